// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cuda_runtime_api.h>

#include <cstddef>
#include <cstdint>

namespace espalier::bench {

/// A table in compressed rows, on the device.
template <class Real>
struct DeviceTable {
    const std::int64_t* offsets;
    const std::int32_t* columns;
    const Real* weights;
    std::int32_t rowCount;
};

/// What OpenSubdiv's evaluator for CUDA does: one thread a row, which goes through its entries one
/// after the other. `components` is 3 or 12, entries one behind the other.
template <class Real>
cudaError_t evaluateByRows(const DeviceTable<Real>& table, const Real* source, Real* destination,
                           int components, cudaStream_t stream);

/// Reads all of an array, so that nothing else is in the cache, and nothing that has yet to be
/// written.
cudaError_t readAll(const float* values, std::size_t count, float* sum, cudaStream_t stream);

}  // namespace espalier::bench
