// SPDX-License-Identifier: Apache-2.0
// What cuda_launch.h declares, of a class StreamLaunch that puts kernels on a stream, and a class
// KernelLoad that loads them. Included by cuda_launch.cu, and by a test that has a device of its
// own, each inside the namespace and behind these classes. No #pragma once, and no includes.

template <class Real>
cudaError_t loadKernels() {
    KernelLoad load;
    Evaluation<Real> evaluation = {};
    const SumStep<Real> step = {};
    AdjointView<Real> adjoint = {};
    adjoint.steps = &step;
    adjoint.stepCount = 1;
    // Each width that forComponents() takes.
    for (const Offset length : {1, 2, 3, 4, 12}) {
        evaluation.length = length;
        launchTable(TableView<Real>{}, evaluation, load);
        launchAdjoint(TableView<Real>{}, adjoint, evaluation, static_cast<Real*>(nullptr), load);
    }
    load(ScatterKernel<Real>{});
    return load.error();
}

template <class Real>
cudaError_t startTable(const TableView<Real>& table, const Evaluation<Real>& evaluation,
                       cudaStream_t stream) {
    StreamLaunch launch(stream);
    launchTable(table, evaluation, launch);
    return launch.error();
}

template <class Real>
cudaError_t startAdjoint(const TableView<Real>& table, const AdjointView<Real>& adjoint,
                         const Evaluation<Real>& evaluation, Real* places, cudaStream_t stream) {
    StreamLaunch launch(stream);
    launchAdjoint(table, adjoint, evaluation, places, launch);
    return launch.error();
}

template <class Real>
cudaError_t startScatter(const Index* rows, Index count, const Real* values,
                         const Evaluation<Real>& evaluation, cudaStream_t stream) {
    StreamLaunch launch(stream);
    launch(ScatterKernel<Real>{rows, count, values, evaluation});
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
template cudaError_t startScatter(const Index*, Index, const float*, const Evaluation<float>&,
                                  cudaStream_t);
template cudaError_t startScatter(const Index*, Index, const double*, const Evaluation<double>&,
                                  cudaStream_t);
