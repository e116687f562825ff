// SPDX-License-Identifier: Apache-2.0
#include <benchmark/benchmark.h>
#include <espalier/far/parallel.h>
#include <espalier/far/standard_cells.h>
#include <espalier/osd/binding_evaluator.h>
#include <espalier/shapes/inventory.h>
#include <espalier/stencils/composition.h>
#include <sys/resource.h>

#include <random>

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

// A million points bound to level 3 of a box of 1,000 cells, which has 512,000: ours, with the rows
// over the base vertices, and VTK's search and interpolation in the same cells.
namespace espalier {
namespace {

using far::Index;

constexpr int kLevel = 3;
constexpr auto kRules = stencils::Rules::Siggraph96;

struct Scene {
    Lattice lattice = shapes::box({.cells = {10, 10, 10}});
    far::TopologyRefiner refiner{lattice.complex};
    std::vector<Point3> positions;
    std::vector<Point3> points;

    Scene() {
        refiner.refineUniform(kLevel);
        positions = stencils::refinePositions(refiner, kLevel, kRules, lattice.positions);
        std::mt19937 random(1);
        std::uniform_real_distribution<double> uniform(0.001, 0.999);
        points.resize(1'000'000);
        for (Point3& point : points) point = {uniform(random), uniform(random), uniform(random)};
    }
};

const Scene& scene() {
    static const Scene made;
    return made;
}

/// Whether the rest positions give the points back, to the rounding of both.
bool givesBack(std::span<const Point3> moved, std::span<const Point3> points) {
    for (std::size_t i = 0; i < points.size(); ++i)
        for (std::size_t c = 0; c < 3; ++c)
            if (!(std::abs(moved[i][c] - points[i][c]) <= 1e-12)) return false;
    return moved.size() == points.size();
}

/// Finds the points and makes D.
void bind(benchmark::State& state) {
    const far::ThreadLimit limit(static_cast<int>(state.range(0)));
    const auto& [lattice, refiner, positions, points] = scene();
    stencils::Binding<double> binding;
    for (auto _ : state) {
        const auto embedding =
            stencils::embedPoints(refiner.level(kLevel).complex, positions, points);
        binding = stencils::makeBinding<double>(refiner, kLevel, kRules, embedding, points);
    }
    if (!givesBack(osd::evaluateBinding(binding, lattice.positions), points))
        state.SkipWithError("the rest pose does not give the points back");
    state.counters["entries a row"] =
        static_cast<double>(binding.table.entryCount()) / static_cast<double>(points.size());
}
BENCHMARK(bind)
    ->Name("bind/1 M points/3/Espalier threads")
    ->Arg(1)
    ->Arg(2)
    ->UseRealTime()
    ->Unit(benchmark::kMillisecond);

/// Finds the points alone.
void embed(benchmark::State& state) {
    const far::ThreadLimit limit(static_cast<int>(state.range(0)));
    const auto& [lattice, refiner, positions, points] = scene();
    for (auto _ : state)
        benchmark::DoNotOptimize(
            stencils::embedPoints(refiner.level(kLevel).complex, positions, points));
}
BENCHMARK(embed)
    ->Name("embed/1 M points/3/Espalier threads")
    ->Arg(1)
    ->Arg(2)
    ->UseRealTime()
    ->Unit(benchmark::kMillisecond);

#ifdef ESPALIER_WITH_VTK

vtkNew<vtkPoints> toVtk(std::span<const Point3> points) {
    vtkNew<vtkPoints> result;
    result->SetDataTypeToDouble();
    result->SetNumberOfPoints(static_cast<vtkIdType>(points.size()));
    for (std::size_t i = 0; i < points.size(); ++i)
        result->SetPoint(static_cast<vtkIdType>(i), points[i].data());
    return result;
}

/// Finds the points, and interpolates the positions of the vertices there.
void probe(benchmark::State& state) {
    const auto& [lattice, refiner, positions, points] = scene();
    const far::CellComplex& complex = refiner.level(kLevel).complex;
    vtkNew<vtkCellArray> cells;
    for (Index cell = 0; cell < complex.count(3); ++cell) {
        const auto corners = far::hexahedronVertices(complex, far::CellId(cell));
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
    if (!givesBack(moved, points)) state.SkipWithError("the points are not given back");
}
BENCHMARK(probe)->Name("bind/1 M points/3/VTK")->UseRealTime()->Unit(benchmark::kMillisecond);

#endif

std::size_t peakMemory() {
    ::rusage usage{};
    ::getrusage(RUSAGE_SELF, &usage);
    return static_cast<std::size_t>(usage.ru_maxrss) * 1024;
}

/// Binds 1 M points to 1,000 base cells at level 3 and applies one pose: what the program's
/// `deform` does. Fails if the process has taken 3 GB or more.
void bindAndApply(benchmark::State& state) {
    constexpr std::size_t kMemoryLimit = 3'000'000'000;
    for (auto _ : state) {
        const Scene made;
        const auto embedding =
            stencils::embedPoints(made.refiner.level(kLevel).complex, made.positions, made.points);
        const auto binding =
            stencils::makeBinding<double>(made.refiner, kLevel, kRules, embedding, made.points);
        if (!givesBack(osd::evaluateBinding(binding, made.lattice.positions), made.points))
            return state.SkipWithError("the rest pose does not give the points back");
    }
    state.counters["peak bytes"] = static_cast<double>(peakMemory());
    if (peakMemory() >= kMemoryLimit) state.SkipWithError("took 3 GB or more");
}
BENCHMARK(bindAndApply)->Unit(benchmark::kSecond)->Iterations(1);

}  // namespace
}  // namespace espalier
