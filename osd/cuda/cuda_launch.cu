// SPDX-License-Identifier: Apache-2.0
#include "cuda_launch.h"
#include "device_evaluation.h"

namespace espalier::osd::device {
namespace {

/// A warp of the device, as device_kernels.h describes it. Each thread is one lane.
class CudaWarp {
public:
    template <class T>
    class PerLane {
    public:
        __device__ T& operator[](int) { return value_; }

    private:
        T value_;
    };

    template <class F>
    __device__ void each(F f) {
        f(lane());
        __syncwarp();
    }

    template <class Real, int n>
    __device__ void sumOver(PerLane<Values<Real, n>>& values, int lanes) {
        for (int distance = lanes / 2; distance > 0; distance /= 2) {
#pragma unroll
            for (int c = 0; c < n; ++c) {
                Real& sum = values[lane()].of[c];
                sum += __shfl_xor_sync(~0U, sum, distance);
            }
        }
    }

    template <class Real, int n>
    __device__ void sumAll(PerLane<Values<Real, n>>& values) {
        Values<Real, n>& own = values[lane()];
#pragma unroll
        for (int t = 0; t < n / kWarp; ++t) {
            addHalves<kWarp / 2>(own.of + t * kWarp);
            own.of[t] = own.of[t * kWarp];
        }
    }

    template <class T>
    static __device__ T load(const float* address) {
        T value;
        asm("ld.global.nc.L1::no_allocate.v4.f32 {%0, %1, %2, %3}, [%4];"
            : "=f"(value.of[0]), "=f"(value.of[1]), "=f"(value.of[2]), "=f"(value.of[3])
            : "l"(address));
        return value;
    }
    template <class T>
    static __device__ T load(const double* address) {
        T value;
        asm("ld.global.nc.L1::no_allocate.v2.f64 {%0, %1}, [%2];"
            : "=d"(value.of[0]), "=d"(value.of[1])
            : "l"(address));
        return value;
    }

    static __device__ void prefetch(const void* address) {
        asm volatile("prefetch.global.L2 [%0];" ::"l"(address));
    }

private:
    /// Adds up 2 · `distance` sums over pairs of lanes: each lane keeps one half of the sums and
    /// gives the other half to its partner. Repeats this with half the distance until each lane has
    /// one sum. It is a template because arrays with variable indices would be in memory.
    template <int distance, class Real>
    static __device__ void addHalves(Real* sums) {
        const bool isUpper = (lane() & distance) != 0;
#pragma unroll
        for (int i = 0; i < distance; ++i) {
            const Real given = isUpper ? sums[i] : sums[i + distance];
            const Real kept = isUpper ? sums[i + distance] : sums[i];
            sums[i] = kept + __shfl_xor_sync(~0U, given, distance);
        }
        if constexpr (distance > 1) addHalves<distance / 2>(sums);
    }

    static __device__ int lane() {
        return static_cast<int>(threadIdx.x % kWarp);
    }
};

template <class Kernel>
__global__ void __launch_bounds__(kWarpsPerBlock* kWarp)
    run(const __grid_constant__ Kernel kernel, unsigned sharedPerWarp) {
    extern __shared__ __align__(16) unsigned char shared[];
    const unsigned warpInBlock = threadIdx.x / kWarp;
    const long long index = static_cast<long long>(blockIdx.x) * (blockDim.x / kWarp) + warpInBlock;
    if (index >= kernel.warps) return;
    CudaWarp warp;
    kernel.kernel(warp, static_cast<Index>(index), shared + warpInBlock * sharedPerWarp);
}

/// A kernel and its number of warps, which is computed once, on the host.
template <class Kernel>
struct Counted {
    Kernel kernel;
    Index warps;
};

template <class Kernel>
const void* functionOf() {
    return reinterpret_cast<const void*>(&run<Counted<Kernel>>);
}

template <class Kernel>
cudaError_t loadKernel(const Kernel&) {
    cudaFuncAttributes attributes;
    return cudaFuncGetAttributes(&attributes, functionOf<Kernel>());
}

template <class Kernel>
cudaError_t startKernel(const Kernel& kernel, cudaStream_t stream) {
    Counted<Kernel> counted = {kernel, kernel.warpCount()};
    if (counted.warps <= 0) return cudaSuccess;
    unsigned shared = kernel.sharedBytes();
    const Blocks blocks = blocksOf(counted.warps, shared);
    void* arguments[] = {&counted, &shared};
    // <<<>>> would also report failures of earlier calls.
    return cudaLaunchKernel(functionOf<Kernel>(), dim3(blocks.count), dim3(blocks.warps * kWarp),
                            arguments, blocks.warps * shared, stream);
}

}  // namespace

#include "cuda_launch_body.h"

}  // namespace espalier::osd::device
