// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "../compile/table_compiler.h"

namespace espalier::osd::device {

/// The highest level whose rows are recognized as rows of a spline.
inline constexpr Index kMaxSplineLevel = 10;

/// Upper bound of Σ |w − w'| in units of ε, over the weights w of a row and the weights w' of a
/// spline at its parameters (splineWeights()).
inline constexpr double kSplineBound = 8;

/// Stores rows of uniform cubic B-splines as three parameters instead of their factors: points in
/// regular cells, bound to the limit or to a level.
///
/// The parameters follow from the factors alone. Along each axis, the first moment of the weights
/// is the parameter plus a constant, since the spline reproduces linear functions. Each row is
/// compared with the weights at its parameters; a row that differs by more than kSplineBound keeps
/// its factors. If one of six sample rows differs, the whole group keeps its factors. So do groups
/// that share their factors with other groups: these are read from a cache.
///
/// \param rows is changed: the new groups come in the order of the old ones. Tasks and runs stay
/// \return Group::spline of each group
/// \cost O(numbers)
template <class Real>
std::vector<Index> storeSplineParameters(CompiledRows<Real>& rows);

}  // namespace espalier::osd::device
