// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <math.h>

// Functions marked ESPALIER_DEVICE are compiled for the device and for the host. Every product is
// added by addProduct(), so that both give the same results to the last bit.
#if defined(__CUDACC__)
#define ESPALIER_DEVICE __host__ __device__
#define ESPALIER_UNROLL _Pragma("unroll")
#else
#define ESPALIER_DEVICE
#define ESPALIER_UNROLL
#endif

namespace espalier::osd::device {

ESPALIER_DEVICE inline float addProduct(float sum, float a, float b) {
    return fmaf(a, b, sum);
}
ESPALIER_DEVICE inline double addProduct(double sum, double a, double b) {
    return fma(a, b, sum);
}

}  // namespace espalier::osd::device
