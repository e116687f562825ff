// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>

namespace espalier {

/// The deformation gradient F = dx' / dX at a point: how fast the deformed position x' changes if
/// the position at rest X moves. Its rows follow each other: number 3 i + j is dx'_i / dX_j, where
/// i and j are coordinates.
///
/// Where nothing moves, F should be the identity to the last bit, so that directions stay as they
/// are. F has this property if it is computed as 1 + d u / d X from the displacements u.
using DeformationGradient = std::array<double, 9>;

}  // namespace espalier
