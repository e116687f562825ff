// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <espalier/osd/evaluation.h>

#include <functional>
#include <optional>
#include <span>
#include <string>

#include "arguments.h"

// Evaluation of arrays by all evaluators: several poses at once, and results in arrays of the
// caller.
namespace espalier::python {

/// An evaluation that maps each set of `sourceRows` × components to `rows` × components.
template <class Real>
struct ArrayEvaluation {
    std::string source;  ///< name of the argument
    Index sourceRows = 0;
    Index rows = 0;
    std::optional<Offset> components =
        {};  ///< required number of components; nothing for any number

    /// Evaluates one set, or all of them.
    std::function<void(std::span<const Real>, const osd::BufferDescriptor&, std::span<Real>)> run;

    bool runTakesAllSets = false;  ///< true if `run` evaluates all sets in one call
};

/// Evaluates arrays of shape (n, k) or (P, n, k), and (n,) if any number of components is allowed.
///
/// \param out an array of Real in C order that receives the result, with its shape; or nothing
/// \throws Error naming the argument, its shape, and the expected shape
template <class Real>
py::array evaluate(const ArrayEvaluation<Real>& evaluation, const ArrayLike& values,
                   const std::optional<ArrayLike>& out);

}  // namespace espalier::python
