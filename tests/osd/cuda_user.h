// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <espalier/osd/cuda/cuda_evaluator.h>

// A user's program that has CUDA code of its own, and uses our points on the device.
namespace user {

/// Evaluates, and then raises all points by a kernel on the same stream.
void raise(const espalier::osd::CudaEvaluator<float>& table,
           const espalier::osd::CudaBuffer<float>& pose, espalier::osd::CudaBuffer<float>& points,
           float height, espalier::osd::CudaWorkspace& workspace);

}  // namespace user
