// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <espalier/base/api.h>
namespace espalier::osd {

/// Vector instructions that compiled tables are evaluated with.
enum class Simd {
    Baseline,  ///< those that every processor of the target has: SSE2 on x86-64
    Avx2,      ///< AVX2 and FMA
    Avx512     ///< AVX-512 F
};

/// The most that this processor has.
ESPALIER_API Simd bestSimd();

/// Whether this processor, and this build, has them.
ESPALIER_API bool hasSimd(Simd simd);

}  // namespace espalier::osd
