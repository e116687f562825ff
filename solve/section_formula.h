// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <espalier/base/point.h>

#include <array>
#include <cmath>

// The formula of SectionVariables, for real and complex numbers; not installed.
namespace espalier::solve {

/// The frame of a section: the unit vectors of the chord and of the normal.
struct SectionFrame {
    Point3 chord, normal;
};

/// The values of a section: twist, scale, translation.
template <class Number>
using SectionValues = std::array<Number, 5>;

/// Returns the position of a vertex.
/// \param foot its point on the axis
/// \param a, b its coordinates along the chord and the normal
template <class Number>
std::array<Number, 3> sectionPosition(const SectionFrame& frame, const Point3& foot, double a,
                                      double b, const SectionValues<Number>& values) {
    using std::cos, std::sin;
    const auto& [twist, scale, tx, ty, tz] = values;
    const Number alongChord = cos(twist) * scale * a - sin(twist) * b;
    const Number alongNormal = sin(twist) * scale * a + cos(twist) * b;
    const Number shift[3] = {tx, ty, tz};
    std::array<Number, 3> position;
    for (std::size_t c = 0; c < 3; ++c)
        position[c] =
            foot[c] + shift[c] + alongChord * frame.chord[c] + alongNormal * frame.normal[c];
    return position;
}

/// Returns the derivatives of the position by the five values.
inline std::array<Point3, 5> sectionDerivatives(const SectionFrame& frame, double a, double b,
                                                const SectionValues<double>& values) {
    const double cosine = std::cos(values[0]), sine = std::sin(values[0]), scale = values[1];
    std::array<Point3, 5> result = {{{}, {}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}}};
    for (std::size_t c = 0; c < 3; ++c) {
        result[0][c] = (-sine * scale * a - cosine * b) * frame.chord[c] +
                       (cosine * scale * a - sine * b) * frame.normal[c];
        result[1][c] = cosine * a * frame.chord[c] + sine * a * frame.normal[c];
    }
    return result;
}

}  // namespace espalier::solve
