// SPDX-License-Identifier: Apache-2.0
#include "collar_cells.h"

#include <espalier/base/bounding_box.h>
#include <espalier/base/vector3.h>
#include <espalier/far/complex_builder.h>
#include <espalier/shapes/new_vertices.h>
#include <espalier/shapes/refiner_options.h>

#include <algorithm>
#include <cmath>
#include <iterator>

#include "untangle.h"

namespace espalier::cages {

Point3 sideDirection(std::size_t side) {
    Point3 direction = {0, 0, 0};
    direction[side / 2] = side % 2 == 1 ? 1 : -1;
    return direction;
}

std::vector<double> layerParts(int layers, double reach, double first) {
    // The sum of the layers, q^0 + ... + q^(layers − 1), grows with q.
    const auto total = [&](double q) {
        double sum = 0;
        for (int layer = 0; layer < layers; ++layer) sum += std::pow(q, layer);
        return sum;
    };
    const double wanted = first > 0 ? reach / first : 0;
    double low = 1, high = 1;
    if (layers > 1 && std::isfinite(wanted) && wanted > total(1)) {
        while (total(high) < wanted) high *= 2;
        constexpr int kHalvings = 60;
        for (int i = 0; i < kHalvings; ++i) {
            const double middle = 0.5 * (low + high);
            (total(middle) < wanted ? low : high) = middle;
        }
    }
    std::vector<double> parts = {0};
    double sum = 0;
    const double all = total(low);
    for (int layer = 0; layer < layers; ++layer) {
        sum += std::pow(low, layer);
        parts.push_back(layer + 1 == layers ? 1 : sum / all);
    }
    return parts;
}

Lattice joined(const Lattice& lattice, const CollarCells& cells) {
    std::vector<shapes::NewVertex> newVertices;
    for (const CollarVertex& vertex : cells.vertices)
        newVertices.push_back({vertex.position, {vertex.over}});
    Lattice result = shapes::withNewVertices(lattice, newVertices);
    far::ComplexBuilder builder(3, static_cast<Index>(result.positions.size()));
    for (Index cell = 0; cell < lattice.complex.count(3); ++cell)
        builder.addCell(far::outwardLoops(lattice.complex, CellId(cell)));
    for (const auto& [bottom, top] : cells.prisms) {
        const std::size_t n = bottom.size();
        std::vector<std::vector<Index>> loops = {{bottom.rbegin(), bottom.rend()}, top};
        for (std::size_t i = 0; i < n; ++i) {
            const std::size_t next = (i + 1) % n;
            loops.push_back({bottom[i], bottom[next], top[next], top[i]});
        }
        builder.addCell(loops);
    }
    result.complex = builder.build();
    const auto append = [](auto& marks, const auto& more) {
        marks.insert(marks.end(), more.begin(), more.end());
    };
    append(result.marks.edges, cells.marks.edges);
    append(result.marks.vertices, cells.marks.vertices);
    return result;
}

void removeFolds(const Lattice& lattice, std::span<const double> weights,
                 std::span<const CollarVertex> homes, double tether, CollarCells& cells) {
    const Lattice whole = joined(lattice, cells);
    const far::CellComplex& complex = whole.complex;
    const Index count = lattice.complex.count(0);
    std::vector<VertexFreedom> freedoms(lattice.positions.size());
    int layers = 0;
    for (const CollarVertex& vertex : cells.vertices) layers = std::max(layers, vertex.layer);
    for (const CollarVertex& home : homes) {
        const double reach = length(difference(home.position, lattice.positions[home.over]));
        freedoms.push_back(
            {true, home.planes, home.layer == layers ? tether * reach : 0, home.position});
    }
    // An edge that folds have shortened gets half the length of the edge of the lattice that it is
    // over.
    const auto over = [&](Index vertex) { return overOf(cells, count, vertex); };
    const double smallest = 1e-6 * BoundingBox(whole.positions).diagonal();
    std::vector<double> lengths;
    for (Index edge = 0; edge < complex.count(1); ++edge) {
        const auto ends = complex.relation(1, 0)[edge];
        const double now = length(difference(whole.positions[ends[0]], whole.positions[ends[1]]));
        const double below =
            length(difference(lattice.positions[over(ends[0])], lattice.positions[over(ends[1])]));
        lengths.push_back(std::max({now, 0.5 * below, smallest}));
    }
    std::vector<Point3> positions = whole.positions;
    const far::TopologyRefiner base(complex, refinerOptions(whole));
    untangle(positions, {base, freedoms, lengths, weights});
    for (std::size_t v = 0; v < cells.vertices.size(); ++v)
        cells.vertices[v].position = positions[std::size_t(count) + v];
}

}  // namespace espalier::cages
