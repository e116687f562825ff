// SPDX-License-Identifier: Apache-2.0
#include "kernel_sets.h"

namespace espalier::osd {

bool hasSimd(Simd simd) {
    switch (simd) {
#ifdef ESPALIER_X86_64
        case Simd::Avx2:
            return __builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma");
        case Simd::Avx512:
            return __builtin_cpu_supports("avx512f") && hasSimd(Simd::Avx2);
#endif
        default:
            return simd == Simd::Baseline;
    }
}

Simd bestSimd() {
    if (hasSimd(Simd::Avx512)) return Simd::Avx512;
    return hasSimd(Simd::Avx2) ? Simd::Avx2 : Simd::Baseline;
}

}  // namespace espalier::osd

namespace espalier::osd::kernels {

template <>
const Kernels<float>& kernelsFor<float>([[maybe_unused]] Simd simd) {
#ifdef ESPALIER_X86_64
    if (simd == Simd::Avx512) return avx512::kFloatKernels;
    if (simd == Simd::Avx2) return avx2::kFloatKernels;
#endif
    return baseline::kFloatKernels;
}

template <>
const Kernels<double>& kernelsFor<double>([[maybe_unused]] Simd simd) {
#ifdef ESPALIER_X86_64
    if (simd == Simd::Avx512) return avx512::kDoubleKernels;
    if (simd == Simd::Avx2) return avx2::kDoubleKernels;
#endif
    return baseline::kDoubleKernels;
}

}  // namespace espalier::osd::kernels
