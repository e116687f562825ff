// SPDX-License-Identifier: Apache-2.0
#include <espalier/io/files/file.h>
#include <espalier/io/vtk/vtu.h>

#include <algorithm>
#include <optional>
#include <ostream>
#include <string>
#include <utility>
#include <vector>

#include "../files/bytes.h"
#include "../format.h"
#include "../lattices/lattice_parts.h"
#include "../meshes/mesh_cells.h"
#include "../models/coordinates.h"
#include "../models/held_points.h"
#include "../models/point_data.h"
#include "vtk_cells.h"
#include "vtk_surface_writers.h"
#include "vtk_xml.h"
#include "vtu_cells.h"

// An unstructured grid (.vtu) as a model. Only its points and their directions are read, and only
// they are replaced on writing. Everything else in the file, whatever cells and arrays it has, is
// kept byte for byte, raw appended data included.
//
// Directions are arrays of PointData with 3 components of Float32 or Float64. An array holds
// normals if its name is "Normals" or if it is the active Normals of the piece; tangents likewise
// by "Tangents". All other arrays are kept.
//
// The faces are the cells of the types 5 to 9: triangles, strips, polygons, pixels and
// quadrilaterals. Cells of a volume have no faces here.
//
// A changed array of Points is written inline, with the same number type (Float64 if it held
// integers): ascii if it was ascii, else base64, compressed if the file is. In a piece where no
// point has moved, the array stays as it was. The same holds for arrays of directions.
//
// The same for VTK's XML files of surfaces (.vtp, PolyData), which OpenFOAM writes. The faces are
// the cells of Polys, and the triangles of Strips.

namespace espalier::io {
namespace {

/// Returns the indentation of an element: the white space before it on its line, or nothing if the
/// line has other text before it.
std::string_view indentOf(std::string_view bytes, std::size_t begin) {
    // Not the begin of the line: a line can be the whole file, with any number of elements.
    const std::size_t before = bytes.substr(0, begin).find_last_not_of(" \t");
    const std::size_t first = before == std::string_view::npos ? 0 : before + 1;
    return first == 0 || bytes[before] == '\n' ? bytes.substr(first, begin - first) : "";
}

Precision precisionOf(NumberType type) {
    return type == NumberType::Float32 ? Precision::Float : Precision::Double;
}

/// Rounds positions or directions to the precision of an array of this type.
std::vector<Point3> rounded(std::vector<Point3> values, NumberType type, std::size_t firstPoint) {
    if (precisionOf(type) == Precision::Float)
        for (std::size_t i = 0; i < values.size(); ++i)
            for (double& number : values[i])
                number = roundTo(Precision::Float, number, firstPoint + i);
    return values;
}

std::string elementOf(const VtkXmlFile& file, const VtkDataArray& array, NumberType type,
                      std::span<const Point3> points) {
    const auto form =
        array.format == VtkDataArray::Format::Ascii ? VtkArrayForm::Ascii : VtkArrayForm::Base64;
    return dataArrayElement<double>({array.name, type, 3}, coordinatesOf(points), form,
                                    file.coding(), indentOf(file.bytes(), array.begin));
}

/// Returns true for an array of this name, and for the active array of this kind.
/// \param kind attribute of PointData: "Normals"
bool holds(const VtkSection& pointData, const VtkDataArray& array, const std::string& kind) {
    const auto active = pointData.active.find(kind);
    return array.name == kind || (active != pointData.active.end() && array.name == active->second);
}

/// Returns the function that carries an array of PointData; null if the array does not hold
/// directions.
Carry carryOf(const VtkSection& pointData, const VtkDataArray& array) {
    if (array.components != 3 || !array.type || isInteger(*array.type)) return nullptr;
    return holds(pointData, array, "Normals")    ? carryNormal
           : holds(pointData, array, "Tangents") ? carryTangent
                                                 : nullptr;
}

std::vector<Point3> copyOf(std::span<const Point3> points) {
    return {points.begin(), points.end()};
}

bool areSame(std::span<const Point3> a, std::span<const Point3> b) {
    const auto isSamePoint = [](const Point3& p, const Point3& q) {
        return std::equal(p.begin(), p.end(), q.begin(), isSame);
    };
    return std::equal(a.begin(), a.end(), b.begin(), isSamePoint);
}

/// A .vtu (UnstructuredGrid) or a .vtp (PolyData): their points are stored alike.
class VtkXmlModel final : public Model {
public:
    VtkXmlModel(const Format& format, const std::filesystem::path& path, std::string bytes)
        : Model(format, path),
          file_(VtkXmlFile::read(path, std::move(bytes),
                                 isGrid() ? "UnstructuredGrid" : "PolyData")) {
        for (const VtkPiece& piece : file_.pieces()) {
            const std::size_t first = positions_.size();
            const std::vector<Point3> points = readPoints(file_, piece);
            if (points.empty()) continue;
            positions_.insert(positions_.end(), points.begin(), points.end());
            arrays_.push_back({pointArray(file_, piece), first, points.size(), nullptr, {}});
            addDirections(piece, first, points.size());
        }
        held_.emplace(positions_);
        if (const auto used = held_->findUsed(*this)) {
            held_->restore(positions_);
            checkFinite(path, std::span(positions_).subspan(0, *used + 1));
        }
        std::sort(arrays_.begin(), arrays_.end(), [](const PointArray& a, const PointArray& b) {
            return a.array.begin < b.array.begin;
        });
    }

    std::span<const Point3> positions() const override { return positions_; }
    std::vector<Index> heldPoints() const override { return held_->numbers(); }
    std::vector<std::string> notes() const override {
        if (held_->empty()) return {};
        return {held_->note()};
    }
    DirectionCounts directions() const override {
        DirectionCounts counts;
        for (const PointArray& each : arrays_)
            if (each.carry != nullptr)
                (each.carry == carryNormal ? counts.normals : counts.tangents) +=
                    each.directions.size();
        return counts;
    }

    ModelSurface readSurface() const override {
        ModelSurface surface;
        VtkFaceReader faces(file_.path());
        std::size_t firstPoint = 0;
        for (const VtkPiece& piece : file_.pieces()) {
            const std::size_t pointCount = file_.count(piece, "NumberOfPoints");
            faces.beginPiece(firstPoint, pointCount);
            if (isGrid())
                addCells(piece, faces);
            else
                for (const auto& [section, type] :
                     {std::pair{"Verts", kVtkVertices}, std::pair{"Lines", kVtkLine},
                      std::pair{"Polys", kVtkPolygon}, std::pair{"Strips", kVtkStrip}})
                    addRows(piece, section, type, faces);
            firstPoint += pointCount;
        }
        faces.giveTo(surface);
        surface.normals = normals();
        nameOtherArrays(surface);
        return surface;
    }

    ModelCells readCells() const override {
        MeshCells cells;
        if (!isGrid()) return {};
        VtkCellReader reader(file_.path(), checkedIndex(file_.path(), positions_.size(), "points"),
                             cells, true);
        readVtuCells(file_, reader);
        return withPathInErrors(file_.path(), [&] { return cells.finish(positions_); });
    }

    std::vector<PointAttribute> attributes() const override {
        std::vector<PointAttribute> attributes;
        if (arrays_.empty()) return attributes;
        for (const VtkPiece& piece : file_.pieces()) {
            if (file_.count(piece, "NumberOfPoints") == 0) continue;
            const auto section = piece.sections.find("PointData");
            if (section == piece.sections.end()) break;
            // The first piece with points has the arrays that all pieces have.
            for (const VtkDataArray& array : section->second.arrays)
                if (array.type)
                    addVtkAttributes(array.name, array.components, array.type == NumberType::UInt8,
                                     holds(section->second, array, "TCoords")
                                         ? PointAttribute::Kind::TextureCoordinate
                                         : PointAttribute::Kind::Numbers,
                                     attributes,
                                     [this, first = &array] { return pointData(*first); });
            break;
        }
        return attributes;
    }

    CoordinateStorage storage() const override {
        CoordinateStorage storage = CoordinateStorage::Double;
        for (const PointArray& each : arrays_) {
            if (each.carry) continue;
            if (isInteger(*each.array.type)) return CoordinateStorage::Integer;
            if (precisionOf(*each.array.type) == Precision::Float)
                storage = CoordinateStorage::Float;
        }
        return storage;
    }

    std::vector<Point3> stored(std::vector<Point3> points) const override {
        for (const PointArray& each : arrays_) {
            if (each.carry || precisionOf(*each.array.type) != Precision::Float) continue;
            for (std::size_t i = 0; i < each.pointCount; ++i)
                for (double& coordinate : points[each.firstPoint + i]) roundToFloat(coordinate);
        }
        return points;
    }

private:
    /// The array of a piece that holds its points, or directions at them.
    struct PointArray {
        VtkDataArray array;
        std::size_t firstPoint = 0;
        std::size_t pointCount = 0;
        Carry carry = nullptr;  ///< null for the points themselves
        std::vector<Point3> directions;
    };

    bool isGrid() const { return &format() == &kVtuFormat; }

    /// Returns the first normals of each piece, if each piece with points has some.
    std::vector<Point3> normals() const {
        std::vector<Point3> normals(positions_.size());
        std::vector<bool> haveNormals(positions_.size());
        for (const PointArray& each : arrays_) {
            if (each.carry != carryNormal || haveNormals[each.firstPoint]) continue;
            std::ranges::copy(each.directions, normals.begin() + std::ptrdiff_t(each.firstPoint));
            std::fill_n(haveNormals.begin() + std::ptrdiff_t(each.firstPoint), each.pointCount,
                        true);
        }
        if (std::ranges::count(haveNormals, false) > 0) normals.clear();
        return normals;
    }

    /// Reads an array of the point data of all pieces.
    /// \param first the array of the first piece
    std::vector<double> pointData(const VtkDataArray& first) const {
        std::vector<double> values;
        for (const VtkPiece& piece : file_.pieces()) {
            const std::size_t count = file_.count(piece, "NumberOfPoints");
            if (count == 0) continue;
            const VtkDataArray& array = file_.array(file_.section(piece, "PointData"), first.name);
            if (array.components != first.components)
                file_.fail(array.line,
                           concat("the array ", inQuotes(array.name), " has ", array.components,
                                  " components, and ", first.components, " in another piece"));
            const auto ofPiece = file_.reals(array, count);
            values.insert(values.end(), ofPiece.begin(), ofPiece.end());
        }
        return values;
    }

    /// Names all arrays but the points and the first normals.
    void nameOtherArrays(ModelSurface& surface) const {
        for (const VtkDataArray& array : file_.fieldData().arrays)
            surface.addOther("field data", array.name);
        for (const VtkPiece& piece : file_.pieces())
            for (const auto& [name, kind] :
                 {std::pair{"PointData", ModelSurface::OtherData::kPointData},
                  std::pair{"CellData", "cell data"}}) {
                const auto section = piece.sections.find(name);
                if (section == piece.sections.end()) continue;
                bool isFirst = !surface.normals.empty();
                for (const VtkDataArray& array : section->second.arrays) {
                    const bool isNormals = std::string_view(name) == "PointData" &&
                                           carryOf(section->second, array) == carryNormal;
                    if (!isNormals || !isFirst) surface.addOther(kind, array.name);
                    isFirst = isFirst && !isNormals;
                }
            }
    }

    void addCells(const VtkPiece& piece, VtkFaceReader& faces) const {
        const std::size_t count = file_.count(piece, "NumberOfCells");
        if (count == 0) return;
        const VtkSection& section = file_.section(piece, "Cells");
        const auto types = file_.list(file_.array(section, "types"), count, kOneACell);
        const VtkRows cells(file_, section, "connectivity", "offsets", count, kOneACell);
        for (std::size_t cell = 0; cell < count; ++cell) faces.add(types[cell], cells[cell]);
    }

    /// Adds the cells of a section of PolyData, which all have one type.
    void addRows(const VtkPiece& piece, const std::string& section, std::int64_t type,
                 VtkFaceReader& faces) const {
        const auto counted = piece.counts.find("NumberOf" + section);
        if (counted == piece.counts.end() || counted->second == 0) return;
        const VtkRows cells(file_, file_.section(piece, section), "connectivity", "offsets",
                            counted->second, kOneACell);
        for (std::size_t cell = 0; cell < counted->second; ++cell) faces.add(type, cells[cell]);
    }

    void addDirections(const VtkPiece& piece, std::size_t firstPoint, std::size_t pointCount) {
        const auto pointData = piece.sections.find("PointData");
        if (pointData == piece.sections.end()) return;
        for (const VtkDataArray& array : pointData->second.arrays)
            if (const Carry carry = carryOf(pointData->second, array))
                arrays_.push_back({array, firstPoint, pointCount, carry,
                                   pointsOf(file_.reals(array, pointCount))});
    }

    void writeChecked(const std::filesystem::path& path, std::span<const Point3> positions,
                      std::span<const DeformationGradient> gradients) const override {
        if (held_->empty()) return writeArrays(path, positions_, positions, gradients);
        std::vector<Point3> before = positions_, now = copyOf(positions);
        held_->restore(before);
        held_->restore(now);
        writeArrays(path, before, now, held_->held(gradients));
    }

    /// \param before the positions in the file
    void writeArrays(const std::filesystem::path& path, std::span<const Point3> before,
                     std::span<const Point3> positions,
                     std::span<const DeformationGradient> gradients) const {
        const std::string_view bytes = file_.bytes();
        writeFile(path, [&](std::ostream& out) {
            std::size_t done = 0;
            for (const PointArray& each : arrays_) {
                if (each.carry && gradients.empty()) continue;
                const VtkDataArray& array = each.array;
                const NumberType type = isInteger(*array.type) ? NumberType::Float64 : *array.type;
                const auto ofPiece = [&](auto values) {
                    return values.subspan(each.firstPoint, each.pointCount);
                };
                const std::vector<Point3> now =
                    rounded(each.carry ? carried(each.directions, ofPiece(gradients), each.carry,
                                                 precisionOf(type))
                                       : copyOf(ofPiece(positions)),
                            type, each.firstPoint);
                const std::span<const Point3> old = each.carry ? each.directions : ofPiece(before);
                if (areSame(now, old)) continue;
                out << bytes.substr(done, array.begin - done);
                try {
                    out << elementOf(file_, array, type, now);
                } catch (const CodingError& error) {
                    throw FileError(path, error.what());
                }
                done = array.end;
            }
            out << bytes.substr(done);
        });
    }

    VtkXmlFile file_;
    std::vector<PointArray> arrays_;  ///< the arrays in the order of the file
    std::vector<Point3> positions_;
    std::optional<HeldPoints> held_;  ///< set when the positions are read
};

std::unique_ptr<Model> readVtkXmlModel(const Format& format, const std::filesystem::path& path,
                                       std::string bytes) {
    return std::make_unique<VtkXmlModel>(format, path, std::move(bytes));
}

}  // namespace

const Format kVtuFormat = {
    .extensions = {".vtu"},
    .readModel = readVtkXmlModel,
    .writeSurface = writeVtuSurface,
    .readLattice = readVtu,
    .writeLattice = [](const std::filesystem::path& path, const Lattice& lattice,
                       const WriteLatticeOptions& options) {
        writeVtu(path, lattice, options.vtuEncoding);
    }};

const Format kVtpFormat = {
    .extensions = {".vtp"}, .readModel = readVtkXmlModel, .writeSurface = writeVtpSurface};

}  // namespace espalier::io
