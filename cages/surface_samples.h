// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <espalier/base/function_ref.h>
#include <espalier/base/point.h>

#include <cstddef>
#include <span>

#include "model_surface.h"

namespace espalier::cages {

/// Calls visit(point, triangle) for points of triangles: the corners, the middles of the sides, the
/// centroids, and more where a triangle is large, so that neighbours are at most `spacing` apart.
/// A point of several triangles is visited several times.
void forEachSample(std::span<const Triangle> triangles, std::span<const Point3> points,
                   double spacing, FunctionRef<void(const Point3&, std::size_t)> visit);

}  // namespace espalier::cages
