// SPDX-License-Identifier: Apache-2.0
#include <immintrin.h>

#include "kernel_sets.h"

#define ESPALIER_REGISTER_BYTES 32

namespace espalier::osd::kernels {
namespace {
#include "kernels_body.h"
}  // namespace

namespace avx2 {
extern const Kernels<float> kFloatKernels = kKernels<float>;
extern const Kernels<double> kDoubleKernels = kKernels<double>;
}  // namespace avx2
}  // namespace espalier::osd::kernels
