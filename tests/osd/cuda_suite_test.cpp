// SPDX-License-Identifier: Apache-2.0
#include <espalier/osd/cuda/cuda_evaluator.h>

#include "cuda_device.h"
#include "evaluator_suite.h"

namespace espalier::osd {
namespace {

/// Copies an array of a test to the device, for tests with arguments on the device, and back.
template <class Real>
class OnDevice {
public:
    explicit OnDevice(std::span<const Real> values) : buffer_(values) {}

    CudaBuffer<Real>& buffer() { return buffer_; }

    void copyTo(std::span<Real> values, CudaWorkspace& workspace) {
        buffer_.download(values, workspace.stream());
        workspace.synchronize();
    }

private:
    CudaBuffer<Real> buffer_;
};

/// A CudaEvaluator, with source and destination both on the device or both on the host.
template <bool isGrouped, bool isAdjoint, bool isOnDevice>
struct Cuda {
    static std::string skipReason() { return test::cudaSkipReason(); }

    template <class Real>
    class Of {
    public:
        explicit Of(const StencilTable<Real>& table)
            : evaluator_(isAdjoint ? stencils::transposeTable(table) : table,
                         {.isGrouped = isGrouped, .hasAdjoint = isAdjoint}) {}

        void evaluate(Values<Real> source, const BufferDescriptor& sourceLayout,
                      MutableValues<Real> destination, const BufferDescriptor& destinationLayout,
                      RowRange rows) const {
            const test::Stream stream;
            CudaWorkspace workspace(stream);
            const auto run = [&](const CudaSource<Real>& from, const CudaDestination<Real>& to) {
                if constexpr (isAdjoint)
                    evaluator_.evaluateAdjoint(from, sourceLayout, to, destinationLayout, rows,
                                               workspace);
                else
                    evaluator_.evaluate(from, sourceLayout, to, destinationLayout, rows, workspace);
            };
            if constexpr (!isOnDevice) {
                run(source, destination);
                workspace.synchronize();
            } else {
                OnDevice<Real> from(source), to(destination);
                run(from.buffer(), to.buffer());
                to.copyTo(destination, workspace);
            }
        }

    private:
        CudaEvaluator<Real> evaluator_;
    };
};

using Cases =
    ::testing::Types<Case<Cuda<true, false, false>, float>, Case<Cuda<true, false, false>, double>,
                     Case<Cuda<true, false, true>, float>, Case<Cuda<true, false, true>, double>,
                     Case<Cuda<false, false, false>, float>, Case<Cuda<false, false, true>, double>,
                     Case<Cuda<true, true, false>, float>, Case<Cuda<true, true, true>, float>,
                     Case<Cuda<true, true, true>, double>, Case<Cuda<false, true, false>, double>,
                     Case<Cuda<false, true, true>, float>>;
INSTANTIATE_TYPED_TEST_SUITE_P(Cuda, EvaluatorTest, Cases);

}  // namespace
}  // namespace espalier::osd
