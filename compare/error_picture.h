// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <espalier/compare/agreement.h>

#include <array>
#include <cstddef>
#include <optional>
#include <string>
#include <vector>

// A surface as it is seen from where its shape reads best; not installed.

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

/// A face that can be drawn.
struct SeenFace {
    Index face = 0;    ///< its number in the surface
    double depth = 0;  ///< the mean of its corners'
    double light = 0;  ///< 0 (edge-on to the light) to 1 (facing it), the same from either side
};

/// A parallel projection. Points and depths are one a position, where the largest coordinate of the
/// surface is 1; those of positions that are not finite are without meaning.
struct SurfaceView {
    std::vector<std::array<double, 2>> points = {};  ///< x to the right, y down
    std::vector<double> depths = {};                 ///< towards the viewer
    std::vector<SeenFace> faces = {};  ///< the farthest first; of equals that of the lower number
    std::array<double, 2> min = {};    ///< of the points of these faces
    std::array<double, 2> max = {};
};

/// Sees a surface from above, from the front and a little from the right.
///
/// What is up: of a flat shape the axis across it, so that it lies on the ground and is seen from
/// well above; else y for a shape that is tall in y, and z for every other. The longer of the two
/// other axes runs across the picture. Faces with a corner that is not finite are left out.
///
/// \throws Error if a face names a position that does not exist
/// \cost   O(n log n)
SurfaceView viewOf(const SurfaceError& surface);

/// How a vertex is seen: as no corner of a face of the view, behind such a face that it is not a
/// corner of, or else in front.
enum class Sight { Absent, Hidden, Visible };

/// \cost O(faces)
Sight sightOf(const SurfaceError& surface, const SurfaceView& view, Index vertex);

/// A picture of the errors over a surface: an SVG element that stands in a page or in a file of its
/// own, needs nothing from outside, and takes the colour of its text from the page.
///
/// The surface is drawn back to front, each face in the colour of the largest error of its corners
/// (see ErrorScale) darkened away from the light, over a legend in which a triangle marks the
/// largest error. A ring is round the vertex of the largest error, broken where that is behind the
/// surface. Faces with a corner that is not finite are left out, and errors that are not finite
/// drawn as the largest; a line in the picture says so. A surface of which nothing can be drawn
/// gives a line of text.
///
/// The faces are the `path` children, in the order that they are drawn in, of the only element of
/// class "surface".
///
/// \param bounds that of positions divides the scale
/// \throws Error if there is not one error a position, or a face names a position that does not
///         exist
/// \cost   O(n log n); 60 to 70 bytes a face
std::string errorPicture(const SurfaceError& surface, const Bounds& bounds = {});

/// The vertex of the largest error, the first of equals; one that is not a number is the largest.
/// None where no error is above 0.
std::optional<Index> largestErrorVertex(const SurfaceError& surface);

}  // namespace espalier::compare
