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
#include "../meshes/volume_cells.h"
#include "../models/coordinates.h"
#include "vtk_cells.h"
#include "vtk_legacy_parts.h"

namespace espalier::io {
namespace {

/// Vectors of a legacy file, one per point, and the offsets of their numbers.
struct LegacyVectors {
    Precision precision = Precision::Double;
    Carry carry = nullptr;  ///< null for the points themselves
    std::vector<Point3> values;
    std::vector<CoordinatePlaces> places;
};

/// Returns the precision of a type of real numbers; nothing for other types.
std::optional<Precision> realPrecisionOf(const std::string& type) {
    if (type == "float") return Precision::Float;
    if (type == "double") return Precision::Double;
    return std::nullopt;
}

/// Returns the function that carries an array; null if the array does not hold directions.
Carry legacyCarry(const LegacyArray& array) {
    if (array.owner != LegacyArray::Owner::Points || array.components != 3 ||
        !realPrecisionOf(array.type))
        return nullptr;
    if (array.isNormals || array.name == "Normals") return carryNormal;
    return array.name == "Tangents" ? carryTangent : nullptr;
}

/// Finds the points of a file, and the directions at them.
class LegacyVectorReader final : public LegacyParts {
public:
    LegacyVectorReader(const std::filesystem::path& path, std::string_view bytes)
        : LegacyParts(path, bytes), path_(path), bytes_(bytes) {}

    /// Returns the points and then the directions, in the order of the file.
    std::vector<LegacyVectors> read() {
        readParts();
        if (vectors_.empty()) text().fail("the file ends; expected POINTS");
        return std::move(vectors_);
    }

    bool isBinary() const { return data().isBinary(); }

private:
    void beginDataSet(const std::string&) override {}
    void readRows(const std::string&) override { data().skipRows(); }
    void readCellTypes(std::size_t count) override {
        data().skipValues("int", count, "a cell type");
    }

    void readPoints(std::size_t count, const std::string& type) override {
        if (!vectors_.empty()) text().fail("a second section POINTS");
        const auto precision = realPrecisionOf(type);
        if (!precision)
            text().fail("the points are of type " + inQuotes(type) +
                        ", which cannot hold a deformed position; expected float or double");
        readVectors(count, *precision, nullptr);
    }

    void beginData(LegacyArray::Owner owner, std::size_t tuples) override {
        if (owner != LegacyArray::Owner::Points) return;
        if (vectors_.empty()) text().fail("POINT_DATA stands before POINTS");
        const std::size_t points = vectors_[0].values.size();
        if (tuples != points)
            text().fail(concat("the data are for ", tuples, " points, but there are ", points));
    }

    void readArray(const LegacyArray& array) override {
        const Carry carry = legacyCarry(array);
        if (!carry) return data().skipValues(array.type, array.size(), "a number");
        if (array.tuples != vectors_[0].values.size())
            text().fail(concat("the array ", inQuotes(array.name), " has ", array.tuples,
                               " tuples for ", vectors_[0].values.size(), " points"));
        readVectors(array.tuples, *realPrecisionOf(array.type), carry);
    }

    void readVectors(std::size_t count, Precision precision, Carry carry) {
        const char* const what = carry ? "a component of a direction" : "a coordinate";
        const std::size_t width = precision == Precision::Float ? sizeof(float) : sizeof(double);
        std::size_t next = 0;  // place of the next binary number
        if (isBinary()) {
            data().beginBinary();
            next = text().position();
            text().bytes(saturatingProduct(saturatingProduct(3, width), count), what);
        } else {
            data().checkRoom(saturatingProduct(3, count), what);
        }
        LegacyVectors& vectors = vectors_.emplace_back(LegacyVectors{precision, carry, {}, {}});
        vectors.values.resize(count);
        vectors.places.resize(count);
        for (std::size_t point = 0; point < count; ++point)
            for (std::size_t axis = 0; axis < 3; ++axis) {
                std::size_t& place = vectors.places[point][axis];
                double& value = vectors.values[point][axis];
                if (isBinary()) {
                    place = std::exchange(next, next + width);
                    value = carry ? loadReal(bytes_, place, precision, std::endian::big)
                                  : loadCoordinate(bytes_, place, precision, std::endian::big, axis,
                                                   point, path_);
                } else {
                    const std::string_view word = text().token(what);
                    place = word.data() - bytes_.data();
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
    std::vector<LegacyVectors> vectors_;
};

/// Reads the faces of a file, and names its arrays.
class LegacySurfaceReader final : public LegacyParts {
public:
    LegacySurfaceReader(const std::filesystem::path& path, std::string_view bytes)
        : LegacyParts(path, bytes), path_(path), faces_(path) {}

    /// Returns the surface without its normals.
    ModelSurface read() {
        readParts();
        if (types_.size() != cells_.count())
            throw FileError(
                path_, concat("has ", cells_.count(), " cells and ", types_.size(), " cell types"));
        for (std::size_t cell = 0; cell < cells_.count(); ++cell)
            faces_.add(types_[cell], cells_[cell]);
        faces_.giveTo(surface_);
        return std::move(surface_);
    }

private:
    void beginDataSet(const std::string&) override {}
    void beginData(LegacyArray::Owner, std::size_t) override {}

    void readPoints(std::size_t count, const std::string& type) override {
        data().skipValues(type, saturatingProduct(3, count), "a coordinate");
        faces_.beginPiece(0, count);
    }

    void readRows(const std::string& keyword) override {
        LegacyRows rows = data().rows(keyword);
        if (keyword == "cells") {
            cells_ = std::move(rows);
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
        types_ = data().numbers<std::int64_t>("int", count, "a cell type");
    }

    void readArray(const LegacyArray& array) override {
        data().skipValues(array.type, array.size(), "a number");
        const bool areNormals = legacyCarry(array) == carryNormal;
        if (!areNormals || std::exchange(haveNormals_, true)) skippedArray(array);
    }

    void skippedArray(const LegacyArray& array) override {
        surface_.addOther(array.owner == LegacyArray::Owner::DataSet  ? "field data"
                          : array.owner == LegacyArray::Owner::Points ? "point data"
                                                                      : "cell data",
                          array.name);
    }

    const std::filesystem::path& path_;
    ModelSurface surface_;
    bool haveNormals_ = false;  ///< the file has had normals
    VtkFaceReader faces_;
    LegacyRows cells_;
    std::vector<std::int64_t> types_;
};

/// Reads the cells of an unstructured grid.
class LegacyVolumeReader final : public LegacyParts {
public:
    LegacyVolumeReader(const std::filesystem::path& path, std::string_view bytes)
        : LegacyParts(path, bytes) {}

    void read(const std::filesystem::path& path, VtkCellReader& cells) {
        readParts();
        addLegacyCells(path, rows_, types_, cells);
    }

private:
    void beginDataSet(const std::string&) override {}
    void beginData(LegacyArray::Owner, std::size_t) override {}

    void readPoints(std::size_t count, const std::string& type) override {
        data().skipValues(type, saturatingProduct(3, count), "a coordinate");
    }

    void readRows(const std::string& keyword) override {
        if (keyword == "cells")
            rows_ = data().rows("CELLS");
        else
            data().skipRows();
    }

    void readCellTypes(std::size_t count) override {
        types_ = data().numbers<std::int64_t>("int", count, "a cell type");
    }

    void readArray(const LegacyArray& array) override {
        data().skipValues(array.type, array.size(), "a number");
    }

    LegacyRows rows_;
    std::vector<std::int64_t> types_;
};

class VtkLegacyModel final : public Model {
public:
    VtkLegacyModel(const std::filesystem::path& path, std::string bytes)
        : path_(path), bytes_(std::move(bytes)) {
        LegacyVectorReader reader(path_, bytes_);
        vectors_ = reader.read();
        isBinary_ = reader.isBinary();
    }

    std::span<const Point3> positions() const override { return points().values; }
    std::string_view extension() const override { return ".vtk"; }
    bool hasDirections() const override { return vectors_.size() > 1; }
    CoordinateStorage storage() const override { return storageOf(points().precision); }
    ModelSurface readSurface() const override {
        ModelSurface surface = LegacySurfaceReader(path_, bytes_).read();
        const auto normals = std::ranges::find(vectors_, Carry{carryNormal}, &LegacyVectors::carry);
        if (normals != vectors_.end()) surface.normals = normals->values;
        return surface;
    }

    ModelVolume readVolume() const override {
        VolumeCells volume;
        VtkCellReader cells(path_, checkedIndex(path_, positions().size(), "points"), volume, true);
        LegacyVolumeReader(path_, bytes_).read(path_, cells);
        return withPathInErrors(path_, [&] { return volume.finish(positions()); });
    }

private:
    const LegacyVectors& points() const { return vectors_.front(); }

    void writeChecked(const std::filesystem::path& path, std::span<const Point3> moved,
                      std::span<const DeformationGradient> gradients) const override {
        std::vector<std::vector<Point3>> turned;
        for (std::size_t i = 1; i < vectors_.size() && !gradients.empty(); ++i) {
            const LegacyVectors& vectors = vectors_[i];
            turned.push_back(carried(vectors.values, gradients, vectors.carry, vectors.precision));
        }
        std::vector<VectorChange> changes;
        for (std::size_t i = 0; i <= turned.size(); ++i) {
            const LegacyVectors& vectors = vectors_[i];
            const std::span<const Point3> now = i == 0 ? moved : turned[i - 1];
            changes.push_back({vectors.places,
                               vectors.values,
                               now,
                               {vectors.precision, vectors.precision, vectors.precision}});
        }
        writeFile(path, [&](std::ostream& out) {
            if (isBinary_)
                writeChangedBinary(out, bytes_, changes, std::endian::big);
            else
                writeChanged(out, bytes_, changes, VectorOrder::OneAfterTheOther);
        });
    }

    std::filesystem::path path_;  ///< path of the file that was read
    std::string bytes_;
    bool isBinary_ = false;
    std::vector<LegacyVectors> vectors_;  ///< the points, and then the directions
};

}  // namespace

std::unique_ptr<Model> readVtkLegacyModel(const std::filesystem::path& path, std::string bytes) {
    return std::make_unique<VtkLegacyModel>(path, std::move(bytes));
}

}  // namespace espalier::io
