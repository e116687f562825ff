// SPDX-License-Identifier: Apache-2.0
#include <espalier/embed/regular_cells.h>
#include <espalier/far/standard_cells.h>

#include <algorithm>
#include <vector>

namespace espalier::embed {
namespace {

/// Returns the stratum of an entity of a grid that is in `cells` cells; −1 for numbers that a grid
/// does not have.
int stratumOf(std::size_t cells, int dimension) {
    for (int stratum = 3; stratum >= dimension; --stratum)
        if (cells == std::size_t{1} << (stratum - dimension)) return stratum;
    return -1;
}

bool isPlain(const far::Level& level, const Entity& entity) {
    const auto cells = level.complex.relation(entity.dimension, 3)[entity.index].size();
    const bool fades = entity.dimension < 2 && far::isSemiSharp(level.strata.sharpness(entity));
    return !fades && !level.strata.isOpen(entity) &&
           level.strata.of(entity) == stratumOf(cells, entity.dimension);
}

}  // namespace

bool isRegularVertex(const far::Level& level, Index vertex) {
    const far::CellComplex& complex = level.complex;
    const auto edges = complex.relation(0, 1)[vertex];
    const auto stratum = static_cast<std::size_t>(level.strata.of({0, vertex}));
    if (!isPlain(level, {0, vertex}) || edges.size() != 3 + stratum) return false;
    for (const int dimension : {1, 2})
        for (const Index index : complex.relation(0, dimension)[vertex])
            if (!isPlain(level, {dimension, index})) return false;
    // In a loop of two cells, both neighbours along the loop are the same vertex: not a grid.
    std::vector<Index> ends;
    for (const Index edge : edges)
        for (const Index end : complex.relation(1, 0)[edge])
            if (end != vertex) ends.push_back(end);
    std::sort(ends.begin(), ends.end());
    if (std::adjacent_find(ends.begin(), ends.end()) != ends.end()) return false;
    const auto cells = complex.relation(0, 3)[vertex];
    return std::all_of(cells.begin(), cells.end(), [&](Index cell) {
        return far::hexahedronVertices(complex, CellId(cell)).has_value();
    });
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
