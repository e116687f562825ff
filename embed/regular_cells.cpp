// SPDX-License-Identifier: Apache-2.0
#include <espalier/base/sort_unique.h>
#include <espalier/embed/regular_cells.h>
#include <espalier/far/standard_cells.h>

#include <algorithm>
#include <array>
#include <span>

namespace espalier::embed {
namespace {

/// Returns the stratum of an entity of a grid that is in `cells` cells; −1 for numbers that a grid
/// does not have.
int stratumOf(std::size_t cells, int dimension) {
    for (int stratum = 3; stratum >= dimension; --stratum)
        if (cells == std::size_t{1} << (stratum - dimension)) return stratum;
    return -1;
}

/// \param cells the cells of each entity of this dimension
bool isPlain(const far::Level& level, const far::Incidence& cells, const Entity& entity) {
    const bool fades = entity.dimension < 2 && far::isSemiSharp(level.strata.sharpness(entity));
    return !fades && !level.strata.isOpen(entity) &&
           level.strata.of(entity) == stratumOf(cells[entity.index].size(), entity.dimension);
}

}  // namespace

bool isRegularVertex(const far::Level& level, Index vertex) {
    return isRegularVertex(level, vertex, [&](Index cell) {
        return far::hexahedronVertices(level.complex, CellId(cell)).has_value();
    });
}

bool isRegularVertex(const far::Level& level, Index vertex, FunctionRef<bool(Index)> isHexahedron) {
    const far::CellComplex& complex = level.complex;
    const auto edges = complex.relation(0, 1)[vertex];
    const far::Incidence& cells = complex.relation(0, 3);
    const std::size_t stratum = level.strata.of({0, vertex});
    if (!isPlain(level, cells, {0, vertex}) || edges.size() != 3 + stratum) return false;
    for (const int dimension : {1, 2}) {
        const far::Incidence& cellsOf = complex.relation(dimension, 3);
        for (const Index index : complex.relation(0, dimension)[vertex])
            if (!isPlain(level, cellsOf, {dimension, index})) return false;
    }
    // In a loop of two cells, both neighbours along the loop are the same vertex: not a grid.
    std::array<Index, 6> ends = {};
    std::size_t count = 0;
    for (const Index edge : edges) {
        const auto both = complex.relation(1, 0)[edge];
        ends[count++] = both[0] == vertex ? both[1] : both[0];
    }
    return !repeatedIn(std::span(ends).first(count)) &&
           std::all_of(cells[vertex].begin(), cells[vertex].end(), isHexahedron);
}

bool isRegularCell(const far::Level& level, Index cell) {
    const auto vertices = level.complex.relation(3, 0)[cell];
    return std::all_of(vertices.begin(), vertices.end(),
                       [&](Index vertex) { return isRegularVertex(level, vertex); });
}

bool remainsInLimit(const far::Level& level, Index cell) {
    const auto vertices = level.complex.relation(3, 0)[cell];
    return std::any_of(vertices.begin(), vertices.end(), [&](Index vertex) {
        return !level.strata.isOpen({0, vertex});
    });
}

}  // namespace espalier::embed
