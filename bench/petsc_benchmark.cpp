// SPDX-License-Identifier: Apache-2.0
//
// Measures a bound model that is distributed over the ranks, for docs/scaling.md.
//
//     mpirun -n RANKS petsc_bench products   D times three components, by petsc::DistributedTable,
//                                            and by PETSc's product with a dense matrix of three
//                                            columns; the same transposed
//     mpirun -n RANKS petsc_bench lattice    memory of a rank, for a lattice of a million vertices

#include <espalier/base/parallel.h>
#include <espalier/embed/local_binding.h>
#include <espalier/embed/tensor_product.h>
#include <espalier/osd/compiled_adjoint.h>
#include <espalier/osd/compiled_table.h>
#include <espalier/petsc/distributed_table.h>
#include <espalier/shapes/inventory.h>
#include <sys/resource.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstring>
#include <functional>
#include <random>
#include <string>
#include <vector>

#include "workloads.h"

namespace espalier {
namespace {

using petsc::DistributedTable;
using petsc::OwnedRange;
using stencils::StencilTable;

constexpr int kComponents = 3;

int rankOf() {
    int rank = 0;
    MPI_Comm_rank(MPI_COMM_WORLD, &rank);
    return rank;
}

int rankCount() {
    int size = 0;
    MPI_Comm_size(MPI_COMM_WORLD, &size);
    return size;
}

void check(PetscErrorCode code) {
    if (code) MPI_Abort(MPI_COMM_WORLD, 1);  // PETSc has printed the error.
}

/// Time of the slowest rank.
double secondsOf(const std::function<void()>& body) {
    MPI_Barrier(MPI_COMM_WORLD);
    const double start = MPI_Wtime();
    body();
    double seconds = MPI_Wtime() - start;
    MPI_Allreduce(MPI_IN_PLACE, &seconds, 1, MPI_DOUBLE, MPI_MAX, MPI_COMM_WORLD);
    return seconds;
}

/// Largest value of all ranks.
double largest(double value) {
    MPI_Allreduce(MPI_IN_PLACE, &value, 1, MPI_DOUBLE, MPI_MAX, MPI_COMM_WORLD);
    return value;
}

/// Peak resident memory of this rank so far.
double peakMegabytes() {
    rusage usage{};
    getrusage(RUSAGE_SELF, &usage);
    return static_cast<double>(usage.ru_maxrss) / 1e3;
}

StencilTable<double> bindOwn(const Lattice& lattice, const std::vector<Point3>& points, int level) {
    return embed::bindPoints({far::TopologyRefiner(lattice.complex), lattice.positions}, points,
                             {.level = level})
        .table;
}

std::vector<double> randomValues(Offset count, unsigned seed) {
    std::mt19937 random(seed + static_cast<unsigned>(rankOf()));
    std::uniform_real_distribution<double> uniform(-1, 1);
    std::vector<double> values(count);
    for (double& value : values) value = uniform(random);
    return values;
}

/// Returns a dense matrix of PETSc with the same numbers; PETSc stores it by columns.
Mat denseMatrix(const std::vector<double>& values, Offset own, Offset all) {
    Mat matrix = nullptr;
    check(MatCreateDense(MPI_COMM_WORLD, static_cast<PetscInt>(own), PETSC_DECIDE,
                         static_cast<PetscInt>(all), kComponents, nullptr, &matrix));
    PetscScalar* numbers = nullptr;
    check(MatDenseGetArray(matrix, &numbers));
    for (Offset i = 0; i < own; ++i)
        for (Offset c = 0; c < kComponents; ++c) numbers[c * own + i] = values[i * kComponents + c];
    check(MatDenseRestoreArray(matrix, &numbers));
    check(MatAssemblyBegin(matrix, MAT_FINAL_ASSEMBLY));
    check(MatAssemblyEnd(matrix, MAT_FINAL_ASSEMBLY));
    return matrix;
}

double largestDifference(Mat dense, const std::vector<double>& values) {
    const PetscScalar* numbers = nullptr;
    check(MatDenseGetArrayRead(dense, &numbers));
    const std::size_t own = values.size() / kComponents;
    double difference = 0;
    for (std::size_t i = 0; i < own; ++i)
        for (std::size_t c = 0; c < kComponents; ++c)
            difference =
                std::max(difference, std::abs(numbers[c * own + i] - values[i * kComponents + c]));
    check(MatDenseRestoreArrayRead(dense, &numbers));
    return largest(difference);
}

/// Times of our product, of PETSc's, and of osd's evaluators on the rank's rows without
/// communication.
struct Times {
    double ours = 1e9, dense = 1e9, compiled = 1e9;
};

/// Measures in turn, so that other load on the machine affects all alike. The fastest of ten runs
/// counts.
Times measure(const std::function<void()>& ours, const std::function<void()>& dense,
              const std::function<void()>& compiled) {
    Times best;
    for (int repetition = 0; repetition < 10; ++repetition) {
        best.ours = std::min(best.ours, secondsOf(ours));
        best.dense = std::min(best.dense, secondsOf(dense));
        best.compiled = std::min(best.compiled, secondsOf(compiled));
    }
    return best;
}

void printRow(const std::string& what, const Times& times) {
    if (rankOf() != 0) return;
    std::printf("| %s | %d | %.1f ms | %.1f ms | %.2f × | %.1f ms | %.1f × |\n", what.c_str(),
                rankCount(), 1e3 * times.dense, 1e3 * times.ours, times.dense / times.ours,
                1e3 * times.compiled, times.ours / times.compiled);
}

void measureProducts(const std::string& name, const StencilTable<double>& rows) {
    const OwnedRange vertices = petsc::evenRange(rows.columnCount(), rankOf(), rankCount());
    DistributedTable table(MPI_COMM_WORLD, rows, vertices.count(), kComponents);
    const osd::CompiledTable<double> compiled(rows);
    const osd::CompiledAdjoint<double> compiledAdjoint(rows);
    const auto layout = osd::BufferDescriptor::packed(kComponents);
    // The rank's rows without communication need the values of all vertices.
    std::vector<double> all = randomValues(Offset{kComponents} * rows.columnCount(), 100);

    const auto pose = randomValues(kComponents * vertices.count(), 1);
    std::vector<double> points(static_cast<std::size_t>(kComponents) *
                               static_cast<std::size_t>(rows.rowCount()));
    auto compiledPoints = points;
    Mat densePose = denseMatrix(pose, vertices.count(), rows.columnCount());
    Mat densePoints = nullptr;
    check(MatMatMult(table.matrix(), densePose, MAT_INITIAL_MATRIX, PETSC_DEFAULT, &densePoints));
    const Times forward =
        measure([&] { table.evaluate(pose, points); },
                [&] {
                    check(MatMatMult(table.matrix(), densePose, MAT_REUSE_MATRIX, PETSC_DEFAULT,
                                     &densePoints));
                },
                [&] {
                    compiled.evaluate(all, layout, compiledPoints, layout, {0, rows.rowCount()});
                });
    const double forwardDifference = largestDifference(densePoints, points);

    const auto gradients = randomValues(Offset{kComponents} * rows.rowCount(), 2);
    std::vector<double> back(pose.size());
    Mat denseGradients = denseMatrix(gradients, rows.rowCount(), table.pointCount());
    Mat denseBack = nullptr;
    check(MatTransposeMatMult(table.matrix(), denseGradients, MAT_INITIAL_MATRIX, PETSC_DEFAULT,
                              &denseBack));
    const Times adjoint = measure(
        [&] { table.evaluateAdjoint(gradients, back); },
        [&] {
            check(MatTransposeMatMult(table.matrix(), denseGradients, MAT_REUSE_MATRIX,
                                      PETSC_DEFAULT, &denseBack));
        },
        [&] {
            compiledAdjoint.evaluate(gradients, layout, all, layout, {0, rows.columnCount()});
        });
    const double adjointDifference = largestDifference(denseBack, back);

    printRow(name + ", forward", forward);
    printRow(name + ", adjoint", adjoint);
    // Both add the same products in different orders. A sum of the adjoint may include all points,
    // with gradients up to 1: the rounding of 10⁶ terms of 1e-16 grows with the root, to about
    // 1e-13; forward sums have less. A wrong or missing product shows as its weight, mostly above
    // 1e-3.
    if (std::max(forwardDifference, adjointDifference) > 1e-9) {
        std::fprintf(stderr, "%s: the results differ by %g and %g\n", name.c_str(),
                     forwardDifference, adjointDifference);
        MPI_Abort(MPI_COMM_WORLD, 1);
    }
    for (Mat* matrix : {&densePose, &densePoints, &denseGradients, &denseBack})
        check(MatDestroy(matrix));
}

void runProducts() {
    const auto points = bench::model();
    const OwnedRange own =
        petsc::evenRange(static_cast<Offset>(points.size()), rankOf(), rankCount());
    const std::vector<Point3> ownPoints(points.begin() + own.first, points.begin() + own.last);
    if (rankOf() == 0)
        std::printf(
            "| product | ranks | dense matrix | ours | ratio | compiled, own rows | ours over it "
            "|\n| --- | --- | --- | --- | --- | --- | --- |\n");
    const Lattice box = shapes::box({.cells = {10, 10, 10}});
    const embed::TensorLattice regular(box.complex, box.positions, embed::Basis::BSpline);
    measureProducts("regular model",
                    embed::buildDeformationTable(regular, embed::embedPoints(regular, ownPoints)));
    const Lattice cylinder = shapes::cylinder({.sectors = 8,
                                               .pattern = {.rings = 3},
                                               .layers = 6,
                                               .radius = 0.6,
                                               .from = {0.5, 0.5, 0},
                                               .to = {0.5, 0.5, 1}});
    measureProducts("irregular model", bindOwn(cylinder, ownPoints, 3));
    const double peak = largest(peakMegabytes());
    if (rankOf() == 0) std::printf("\nPeak of a rank: %.0f MB, with the peer's.\n", peak);
}

/// Number of ranks that own vertices which this rank needs.
int neighbourCount(const DistributedTable& table) {
    PetscInt count = 0;
    const PetscInt *ghosts = nullptr, *ranges = nullptr;
    check(MatGetGhosts(table.matrix(), &count, &ghosts));
    check(MatGetOwnershipRangesColumn(table.matrix(), &ranges));
    int neighbours = 0;
    for (int rank = 0; rank < rankCount(); ++rank)
        if (std::any_of(ghosts, ghosts + count, [&](PetscInt ghost) {
                return ghost >= ranges[rank] && ghost < ranges[rank + 1];
            }))
            ++neighbours;
    return neighbours;
}

void runLattice() {
    constexpr int kSide = 100, kPointCount = 400'000, kLevel = 2;
    const double before = peakMegabytes();
    const Lattice lattice = shapes::box({.cells = {kSide - 1, kSide - 1, kSide - 1}});
    const double ofLattice = peakMegabytes();
    const far::TopologyRefiner base(lattice.complex);
    const double ofBase = peakMegabytes();
    if (rankOf() == 0)
        std::printf("%d vertices: %.0f MB at start, %.0f with the lattice, %.0f with its strata\n",
                    lattice.complex.count(0), before, ofLattice, ofBase);

    const OwnedRange vertices = petsc::evenRange(kSide * kSide * kSide, rankOf(), rankCount());
    const auto slabFrom = [&](Offset first) {
        return static_cast<double>(first) / (kSide * kSide * kSide);
    };
    for (const bool together : {true, false}) {
        std::mt19937 random(static_cast<unsigned>(rankOf()));
        std::uniform_real_distribution<double> anywhere(0, 1);
        std::uniform_real_distribution<double> along(together ? slabFrom(vertices.first) : 0,
                                                     together ? slabFrom(vertices.last) : 1);
        std::vector<Point3> points(kPointCount);
        for (Point3& point : points) point = {anywhere(random), anywhere(random), along(random)};
        StencilTable<double> rows;
        const double binding = secondsOf([&] {
            rows = embed::bindPoints({base, lattice.positions}, points, {.level = kLevel}).table;
        });
        const double peak = largest(peakMegabytes());
        const auto pose = randomValues(kComponents * vertices.count(), 1);
        std::vector<double> moved(kComponents * points.size()), gradients(pose.size());
        const auto start = MPI_Wtime();
        DistributedTable table(MPI_COMM_WORLD, rows, vertices.count());
        const double spreading = largest(MPI_Wtime() - start);
        double evaluating = 1e9, back = 1e9;
        for (int repetition = 0; repetition < 5; ++repetition) {
            evaluating = std::min(evaluating, secondsOf([&] { table.evaluate(pose, moved); }));
            back = std::min(back, secondsOf([&] { table.evaluateAdjoint(moved, gradients); }));
        }
        const double ghosts = largest(static_cast<double>(table.ghostCount()));
        const double neighbours = largest(neighbourCount(table));
        const double inTheEnd = largest(peakMegabytes());
        if (rankOf() == 0)
            std::printf(
                "%d points a rank %s, %d ranks: bound in %.2f µs a point, peak %.0f MB; %.1f "
                "entries a row; spread in %.0f ms; at most %.0f ghosts of %.0f ranks, %.2f MB; "
                "evaluated in %.1f ms, adjoint %.1f ms; peak in the end %.0f MB\n",
                kPointCount, together ? "beside its vertices" : "anywhere", rankCount(),
                1e6 * binding / kPointCount, peak,
                static_cast<double>(rows.entryCount()) / kPointCount, 1e3 * spreading, ghosts,
                neighbours, ghosts * kComponents * 8 / 1e6, 1e3 * evaluating, 1e3 * back, inTheEnd);
    }
}

}  // namespace
}  // namespace espalier

int main(int argumentCount, char** arguments) {
    if (PetscInitialize(&argumentCount, &arguments, nullptr, nullptr)) return 2;
    // Ranks replace threads here.
    const espalier::ThreadLimit oneThread(1);
    const bool ofLattice = argumentCount == 2 && !std::strcmp(arguments[1], "lattice");
    const bool ofProducts = argumentCount == 2 && !std::strcmp(arguments[1], "products");
    if (ofLattice) espalier::runLattice();
    if (ofProducts) espalier::runProducts();
    if (!ofLattice && !ofProducts)
        std::fprintf(stderr, "usage: mpirun -n RANKS petsc_bench products|lattice\n");
    const bool finalised = !PetscFinalize();
    return finalised && (ofLattice || ofProducts) ? 0 : 2;
}
