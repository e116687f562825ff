// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>

namespace espalier {

/// The deformation gradient F at a point, by rows: number 3 i + j is d x'_i / d X_j, the derivative
/// of coordinate i of the deformed point by coordinate j of the point at rest.
///
/// Where nothing moves, F should be the identity to the last bit, so that directions stay as they
/// are. F has this property if it is computed as 1 + d u / d X from the displacements u.
using DeformationGradient = std::array<double, 9>;

}  // namespace espalier
