// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <espalier/base/function_ref.h>

#include <Eigen/Core>

// Minimises functions of points; not installed.
namespace espalier::solve {

/// Bounds of a minimisation.
struct QuasiNewtonOptions {
    /// The minimisation ends if no point moves by more than this in three steps one after the
    /// other; a single step may be short because the function is infinite ahead.
    double tolerance = 0;

    double maxStep = 0;  ///< no point moves by more in one step; above 0
    int maxIterations = 1;
};

/// Minimises a function of points by L-BFGS with a model of the Hessian. Each step decreases the
/// function, so that the points never enter a region where it is infinite.
/// \param x where to start; the value there is finite. Receives the minimum
/// \param value value(x, gradient) returns the function, infinite where x is not allowed, and if
///        it is finite, its derivatives by the rows of x
/// \param inverse inverse(g) returns the inverse of the model of the Hessian times g
/// \returns the number of steps
/// \cite Nocedal & Wright 2006, Numerical Optimization, algorithms 7.4 and 7.5
/// \cite Liu, Bouaziz & Kavan 2017, Quasi-Newton methods for real-time simulation of hyperelastic
///       materials, section 4: the matrix of as-rigid-as-possible as the model
int minimise(Eigen::MatrixX3d& x,
             FunctionRef<double(const Eigen::MatrixX3d&, Eigen::MatrixX3d&)> value,
             FunctionRef<Eigen::MatrixX3d(const Eigen::MatrixX3d&)> inverse,
             const QuasiNewtonOptions& options);

}  // namespace espalier::solve
