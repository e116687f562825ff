// SPDX-License-Identifier: Apache-2.0
//
// Deforms a model by poses of a lattice, on a GPU: deform_on_gpu MODEL REST POSE... OUT
//
// The deformed points stay on the device, where a renderer or another kernel can use them. OUT is
// the model in the last pose.

#include <espalier/bind/bind.h>
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
        bind::bindPoints({base, rest.positions}, model->positions(), bind::Level{3});
    const osd::CudaEvaluator<float> table(stencils::convertTable<float>(binding.table));
    std::vector<float> coordinates;
    for (const Point3& point : binding.points)
        coordinates.insert(coordinates.end(), point.begin(), point.end());
    const osd::CudaBuffer<float> atRest{std::span<const float>(coordinates)};
    const auto xyz = osd::BufferDescriptor::packed(3);
    const osd::RowRange all = {0, table.rowCount()};
    osd::CudaBuffer<float> points(atRest.size());
    osd::CudaWorkspace workspace;

    // For every pose: copy the displacements of the lattice to the device, and put one sparse
    // product on the stream. Later work on the stream finds the points in points.data().
    for (int i = 3; i + 1 < count; ++i) {
        const Lattice pose = io::readLattice(arguments[i]);
        std::vector<float> displacements;
        for (std::size_t v = 0; v < pose.positions.size(); ++v)
            for (std::size_t c = 0; c < 3; ++c)
                displacements.push_back(
                    static_cast<float>(pose.positions[v][c] - rest.positions[v][c]));
        table.evaluate(displacements, xyz, points, xyz, all, workspace,
                       osd::CudaAddend<float>::packed(atRest, 3));
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
