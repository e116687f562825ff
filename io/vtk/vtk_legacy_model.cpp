// SPDX-License-Identifier: Apache-2.0
#include <espalier/io/files/file.h>
#include <espalier/io/vtk/vtk_legacy.h>

#include <algorithm>
#include <cstdint>
#include <optional>
#include <ostream>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "../lattices/lattice_parts.h"
#include "../meshes/mesh_cells.h"
#include "../models/file_model.h"
#include "../models/point_data.h"
#include "vtk_cells.h"
#include "vtk_legacy_parts.h"
#include "vtk_surface_writers.h"

// A surface (POLYDATA), an unstructured or a structured grid as a model. Its points, of type float
// or double, and the directions at them are replaced on writing; everything else is kept byte for
// byte. The faces are the cells of POLYGONS and TRIANGLE_STRIPS, or the cells of the types 5 to 9.
// A structured grid has hexahedra as cells or, if it is one layer, quadrilaterals as faces.
//
// Directions are arrays of POINT_DATA with 3 components of float or double. An array holds normals
// if it has the keyword NORMALS or the name "Normals", and tangents if it has the name "Tangents",
// in a FIELD too. A changed number of a text is the shortest that reads back as the same number.

namespace espalier::io {
namespace {

/// Returns the precision of a type of real numbers; nothing for other types.
std::optional<Precision> realPrecisionOf(const std::string& type) {
    if (type == "float") return Precision::Float;
    if (type == "double") return Precision::Double;
    return std::nullopt;
}

/// Returns the function that carries an array; null if the array does not hold directions.
Carry legacyCarry(const LegacyArray& array) {
    if (array.owner != LegacyArray::Owner::Points || array.components != 3 ||
        !realPrecisionOf(array.type) || array.kind == LegacyArray::Kind::Colors)
        return nullptr;
    if (array.kind == LegacyArray::Kind::Normals || array.name == "Normals") return carryNormal;
    return array.name == "Tangents" ? carryTangent : nullptr;
}

/// Finds the points of a file, and the directions at them.
class LegacyVectorReader final : public LegacyParts {
public:
    LegacyVectorReader(const std::filesystem::path& path, std::string_view bytes)
        : LegacyParts(path, bytes), path_(path), bytes_(bytes) {}

    FileNumbers read() {
        readParts();
        if (!havePoints_) text().fail("the file ends; expected POINTS");
        if (isBinary()) numbers_.order = std::endian::big;
        numbers_.storage = storageOf(numbers_.points.precisions[0]);
        return std::move(numbers_);
    }

private:
    bool isBinary() const { return data().isBinary(); }
    std::size_t pointCount() const { return numbers_.points.values.size(); }

    void beginDataSet(const std::string&) override {}
    void readRows(const std::string&) override { data().skipRows(); }
    void readCellTypes(std::size_t count) override {
        data().skipValues("int", count, "a cell type");
    }

    void readPoints(std::size_t count, const std::string& type) override {
        if (havePoints_) text().fail("a second section POINTS");
        const auto precision = realPrecisionOf(type);
        if (!precision)
            text().fail("the points are of type " + inQuotes(type) +
                        ", which cannot hold a deformed position; expected float or double");
        havePoints_ = true;
        readVectors(count, *precision, nullptr, numbers_.points);
    }

    void beginData(LegacyArray::Owner owner, std::size_t tuples) override {
        if (owner != LegacyArray::Owner::Points) return;
        if (!havePoints_) text().fail("POINT_DATA stands before POINTS");
        if (tuples != pointCount())
            text().fail(
                concat("the data are for ", tuples, " points, but there are ", pointCount()));
    }

    void readArray(const LegacyArray& array) override {
        const Carry carry = legacyCarry(array);
        if (!carry) return data().skipValues(array.type, array.size(), "a number");
        if (array.tuples != pointCount())
            text().fail(concat("the array ", inQuotes(array.name), " has ", array.tuples,
                               " tuples for ", pointCount(), " points"));
        readVectors(array.tuples, *realPrecisionOf(array.type), carry,
                    numbers_.directions.emplace_back());
    }

    void readVectors(std::size_t count, Precision precision, Carry carry, FileVectors& vectors) {
        const char* const what = carry ? "a component of a direction" : "a coordinate";
        const std::size_t width = precision == Precision::Float ? sizeof(float) : sizeof(double);
        std::size_t next = 0;  // offset of the next binary number
        if (isBinary()) {
            data().beginBinary();
            next = text().position();
            text().bytes(saturatingProduct(saturatingProduct(3, width), count), what);
        } else {
            data().checkRoom(saturatingProduct(3, count), what);
        }
        vectors.precisions.fill(precision);
        vectors.carry = carry;
        vectors.resize(count);
        for (std::size_t point = 0; point < count; ++point)
            for (std::size_t axis = 0; axis < 3; ++axis) {
                std::size_t& offset = vectors.offsets[point][axis];
                double& value = vectors.values[point][axis];
                if (isBinary()) {
                    offset = std::exchange(next, next + width);
                    value = loadReal(bytes_, offset, precision, std::endian::big);
                } else {
                    const std::string_view word = text().token(what);
                    offset = word.data() - bytes_.data();
                    value = carry ? direction(word, precision)
                                  : parseCoordinate(word, axis, precision, path_, text().line());
                }
            }
    }

    double direction(std::string_view word, Precision precision) const {
        double number = 0;
        if (!parseNumber(word, number))
            text().fail(inQuotes(word) + " is not a number; expected a component of a direction");
        return parseReal(word, precision);
    }

    const std::filesystem::path& path_;
    std::string_view bytes_;
    bool havePoints_ = false;
    FileNumbers numbers_;
};

/// Reads the faces of a file, and names its arrays.
class LegacySurfaceReader final : public LegacyParts {
public:
    LegacySurfaceReader(const std::filesystem::path& path, std::string_view bytes)
        : LegacyParts(path, bytes), path_(path), faces_(path) {}

    /// Returns the surface without its normals.
    ModelSurface read() {
        readParts();
        if (cells_.types.size() != cells_.rows.count())
            throw FileError(path_, concat("has ", cells_.rows.count(), " cells and ",
                                          cells_.types.size(), " cell types"));
        for (std::size_t cell = 0; cell < cells_.rows.count(); ++cell)
            faces_.add(cells_.types[cell], cells_.rows[cell]);
        faces_.giveTo(surface_);
        return std::move(surface_);
    }

private:
    void beginDataSet(const std::string&) override {}
    void beginData(LegacyArray::Owner, std::size_t) override {}
    void beginGrid(const Extent& extent) override { cells_ = cellsOfGrid(extent); }

    void readPoints(std::size_t count, const std::string& type) override {
        data().skipValues(type, saturatingProduct(3, count), "a coordinate");
        faces_.beginPiece(0, count);
    }

    void readRows(const std::string& keyword) override {
        LegacyRows rows = data().rows(keyword);
        if (keyword == "cells") {
            cells_.rows = std::move(rows);
            return;
        }
        // A section of POLYDATA. Its cells all have one type.
        const std::int64_t type = keyword == "vertices"   ? kVtkVertices
                                  : keyword == "lines"    ? kVtkLine
                                  : keyword == "polygons" ? kVtkPolygon
                                                          : kVtkStrip;
        for (std::size_t row = 0; row < rows.count(); ++row) faces_.add(type, rows[row]);
    }

    void readCellTypes(std::size_t count) override {
        cells_.types = data().numbers<std::int64_t>("int", count, "a cell type");
    }

    void readArray(const LegacyArray& array) override {
        data().skipValues(array.type, array.size(), "a number");
        const bool areNormals = legacyCarry(array) == carryNormal;
        if (!areNormals || std::exchange(haveNormals_, true)) skippedArray(array);
    }

    void skippedArray(const LegacyArray& array) override {
        surface_.addOther(array.owner == LegacyArray::Owner::DataSet ? "field data"
                          : array.owner == LegacyArray::Owner::Points
                              ? ModelSurface::OtherData::kPointData
                              : "cell data",
                          array.name);
    }

    const std::filesystem::path& path_;
    ModelSurface surface_;
    bool haveNormals_ = false;  ///< the file has had normals
    VtkFaceReader faces_;
    LegacyCells cells_;
};

/// Reads the cells of an unstructured grid.
class LegacyVolumeReader final : public LegacyParts {
public:
    LegacyVolumeReader(const std::filesystem::path& path, std::string_view bytes)
        : LegacyParts(path, bytes) {}

    void read(const std::filesystem::path& path, VtkCellReader& cells) {
        readParts();
        addLegacyCells(path, cells_, cells);
    }

private:
    void beginDataSet(const std::string&) override {}
    void beginData(LegacyArray::Owner, std::size_t) override {}
    void beginGrid(const Extent& extent) override { cells_ = cellsOfGrid(extent); }

    void readPoints(std::size_t count, const std::string& type) override {
        data().skipValues(type, saturatingProduct(3, count), "a coordinate");
    }

    void readRows(const std::string& keyword) override {
        if (keyword == "cells")
            cells_.rows = data().rows("CELLS");
        else
            data().skipRows();
    }

    void readCellTypes(std::size_t count) override {
        cells_.types = data().numbers<std::int64_t>("int", count, "a cell type");
    }

    void readArray(const LegacyArray& array) override {
        data().skipValues(array.type, array.size(), "a number");
    }

    LegacyCells cells_;
};

/// Finds the arrays of the point data, and reads one of them.
class LegacyArrayReader final : public LegacyParts {
public:
    LegacyArrayReader(const std::filesystem::path& path, std::string_view bytes)
        : LegacyParts(path, bytes) {}

    /// Returns the arrays of numbers.
    std::vector<LegacyArray> read() {
        readParts();
        return std::move(arrays_);
    }

    /// Returns the numbers of an array.
    std::vector<double> read(std::size_t number) {
        wanted_ = number;
        readParts();
        return std::move(values_);
    }

private:
    void beginDataSet(const std::string&) override {}
    void beginData(LegacyArray::Owner, std::size_t) override {}
    void readRows(const std::string&) override { data().skipRows(); }
    void readPoints(std::size_t count, const std::string& type) override {
        data().skipValues(type, saturatingProduct(3, count), "a coordinate");
        pointCount_ = count;
    }
    void readCellTypes(std::size_t count) override {
        data().skipValues("int", count, "a cell type");
    }

    void readArray(const LegacyArray& array) override {
        constexpr const char* kNumber = "a number";
        const bool isOfPoints = array.owner == LegacyArray::Owner::Points &&
                                array.tuples == pointCount_ && array.components > 0 &&
                                numberOfLegacyName(array.type).has_value();
        if (isOfPoints) arrays_.push_back(array);
        if (isOfPoints && wanted_ == arrays_.size() - 1)
            values_ = data().numbers<double>(array.type, array.size(), kNumber);
        else
            data().skipValues(array.type, array.size(), kNumber);
    }

    std::size_t pointCount_ = 0;
    std::vector<LegacyArray> arrays_;
    std::optional<std::size_t> wanted_;
    std::vector<double> values_;
};

FileNumbers readLegacyNumbers(const std::filesystem::path& path, std::string_view bytes) {
    return LegacyVectorReader(path, bytes).read();
}

ModelSurface readLegacySurface(const FileView& file) {
    ModelSurface surface = LegacySurfaceReader(file.path, file.bytes).read();
    surface.normals = normalsOf(file.numbers);
    return surface;
}

ModelCells readLegacyCells(const FileView& file) {
    MeshCells volume;
    VtkCellReader cells(file.path, file.pointCount(), volume, true);
    LegacyVolumeReader(file.path, file.bytes).read(file.path, cells);
    return withPathInErrors(file.path, [&] { return volume.finish(file.numbers.points.values); });
}

PointAttribute::Kind kindOf(const LegacyArray& array) {
    switch (array.kind) {
        case LegacyArray::Kind::TextureCoordinates:
            return PointAttribute::Kind::TextureCoordinate;
        case LegacyArray::Kind::Colors:
            return PointAttribute::Kind::Color;
        default:
            return PointAttribute::Kind::Numbers;
    }
}

std::vector<PointAttribute> legacyAttributes(const FileView& file) {
    std::vector<PointAttribute> attributes;
    const auto arrays = LegacyArrayReader(file.path, file.bytes).read();
    for (std::size_t number = 0; number < arrays.size(); ++number)
        addVtkAttributes(
            arrays[number].name, arrays[number].components, arrays[number].type == "unsigned_char",
            kindOf(arrays[number]), attributes,
            [file, number] { return LegacyArrayReader(file.path, file.bytes).read(number); });
    return attributes;
}

constexpr FileModelFormat kLegacyModel = {.readNumbers = readLegacyNumbers,
                                          .readSurface = readLegacySurface,
                                          .readCells = readLegacyCells,
                                          .attributes = legacyAttributes};

}  // namespace

const Format kVtkLegacyFormat = {
    .extensions = {".vtk"},
    .readModel = readFileModel<kLegacyModel>,
    .writeSurface = writeVtkLegacySurface,
    .readLattice = readVtkLegacy,
    .writeLattice = [](const std::filesystem::path& path, const Lattice& lattice,
                       const WriteLatticeOptions&) { writeVtkLegacy(path, lattice); }};

}  // namespace espalier::io
