// SPDX-License-Identifier: Apache-2.0
#include <espalier/shapes/remove_cells.h>

#include <cstddef>
#include <string>
#include <vector>

#include "cell_loops.h"
#include "checks.h"

namespace espalier::shapes {
namespace {

/// Keeps the values of the vertices that remain, `components` for each.
/// \param newVertex the new number of each vertex; kMaxIndex for a vertex that is removed
template <class Value>
void keepValues(std::span<const Index> newVertex, std::size_t components,
                std::vector<Value>& values) {
    std::size_t to = 0;
    for (std::size_t vertex = 0; vertex < newVertex.size(); ++vertex)
        if (newVertex[vertex] != kMaxIndex)
            for (std::size_t i = 0; i < components; ++i)
                values[to++] = values[vertex * components + i];
    values.resize(to);
}

/// Returns the marks of the vertices and edges that `complex`, the new lattice, still has.
far::Marks keptMarks(std::span<const Index> newVertex, const far::CellComplex& complex,
                     const far::Marks& marks) {
    const auto isEdge = [&](Index a, Index b) {
        for (const Index edge : complex.relation(0, 1)[a])
            if (far::contains(complex.relation(1, 0)[edge], b)) return true;
        return false;
    };
    far::Marks result;
    for (const auto& mark : marks.edges) {
        const Index a = newVertex[mark.vertices[0]], b = newVertex[mark.vertices[1]];
        if (a != kMaxIndex && b != kMaxIndex && isEdge(a, b))
            result.edges.push_back({{a, b}, mark.sharpness});
    }
    for (const auto& mark : marks.vertices)
        if (newVertex[mark.vertex] != kMaxIndex)
            result.vertices.push_back({newVertex[mark.vertex], mark.sharpness});
    return result;
}

}  // namespace

Lattice removeCells(const Lattice& lattice, std::span<const Index> cells) {
    requireConsistent("removeCells", "the lattice", lattice, 3);
    const far::CellComplex& complex = lattice.complex;
    std::vector<bool> isRemoved(complex.count(3));
    for (const Index cell : cells) {
        if (cell < 0 || cell >= complex.count(3))
            throw ArgumentError("removeCells", "cells", std::to_string(cell),
                                concat("0 to ", complex.count(3) - 1));
        isRemoved[cell] = true;
    }

    far::ComplexBuilder builder(3, complex.count(0));
    bool isEmpty = true;
    for (Index cell = 0; cell < complex.count(3); ++cell) {
        if (isRemoved[cell]) continue;
        builder.addCell(far::outwardLoops(complex, CellId(cell)));
        isEmpty = false;
    }
    if (isEmpty) throw Error("no cell would remain; a lattice has one cell or more");

    std::vector<Index> newVertex(complex.count(0));
    for (const Index vertex : builder.dropUnusedVertices()) newVertex[vertex] = kMaxIndex;
    Index next = 0;
    for (Index& vertex : newVertex)
        if (vertex != kMaxIndex) vertex = next++;

    Lattice result = lattice;
    result.complex = builder.build();
    result.marks = keptMarks(newVertex, result.complex, lattice.marks);
    keepValues(newVertex, 1, result.positions);
    for (auto& attribute : result.attributes)
        keepValues(newVertex, attribute.components, attribute.values);
    for (auto& integers : result.integers)
        keepValues(newVertex, integers.components, integers.values);
    return result;
}

}  // namespace espalier::shapes
