// SPDX-License-Identifier: Apache-2.0
#include <espalier/base/error.h>
#include <espalier/base/number_text.h>
#include <espalier/base/progress.h>
#include <espalier/base/vector3.h>
#include <espalier/far/topology_error.h>

#include <cmath>
#include <utility>

#include "checks.h"

namespace espalier::shapes {
namespace {

const char* complexName(int dimension) {
    constexpr const char* kNames[] = {"curve", "mesh", "lattice"};
    return dimension >= 1 && dimension <= 3 ? kNames[dimension - 1] : "empty complex";
}

}  // namespace

void requireAtLeast(const std::string& shape, const std::string& field, int value, int least) {
    if (value < least)
        throw ArgumentError(shape, field, std::to_string(value), concat(least, " or more"));
}

void requireFinite(const std::string& shape, const std::string& field, double value) {
    if (!std::isfinite(value)) throw ArgumentError(shape, field, textOf(value), "a finite number");
}

void requireFinite(const std::string& shape, const std::string& field, const Point3& value) {
    if (!isFinite(value)) throw ArgumentError(shape, field, textOf(value), "finite numbers");
}

void requirePositive(const std::string& shape, const std::string& field, double value) {
    if (!(value > 0) || !std::isfinite(value))
        throw ArgumentError(shape, field, textOf(value), "a finite number above 0");
}

Point3 unitVector(const std::string& shape, const std::string& field, const Point3& vector) {
    requireFinite(shape, field, vector);
    if (!(length(vector) > 0))
        throw ArgumentError(shape, field, textOf(vector), "a vector other than 0");
    return normalised(vector);
}

void requireFinite(const std::string& name, std::span<const Point3> positions) {
    for (std::size_t i = 0; i < positions.size(); ++i) {
        checkCancelledEvery(i, 14);
        if (!isFinite(positions[i]))
            throw Error(indexed(name, i) + " is " + textOf(positions[i]) +
                        "; expected finite numbers");
    }
}

std::string indexed(const std::string& field, std::size_t index) {
    std::string name = field;
    name += '[';
    name += std::to_string(index);
    name += ']';
    return name;
}

void requireInterval(const std::string& shape, const std::string& minField, double min,
                     const std::string& maxField, double max) {
    requireFinite(shape, minField, min);
    requireFinite(shape, maxField, max);
    if (!(max > min))
        throw ArgumentError(shape, maxField, textOf(max), "a number above",
                            {minField, textOf(min)});
}

void requireCountable(const std::string& shape, std::initializer_list<Offset> factors) {
    Offset count = 1;
    for (const Offset factor : factors) {
        // `count` is below 2^31 before each multiplication, so nothing overflows.
        if (factor <= kMaxIndex / count) {
            count *= factor;
            continue;
        }
        std::string product;
        for (const Offset each : factors) product += concat(product.empty() ? "" : " x ", each);
        throw far::TopologyError(
            far::TopologyCause::TooManyEntities, {0, kMaxIndex},
            concat(shape, ": needs ", product, " entries; the maximum is ", kMaxIndex));
    }
}

void requireConsistent(const std::string& who, const std::string& name, const Lattice& lattice,
                       int dimension) {
    if (lattice.complex.dimension() != dimension)
        throw Error(who + ": " + name + " is a " + complexName(lattice.complex.dimension()) +
                    "; expected a " + complexName(dimension));
    const std::size_t vertexCount = lattice.complex.count(0);
    if (lattice.positions.size() != vertexCount)
        throw Error(concat(who, ": ", name, " has ", lattice.positions.size(),
                           " positions; expected ", vertexCount, ", one for each vertex"));
    for (std::size_t vertex = 0; vertex < vertexCount; ++vertex)
        if (!isFinite(lattice.positions[vertex]))
            throw Error(concat(who, ": vertex ", vertex, " of ", name, " is at ",
                               textOf(lattice.positions[vertex]), "; expected finite numbers"));
    const auto checkAttribute = [&](const auto& attribute) {
        if (attribute.components < 1)
            throw Error(concat(who, ": attribute ", inQuotes(attribute.name), " of ", name, " has ",
                               attribute.components, " components; expected 1 or more"));
        const std::size_t expected = vertexCount * attribute.components;
        if (attribute.values.size() != expected)
            throw Error(concat(who, ": attribute ", inQuotes(attribute.name), " of ", name, " has ",
                               attribute.values.size(), " values; expected ", expected));
    };
    for (const VertexAttribute& attribute : lattice.attributes) checkAttribute(attribute);
    for (const VertexIntegers& integers : lattice.integers) checkAttribute(integers);
    const auto checkMark = [&](Index vertex) {
        if (vertex < 0 || std::cmp_greater_equal(vertex, vertexCount))
            throw far::TopologyError(far::TopologyCause::VertexOutOfRange, {0, vertex},
                                     concat(who, ": a mark of ", name, " names vertex ", vertex,
                                            "; there are ", vertexCount));
    };
    for (const far::Marks::Edge& mark : lattice.marks.edges)
        for (const Index vertex : mark.vertices) checkMark(vertex);
    for (const far::Marks::Vertex& mark : lattice.marks.vertices) checkMark(mark.vertex);
}

}  // namespace espalier::shapes
