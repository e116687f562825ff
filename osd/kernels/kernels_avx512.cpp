// SPDX-License-Identifier: Apache-2.0
#include "kernel_sets.h"

#define ESPALIER_REGISTER_BYTES 64

namespace espalier::osd::kernels {
namespace {
#include "kernels_body.h"
}  // namespace

namespace avx512 {
extern const Kernels<float> kFloatKernels = kFloat;
extern const Kernels<double> kDoubleKernels = kDouble;
}  // namespace avx512
}  // namespace espalier::osd::kernels
