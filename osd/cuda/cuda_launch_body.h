// SPDX-License-Identifier: Apache-2.0
// Implements cuda_launch.h by means of loadKernel(kernel) and startKernel(kernel, stream). Included
// by cuda_launch.cu, and by a test that has its own device, each time inside the namespace and
// after these two functions. Hence there is no #pragma once, and there are no includes.

/// Calls `call` for each kernel until one call fails, and keeps that failure.
template <class Call>
class UntilError {
public:
    explicit UntilError(Call call) : call_(call) {}

    template <class Kernel>
    void operator()(const Kernel& kernel) {
        if (error_ == cudaSuccess) error_ = call_(kernel);
    }

    cudaError_t error() const { return error_; }

private:
    Call call_;
    cudaError_t error_ = cudaSuccess;
};

inline auto launchOn(cudaStream_t stream) {
    return UntilError([stream](const auto& kernel) { return startKernel(kernel, stream); });
}

template <class Real>
cudaError_t loadKernels() {
    UntilError load([](const auto& kernel) { return loadKernel(kernel); });
    Evaluation<Real> evaluation = {};
    const SumStep<Real> step = {};
    AdjointView<Real> adjoint = {};
    adjoint.steps = &step;
    adjoint.stepCount = 1;
    // These lengths need every width of forComponents().
    for (const Offset length : {1, 2, 3, 4, 12}) {
        evaluation.length = length;
        launchTable(TableView<Real>{}, evaluation, load);
        launchAdjoint(TableView<Real>{}, adjoint, evaluation, static_cast<Real*>(nullptr), load);
    }
    return load.error();
}

template <class Real>
cudaError_t startTable(const TableView<Real>& table, const Evaluation<Real>& evaluation,
                       cudaStream_t stream) {
    auto launch = launchOn(stream);
    launchTable(table, evaluation, launch);
    return launch.error();
}

template <class Real>
cudaError_t startAdjoint(const TableView<Real>& table, const AdjointView<Real>& adjoint,
                         const Evaluation<Real>& evaluation, Real* slots, cudaStream_t stream) {
    auto launch = launchOn(stream);
    launchAdjoint(table, adjoint, evaluation, slots, launch);
    return launch.error();
}

template cudaError_t loadKernels<float>();
template cudaError_t loadKernels<double>();
template cudaError_t startTable(const TableView<float>&, const Evaluation<float>&, cudaStream_t);
template cudaError_t startTable(const TableView<double>&, const Evaluation<double>&, cudaStream_t);
template cudaError_t startAdjoint(const TableView<float>&, const AdjointView<float>&,
                                  const Evaluation<float>&, float*, cudaStream_t);
template cudaError_t startAdjoint(const TableView<double>&, const AdjointView<double>&,
                                  const Evaluation<double>&, double*, cudaStream_t);
