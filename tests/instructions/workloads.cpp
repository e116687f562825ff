// SPDX-License-Identifier: Apache-2.0
#include <espalier/base/parallel.h>
#include <espalier/embed/local_binding.h>
#include <espalier/far/topology_refiner.h>
#include <espalier/osd/compiled_table.h>
#include <espalier/shapes/inventory.h>
#include <espalier/stencils/composition.h>

#include <cstdint>
#include <cstdio>
#include <functional>
#include <map>
#include <string>
#include <vector>

// Three small workloads whose instructions counts_test.py counts: refine, bind and apply. Each runs
// on one thread. Kernels use the instructions that every processor has, so that the count does not
// depend on the processor.

/// Callgrind counts what this function calls, and nothing else: see counts_test.py.
extern "C" [[gnu::noinline]] void counted(const std::function<void()>& work);
void counted(const std::function<void()>& work) {
    work();
}

namespace espalier {
namespace {

/// A cylinder with an irregular axis.
Lattice lattice() {
    return shapes::cylinder({.sectors = 6, .layers = 3});
}

/// Returns points in the box around the cylinder, some of them outside the cylinder. They come from
/// integers, so that they are the same with each standard library.
std::vector<Point3> pointsAround(Index count) {
    std::uint32_t state = 1;
    const auto next = [&] {
        state = state * 1664525 + 1013904223;
        return (state >> 8) / double(1 << 24);
    };
    std::vector<Point3> points(count);
    for (Point3& p : points) p = {2 * next() - 1, 2 * next() - 1, next()};
    return points;
}

embed::BoundRows<> bind(Index pointCount) {
    const Lattice rest = lattice();
    const far::TopologyRefiner base(rest.complex);
    embed::BoundRows<> binding;
    counted([&] {
        binding = embed::bindPoints({base, rest.positions}, pointsAround(pointCount), {.level = 2});
    });
    return binding;
}

/// Refines a lattice and builds S_2. Returns the number of entries.
Offset refineAndBuild() {
    far::TopologyRefiner refiner(lattice().complex);
    Offset entryCount = 0;
    counted([&] {
        refiner.refineUniform(2);
        entryCount = stencils::buildStencils(refiner, 2).entryCount();
    });
    return entryCount;
}

/// Binds 2,000 points. Returns the number of entries of D.
Offset bindPoints() {
    return bind(2000).table.entryCount();
}

/// Compiles S_2 and applies it to ten poses. Returns the number of rows that share their columns.
Offset compileAndApply() {
    far::TopologyRefiner refiner(lattice().complex);
    refiner.refineUniform(2);
    const auto table = stencils::buildStencils<float>(refiner, 2);
    const std::vector<float> source(3 * static_cast<std::size_t>(table.columnCount()), 1.0F);
    std::vector<float> result(3 * static_cast<std::size_t>(table.rowCount()));
    Offset grouped = 0;
    counted([&] {
        const osd::CompiledTable<float> compiled(table, osd::Simd::Baseline);
        for (int pose = 0; pose < 10; ++pose)
            compiled.evaluate(source, {0, 3, 3}, result, {0, 3, 3}, {0, table.rowCount()});
        grouped = compiled.panelRowCount();
    });
    return grouped;
}

}  // namespace
}  // namespace espalier

int main(int count, char** arguments) {
    using namespace espalier;
    const std::map<std::string, Offset (*)()> workloads = {
        {"refine", refineAndBuild}, {"bind", bindPoints}, {"apply", compileAndApply}};
    const auto found = count == 2 ? workloads.find(arguments[1]) : workloads.end();
    if (found == workloads.end()) {
        std::fprintf(stderr, "usage: workloads refine|bind|apply\n");
        return 2;
    }
    const ThreadLimit oneThread(1);
    // oneTBB starts with its first loop. How long this takes depends on the number of cores, and on
    // the number of mappings of the process, which oneTBB reads.
    parallelFor(2, 1, [](Offset, Offset) {});
    const Offset result = found->second();
    std::printf("%lld\n", static_cast<long long>(result));
    return result > 0 ? 0 : 1;
}
