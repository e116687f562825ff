// SPDX-License-Identifier: Apache-2.0
#include <espalier/base/argument_error.h>
#include <espalier/base/error.h>
#include <espalier/base/number_text.h>
#include <espalier/base/sort_unique.h>
#include <espalier/shapes/held.h>

#include <algorithm>
#include <string>
#include <utility>

namespace espalier::shapes {
namespace {

constexpr std::int64_t kIsHeld = 1;

bool isNamedHeld(const VertexIntegers& integers) {
    return integers.name == kHeld;
}

}  // namespace

std::vector<Index> heldVertices(const Lattice& lattice) {
    std::vector<Index> vertices;
    const auto held = std::ranges::find_if(lattice.integers, isNamedHeld);
    if (held == lattice.integers.end() || held->components != 1) return vertices;
    for (std::size_t vertex = 0; vertex < held->values.size(); ++vertex)
        if (held->values[vertex] == kIsHeld) vertices.push_back(static_cast<Index>(vertex));
    return vertices;
}

void setHeldVertices(Lattice& lattice, std::span<const Index> vertices) {
    VertexIntegers held{kHeld, 1, IntegerType::UInt8, {}};
    held.values.resize(lattice.positions.size());
    for (const Index vertex : vertices) {
        if (vertex < 0 || vertex >= std::ssize(lattice.positions))
            throw ArgumentError("setHeldVertices", "vertices", std::to_string(vertex),
                                concat("0 to ", std::ssize(lattice.positions) - 1));
        held.values[vertex] = kIsHeld;
    }
    std::erase_if(lattice.integers, isNamedHeld);
    lattice.integers.push_back(std::move(held));
}

std::vector<double> weightsWithHeld(const Lattice& lattice, std::span<const double> weights) {
    if (!weights.empty() && weights.size() != lattice.positions.size())
        throw Error(concat("there are ", weights.size(), " weights; expected one for each of the ",
                           lattice.positions.size(), " vertices"));
    for (std::size_t vertex = 0; vertex < weights.size(); ++vertex)
        if (!(weights[vertex] >= 0 && weights[vertex] <= 1))
            throw Error(
                concat("weights[", vertex, "] is ", textOf(weights[vertex]), "; expected 0 to 1"));
    std::vector<double> result(weights.begin(), weights.end());
    const std::vector<Index> held = heldVertices(lattice);
    if (held.empty()) return result;
    result.resize(lattice.positions.size(), 1);
    for (const Index vertex : held) result[vertex] = 0;
    return result;
}

std::vector<Index> frozenWithHeld(const Lattice& lattice, std::span<const Index> frozen) {
    std::vector<Index> vertices = heldVertices(lattice);
    vertices.insert(vertices.end(), frozen.begin(), frozen.end());
    sortUnique(vertices);
    return vertices;
}

}  // namespace espalier::shapes
