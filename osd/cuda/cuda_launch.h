// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cuda_runtime_api.h>
#include "../device/device_data.h"

// The functions that cuda_launch.cu compiles for the device. They put kernels on a stream and
// return at once.
namespace espalier::osd::device {

/// Loads all kernels onto the current device. Otherwise CUDA would load each when it is first
/// started, and might wait for the device then.
template <class Real>
cudaError_t loadKernels();

/// Starts the kernels of launchTable() in device_evaluation.h.
/// \return the first failure
template <class Real>
cudaError_t startTable(const TableView<Real>& table, const Evaluation<Real>& evaluation,
                       cudaStream_t stream);

/// Starts the kernels of launchAdjoint().
template <class Real>
cudaError_t startAdjoint(const TableView<Real>& table, const AdjointView<Real>& adjoint,
                         const Evaluation<Real>& evaluation, Real* slots, cudaStream_t stream);

}  // namespace espalier::osd::device
