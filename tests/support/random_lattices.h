// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <espalier/far/strata.h>
#include <espalier/shapes/attach.h>
#include <espalier/shapes/inventory.h>
#include <espalier/shapes/solids.h>

#include <array>
#include <numeric>
#include <string>
#include <utility>
#include <vector>

#include "support/polyhedra.h"
#include "support/random_marks.h"
#include "support/zoo.h"

namespace espalier::test {

/// Marks some edges and vertices of a lattice as sharp or semi-sharp, mostly on the surface, and
/// some as smooth where the topology allows it.
inline void markRandomly(Lattice& lattice, far::Creasing creasing, Draws& draws) {
    // Without boundary control, only the topology makes entities sharp.
    const far::Strata forced =
        far::classify(lattice.complex, far::Boundary::Open, far::SharpEdges::SingleCell, {});
    const auto choose = [&](int dimension, auto smoothen) {
        std::vector<Index> chosen;
        for (Index index = 0; index < lattice.complex.count(dimension); ++index) {
            const bool isOnSurface = forced.smoothStratum({dimension, index}) == 2;
            const bool isForced = forced.sharpness({dimension, index}) > far::kSmooth;
            const Index draw = draws.below(isOnSurface ? 12 : 24);
            if (draw < 2)
                chosen.push_back(index);
            else if (draw == 2 && !isForced)
                smoothen(index);
        }
        draws.shuffle(chosen);
        return chosen;
    };
    const std::vector<Index> edges = choose(1, [&](Index edge) {
        const auto ends = lattice.complex.relation(1, 0)[edge];
        lattice.marks.edges.push_back({{ends[0], ends[1]}, far::kSmooth});
    });
    const std::vector<Index> vertices = choose(0, [&](Index vertex) {
        lattice.marks.vertices.push_back({vertex, far::kSmooth});
    });
    addRandomSharpness(lattice, edges, vertices, creasing, draws);
    lattice.tags.creasing = creasing;
}

/// Returns a lattice of a few polyhedra (one to six, or more if they cannot be merged): hexahedra,
/// tetrahedra, pyramids, wedges and unions of these, with faces of three to seven and more sides,
/// cells of types 2 to 6 and more, and cells that touch in an edge or a vertex. Three in four have
/// marks, and one in four has Boundary::EdgeOnly. The lattice depends only on the seed, on every
/// platform.
inline Lattice randomLattice(unsigned seed) {
    Draws draws(seed);
    std::array<Index, 3> n;
    n[0] = 2 + draws.below(2);
    n[1] = 1 + draws.below(3);
    n[2] = 1 + draws.below(2);
    Polyhedra polyhedra(n, draws);
    const Index target = 1 + draws.below(6);
    polyhedra.mergeCells(target, draws);
    for (Index times = draws.below(4); times > 0; --times) polyhedra.mergeFaces(draws);
    Lattice lattice = polyhedra.lattice();
    const bool isUniform = draws.oneIn(2);
    if (seed % 4 != 0)
        markRandomly(lattice, isUniform ? far::Creasing::Uniform : far::Creasing::Chaikin, draws);
    if (seed % 4 == 1) lattice.tags.boundary = far::Boundary::EdgeOnly;
    return lattice;
}

/// Returns a bipyramid with a prism on one side and a pyramid on the opposite side. Four or `sides`
/// faces of a cell meet at its vertices.
inline Lattice extendedBipyramid(int sides) {
    Lattice lattice = shapes::bipyramid({.sides = sides, .height = 2});
    const auto middleOf = [&](Index face) {
        Point3 middle = {0, 0, 0};
        const auto loop = lattice.complex.relation(2, 0)[face];
        for (const Index vertex : loop)
            for (std::size_t c = 0; c < 3; ++c)
                middle[c] += lattice.positions[vertex][c] / double(loop.size());
        return middle;
    };
    // The bipyramid is centred at the origin, so the middle of a side points outwards. The opposite
    // side is the one whose middle is farthest in the opposite direction.
    const Point3 outward = middleOf(0);
    Index opposite = 0;
    double least = 1;
    for (Index face = 0; face < lattice.complex.count(2); ++face) {
        const Point3 middle = middleOf(face);
        const double along = std::inner_product(middle.begin(), middle.end(), outward.begin(), 0.0);
        if (along >= least) continue;
        least = along;
        opposite = face;
    }
    Point3 apex = middleOf(opposite);
    for (double& x : apex) x *= 2.5;
    lattice = shapes::attachPyramid(lattice, FaceId(opposite), apex);
    return shapes::attachPrism(lattice, FaceId(0), outward);
}

/// Returns lattices with surface features that zoo() does not have: cells of types 4, 5 and 6 with
/// neighbours, semi-sharp features, darts.
inline std::vector<NamedLattice> featureLattices() {
    std::vector<NamedLattice> all;
    const auto add = [&](const std::string& name, Lattice lattice, far::Marks marks = {}) {
        lattice.marks = std::move(marks);
        lattice.tags.creasing = far::Creasing::Uniform;
        all.push_back({name, lattice});
        if (lattice.marks.empty()) return;
        lattice.tags.creasing = far::Creasing::Chaikin;
        all.push_back({name + ", Chaikin", std::move(lattice)});
    };
    for (const int sides : {4, 5, 6})
        add("bipyramid of " + std::to_string(sides) + " sides with neighbours",
            extendedBipyramid(sides));

    const std::array<Index, 3> n = {2, 2, 2};
    const Lattice box = shapes::box({.cells = {2, 2, 2}});
    const auto at = [&](Index i, Index j, Index k) { return gridVertex(n, i, j, k); };
    const Index side = at(1, 1, 0), inside = at(1, 1, 1);
    for (const double sharpness : {10.0, 2.7, 0.4}) {
        const std::string text = " of sharpness " + std::to_string(sharpness).substr(0, 4);
        add("box with a dart" + text, box, {.edges = {{{at(1, 0, 0), side}, sharpness}}});
        add("box with a sharp edge inside" + text, box, {.edges = {{{inside, side}, sharpness}}});
        // A crease across a side, and a sharp vertex inside the lattice.
        add("box with a crease and a vertex inside" + text, box,
            {.edges = {{{at(1, 0, 0), side}, sharpness}, {{side, at(1, 2, 0)}, 1.2}},
             .vertices = {{inside, sharpness}}});
    }
    // All entities that are sharp by rule are marked semi-sharp, and some smooth.
    const far::Strata strata =
        far::classify(box.complex, far::Boundary::Sharp, far::SharpEdges::SingleCell, {});
    far::Marks semiSharp, partlySmooth;
    for (Index edge = 0; edge < box.complex.count(1); ++edge) {
        if (strata.of({1, edge}) != 1) continue;
        const auto ends = box.complex.relation(1, 0)[edge];
        semiSharp.edges.push_back({{ends[0], ends[1]}, 2.5});
        partlySmooth.edges.push_back({{ends[0], ends[1]}, edge % 3 == 0 ? far::kSmooth : 1.25});
    }
    for (Index vertex = 0; vertex < box.complex.count(0); ++vertex)
        if (strata.sharpness({0, vertex}) > far::kSmooth) {
            semiSharp.vertices.push_back({vertex, 1.5});
            partlySmooth.vertices.push_back({vertex, vertex % 2 == 0 ? far::kSmooth : 0.5});
        }
    add("semi-sharp box", box, semiSharp);
    add("partly smooth box", box, partlySmooth);

    // The edge at the inner corner of an L, and the three edges that meet inside a tripod.
    const auto isInL = [](Index i, Index j, Index) { return i == 0 || j == 0; };
    const auto isInTripod = [](Index i, Index j, Index k) { return i + j + k <= 1; };
    const auto isInRing = [](Index i, Index j, Index) { return i != 1 || j != 1; };
    const auto sharpened = [](Lattice lattice, double sharpness) {
        const far::Strata rule =
            far::classify(lattice.complex, far::Boundary::Sharp, far::SharpEdges::SingleCell, {});
        for (Index edge = 0; edge < lattice.complex.count(1); edge += 2) {
            if (rule.sharpness({1, edge}) == far::kSmooth) continue;
            const auto ends = lattice.complex.relation(1, 0)[edge];
            lattice.marks.edges.push_back({{ends[0], ends[1]}, sharpness});
        }
        return lattice.marks;
    };
    const Lattice thickL = carvedGrid({2, 2, 2}, isInL), tripod = carvedGrid({2, 2, 2}, isInTripod),
                  ring = carvedGrid({3, 3, 2}, isInRing);
    add("L of two layers", thickL);
    add("ring of two layers", ring);
    add("semi-sharp L", thickL, sharpened(thickL, 2.25));
    add("semi-sharp tripod", tripod, sharpened(tripod, 1.75));
    add("semi-sharp ring", ring, sharpened(ring, 0.75));
    return someOf(std::move(all));
}

}  // namespace espalier::test
