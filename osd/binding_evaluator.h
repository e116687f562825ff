// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <espalier/base/api.h>
#include <espalier/base/deformation_gradient.h>
#include <espalier/base/point.h>
#include <espalier/bind/bind.h>

#include <span>
#include <vector>

namespace espalier::osd {

/// Returns the points of a binding for a pose of the lattice: x + D · (p' − p), where x and p are
/// the points and the lattice at rest. A point that no moved vertex influences is exactly where it
/// was, and the rounding error is relative to the displacement of a point, not to its coordinates.
/// The placement error of the binding cancels too. For many poses use a Deformer, which is faster.
///
/// \param pose positions of the base vertices
/// \throws Error if there is not one position for each column, or the parts of the binding do not
///         fit together
/// \cost O(entries), on all threads; memory for the pose and the result
/// \cite MacCracken & Joy 1996, section 5
ESPALIER_API std::vector<Point3> evaluateBinding(const bind::Binding& binding,
                                                 std::span<const Point3> pose);

/// Returns the deformation gradient of each point for a pose of the lattice, with the weights of
/// the points (bind::PointWeights). A point that no moved vertex influences has exactly the
/// identity.
///
/// \param pose positions of the base vertices
/// \throws Error if there is not one position for each column, the parts of the binding do not fit
///         together, or the binding has no gradients
/// \cost O(entries), on all threads
ESPALIER_API std::vector<DeformationGradient> evaluateGradients(const bind::Binding& binding,
                                                                std::span<const Point3> pose);

}  // namespace espalier::osd
