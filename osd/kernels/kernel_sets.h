// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <espalier/osd/kernels/kernels.h>

// The kernels that each kernels_*.cpp defines.
namespace espalier::osd::kernels {

namespace baseline {
extern const Kernels<float> kFloatKernels;
extern const Kernels<double> kDoubleKernels;
}  // namespace baseline

#ifdef ESPALIER_X86_64
namespace avx2 {
extern const Kernels<float> kFloatKernels;
extern const Kernels<double> kDoubleKernels;
}  // namespace avx2

namespace avx512 {
extern const Kernels<float> kFloatKernels;
extern const Kernels<double> kDoubleKernels;
}  // namespace avx512
#endif

}  // namespace espalier::osd::kernels
