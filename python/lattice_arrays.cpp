// SPDX-License-Identifier: Apache-2.0
#include "lattice_arrays.h"

#include <espalier/base/error.h>
#include <espalier/base/printable.h>
#include <espalier/far/complex_builder.h>

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>

#include "arrays.h"
#include "names.h"

namespace espalier::python {
namespace {

using far::StandardCell;

/// How io/lattices/lattice_parts.h names what a lattice has besides its attributes, in a file of
/// these.
constexpr std::string_view kReservedNames = "espalier:";

std::optional<StandardCell> standardCell(std::size_t vertexCount) {
    for (const auto cell : {StandardCell::Tetrahedron, StandardCell::Pyramid, StandardCell::Wedge,
                            StandardCell::Hexahedron})
        if (static_cast<std::size_t>(far::vertexCount(cell)) == vertexCount) return cell;
    return std::nullopt;
}

py::sequence sequenceOf(const py::handle& object, const std::string& name,
                        const std::string& expected) {
    if (!py::isinstance<py::sequence>(object) || py::isinstance<py::str>(object))
        throw Error(name + ": expected " + expected + ", got " + typeName(object));
    return py::reinterpret_borrow<py::sequence>(object);
}

[[noreturn]] void refuseCell(const std::string& name, std::size_t vertexCount) {
    throw Error(name +
                ": expected the 4, 5, 6 or 8 vertices of a tetrahedron, pyramid, wedge or "
                "hexahedron, or loops of vertices, got " +
                std::to_string(vertexCount) + " vertices");
}

/// The rows of a two-dimensional array of integers.
struct IndexRows {
    py::array_t<Index> array;
    std::size_t count() const { return static_cast<std::size_t>(array.shape(0)); }
    std::size_t length() const { return static_cast<std::size_t>(array.shape(1)); }
    std::span<const Index> operator[](std::size_t row) const {
        return {array.data() + row * length(), length()};
    }
};

std::optional<IndexRows> rowsOf(const py::object& object, const std::string& name,
                                const std::string& expected) {
    if (!py::isinstance<py::array>(object)) return std::nullopt;
    IndexRows rows{indexArray(object, name)};
    if (rows.array.ndim() != 2)
        throw Error(name + ": expected an array of shape " + expected + ", got " +
                    shapeText(rows.array));
    return rows;
}

/// Whether each entry of a cell is a list, or an array, in its turn.
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
        loops.push_back(toIndices(cell[i], name + "[" + std::to_string(i) + "]"));
    builder.addCell(loops);
}

/// The numbers that each vertex has in an array (V,) or (V, k).
int componentsOf(const py::array& array, const std::string& name, std::size_t vertexCount) {
    const bool fits = (array.ndim() == 1 || (array.ndim() == 2 && array.shape(1) > 0)) &&
                      static_cast<std::size_t>(array.shape(0)) == vertexCount;
    if (!fits)
        throw Error(name + ": expected an array of shape (" + std::to_string(vertexCount) +
                    ",) or (" + std::to_string(vertexCount) + ", k), got " + shapeText(array));
    return array.ndim() == 1 ? 1 : static_cast<int>(array.shape(1));
}

bool isOfIntegers(const py::array& array) {
    return array.dtype().kind() == 'i' || array.dtype().kind() == 'u';
}

/// In any order of their bytes.
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

/// Of integers of 64 bits without sign the bits.
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
    if (const auto rows = rowsOf(cells, "cells", "(C, 4), (C, 5), (C, 6) or (C, 8)")) {
        const auto kind = standardCell(rows->length());
        if (!kind) refuseCell("cells", rows->length());
        return withoutGil([&] {
            for (std::size_t i = 0; i < rows->count(); ++i) builder.addCell(*kind, (*rows)[i]);
            return builder.build();
        });
    }
    const auto list = sequenceOf(cells, "cells", "an array or a list of cells");
    for (std::size_t i = 0; i < list.size(); ++i) {
        const std::string name = "cells[" + std::to_string(i) + "]";
        addCell(builder, sequenceOf(list[i], name, "a list of vertices or of loops"), name);
    }
    return withoutGil([&] { return builder.build(); });
}

far::CellComplex complexOfFaces(Index vertexCount, const py::object& faces) {
    far::ComplexBuilder builder(2, vertexCount);
    if (const auto rows = rowsOf(faces, "faces", "(F, k)"))
        return withoutGil([&] {
            for (std::size_t i = 0; i < rows->count(); ++i) builder.addFace((*rows)[i]);
            return builder.build();
        });
    const auto list = sequenceOf(faces, "faces", "an array or a list of loops");
    for (std::size_t i = 0; i < list.size(); ++i)
        builder.addFace(toIndices(list[i], "faces[" + std::to_string(i) + "]"));
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
                        "\" are reserved, for what files of lattices hold besides attributes");
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
        // Which of them were to count would be chance.
        if (a < b && edges.contains({b, a}))
            throw Error("edge_sharpness: the edge of vertices " + std::to_string(a) + " and " +
                        std::to_string(b) + " is there twice, in both directions");
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

}  // namespace espalier::python
