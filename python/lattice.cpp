// SPDX-License-Identifier: Apache-2.0
#include <espalier/far/box_grid.h>
#include <espalier/far/complex_builder.h>
#include <espalier/far/topology_match.h>
#include <espalier/io/formats.h>
#include <espalier/io/lattice_file.h>
#include <espalier/io/pose_file.h>
#include <espalier/shapes/held.h>
#include <espalier/shapes/lattice.h>
#include <espalier/shapes/transform.h>
#include <pybind11/stl.h>
#include <pybind11/stl/filesystem.h>

#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <tuple>
#include <utility>
#include <vector>

#include "lattice_arguments.h"
#include "pickling.h"

namespace espalier::python {

using namespace py::literals;

namespace {

/// A lattice never changes after it has been made, so any number of threads may read it.
using LatticePointer = std::shared_ptr<Lattice>;

/// The parts of a lattice that are optional in Python.
struct OptionalParts {
    EdgeSharpness edges;
    VertexSharpness vertices;
    std::vector<Index> holes;
    py::dict attributes;
};

Index vertexCountOf(const std::vector<Point3>& positions) {
    if (!std::in_range<Index>(positions.size()))
        throw Error("positions: there are too many; expected at most 2147483647");
    return static_cast<Index>(positions.size());
}

LatticePointer makeLattice(far::CellComplex complex, std::vector<Point3> positions,
                           const OptionalParts& extras) {
    auto marks = marksOf(complex, extras.edges, extras.vertices, extras.holes);
    auto [attributes, integers] = vertexArraysOf(extras.attributes, positions.size());
    return std::make_shared<Lattice>(Lattice{std::move(complex),
                                             std::move(positions),
                                             std::move(marks),
                                             std::move(attributes),
                                             {},
                                             std::move(integers)});
}

LatticePointer ofCells(const ArrayLike& positions, const py::object& cells,
                       const EdgeSharpness& edges, const VertexSharpness& vertices,
                       const py::dict& attributes) {
    auto points = toPoints(positions, "positions");
    auto complex = complexOfCells(vertexCountOf(points), cells);
    return makeLattice(std::move(complex), std::move(points), {edges, vertices, {}, attributes});
}

LatticePointer ofFaces(const ArrayLike& positions, const py::object& faces,
                       const EdgeSharpness& edges, const VertexSharpness& vertices,
                       const std::optional<ArrayLike>& holes, const py::dict& attributes,
                       const std::optional<ArrayLike>& textures, const py::object& textureCorners) {
    auto points = toPoints(positions, "positions");
    auto complex = complexOfFaces(vertexCountOf(points), faces);
    auto mesh = makeLattice(
        std::move(complex), std::move(points),
        {edges, vertices, holes ? toIndices(*holes, "holes") : std::vector<Index>(), attributes});
    if (textures.has_value() == textureCorners.is_none())
        throw Error("texture_coordinates and texture_corners: expected both or neither");
    if (textures) mesh->textureCoordinates = texturesOf(mesh->complex, *textures, textureCorners);
    return mesh;
}

LatticePointer curve(const ArrayLike& positions, bool closed, const VertexSharpness& vertices,
                     const py::dict& attributes) {
    auto points = toPoints(positions, "positions");
    auto complex = far::buildCurve(vertexCountOf(points), closed);
    return makeLattice(std::move(complex), std::move(points), {{}, vertices, {}, attributes});
}

LatticePointer withPositions(const Lattice& lattice, const ArrayLike& positions) {
    Lattice posed = lattice;
    posed.positions = toPoints(positions, "positions", lattice.positions.size());
    return std::make_shared<Lattice>(std::move(posed));
}

/// Returns the lattice with other marks; its holes stay.
LatticePointer withMarks(const Lattice& lattice, const EdgeSharpness& edges,
                         const VertexSharpness& vertices) {
    Lattice marked = lattice;
    marked.marks = marksOf(lattice.complex, edges, vertices, lattice.marks.holes);
    return std::make_shared<Lattice>(std::move(marked));
}

LatticePointer transformed(const Lattice& lattice, const ArrayLike& linear,
                           const Point3& translation) {
    const auto rows = toPoints(linear, "linear", 3);
    shapes::Affine map{{rows[0], rows[1], rows[2]}, translation};
    return sharedWithoutGil([&] { return shapes::transformed(lattice, map); });
}

// Functions that may derive a relation release the GIL first. Another thread may be deriving the
// same relation, and may need the GIL for it (InterruptScope). If this thread waited for the other
// one and kept the GIL, both would wait for ever.

std::vector<std::vector<Index>> loopsOf(const far::CellComplex& complex) {
    return withoutGil([&] {
        std::vector<std::vector<Index>> loops;
        if (complex.dimension() < 2) return loops;
        for (Index face = 0; face < complex.count(2); ++face) {
            const auto loop = complex.relation(2, 0)[face];
            loops.emplace_back(loop.begin(), loop.end());
        }
        return loops;
    });
}

std::vector<std::vector<std::vector<Index>>> cellsOf(const far::CellComplex& complex) {
    return withoutGil([&] {
        std::vector<std::vector<std::vector<Index>>> cells;
        for (Index cell = 0; cell < complex.count(3); ++cell)
            cells.push_back(far::outwardLoops(complex, CellId(cell)));
        return cells;
    });
}

py::array_t<Index> hexahedra(const Lattice& lattice) {
    const Index count = lattice.complex.count(3);
    return toArray(withoutGil([&] {
               std::vector<Index> vertices;
               for (Index cell = 0; cell < count; ++cell) {
                   const auto corners = far::hexahedronVertices(lattice.complex, CellId(cell));
                   if (!corners)
                       throw Error(concat(
                           "cell ", cell,
                           " is not a hexahedron; use `cells`, which has the faces of every cell"));
                   vertices.insert(vertices.end(), corners->begin(), corners->end());
               }
               return vertices;
           }))
        .reshape(std::vector<py::ssize_t>{count, 8});
}

/// Returns the vertices of a box by their places in it.
py::array_t<Index> gridOf(const Lattice& lattice) {
    const far::BoxGrid grid = withoutGil([&] { return far::asBoxGrid(lattice.complex); });
    std::vector<Index> vertices;
    vertices.reserve(grid.vertices.size());
    for (Index i = 0; i <= grid.cells[0]; ++i)
        for (Index j = 0; j <= grid.cells[1]; ++j)
            for (Index k = 0; k <= grid.cells[2]; ++k) vertices.push_back(grid.vertexAt({i, j, k}));
    return toArray(std::move(vertices))
        .reshape(std::vector<py::ssize_t>{grid.cells[0] + 1, grid.cells[1] + 1, grid.cells[2] + 1});
}

py::array_t<Index> edgesOf(const Lattice& lattice) {
    std::vector<Index> ends;
    for (Index edge = 0; edge < lattice.complex.count(1); ++edge)
        for (const Index vertex : lattice.complex.relation(1, 0)[edge]) ends.push_back(vertex);
    return toArray(std::move(ends)).reshape(std::vector<py::ssize_t>{-1, 2});
}

py::array_t<Index> boundaryFaces(const Lattice& lattice) {
    return toArray(withoutGil([&] {
        std::vector<Index> faces;
        if (lattice.complex.dimension() == 3)
            for (Index face = 0; face < lattice.complex.count(2); ++face)
                if (lattice.complex.relation(2, 3)[face].size() == 1) faces.push_back(face);
        return faces;
    }));
}

EdgeSharpness edgeSharpness(const Lattice& lattice) {
    EdgeSharpness sharpness;
    for (const auto& mark : lattice.marks.edges) {
        const auto& [a, b] = mark.vertices;
        sharpness.erase({b, a});  // the last mark counts
        sharpness.insert_or_assign({a, b}, mark.sharpness);
    }
    return sharpness;
}

VertexSharpness vertexSharpness(const Lattice& lattice) {
    VertexSharpness sharpness;
    for (const auto& mark : lattice.marks.vertices)
        sharpness.insert_or_assign(mark.vertex, mark.sharpness);
    return sharpness;
}

/// Returns views of the attributes or integers of a lattice. `self` is the lattice, which owns
/// them.
template <class List>
py::dict arraysOf(const List& list, const py::object& self) {
    const auto count = static_cast<py::ssize_t>(self.cast<const Lattice&>().positions.size());
    py::dict arrays;
    for (const auto& each : list)
        arrays[strOfName(each.name)] =
            viewOf(std::span(each.values), {count, each.components}, self);
    return arrays;
}

py::dict attributesIn(const py::object& self) {
    return arraysOf(self.cast<const Lattice&>().attributes, self);
}

py::dict integersIn(const py::object& self) {
    const auto& integers = self.cast<const Lattice&>().integers;
    const py::dict arrays = arraysOf(integers, self);
    for (const VertexIntegers& each : integers)
        if (const py::str name = strOfName(each.name); each.type == IntegerType::UInt64)
            arrays[name] = arrays[name].attr("view")("uint64");
    return arrays;
}

py::dict tagsOf(const Lattice& lattice) {
    py::dict tags;
    const RefinementTags& set = lattice.tags;
    if (set.boundary) tags["boundary"] = wordOf(far::kBoundaryWords, set.boundary);
    if (set.creasing) tags["creasing"] = wordOf(far::kCreasingWords, set.creasing);
    if (set.triangles) tags["triangles"] = wordOf(far::kTriangleSubdivisionWords, set.triangles);
    if (set.faceVarying)
        tags["face_varying"] = wordOf(far::kFaceVaryingLinearWords, set.faceVarying);
    return tags;
}

std::vector<std::vector<Index>> textureCornersOf(const Lattice& lattice) {
    const auto& corners = lattice.textureCoordinates.corners;
    std::vector<std::vector<Index>> faces;
    if (corners.empty()) return faces;
    return withoutGil([&] {
        auto corner = corners.begin();
        for (Index face = 0; face < lattice.complex.count(2); ++face) {
            const auto size = std::ssize(lattice.complex.relation(2, 0)[face]);
            faces.emplace_back(corner, corner + size);
            corner += size;
        }
        return faces;
    });
}

std::string summaryOf(const Lattice& lattice) {
    const auto& complex = lattice.complex;
    std::string text =
        concat("<espalier.Lattice: ", complex.count(0), " vertices, ", complex.count(1), " edges");
    if (complex.dimension() > 1) text += concat(", ", complex.count(2), " faces");
    if (complex.dimension() > 2) text += concat(", ", complex.count(3), " cells");
    return text + ">";
}

void addArrays(py::class_<Lattice, LatticePointer>& type) {
    type.def_property_readonly(
            "positions",
            [](const py::object& self) {
                return viewOf(self.cast<const Lattice&>().positions, self);
            },
            "Positions of the vertices: array (V, 3) of float64, read-only, not a copy, in any "
            "unit of "
            "length.")
        .def_property_readonly(
            "dimension", [](const Lattice& self) { return self.complex.dimension(); },
            "3 for a lattice, 2 for a mesh, 1 for a curve.")
        .def_property_readonly(
            "counts",
            [](const Lattice& self) {
                const auto& complex = self.complex;
                return std::tuple(complex.count(0), complex.count(1), complex.count(2),
                                  complex.count(3));
            },
            "Numbers of vertices, edges, faces and cells: tuple of 4 int.")
        .def_property_readonly("edges", &edgesOf,
                               "The two vertices of each edge: array (E, 2) of int32.")
        .def_property_readonly(
            "faces", [](const Lattice& self) { return loopsOf(self.complex); },
            "The vertices around each face: list of lists of int.")
        .def_property_readonly(
            "cells", [](const Lattice& self) { return cellsOf(self.complex); },
            "The faces of each cell, as loops of vertices, anticlockwise seen from outside: list "
            "of "
            "lists of lists of int.")
        .def_property_readonly("hexahedra", &hexahedra,
                               "The vertices of the cells in VTK's order, if all cells are "
                               "hexahedra: array (C, 8) of int32. Otherwise a ValueError names a "
                               "cell that is not.")
        .def_property_readonly("grid", &gridOf,
                               "The vertices of a box by their places: array (I, J, K) of int32. "
                               "Vertex (0, 0, 0) is the lowest one in a single cell; its "
                               "neighbours, ascending, give the axes. A ValueError names the place "
                               "where another lattice is not a box of hexahedra.")
        .def_property_readonly("boundary_faces", &boundaryFaces,
                               "The faces of a lattice that are in one cell only, ascending: array "
                               "(B,) of int32.")
        .def_property_readonly("edge_sharpness", &edgeSharpness,
                               "Edges whose sharpness is set by hand: dict from pairs of vertices "
                               "to float; inf is sharp, 0 is smooth, numbers between are "
                               "semi-sharp.")
        .def_property_readonly("vertex_sharpness", &vertexSharpness,
                               "Vertices whose sharpness is set by hand: dict from int to float.")
        .def_property_readonly("attributes", &attributesIn,
                               "Real numbers at the vertices, which are refined like the "
                               "positions: dict from names to arrays (V, k) of float64, read-only, "
                               "not copies.")
        .def_property_readonly(
            "held", [](const Lattice& self) { return toArray(shapes::heldVertices(self)); },
            "The vertices that fit() and RigidPull keep in place, such as the outer vertices of a "
            "collar, ascending: array of int32. They have a 1 in the integers named \"held\".")
        .def_property_readonly(
            "integers", &integersIn,
            "Integers at the vertices, which are never averaged: dict from names "
            "to arrays (V, k) of int64, or uint64 if they were given so, "
            "read-only, not copies. In a refined lattice a vertex that is not "
            "the child of a vertex has -1, or the largest number of an unsigned "
            "type.")
        .def_property_readonly("tags", &tagsOf,
                               "How the file asks to be refined: dict with boundary, creasing, "
                               "triangles and face_varying, each only if the file sets it.")
        .def_property_readonly(
            "texture_coordinates",
            [](const py::object& self) {
                const auto& values = self.cast<const Lattice&>().textureCoordinates.values;
                return viewOf(std::span(values), {std::ssize(values) / 2, 2}, self);
            },
            "Texture coordinates of a mesh, which `texture_corners` refers to: array (T, 2) of "
            "float64, read-only, not a copy. Of shape (0, 2) if there are none.")
        .def_property_readonly("texture_corners", &textureCornersOf,
                               "For each face of a mesh, the row of `texture_coordinates` at each "
                               "of its corners, in the order of `faces`: list of lists of int. "
                               "Empty if there are none.");
}

}  // namespace

void addLattice(py::module_& module) {
    py::class_<Lattice, LatticePointer> type(module, "Lattice", R"(
A control lattice: positions of vertices, and polyhedral cells of any shape. Immutable.

positions : array (V, 3) of float64, in any unit of length
cells     : array (C, 8) of int, hexahedra in VTK's order; (C, 4) tetrahedra, (C, 5) pyramids and
            (C, 6) wedges likewise; or a list whose entries are 4, 5, 6 or 8 vertices, or the faces
            of any polyhedron as loops of vertices
edge_sharpness   : dict from pairs of vertices to a sharpness, as in OpenSubdiv: inf (or 10 and
                   more) is sharp, 0 is smooth, numbers between are semi-sharp
vertex_sharpness : dict from vertices to a sharpness
attributes       : dict from names to arrays (V,) or (V, k). Arrays of real numbers are refined
                   like the positions. Arrays of integers, such as identifiers, are never averaged,
                   and are found in `integers`

Meshes and curves are lattices of dimension 2 and 1: mesh() and curve() make them.
)");
    type.def(py::init(&ofCells), "positions"_a, "cells"_a, py::kw_only(),
             "edge_sharpness"_a = EdgeSharpness(), "vertex_sharpness"_a = VertexSharpness(),
             "attributes"_a = py::dict())
        .def_static("mesh", &ofFaces, "positions"_a, "faces"_a, py::kw_only(),
                    "edge_sharpness"_a = EdgeSharpness(), "vertex_sharpness"_a = VertexSharpness(),
                    "holes"_a = py::none(), "attributes"_a = py::dict(),
                    "texture_coordinates"_a = py::none(), "texture_corners"_a = py::none(), R"(
A mesh: a lattice of dimension 2.

positions : array (V, 3) of float64
faces     : array (F, k) of int, or a list of loops of vertices
holes     : array (H,) of int, faces that are not part of the surface
texture_coordinates : array (T, 2) of float64
texture_corners     : array (F, k) of int, or a list of lists like `faces`: the row of
                      texture_coordinates at each corner of each face. Corners of one vertex with
                      different rows make a seam
)")
        .def_static("curve", &curve, "positions"_a, py::kw_only(), "closed"_a = false,
                    "vertex_sharpness"_a = VertexSharpness(), "attributes"_a = py::dict(), R"(
A curve through its vertices in order: a lattice of dimension 1.

positions : array (V, 3) of float64
closed    : whether an edge joins the last vertex to the first
)")
        .def("with_positions", &withPositions, "positions"_a,
             "Returns the same lattice in another pose. positions : array (V, 3)")
        .def("with_marks", &withMarks, py::kw_only(), "edge_sharpness"_a = EdgeSharpness(),
             "vertex_sharpness"_a = VertexSharpness(),
             "Returns the same lattice with these sharpness values instead of its own.")
        .def("transformed", &transformed, "linear"_a, "translation"_a = Point3{},
             R"(
Returns the lattice moved by an affine map, p -> linear @ p + translation. If the map mirrors, the
faces are reversed, so that volumes stay positive.

linear : array (3, 3); translation : 3 float
)")
        .def(
            "topology_difference",
            [](const Lattice& self, const Lattice& other) {
                return withoutGil(
                    [&] { return far::topologyDifference(self.complex, other.complex); });
            },
            "other"_a,
            "Returns how the cells of two lattices differ: str; None if they are the same cells on "
            "the same vertex numbers, so that one can be a pose of the other.")
        .def(
            "write",
            [](const Lattice& self, const std::filesystem::path& path) {
                withoutGil([&] { io::writeRefinable(path, self); });
            },
            "path"_a,
            "Writes a lattice (.ovm, .vtu or .vtk), or a mesh or a curve (.obj). An existing file "
            "is "
            "replaced only when the new one is complete.")
        .def(
            "write_editor_mesh",
            [](const Lattice& self, const std::filesystem::path& path) {
                withoutGil([&] { io::writeEditorMesh(path, self); });
            },
            "path"_a,
            "Writes the vertices of a lattice in their order, and all its faces, as .obj or .ply, "
            "for mesh editors. read_pose() reads the edited file.")
        .def("__repr__", &summaryOf);
    addArrays(type);
    addPickling(type, &stateOfLattice, &latticeOfState);
    module.def(
        "read",
        [](const std::filesystem::path& path) {
            io::ReadNotes notes;
            auto lattice = sharedWithoutGil([&] { return io::readRefinable(path, &notes); });
            warn(io::describe(path, notes));
            return lattice;
        },
        "path"_a,
        ("Reads a Lattice from " + io::listOfFormats(io::FileContent::Lattice, io::FileUse::Read) +
         "; or a mesh or a curve from " +
         io::listOfFormats(io::FileContent::Mesh, io::FileUse::Read) +
         ". Vertices in no cell of a lattice, or no line of a curve, are dropped with a "
         "UserWarning; the vertices after them get lower numbers.")
            .c_str());
    module.def(
        "read_pose",
        [](const std::filesystem::path& path, const Lattice& rest) {
            io::ReadNotes notes;
            auto points =
                withoutGil([&] { return io::readPose(path, rest, "the lattice", &notes); });
            warn(io::describe(path, notes));
            return toArray(std::move(points));
        },
        "path"_a, "rest"_a,
        "Reads the positions of a pose of the Lattice `rest`: array (V, 3) of float64. The file is "
        "a lattice with the same topology, or an editor mesh (.obj, .ply): one point per vertex, "
        "in the order of the vertices, and faces that are faces of the lattice. "
        "Lattice.write_editor_mesh() writes an editor mesh.");
}

}  // namespace espalier::python
