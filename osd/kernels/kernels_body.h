// SPDX-License-Identifier: Apache-2.0
// The kernels. Each kernels_*.cpp includes this file once, inside its own namespace and with its
// own processor flags. Hence neither this file nor the files that it includes have a #pragma once,
// and they include nothing else.

/// A vector of `count` numbers. It takes several registers if a register of the processor is
/// shorter.
template <class Real, int count>
struct Vector {
    typedef Real Type __attribute__((vector_size(count * sizeof(Real)), may_alias));
};

template <class V, class Real>
const V& at(const Real* address) {
    return *reinterpret_cast<const V*>(address);
}

/// Reads numbers at an address that need not be aligned.
template <class V, class Real>
V load(const Real* address) {
    V result;
    __builtin_memcpy(&result, address, sizeof result);
    return result;
}

/// How many numbers a register of this processor holds.
template <class Real>
constexpr int kRegister = ESPALIER_REGISTER_BYTES / sizeof(Real);

/// Returns true if a row is in the range to be evaluated.
template <class Real>
bool isInRange(Index row, const Destination<Real>& to) {
    return to.isWhole || (row >= to.first && row < to.last);
}

/// The slots in an entry of the addend that components `from` to `from` + width − 1 add.
template <int width>
struct AddendSlots {
    Offset at[width];

    AddendSlots(Offset from, Offset addendLength) {
        if (from >= addendLength) from %= addendLength;
        for (int c = 0; c < width; ++c) {
            at[c] = from;
            from = from + 1 < addendLength ? from + 1 : 0;
        }
    }
};

/// Calls step<width>(from) until all components are done, at most 4 at a time.
template <class Step>
void forComponents(Offset length, Step step) {
    Offset from = 0;
    for (; from + 4 < length; from += 4) step.template operator()<4>(from);
    switch (length - from) {
        case 1:
            return step.template operator()<1>(from);
        case 2:
            return step.template operator()<2>(from);
        case 3:
            return step.template operator()<3>(from);
        default:
            return step.template operator()<4>(from);
    }
}

#include "fused_products.h"
// These sum with addProduct():
#include "adjoint_kernels.h"
#include "factor_kernels.h"
#include "panel_kernels.h"
#include "row_kernels.h"

template <class Real>
constexpr Kernels<Real> kKernels = {
    evaluatePanels<Real>,  evaluateProducts<Real>, evaluateRows<Real>, evaluateAdjoint<Real>,
    kAdjointColumns<Real>, interleave<Real>,       factorize<Real>};
