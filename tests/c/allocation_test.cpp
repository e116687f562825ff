// SPDX-License-Identifier: Apache-2.0
// That an evaluation as espalier.h describes it for real time allocates nothing.
#include <espalier.h>

#include <atomic>
#include <cstddef>
#include <cstdlib>
#include <new>
#include <vector>

#include "box.h"

namespace {

std::atomic<long> allocations = 0;

void* allocate(std::size_t bytes, std::size_t alignment) {
    ++allocations;
    if (void* memory =
            std::aligned_alloc(alignment, (bytes + alignment - 1) / alignment * alignment))
        return memory;
    throw std::bad_alloc();
}

}  // namespace

// In place of those of the C++ library, for libespalier.so too.
void* operator new(std::size_t bytes) {
    return allocate(bytes, alignof(std::max_align_t));
}
void* operator new(std::size_t bytes, std::align_val_t alignment) {
    return allocate(bytes, static_cast<std::size_t>(alignment));
}
void* operator new(std::size_t bytes, const std::nothrow_t&) noexcept {
    ++allocations;
    return std::malloc(bytes);
}
void operator delete(void* memory) noexcept {
    std::free(memory);
}
void operator delete(void* memory, std::size_t) noexcept {
    std::free(memory);
}
void operator delete(void* memory, std::align_val_t) noexcept {
    std::free(memory);
}
void operator delete(void* memory, std::size_t, std::align_val_t) noexcept {
    std::free(memory);
}

int main() {
    double rest[3 * BOX_VERTICES];
    std::int32_t cells[8 * BOX_CELLS];
    make_box(rest, cells);
    std::vector<float> pose(rest, rest + 3 * BOX_VERTICES);
    constexpr std::int32_t kPoints = 20000;
    std::vector<double> points;
    for (int i = 0; i < 3 * kPoints; ++i) points.push_back(i * 7919 % 10007 / 10007.0);
    points[0] = 2;  // Outside: kept in place.

    espalier_lattice* lattice = nullptr;
    espalier_refiner* refiner = nullptr;
    espalier_binding* binding = nullptr;
    espalier_table* table = nullptr;
    espalier_evaluator_f32 *forward = nullptr, *backward = nullptr;
    espalier_workspace* workspace = nullptr;
    espalier_executor_scope* scope = nullptr;
    espalier_status failed = ESPALIER_OK;
    failed |= espalier_lattice_create_hexahedra(BOX_VERTICES, rest, BOX_CELLS, cells, &lattice);
    failed |= espalier_refiner_create(lattice, nullptr, &refiner);
    failed |= espalier_binding_create(refiner, BOX_VERTICES, rest, kPoints, points.data(), nullptr,
                                      &binding);
    failed |= espalier_binding_table(binding, &table);
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
        failed |= espalier_binding_put_kept_f32(binding, moved.data(), size(moved), xyz);
        failed |= espalier_evaluator_f32_evaluate(backward, moved.data(), size(moved), xyz,
                                                  gradient.data(), size(gradient), xyz, 0,
                                                  BOX_VERTICES, workspace);
    };
    const long none = allocations;
    evaluate();
    const long first = allocations;
    evaluate();
    const long second = allocations;

    espalier_executor_scope_destroy(scope);
    espalier_workspace_destroy(workspace);
    espalier_evaluator_f32_destroy(backward);
    espalier_evaluator_f32_destroy(forward);
    espalier_table_destroy(table);
    espalier_binding_destroy(binding);
    espalier_refiner_destroy(refiner);
    espalier_lattice_destroy(lattice);
    // The first one did allocate: those of the library are counted.
    return failed == ESPALIER_OK && none < first && first == second ? 0 : 1;
}
