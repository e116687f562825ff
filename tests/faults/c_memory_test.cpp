// SPDX-License-Identifier: Apache-2.0
#include <espalier_pose.h>

#include <cstdint>
#include <cstring>
#include <functional>
#include <string>
#include <thread>
#include <vector>

#include "c_objects.h"
#include "exhaustion.h"
#include "support/temporary_folder.h"

// When an allocation fails under the C API, calls return a status and a message, and make no
// object.
namespace espalier {
namespace {

using namespace test;

class CMemory : public testing::Test {
protected:
    const Owned<espalier_executor_scope> serial = make<espalier_executor_scope>(
        espalier_executor_scope_destroy,
        [](auto** out) { return espalier_executor_scope_create(nullptr, nullptr, out); });
    const test::TemporaryFolder folder;
    const std::string lattice = (folder / "a.vtu").string();
    const std::string binding = (folder / "a.espb").string();
};

TEST_F(CMemory, Lattices) {
    test::failEachAllocation([&] {
        const auto own = makeLattice();
        const std::int32_t edge[] = {0, 1}, vertex = 3;
        const double sharpness = 2.5;
        check(espalier_lattice_mark_edges(own.get(), 1, edge, &sharpness));
        check(espalier_lattice_mark_vertices(own.get(), 1, &vertex, &sharpness));
        check(espalier_lattice_set_positions(own.get(), 8, kCorners.data()));
        check(espalier_lattice_write(own.get(), lattice.c_str()));
        std::uint64_t hash = 0;
        check(espalier_lattice_topology_hash(own.get(), &hash));
        return hash;
    });
    test::failEachAllocation([&] {
        const auto own = make<espalier_lattice>(espalier_lattice_destroy, [&](auto** out) {
            return espalier_lattice_read(lattice.c_str(), out);
        });
        std::int32_t counts[4] = {};
        check(espalier_lattice_counts(own.get(), counts));
        return counts[3];
    });
}

TEST_F(CMemory, Refiners) {
    const auto own = makeLattice();
    test::failEachAllocation([&] {
        const auto refiner = makeRefiner(own.get());
        check(espalier_refiner_refine(refiner.get(), 1));
        espalier_cells cells = {};
        check(espalier_refiner_cells(refiner.get(), 1, &cells));
        std::vector<double> carried(3 * static_cast<std::size_t>(cells.vertex_count));
        check(espalier_refiner_carry_values(refiner.get(), 1, 3, kCorners.data(), 24,
                                            carried.data(),
                                            static_cast<std::int64_t>(carried.size())));
        return carried;
    });
}

TEST_F(CMemory, BindingsAndEvaluators) {
    const auto own = makeLattice();
    const auto refiner = makeRefiner(own.get());
    test::failEachAllocation([&] {
        const auto bound = makeBinding(refiner.get());
        check(espalier_binding_save(bound.get(), binding.c_str()));
        return true;
    });
    test::failEachAllocation([&] {
        const auto bound = make<espalier_binding>(espalier_binding_destroy, [&](auto** out) {
            return espalier_binding_load(binding.c_str(), out);
        });
        std::vector<double> points(9);
        check(espalier_binding_apply(bound.get(), 8, kCorners.data(), 3, points.data()));
        return points;
    });
    const auto bound = makeBinding(refiner.get());
    test::failEachAllocation([&] {
        const auto table = make<espalier_table>(espalier_table_destroy, [&](auto** out) {
            return espalier_binding_table(bound.get(), out);
        });
        const auto evaluator = make<espalier_evaluator_f32>(
            espalier_evaluator_f32_destroy,
            [&](auto** out) { return espalier_evaluator_f32_create(table.get(), out); });
        const auto deformer = make<espalier_deformer_f32>(
            espalier_deformer_f32_destroy,
            [&](auto** out) { return espalier_deformer_f32_create(bound.get(), out); });
        const std::vector<float> pose(kCorners.begin(), kCorners.end());
        std::vector<float> points(9);
        const auto xyz = espalier_packed_layout(3);
        check(espalier_evaluator_f32_evaluate(evaluator.get(), pose.data(), 24, xyz, points.data(),
                                              9, xyz, 0, 3, nullptr));
        const std::int32_t changed = 3;
        check(espalier_deformer_f32_deform(deformer.get(), pose.data(), 24, points.data(), 9));
        check(espalier_deformer_f32_deform_changed(deformer.get(), pose.data(), 24, 1, &changed,
                                                   points.data(), 9));
        return points;
    });
}

TEST_F(CMemory, Poses) {
    const auto own = makeLattice();
    const auto refiner = makeRefiner(own.get());
    const auto bound = makeBinding(refiner.get());
    const std::string mesh = (folder / "editor.obj").string();
    check(espalier_lattice_write_editor_mesh(own.get(), mesh.c_str()));
    const double axis[] = {0, 0, 1};
    test::failEachAllocation([&] {
        std::vector<double> weights(8), pose(24);
        const espalier_falloff falloff = {ESPALIER_FALLOFF_SMOOTH, 2};
        check(espalier_select_end(8, kCorners.data(), axis, &falloff, weights.data()));
        auto options = espalier_default_pose_options();
        options.weights = weights.data();
        check(espalier_pose_twist(8, kCorners.data(), axis, 0.5, &options, pose.data()));
        check(espalier_lattice_write_editor_mesh(own.get(), mesh.c_str()));
        return pose;
    });
    test::failEachAllocation([&] {
        std::vector<double> pose(24);
        check(espalier_lattice_read_pose(own.get(), mesh.c_str(), 8, pose.data()));
        check(espalier_binding_read_pose(bound.get(), mesh.c_str(), 8, pose.data()));
        return pose;
    });
}

TEST_F(CMemory, Scopes) {
    test::failEachAllocation([] {
        const auto limit = make<espalier_thread_limit>(
            espalier_thread_limit_destroy,
            [](auto** out) { return espalier_thread_limit_create(1, out); });
        const auto workspace =
            make<espalier_workspace>(espalier_workspace_destroy, espalier_workspace_create);
        const auto executor = make<espalier_executor_scope>(
            espalier_executor_scope_destroy,
            [](auto** out) { return espalier_executor_scope_create(nullptr, nullptr, out); });
        const auto progress =
            make<espalier_progress_scope>(espalier_progress_scope_destroy, [](auto** out) {
                return espalier_progress_scope_create(
                    [](void*, const espalier_progress*) { return 1; }, nullptr, 0, out);
            });
        return true;
    });
}

/// Makes allocations fail while a thread that has not called before reports an error. Expects that
/// the status is the right one or says that memory is exhausted, and that there is a message.
void expectErrorsReportedOnANewThread(espalier_status expected, const char* message,
                                      const std::function<espalier_status()>& call) {
    for (long n = 1;; ++n) {
        bool isDone = false, isTold = false, isWhole = false;
        std::thread([&] {
            const test::AllocationFault fault(test::Failing::AllFrom, n);
            const espalier_status status = call();
            isWhole = status == expected && std::strcmp(espalier_last_error(), message) == 0;
            isTold = isWhole || std::strstr(espalier_last_error(), "not enough memory") != nullptr;
            isDone = !fault.hasHappened();
        }).join();
        EXPECT_TRUE(isTold) << n;
        if (!isDone) continue;
        EXPECT_TRUE(isWhole);
        break;
    }
}

TEST_F(CMemory, ErrorsAreReportedOnNewThreads) {
    espalier_lattice* none = nullptr;
    const std::string missing = (folder / "none.vtu").string();
    expectErrorsReportedOnANewThread(ESPALIER_ERROR_FILE,
                                     (missing + ": cannot open: No such file or directory").c_str(),
                                     [&] { return espalier_lattice_read(missing.c_str(), &none); });
    expectErrorsReportedOnANewThread(ESPALIER_ERROR_INPUT, "path is null",
                                     [&] { return espalier_lattice_read(nullptr, &none); });
    EXPECT_EQ(none, nullptr);
}

}  // namespace
}  // namespace espalier
