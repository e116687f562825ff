// SPDX-License-Identifier: Apache-2.0
#include <espalier/base/executor.h>
#include <espalier/base/parallel.h>
#include <espalier/base/progress.h>
#include <espalier/embed/continuity.h>
#include <espalier/embed/nested_lattices.h>
#include <espalier/embed/tensor_product.h>
#include <espalier/far/topology_match.h>
#include <espalier/osd/binding_evaluator.h>
#include <espalier/osd/change_evaluator.h>
#include <espalier/osd/compiled_adjoint.h>
#include <espalier/osd/compiled_chain.h>
#include <espalier/osd/compiled_table.h>
#include <espalier/osd/cpu_evaluator.h>
#include <espalier/osd/deformer.h>
#include <espalier/shapes/inventory.h>
#include <espalier/shapes/merge.h>
#include <espalier/shapes/solids.h>
#include <espalier/solve/design_variables.h>
#include <espalier/solve/lattice_fit.h>
#include <espalier/solve/validity.h>
#include <espalier/stencils/composition.h>

#include <optional>
#include <tuple>
#include <type_traits>

#include "exhaustion.h"
#include "support/test.h"

// Failing allocations while objects are made and used, on one thread. parallel_memory_test.cpp
// tests several threads, where oneTBB's behaviour is not ours.
namespace espalier {
namespace {

using stencils::StencilTable;
using test::failEachAllocation;

class CoreMemory : public testing::Test {
protected:
    SerialExecutor serial;
    const ExecutorScope scope{serial};

    /// A lattice with marks and without regular parts.
    const Lattice lattice = marked(shapes::bipyramid({.sides = 3}));
    const std::vector<Point3> points = {
        {0.1, 0.1, 0.1}, {-0.1, 0.05, -0.2}, {0.01, -0.1, 0.3}, {9, 9, 9}};

    static Lattice marked(Lattice lattice) {
        lattice.marks.vertices = {{0, 1.5}};
        lattice.marks.edges = {{{0, 2}, 2.5}};
        return lattice;
    }

    TopologyRefiner refined(int level) const {
        TopologyRefiner refiner(lattice.complex, {.marks = lattice.marks});
        refiner.refineUniform(level);
        return refiner;
    }

    auto bind() const {
        return embed::bindPoints({refined(0), lattice.positions}, points, {.level = 2});
    }
};

std::vector<double> flat(const std::vector<Point3>& points) {
    std::vector<double> numbers;
    for (const Point3& point : points) numbers.insert(numbers.end(), point.begin(), point.end());
    return numbers;
}

TEST_F(CoreMemory, Lattices) {
    failEachAllocation([] {
        const Lattice two = shapes::merge(shapes::box({.cells = {2, 1, 1}}),
                                          shapes::box({.min = {2, 0, 0}, .max = {3, 1, 1}}));
        return std::tuple(two.positions, far::topologyHash(two.complex));
    });
    failEachAllocation([] { return shapes::cylinder({.sectors = 3}).positions; });
    failEachAllocation([&] {
        const auto difference =
            far::topologyDifference(lattice.complex, shapes::box({.cells = {1, 1, 1}}).complex);
        return difference.value_or("");
    });
}

TEST_F(CoreMemory, RelationsDerivedOnFirstUse) {
    failEachAllocation([&] {
        const Lattice own = shapes::box({.cells = {2, 1, 1}});
        std::size_t size = 0;
        for (int from = 0; from <= 3; ++from)
            for (int to = 0; to <= 3; ++to) size += own.complex.relation(from, to).values().size();
        return size;
    });
}

// If memory is exhausted while a complex derives a relation, the complex is unchanged, and derives
// the relation later.
TEST_F(CoreMemory, ComplexStaysUsable) {
    const auto expected = far::topologyHash(shapes::box({.cells = {2, 1, 1}}).complex);
    for (long n = 1;; ++n) {
        const Lattice own = shapes::box({.cells = {2, 1, 1}});
        const auto derive = [&] { return own.complex.relation(0, 3).values().size(); };
        const auto it = test::attempt(test::Failing::AllFrom, n, derive);
        EXPECT_EQ(derive(), 16u);
        EXPECT_EQ(far::topologyHash(own.complex), expected);
        EXPECT_NO_THROW(far::validate(own.complex));
        if (!it.hasHappened) break;
        EXPECT_TRUE(it.isOutOfMemory);
    }
}

TEST_F(CoreMemory, Refinement) {
    failEachAllocation([&] {
        const auto refiner = refined(1);
        return refiner.level(1).complex.count(0);
    });
    for (const auto creasing : {far::Creasing::Uniform, far::Creasing::Chaikin})
        failEachAllocation([&] {
            TopologyRefiner refiner(lattice.complex,
                                    {.creasing = creasing, .marks = lattice.marks});
            refiner.refineAround(std::vector<Index>{0});
            return refiner.level(1).complex.count(0);
        });
}

// refineUniform() promises to keep the levels that were made before.
TEST_F(CoreMemory, RefinerKeepsCompleteLevels) {
    const Index expected = refined(2).level(2).complex.count(3);
    for (long n = 1;; n += 5) {
        TopologyRefiner refiner = refined(1);
        const auto refine = [&] {
            refiner.refineUniform(2);
            return 0;
        };
        const auto it = test::attempt(test::Failing::One, n, refine);
        EXPECT_EQ(refiner.maxLevel(), it.isOutOfMemory ? 1 : 2);
        refine();
        EXPECT_EQ(refiner.level(2).complex.count(3), expected);
        EXPECT_NO_THROW(far::validate(refiner.level(2).complex));
        if (!it.hasHappened) break;
    }
}

TEST_F(CoreMemory, Tables) {
    const auto refiner = refined(2);
    failEachAllocation([&] { return stencils::buildLevelTables(refiner, 2); });
    failEachAllocation([&] { return stencils::buildStencils(refiner, 1); });
    const auto table = stencils::buildStencils(refiner, 1);
    failEachAllocation([&] { return stencils::transposeTable(table); });
    failEachAllocation([&] { return stencils::convertTable<float>(table); });
    failEachAllocation([&] { return stencils::convertTable<float>(StencilTable<double>(table)); });
    failEachAllocation([&] { return stencils::selectRows(table, std::vector<Index>{3, 1}); });
    failEachAllocation([&] { return stencils::refinePositions(refiner, 2, lattice.positions); });
}

TEST_F(CoreMemory, Binding) {
    failEachAllocation([&] { return bind(); });
    failEachAllocation([&] {
        const auto bound =
            embed::bindFactored({refined(0), lattice.positions}, points, {.level = 1});
        return bound.statuses;
    });
    const auto refiner = refined(1);
    const auto positions = stencils::refinePositions(refiner, 1, lattice.positions);
    failEachAllocation([&] {
        const auto embedding = embed::embedPoints(refiner.level(1).complex, positions, points,
                                                  {.outside = embed::OutsidePolicy::Nearest});
        return embed::buildDeformationTable(refiner, 1, embedding);
    });
}

// Making the message of an error allocates memory too.
TEST_F(CoreMemory, Refusals) {
    failEachAllocation([&] {
        try {
            embed::bindPoints({refined(0), lattice.positions}, points,
                              {.level = 1, .embedding = {.outside = embed::OutsidePolicy::Error}});
        } catch (const Error& error) {
            return std::string(error.what()).find("point 3 at (9") != std::string::npos;
        }
        return false;
    });
}

TEST_F(CoreMemory, BoxLatticesOfOtherBases) {
    const Lattice rest = shapes::box({.cells = {2, 1, 1}});
    failEachAllocation([&] {
        const embed::TensorLattice tensor(rest.complex, rest.positions, embed::Basis::Bezier);
        return embed::bindPoints(tensor, points).table;
    });
}

TEST_F(CoreMemory, Evaluation) {
    const auto bound = bind();
    const auto& table = bound.table;
    const auto binding = bind::bindPoints({refined(0), lattice.positions}, points,
                                          bind::Level{.level = 2, .factors = true});
    failEachAllocation([&] { return osd::evaluateBinding(binding, lattice.positions); });
    failEachAllocation([&] {
        const osd::Deformer<float> deformer(binding);
        const std::vector<float> poses(2 * 3 * lattice.positions.size(), 1);
        std::vector<float> result(2 * 3 * points.size());
        deformer.deform(poses, result);
        return result;
    });

    const auto pose = flat(lattice.positions);
    const auto xyz = osd::BufferDescriptor::packed(3);
    const auto evaluated = [&](const auto& compiled) {
        std::vector<double> moved(3 * std::size_t(compiled.rowCount()));
        const auto width = std::size_t(compiled.columnCount());
        compiled.evaluate(std::span(pose).first(3 * width), xyz, moved, xyz,
                          {0, compiled.rowCount()});
        return moved;
    };
    failEachAllocation([&] { return evaluated(osd::CompiledTable<double>(table)); });
    failEachAllocation([&] { return evaluated(osd::CompiledAdjoint<double>(table)); });
    failEachAllocation([&] { return evaluated(osd::CompiledChain<double>(*binding.factors)); });
    const osd::CompiledTable<double> compiled(table);
    failEachAllocation([&] {
        const osd::ChangeEvaluator<double> changes(compiled);
        std::vector<double> moved(3 * points.size());
        changes.evaluateChanged(pose, xyz, moved, xyz, std::vector<Index>{0, 3});
        return std::tuple(moved, changes.rowsOf(std::vector<Index>{1}));
    });
}

TEST_F(CoreMemory, Solvers) {
    const auto table = stencils::selectRows(bind().table, std::vector<Index>{0, 1, 2});
    const std::vector<Point3> misses(3, Point3{0.1, 0, 0});
    for (const auto smoothing : {solve::Smoothing::None, solve::Smoothing::Laplacian})
        failEachAllocation([&] {
            return solve::fitLattice(table, misses, lattice.complex,
                                     {.smoothing = smoothing, .frozen = {0}})
                .displacements;
        });
    const auto refiner = refined(1);
    const auto rest = stencils::refinePositions(refiner, 1, lattice.positions);
    auto pose = rest;
    pose[0][2] += 1.5;
    failEachAllocation([&] {
        const solve::ValidityCheck check(refiner.level(1).complex, rest);
        return std::tuple(check.check(pose).inverted, check.largestStep(pose).length);
    });
    failEachAllocation([&] { return embed::verticesHoldingRows(table); });
    const TopologyRefiner parent(shapes::box({.min = {-2, -2, -2}, .max = {2, 2, 2}}).complex);
    const auto parentRest = shapes::box({.min = {-2, -2, -2}, .max = {2, 2, 2}}).positions;
    failEachAllocation([&] {
        return embed::nestTables(table, lattice.positions, {parent, parentRest}, {.level = 1});
    });
}

// An evaluation that fails for lack of memory has written nothing.
TEST_F(CoreMemory, DestinationsAreUnchanged) {
    const osd::CompiledTable<double> compiled(bind().table);
    const osd::ChangeEvaluator<double> changes(compiled);
    const auto pose = flat(lattice.positions);
    const auto xyz = osd::BufferDescriptor::packed(3);
    const std::vector<double> before(3 * points.size(), 42);
    const std::vector<Index> changed = {0, 3};
    const auto expectUntouched = [&](const auto& evaluate) {
        for (long n = 1;; ++n) {
            std::vector<double> moved = before;
            const auto into = [&] {
                evaluate(moved);
                return 0;
            };
            const auto it = test::attempt(test::Failing::One, n, into);
            if (!it.hasHappened) break;
            EXPECT_TRUE(it.isOutOfMemory);
            EXPECT_EQ(moved, before);
        }
    };
    expectUntouched([&](std::vector<double>& moved) {
        compiled.evaluate(pose, xyz, moved, xyz, {0, compiled.rowCount()});
    });
    expectUntouched([&](std::vector<double>& moved) {
        changes.evaluateChanged(pose, xyz, moved, xyz, changed);
    });
}

TEST_F(CoreMemory, DestroyingNeedsNoMemory) {
    auto bound = std::optional(bind());
    auto factored =
        std::optional(embed::bindFactored({refined(0), lattice.positions}, points, {.level = 2}));
    auto refiner = std::optional(refined(2));
    refiner->level(2).complex.relation(0, 3);
    std::optional<osd::CompiledTable<double>> compiled(bound->table);
    std::optional<osd::CompiledAdjoint<double>> adjoint(bound->table);
    std::optional<osd::CompiledChain<double>> chain(factored->table);
    std::optional<osd::ChangeEvaluator<double>> changes(*compiled);
    std::optional<Lattice> copy(lattice);
    auto let = [&] {
        changes.reset();
        chain.reset();
        adjoint.reset();
        compiled.reset();
        refiner.reset();
        factored.reset();
        bound.reset();
        copy.reset();
        return 0;
    };
    EXPECT_FALSE(test::attempt(test::Failing::AllFrom, 1, let).hasHappened);
}

// Moving objects allocates nothing either, so that containers keep their exception guarantees.
template <class... Types>
constexpr bool kMoveWithoutMemory = (... && (std::is_nothrow_move_constructible_v<Types> &&
                                             std::is_nothrow_move_assignable_v<Types>));
static_assert(kMoveWithoutMemory<CellComplex, far::Incidence, far::SignedIncidence, far::Level,
                                 far::Refinement, far::Marks, TopologyRefiner, Lattice>);
static_assert(
    kMoveWithoutMemory<StencilTable<double>, bind::Binding, embed::BoundRows<>, embed::Embedding>);
static_assert(kMoveWithoutMemory<osd::CompiledTable<double>, osd::CompiledAdjoint<float>,
                                 osd::CompiledChain<double>, osd::ChangeEvaluator<float>,
                                 osd::Deformer<float>, osd::Workspace, solve::LatticeFit>);

// If making a scope fails, the thread is unchanged.
TEST_F(CoreMemory, Scopes) {
    failEachAllocation([] {
        int calls = 0;
        const ProgressScope progress(
            [&calls, filling = std::vector<int>(10)](const Progress&) { return ++calls > 0; },
            std::chrono::milliseconds(0));
        parallelFor(10, 1, [](Offset, Offset) {});
        return calls;
    });
}

}  // namespace
}  // namespace espalier
