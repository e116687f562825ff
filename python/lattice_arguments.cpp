// SPDX-License-Identifier: Apache-2.0
#include "lattice_arguments.h"

#include <espalier/base/printable.h>
#include <espalier/far/complex_builder.h>

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <utility>

namespace espalier::python {
namespace {

using far::StandardCell;

/// Files store marks under names that begin so (io/lattices/lattice_parts.h).
constexpr std::string_view kReservedNames = "espalier:";

std::optional<StandardCell> standardCell(std::size_t vertexCount) {
    for (const auto cell : {StandardCell::Tetrahedron, StandardCell::Pyramid, StandardCell::Wedge,
                            StandardCell::Hexahedron})
        if (std::cmp_equal(far::vertexCount(cell), vertexCount)) return cell;
    return std::nullopt;
}

[[noreturn]] void refuseCell(const std::string& name, std::size_t vertexCount) {
    throw Error(concat(name,
                       ": expected the 4, 5, 6 or 8 vertices of a tetrahedron, pyramid, wedge or "
                       "hexahedron, or loops of vertices, got ",
                       vertexCount, " vertices"));
}

/// A cell lists either loops (lists or arrays) or vertex numbers. Returns true if it lists loops.
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
                      std::cmp_equal(array.shape(0), vertexCount);
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

}  // namespace

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
    if (std::cmp_not_equal(count, mesh.count(2)))
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

}  // namespace espalier::python
