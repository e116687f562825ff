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

/// Tells whether integers say which vertices are held.
bool saysHeld(const VertexIntegers& integers) {
    return integers.name == kHeld && integers.components == 1 &&
           std::ranges::all_of(integers.values, [&](std::int64_t value) {
               return value == 0 || value == kIsHeld || value == noInteger(integers.type);
           });
}

}  // namespace

std::vector<Index> heldVertices(const Lattice& lattice) {
    std::vector<Index> vertices;
    const auto held = std::ranges::find_if(lattice.integers, saysHeld);
    if (held == lattice.integers.end()) return vertices;
    for (std::size_t vertex = 0; vertex < held->values.size(); ++vertex)
        if (held->values[vertex] == kIsHeld) vertices.push_back(static_cast<Index>(vertex));
    return vertices;
}

void requireHeldIsFree(const Lattice& lattice) {
    const bool isTaken = std::ranges::any_of(lattice.attributes,
                                             [](const VertexAttribute& attribute) {
                                                 return attribute.name == kHeld;
                                             }) ||
                         std::ranges::any_of(lattice.integers, [](const VertexIntegers& integers) {
                             return integers.name == kHeld && !saysHeld(integers);
                         });
    if (isTaken)
        throw Error(
            "the lattice has point data with the name \"held\" that are not integers 0 and 1; "
            "rename them, because data of this name say which vertices are held in place");
}

void setHeldVertices(Lattice& lattice, std::span<const Index> vertices) {
    requireHeldIsFree(lattice);
    VertexIntegers held{kHeld, 1, IntegerType::UInt8, {}};
    held.values.resize(lattice.positions.size());
    for (const Index vertex : vertices) {
        if (vertex < 0 || vertex >= std::ssize(lattice.positions))
            throw ArgumentError("setHeldVertices", "vertices", std::to_string(vertex),
                                concat("0 to ", std::ssize(lattice.positions) - 1));
        held.values[vertex] = kIsHeld;
    }
    std::erase_if(lattice.integers, saysHeld);
    lattice.integers.push_back(std::move(held));
}

std::vector<double> weightsWithHeld(const Lattice& lattice) {
    return weightsWithHeld(lattice, std::vector<double>(lattice.positions.size(), 1.0));
}

std::vector<double> weightsWithHeld(const Lattice& lattice, std::span<const double> weights) {
    if (weights.size() != lattice.positions.size())
        throw Error(concat("there are ", weights.size(), " weights; expected one for each of the ",
                           lattice.positions.size(), " vertices"));
    for (std::size_t vertex = 0; vertex < weights.size(); ++vertex)
        if (!(weights[vertex] >= 0 && weights[vertex] <= 1))
            throw Error(
                concat("weights[", vertex, "] is ", textOf(weights[vertex]), "; expected 0 to 1"));
    std::vector<double> result(weights.begin(), weights.end());
    for (const Index vertex : heldVertices(lattice)) result[vertex] = 0;
    return result;
}

std::vector<Index> frozenWithHeld(const Lattice& lattice, std::span<const Index> frozen) {
    std::vector<Index> vertices = heldVertices(lattice);
    vertices.insert(vertices.end(), frozen.begin(), frozen.end());
    sortUnique(vertices);
    return vertices;
}

}  // namespace espalier::shapes
