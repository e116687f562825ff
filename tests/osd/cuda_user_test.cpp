// SPDX-License-Identifier: Apache-2.0
#include "cuda_user.h"

#include "cuda_device.h"
#include "support/test.h"

namespace espalier::osd {
namespace {

using CudaUser = CudaTest;

// Also tests that the user's code compiles without warnings by the CUDA compiler.
TEST_F(CudaUser, UsesThePointsOnTheDevice) {
    const CudaEvaluator<float> table(
        stencils::StencilTable<float>(2, {0, 1, 3}, {0, 0, 1}, {2, 1, 1}));
    const Stream stream;
    CudaWorkspace workspace(stream);
    const CudaBuffer<float> pose{std::span<const float>(std::vector<float>{1, 2, 3, 10, 20, 30})};
    CudaBuffer<float> points(6);
    user::raise(table, pose, points, 100, workspace);
    std::vector<float> result(6);
    points.download(result, stream);
    workspace.synchronize();
    EXPECT_THAT(result, ElementsAre(2, 4, 106, 11, 22, 133));
}

}  // namespace
}  // namespace espalier::osd
