// SPDX-License-Identifier: Apache-2.0
#include <espalier/base/printable.h>
#include <espalier/far/complex_builder.h>
#include <espalier/far/topology_match.h>
#include <espalier/io/lattice_file.h>
#include <espalier/io/pose_file.h>
#include <espalier/shapes/lattice.h>
#include <espalier/shapes/transform.h>
#include <pybind11/stl.h>
#include <pybind11/stl/filesystem.h>

#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <tuple>
#include <utility>
#include <vector>

#include "arguments.h"
#include "pickling.h"

namespace espalier::python {

using namespace py::literals;

namespace {

using far::StandardCell;

/// The values of vertices besides their positions.
struct VertexArrays {
    std::vector<VertexAttribute> attributes;
    std::vector<VertexIntegers> integers;
};

/// Sharpness by the two vertices of an edge.
using EdgeSharpness = std::map<std::pair<Index, Index>, double>;
using VertexSharpness = std::map<Index, double>;

/// Files store marks under names that begin so (io/lattices/lattice_parts.h).
constexpr std::string_view kReservedNames = "espalier:";

std::optional<StandardCell> standardCell(std::size_t vertexCount) {
    for (const auto cell : {StandardCell::Tetrahedron, StandardCell::Pyramid, StandardCell::Wedge,
                            StandardCell::Hexahedron})
        if (static_cast<std::size_t>(far::vertexCount(cell)) == vertexCount) return cell;
    return std::nullopt;
}

[[noreturn]] void refuseCell(const std::string& name, std::size_t vertexCount) {
    throw Error(concat(name,
                       ": expected the 4, 5, 6 or 8 vertices of a tetrahedron, pyramid, wedge or "
                       "hexahedron, or loops of vertices, got ",
                       vertexCount, " vertices"));
}

/// Returns true if the entries of a cell are loops (lists or arrays), and false if they are numbers
/// of vertices.
bool holdsLoops(const py::sequence& cell) {
    return cell.size() == 0 || py::isinstance<py::sequence>(cell[0]);
}

void addCell(far::ComplexBuilder& builder, const py::sequence& cell, const std::string& name) {
    if (!holdsLoops(cell)) {
        const auto vertices = toIndices(cell, name);
        const auto kind = standardCell(vertices.size());
        if (!kind) refuseCell(name, vertices.size());
        builder.addCell(*kind, vertices);
        return;
    }
    std::vector<std::vector<Index>> loops;
    for (std::size_t i = 0; i < cell.size(); ++i)
        loops.push_back(toIndices(cell[i], concat(name, "[", i, "]")));
    builder.addCell(loops);
}

/// Returns the numbers per vertex of an array (V,) or (V, k): 1 or k.
int componentsOf(const py::array& array, const std::string& name, std::size_t vertexCount) {
    const bool fits = (array.ndim() == 1 || (array.ndim() == 2 && array.shape(1) > 0)) &&
                      static_cast<std::size_t>(array.shape(0)) == vertexCount;
    if (!fits)
        throw Error(concat(name, ": expected an array of shape (", vertexCount, ",) or (",
                           vertexCount, ", k), got ", shapeText(array)));
    return array.ndim() == 1 ? 1 : static_cast<int>(array.shape(1));
}

bool isOfIntegers(const py::array& array) {
    return array.dtype().kind() == 'i' || array.dtype().kind() == 'u';
}

/// Returns the type of integers, of either byte order.
IntegerType integerType(const py::dtype& type) {
    const bool isUnsigned = type.kind() == 'u';
    switch (type.itemsize()) {
        case 1:
            return isUnsigned ? IntegerType::UInt8 : IntegerType::Int8;
        case 2:
            return isUnsigned ? IntegerType::UInt16 : IntegerType::Int16;
        case 4:
            return isUnsigned ? IntegerType::UInt32 : IntegerType::Int32;
        default:
            return isUnsigned ? IntegerType::UInt64 : IntegerType::Int64;
    }
}

/// Returns the integers of an array. Unsigned 64-bit integers keep their bits.
std::vector<std::int64_t> entriesOf(const py::array& array) {
    const auto copied = [](const auto& wide) {
        if (!wide) throw py::error_already_set();
        return std::vector<std::int64_t>(wide.data(), wide.data() + wide.size());
    };
    return array.dtype().kind() == 'u'
               ? copied(py::array_t<std::uint64_t, kReadable>::ensure(array))
               : copied(py::array_t<std::int64_t, kReadable>::ensure(array));
}

/// Builds the complex of cells: an array (C, 4), (C, 5), (C, 6) or (C, 8) of standard cells, or a
/// list of cells that are each 4, 5, 6 or 8 vertices or a list of loops. \throws Error naming the
/// first cell that is neither; TopologyError as far::ComplexBuilder
far::CellComplex complexOfCells(Index vertexCount, const py::object& cells) {
    far::ComplexBuilder builder(3, vertexCount);
    if (const auto rows = indexRows(cells, "cells", "(C, 4), (C, 5), (C, 6) or (C, 8)")) {
        const auto kind = standardCell(rows->length());
        if (!kind) refuseCell("cells", rows->length());
        return withoutGil([&] {
            for (std::size_t i = 0; i < rows->count(); ++i) builder.addCell(*kind, (*rows)[i]);
            return builder.build();
        });
    }
    const auto list = sequenceOf(cells, "cells", "an array or a list of cells");
    for (std::size_t i = 0; i < list.size(); ++i) {
        const std::string name = concat("cells[", i, "]");
        addCell(builder, sequenceOf(list[i], name, "a list of vertices or of loops"), name);
    }
    return withoutGil([&] { return builder.build(); });
}

/// Builds the complex of faces: an array (F, k), or a list of loops.
far::CellComplex complexOfFaces(Index vertexCount, const py::object& faces) {
    far::ComplexBuilder builder(2, vertexCount);
    if (const auto rows = indexRows(faces, "faces", "(F, k)"))
        return withoutGil([&] {
            for (std::size_t i = 0; i < rows->count(); ++i) builder.addFace((*rows)[i]);
            return builder.build();
        });
    const auto list = sequenceOf(faces, "faces", "an array or a list of loops");
    for (std::size_t i = 0; i < list.size(); ++i)
        builder.addFace(toIndices(list[i], concat("faces[", i, "]")));
    return withoutGil([&] { return builder.build(); });
}

/// Splits a dictionary from names to arrays (V,) or (V, k) into attributes, for arrays of real
/// numbers, and integers, for arrays of integers.
VertexArrays vertexArraysOf(const py::dict& arrays, std::size_t vertexCount) {
    VertexArrays result;
    for (const auto& [key, value] : arrays) {
        if (!py::isinstance<py::str>(key))
            throw Error("attributes: expected names that are str, got " + typeName(key));
        const auto attribute = nameOfStr(py::reinterpret_borrow<py::str>(key));
        const std::string name = "attributes[\"" + printable(attribute) + "\"]";
        if (attribute.starts_with(kReservedNames))
            throw Error(name + ": names that begin with \"" + std::string(kReservedNames) +
                        "\" are reserved for marks in files; choose another name");
        if (const auto integers = py::array::ensure(value); integers && isOfIntegers(integers)) {
            const int components = componentsOf(integers, name, vertexCount);
            result.integers.push_back(
                {attribute, components, integerType(integers.dtype()), entriesOf(integers)});
            continue;
        }
        const auto array = realArray<double>(value, name);
        const int components = componentsOf(array, name, vertexCount);
        result.attributes.push_back(
            {attribute, components, {array.data(), array.data() + array.size()}});
    }
    return result;
}

/// Returns marks that have been checked against the complex.
far::Marks marksOf(const far::CellComplex& complex, const EdgeSharpness& edges,
                   const VertexSharpness& vertices, std::vector<Index> holes) {
    far::Marks marks;
    for (const auto& [ends, sharpness] : edges) {
        const auto& [a, b] = ends;
        // If both directions were allowed, it would be arbitrary which of the two values counts.
        if (a < b && edges.contains({b, a}))
            throw Error(concat("edge_sharpness: the edge of vertices ", a, " and ", b,
                               " is given twice, once in each direction"));
        marks.edges.push_back({{a, b}, sharpness});
    }
    for (const auto& [vertex, sharpness] : vertices) marks.vertices.push_back({vertex, sharpness});
    marks.holes = std::move(holes);
    withoutGil([&] {
        far::readMarks(complex, marks);
        if (!marks.holes.empty()) far::readHoles(complex, marks);
    });
    return marks;
}

/// A lattice never changes after it has been made, so any number of threads may read it.
using LatticePointer = std::shared_ptr<Lattice>;

struct Extras {
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
                           const Extras& extras) {
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

/// Returns texture coordinates that fit a mesh.
/// \param corners an array (F, k), or a list with the values at the corners of each face
FaceVaryingAttribute texturesOf(const far::CellComplex& mesh, const ArrayLike& coordinates,
                                const py::object& corners) {
    const auto values = realArray<double>(coordinates, "texture_coordinates");
    if (values.ndim() != 2 || values.shape(1) != 2)
        throw Error("texture_coordinates: expected an array of shape (T, 2), got " +
                    shapeText(values));
    FaceVaryingAttribute result{2, {values.data(), values.data() + values.size()}, {}};
    const auto rows = indexRows(corners, "texture_corners", "(F, k)");
    const auto list =
        rows ? py::sequence() : sequenceOf(corners, "texture_corners", "an array or a list");
    const std::size_t count = rows ? rows->count() : list.size();
    const far::Incidence& loops = *withoutGil([&] { return &mesh.relation(2, 0); });
    if (count != static_cast<std::size_t>(mesh.count(2)))
        throw Error(concat("texture_corners: expected one entry for each of the ", mesh.count(2),
                           " faces, got ", count));
    for (Index face = 0; face < mesh.count(2); ++face) {
        const std::string name = concat("texture_corners[", face, "]");
        const auto ofFace = rows ? std::vector<Index>((*rows)[face].begin(), (*rows)[face].end())
                                 : toIndices(list[face], name);
        const std::size_t cornerCount = loops[face].size();
        if (ofFace.size() != cornerCount)
            throw Error(concat(name, ": expected ", cornerCount,
                               " values, one for each corner, got ", ofFace.size()));
        for (const Index value : ofFace)
            if (value < 0 || value >= values.shape(0))
                throw Error(concat(name, ": names ", value, "; there are ", values.shape(0),
                                   " texture coordinates"));
        result.corners.insert(result.corners.end(), ofFace.begin(), ofFace.end());
    }
    return result;
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
            "Writes a lattice (.ovm, .vtu, .vtk), or a mesh or a curve (.obj). An existing file is "
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
        "Reads a Lattice from .ovm, .vtu or .vtk, or from the mesh of a simulation (.msh, .mesh, "
        ".su2, "
        ".xyz, an OpenFOAM case), or a mesh or a curve from .obj. Vertices in no "
        "cell of a lattice, or no line of a curve, are dropped with a UserWarning; the vertices "
        "after them get lower numbers.");
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
        "a lattice (.ovm, .vtu, .vtk) with the same topology, or an editor mesh (.obj, .ply): one "
        "point "
        "per vertex, in the order of the vertices, and faces that are faces of the lattice. "
        "Lattice.write_editor_mesh() writes an editor mesh.");
}

}  // namespace espalier::python
