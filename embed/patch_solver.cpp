// SPDX-License-Identifier: Apache-2.0
#include <espalier/embed/basis_functions.h>
#include <espalier/embed/map_inversion.h>
#include <espalier/embed/patch_solver.h>
#include <espalier/embed/rounded_product.h>

#include <algorithm>

namespace espalier::embed {

using Eigen::Matrix3d;
using Eigen::Vector3d;

namespace {

const Vector3d kCentre = Vector3d::Constant(0.5);

/// Writes the map along each axis as P₀ + u (P₁ − P₀) + w₋₁ (P₋₁ − 2P₀ + P₁) + w₂ (P₀ − 2P₁ + P₂)
/// (see cubicBSpline()), and returns the coefficients of w₋₁, 1, u and w₂, in this order. In an
/// affine lattice the coefficients of w₋₁ and w₂ are 0, and places are as accurate as in a
/// trilinear cell.
TricubicPatch::ControlPoints bends(TricubicPatch::ControlPoints points) {
    for (std::size_t stride = 1; stride < 64; stride *= 4)
        for (std::size_t i = 0; i < 64; ++i) {
            if (i / stride % 4 != 0) continue;
            Vector3d &a = points[i], &b = points[i + stride], &c = points[i + 2 * stride],
                     &d = points[i + 3 * stride];
            const Vector3d step = c - b;
            a = step - (b - a);
            d = (d - c) - step;
            c = step;
        }
    return points;
}

TricubicPatch::ControlPoints relativeTo(const Vector3d& origin,
                                        TricubicPatch::ControlPoints points) {
    for (Vector3d& point : points) point -= origin;
    return points;
}

// A patch is summed along one axis after the other: over w to 16 points, over v to 4, over u to
// one. Matrices of this shape fill the vector registers.
using Solid = Eigen::Matrix<double, 48, 4>;
using Sheet = Eigen::Matrix<double, 12, 4>;
using Line = Eigen::Matrix<double, 3, 4>;

Eigen::Map<const Sheet> asSheet(const Eigen::Matrix<double, 48, 1>& points) {
    return Eigen::Map<const Sheet>(points.data());
}
Eigen::Map<const Line> asLine(const Eigen::Matrix<double, 12, 1>& points) {
    return Eigen::Map<const Line>(points.data());
}

}  // namespace

TricubicMap::TricubicMap(const TricubicPatch::ControlPoints& points, double spacing)
    : coefficients_(bends(points)), spacing_(spacing) {}

Trilinear::Tangent TricubicMap::tangent(const Vector3d& uvw) const {
    std::array<Eigen::Vector4d, 3> values, slopes;
    for (Eigen::Index axis = 0; axis < 3; ++axis) {
        const OuterWeights outer = outerWeights(uvw[axis], {.spacing = spacing_});
        values[axis] = {outer.low, 1, uvw[axis], outer.high};
        slopes[axis] = {outer.lowSlope, 0, 1, outer.highSlope};
    }
    const Eigen::Map<const Solid> solid(coefficients_.front().data());
    const auto sheet = roundedProduct(solid, values[2]), sheetW = roundedProduct(solid, slopes[2]);
    const auto line = roundedProduct(asSheet(sheet), values[1]);
    const auto lineV = roundedProduct(asSheet(sheet), slopes[1]);
    const auto lineW = roundedProduct(asSheet(sheetW), values[1]);
    Trilinear::Tangent tangent;
    tangent.position = roundedProduct(asLine(line), values[0]);
    tangent.jacobian.col(0) = roundedProduct(asLine(line), slopes[0]);
    tangent.jacobian.col(1) = roundedProduct(asLine(lineV), values[0]);
    tangent.jacobian.col(2) = roundedProduct(asLine(lineW), values[0]);
    return tangent;
}

Vector3d TricubicMap::position(const Vector3d& uvw) const {
    std::array<Eigen::Vector4d, 3> values;
    for (Eigen::Index axis = 0; axis < 3; ++axis) {
        const OuterWeights outer = outerWeights(uvw[axis], {.spacing = spacing_});
        values[axis] = {outer.low, 1, uvw[axis], outer.high};
    }
    const Eigen::Map<const Solid> solid(coefficients_.front().data());
    const auto sheet = roundedProduct(solid, values[2]);
    const auto line = roundedProduct(asSheet(sheet), values[1]);
    return roundedProduct(asLine(line), values[0]);
}

/// The map, moved so that a point is at the origin.
struct PatchSolver::MapAround {
    const TricubicMap& map;
    Vector3d point;

    Trilinear::Tangent tangent(const Vector3d& uvw) const {
        Trilinear::Tangent tangent = map.tangent(uvw);
        tangent.position -= point;
        return tangent;
    }
    Vector3d position(const Vector3d& uvw) const { return map.position(uvw) - point; }
};

PatchSolver::PatchSolver(const TricubicPatch::ControlPoints& points, double spacing)
    : origin_(TricubicMap(points, spacing).position(kCentre)),
      map_(relativeTo(origin_, points), spacing) {
    const auto atCentre = map_.tangent(kCentre);
    middle_ = atCentre.position;
    inverse_ = atCentre.jacobian.inverse();
    // About ten units in the last place of a coordinate.
    constexpr double kCoordinateRounding = 2e-15;
    double largest = 0;
    for (const Vector3d& control : points)
        largest = std::max(largest, control.lpNorm<Eigen::Infinity>());
    length_ = kCoordinateRounding * largest;
    rounding_ = length_ * inverse_.cwiseAbs().rowwise().sum().maxCoeff();
    // A polynomial is in the hull of its Bézier points. The rounding of these points, and of the
    // point, is also within some units in the last place of the largest coordinate.
    hull_ = AffineHull(inverse_);
    const TricubicPatch::ControlPoints bezier = bezierPoints(relativeTo(origin_, points), spacing);
    for (const Vector3d& control : bezier) {
        hull_.extend(control);
        box_.extend(control);
    }
    hull_.widen(2 * rounding_);
    box_.min().array() -= 2 * length_;
    box_.max().array() += 2 * length_;
    // The derivative of the polynomial by u is in the hull of three times the differences along u.
    // The derivative of a level is a mean of derivatives of the polynomial, so it is in this hull,
    // too.
    spread_.setZero();
    const Matrix3d thrice = 3 * inverse_;
    std::size_t stride = 1;
    for (Eigen::Index axis = 0; axis < 3; ++axis, stride *= 4)
        for (std::size_t i = 0; i < 64; ++i) {
            if (i / stride % 4 == 3) continue;
            Vector3d off = roundedProduct(thrice, bezier[i + stride] - bezier[i]);
            off[axis] -= 1;
            spread_.col(axis) = spread_.col(axis).cwiseMax(off.cwiseAbs());
        }
}

PatchSolver::Found PatchSolver::find(const Vector3d& position) const {
    constexpr double kOnPatchFace = 1e-9;
    const Vector3d point = position - origin_;
    if (!box_.contains(point)) return {Answer::Outside, {}};
    // This excludes most patches that do not contain the point. In irregular regions 3 of 4 patches
    // asked do not contain it.
    if (!hull_.contains(point)) return {Answer::Outside, {}};
    const MapAround map{map_, point};
    if (inverse_.allFinite()) {
        const Vector3d start = kCentre - roundedProduct(inverse_, middle_ - point);
        // The first cut of isExcluded(), which needs no evaluation of the map.
        const Vector3d reach = (spread_.rowwise().sum().array() + 1) / 2 + kOnPatchFace + rounding_;
        if (((start - kCentre).array().abs() > reach.array()).any()) return {Answer::Outside, {}};
        const auto uvw = findOrigin(map, start.cwiseMax(0).cwiseMin(1));
        if (uvw && isInUnitCube(*uvw, kOnPatchFace + rounding_)) return {Answer::Inside, *uvw};
        if (isExcluded(map)) return {Answer::Outside, {}};
        // The polynomial contains the point beyond the patch. A strongly bent patch might contain
        // the point, too.
        if (uvw) return {Answer::Undecided, {}};
    }
    const Vector3d nearest = nearestToOrigin(map);
    if (map.position(nearest).norm() <= 2 * length_) return {Answer::Inside, nearest};
    return {Answer::Undecided, {}};
}

/// Krawczyk's test. For a box with centre c and half sides r, let A be the inverse of a Jacobian
/// and E a bound of |A J − identity|. Then any solution in the box is within E r of c − A F(c). The
/// box is cut to this region repeatedly; if nothing is left, there is no solution.
bool PatchSolver::isExcluded(const MapAround& map) const {
    constexpr int kMaxCuts = 50;
    // Rounding of E.
    constexpr double kSlack = 1e-12;
    // Stop when a cut leaves more than this fraction: the box hardly gets smaller.
    constexpr double kLeastCut = 0.9;
    Vector3d low = Vector3d::Zero(), high = Vector3d::Ones();
    for (int cut = 0; cut < kMaxCuts; ++cut) {
        const Vector3d centre = (low + high) / 2, before = high - low;
        const Vector3d middle = centre - roundedProduct(inverse_, map.position(centre));
        const Vector3d reach = (roundedProduct(spread_, before) / 2).array() + kSlack + rounding_;
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

/// Let A be inverse_, E be spread_, and d = |x − y|. If f(x) = f(y), then A (f(x) − f(y)) = 0
/// differs from x − y by at most E d: d ≤ E d ≤ E² d ≤ … If a power of E is below 1, then d = 0.
bool PatchSolver::isOneToOne() const {
    constexpr int kSquares = 5;  // E³² tells all but spectral radii close to 1
    if (!inverse_.allFinite()) return false;
    Matrix3d power = spread_;
    for (int square = 0; square < kSquares; ++square) {
        const Matrix3d factor = power;
        for (Eigen::Index axis = 0; axis < 3; ++axis)
            power.col(axis) = roundedProduct(factor, factor.col(axis));
    }
    return power.rowwise().sum().maxCoeff() < 1;
}

Vector3d PatchSolver::nearest(const Vector3d& point) const {
    return nearestToOrigin(MapAround{map_, point - origin_});
}

}  // namespace espalier::embed
