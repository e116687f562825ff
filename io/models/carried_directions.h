// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <espalier/io/directions.h>

#include <span>
#include <vector>

#include "coordinates.h"

// What the model formats share about the directions in a file.

namespace espalier::io {

/// What a direction is, is how it is carried: carryNormal() or carryTangent().
using Carry = Point3 (*)(const DeformationGradient&, const Point3&);

/// Whether three numbers of a file are a direction: not those that are no numbers, that are all 0,
/// or that are too large to be turned. What is none is kept as it is.
bool isDirection(const Point3& numbers, Precision precision);

/// The directions of points, one each, as F of each makes them.
std::vector<Point3> carried(std::span<const Point3> directions,
                            std::span<const DeformationGradient> gradients, Carry carry,
                            Precision precision);

}  // namespace espalier::io
