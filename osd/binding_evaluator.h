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

/// The points of a model in some poses of a lattice.
struct DeformedPoints {
    struct Pose {
        std::vector<Point3> points;                  ///< x'
        std::vector<DeformationGradient> gradients;  ///< F, one per point; only on request
    };
    std::vector<Pose> poses;  ///< in the order of the poses
    bind::BindingStatistics statistics;
};

/// Deforms points by a few poses without making D: binds a group of points, applies the poses to it
/// while its rows are in the cache, and forgets the rows. The results have the same bits as those
/// of evaluateBinding(), and differ from evaluateGradients() by rounding.
///
/// \param options BindOptions::gradients makes Pose::gradients
/// \param poses positions of the base vertices, for each pose
/// \throws Error, ArgumentError as bind::bindPoints(); Error if a pose has not one position for
///         each vertex
/// \cost bind::bindInGroups() and O(entries) for each pose; memory for the results, which take less
///       than D for up to kMostPosesWithoutTable poses
/// \cite MacCracken & Joy 1996, section 5
ESPALIER_API DeformedPoints deformPoints(const embed::RestLattice& lattice,
                                         std::span<const Point3> points, const bind::Target& target,
                                         const bind::BindOptions& options,
                                         std::span<const std::vector<Point3>> poses);

/// The most poses for which deformPoints() is the better choice. A row of D takes 400 to 770 bytes
/// in a box, a point of a pose takes 24, and its gradient 72, while rows with gradients take 32
/// more. Each further pose of a Binding takes less time than to bind again.
inline constexpr std::size_t kMostPosesWithoutTable = 4;

}  // namespace espalier::osd
