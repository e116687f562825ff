// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <espalier/base/error.h>
#include <espalier/base/point.h>
#include <espalier/far/topology_error.h>
#include <espalier/far/topology_refiner.h>
#include <gmock/gmock.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <map>
#include <numeric>
#include <random>
#include <set>
#include <stdexcept>
#include <string>
#include <vector>

// Included by all tests: GoogleTest and its matchers, the helpers of support/, and checks of error
// messages.
namespace espalier {

namespace test {}
using namespace test;

using ::testing::AllOf;
using ::testing::Contains;
using ::testing::Each;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::SizeIs;
using ::testing::StartsWith;
using ::testing::Throws;
using ::testing::ThrowsMessage;

namespace test {

using far::Boundary;
using far::CellComplex;
using far::Rules;
using far::TopologyRefiner;

/// The types for TYPED_TEST_SUITE().
using Reals = ::testing::Types<float, double>;

inline constexpr double kInfinity = std::numeric_limits<double>::infinity();
inline constexpr double kNan = std::numeric_limits<double>::quiet_NaN();

/// Returns random numbers between −1 and 1.
template <class Real = double>
std::vector<Real> randomValues(std::size_t count, unsigned seed) {
    std::mt19937 random(seed);
    std::uniform_real_distribution<double> uniform(-1, 1);
    std::vector<Real> values(count);
    for (Real& value : values) value = Real(uniform(random));
    return values;
}

/// Returns random points with coordinates between −size and size.
inline std::vector<Point3> randomPoints(std::size_t count, unsigned seed, double size = 1) {
    const auto values = randomValues(3 * count, seed);
    std::vector<Point3> points(count);
    for (std::size_t i = 0; i < values.size(); ++i) points[i / 3][i % 3] = size * values[i];
    return points;
}

/// Returns the points, randomly moved by up to `size` in each coordinate.
inline std::vector<Point3> shaken(std::vector<Point3> points, unsigned seed, double size = 0.5) {
    const auto moves = randomPoints(points.size(), seed, size);
    for (std::size_t i = 0; i < points.size(); ++i)
        for (std::size_t axis = 0; axis < 3; ++axis) points[i][axis] += moves[i][axis];
    return points;
}

/// Returns the message of the exception that a call throws; empty if it throws none.
template <class Refusal = Error, class Call>
std::string messageOf(Call call) {
    try {
        call();
    } catch (const Refusal& error) {
        return error.what();
    }
    return {};
}

/// Returns the TopologyError that a call must throw.
template <class Call>
far::TopologyError topologyErrorOf(Call call) {
    try {
        call();
    } catch (const far::TopologyError& error) {
        return error;
    }
    throw std::logic_error("no TopologyError was thrown");
}

template <class Call>
far::TopologyCause causeOf(Call call) {
    return topologyErrorOf(call).cause();
}

}  // namespace test
}  // namespace espalier

/// Expects that a call throws this type of exception, with a message that contains the text.
#define EXPECT_REFUSED(Refusal, text, ...)                                  \
    EXPECT_THAT(::espalier::test::messageOf<Refusal>([&] { __VA_ARGS__; }), \
                ::testing::HasSubstr(text))

/// Expects that a call throws an Error with this message.
#define EXPECT_MESSAGE(text, ...) EXPECT_EQ(::espalier::test::messageOf([&] { __VA_ARGS__; }), text)
