// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <espalier/base/api.h>
#include <espalier/base/index.h>
#include <espalier/base/point.h>
#include <espalier/embed/gradients.h>

#include <Eigen/Core>
#include <span>
#include <vector>

// Makes and combines Gradients.
namespace espalier::embed {

/// Returns the inverse of T X; NaN where T X spans no volume, so that F would have less than six
/// right digits.
/// \param directions T X: the rows are the directions
/// \param sizes for each row, the sum of the sizes of its terms
ESPALIER_API Eigen::Matrix3d inverseOf(const Eigen::Matrix3d& directions,
                                       const Eigen::Vector3d& sizes);

/// Returns true if directions, as rows, span no volume in this sense.
ESPALIER_API bool areFlat(const Eigen::Matrix3d& directions);

/// Returns rows of F − 1 from three directions at each point: three rows for each point, over the
/// same vertices. F maps the directions T X of the rest X to the directions T x of the pose x:
/// Fᵀ = (T X)⁻¹ T x. Rows are empty where T X spans no volume.
/// \param directions T: three rows for each point; they sum to 0
/// \param rest X, one per column
/// \param scale factor for the gradients by X
/// \cost O(entries), in parallel
ESPALIER_API stencils::StencilTable<double> gradientRows(
    const stencils::StencilTable<double>& directions, std::span<const Point3> rest, double scale);

/// Returns the rows of the base vertices over the base, which are the identity.
ESPALIER_API stencils::StencilTable<double> baseVertexRows(Index columnCount);

/// Returns the gradients of points that have these rows.
/// \param rows three rows for each point, over the base; all three are empty for points without
ESPALIER_API Gradients gradientsOfRows(const stencils::StencilTable<double>& rows);

/// Returns the gradients without those of some points.
/// \param points ascending
ESPALIER_API Gradients withoutPoints(Gradients gradients, std::span<const Index> points);

/// Returns the gradients with other numbers of the points: point i becomes numbers[i].
ESPALIER_API Gradients renumbered(Gradients gradients, std::span<const Index> numbers);

/// Puts the gradients of several parts together, and empties the parts. Their vertices stay
/// vertices of their own. The parts have no points in common and no places in a basis, and parts
/// with places in splines have the same spacing.
/// \param columnCount number of base vertices
/// \throws Error if there are too many vertices
ESPALIER_API Gradients merged(std::vector<Gradients>& parts, Index columnCount);

}  // namespace espalier::embed
