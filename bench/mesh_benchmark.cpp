// SPDX-License-Identifier: Apache-2.0
#include <benchmark/benchmark.h>
#include <espalier/base/parallel.h>
#include <espalier/far/volume_mesh.h>
#include <espalier/solve/mesh_quality.h>
#include <espalier/solve/validity.h>

#include <array>
#include <chrono>
#include <cmath>
#include <string>
#include <vector>

// Checks a pose of a mesh of about a million cells, as `espalier deform` does: is each cell valid,
// how far towards the pose is every cell valid, and the quality before and after. Benchmarks are
// named mesh/CELLS/ANSWER: in the pose "valid" no cell is inverted, in "inverted" some are.
namespace espalier {
namespace {

enum class Cells { Hexahedra, Tetrahedra, Polyhedra };

struct Mesh {
    far::VolumeMesh mesh;
    std::vector<Point3> rest;
};

/// Returns about a million cells on a grid whose points are moved by sines.
Mesh makeMesh(Cells cells) {
    // A cube is one hexahedron, one polyhedron, or six tetrahedra around its diagonal.
    const Index side = cells == Cells::Tetrahedra ? 55 : 100;
    const auto vertex = [&](Index x, Index y, Index z) {
        return x + (side + 1) * (y + (side + 1) * z);
    };
    Mesh result;
    const double h = 1.0 / side;
    for (Index z = 0; z <= side; ++z)
        for (Index y = 0; y <= side; ++y)
            for (Index x = 0; x <= side; ++x)
                result.rest.push_back({h * x + 0.02 * std::sin(9 * h * y),
                                       h * y + 0.02 * std::sin(8 * h * z),
                                       h * z + 0.02 * std::sin(7 * h * x)});
    constexpr std::array<std::array<Index, 4>, 6> kFaces = {
        {{0, 4, 7, 3}, {1, 2, 6, 5}, {0, 1, 5, 4}, {3, 7, 6, 2}, {0, 3, 2, 1}, {4, 5, 6, 7}}};
    constexpr std::array<std::array<Index, 4>, 6> kTetrahedra = {
        {{0, 1, 2, 6}, {0, 2, 3, 6}, {0, 3, 7, 6}, {0, 7, 4, 6}, {0, 4, 5, 6}, {0, 5, 1, 6}}};
    far::VolumeMeshBuilder builder(static_cast<Index>(result.rest.size()));
    for (Index z = 0; z < side; ++z)
        for (Index y = 0; y < side; ++y)
            for (Index x = 0; x < side; ++x) {
                std::array<Index, 8> corners;
                for (Index top : {0, 1}) {
                    corners[4 * top] = vertex(x, y, z + top);
                    corners[4 * top + 1] = vertex(x + 1, y, z + top);
                    corners[4 * top + 2] = vertex(x + 1, y + 1, z + top);
                    corners[4 * top + 3] = vertex(x, y + 1, z + top);
                }
                if (cells == Cells::Hexahedra)
                    builder.addCell(far::StandardCell::Hexahedron, corners);
                if (cells == Cells::Polyhedra) {
                    std::vector<std::vector<Index>> loops;
                    for (const auto& face : kFaces) {
                        loops.emplace_back();
                        for (const Index corner : face) loops.back().push_back(corners[corner]);
                    }
                    builder.addCell(loops);
                }
                if (cells == Cells::Tetrahedra)
                    for (const auto& [a, b, c, d] : kTetrahedra)
                        builder.addCell(far::StandardCell::Tetrahedron,
                                        {corners[a], corners[b], corners[c], corners[d]});
            }
    result.mesh = builder.build();
    return result;
}

void check(benchmark::State& state, Cells cells, bool isInverted) {
    const ThreadLimit limit(1);
    const Mesh made = makeMesh(cells);
    // The second sine has the length of four cells and turns some of them inside out.
    std::vector<Point3> pose = made.rest;
    for (Point3& p : pose) {
        p[0] += 0.05 * std::sin(6 * p[1]) * std::sin(5 * p[2]);
        if (isInverted) p[1] += 0.012 * std::sin(150 * p[1]);
    }
    double preparing = 0, checking = 0, stepping = 0, measuring = 0;
    const auto timed = [](double& seconds, auto&& work) {
        const auto begin = std::chrono::steady_clock::now();
        auto result = work();
        seconds += std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
        return result;
    };
    for (auto _ : state) {
        const auto validity =
            timed(preparing, [&] { return solve::ValidityCheck(made.mesh, made.rest); });
        const auto found = timed(checking, [&] { return validity.check(pose); });
        const auto step = timed(stepping, [&] { return validity.largestStep(pose); });
        const auto before =
            timed(measuring, [&] { return solve::meshQuality(made.mesh, made.rest); });
        const auto after = timed(measuring, [&] { return solve::meshQuality(made.mesh, pose); });
        benchmark::DoNotOptimize(after);
        if (!validity.badAtRest().empty() || !before.nonPositiveVolumes.empty())
            state.SkipWithError("cells are bad at rest");
        if (found.inverted.empty() == isInverted || (step.length < 1) != isInverted)
            state.SkipWithError("the answer is wrong");
    }
    const auto runs = static_cast<double>(state.iterations());
    state.counters["items"] = made.mesh.cellCount();
    state.counters["preparing_s"] = preparing / runs;
    state.counters["checking_s"] = checking / runs;
    state.counters["stepping_s"] = stepping / runs;
    state.counters["measuring_s"] = measuring / runs;
}

const bool kRegistered = [] {
    for (const auto& [cells, name] : {std::pair{Cells::Hexahedra, "hexahedra"},
                                      {Cells::Tetrahedra, "tetrahedra"},
                                      {Cells::Polyhedra, "polyhedra"}})
        for (const bool isInverted : {false, true})
            benchmark::RegisterBenchmark(
                (std::string("mesh/") + name + (isInverted ? "/inverted" : "/valid")).c_str(),
                [cells = cells, isInverted](auto& state) { check(state, cells, isInverted); })
                ->UseRealTime()
                ->Unit(benchmark::kMillisecond)
                ->Iterations(1);
    return true;
}();

}  // namespace
}  // namespace espalier
