// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <espalier/compare/agreement.h>

#include <array>
#include <cstddef>
#include <vector>

// A surface as it is seen from where its shape reads best; not installed.
namespace espalier::compare {

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

}  // namespace espalier::compare
