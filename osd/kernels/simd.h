// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <espalier/base/api.h>
namespace espalier::osd {

/// The vector instructions with which compiled tables are evaluated.
enum class Simd {
    Baseline,  ///< instructions that every processor of the target has: SSE2 on x86-64
    Avx2,      ///< AVX2 and FMA
    Avx512     ///< AVX-512 F
};

/// Returns the widest instructions that this processor and this build have.
ESPALIER_API Simd bestSimd();

/// Returns true if this processor and this build have these instructions.
ESPALIER_API bool hasSimd(Simd simd);

}  // namespace espalier::osd
