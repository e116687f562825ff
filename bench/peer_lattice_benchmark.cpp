// SPDX-License-Identifier: Apache-2.0
#include <benchmark/benchmark.h>
#include <espalier/base/parallel.h>
#include <espalier/embed/tensor_product.h>
#include <espalier/osd/compiled_table.h>

#include <array>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <span>
#include <string>
#include <vector>

#include "peer_itk.h"
#include "support/temporary_folder.h"
#include "workloads.h"

// Moves a million points by a box lattice of 10 × 10 × 10 cells with B-splines, as the table of
// bench::regularModel() does. Benchmarks are named lattice/WHO.
namespace espalier {
namespace {

/// The lattice in a pose that moves all vertices differently, and the points.
struct Scene {
    Lattice lattice = bench::regularLattice();
    std::vector<Point3> pose = lattice.positions;
    std::vector<Point3> points = bench::model();

    Scene() {
        for (Point3& p : pose)
            p = {p[0] + 0.1 * std::sin(7 * p[1]), p[1] + 0.1 * std::sin(5 * p[2]),
                 p[2] + 0.1 * std::sin(6 * p[0])};
    }

    stencils::StencilTable<double> bind() const {
        const embed::TensorLattice tensor(lattice.complex, lattice.positions,
                                          embed::Basis::BSpline);
        return embed::buildDeformationTable(tensor, embed::embedPoints(tensor, points));
    }
};

const Scene& scene() {
    static const Scene made;
    return made;
}

template <class Real>
std::vector<Real> coordinates(std::span<const Point3> points) {
    std::vector<Real> result;
    for (const Point3& point : points)
        for (const double value : point) result.push_back(static_cast<Real>(value));
    return result;
}

template <class Real>
void evaluate(const osd::CompiledTable<Real>& compiled, const std::vector<Real>& pose,
              std::vector<Real>& moved) {
    const auto layout = osd::BufferDescriptor::packed(3);
    compiled.evaluate(pose, layout, moved, layout, {0, compiled.rowCount()});
    benchmark::ClobberMemory();
}

/// Returns true if points are the points of Espalier, up to a tolerance.
template <class Real>
bool agree(const std::vector<Real>& moved, double tolerance) {
    std::vector<double> ours(3 * scene().points.size());
    evaluate(osd::CompiledTable<double>(scene().bind()), coordinates<double>(scene().pose), ours);
    if (moved.size() != ours.size()) return false;
    for (std::size_t i = 0; i < ours.size(); ++i)
        if (!(std::abs(static_cast<double>(moved[i]) - ours[i]) <= tolerance)) return false;
    return true;
}

/// Times one pose of a model that is bound.
template <class Real>
void apply(benchmark::State& state) {
    const ThreadLimit limit(1);
    const osd::CompiledTable<Real> compiled(stencils::convertTable<Real>(scene().bind()));
    const auto pose = coordinates<Real>(scene().pose);
    std::vector<Real> moved(3 * scene().points.size());
    for (auto _ : state) evaluate(compiled, pose, moved);
}

/// Times binding, compiling and one pose.
void bindAndApply(benchmark::State& state) {
    const ThreadLimit limit(1);
    const auto pose = coordinates<double>(scene().pose);
    std::vector<double> moved(3 * scene().points.size());
    for (auto _ : state) evaluate(osd::CompiledTable<double>(scene().bind()), pose, moved);
}

#ifdef ESPALIER_WITH_ITK

void transform(benchmark::State& state) {
    std::vector<Point3> moved(scene().points.size());
    for (auto _ : state) {
        bench::moveByItk(scene().lattice.positions, scene().pose, scene().points, moved);
        benchmark::ClobberMemory();
    }
    // Both are sums of 64 products in double precision. The factors of the products come from
    // coordinates of up to 10 cells, whose rounding error is 2e-15.
    if (!agree(coordinates<double>(moved), 1e-14))
        state.SkipWithError("the points differ from the points of Espalier");
}

#endif

template <class Value>
void writeFile(const std::filesystem::path& path, const std::vector<Value>& values) {
    std::ofstream(path, std::ios::binary)
        .write(reinterpret_cast<const char*>(values.data()),
               static_cast<std::streamsize>(values.size() * sizeof(Value)));
}

template <class Value>
std::vector<Value> readFile(const std::filesystem::path& path, std::size_t count) {
    std::vector<Value> values(count);
    std::ifstream file(path, std::ios::binary);
    file.read(reinterpret_cast<char*>(values.data()),
              static_cast<std::streamsize>(count * sizeof(Value)));
    if (!file) values.clear();
    return values;
}

/// Runs Blender, which times its updates of a scene with a lattice modifier on a mesh, or on points
/// without faces.
template <bool kHasFaces>
void update(benchmark::State& state) {
    const test::TemporaryFolder folder;
    const auto side = static_cast<Index>(std::lround(std::sqrt(scene().points.size())));
    std::vector<Index> loops;
    if (kHasFaces)
        for (const auto& loop : bench::torus(side).loops)
            loops.insert(loops.end(), loop.begin(), loop.end());
    writeFile(folder / "points", coordinates<float>(scene().points));
    writeFile(folder / "pose", coordinates<float>(scene().pose));
    writeFile(folder / "loops", loops);
    const std::string command =
        "blender --background --factory-startup --threads 1 --python-exit-code 1 --python '" +
        std::string(ESPALIER_BLENDER_SCRIPT) + "' -- '" + folder.path().string() + "' >&2";
    const int status = std::system(command.c_str());
    const auto seconds = readFile<double>(folder / "seconds", 1);
    const auto moved = readFile<float>(folder / "moved", 3 * scene().points.size());
    if (status != 0 || seconds.empty()) return state.SkipWithError("blender failed");
    for (auto _ : state) state.SetIterationTime(seconds[0]);
    // Blender computes in single precision. Coordinates of up to 10 cells are rounded to 5e-7 of a
    // cell, and the pose shears by up to 0.7.
    if (!agree(moved, 1e-6)) state.SkipWithError("the points differ from the points of Espalier");
}

const bool kRegistered = [] {
    const auto add = [](const std::string& who, void (*work)(benchmark::State&)) {
        return benchmark::RegisterBenchmark(("lattice/" + who).c_str(), work)
            ->Unit(benchmark::kMillisecond);
    };
    add("Espalier float", apply<float>)->MeasureProcessCPUTime();
    add("Espalier double", apply<double>)->MeasureProcessCPUTime();
    add("Espalier bind and apply", bindAndApply)->MeasureProcessCPUTime();
#ifdef ESPALIER_WITH_ITK
    add("ITK", transform)->MeasureProcessCPUTime();
#endif
    if (std::system("command -v blender >/dev/null") == 0) {
        add("Blender", update<true>)->UseManualTime()->Iterations(1);
        add("Blender without faces", update<false>)->UseManualTime()->Iterations(1);
    }
    return true;
}();

}  // namespace
}  // namespace espalier
