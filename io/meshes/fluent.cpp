// SPDX-License-Identifier: Apache-2.0
#include <espalier/base/error.h>
#include <espalier/base/sort_unique.h>
#include <espalier/base/vector3.h>
#include <espalier/io/files/file.h>
#include <espalier/io/files/text_reader.h>

#include <algorithm>
#include <array>
#include <map>
#include <optional>
#include <tuple>
#include <utility>

#include "../lattices/lattice_parts.h"
#include "fluent_file.h"
#include "mesh_cells.h"
#include "mesh_format.h"

// Reads the meshes of Fluent (.msh) and the meshes of its cases (.cas), in text and binary, of two
// and three dimensions.
//
// The points are the nodes of the sections 10, in the order of the file. The sections 13 list the
// faces and the cells on both sides of each; cells are numbered in the order of the file, and cells
// without faces are left out. So are faces that the file marks as parents of smaller ones (type
// 31). The groups are the zones: of the boundary with their types, such as "wall", and of cells.
// The two zones of a periodic boundary (section 18) name each other. In a mesh of two dimensions,
// the faces are edges, the cells are polygons, and new positions must have z = 0.
//
// All other sections are kept without being understood. Gmsh's files have the extension .msh, too;
// those of Fluent begin with a parenthesis.

namespace espalier::io {
namespace {

/// A range of numbers in the file, from 1 on, of one zone.
struct FluentZone {
    std::int64_t id;
    std::int64_t first, last;
    std::int64_t type;
};

/// The parts of a file.
struct FluentMesh {
    FileNumbers numbers;
    std::vector<std::pair<FluentZone, Index>> nodes;  ///< zones, and the first point of each
    std::vector<FluentZone> cells;
    std::vector<std::pair<FluentZone, std::size_t>> faces;  ///< zones, and the first face of each
    std::size_t faceEnd(std::size_t zone) const {
        return zone + 1 < faces.size() ? faces[zone + 1].second : sides.size();
    }

    far::Rows<Index> corners;                 ///< the points of each face
    std::vector<std::array<Index, 2>> sides;  ///< the cells of each face; −1 for none
    Index cellCount = 0;
    std::map<std::int64_t, std::pair<std::string, std::string>> names;  ///< type and name of a zone
    std::map<std::int64_t, std::int64_t> partners;                      ///< of periodic zones
};

constexpr std::int64_t kNodeSection = 10, kCellSection = 12, kFaceSection = 13,
                       kPeriodicSection = 18;
constexpr std::int64_t kInteriorZone = 2, kParentZone = 31;

class FluentReader {
public:
    FluentReader(const std::filesystem::path& path, std::string_view bytes)
        : path_(path), bytes_(bytes), file_(path, bytes) {}

    FluentMesh readPoints() {
        while (file_.next()) {
            if (file_.kind() == 2 && !file_.isBinary() && file_.head().size() == 1)
                setDimension(file_.number(0, 10));
            else if (file_.kind() == kNodeSection)
                readNodes();
        }
        if (mesh_.numbers.points.values.empty())
            throw FileError(path_, "has no nodes (a section 10 with coordinates)");
        mesh_.numbers.dimension = static_cast<std::size_t>(dimension_);
        return std::move(mesh_);
    }

    /// Reads the faces and cells of a file whose points are read.
    FluentMesh readAll(FluentMesh points) {
        mesh_ = std::move(points);
        dimension_ = static_cast<std::int64_t>(mesh_.numbers.dimension);
        std::sort(mesh_.nodes.begin(), mesh_.nodes.end(),
                  [](const auto& a, const auto& b) { return a.first.first < b.first.first; });
        while (file_.next()) {
            const std::int64_t kind = file_.kind();
            if (kind == kCellSection && file_.number(0) > 0)
                mesh_.cells.push_back({file_.number(0), file_.number(1), file_.number(2), 0});
            else if (kind == kFaceSection)
                readFaces();
            else if (kind == kPeriodicSection && file_.head().size() >= 4)
                mesh_.partners[file_.number(2)] = file_.number(3);
            else if ((kind == 39 || kind == 45) && file_.head().size() >= 3)
                mesh_.names[file_.number(0, 10)] = {std::string(file_.head()[1]),
                                                    std::string(file_.head()[2])};
        }
        for (const auto& [zone, partner] : std::map(mesh_.partners)) mesh_.partners[partner] = zone;
        checkZones();
        numberCells();
        return std::move(mesh_);
    }

private:
    void setDimension(std::int64_t dimension) {
        if (dimension != 2 && dimension != 3)
            file_.fail(concat("the dimension is ", dimension, "; expected 2 or 3"));
        if (!mesh_.numbers.points.values.empty() && dimension != dimension_)
            file_.fail(concat("the dimension is ", dimension,
                              ", but there are points of dimension ", dimension_));
        dimension_ = dimension;
        hasDimension_ = true;
    }

    /// Reads the range of a zone; nothing for a declaration of all zones, which has no body.
    std::optional<FluentZone> readZone(std::size_t minBytes, const char* what) {
        const FluentZone zone{file_.number(0), file_.number(1), file_.number(2), file_.number(3)};
        if (zone.id == 0 || !file_.beginBody()) return std::nullopt;
        if (zone.first < 1 || zone.last < zone.first - 1 || zone.last >= kMaxIndex)
            file_.fail(concat("a section has the ", what, " ", zone.first, " to ", zone.last));
        file_.checkRoom(zone.last - zone.first + 1, minBytes, what);
        return zone;
    }

    void readNodes() {
        // Without the section 2, the zone tells the dimension.
        const std::int64_t own = file_.head().size() >= 5 ? file_.number(4) : 0;
        if (!hasDimension_ && (own == 2 || own == 3)) setDimension(own);
        const auto axes = static_cast<std::size_t>(dimension_);
        const auto zone = readZone(axes * (file_.isBinary() ? file_.numberSize() : 2), "nodes");
        if (!zone) return;
        FileVectors& points = mesh_.numbers.points;
        const Precision precision = file_.numberSize() == 4 ? Precision::Float : Precision::Double;
        if (!points.values.empty() && (file_.isBinary() != mesh_.numbers.order.has_value() ||
                                       (file_.isBinary() && points.precisions[0] != precision)))
            file_.fail("the nodes of a zone are written in another way than those before");
        if (file_.isBinary()) mesh_.numbers.setBinary(std::endian::little, precision);
        mesh_.nodes.emplace_back(*zone, static_cast<Index>(points.values.size()));
        for (std::int64_t node = zone->first; node <= zone->last; ++node) {
            Point3& position = points.values.emplace_back(Point3{0, 0, 0});
            CoordinateOffsets& offsets = points.offsets.emplace_back(CoordinateOffsets{});
            for (std::size_t axis = 0; axis < axes; ++axis) {
                if (file_.isBinary()) {
                    offsets[axis] = file_.realOffset("a coordinate");
                    position[axis] =
                        loadReal(bytes_, offsets[axis], precision, std::endian::little);
                } else {
                    const std::string_view word = file_.realWord("a coordinate");
                    offsets[axis] = file_.offsetOf(word);
                    position[axis] = parseReal(word, Precision::Double);
                    if (!isNumber(word))
                        file_.fail(concat(inQuotes(word), " is not a number; expected ",
                                          axisName(axis), " of a node"));
                }
            }
        }
    }

    static bool isNumber(std::string_view word) {
        double number = 0;
        return parseNumber(word, number);
    }

    Index pointOf(std::int64_t node) const {
        auto zone = std::upper_bound(
            mesh_.nodes.begin(), mesh_.nodes.end(), node,
            [](std::int64_t number, const auto& item) { return number < item.first.first; });
        if (zone != mesh_.nodes.begin() && node <= (--zone)->first.last)
            return zone->second + static_cast<Index>(node - zone->first.first);
        file_.fail(concat("a face names node ", node, ", which does not exist"));
    }

    Index cellOf(std::int64_t cell) const {
        if (cell < 0 || cell >= kMaxIndex)
            file_.fail(concat("a face names cell ", cell, ", which does not exist"));
        return static_cast<Index>(cell) - 1;
    }

    void readFaces() {
        const std::int64_t shape = file_.number(4);
        const auto zone = readZone(file_.isBinary() ? 16 : 6, "faces");
        if (!zone) return;
        const bool isParent = zone->type == kParentZone;
        if (!isParent) mesh_.faces.emplace_back(*zone, mesh_.sides.size());
        std::vector<Index> corners;
        for (std::int64_t face = zone->first; face <= zone->last; ++face) {
            // A face of a mixed zone, or a polygon, has the number of its nodes.
            const std::int64_t count =
                shape == 0 || shape == 5 ? file_.integer("the number of nodes of a face") : shape;
            // Where Fluent has cut the faces of an interface, it keeps their numbers.
            const bool isCut = count == 0 && shape == 0;
            if (!isCut && (count < 2 || (dimension_ == 2) != (count == 2)))
                file_.fail(concat("a face of a mesh of ", dimension_, " dimensions has ", count,
                                  " nodes"));
            file_.checkRoom(count, 2, "nodes");
            corners.clear();
            for (std::int64_t i = 0; i < count; ++i)
                corners.push_back(pointOf(file_.integer("a node of a face")));
            std::array<Index, 2> cells{};
            for (Index& cell : cells) cell = cellOf(file_.integer("a cell of a face"));
            if (isParent || isCut) continue;
            if (cells[0] == cells[1])
                file_.fail(cells[0] < 0
                               ? "a face has no cell"
                               : concat("a face has cell ", cells[0] + 1, " on both sides"));
            mesh_.corners.push(corners);
            mesh_.sides.push_back(cells);
        }
    }

    /// Throws if two zones have the same cells.
    void checkZones() {
        std::sort(mesh_.cells.begin(), mesh_.cells.end(),
                  [](const FluentZone& a, const FluentZone& b) { return a.first < b.first; });
        for (std::size_t i = 1; i < mesh_.cells.size(); ++i) {
            const FluentZone &before = mesh_.cells[i - 1], &zone = mesh_.cells[i];
            if (before.last >= zone.first)
                throw FileError(path_, concat("the zones ", before.id, " and ", zone.id,
                                              " both have cell ", zone.first));
        }
    }

    /// Gives the cells that have faces the numbers from 0 on.
    void numberCells() {
        std::vector<Index> used;
        for (const auto& cells : mesh_.sides)
            for (const Index cell : cells)
                if (cell >= 0) used.push_back(cell);
        sortUnique(used);
        for (auto& cells : mesh_.sides)
            for (Index& cell : cells)
                if (cell >= 0) cell = indexIn(used, cell);
        for (FluentZone& zone : mesh_.cells) {
            const auto numberOf = [&](std::int64_t cell) {
                return std::lower_bound(used.begin(), used.end(), cell) - used.begin();
            };
            zone.first = numberOf(zone.first - 1);
            zone.last = numberOf(zone.last) - 1;
        }
        mesh_.cellCount = static_cast<Index>(used.size());
    }

    const std::filesystem::path& path_;
    std::string_view bytes_;
    FluentFile file_;
    std::int64_t dimension_ = 3;
    bool hasDimension_ = false;
    FluentMesh mesh_;
};

FluentMesh readFluent(const std::filesystem::path& path, std::string_view bytes) {
    return FluentReader(path, bytes).readAll(FluentReader(path, bytes).readPoints());
}

/// Returns the name and the type of a zone.
std::pair<std::string, std::string> zoneName(const FluentMesh& mesh, const FluentZone& zone) {
    const auto found = mesh.names.find(zone.id);
    if (found != mesh.names.end()) return {found->second.second, found->second.first};
    constexpr std::pair<std::int64_t, const char*> kTypes[] = {
        {3, "wall"},       {4, "pressure-inlet"},   {5, "pressure-outlet"}, {7, "symmetry"},
        {8, "shadow"},     {12, "periodic"},        {10, "velocity-inlet"}, {14, "fan"},
        {24, "interface"}, {20, "mass-flow-inlet"}, {36, "outflow"},        {37, "axis"}};
    const auto type =
        std::ranges::find(kTypes, zone.type, &std::pair<std::int64_t, const char*>::first);
    return {concat("zone ", zone.id), type == std::end(kTypes) ? "" : type->second};
}

/// Returns twice the area, or six times the volume, that the faces enclose: positive if the faces
/// are anticlockwise seen from outside their first cells.
double orientation(const FluentMesh& mesh) {
    double sum = 0;
    const auto& positions = mesh.numbers.points.values;
    std::vector<Point3> points;
    for (std::size_t face = 0; face < mesh.sides.size(); ++face) {
        const auto& [first, second] = mesh.sides[face];
        if (first >= 0 && second >= 0) continue;  // counts twice, with both signs
        points.clear();
        for (const Index point : mesh.corners[face])
            points.push_back(difference(positions[point], positions[0]));
        const double part = points.size() == 2
                                ? points[0][0] * points[1][1] - points[0][1] * points[1][0]
                                : 2 * dot(mean(points), areaVector(points));
        sum += first >= 0 ? part : -part;
    }
    return sum;
}

/// Makes all faces anticlockwise seen from outside their first cells, and that cell exist.
void orient(FluentMesh& mesh) {
    // The format has the opposite order, but some programs do not follow it.
    const bool isReversed = orientation(mesh) < 0;
    far::Rows<Index> corners;
    std::vector<Index> loop;
    for (std::size_t face = 0; face < mesh.sides.size(); ++face) {
        const auto points = mesh.corners[face];
        loop.assign(points.begin(), points.end());
        auto& cells = mesh.sides[face];
        const bool isSwapped = cells[0] < 0;
        if (isSwapped) std::swap(cells[0], cells[1]);
        if (isReversed != isSwapped) std::reverse(loop.begin(), loop.end());
        corners.push(loop);
    }
    mesh.corners = std::move(corners);
}

/// Makes the volume, whose internal faces come first.
far::VolumeMesh volumeOf(const std::filesystem::path& path, FluentMesh& mesh) {
    orient(mesh);
    far::Rows<Index> faces;
    std::vector<Index> owners, neighbours;
    for (const bool isInternal : {true, false})
        for (std::size_t face = 0; face < mesh.sides.size(); ++face) {
            const auto& [owner, neighbour] = mesh.sides[face];
            if ((neighbour >= 0) != isInternal) continue;
            faces.push(mesh.corners[face]);
            owners.push_back(owner);
            if (isInternal) neighbours.push_back(neighbour);
        }
    return withPathInErrors(path, [&] {
        return far::VolumeMesh(static_cast<Index>(mesh.numbers.points.values.size()),
                               mesh.cellCount, std::move(faces), std::move(owners),
                               std::move(neighbours));
    });
}

/// Returns the faces of each cell: the number of the face, and whether it is the first cell of the
/// face.
far::Rows<std::pair<Index, bool>> facesOfCells(const FluentMesh& mesh) {
    far::Rows<std::pair<Index, bool>> rows;
    std::vector<Offset> next(static_cast<std::size_t>(mesh.cellCount) + 1, 0);
    for (const auto& cells : mesh.sides)
        for (const Index cell : cells)
            if (cell >= 0) ++next[static_cast<std::size_t>(cell) + 1];
    for (std::size_t cell = 1; cell < next.size(); ++cell) next[cell] += next[cell - 1];
    rows.offsets.assign(next.begin(), next.end());
    rows.values.resize(next.back());
    for (std::size_t face = 0; face < mesh.sides.size(); ++face)
        for (const bool isFirst : {true, false})
            if (const Index cell = mesh.sides[face][isFirst ? 0 : 1]; cell >= 0)
                rows.values[next[static_cast<std::size_t>(cell)]++] = {static_cast<Index>(face),
                                                                       isFirst};
    return rows;
}

/// Visits the polygons of a mesh of two dimensions.
class FluentPolygons {
public:
    explicit FluentPolygons(FluentMesh& mesh) : mesh_(mesh) {
        orient(mesh_);
        edges_ = facesOfCells(mesh_);
    }

    void visit(CellVisitor& visitor) {
        for (const FluentZone& zone : mesh_.cells) {
            beginGroup(zone, visitor);
            for (std::int64_t cell = zone.first; cell <= zone.last; ++cell)
                visitCell(static_cast<Index>(cell), visitor);
        }
        // Cells of no zone.
        std::vector<char> isInZone(static_cast<std::size_t>(mesh_.cellCount), 0);
        for (const FluentZone& zone : mesh_.cells)
            for (std::int64_t cell = zone.first; cell <= zone.last; ++cell)
                isInZone[static_cast<std::size_t>(cell)] = 1;
        if (visitor.wantsGroups()) visitor.beginGroups({});
        for (Index cell = 0; cell < mesh_.cellCount; ++cell)
            if (!isInZone[static_cast<std::size_t>(cell)]) visitCell(cell, visitor);
        for (std::size_t zone = 0; zone < mesh_.faces.size(); ++zone) {
            if (mesh_.faces[zone].first.type == kInteriorZone) continue;
            beginGroup(mesh_.faces[zone].first, visitor);
            for (std::size_t face = mesh_.faces[zone].second; face < mesh_.faceEnd(zone); ++face)
                visitor.smallCell(1, mesh_.corners[face]);
        }
    }

private:
    void beginGroup(const FluentZone& zone, CellVisitor& visitor) const {
        if (!visitor.wantsGroups()) return;
        const std::string name = zoneName(mesh_, zone).first;
        visitor.beginGroups(std::span(&name, 1));
    }

    /// Joins the edges of a cell. The first one gives the direction, since some files have edges in
    /// the wrong one.
    void visitCell(Index cell, CellVisitor& visitor) {
        ends_.clear();
        loop_.clear();
        const auto edges = edges_[static_cast<std::size_t>(cell)];
        for (std::size_t i = 0; i < edges.size(); ++i) {
            const auto& [edge, isFirst] = edges[i];
            const auto ends = mesh_.corners[static_cast<std::size_t>(edge)];
            const Index from = ends[isFirst ? 0 : 1], to = ends[isFirst ? 1 : 0];
            if (i == 0) loop_ = {from, to};
            if (i > 0) ends_.push_back({from, to, i});
            if (i > 0) ends_.push_back({to, from, i});
        }
        std::sort(ends_.begin(), ends_.end());
        isUsed_.assign(edges.size(), false);
        while (loop_.size() <= edges.size()) {
            auto next = std::lower_bound(ends_.begin(), ends_.end(),
                                         std::tuple(loop_.back(), Index{-1}, std::size_t{0}));
            while (next != ends_.end() && std::get<0>(*next) == loop_.back() &&
                   isUsed_[std::get<2>(*next)])
                ++next;
            if (next == ends_.end() || std::get<0>(*next) != loop_.back()) break;
            isUsed_[std::get<2>(*next)] = true;
            loop_.push_back(std::get<1>(*next));
        }
        if (loop_.size() < 4 || loop_.size() != edges.size() + 1 || loop_.front() != loop_.back())
            return visitor.unknownElement(1,
                                          concat("the edges of cell ", cell, " form no polygon"));
        loop_.pop_back();
        visitor.face(loop_);
    }

    FluentMesh& mesh_;
    far::Rows<std::pair<Index, bool>> edges_;
    /// The ends of the edges of the current cell: a point, the other one, and the edge.
    std::vector<std::tuple<Index, Index, std::size_t>> ends_;
    std::vector<bool> isUsed_;  ///< of its edges
    std::vector<Index> loop_;
};

void readFluentCells(const std::filesystem::path& path, std::string_view bytes, Index,
                     CellVisitor& visitor) {
    FluentMesh mesh = readFluent(path, bytes);
    if (mesh.numbers.dimension == 2) return FluentPolygons(mesh).visit(visitor);
    visitVolume(volumeOf(path, mesh), visitor);
}

/// Returns the patches of a volume: the zones of its cells and of its boundary.
std::vector<far::MeshPatch> patchesOf(const FluentMesh& mesh, const far::VolumeMesh& volume) {
    std::vector<far::MeshPatch> patches;
    std::map<std::string, std::size_t> numbers;
    std::map<std::int64_t, std::string> namesOfFaces;
    for (const auto& [zone, face] : mesh.faces) namesOfFaces[zone.id] = zoneName(mesh, zone).first;
    const auto add = [&](const FluentZone& zone, int dimension) -> far::MeshPatch& {
        auto [name, type] = zoneName(mesh, zone);
        const auto [at, isNew] = numbers.try_emplace(name, patches.size());
        if (isNew) patches.push_back({name, type});
        far::MeshPatch& patch = patches[at->second];
        patch.dimension = std::max(patch.dimension, dimension);
        return patch;
    };
    for (const FluentZone& zone : mesh.cells) {
        std::vector<Index>& points = add(zone, 3).points;
        for (std::int64_t cell = zone.first; cell <= zone.last; ++cell)
            for (const Index face : volume.faces(static_cast<Index>(cell)))
                points.insert(points.end(), volume.face(face).begin(), volume.face(face).end());
        sortUnique(points);
    }
    for (std::size_t number = 0; number < mesh.faces.size(); ++number) {
        const FluentZone& zone = mesh.faces[number].first;
        if (zone.type == kInteriorZone) continue;
        far::MeshPatch& patch = add(zone, 2);
        if (const auto partner = mesh.partners.find(zone.id); partner != mesh.partners.end())
            if (const auto name = namesOfFaces.find(partner->second); name != namesOfFaces.end())
                patch.partner = name->second;
        for (std::size_t face = mesh.faces[number].second; face < mesh.faceEnd(number); ++face) {
            patch.faces.push(mesh.corners[face]);
            patch.points.insert(patch.points.end(), mesh.corners[face].begin(),
                                mesh.corners[face].end());
        }
        sortUnique(patch.points);
    }
    std::erase_if(patches, [](const far::MeshPatch& patch) { return patch.points.empty(); });
    return patches;
}

ModelCells readFluentModelCells(const FileView& file) {
    FluentMesh mesh = readFluent(file.path, file.bytes);
    ModelCells result;
    if (mesh.numbers.dimension == 2) {
        MeshCells cells;
        FluentPolygons(mesh).visit(cells);
        result =
            withPathInErrors(file.path, [&] { return cells.finish(file.numbers.points.values); });
        std::map<std::string, std::string> types;
        for (const FluentZone& zone : mesh.cells) types.insert(zoneName(mesh, zone));
        for (const auto& [zone, face] : mesh.faces) types.insert(zoneName(mesh, zone));
        for (far::MeshPatch& patch : result.patches) patch.type = types[patch.name];
        return result;
    }
    result.volume = volumeOf(file.path, mesh);
    result.patches = patchesOf(mesh, result.volume);
    return result;
}

constexpr MeshFormat kFluentMesh = {
    .readPoints =
        [](const std::filesystem::path& path, std::string_view bytes) {
            return FluentReader(path, bytes).readPoints().numbers;
        },
    .readCells = readFluentCells,
    .readModelCells = readFluentModelCells};

}  // namespace

const Format kFluentFormat = {.extensions = {".cas", ".msh"},
                              .isMesh = true,
                              .isContent =
                                  [](std::string_view bytes) {
                                      const std::size_t begin =
                                          bytes.find_first_not_of(" \t\r\n\v\f");
                                      return begin != std::string_view::npos && bytes[begin] == '(';
                                  },
                              .readModel = readMeshModel<kFluentMesh>,
                              .readLattice = readMeshLattice<kFluentMesh>};

}  // namespace espalier::io
