// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <espalier/base/disjoint_sets.h>
#include <espalier/base/vector3.h>
#include <espalier/embed/local_binding.h>
#include <espalier/far/standard_cells.h>
#include <espalier/limit/limit_binding.h>
#include <espalier/limit/limit_parts.h>
#include <espalier/limit/vertex_limits.h>
#include <espalier/shapes/refiner_options.h>
#include <espalier/solve/validity.h>
#include <espalier/stencils/composition.h>

#include <algorithm>
#include <map>
#include <ostream>
#include <span>
#include <utility>
#include <vector>

// Measures of lattices that do not use the code that makes cages.
namespace espalier::test {

/// Returns the volume of a lattice between the limits of the vertices of level 2. Its boundary
/// differs from the limit by about a hundredth of a cell.
inline double limitVolume(const Lattice& lattice) {
    far::TopologyRefiner refiner(lattice.complex, refinerOptions(lattice));
    refiner.refineUniform(2);
    const auto positions =
        stencils::applyLevelTable(limit::buildVertexLimits(refiner, 2), lattice.positions);
    const far::CellComplex& complex = refiner.level(2).complex;
    double volume = 0;
    for (Index cell = 0; cell < complex.count(3); ++cell)
        for (const auto& loop : far::outwardLoops(complex, CellId(cell)))
            for (std::size_t i = 2; i < loop.size(); ++i)
                volume +=
                    dot(positions[loop[0]], cross(positions[loop[i - 1]], positions[loop[i]])) / 6;
    return volume;
}

/// Returns the cells whose limits are not proved to have positive Jacobians.
inline std::vector<Index> badCells(const Lattice& lattice) {
    const far::TopologyRefiner refiner(lattice.complex, refinerOptions(lattice));
    return solve::ValidityCheck(limit::LimitParts(refiner, 2), lattice.positions).badAtRest();
}

/// Returns the number of points that are not inside level 3.
inline Index outsideLevel(const Lattice& lattice, std::span<const Point3> points) {
    const far::TopologyRefiner refiner(lattice.complex, refinerOptions(lattice));
    // Without a tolerance: inside means inside.
    embed::BindingOptions options;
    options.embedding.tolerance = 0;
    const auto bound = embed::bindPoints({refiner, lattice.positions}, points, options);
    return static_cast<Index>(points.size()) - bound.count(embed::PointStatus::Inside);
}

/// Returns the number of points that are not inside the limit volume.
inline Index outsideLimit(const Lattice& lattice, std::span<const Point3> points) {
    const far::TopologyRefiner refiner(lattice.complex, refinerOptions(lattice));
    const auto bound = limit::bindLimit({refiner, lattice.positions}, points);
    return static_cast<Index>(points.size()) - bound.count(embed::PointStatus::Inside);
}

/// The topology of the solid that cells fill.
struct SolidTopology {
    int components = 0;
    int handles = 0;   ///< first Betti number
    int cavities = 0;  ///< components of the boundary, less the components
    bool isManifold = true;

    friend bool operator==(const SolidTopology&, const SolidTopology&) = default;
    friend std::ostream& operator<<(std::ostream& out, const SolidTopology& t) {
        return out << t.components << " components, " << t.handles << " handles, " << t.cavities
                   << " cavities" << (t.isManifold ? "" : ", not a manifold");
    }
};

/// Returns the topology of a lattice. The number of handles follows from the Euler characteristic:
/// in space, V − E + F − C = components − handles + cavities.
inline SolidTopology topologyOf(const far::CellComplex& complex) {
    SolidTopology result;
    DisjointSets cells(complex.count(3)), surface(complex.count(0));
    std::map<std::pair<Index, Index>, int> edges;
    std::map<Index, std::vector<std::pair<Index, Index>>> linkOf;  // of each boundary vertex
    for (Index face = 0; face < complex.count(2); ++face) {
        const auto row = complex.relation(2, 3)[face];
        if (row.size() == 2) cells.join(row[0], row[1]);
        if (row.size() != 1) continue;
        const auto loop = complex.relation(2, 0)[face];
        for (std::size_t i = 0; i < loop.size(); ++i) {
            const Index before = loop[(i + loop.size() - 1) % loop.size()],
                        after = loop[(i + 1) % loop.size()];
            surface.join(loop[i], after);
            ++edges[std::minmax(loop[i], after)];
            linkOf[loop[i]].emplace_back(before, after);
        }
    }
    result.components = static_cast<int>(cells.setCount());
    std::vector<Index> roots;
    for (const auto& [vertex, link] : linkOf) {
        roots.push_back(static_cast<Index>(surface.rootOf(vertex)));
        // The link must be one circle.
        std::map<Index, int> numbers;
        for (const auto& [a, b] : link) {
            numbers.emplace(a, static_cast<int>(numbers.size()));
            numbers.emplace(b, static_cast<int>(numbers.size()));
        }
        DisjointSets ends(numbers.size());
        for (const auto& [a, b] : link) ends.join(numbers[a], numbers[b]);
        if (ends.setCount() != 1) result.isManifold = false;
    }
    for (const auto& [edge, count] : edges)
        if (count != 2) result.isManifold = false;
    std::sort(roots.begin(), roots.end());
    roots.erase(std::unique(roots.begin(), roots.end()), roots.end());
    result.cavities = static_cast<int>(roots.size()) - result.components;
    const Index euler = complex.count(0) - complex.count(1) + complex.count(2) - complex.count(3);
    result.handles = result.components + result.cavities - static_cast<int>(euler);
    return result;
}

}  // namespace espalier::test
