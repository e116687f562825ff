// SPDX-License-Identifier: Apache-2.0
#include "cuda_user.h"

namespace user {
namespace {

__global__ void add(float* z, int count, float height) {
    const int i = static_cast<int>(blockIdx.x * blockDim.x + threadIdx.x);
    if (i < count) z[3 * i] += height;
}

}  // namespace

void raise(const espalier::osd::CudaEvaluator<float>& table,
           const espalier::osd::CudaBuffer<float>& pose, espalier::osd::CudaBuffer<float>& points,
           float height, espalier::osd::CudaWorkspace& workspace) {
    const auto xyz = espalier::osd::BufferDescriptor::packed(3);
    const int count = table.rowCount();
    table.evaluate(pose, xyz, points, xyz, {0, count}, workspace);
    add<<<(count + 255) / 256, 256, 0, workspace.stream()>>>(points.data() + 2, count, height);
}

}  // namespace user
