// SPDX-License-Identifier: Apache-2.0
#include <espalier/embed/box_least_squares.h>

#include <Eigen/LU>
#include <limits>

namespace espalier::embed {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

/// The multiple of a vector that is nearest to `target`.
double solve(const Vector3d& column, const Vector3d& target) {
    return column.dot(target) / column.squaredNorm();
}

/// Sets the axes that are free so that map · x is nearest to `target`, with the others where they
/// are. By orthogonalisation, which keeps more digits than normal equations. Not finite where the
/// free axes do not determine them.
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
    // To a size whose squares are numbers.
    const double size = map.cwiseAbs().maxCoeff();
    if (!(size > 0)) return low;
    const Matrix3d unitMap = map / size;
    const Vector3d unitTarget = target / size;
    Vector3d best = low;
    double least = std::numeric_limits<double>::infinity();
    // Digits to base 3: free, at the lower end, at the upper end.
    for (int way = 0; way < 27; ++way) {
        const Eigen::Vector3i held(way % 3, way / 3 % 3, way / 9);
        Vector3d x;
        for (int axis = 0; axis < 3; ++axis) x[axis] = held[axis] == 2 ? high[axis] : low[axis];
        solveFree(unitMap, unitTarget, held, x);
        // A way that leads out of the box is not the right one; clamped, it is no nearer than that.
        x = x.cwiseMax(low).cwiseMin(high);
        const double distance = (unitMap * x - unitTarget).squaredNorm();
        if (distance < least) {
            least = distance;
            best = x;
        }
    }
    return best;
}

}  // namespace espalier::embed
