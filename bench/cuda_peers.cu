// SPDX-License-Identifier: Apache-2.0
#include "cuda_peers.h"

namespace espalier::bench {
namespace {

template <int components, class Real>
__global__ void rows(DeviceTable<Real> table, const Real* __restrict__ source,
                     Real* __restrict__ destination) {
    const int row = static_cast<int>(blockIdx.x * blockDim.x + threadIdx.x);
    if (row >= table.rowCount) return;
    Real sums[components] = {};
    for (std::int64_t k = table.offsets[row]; k < table.offsets[row + 1]; ++k) {
        const Real weight = table.weights[k];
        const Real* const values = source + std::int64_t{table.columns[k]} * components;
        for (int c = 0; c < components; ++c) sums[c] += weight * values[c];
    }
    for (int c = 0; c < components; ++c) destination[std::int64_t{row} * components + c] = sums[c];
}

__global__ void sumUp(const float* values, std::size_t count, float* sum) {
    float own = 0;
    for (std::size_t i = std::size_t{blockIdx.x} * blockDim.x + threadIdx.x; i < count;
         i += std::size_t{gridDim.x} * blockDim.x)
        own += values[i];
    if (own != 0) *sum = own;  // All values are 0, which the compiler does not know.
}

}  // namespace

cudaError_t readAll(const float* values, std::size_t count, float* sum, cudaStream_t stream) {
    cudaGetLastError();
    sumUp<<<2048, 256, 0, stream>>>(values, count, sum);
    return cudaGetLastError();
}

template <class Real>
cudaError_t evaluateByRows(const DeviceTable<Real>& table, const Real* source, Real* destination,
                           int components, cudaStream_t stream) {
    constexpr int kThreads = 256;
    cudaGetLastError();  // Clears earlier errors.
    const int blocks = (table.rowCount + kThreads - 1) / kThreads;
    if (components == 3)
        rows<3><<<blocks, kThreads, 0, stream>>>(table, source, destination);
    else if (components == 12)
        rows<12><<<blocks, kThreads, 0, stream>>>(table, source, destination);
    else
        return cudaErrorInvalidValue;
    return cudaGetLastError();
}

template cudaError_t evaluateByRows(const DeviceTable<float>&, const float*, float*, int,
                                    cudaStream_t);
template cudaError_t evaluateByRows(const DeviceTable<double>&, const double*, double*, int,
                                    cudaStream_t);

}  // namespace espalier::bench
