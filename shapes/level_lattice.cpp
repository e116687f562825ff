// SPDX-License-Identifier: Apache-2.0
#include <espalier/base/error.h>
#include <espalier/shapes/level_lattice.h>

#include <string>
#include <utility>

namespace espalier {
namespace {

/// Adds marks for vertices that were marked by hand and are still sharp. marksFor() omits marks
/// that the boundary mode implies, but the new lattice may be refined under another mode.
void keepCorners(const far::TopologyRefiner& refiner, int level, far::Marks& marks) {
    if (refiner.boundary() == far::Boundary::Open) return;
    std::vector<bool> isMarked(refiner.level(level).complex.count(0));
    for (const far::Marks::Vertex& mark : marks.vertices) isMarked[mark.vertex] = true;
    for (const far::Marks::Vertex& mark : refiner.options().marks.vertices) {
        // The vertex points of a level keep the numbers of their vertices.
        const float sharpness = refiner.level(level).strata.sharpness({0, mark.vertex});
        if (sharpness > far::kSmooth && !isMarked[mark.vertex])
            marks.vertices.push_back({mark.vertex, sharpness});
    }
}

}  // namespace

Lattice levelLattice(const far::TopologyRefiner& refiner, int level,
                     std::vector<Point3> positions) {
    const auto& [complex, strata, holes] = refiner.level(level);
    if (std::ssize(positions) != complex.count(0))
        throw Error(concat("level ", level, " has ", complex.count(0), " vertices, but there are ",
                           positions.size(), " positions"));
    const far::RefinerOptions& used = refiner.options();
    Lattice lattice{complex, std::move(positions), {}, {}};
    // Files of meshes and curves store the boundary mode; files of lattices store only marks.
    const bool hasTags = complex.dimension() < kMaxDimension;
    lattice.marks = far::marksFor(
        complex, strata,
        hasTags || used.boundary == far::Boundary::Open ? used.boundary : far::Boundary::Sharp);
    keepCorners(refiner, level, lattice.marks);
    lattice.marks.holes = holes;
    if (hasTags) lattice.tags = {used.boundary, used.creasing, used.triangles};
    return lattice;
}

std::vector<VertexIntegers> levelIntegers(const far::TopologyRefiner& refiner, int level,
                                          std::span<const VertexIntegers> integers) {
    const std::size_t vertexCount = refiner.level(level).complex.count(0);
    const std::size_t baseCount = refiner.level(0).complex.count(0);
    std::vector<VertexIntegers> result(integers.begin(), integers.end());
    for (auto& [name, components, type, values] : result) {
        const std::size_t width = components;
        if (components < 1 || values.size() != baseCount * width)
            throw Error(concat("the integers ", inQuotes(name), " have ", values.size(),
                               " values; expected ", components, " for each of the ", baseCount,
                               " vertices of level 0"));
        // The vertex points of a level keep the numbers of their vertices, and come first.
        values.resize(vertexCount * width, noInteger(type));
    }
    return result;
}

}  // namespace espalier
