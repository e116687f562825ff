// SPDX-License-Identifier: Apache-2.0
// Checks that deforming and evaluating in real time, as espalier.h describes it, allocates nothing
// and takes no lock.
#include <espalier.h>

#include <vector>

#include "box.h"
#include "support/call_counts.h"

int main() {
    double rest[3 * BOX_VERTICES];
    std::int32_t cells[8 * BOX_CELLS];
    make_box(rest, cells);
    std::vector<float> pose(rest, rest + 3 * BOX_VERTICES);
    constexpr std::int32_t kPoints = 20000;
    std::vector<double> points;
    for (int i = 0; i < 3 * kPoints; ++i) points.push_back(i * 7919 % 10007 / 10007.0);
    points[0] = 2;  // Outside.

    espalier_lattice* lattice = nullptr;
    espalier_refiner* refiner = nullptr;
    espalier_binding* binding = nullptr;
    espalier_table* table = nullptr;
    espalier_deformer_f32* deformer = nullptr;
    espalier_evaluator_f32 *forward = nullptr, *backward = nullptr;
    espalier_workspace* workspace = nullptr;
    espalier_executor_scope* scope = nullptr;
    espalier_status failed = ESPALIER_OK;
    failed |= espalier_lattice_create_hexahedra(BOX_VERTICES, rest, BOX_CELLS, cells, &lattice);
    failed |= espalier_refiner_create(lattice, nullptr, &refiner);
    failed |= espalier_binding_create(refiner, BOX_VERTICES, rest, kPoints, points.data(), nullptr,
                                      &binding);
    failed |= espalier_binding_table(binding, &table);
    failed |= espalier_deformer_f32_create(binding, &deformer);
    failed |= espalier_evaluator_f32_create(table, &forward);
    failed |= espalier_evaluator_f32_create_adjoint(table, &backward);
    failed |= espalier_workspace_create(&workspace);
    failed |= espalier_executor_scope_create(nullptr, nullptr, &scope);

    std::vector<float> moved(points.size()), gradient(pose.size());
    const espalier_buffer_layout xyz = espalier_packed_layout(3);
    const auto size = [](const std::vector<float>& values) {
        return static_cast<std::int64_t>(values.size());
    };
    const auto evaluate = [&] {
        failed |=
            espalier_evaluator_f32_evaluate(forward, pose.data(), size(pose), xyz, moved.data(),
                                            size(moved), xyz, 0, kPoints, workspace);
        failed |= espalier_deformer_f32_deform(deformer, pose.data(), size(pose), moved.data(),
                                               size(moved));
        failed |= espalier_evaluator_f32_evaluate(backward, moved.data(), size(moved), xyz,
                                                  gradient.data(), size(gradient), xyz, 0,
                                                  BOX_VERTICES, workspace);
    };
    const auto first = espalier::test::callsOf(evaluate);
    const auto second = espalier::test::callsOf(evaluate);

    espalier_executor_scope_destroy(scope);
    espalier_workspace_destroy(workspace);
    espalier_evaluator_f32_destroy(backward);
    espalier_evaluator_f32_destroy(forward);
    espalier_deformer_f32_destroy(deformer);
    espalier_table_destroy(table);
    espalier_binding_destroy(binding);
    espalier_refiner_destroy(refiner);
    espalier_lattice_destroy(lattice);
    // The first evaluation allocated, so allocations of the library are counted.
    const bool isRight = first.allocations > 0 && second == espalier::test::CallCounts{};
    return failed == ESPALIER_OK && isRight ? 0 : 1;
}
