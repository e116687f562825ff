// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <espalier/osd/cuda/cuda_evaluator.h>

// A program of somebody's who writes CUDA, and has points of ours on the device.
namespace user {

/// Evaluates, and raises all points by a kernel behind that on the stream.
void raise(const espalier::osd::CudaEvaluator<float>& table,
           const espalier::osd::CudaBuffer<float>& pose, espalier::osd::CudaBuffer<float>& points,
           float height, espalier::osd::CudaWorkspace& workspace);

}  // namespace user
