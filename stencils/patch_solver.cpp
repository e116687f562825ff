// SPDX-License-Identifier: Apache-2.0
#include "patch_solver.h"

#include <espalier/stencils/basis_functions.h>

#include <algorithm>

#include "map_inversion.h"

namespace espalier::stencils {

using Eigen::Matrix3d;
using Eigen::Vector3d;

namespace {

const Vector3d kCentre = Vector3d::Constant(0.5);

Vector3d combine(const std::array<double, 4>& weights, const Vector3d* points, std::size_t stride) {
    return weights[0] * points[0] + weights[1] * points[stride] + weights[2] * points[2 * stride] +
           weights[3] * points[3 * stride];
}

}  // namespace

TricubicMap TricubicMap::around(const Vector3d& point) const {
    TricubicMap result = *this;
    for (Vector3d& control : result.points_) control -= point;
    return result;
}

Trilinear::Tangent TricubicMap::tangent(const Vector3d& uvw) const {
    std::array<std::array<double, 4>, 3> values, slopes;
    for (std::size_t axis = 0; axis < 3; ++axis) {
        values[axis] = cubicBSpline(uvw[static_cast<Eigen::Index>(axis)], 0);
        slopes[axis] = cubicBSpline(uvw[static_cast<Eigen::Index>(axis)], 1);
    }
    // Axis by axis: along w to 16 points, along v to 4, along u to one.
    std::array<Vector3d, 16> sheet, sheetW;
    for (std::size_t i = 0; i < 16; ++i) {
        sheet[i] = combine(values[2], &points_[i], 16);
        sheetW[i] = combine(slopes[2], &points_[i], 16);
    }
    std::array<Vector3d, 4> line, lineV, lineW;
    for (std::size_t i = 0; i < 4; ++i) {
        line[i] = combine(values[1], &sheet[i], 4);
        lineV[i] = combine(slopes[1], &sheet[i], 4);
        lineW[i] = combine(values[1], &sheetW[i], 4);
    }
    Trilinear::Tangent tangent;
    tangent.position = combine(values[0], line.data(), 1);
    tangent.jacobian.col(0) = combine(slopes[0], line.data(), 1);
    tangent.jacobian.col(1) = combine(values[0], lineV.data(), 1);
    tangent.jacobian.col(2) = combine(values[0], lineW.data(), 1);
    return tangent;
}

PatchSolver::PatchSolver(const TricubicPatch::ControlPoints& points) : map_(points) {
    inverse_ = map_.tangent(kCentre).jacobian.inverse();
    // Some ten units in the last place of a coordinate.
    constexpr double kRounding = 2e-15;
    double largest = 0;
    for (const Vector3d& control : points)
        largest = std::max(largest, control.lpNorm<Eigen::Infinity>());
    rounding_ = kRounding * largest * inverse_.cwiseAbs().rowwise().sum().maxCoeff();
    // A derivative by u is a spline whose control points are the differences along u: it lies in
    // their hull.
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
    if (!inverse_.allFinite()) return {};
    const TricubicMap map = map_.around(point);
    const Vector3d start = kCentre - inverse_ * map.position(kCentre);
    const auto uvw = findOrigin(map, start.cwiseMax(0).cwiseMin(1));
    if (uvw && isInUnitCube(*uvw, kOnFace + rounding_)) return {Answer::Here, *uvw};
    return {isExcluded(map) ? Answer::NotHere : Answer::Undecided, {}};
}

/// Krawczyk's test. With c the centre of a box, r half its sides, A the inverse of a Jacobian and E
/// the most that A J is off the identity, any solution in the box lies within E r of c − A F(c). So
/// the box may be cut to that, again and again; there is none if nothing is left.
bool PatchSolver::isExcluded(const TricubicMap& map) const {
    constexpr int kMostCuts = 50;
    // Rounding of what was found of E.
    constexpr double kSlack = 1e-12;
    // A box that is cut by less than this hardly gets smaller.
    constexpr double kLeastCut = 0.9;
    Vector3d low = Vector3d::Zero(), high = Vector3d::Ones();
    for (int cut = 0; cut < kMostCuts; ++cut) {
        const Vector3d centre = (low + high) / 2, before = high - low;
        const Vector3d middle = centre - inverse_ * map.position(centre);
        const Vector3d reach = (spread_ * before / 2).array() + kSlack + rounding_;
        low = low.cwiseMax(middle - reach);
        high = high.cwiseMin(middle + reach);
        if ((low.array() > high.array()).any()) return true;
        // Written so that what is not a number ends it.
        if (!((high - low).sum() < kLeastCut * before.sum())) return false;
    }
    return false;
}

bool PatchSolver::isNearlyLinear() const {
    return spread_.rowwise().sum().maxCoeff() < 0.5;
}

Vector3d PatchSolver::nearest(const Vector3d& point) const {
    return nearestToOrigin(map_.around(point));
}

}  // namespace espalier::stencils
