// SPDX-License-Identifier: Apache-2.0
#include <benchmark/benchmark.h>
#include <espalier/base/parallel.h>
#include <espalier/embed/local_binding.h>
#include <espalier/far/standard_cells.h>
#include <espalier/stencils/composition.h>
#include <sys/resource.h>

#include <string>
#include <vector>

#include "workloads.h"

#ifdef ESPALIER_WITH_VTK
#include <vtkCellArray.h>
#include <vtkDoubleArray.h>
#include <vtkNew.h>
#include <vtkPointData.h>
#include <vtkPolyData.h>
#include <vtkProbeFilter.h>
#include <vtkStaticCellLocator.h>
#include <vtkUnstructuredGrid.h>
#endif

// Binds a million points to a box of 1,000 cells: random points on level 3, which has 512,000
// cells, and points of a surface on level 5. Benchmarks are named bind/POINTS/LEVEL/WHO. VTK gets
// the cells of level 3, finds the points and interpolates; embed/ is the part of ours that does the
// same work.
namespace espalier {
namespace {

struct Scene {
    int level;
    std::vector<Point3> points;
    Lattice lattice = bench::regularLattice();
    far::TopologyRefiner base{lattice.complex};

    embed::BoundRows<> bind() const {
        return embed::bindPoints({base, lattice.positions}, points, {.level = level});
    }
};

Scene randomScene() {
    return {bench::RefinedBox::kLevel, bench::randomPoints()};
}
Scene surfaceScene() {
    return {5, bench::model()};
}

const bench::RefinedBox& refined() {
    static const bench::RefinedBox made;
    return made;
}

/// Binds: refines around the points, finds them and makes D.
void bind(benchmark::State& state, Scene (*make)(), int threads) {
    const ThreadLimit limit(threads);
    const Scene scene = make();
    embed::BoundRows<> binding;
    for (auto _ : state) binding = scene.bind();
    if (!bench::givesBack(stencils::applyLevelTable(binding.table, scene.lattice.positions),
                          scene.points))
        state.SkipWithError("the rest pose does not give the points back");
    state.counters["entries a row"] =
        static_cast<double>(binding.table.entryCount()) / binding.table.rowCount();
}

/// Only finds the points, in the whole level.
void embed(benchmark::State& state, int threads) {
    const ThreadLimit limit(threads);
    const std::vector<Point3> points = bench::randomPoints();
    for (auto _ : state)
        benchmark::DoNotOptimize(
            embed::embedPoints(refined().complex(), refined().positions(), points));
}

#ifdef ESPALIER_WITH_VTK

vtkNew<vtkPoints> toVtk(std::span<const Point3> points) {
    vtkNew<vtkPoints> result;
    result->SetDataTypeToDouble();
    result->SetNumberOfPoints(static_cast<vtkIdType>(points.size()));
    for (std::size_t i = 0; i < points.size(); ++i)
        result->SetPoint(static_cast<vtkIdType>(i), points[i].data());
    return result;
}

/// Finds the points with VTK, and interpolates the positions of the vertices there.
void probe(benchmark::State& state) {
    const far::CellComplex& complex = refined().complex();
    const std::vector<Point3>& positions = refined().positions();
    const std::vector<Point3> points = bench::randomPoints();
    vtkNew<vtkCellArray> cells;
    for (Index cell = 0; cell < complex.count(3); ++cell) {
        const auto corners = far::hexahedronVertices(complex, CellId(cell));
        std::array<vtkIdType, 8> ids;
        std::copy(corners->begin(), corners->end(), ids.begin());
        cells->InsertNextCell(8, ids.data());
    }
    vtkNew<vtkUnstructuredGrid> grid;
    grid->SetPoints(toVtk(positions));
    grid->SetCells(VTK_HEXAHEDRON, cells);
    vtkNew<vtkDoubleArray> values;
    values->SetName("positions");
    values->SetNumberOfComponents(3);
    for (const Point3& position : positions) values->InsertNextTuple(position.data());
    grid->GetPointData()->AddArray(values);
    vtkNew<vtkPolyData> model;
    model->SetPoints(toVtk(points));
    std::vector<Point3> moved(points.size());
    for (auto _ : state) {
        vtkNew<vtkStaticCellLocator> locator;
        vtkNew<vtkProbeFilter> filter;
        filter->SetCellLocatorPrototype(locator);
        filter->SetInputData(model);
        filter->SetSourceData(grid);
        filter->Update();
        state.PauseTiming();
        vtkDataArray& found = *filter->GetOutput()->GetPointData()->GetArray("positions");
        for (std::size_t i = 0; i < moved.size(); ++i)
            found.GetTuple(static_cast<vtkIdType>(i), moved[i].data());
        state.ResumeTiming();
    }
    if (!bench::givesBack(moved, points)) state.SkipWithError("the points are not given back");
}

#endif

std::size_t peakMemory() {
    ::rusage usage{};
    ::getrusage(RUSAGE_SELF, &usage);
    return static_cast<std::size_t>(usage.ru_maxrss) * 1024;
}

std::size_t byteCount(const stencils::StencilTable<double>& table) {
    return table.offsets().size_bytes() + table.columns().size_bytes() +
           table.weights().size_bytes();
}

/// Binds and applies one pose, as the program's `deform` does. The peak memory is the peak of the
/// process, so it is meaningful only if no other benchmark ran before. Fails at 3 GB or more.
void bindAndApply(benchmark::State& state, Scene (*make)()) {
    constexpr std::size_t kMemoryLimit = 3'000'000'000;
    for (auto _ : state) {
        const Scene scene = make();
        const auto binding = scene.bind();
        if (!bench::givesBack(stencils::applyLevelTable(binding.table, scene.lattice.positions),
                              scene.points))
            return state.SkipWithError("the rest pose does not give the points back");
        state.counters["result bytes"] = static_cast<double>(byteCount(binding.table));
    }
    state.counters["peak bytes"] = static_cast<double>(peakMemory());
    if (peakMemory() >= kMemoryLimit) state.SkipWithError("took 3 GB or more");
}

/// Registers a benchmark with one iteration, which takes long enough.
template <class Job>
void add(const std::string& name, Job job) {
    benchmark::RegisterBenchmark(name.c_str(), job)
        ->UseRealTime()
        ->Unit(benchmark::kMillisecond)
        ->Iterations(1);
}

const bool kRegistered = [] {
    for (const int threads : {1, 2}) {
        const std::string who = threads == 1 ? "Espalier" : "Espalier 2 threads";
        add("bind/random/3/" + who, [=](auto& state) { bind(state, randomScene, threads); });
        add("bind/surface/5/" + who, [=](auto& state) { bind(state, surfaceScene, threads); });
        add("embed/random/3/" + who, [=](auto& state) { embed(state, threads); });
    }
#ifdef ESPALIER_WITH_VTK
    add("bind/random/3/VTK", probe);
#endif
    add("bindAndApply/random/3", [](auto& state) { bindAndApply(state, randomScene); });
    add("bindAndApply/surface/5", [](auto& state) { bindAndApply(state, surfaceScene); });
    return true;
}();

}  // namespace
}  // namespace espalier
