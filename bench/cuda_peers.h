// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cuda_runtime_api.h>

#include <cstddef>
#include <cstdint>

namespace espalier::bench {

/// A table in CSR form on the device.
template <class Real>
struct DeviceTable {
    const std::int64_t* offsets;
    const std::int32_t* columns;
    const Real* weights;
    std::int32_t rowCount;
};

/// Evaluates as OpenSubdiv's CUDA evaluator does: one thread per row, which adds up its entries in
/// order. `components` is 3 or 12, and the components of an entry are consecutive.
template <class Real>
cudaError_t evaluateByRows(const DeviceTable<Real>& table, const Real* source, Real* destination,
                           int components, cudaStream_t stream);

/// Reads a whole array, so that the cache holds nothing else and no data to be written back.
cudaError_t readAll(const float* values, std::size_t count, float* sum, cudaStream_t stream);

}  // namespace espalier::bench
