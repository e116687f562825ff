// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <espalier/base/api.h>
#include <espalier/osd/evaluation.h>

namespace espalier::osd {

/// Evaluates a table as it is, on all threads. Results do not depend on the number of threads, bit
/// for bit.
struct ESPALIER_API CpuEvaluator {
    /// Evaluates rows of a table; see checkEvaluation() for the contract.
    /// \cost O(entries × components)
    template <class Real>
    static void evaluate(const stencils::StencilTable<Real>& table, Values<Real> source,
                         const BufferDescriptor& sourceLayout, MutableValues<Real> destination,
                         const BufferDescriptor& destinationLayout, RowRange rows,
                         const Addend<std::type_identity_t<Real>>& addend = {});
};

/// Evaluates a table in the simplest way, on one thread. All other evaluators are tested against
/// it.
struct ESPALIER_API ReferenceEvaluator {
    /// Evaluates rows of a table; see checkEvaluation() for the contract.
    /// \cost O(entries × components)
    template <class Real>
    static void evaluate(const stencils::StencilTable<Real>& table, Values<Real> source,
                         const BufferDescriptor& sourceLayout, MutableValues<Real> destination,
                         const BufferDescriptor& destinationLayout, RowRange rows,
                         const Addend<std::type_identity_t<Real>>& addend = {});
};

}  // namespace espalier::osd
