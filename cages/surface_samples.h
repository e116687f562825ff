// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <espalier/base/point.h>

#include <span>
#include <vector>

#include "model_surface.h"

namespace espalier::cages {

/// Returns points of triangles: the corners, the middles of the sides, the centroids, and more where
/// a triangle is large, so that neighbours are at most `spacing` apart.
std::vector<Point3> surfaceSamples(std::span<const Triangle> triangles,
                                   std::span<const Point3> points, double spacing);

}  // namespace espalier::cages
