// SPDX-License-Identifier: Apache-2.0
#include <espalier_shapes.h>
#include <espalier_solve.h>

#include <array>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <tuple>
#include <vector>

#include "c_objects.h"
#include "exhaustion.h"
#include "support/temporary_folder.h"

// Failing allocations under the C API: the inventory, tables of every kind, and solvers.
namespace espalier {
namespace {

using namespace test;

using LatticeOwner = Owned<espalier_lattice>;
using TableOwner = Owned<espalier_table>;

template <class Create>
LatticeOwner madeLattice(Create create) {
    return make<espalier_lattice>(espalier_lattice_destroy, create);
}

template <class Create>
TableOwner madeTable(Create create) {
    return make<espalier_table>(espalier_table_destroy, create);
}

LatticeOwner makeBox(std::int32_t cellsAlong) {
    const std::int32_t cells[] = {cellsAlong, cellsAlong, cellsAlong};
    const double min[] = {0, 0, 0}, max[] = {1, 1, 1};
    return madeLattice(
        [&](auto** out) { return espalier_lattice_create_box(cells, min, max, out); });
}

std::vector<double> positionsOf(const espalier_lattice* lattice) {
    std::int32_t count = 0;
    const double* positions = nullptr;
    check(espalier_lattice_positions(lattice, &count, &positions));
    return {positions, positions + 3 * static_cast<std::ptrdiff_t>(count)};
}

/// Returns the rows and numbers of a table, for comparison.
auto numbersOf(const espalier_table* table) {
    espalier_csr csr = {};
    check(espalier_table_csr(table, &csr));
    const std::int64_t entries = csr.offsets[csr.row_count];
    return std::tuple(csr.column_count, std::vector(csr.offsets, csr.offsets + csr.row_count + 1),
                      std::vector(csr.columns, csr.columns + entries),
                      std::vector(csr.weights, csr.weights + entries));
}

class CSolveMemory : public testing::Test {
protected:
    const Owned<espalier_executor_scope> serial = make<espalier_executor_scope>(
        espalier_executor_scope_destroy,
        [](auto** out) { return espalier_executor_scope_create(nullptr, nullptr, out); });
    const LatticeOwner lattice = makeLattice();
    const Owned<espalier_refiner> refiner = makeRefiner(lattice.get());
    const Owned<espalier_binding> binding = makeBinding(refiner.get());
    const TableOwner deformation =
        madeTable([&](auto** out) { return espalier_binding_table(binding.get(), out); });
    const test::TemporaryFolder folder;
};

TEST_F(CSolveMemory, Inventory) {
    const double from[] = {0, 0, 0}, to[] = {0, 0, 1};
    const std::function<espalier_status(espalier_lattice**)> shapes[] = {
        [&](auto** out) {
            return espalier_lattice_create_cylinder(3, 1, ESPALIER_CORE_POLYGON, 1, 1, from, to,
                                                    out);
        },
        [](auto** out) { return espalier_lattice_create_torus(nullptr, out); },
        [](auto** out) { return espalier_lattice_create_star(nullptr, out); },
        [](auto** out) { return espalier_lattice_create_barbell(nullptr, out); },
        [](auto** out) { return espalier_lattice_create_arm(nullptr, out); },
        [](auto** out) {
            return espalier_lattice_create_regular_solid(ESPALIER_SOLID_DODECAHEDRON, 1, out);
        },
        [](auto** out) {
            return espalier_lattice_create_polygonal_solid(ESPALIER_SOLID_PYRAMID, 5, 1, 1, out);
        }};
    for (const auto& shape : shapes)
        test::failEachAllocation([&] { return positionsOf(madeLattice(shape).get()); });
    test::failEachAllocation([] { return positionsOf(makeBox(2).get()); });
    const LatticeOwner box = makeBox(1), next = makeBox(1);
    auto moved = positionsOf(next.get());
    for (std::size_t i = 0; i < moved.size(); i += 3) moved[i] += 1;
    check(espalier_lattice_set_positions(next.get(), 8, moved.data()));
    const espalier_lattice* const both[] = {box.get(), next.get()};
    test::failEachAllocation([&] {
        return positionsOf(madeLattice([&](auto** out) {
                               return espalier_lattice_create_merged(2, both, 1e-6, out);
                           }).get());
    });
}

TEST_F(CSolveMemory, Fit) {
    const std::vector<double> misses = {0.1, 0, 0, 0, -0.2, 0};
    const std::int32_t rows[] = {0, 1}, frozen = 7;
    auto options = espalier_default_fit_options();
    for (const std::int32_t smoothing : {ESPALIER_SMOOTHING_NONE, ESPALIER_SMOOTHING_LAPLACIAN}) {
        options.smoothing = smoothing;
        options.frozen_count = 1;
        options.frozen = &frozen;
        test::failEachAllocation([&] {
            std::vector<double> displacements(24);
            espalier_fit_quality quality = {};
            check(espalier_lattice_fit(deformation.get(), lattice.get(), 2, rows, misses.data(),
                                       &options, 8, displacements.data(), &quality));
            return displacements;
        });
    }
}

TEST_F(CSolveMemory, Pull) {
    const std::vector<double> misses = {0.1, 0, 0, 0, -0.2, 0};
    const std::int32_t rows[] = {0, 1}, frozen = 7, pin = 1;
    auto options = espalier_default_pull_options();
    options.frozen_count = options.pin_count = 1;
    options.frozen = &frozen;
    options.pins = &pin;
    options.max_iterations = 2;
    test::failEachAllocation([&] {
        std::vector<double> displacements(24);
        espalier_pull* pull = nullptr;
        check(espalier_pull_create(lattice.get(), 8, kCorners.data(), deformation.get(), 2, rows,
                                   &options, &pull));
        const std::unique_ptr<espalier_pull, decltype(&espalier_pull_destroy)> owner(
            pull, espalier_pull_destroy);
        check(
            espalier_pull_solve(pull, 2, misses.data(), 8, nullptr, displacements.data(), nullptr));
        return displacements;
    });
}

TEST_F(CSolveMemory, Holding) {
    const std::int32_t face = 0, row = 1;
    auto options = espalier_default_bind_options();
    options.level = 1;
    for (const std::int32_t continuity :
         {ESPALIER_CONTINUITY_C0, ESPALIER_CONTINUITY_C1, ESPALIER_CONTINUITY_C2}) {
        test::failEachAllocation([&] {
            std::array<std::int32_t, 8> held{};
            std::int32_t count = 0;
            check(espalier_hold_faces(refiner.get(), 1, &face, continuity, 8, held.data(), &count));
            return std::pair(held, count);
        });
        test::failEachAllocation([&] {
            std::array<std::int32_t, 8> held{};
            std::int32_t count = 0;
            check(espalier_hold_points(refiner.get(), 8, kCorners.data(), 2, kPoints.data(),
                                       continuity, &options, held.data(), &count));
            return std::pair(held, count);
        });
    }
    test::failEachAllocation([&] {
        std::array<std::int32_t, 8> held{};
        std::int32_t count = 0;
        check(espalier_hold_rows(deformation.get(), 1, &row, 8, held.data(), &count));
        return std::pair(held, count);
    });
}

TEST_F(CSolveMemory, Validity) {
    // The last vertex moves through the cell.
    std::vector<double> pose = kCorners;
    for (int axis = 0; axis < 3; ++axis) pose[18 + static_cast<std::size_t>(axis)] = -1;
    auto options = espalier_default_validity_options();
    options.level = 1;
    for (const std::int32_t ofLimit : {0, 1}) {
        options.of_limit = ofLimit;
        test::failEachAllocation([&] {
            const auto validity =
                make<espalier_validity>(espalier_validity_destroy, [&](auto** out) {
                    return espalier_validity_create(refiner.get(), 8, kCorners.data(), &options,
                                                    out);
                });
            std::int32_t cells = 0, bad = 0;
            const std::int32_t* badCells = nullptr;
            check(espalier_validity_cell_count(validity.get(), &cells));
            check(espalier_validity_bad_at_rest(validity.get(), &bad, &badCells));
            std::vector<double> ratios(cells);
            espalier_pose_validity result = {};
            check(espalier_validity_check(validity.get(), 8, pose.data(), cells, ratios.data(),
                                          &result));
            espalier_largest_step step = {};
            check(espalier_validity_largest_step(validity.get(), 8, pose.data(), 1, &step));
            return std::tuple(bad, ratios, result.inverted_count, step.length);
        });
    }
}

TEST_F(CSolveMemory, NestedLattices) {
    const LatticeOwner box = makeBox(2);
    const auto parent = makeRefiner(box.get());
    const auto at = positionsOf(box.get());
    auto options = espalier_default_bind_options();
    options.level = 1;
    test::failEachAllocation([&] {
        return numbersOf(madeTable([&](auto** out) {
                             return espalier_table_create_nested(deformation.get(), 8,
                                                                 kCorners.data(), parent.get(), 27,
                                                                 at.data(), &options, out);
                         }).get());
    });
}

TEST_F(CSolveMemory, Stencils) {
    check(espalier_refiner_refine(refiner.get(), 1));
    using Make = espalier_status (*)(const espalier_refiner*, std::int32_t, espalier_table**);
    for (const Make create : {&espalier_table_create_stencils, &espalier_table_create_level,
                              &espalier_table_create_limits})
        test::failEachAllocation([&] {
            return numbersOf(
                madeTable([&](auto** out) { return create(refiner.get(), 1, out); }).get());
        });
    const std::int32_t cells[] = {0, 5};
    const double uvw[] = {0.5, 0.25, 0.75, 0, 1, 0.5};
    auto options = espalier_default_limit_stencil_options();
    options.derivatives = 1;
    options.tolerance = 1e-2;
    constexpr std::int32_t kTables = ESPALIER_LIMIT_STENCIL_TABLES(1);
    test::failEachAllocation([&] {
        struct Tables {
            espalier_table* all[kTables] = {};
            ~Tables() {
                for (espalier_table* each : all) espalier_table_destroy(each);
            }
        } tables;
        const espalier_status status = espalier_table_create_limit_stencils(
            refiner.get(), 1, 2, cells, uvw, &options, kTables, tables.all);
        for (const espalier_table* each : tables.all)
            if ((each != nullptr) != (status == ESPALIER_OK))
                throw std::logic_error("another number of tables than the status says");
        check(status);
        return std::pair(numbersOf(tables.all[0]), numbersOf(tables.all[3]));
    });
}

TEST_F(CSolveMemory, TensorBindings) {
    for (const std::int32_t basis : {ESPALIER_BASIS_BEZIER, ESPALIER_BASIS_BSPLINE}) {
        const LatticeOwner box = makeBox(basis == ESPALIER_BASIS_BSPLINE ? 3 : 1);
        test::failEachAllocation([&] {
            const auto bound = make<espalier_binding>(espalier_binding_destroy, [&](auto** out) {
                return espalier_binding_create_tensor(box.get(), basis, 3, kPoints.data(), nullptr,
                                                      out);
            });
            return numbersOf(madeTable([&](auto** out) {
                                 return espalier_binding_table(bound.get(), out);
                             }).get());
        });
    }
}

TEST_F(CSolveMemory, BindingsToTheLimit) {
    auto options = espalier_default_bind_options();
    options.limit_tolerance = 1e-2;
    test::failEachAllocation([&] {
        const auto bound = make<espalier_binding>(espalier_binding_destroy, [&](auto** out) {
            return espalier_binding_create(refiner.get(), 8, kCorners.data(), 1, kPoints.data(),
                                           &options, out);
        });
        return numbersOf(
            madeTable([&](auto** out) { return espalier_binding_table(bound.get(), out); }).get());
    });
}

TEST_F(CSolveMemory, MatrixFiles) {
    for (const char* extension : {".mtx", ".npz", ".petsc", ".npy"}) {
        SCOPED_TRACE(extension);
        const std::string path = (folder / (std::string("d") + extension)).string();
        test::failEachAllocation([&] {
            check(espalier_table_write(deformation.get(), path.c_str()));
            return true;
        });
        if (std::string_view(extension) == ".npy") continue;  // three files, which cannot be read
        test::failEachAllocation([&] {
            return numbersOf(madeTable([&](auto** out) {
                                 return espalier_table_read(path.c_str(), out);
                             }).get());
        });
    }
}

}  // namespace
}  // namespace espalier
