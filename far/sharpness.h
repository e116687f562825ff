// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <espalier/base/api.h>
#include <espalier/base/word.h>
#include <limits>
#include <span>

namespace espalier::far {

/// \file
/// Sharpness is a number, as in OpenSubdiv: 0 is smooth, 10 and more is infinite, and what lies
/// between is semi-sharp: it loses 1 a level. It is held in single precision, as there, so that
/// Chaikin's averages are rounded alike. These are the rules of numbers alone; strata.h applies
/// them to a complex.
///
/// Where three or more semi-sharp values meet in a vertex, their sum is rounded, and OpenSubdiv may
/// add them in another order: weights may then differ by some units of single precision (1e-7),
/// unless the sums are exact, as those of multiples of 1/4 are.
///
/// \cite DeRose, Kass, Truong 1998, as OpenSubdiv 3.5 computes it (Sdc::Crease)

/// Sharpness that no refinement uses up.
inline constexpr float kInfinitelySharp = std::numeric_limits<float>::infinity();
inline constexpr float kSmooth = 0;

/// From this on, a sharpness counts as infinite.
inline constexpr double kLeastInfinite = 10;

/// How the sharpness of an edge goes over to its two children.
enum class Creasing {
    Uniform,  ///< less 1 at both ends
    Chaikin   ///< less 1 after it is averaged with the other semi-sharp edges at that end
};
inline constexpr Word<Creasing> kCreasingWords[] = {{"uniform", Creasing::Uniform},
                                                    {"chaikin", Creasing::Chaikin}};

/// A sharpness as it is stored: in single precision, and infinite from kLeastInfinite on.
/// \param sharpness 0 or more
ESPALIER_API float storedSharpness(double sharpness);

inline bool isSemiSharp(float sharpness) {
    return sharpness > kSmooth && sharpness < kInfinitelySharp;
}

/// Sharpness one level on, without regard to what is around: that of a vertex, and of an edge under
/// Creasing::Uniform.
ESPALIER_API float subdivideSharpness(float sharpness);

/// Sharpness of the child of an edge at one of its ends.
/// \param around the sharpness of all edges at that end, the edge itself among them
ESPALIER_API float subdivideEdgeSharpness(Creasing creasing, float sharpness,
                                          std::span<const float> around);

}  // namespace espalier::far
