// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <espalier/far/topology_refiner.h>
#include <espalier/shapes/inventory.h>
#include <espalier/shapes/lattice.h>
#include <espalier/shapes/merge.h>
#include <espalier/shapes/solids.h>

#include <algorithm>
#include <map>
#include <numbers>
#include <random>
#include <string>
#include <vector>

#include "support/complexes.h"
#include "support/sanitizers.h"

namespace espalier::test {

struct NamedLattice {
    std::string name;
    Lattice lattice;
};

/// Returns the positions of a grid with spacing 1, from 0 to its number of cells.
inline std::vector<Point3> gridPositions(const std::array<Index, 3>& n) {
    std::vector<Point3> positions;
    for (Index k = 0; k <= n[2]; ++k)
        for (Index j = 0; j <= n[1]; ++j)
            for (Index i = 0; i <= n[0]; ++i)
                positions.push_back({double(i), double(j), double(k)});
    return positions;
}

/// Returns a grid without some of its cells.
template <class IsThere>
Lattice carvedGrid(const std::array<Index, 3>& n, IsThere isThere) {
    far::ComplexBuilder builder(3);
    std::map<Index, Index> names;
    const std::vector<Point3> all = gridPositions(n);
    std::vector<Point3> positions;
    for (Index k = 0; k < n[2]; ++k)
        for (Index j = 0; j < n[1]; ++j)
            for (Index i = 0; i < n[0]; ++i) {
                if (!isThere(i, j, k)) continue;
                auto cell = gridCell(n, i, j, k);
                for (Index& vertex : cell) {
                    if (names.count(vertex) == 0) {
                        names[vertex] = builder.addVertex();
                        positions.push_back(all[vertex]);
                    }
                    vertex = names[vertex];
                }
                builder.addCell(far::StandardCell::Hexahedron, cell);
            }
    return {builder.build(), positions, {}, {}};
}

/// Returns mixedCells() with positions.
inline Lattice mixedLattice() {
    return {mixedCells(),
            {{0, 0, 0},
             {1, 0, 0},
             {1, 1, 0},
             {0, 1, 0},
             {0, 0, 1},
             {1, 0, 1},
             {1, 1, 1},
             {0, 1, 1},
             {0.5, 0.5, 1.8},
             {2, 0, 0},
             {2, 1, 0},
             {1.7, -0.9, 0.4}},
            {},
            {}};
}

/// Returns lattices of every kind: regular, with cells of types 3 to 6, thin, L-shaped,
/// ring-shaped, with notches, in pieces that touch in an edge or a vertex, with marks.
inline std::vector<NamedLattice> zoo() {
    std::vector<NamedLattice> all;
    const auto add = [&](const std::string& name, Lattice lattice) {
        all.push_back({name, std::move(lattice)});
    };
    add("cube", shapes::box());
    add("bar", shapes::box({.cells = {3, 1, 1}}));
    add("box", shapes::box({.cells = {3, 2, 4}}));
    add("cylinder", shapes::cylinder({.sectors = 6}));
    add("cylinder with rings", shapes::cylinder({.sectors = 5, .pattern = {2}, .layers = 2}));
    add("torus", shapes::torus());
    add("star", shapes::star());
    add("barbell", shapes::barbell());
    add("arm", shapes::arm({.sides = 5}));
    add("tetrahedron", shapes::tetrahedron());
    add("octahedron", shapes::octahedron());
    add("icosahedron", shapes::icosahedron());
    add("dodecahedron", shapes::dodecahedron());
    add("bipyramid", shapes::bipyramid({.sides = 6}));
    add("mixed cells", mixedLattice());
    add("L", carvedGrid({2, 2, 1}, [](Index i, Index j, Index) { return i == 0 || j == 0; }));
    add("tripod", carvedGrid({2, 2, 2}, [](Index i, Index j, Index k) { return i + j + k <= 1; }));
    add("square ring",
        carvedGrid({3, 3, 1}, [](Index i, Index j, Index) { return i != 1 || j != 1; }));
    add("hollow", carvedGrid({3, 3, 3},
                             [](Index i, Index j, Index k) { return i != 1 || j != 1 || k != 1; }));
    add("edge contact", carvedGrid({2, 2, 1}, [](Index i, Index j, Index) { return i == j; }));
    add("vertex contact",
        carvedGrid({2, 2, 2}, [](Index i, Index j, Index k) { return i == j && j == k; }));
    Lattice marked = shapes::box({.cells = {2, 2, 2}});
    const Index middle = gridVertex({2, 2, 2}, 1, 1, 0), centre = gridVertex({2, 2, 2}, 1, 1, 1);
    marked.marks = {.edges = {{{0, 1}, far::kSmooth},
                              {{1, middle}, far::kInfinitelySharp},
                              {{middle, centre}, far::kInfinitelySharp}},
                    .vertices = {{26, far::kInfinitelySharp}, {0, far::kSmooth}}};
    add("marked box", marked);
    return someOf(std::move(all));
}

/// Returns for each level the vertex of `second` that corresponds to each vertex of `first`, given
/// the correspondence at level 0. Entities correspond if their vertices do.
inline std::vector<std::vector<Index>> matchLevels(const far::TopologyRefiner& first,
                                                   const far::TopologyRefiner& second,
                                                   std::vector<Index> base) {
    std::vector<std::vector<Index>> maps = {std::move(base)};
    for (int level = 1; level <= first.maxLevel(); ++level) {
        const auto keyOf = [&](const CellComplex& complex, Entity entity, bool rename) {
            const auto row = complex.relation(entity.dimension, 0)[entity.index];
            std::vector<Index> key(row.begin(), row.end());
            if (rename)
                for (Index& vertex : key) vertex = maps.back()[vertex];
            std::sort(key.begin(), key.end());
            key.push_back(entity.dimension);
            return key;
        };
        std::map<std::vector<Index>, Index> children;
        const CellComplex& secondParent = second.level(level - 1).complex;
        for (Index v = 0; v < second.level(level).complex.count(0); ++v)
            children[keyOf(secondParent, second.refinement(level).parentOf({0, v}).upper, false)] =
                v;
        std::vector<Index> map;
        const CellComplex& firstParent = first.level(level - 1).complex;
        for (Index v = 0; v < first.level(level).complex.count(0); ++v)
            map.push_back(children.at(
                keyOf(firstParent, first.refinement(level).parentOf({0, v}).upper, true)));
        maps.push_back(std::move(map));
    }
    return maps;
}

}  // namespace espalier::test
