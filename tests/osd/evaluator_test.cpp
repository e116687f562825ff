// SPDX-License-Identifier: Apache-2.0
#include <espalier/osd/compiled_adjoint.h>
#include <espalier/osd/compiled_chain.h>
#include <espalier/osd/compiled_table.h>
#include <espalier/osd/cpu_evaluator.h>

#include <array>
#include <numeric>
#include <utility>

#include "evaluator_suite.h"
#include "host_device.h"

namespace espalier::osd {
namespace {

/// An evaluator that uses the table as it is.
template <class E>
struct Direct {
    template <class Real>
    class Of {
    public:
        explicit Of(const StencilTable<Real>& table) : table_(table) {}

        void evaluate(Values<Real> source, const BufferDescriptor& sourceLayout,
                      MutableValues<Real> destination, const BufferDescriptor& destinationLayout,
                      RowRange rows, const Addend<Real>& addend = {}) const {
            E::evaluate(table_, source, sourceLayout, destination, destinationLayout, rows, addend);
        }

    private:
        const StencilTable<Real>& table_;
    };
};

/// An evaluator that compiles the table. A processor without these instructions uses its best ones,
/// so the suite then runs on these twice.
template <Simd simd>
struct Compiled {
    template <class Real>
    class Of : public CompiledTable<Real> {
    public:
        explicit Of(const StencilTable<Real>& table)
            : CompiledTable<Real>(table, hasSimd(simd) ? simd : bestSimd()) {}
    };
};

/// Evaluates the adjoint of the transpose, which is the table again.
template <Simd simd>
struct Adjoint {
    template <class Real>
    class Of : public CompiledAdjoint<Real> {
    public:
        explicit Of(const StencilTable<Real>& table)
            : CompiledAdjoint<Real>(stencils::transposeTable(table),
                                    hasSimd(simd) ? simd : bestSimd()) {}
    };
};

template <class Real>
StencilTable<Real> identity(Index count) {
    Array<Offset> offsets(std::size_t(count) + 1);
    Array<Index> columns(count);
    std::iota(offsets.begin(), offsets.end(), Offset{0});
    std::iota(columns.begin(), columns.end(), Index{0});
    return {count, std::move(offsets), columns, Array<Real>(columns.size(), Real{1})};
}

/// A chain of the table and the identity.
struct Chained {
    template <class Real>
    class Of : public CompiledChain<Real> {
    public:
        explicit Of(const StencilTable<Real>& table)
            : CompiledChain<Real>(std::array{table, identity<Real>(table.rowCount())}) {}
    };
};

/// The adjoint of a chain of the identity and the transpose.
struct AdjointChained {
    template <class Real>
    class Of : public CompiledAdjointChain<Real> {
    public:
        explicit Of(const StencilTable<Real>& table)
            : CompiledAdjointChain<Real>(
                  std::array{identity<Real>(table.rowCount()), stencils::transposeTable(table)}) {}
    };
};

/// The kernels of GPUs, run on the host.
/// \tparam isGrouped true to group rows that share their columns
template <bool isGrouped>
struct OnHost {
    template <class Real>
    class Of : public HostDevice<Real> {
    public:
        explicit Of(const StencilTable<Real>& table) : HostDevice<Real>(table, isGrouped) {}
    };
};

template <bool isGrouped>
struct AdjointOnHost {
    template <class Real>
    class Of {
    public:
        explicit Of(const StencilTable<Real>& table)
            : device_(stencils::transposeTable(table), isGrouped) {}

        void evaluate(Values<Real> source, const BufferDescriptor& sourceLayout,
                      MutableValues<Real> destination, const BufferDescriptor& destinationLayout,
                      RowRange rows) const {
            device_.evaluateAdjoint(source, sourceLayout, destination, destinationLayout, rows);
        }

    private:
        HostDevice<Real> device_;
    };
};

using ProcessorCases = ::testing::Types<
    Case<Direct<ReferenceEvaluator>, float>, Case<Direct<ReferenceEvaluator>, double>,
    Case<Direct<CpuEvaluator>, float>, Case<Direct<CpuEvaluator>, double>,
    Case<Compiled<Simd::Baseline>, float>, Case<Compiled<Simd::Baseline>, double>,
    Case<Compiled<Simd::Avx2>, float>, Case<Compiled<Simd::Avx2>, double>,
    Case<Compiled<Simd::Avx512>, float>, Case<Compiled<Simd::Avx512>, double>, Case<Chained, float>,
    Case<Chained, double>, Case<Adjoint<Simd::Baseline>, float>,
    Case<Adjoint<Simd::Baseline>, double>, Case<Adjoint<Simd::Avx2>, float>,
    Case<Adjoint<Simd::Avx2>, double>, Case<Adjoint<Simd::Avx512>, float>,
    Case<Adjoint<Simd::Avx512>, double>, Case<AdjointChained, float>, Case<AdjointChained, double>>;
using DeviceCases =
    ::testing::Types<Case<OnHost<true>, float>, Case<OnHost<true>, double>,
                     Case<OnHost<false>, float>, Case<OnHost<false>, double>,
                     Case<AdjointOnHost<true>, float>, Case<AdjointOnHost<true>, double>,
                     Case<AdjointOnHost<false>, float>, Case<AdjointOnHost<false>, double>>;

INSTANTIATE_TYPED_TEST_SUITE_P(Processor, EvaluatorTest, ProcessorCases);
INSTANTIATE_TYPED_TEST_SUITE_P(DeviceOnHost, EvaluatorTest, DeviceCases);

/// The tests of the Addend, which evaluators on processors take.
template <class C>
class AddendTest : public EvaluatorTest<C> {};
TYPED_TEST_SUITE(AddendTest, ProcessorCases);

// Each result is the sum without an addend, plus the addend: one addition. Poses as further
// components add the same entries.
TYPED_TEST(AddendTest, IsAddedToEachSum) {
    using R = typename TestFixture::Real;
    for (const StencilTable<R>& table :
         {this->small, randomTable<R>(500, 90, 9), TestFixture::tableOfSets(90, 3),
          TestFixture::tableOfMasks(90, 5)}) {
        const typename TestFixture::Evaluator evaluator(table);
        const Index rowCount = table.rowCount();
        for (const auto& [length, own] :
             {std::pair<Offset, Offset>{3, 3}, {1, 1}, {36, 3}, {10, 5}, {5, 1}, {4, 2}}) {
            const BufferDescriptor layout = BufferDescriptor::packed(length);
            const auto source = randomValues<R>(table.columnCount() * length, 4);
            const BufferDescriptor spaced{2, own, own + 1};
            const auto values = randomValues<R>(2 + rowCount * spaced.stride, 5);
            std::vector<R> expected(rowCount * length), result(expected.size());
            evaluator.evaluate(source, layout, expected, layout, {0, rowCount});
            for (Index row = 0; row < rowCount; ++row)
                for (Offset c = 0; c < length; ++c)
                    expected[row * length + c] += values[2 + row * spaced.stride + c % own];
            for (const int threads : {1, 4}) {
                test::withThreads(threads, [&] {
                    evaluator.evaluate(source, layout, result, layout, {0, rowCount},
                                       Addend<R>{values, spaced});
                });
                ASSERT_EQ(result, expected) << length << ' ' << own;
            }
            // A range writes its rows only, and needs no longer addend.
            const Index first = rowCount / 3, last = rowCount / 2;
            std::vector<R> part(result.size(), 99);
            const auto shorter =
                std::span(values).first(2 + std::max(last - 1, 0) * spaced.stride + own);
            evaluator.evaluate(source, layout, part, layout, {first, last},
                               Addend<R>{shorter, spaced});
            for (std::size_t i = 0; i < part.size(); ++i) {
                const Index row = Index(Offset(i) / length);
                ASSERT_EQ(part[i], row >= first && row < last ? expected[i] : R(99)) << i;
            }
        }
    }
}

// The reference adds the terms in the order of the table, and the addend last.
TYPED_TEST(AddendTest, AgreesWithTheReference) {
    using R = typename TestFixture::Real;
    const auto table = TestFixture::tableOfSets(90, 3);
    const BufferDescriptor poses = BufferDescriptor::packed(12);
    const auto source = randomValues<R>(90 * 12, 4),
               values = randomValues<R>(3 * table.rowCount(), 5);
    const auto addend = Addend<R>::packed(values, 3);
    std::vector<R> expected(table.rowCount() * 12), result(expected.size());
    ReferenceEvaluator::evaluate(table, source, poses, expected, poses, {0, table.rowCount()},
                                 addend);
    typename TestFixture::Evaluator(table).evaluate(source, poses, result, poses,
                                                    {0, table.rowCount()}, addend);
    // Sums of at most 60 products below 1, and an addend below 1: one rounding for each.
    for (std::size_t i = 0; i < result.size(); ++i)
        ASSERT_NEAR(result[i], expected[i], 61 * 61 * std::numeric_limits<R>::epsilon());
}

// x + D · 0 is x, bit for bit: what a pose leaves alone stays as it was.
TYPED_TEST(AddendTest, IsTheResultWithoutDisplacements) {
    using R = typename TestFixture::Real;
    const auto table = TestFixture::tableOfSets(90, 3);
    const BufferDescriptor layout = BufferDescriptor::packed(3);
    std::vector<R> rest = randomValues<R>(table.rowCount() * std::size_t{3}, 6);
    for (R& value : rest) value = value * 1000 + R(0.1);
    const std::vector<R> source(90 * 3, 0);
    std::vector<R> result(rest.size());
    typename TestFixture::Evaluator(table).evaluate(
        source, layout, result, layout, {0, table.rowCount()}, Addend<R>::packed(rest, 3));
    EXPECT_EQ(result, rest);
}

TYPED_TEST(AddendTest, IsCheckedBeforeAnythingIsWritten) {
    using R = typename TestFixture::Real;
    const std::vector<R> source(16, 1), values(12, 1);
    std::vector<R> destination(12, 99);
    const auto expectRefused = [&](const char* why, std::size_t size,
                                   const BufferDescriptor& layout) {
        EXPECT_REFUSED(Error, why,
                       typename TestFixture::Evaluator(this->small)
                           .evaluate(source, {0, 4, 4}, destination, {0, 4, 4}, {0, 3},
                                     Addend<R>{std::span(values).first(size), layout}));
        EXPECT_THAT(destination, Each(99));
    };
    expectRefused("the addend buffer holds 11", 11, {0, 4, 4});
    expectRefused("the addend buffer holds 0", 0, {0, 4, 4});
    expectRefused("the addend buffer holds 12", 12, {1, 4, 4});
    expectRefused("offset -1, length 4", 12, {-1, 4, 4});
    expectRefused("stride 1", 12, {0, 2, 1});
    expectRefused("length -4", 12, {0, -4, 4});
    expectRefused("have 4 components; expected a multiple of the 3 of the addend", 12, {0, 3, 3});
}

}  // namespace
}  // namespace espalier::osd
