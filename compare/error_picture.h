// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <espalier/compare/agreement.h>

#include <array>
#include <cstddef>
#include <optional>
#include <string>
#include <vector>

// Draws the errors over a surface, seen from a suitable direction. Not installed.

namespace espalier::compare {

/// Red, green and blue, 0 to 255.
using Colour = std::array<int, 3>;

/// "#2f6da8".
std::string hexText(const Colour& colour);

/// The same hue, darker.
/// \param shade 0 (black) to 1 (the colour itself)
Colour shaded(const Colour& colour, double shade);

/// Colours for errors, on a log scale from 1e-18 to 1e-6 that the bound divides into two parts.
///
/// The hue shows whether an error is within the bound: pale green to blue up to the bound, red to
/// purple above it. The colour gets steadily darker with the error, so that the order is also
/// visible to colour-blind readers and in grey prints. The part within the bound, where rounding
/// errors are, takes two thirds of the scale.
class ErrorScale {
public:
    static constexpr double kMin = 1e-18;
    static constexpr double kMax = 1e-6;

    /// A grey for an error of 0.
    static constexpr Colour kExact = {214, 212, 207};

    /// \param bound largest error that counts as agreement; moved if it leaves less than a decade
    ///        to either part
    explicit ErrorScale(double bound);

    /// Returns the place of an error on the scale, 0 to 1. Errors below kMin are at 0; errors
    /// above kMax, and NaN, at 1.
    double place(double error) const;

    /// Returns kExact for 0, else the colour at the place of the error.
    Colour colour(double error) const;

    /// \param place 0 to 1
    Colour colourAt(double place) const;

    struct Tick {
        double place = 0;
        std::string label = {};  ///< "1e-15"; empty where it would overlap another one
    };

    /// Returns ticks at powers of ten, ascending, from kMin to kMax, which both have labels.
    /// \param spacing smallest distance of two labels, as a fraction of the scale
    std::vector<Tick> ticks(double spacing) const;

    /// The place where the hue changes: the place of the bound, unless this leaves less than a
    /// decade to either part.
    static constexpr double kBoundPlace = 2.0 / 3;

private:
    double logBound_;
};

/// A face that can be drawn.
struct SeenFace {
    Index face = 0;    ///< its number in the surface
    double depth = 0;  ///< mean depth of its corners
    double light = 0;  ///< 0 (edge-on to the light) to 1 (facing it), the same from either side
};

/// A parallel projection of a surface. There is one point and one depth for each position, in units
/// of the largest coordinate of the surface. Values for positions that are not finite are
/// undefined.
struct SurfaceView {
    std::vector<std::array<double, 2>> points = {};  ///< x to the right, y down
    std::vector<double> depths = {};                 ///< towards the viewer
    /// Farthest first; of equally far ones, the lower number first.
    std::vector<SeenFace> faces = {};
    std::array<double, 2> min = {};  ///< bounding box of the points of these faces
    std::array<double, 2> max = {};
};

/// Projects a surface, seen from above, from the front and a little from the right.
///
/// A flat shape is on the ground and is seen from well above: the axis across it is up. Otherwise y
/// is up for a shape that is tall in y, and z for any other. The longer one of the two remaining
/// axes runs across the picture. Faces with a corner that is not finite are left out.
///
/// \throws Error if a face names a position that does not exist
/// \cost   O(n log n)
SurfaceView viewOf(const SurfaceError& surface);

/// Visibility of a vertex: not a corner of any face of the view; behind a face that it is not a
/// corner of; or visible.
enum class Sight { Absent, Hidden, Visible };

/// \cost O(faces)
Sight sightOf(const SurfaceError& surface, const SurfaceView& view, Index vertex);

/// Returns a picture of the errors over a surface: an SVG element that works in a page or in a file
/// of its own, needs no external resources, and takes the colour of its text from the page.
///
/// The surface is drawn back to front. Each face has the colour of the largest error of its corners
/// (see ErrorScale), darkened away from the light. A legend is below, in which a triangle marks the
/// largest error. A ring marks the vertex of the largest error; it is broken if the vertex is
/// behind the surface. Faces with a corner that is not finite are left out, and errors that are not
/// finite are drawn as the largest; a line in the picture says so. If nothing can be drawn, the
/// picture is a line of text.
///
/// The faces are the `path` children, in drawing order, of the only element of class "surface".
///
/// \param bounds its bound of positions divides the scale
/// \throws Error unless there is one error for each position, or if a face names a position that
///         does not exist
/// \cost   O(n log n); 60 to 70 bytes per face
std::string errorPicture(const SurfaceError& surface, const Bounds& bounds = {});

/// Returns the vertex of the largest error, the first of several; NaN counts as the largest. Empty
/// if no error is above 0.
std::optional<Index> largestErrorVertex(const SurfaceError& surface);

}  // namespace espalier::compare
