// SPDX-License-Identifier: Apache-2.0
#include <immintrin.h>

#include "kernel_sets.h"

#define ESPALIER_REGISTER_BYTES 64

namespace espalier::osd::kernels {
namespace {
#include "kernels_body.h"
}  // namespace

namespace avx512 {
extern const Kernels<float> kFloatKernels = kKernels<float>;
extern const Kernels<double> kDoubleKernels = kKernels<double>;
}  // namespace avx512
}  // namespace espalier::osd::kernels
