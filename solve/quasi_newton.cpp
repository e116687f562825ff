// SPDX-License-Identifier: Apache-2.0
#include "quasi_newton.h"

#include <espalier/base/progress.h>

#include <deque>
#include <vector>

namespace espalier::solve {
namespace {

using Columns = Eigen::MatrixX3d;

double product(const Columns& a, const Columns& b) {
    return (a.array() * b.array()).sum();
}

/// A step, and the change of the gradient along it.
struct Change {
    Columns step, gradient;
    double scale = 0;  ///< 1 / (step · gradient)
};

/// Returns −H g for the inverse Hessian H that the last changes make of the model.
Columns directionFrom(const Columns& gradient, const std::deque<Change>& changes,
                      FunctionRef<Columns(const Columns&)> inverse) {
    Columns rest = gradient;
    std::vector<double> parts(changes.size());
    for (std::size_t i = changes.size(); i-- > 0;) {
        parts[i] = changes[i].scale * product(changes[i].step, rest);
        rest -= parts[i] * changes[i].gradient;
    }
    Columns direction = inverse(rest);
    for (std::size_t i = 0; i < changes.size(); ++i)
        direction += changes[i].step *
                     (parts[i] - changes[i].scale * product(changes[i].gradient, direction));
    return -direction;
}

}  // namespace

int minimise(Columns& x, FunctionRef<double(const Columns&, Columns&)> value,
             FunctionRef<Columns(const Columns&)> inverse, const QuasiNewtonOptions& options) {
    constexpr std::size_t kMaxChanges = 10;
    constexpr double kDecrease = 1e-4;   // Armijo's condition
    constexpr double kShortest = 1e-12;  // Beyond, rounding decides about the decrease.
    constexpr double kCurved = 1e-12;    // Rounding of the product of a step and a gradient.
    constexpr int kShortSteps = 3;
    Columns gradient(x.rows(), 3), next, nextGradient(x.rows(), 3);
    double current = value(x, gradient);
    std::deque<Change> changes;
    int iterations = 0, shortSteps = 0;
    while (iterations < options.maxIterations && shortSteps < kShortSteps) {
        checkCancelled();
        const Columns direction = directionFrom(gradient, changes, inverse);
        const double slope = product(gradient, direction);
        const double farthest = direction.rowwise().norm().maxCoeff();
        double length = farthest > options.maxStep ? options.maxStep / farthest : 1, found = 0;
        for (; length > kShortest; length *= 0.5) {
            next = x + length * direction;
            found = value(next, nextGradient);
            if (found <= current + kDecrease * length * slope) break;
        }
        if (!(length > kShortest)) {
            if (changes.empty()) break;
            changes.clear();  // Their model of the Hessian is wrong here.
            continue;
        }
        ++iterations;
        Change change{next - x, nextGradient - gradient, 0};
        shortSteps =
            change.step.rowwise().norm().maxCoeff() <= options.tolerance ? shortSteps + 1 : 0;
        const double curvature = product(change.step, change.gradient);
        if (curvature > kCurved * change.step.stableNorm() * change.gradient.stableNorm()) {
            change.scale = 1 / curvature;
            changes.push_back(std::move(change));
            if (changes.size() > kMaxChanges) changes.pop_front();
        }
        x.swap(next);
        gradient.swap(nextGradient);
        current = found;
    }
    return iterations;
}

}  // namespace espalier::solve
