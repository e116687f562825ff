// SPDX-License-Identifier: Apache-2.0
//
// Tests the library as plug-ins use it: loaded while the program runs. In this case, too, an
// evaluation with a workspace allocates nothing on a thread that has not called the library before.

#include <dlfcn.h>
#include <espalier.h>

#include <cstdio>
#include <thread>
#include <vector>

#include "support/call_counts.h"

namespace {

void* library;

template <class Function>
Function* get(const char* name, Function*) {
    return reinterpret_cast<Function*>(dlsym(library, name));
}

#define CALL(name) get(#name, &name)

constexpr int kVertices = 8;

}  // namespace

int main(int count, char** arguments) {
    if (count != 2 || (library = dlopen(arguments[1], RTLD_NOW)) == nullptr) return 2;
    std::vector<double> rest;
    for (int v = 0; v < kVertices; ++v)
        rest.insert(rest.end(), {double(v & 1), double(v >> 1 & 1), double(v >> 2)});
    const std::vector<int32_t> cell = {0, 1, 3, 2, 4, 5, 7, 6};
    std::vector<double> points = {0.25, 0.5, 0.75}, moved(3);
    espalier_lattice* lattice = nullptr;
    espalier_refiner* refiner = nullptr;
    espalier_binding* binding = nullptr;
    espalier_table* table = nullptr;
    espalier_evaluator_f64* evaluator = nullptr;
    espalier_workspace* workspace = nullptr;
    const espalier_buffer_layout xyz = espalier_packed_layout(3);
    const auto evaluate = [&, run = CALL(espalier_evaluator_f64_evaluate)] {
        return run(evaluator, rest.data(), 3 * kVertices, xyz, moved.data(), 3, xyz, 0, 1,
                   workspace);
    };
    if (CALL(espalier_lattice_create_hexahedra)(kVertices, rest.data(), 1, cell.data(), &lattice) ||
        CALL(espalier_refiner_create)(lattice, nullptr, &refiner) ||
        CALL(espalier_binding_create)(refiner, kVertices, rest.data(), 1, points.data(), nullptr,
                                      &binding) ||
        CALL(espalier_binding_table)(binding, &table) ||
        CALL(espalier_evaluator_f64_create)(table, &evaluator) ||
        CALL(espalier_workspace_create)(&workspace) || evaluate())
        return 3;
    espalier::test::CallCounts counts;
    std::thread([&] { counts = espalier::test::callsOf(evaluate); }).join();
    std::printf("%ld allocations, %ld locks\n", counts.allocations, counts.locks);
    return counts == espalier::test::CallCounts{} && moved == points ? 0 : 1;
}
