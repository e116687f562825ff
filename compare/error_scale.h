// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <string>
#include <vector>

namespace espalier::compare {

/// Red, green and blue, 0 to 255.
using Colour = std::array<int, 3>;

/// "#2f6da8".
std::string hexText(const Colour& colour);

/// The same hue, darker.
/// \param shade 0 (black) to 1 (the colour itself)
Colour shaded(const Colour& colour, double shade);

/// How errors are coloured: on a log scale from 1e-18 to 1e-6, whose one part ends at the bound and
/// whose other starts there.
///
/// The two parts differ in hue, so that it is seen at once which side of the bound an error is on:
/// pale green to blue up to the bound, red to purple above it. The colour gets darker with the
/// error all along, so that the order survives colour blindness and a grey print. The part within
/// the bound, where errors of rounding are, takes two thirds of the scale.
class ErrorScale {
public:
    static constexpr double kLeast = 1e-18;
    static constexpr double kMax = 1e-6;

    /// A grey: of no error at all.
    static constexpr Colour kExact = {214, 212, 207};

    /// \param bound of errors that are called agreement; one that leaves either part less than a
    ///        decade counts as the next that does not
    explicit ErrorScale(double bound);

    /// The place on the scale, 0 to 1. Errors below kLeast are at 0; those above kMax, and what is
    /// not a number, at 1.
    double place(double error) const;

    /// kExact for 0, else that of the place.
    Colour colour(double error) const;

    /// \param place 0 to 1
    Colour colourAt(double place) const;

    struct Tick {
        double place = 0;
        std::string label = {};  ///< "1e-15"; empty where it would run into another
    };

    /// Powers of ten, ascending, from kLeast to kMax, which both have labels.
    /// \param spacing least distance of two labels, as a part of the scale
    std::vector<Tick> ticks(double spacing) const;

    /// The place where the hue changes: that of the bound, as long as it leaves either part its
    /// decade.
    static constexpr double kBoundPlace = 2.0 / 3;

private:
    double logBound_;
};

}  // namespace espalier::compare
