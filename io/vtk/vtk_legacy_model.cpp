// SPDX-License-Identifier: Apache-2.0
#include <espalier/io/files/file.h>
#include <espalier/io/vtk/vtk_legacy.h>

#include <array>
#include <ostream>
#include <string>
#include <utility>
#include <vector>

#include "../lattices/lattice_parts.h"
#include "../meshes/volume_cells.h"
#include "../models/coordinates.h"
#include "vtk_cells.h"
#include "vtk_legacy_data.h"

namespace espalier::io {
namespace {

class VtkLegacyModel final : public Model {
public:
    VtkLegacyModel(const std::filesystem::path& path, std::string bytes)
        : path_(path), bytes_(std::move(bytes)) {
        LegacyData data(path_, bytes_);
        findPoints(data);
        readPoints(data);
    }

    std::span<const Point3> positions() const override { return positions_; }
    std::string_view extension() const override { return ".vtk"; }
    bool hasDirections() const override { return false; }
    CoordinateStorage storage() const override { return storageOf(precision_); }

    ModelFaces readFaces() const override {
        VtkFaceReader faces(path_);
        faces.beginPiece(0, positions_.size());
        const auto [cells, types] = readSections(&faces);
        if (types.size() != cells.count())
            throw FileError(
                path_, concat("has ", cells.count(), " cells and ", types.size(), " cell types"));
        for (std::size_t cell = 0; cell < cells.count(); ++cell)
            faces.add(types[cell], cells[cell]);
        return faces.take();
    }

    ModelVolume readVolume() const override {
        const auto [cells, types] = readSections(nullptr);
        VolumeCells volume;
        VtkCellReader reader(path_, checkedIndex(path_, positions_.size(), "points"), volume, true);
        addLegacyCells(path_, cells, types, reader);
        return withPathInErrors(path_, [&] { return volume.finish(positions_); });
    }

private:
    /// Reads the cells of an unstructured grid, with their types. Adds the faces of POLYDATA.
    /// \param faces may be null
    std::pair<LegacyRows, std::vector<std::int64_t>> readSections(VtkFaceReader* faces) const {
        LegacyData data(path_, bytes_);
        const bool isGrid = findPoints(data) == "unstructured_grid";
        skipPoints(data);
        LegacyRows cells;
        std::vector<std::int64_t> types;
        while (!data.text().atEnd()) {
            const std::string keyword = data.keyword("a keyword");
            if (keyword == "point_data" || keyword == "cell_data") break;
            if (keyword == "metadata") {
                data.skipMetadata();
            } else if (keyword == "field") {
                skipField(data);
            } else if (isGrid && keyword == "cells") {
                cells = data.rows("CELLS");
            } else if (isGrid && keyword == "cell_types") {
                types = data.numbers<std::int64_t>(
                    "int", data.text().count("the number of cell types", 1), "a cell type");
            } else if (const auto type = typeOf(keyword); !isGrid && type) {
                const LegacyRows rows = data.rows(keyword);
                for (std::size_t row = 0; faces && row < rows.count(); ++row)
                    faces->add(*type, rows[row]);
            } else {
                data.text().fail(inQuotes(keyword) + " is not a keyword that can stand here");
            }
        }
        return {std::move(cells), std::move(types)};
    }

    /// Returns VTK's type of the cells in a section of POLYDATA; nothing if there is no such
    /// section.
    static std::optional<std::int64_t> typeOf(const std::string& keyword) {
        constexpr std::int64_t kVertices = 2, kLine = 4;
        if (keyword == "vertices") return kVertices;
        if (keyword == "lines") return kLine;
        if (keyword == "polygons") return kVtkPolygon;
        if (keyword == "triangle_strips") return kVtkStrip;
        return std::nullopt;
    }

    static void skipField(LegacyData& data) {
        data.readField([&](const std::string&, const std::string& type, std::size_t components,
                           std::size_t tuples) {
            data.values(type, saturatingProduct(components, tuples), "a number");
        });
    }

    /// Reads up to the keyword POINTS, and returns the kind of data set.
    static std::string findPoints(LegacyData& data) {
        std::string dataSet = data.readHeader();
        while (true) {
            const std::string keyword = data.keyword("POINTS");
            if (keyword == "points") return dataSet;
            if (keyword == "metadata")
                data.skipMetadata();
            else if (keyword == "field")
                skipField(data);
            else
                data.text().fail("expected POINTS, got " + inQuotes(keyword));
        }
    }

    static void skipPoints(LegacyData& data) {
        const std::size_t count = data.text().count("the number of points", 3);
        const std::string type = data.keyword("the type of the points");
        data.numbers<double>(type, saturatingProduct(3, count), "a coordinate");
    }

    void readPoints(LegacyData& data) {
        TextReader& text = data.text();
        const std::size_t count = text.count("the number of points", 3);
        const std::string type = data.keyword("the type of the points");
        if (type != "float" && type != "double")
            text.fail("the points are of type " + inQuotes(type) +
                      ", which cannot hold a deformed position; expected float or double");
        precision_ = type == "float" ? Precision::Float : Precision::Double;
        isBinary_ = data.isBinary();
        const std::size_t width = precision_ == Precision::Float ? sizeof(float) : sizeof(double);
        std::size_t next = 0;  // place of the next binary number
        if (isBinary_) {
            data.beginBinary();
            next = text.position();
            text.bytes(saturatingProduct(saturatingProduct(3, width), count), "a coordinate");
        } else {
            text.checkRoom(saturatingProduct(3, count), 2, "a coordinate");
        }
        positions_.resize(count);
        places_.resize(count);
        for (std::size_t point = 0; point < count; ++point)
            for (std::size_t axis = 0; axis < 3; ++axis) {
                if (isBinary_) {
                    places_[point][axis] = std::exchange(next, next + width);
                    positions_[point][axis] =
                        loadCoordinate(bytes_, places_[point][axis], precision_, std::endian::big,
                                       axis, point, path_);
                    continue;
                }
                const std::string_view word = text.token("a coordinate");
                places_[point][axis] = word.data() - bytes_.data();
                positions_[point][axis] =
                    parseCoordinate(word, axis, precision_, path_, text.line());
            }
    }

    void writeChecked(const std::filesystem::path& path, std::span<const Point3> moved,
                      std::span<const DeformationGradient>) const override {
        const VectorChange change{places_, positions_, moved, {precision_, precision_, precision_}};
        writeFile(path, [&](std::ostream& out) {
            if (isBinary_)
                writeChangedBinary(out, bytes_, {&change, 1}, std::endian::big);
            else
                writeChanged(out, bytes_, {&change, 1});
        });
    }

    std::filesystem::path path_;  ///< path of the file that was read
    std::string bytes_;
    Precision precision_ = Precision::Double;
    bool isBinary_ = false;
    std::vector<Point3> positions_;
    std::vector<CoordinatePlaces> places_;
};

}  // namespace

std::unique_ptr<Model> readVtkLegacyModel(const std::filesystem::path& path, std::string bytes) {
    return std::make_unique<VtkLegacyModel>(path, std::move(bytes));
}

}  // namespace espalier::io
