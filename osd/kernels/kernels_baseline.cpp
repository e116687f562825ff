// SPDX-License-Identifier: Apache-2.0
#ifdef __aarch64__
#include <arm_neon.h>
#endif

#include "kernel_sets.h"

#define ESPALIER_REGISTER_BYTES 16

namespace espalier::osd::kernels {
namespace {
#include "kernels_body.h"
}  // namespace

namespace baseline {
extern const Kernels<float> kFloatKernels = kKernels<float>;
extern const Kernels<double> kDoubleKernels = kKernels<double>;
}  // namespace baseline
}  // namespace espalier::osd::kernels
