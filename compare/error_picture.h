// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <espalier/compare/agreement.h>

#include <optional>
#include <string>

namespace espalier::compare {

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
