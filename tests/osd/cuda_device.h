// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cuda_runtime_api.h>
#include <espalier/osd/cuda/cuda_evaluator.h>

#include "support/test.h"

namespace espalier::test {

/// Returns why tests on a device cannot run here; empty if they can.
inline std::string cudaSkipReason() {
    if (osd::cudaDeviceCount() > 0) return {};
    try {
        const osd::CudaBuffer<float> buffer(1);
        return "no device is counted";
    } catch (const osd::CudaError& error) {
        return error.what();
    }
}

/// A stream of the current device that does not synchronize with the default stream.
class Stream {
public:
    Stream() {
        if (cudaStreamCreateWithFlags(&stream_, cudaStreamNonBlocking) != cudaSuccess)
            throw std::runtime_error("cudaStreamCreateWithFlags");
    }
    ~Stream() { cudaStreamDestroy(stream_); }
    Stream(const Stream&) = delete;
    Stream& operator=(const Stream&) = delete;

    operator cudaStream_t() const { return stream_; }

private:
    cudaStream_t stream_ = nullptr;
};

/// The base of tests that need a device; skips them if there is none.
class CudaTest : public ::testing::Test {
protected:
    void SetUp() override {
        if (const std::string reason = cudaSkipReason(); !reason.empty()) GTEST_SKIP() << reason;
    }
};

}  // namespace espalier::test
