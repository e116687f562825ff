// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <espalier/solve/reference_axis.h>

#include <array>
#include <cmath>
#include <cstddef>

// The formula of ReferenceAxis, for real and complex numbers; not installed.
namespace espalier::solve {

template <class Number>
using AxisVector = std::array<Number, 3>;

template <class Number>
Number product(const AxisVector<Number>& a, const AxisVector<Number>& b) {
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

/// The values of a node of an axis.
template <class Number>
using NodeValues = std::array<Number, ReferenceAxis::kValues>;

/// A vertex, and the segment of the axis that it is linked to: at rest, and with its values.
template <class Number>
struct AxisPart {
    AxisVector<Number> vertex;
    std::array<AxisVector<Number>, 2> rest;
    std::array<NodeValues<Number>, 2> values;
    double fraction;
};

/// How the sections of an axis turn and scale: the options of the axis.
struct AxisTurns {
    TurnOrder order;
    bool follows;
    std::array<Point3, 3> frame;
};

/// Returns the unit vector from a to b.
template <class Number>
AxisVector<Number> directionOf(const AxisVector<Number>& a, const AxisVector<Number>& b) {
    using std::sqrt;
    AxisVector<Number> result;
    for (std::size_t c = 0; c < 3; ++c) result[c] = b[c] - a[c];
    const Number length = sqrt(product(result, result));
    for (Number& coordinate : result) coordinate /= length;
    return result;
}

/// Turns a vector about a unit vector, by Rodrigues' formula.
template <class Number>
AxisVector<Number> turned(const AxisVector<Number>& v, const AxisVector<Number>& axis,
                          const Number& angle) {
    using std::cos, std::sin;
    const Number cosine = cos(angle), sine = sin(angle);
    const Number along = (Number(1) - cosine) * product(axis, v);
    AxisVector<Number> result;
    for (std::size_t c = 0; c < 3; ++c) {
        const std::size_t next = (c + 1) % 3, last = (c + 2) % 3;
        const Number across = axis[next] * v[last] - axis[last] * v[next];
        result[c] = cosine * v[c] + sine * across + along * axis[c];
    }
    return result;
}

/// The numbers of the coordinate axes in an order of turns.
inline std::array<std::size_t, 3> axesOf(TurnOrder order) {
    switch (order) {
        case TurnOrder::Xyz:
            return {0, 1, 2};
        case TurnOrder::Xzy:
            return {0, 2, 1};
        case TurnOrder::Yzx:
            return {1, 2, 0};
        case TurnOrder::Yxz:
            return {1, 0, 2};
        case TurnOrder::Zxy:
            return {2, 0, 1};
        case TurnOrder::Zyx:
            return {2, 1, 0};
    }
    return {2, 0, 1};
}

/// Scales a vector along the directions of a frame.
template <class Number>
AxisVector<Number> scaledIn(const std::array<Point3, 3>& frame, const AxisVector<Number>& v,
                            const Number* scales) {
    AxisVector<Number> result = v;
    for (std::size_t k = 0; k < 3; ++k) {
        const Number along = frame[k][0] * v[0] + frame[k][1] * v[1] + frame[k][2] * v[2];
        for (std::size_t c = 0; c < 3; ++c)
            result[c] += (scales[k] - Number(1)) * along * frame[k][c];
    }
    return result;
}

/// Returns the position of a vertex.
template <class Number>
AxisVector<Number> axisPosition(const AxisTurns& turns, const AxisPart<Number>& part) {
    NodeValues<Number> values;
    for (std::size_t k = 0; k < values.size(); ++k)
        values[k] = (1 - part.fraction) * part.values[0][k] + part.fraction * part.values[1][k];
    AxisVector<Number> link;
    for (std::size_t c = 0; c < 3; ++c)
        link[c] = part.vertex[c] -
                  ((1 - part.fraction) * part.rest[0][c] + part.fraction * part.rest[1][c]);
    const auto nodeOf = [](const NodeValues<Number>& node) {
        return AxisVector<Number>{node[0], node[1], node[2]};
    };
    const AxisVector<Number> direction =
        directionOf(nodeOf(part.values[0]), nodeOf(part.values[1]));
    constexpr std::size_t kTurns = 3, kTwist = 6, kScale = 7, kScales = 8;
    if (turns.follows) {
        const AxisVector<Number> before = directionOf(part.rest[0], part.rest[1]);
        const Number alike = product(direction, before), along = product(direction, link);
        for (std::size_t c = 0; c < 3; ++c) link[c] = alike * link[c] - along * before[c];
        link = scaledIn(turns.frame, link, &values[kScales]);
        link = turned(link, direction, values[kTwist]);
    } else {
        for (const std::size_t axis : axesOf(turns.order)) {
            AxisVector<Number> unit = {0, 0, 0};
            unit[axis] = 1;
            link = turned(link, unit, values[kTurns + axis]);
        }
        link = turned(link, direction, values[kTwist]);
        link = scaledIn(turns.frame, link, &values[kScales]);
    }
    AxisVector<Number> result;
    for (std::size_t c = 0; c < 3; ++c) result[c] = values[c] + values[kScale] * link[c];
    return result;
}

}  // namespace espalier::solve
