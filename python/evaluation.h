// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <espalier/osd/evaluation.h>

#include <functional>
#include <optional>
#include <span>
#include <string>

#include "arguments.h"

// What all evaluators do with arrays: several poses at once, and results into arrays of the caller.
namespace espalier::python {

/// What an evaluator is asked to do: `sets` times from an array of `sourceRows` × components to one
/// of `rows` × components.
template <class Real>
struct ArrayEvaluation {
    std::string source;  ///< name of the argument
    Index sourceRows = 0;
    Index rows = 0;
    std::optional<Offset> components = {};  ///< that there have to be; any number without

    /// Of one set.
    std::function<void(std::span<const Real>, const osd::BufferDescriptor&, std::span<Real>)> run;
};

/// Evaluates arrays of shape (n, k) or (P, n, k), and (n,) where any number of components will do.
///
/// \param out an array of the shape of the result, of Real, in C order, which gets it; or nothing
/// \throws Error naming `values` or `out`, the shape that was expected and the one that it has
template <class Real>
py::array evaluate(const ArrayEvaluation<Real>& evaluation, const ArrayLike& values,
                   const std::optional<ArrayLike>& out);

}  // namespace espalier::python
