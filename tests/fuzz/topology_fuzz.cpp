// SPDX-License-Identifier: Apache-2.0
#include <espalier/far/complex_builder.h>
#include <espalier/far/topology_refiner.h>
#include <espalier/stencils/composition.h>

#include <cmath>
#include <vector>

#include "fuzz_target.h"

namespace espalier::fuzz {
namespace {

/// Reads the index of a vertex, edge or face: mostly one that may exist, but also negative.
Index takeIndex(Input& input) {
    return input.take<std::int8_t>();
}

std::vector<Index> takeIndices(Input& input, int count) {
    std::vector<Index> indices;
    for (int i = 0; i < count; ++i) indices.push_back(takeIndex(input));
    return indices;
}

/// Builds a complex from cells, faces or edges, as a file gives them, up to the end of the input.
far::CellComplex buildFrom(Input& input, int dimension) {
    far::ComplexBuilder builder(dimension, input.byte());
    while (input.left() > 0) {
        const int kind = input.choice(20);
        if (dimension == 1) {
            const Index tail = takeIndex(input);
            builder.addEdge(tail, takeIndex(input));
        } else if (dimension == 2) {
            builder.addFace(takeIndices(input, kind));
        } else if (kind < 4) {
            const auto cell = static_cast<far::StandardCell>(kind);
            builder.addCell(cell, takeIndices(input, far::vertexCount(cell)));
        } else {
            std::vector<std::vector<Index>> loops;
            for (int loop = 0; loop < kind; ++loop)
                loops.push_back(takeIndices(input, input.choice(8)));
            builder.addCell(loops);
        }
    }
    return builder.build();
}

/// Assembles a complex from relations that no builder would make.
far::CellComplex assembleFrom(Input& input, int dimension) {
    const Index vertexCount = takeIndex(input);
    far::CellComplex::Boundaries boundaries;
    for (int d = 1; d <= dimension; ++d) {
        far::Rows<far::Signed> rows;
        for (int row = input.byte(); row > 0; --row) {
            for (int entry = input.choice(8); entry > 0; --entry) {
                const Index index = takeIndex(input);
                rows.values.push_back({index, static_cast<std::int8_t>(input.flag() ? 1 : -1)});
            }
            rows.offsets.push_back(static_cast<Offset>(rows.values.size()));
        }
        boundaries[d - 1] = far::SignedIncidence(rows);
    }
    far::CellComplex complex(dimension, vertexCount, boundaries);
    far::validate(complex);
    return complex;
}

double takeSharpness(Input& input) {
    constexpr double kSharpness[] = {0, 0.5, 1, 2.7, 10, far::kInfinitelySharp, -1, 1e300};
    return kSharpness[input.choice(8)];
}

far::RefinerOptions takeOptions(Input& input) {
    far::RefinerOptions options;
    options.rules = static_cast<far::Rules>(input.choice(4));
    options.boundary = static_cast<far::Boundary>(input.choice(3));
    options.sharpEdges = static_cast<far::SharpEdges>(input.choice(2));
    options.creasing = static_cast<far::Creasing>(input.choice(2));
    options.triangles = static_cast<far::TriangleSubdivision>(input.choice(2));
    for (int edge = input.choice(4); edge > 0; --edge) {
        const Index tail = takeIndex(input);
        options.marks.edges.push_back({{tail, takeIndex(input)}, takeSharpness(input)});
    }
    for (int vertex = input.choice(4); vertex > 0; --vertex)
        options.marks.vertices.push_back({takeIndex(input), takeSharpness(input)});
    for (int hole = input.choice(4) / 2; hole > 0; --hole)
        options.marks.holes.push_back(takeIndex(input));
    return options;
}

void requireWeights(const far::TopologyRefiner& refiner) {
    const auto table = stencils::buildStencils(refiner, refiner.maxLevel());
    for (Index row = 0; row < table.rowCount(); ++row) {
        double sum = 0;
        for (const double weight : table.weights(row)) sum += weight;
        // The rows are sums over two levels of some hundred weights, none above 1.
        require(std::abs(sum - 1) < 1e-12, "rows sum to 1", std::to_string(sum));
    }
}

/// Requires that arbitrary integers are refused as a complex, or make one that can be refined.
void runTopology(Input input) {
    const int dimension = 1 + input.choice(3);
    const bool isBuilt = input.flag();
    const far::RefinerOptions options = takeOptions(input);
    const auto complex = resultOf(
        [&] { return isBuilt ? buildFrom(input, dimension) : assembleFrom(input, dimension); });
    if (!complex) return;
    far::validate(*complex);
    auto refiner = resultOf([&] { return far::TopologyRefiner(*complex, options); });
    if (!refiner) return;
    constexpr int kLevels = 2;
    constexpr Index kEnough = 300;  // vertices for one input
    while (refiner->maxLevel() < kLevels) {
        const int level = refiner->maxLevel() + 1;
        if (!resultOf([&] { return refiner->refineUniform(level), true; })) return;
        const far::CellComplex& child = refiner->level(level).complex;
        far::validate(child);
        if (child.count(0) > kEnough) break;
    }
    requireWeights(*refiner);
}

const Target kTopology("topology", [](std::string_view bytes) { runTopology(Input(bytes)); });

}  // namespace
}  // namespace espalier::fuzz
