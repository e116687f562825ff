// SPDX-License-Identifier: Apache-2.0
#include <espalier/shapes/level_lattice.h>

#include <algorithm>
#include <utility>

namespace espalier {
namespace {

/// Adds the vertices that are marked by hand and as sharp as their mark says, though without it
/// they would be too: under another boundary mode they might not.
void keepCorners(const far::TopologyRefiner& refiner, int level, far::Marks& marks) {
    if (refiner.boundary() == far::Boundary::Open) return;
    for (const far::Marks::Vertex& mark : refiner.options().marks.vertices) {
        // The vertex points of a level keep the numbers of their vertices.
        const float sharpness = refiner.level(level).strata.sharpness({0, mark.vertex});
        const bool isThere =
            std::any_of(marks.vertices.begin(), marks.vertices.end(),
                        [&](const auto& other) { return other.vertex == mark.vertex; });
        if (sharpness > far::kSmooth && !isThere)
            marks.vertices.push_back({mark.vertex, sharpness});
    }
}

}  // namespace

Lattice levelLattice(const far::TopologyRefiner& refiner, int level,
                     std::vector<Point3> positions) {
    const auto& [complex, strata, holes] = refiner.level(level);
    const far::RefinerOptions& used = refiner.options();
    Lattice lattice{complex, std::move(positions), {}, {}};
    // A file of a mesh or a curve keeps the boundary mode; one of a lattice has marks alone.
    const bool hasTags = complex.dimension() < far::kMaxDimension;
    lattice.marks = far::marksFor(
        complex, strata,
        hasTags || used.boundary == far::Boundary::Open ? used.boundary : far::Boundary::Sharp);
    keepCorners(refiner, level, lattice.marks);
    lattice.marks.holes = holes;
    if (hasTags) lattice.tags = {used.boundary, used.creasing, used.triangles};
    return lattice;
}

}  // namespace espalier
