// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cuda_runtime_api.h>
#include "device_data.h"

// What cuda_launch.cu compiles for the device: puts kernels on a stream, and returns at once.
namespace espalier::osd::device {

/// Loads all kernels onto the current device. CUDA would do that when one is first started, and
/// might wait for the device then.
template <class Real>
cudaError_t loadKernels();

/// The kernels of launchTable() in device_evaluation.h.
/// \return what starting them has failed with
template <class Real>
cudaError_t startTable(const TableView<Real>& table, const Evaluation<Real>& evaluation,
                       cudaStream_t stream);

/// Those of launchAdjoint().
template <class Real>
cudaError_t startAdjoint(const TableView<Real>& table, const AdjointView<Real>& adjoint,
                         const Evaluation<Real>& evaluation, Real* places, cudaStream_t stream);

/// ScatterKernel.
template <class Real>
cudaError_t startScatter(const Index* rows, Index count, const Real* values,
                         const Evaluation<Real>& evaluation, cudaStream_t stream);

}  // namespace espalier::osd::device
