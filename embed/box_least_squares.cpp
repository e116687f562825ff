// SPDX-License-Identifier: Apache-2.0
#include <espalier/embed/box_least_squares.h>
#include <espalier/embed/rounded_product.h>

#include <Eigen/LU>
#include <limits>

namespace espalier::embed {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

/// Returns the factor by which to multiply a vector so that it is nearest to `target`.
double solve(const Vector3d& column, const Vector3d& target) {
    return column.dot(target) / column.squaredNorm();
}

/// Solves for the free axes so that map · x is nearest to `target`, with the held axes unchanged.
/// Uses orthogonalisation, which keeps more digits than normal equations. The result is not finite
/// if the problem does not determine the free axes.
void solveFree(const Matrix3d& map, const Vector3d& target, const Eigen::Vector3i& held,
               Vector3d& x) {
    Eigen::Vector3i free = {0, 0, 0};
    int count = 0;
    Vector3d rest = target;
    for (int axis = 0; axis < 3; ++axis) {
        if (held[axis] == 0)
            free[count++] = axis;
        else
            rest -= x[axis] * map.col(axis);
    }
    if (count == 1) {
        x[free[0]] = solve(map.col(free[0]), rest);
    } else if (count == 2) {
        const Vector3d a = map.col(free[0]), b = map.col(free[1]);
        x[free[1]] = solve(b - solve(a, b) * a, rest);
        x[free[0]] = solve(a, rest - x[free[1]] * b);
    } else if (count == 3) {
        x = map.partialPivLu().solve(rest);
    }
}

}  // namespace

Vector3d nearestInBox(const Matrix3d& map, const Vector3d& target, const Vector3d& low,
                      const Vector3d& high) {
    // Scale so that squares neither overflow nor underflow.
    const double size = map.cwiseAbs().maxCoeff();
    if (!(size > 0)) return low;
    const Matrix3d unitMap = map / size;
    const Vector3d unitTarget = target / size;
    Vector3d best = low;
    double least = std::numeric_limits<double>::infinity();
    // The base-3 digits of `way` tell for each axis: 0 free, 1 at the lower bound, 2 at the upper
    // bound.
    for (int way = 0; way < 27; ++way) {
        const Eigen::Vector3i held(way % 3, way / 3 % 3, way / 9);
        Vector3d x;
        for (int axis = 0; axis < 3; ++axis) x[axis] = held[axis] == 2 ? high[axis] : low[axis];
        solveFree(unitMap, unitTarget, held, x);
        // If a combination leads out of the box, it is not the solution; clamped, it is at least as
        // far from the target.
        x = x.cwiseMax(low).cwiseMin(high);
        const double distance = (roundedProduct(unitMap, x) - unitTarget).squaredNorm();
        if (distance < least) {
            least = distance;
            best = x;
        }
    }
    return best;
}

}  // namespace espalier::embed
