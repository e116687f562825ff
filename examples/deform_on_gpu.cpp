// SPDX-License-Identifier: Apache-2.0
//
// Deforms a model by poses of a lattice, on a GPU: deform_on_gpu MODEL REST POSE... OUT
//
// The deformed points stay on the device, where a renderer or another kernel can use them. OUT is
// the model in the last pose.

#include <espalier/embed/local_binding.h>
#include <espalier/io/lattice_file.h>
#include <espalier/io/model.h>
#include <espalier/osd/cuda/cuda_evaluator.h>

#include <cstdio>
#include <exception>
#include <vector>

using namespace espalier;

namespace {

void deform(int count, char** arguments) {
    const auto model = io::readModel(arguments[1]);
    const Lattice rest = io::readLattice(arguments[2]);

    // Once: find each point of the model in level 3 of the lattice, compose the matrix, and copy it
    // to the device.
    const far::TopologyRefiner base(rest.complex, {.marks = rest.marks});
    const auto binding =
        embed::bindPoints({base, rest.positions}, model->positions(), {.level = 3}).binding;
    const osd::CudaEvaluator<float> table(stencils::convertTable<float>(binding.table));
    const osd::CudaKeptPoints<float> kept(table.rowCount(), binding.kept, binding.keptAt);
    const auto xyz = osd::BufferDescriptor::packed(3);
    const osd::RowRange all = {0, table.rowCount()};
    osd::CudaBuffer<float> points(3 * static_cast<std::size_t>(table.rowCount()));
    osd::CudaWorkspace workspace;

    // For every pose: copy the vertices of the lattice to the device, and put one sparse product on
    // the stream. Later work on the stream finds the points in points.data().
    for (int i = 3; i + 1 < count; ++i) {
        std::vector<float> pose;
        for (const Point3& vertex : io::readLattice(arguments[i]).positions)
            pose.insert(pose.end(), vertex.begin(), vertex.end());
        table.evaluate(pose, xyz, points, xyz, all, workspace);
        kept.write(points, xyz, workspace.stream());
    }

    std::vector<float> last(points.size());
    points.download(last, workspace.stream());
    workspace.synchronize();
    std::vector<Point3> positions;
    for (std::size_t i = 0; i < last.size(); i += 3)
        positions.push_back({last[i], last[i + 1], last[i + 2]});
    model->write(arguments[count - 1], positions);
}

}  // namespace

int main(int count, char** arguments) {
    if (count < 5) {
        std::fprintf(stderr, "usage: deform_on_gpu MODEL REST POSE... OUT\n");
        return 2;
    }
    try {
        deform(count, arguments);
        return 0;
    } catch (const std::exception& error) {
        std::fprintf(stderr, "deform_on_gpu: %s\n", error.what());
        return 1;
    }
}
