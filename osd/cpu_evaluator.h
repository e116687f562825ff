// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <espalier/base/api.h>
#include <espalier/osd/evaluation.h>

namespace espalier::osd {

/// On all threads. The result does not depend on their number, bit for bit.
struct ESPALIER_API CpuEvaluator {
    /// Evaluates rows of a table; see checkEvaluation() for the contract.
    /// \cost O(entries × components)
    template <class Real>
    static void evaluate(const stencils::StencilTable<Real>& table, Values<Real> source,
                         const BufferDescriptor& sourceLayout, MutableValues<Real> destination,
                         const BufferDescriptor& destinationLayout, RowRange rows);
};

/// The contract in the fewest words, on one thread: what every other evaluator is tested against.
struct ESPALIER_API ReferenceEvaluator {
    /// Evaluates rows of a table; see checkEvaluation() for the contract.
    /// \cost O(entries × components)
    template <class Real>
    static void evaluate(const stencils::StencilTable<Real>& table, Values<Real> source,
                         const BufferDescriptor& sourceLayout, MutableValues<Real> destination,
                         const BufferDescriptor& destinationLayout, RowRange rows);
};

}  // namespace espalier::osd
