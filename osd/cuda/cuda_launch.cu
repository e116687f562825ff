// SPDX-License-Identifier: Apache-2.0
#include "../device/device_evaluation.h"
#include "cuda_launch.h"

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

    template <int toBytes, int fromBytes, class T>
    static __device__ void copy(T* to, const T* from) {
#if __CUDA_ARCH__ >= 800
        const auto address = static_cast<unsigned>(__cvta_generic_to_shared(to));
        if constexpr (sizeof(T) == 16)
            asm volatile("cp.async.cg.shared.global [%0 + %2], [%1 + %3], 16;" ::"r"(address),
                         "l"(from), "n"(toBytes), "n"(fromBytes)
                         : "memory");
        else
            asm volatile("cp.async.ca.shared.global [%0 + %2], [%1 + %3], %4;" ::"r"(address),
                         "l"(from), "n"(toBytes), "n"(fromBytes), "n"(sizeof(T))
                         : "memory");
#else
        to[toBytes / int{sizeof(T)}] = from[fromBytes / int{sizeof(T)}];
#endif
    }

    static __device__ void storeIf(bool isStored, float* to, float value) {
        asm volatile("{.reg .pred p; setp.ne.s32 p, %0, 0; @p st.global.f32 [%1], %2;}" ::"r"(
                         static_cast<int>(isStored)),
                     "l"(to), "f"(value)
                     : "memory");
    }
    static __device__ void storeIf(bool isStored, double* to, double value) {
        asm volatile("{.reg .pred p; setp.ne.s32 p, %0, 0; @p st.global.f64 [%1], %2;}" ::"r"(
                         static_cast<int>(isStored)),
                     "l"(to), "d"(value)
                     : "memory");
    }

    static __device__ void waitForCopies() {
#if __CUDA_ARCH__ >= 800
        asm volatile("cp.async.wait_all;" ::: "memory");
#endif
        __syncwarp();
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

/// A kernel and its number of warps, which is computed once, on the host.
template <class Kernel>
struct CountedKernel {
    static constexpr int kBlocks = Kernel::kBlocks;
    Kernel kernel;
    Index warps;
};

template <class CountedKernel>
__global__ void __launch_bounds__(kWarpsPerBlock* kWarp, CountedKernel::kBlocks)
    run(const __grid_constant__ CountedKernel kernel, unsigned sharedPerWarp) {
    extern __shared__ __align__(16) unsigned char shared[];
    const unsigned warpInBlock = threadIdx.x / kWarp;
    const long long index = static_cast<long long>(blockIdx.x) * (blockDim.x / kWarp) + warpInBlock;
    if (index >= kernel.warps) return;
    CudaWarp warp;
    kernel.kernel(warp, static_cast<Index>(index), shared + warpInBlock * sharedPerWarp);
}

template <class Kernel>
const void* functionOf() {
    return reinterpret_cast<const void*>(&run<CountedKernel<Kernel>>);
}

template <class Kernel>
cudaError_t loadKernel(const Kernel&) {
    cudaFuncAttributes attributes;
    return cudaFuncGetAttributes(&attributes, functionOf<Kernel>());
}

/// Computes how many warps of a kernel the current device runs at a time.
template <class Kernel>
cudaError_t warpsAtOnce(unsigned sharedPerWarp, Index& count) {
    int device = 0, multiprocessors = 0, blocks = 0;
    if (const auto error = cudaGetDevice(&device)) return error;
    if (const auto error =
            cudaDeviceGetAttribute(&multiprocessors, cudaDevAttrMultiProcessorCount, device))
        return error;
    const auto warps = static_cast<int>(blocksOf(kWarpsPerBlock, sharedPerWarp).warps);
    if (const auto error = cudaOccupancyMaxActiveBlocksPerMultiprocessor(
            &blocks, functionOf<Kernel>(), warps * kWarp, warps * sharedPerWarp))
        return error;
    count = multiprocessors * blocks * warps;
    return cudaSuccess;
}

template <class Kernel>
cudaError_t startKernel(const Kernel& kernel, cudaStream_t stream) {
    CountedKernel<Kernel> counted = {kernel, kernel.warpCount()};
    unsigned shared = kernel.sharedBytes();
    if constexpr (requires { counted.kernel.divideAmong(0); }) {
        Index atOnce = 0;
        if (const auto error = warpsAtOnce<Kernel>(shared, atOnce)) return error;
        counted.kernel.divideAmong(atOnce);
        counted.warps = counted.kernel.warpCount();
    }
    if (counted.warps <= 0) return cudaSuccess;
    const Blocks blocks = blocksOf(counted.warps, shared);
    void* arguments[] = {&counted, &shared};
    // <<<>>> would also report failures of earlier calls.
    return cudaLaunchKernel(functionOf<Kernel>(), dim3(blocks.count), dim3(blocks.warps * kWarp),
                            arguments, blocks.warps * shared, stream);
}

}  // namespace

#include "cuda_launch_body.h"

}  // namespace espalier::osd::device
