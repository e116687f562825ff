// SPDX-License-Identifier: Apache-2.0
#include "patch_solver.h"

#include <espalier/embed/basis_functions.h>
#include <espalier/embed/map_inversion.h>

#include <algorithm>

namespace espalier::limit {

using Eigen::Matrix3d;
using Eigen::Vector3d;

namespace {

const Vector3d kCentre = Vector3d::Constant(0.5);

Eigen::Vector4d weightsAt(const Vector3d& uvw, std::size_t axis, int order) {
    return Eigen::Vector4d(embed::cubicBSpline(uvw[static_cast<Eigen::Index>(axis)], order).data());
}

// A patch is summed along one axis after the other: over w to 16 points, over v to 4, over u to
// one. Matrices of this shape fill the vector registers.
using Solid = Eigen::Matrix<double, 48, 4>;
using Sheet = Eigen::Matrix<double, 12, 4>;
using Line = Eigen::Matrix<double, 3, 4>;

}  // namespace

TricubicMap TricubicMap::around(const Vector3d& point) const {
    TricubicMap result = *this;
    for (Vector3d& control : result.points_) control -= point;
    return result;
}

embed::Trilinear::Tangent TricubicMap::tangent(const Vector3d& uvw) const {
    std::array<Eigen::Vector4d, 3> values, slopes;
    for (std::size_t axis = 0; axis < 3; ++axis) {
        values[axis] = weightsAt(uvw, axis, 0);
        slopes[axis] = weightsAt(uvw, axis, 1);
    }
    const Eigen::Map<const Solid> solid(points_.front().data());
    Sheet sheet, sheetW;
    Eigen::Map<Eigen::Matrix<double, 48, 1>>(sheet.data()).noalias() = solid * values[2];
    Eigen::Map<Eigen::Matrix<double, 48, 1>>(sheetW.data()).noalias() = solid * slopes[2];
    Line line, lineV, lineW;
    Eigen::Map<Eigen::Matrix<double, 12, 1>>(line.data()).noalias() = sheet * values[1];
    Eigen::Map<Eigen::Matrix<double, 12, 1>>(lineV.data()).noalias() = sheet * slopes[1];
    Eigen::Map<Eigen::Matrix<double, 12, 1>>(lineW.data()).noalias() = sheetW * values[1];
    embed::Trilinear::Tangent tangent;
    tangent.position.noalias() = line * values[0];
    tangent.jacobian.col(0).noalias() = line * slopes[0];
    tangent.jacobian.col(1).noalias() = lineV * values[0];
    tangent.jacobian.col(2).noalias() = lineW * values[0];
    return tangent;
}

Vector3d TricubicMap::position(const Vector3d& uvw) const {
    const Eigen::Map<const Solid> solid(points_.front().data());
    Sheet sheet;
    Eigen::Map<Eigen::Matrix<double, 48, 1>>(sheet.data()).noalias() = solid * weightsAt(uvw, 2, 0);
    Line line;
    Eigen::Map<Eigen::Matrix<double, 12, 1>>(line.data()).noalias() = sheet * weightsAt(uvw, 1, 0);
    return line * weightsAt(uvw, 0, 0);
}

PatchSolver::PatchSolver(const TricubicPatch::ControlPoints& points) : map_(points) {
    const auto atCentre = map_.tangent(kCentre);
    middle_ = atCentre.position;
    inverse_ = atCentre.jacobian.inverse();
    // About ten units in the last place of a coordinate.
    constexpr double kRounding = 2e-15;
    double largest = 0;
    for (const Vector3d& control : points)
        largest = std::max(largest, control.lpNorm<Eigen::Infinity>());
    length_ = kRounding * largest;
    rounding_ = length_ * inverse_.cwiseAbs().rowwise().sum().maxCoeff();
    // A polynomial is in the hull of its Bézier points. The rounding of these points, and of the
    // point, is also within some units in the last place of the largest coordinate.
    hull_ = embed::AffineHull(inverse_);
    for (const Vector3d& control : bezierPoints(points)) {
        hull_.extend(control);
        box_.extend(control);
    }
    hull_.widen(2 * rounding_);
    box_.min().array() -= 2 * length_;
    box_.max().array() += 2 * length_;
    // A derivative by u is a spline whose control points are the differences along u: it is in the
    // hull of these.
    spread_.setZero();
    std::size_t stride = 1;
    for (Eigen::Index axis = 0; axis < 3; ++axis, stride *= 4)
        for (std::size_t i = 0; i < 64; ++i) {
            if (i / stride % 4 == 3) continue;
            Vector3d off = inverse_ * (points[i + stride] - points[i]);
            off[axis] -= 1;
            spread_.col(axis) = spread_.col(axis).cwiseMax(off.cwiseAbs());
        }
}

PatchSolver::Found PatchSolver::find(const Vector3d& point) const {
    constexpr double kOnFace = 1e-9;
    if (!box_.contains(point)) return {Answer::Outside, {}};
    // This excludes most patches that do not contain the point. In irregular regions 3 of 4 patches
    // asked do not contain it.
    if (!hull_.contains(point)) return {Answer::Outside, {}};
    const TricubicMap map = map_.around(point);
    if (inverse_.allFinite()) {
        const Vector3d start = kCentre - inverse_ * (middle_ - point);
        const auto uvw = embed::findOrigin(map, start.cwiseMax(0).cwiseMin(1));
        if (uvw && embed::isInUnitCube(*uvw, kOnFace + rounding_)) return {Answer::Inside, *uvw};
        if (isExcluded(map)) return {Answer::Outside, {}};
        // The polynomial contains the point beyond the patch. A strongly bent patch might contain
        // the point, too.
        if (uvw) return {Answer::Undecided, {}};
    }
    const Vector3d nearest = embed::nearestToOrigin(map);
    if (map.position(nearest).norm() <= 2 * length_) return {Answer::Inside, nearest};
    return {Answer::Undecided, {}};
}

/// Krawczyk's test. For a box with centre c and half sides r, let A be the inverse of a Jacobian
/// and E a bound of |A J − identity|. Then any solution in the box is within E r of c − A F(c). The
/// box is cut to this region repeatedly; if nothing is left, there is no solution.
bool PatchSolver::isExcluded(const TricubicMap& map) const {
    constexpr int kMaxCuts = 50;
    // Rounding of E.
    constexpr double kSlack = 1e-12;
    // Stop when a cut leaves more than this fraction: the box hardly gets smaller.
    constexpr double kLeastCut = 0.9;
    Vector3d low = Vector3d::Zero(), high = Vector3d::Ones();
    for (int cut = 0; cut < kMaxCuts; ++cut) {
        const Vector3d centre = (low + high) / 2, before = high - low;
        const Vector3d middle = centre - inverse_ * map.position(centre);
        const Vector3d reach = (spread_ * before / 2).array() + kSlack + rounding_;
        low = low.cwiseMax(middle - reach);
        high = high.cwiseMin(middle + reach);
        if ((low.array() > high.array()).any()) return true;
        // This form of the comparison also stops at NaN.
        if (!((high - low).sum() < kLeastCut * before.sum())) return false;
    }
    return false;
}

bool PatchSolver::isNearlyLinear() const {
    return spread_.rowwise().sum().maxCoeff() < 0.5;
}

Vector3d PatchSolver::nearest(const Vector3d& point) const {
    return embed::nearestToOrigin(map_.around(point));
}

}  // namespace espalier::limit
