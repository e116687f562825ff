// SPDX-License-Identifier: Apache-2.0
#include <espalier/embed/local_binding.h>
#include <espalier/osd/binding_evaluator.h>
#include <espalier/osd/cpu_evaluator.h>
#include <espalier/stencils/composition.h>

#include <bit>
#include <cstdint>
#include <span>

#include "support/test.h"
#include "support/threads.h"
#include "support/zoo.h"

// Tables, bindings and results of the reference evaluator have the same bits everywhere: with any
// compiler, any number of threads and any instruction set of the processor. The numbers below are
// hashes of these bits, recorded when the test was written. They cannot be derived by hand; they
// reveal changes of rounding.

namespace espalier::osd {
namespace {

/// FNV-1a of numbers, byte by byte from the lowest.
class Hash {
public:
    template <class Number>
    void add(std::span<const Number> numbers) {
        for (const Number number : numbers) addNumber(number);
    }
    std::uint64_t value() const { return value_; }

private:
    void addNumber(double number) { addNumber(std::bit_cast<std::int64_t>(number)); }
    void addNumber(float number) { addNumber(std::bit_cast<std::int32_t>(number)); }
    template <class Integer>
    requires std::is_integral_v<Integer>
    void addNumber(Integer number) {
        for (unsigned byte = 0; byte < sizeof number; ++byte) {
            value_ ^= std::uint64_t(number) >> 8 * byte & 0xFF;
            value_ *= 0x100000001B3;
        }
    }

    std::uint64_t value_ = 0xCBF29CE484222325;
};

template <class Real>
void add(const stencils::StencilTable<Real>& table, Hash& hash) {
    hash.add(table.offsets());
    hash.add(table.columns());
    hash.add(table.weights());
}

/// Returns lattices whose coordinates are exact: no library function has rounded them.
std::vector<Lattice> exactLattices() {
    Lattice marked = shapes::box({.cells = {2, 2, 2}});
    marked.marks = {.edges = {{{0, 1}, far::kSmooth}, {{1, 4}, 2.3}, {{4, 13}, 0.7}},
                    .vertices = {{26, far::kInfinitelySharp}, {13, 1.4}}};
    return {mixedLattice(), shapes::box({.cells = {3, 2, 1}}), marked};
}

/// Returns a grid through the bounding box of all lattices and beyond.
std::vector<Point3> exactPoints() {
    std::vector<Point3> points;
    for (int i = -1; i < 9; ++i)
        for (int j = -1; j < 5; ++j)
            for (int k = -1; k < 5; ++k) points.push_back({i / 3.5, j / 4.0, k / 3.75});
    return points;
}

template <class Real>
void addResults(const TopologyRefiner& refiner, const Lattice& lattice, Hash& hash) {
    add(stencils::convertTable<Real>(stencils::buildStencils(refiner, refiner.maxLevel())), hash);
    const auto points = exactPoints();
    const auto bound =
        embed::bindPoints({TopologyRefiner(lattice.complex, refiner.options()), lattice.positions},
                          points, {.level = 2});
    const auto table = stencils::convertTable<Real>(bound.table);
    add(table, hash);
    std::vector<Real> source;
    for (const Point3& position : lattice.positions)
        for (const double coordinate : position) source.push_back(Real(1.25 * coordinate - 0.3));
    std::vector<Real> result(3 * table.rowCount());
    const BufferDescriptor points3{0, 3, 3};
    ReferenceEvaluator::evaluate<Real>(table, source, points3, result, points3,
                                       {0, table.rowCount()});
    hash.add(std::span<const Real>(result));
}

std::uint64_t hashOfAll(Boundary boundary, Rules rules) {
    Hash hash;
    for (const Lattice& lattice : exactLattices()) {
        TopologyRefiner refiner = refined(
            lattice.complex, 2, {.rules = rules, .boundary = boundary, .marks = lattice.marks});
        addResults<double>(refiner, lattice, hash);
        addResults<float>(refiner, lattice, hash);
    }
    return hash.value();
}

TEST(GoldenBits, AreTheSameEverywhere) {
    for (const int threads : {1, 7})
        withThreads(threads, [] {
            EXPECT_EQ(hashOfAll(Boundary::Sharp, Rules::Siggraph96), 0xA3681D55424EF23Au);
        });
    EXPECT_EQ(hashOfAll(Boundary::Sharp, Rules::Cse96), 0x19F6D810547894B6u);
    EXPECT_EQ(hashOfAll(Boundary::EdgeOnly, Rules::Siggraph96), 0xC89E8AF4CC1AE4F9u);
}

}  // namespace
}  // namespace espalier::osd
