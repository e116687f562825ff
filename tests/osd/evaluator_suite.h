// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <espalier/osd/evaluation.h>

#include <utility>

#include "osd/kernels/scratch.h"
#include "sums.h"
#include "support/tables.h"
#include "support/test.h"
#include "support/threads.h"

// Tests the contract of all evaluators, in osd/evaluation.h.
namespace espalier::osd {

/// A pair of evaluator and precision. Instantiate the suite with other pairs to test another back
/// end.
template <class E, class R>
struct Case {
    using Evaluator = typename E::template Of<R>;
    using Real = R;

    /// Returns why the suite cannot run here; empty if it can.
    static std::string skipReason() {
        if constexpr (requires { E::skipReason(); })
            return E::skipReason();
        else
            return {};
    }
};

template <class C>
class EvaluatorTest : public ::testing::Test {
protected:
    using Real = typename C::Real;
    using Evaluator = typename C::Evaluator;

    void SetUp() override {
        if (const std::string reason = C::skipReason(); !reason.empty()) GTEST_SKIP() << reason;
    }

    /// Rows: 2·x₁ + 3·x₃, none, −x₀.
    const StencilTable<Real> small{4, {0, 2, 2, 3}, {1, 3, 0}, {2, 3, -1}};

    using Row = std::pair<std::vector<Index>, std::vector<Real>>;

    static StencilTable<Real> tableOf(Index columnCount, const std::vector<Row>& rows) {
        Array<Offset> offsets = {0};
        Array<Index> columns;
        Array<Real> weights;
        for (const auto& [own, ofRow] : rows) {
            columns.insert(columns.end(), own.begin(), own.end());
            weights.insert(weights.end(), ofRow.begin(), ofRow.end());
            offsets.push_back(Offset(columns.size()));
        }
        return StencilTable<Real>(columnCount, offsets, columns, weights);
    }

    /// Returns some random columns, ascending.
    static std::vector<Index> randomColumns(Index columnCount, std::size_t count,
                                            std::mt19937& random) {
        std::vector<Index> columns(columnCount);
        std::iota(columns.begin(), columns.end(), Index{0});
        std::shuffle(columns.begin(), columns.end(), random);
        columns.resize(count);
        std::sort(columns.begin(), columns.end());
        return columns;
    }

    /// Returns sets of 1 to 40 rows with the same columns, in a random order. In every third set,
    /// the rows are outer products.
    static StencilTable<Real> tableOfSets(Index columnCount, unsigned seed) {
        std::mt19937 random(seed);
        std::uniform_real_distribution<Real> weight(Real(0.1), 1);
        std::vector<Row> rows;
        for (Index size = 1; size <= 40; ++size) {
            const bool isProduct = size % 3 == 0;
            const std::array<std::size_t, 3> sides = {1 + random() % 5, 2 + random() % 3,
                                                      1 + random() % 4};
            const auto columns = randomColumns(columnCount, sides[0] * sides[1] * sides[2], random);
            std::vector<std::size_t> slots(columns.size());
            std::iota(slots.begin(), slots.end(), std::size_t{0});
            std::shuffle(slots.begin(), slots.end(), random);
            for (Index i = 0; i < size; ++i) {
                std::array<std::vector<Real>, 3> factors;
                for (std::size_t axis = 0; axis < 3; ++axis)
                    for (std::size_t k = 0; k < sides[axis]; ++k)
                        factors[axis].push_back(weight(random));
                std::vector<Real> weights;
                for (const std::size_t p : slots)
                    weights.push_back(isProduct ? factors[0][p % sides[0]] *
                                                      factors[1][p / sides[0] % sides[1]] *
                                                      factors[2][p / sides[0] / sides[1]]
                                                : weight(random));
                rows.emplace_back(columns, weights);
            }
        }
        std::shuffle(rows.begin(), rows.end(), random);
        return tableOf(columnCount, rows);
    }

    /// Returns about 30 rows of each length from 1 to 30, in a random order. Most rows of a length
    /// have the same weights; each has its own columns.
    static StencilTable<Real> tableOfMasks(Index columnCount, unsigned seed) {
        std::mt19937 random(seed);
        std::vector<Row> rows;
        for (std::size_t length = 1; length <= 30; ++length) {
            const std::vector<Real> weights = test::randomValues<Real>(length, seed);
            for (int i = 0; i < 30; ++i)
                rows.emplace_back(
                    randomColumns(columnCount, length, random),
                    i % 10 == 9 ? test::randomValues<Real>(length, unsigned(random())) : weights);
        }
        std::shuffle(rows.begin(), rows.end(), random);
        return tableOf(columnCount, rows);
    }

    /// Returns 10 sets of 25 rows; each set has its own columns. Five sets have the same weights,
    /// in different orders of rows; the others differ from them in one number.
    static StencilTable<Real> tableOfEqualSets(Index columnCount, unsigned seed) {
        std::mt19937 random(seed);
        std::vector<std::vector<Real>> weights(25);
        for (auto& row : weights) row = test::randomValues<Real>(12, unsigned(random()));
        std::vector<Row> rows;
        for (int set = 0; set < 10; ++set) {
            const auto columns = randomColumns(columnCount, 12, random);
            std::shuffle(weights.begin(), weights.end(), random);
            for (const auto& row : weights) rows.emplace_back(columns, row);
            if (set >= 5) rows.back().second[set] += Real(0.5);
        }
        return tableOf(columnCount, rows);
    }
};
TYPED_TEST_SUITE_P(EvaluatorTest);

TYPED_TEST_P(EvaluatorTest, ByHand) {
    const std::vector<typename TestFixture::Real> source = {1, 10, 2, 20, 3, 30, 4, 40};
    std::vector<typename TestFixture::Real> destination(6, 99);
    typename TestFixture::Evaluator(this->small)
        .evaluate(source, {0, 2, 2}, destination, {0, 2, 2}, {0, 3});
    EXPECT_THAT(destination, ElementsAre(16, 160, 0, 0, -1, -10));
}

// Numbers between entries, before the offset and after the last row are not written.
TYPED_TEST_P(EvaluatorTest, OffsetsAndStrides) {
    using R = typename TestFixture::Real;
    const std::vector<R> source = {-7, 1, 10, -7, 2, 20, -7, 3, 30, -7, 4, 40};
    std::vector<R> destination(2 + 3 * 4, 99);
    typename TestFixture::Evaluator(this->small)
        .evaluate(source, {1, 2, 3}, destination, {2, 2, 4}, {0, 3});
    EXPECT_THAT(destination, ElementsAre(99, 99, 16, 160, 99, 99, 0, 0, 99, 99, -1, -10, 99, 99));
}

// Positions with the layout xyz? are read without a copy.
TYPED_TEST_P(EvaluatorTest, IgnoresValuesBetweenSourceEntries) {
    using R = typename TestFixture::Real;
    constexpr std::size_t kColumns = 90;
    const auto table = TestFixture::tableOfSets(Index(kColumns), 3);
    const typename TestFixture::Evaluator evaluator(table);
    for (const Offset length : {3, 5, 12}) {
        const auto packed = randomValues<R>(kColumns * std::size_t(length), 4);
        const BufferDescriptor layout = BufferDescriptor::packed(length);
        const BufferDescriptor spaced{0, length, paddedLength(length)};
        AlignedVector<R> source(kColumns * std::size_t(spaced.stride),
                                std::numeric_limits<R>::quiet_NaN());
        for (std::size_t i = 0; i < kColumns; ++i)
            std::copy_n(packed.begin() + std::ptrdiff_t(i) * length, length,
                        source.begin() + std::ptrdiff_t(i) * spaced.stride);
        std::vector<R> expected(table.rowCount() * length), result(expected.size());
        evaluator.evaluate(packed, layout, expected, layout, {0, table.rowCount()});
        evaluator.evaluate(source, spaced, result, layout, {0, table.rowCount()});
        EXPECT_EQ(result, expected) << length;
    }
}

TYPED_TEST_P(EvaluatorTest, SubRangeWritesOnlyItsRows) {
    using R = typename TestFixture::Real;
    const std::vector<R> source = {1, 2, 3, 4};
    std::vector<R> destination(3, 99);
    typename TestFixture::Evaluator(this->small)
        .evaluate(source, {0, 1, 1}, destination, {0, 1, 1}, {2, 3});
    EXPECT_THAT(destination, ElementsAre(99, 99, -1));
    typename TestFixture::Evaluator(this->small)
        .evaluate(source, {0, 1, 1}, destination, {0, 1, 1}, {1, 1});
    EXPECT_THAT(destination, ElementsAre(99, 99, -1));
    // The destination need not be longer than the range.
    std::vector<R> first(1, 99);
    typename TestFixture::Evaluator(this->small)
        .evaluate(source, {0, 1, 1}, first, {0, 1, 1}, {0, 1});
    EXPECT_THAT(first, ElementsAre(16));
}

// The kernels evaluate several rows at a time. A range may begin and end at any row of a group.
TYPED_TEST_P(EvaluatorTest, AnyRangeOfAGroupWritesOnlyItsRows) {
    using R = typename TestFixture::Real;
    constexpr Index kRows = 21, kColumns = 8;
    std::vector<typename TestFixture::Row> rows;
    for (Index row = 0; row < kRows; ++row)
        rows.push_back({{0, 1, 2, 3, 4, 5, 6, 7}, randomValues<R>(kColumns, unsigned(row))});
    const auto table = TestFixture::tableOf(kColumns, rows);
    const typename TestFixture::Evaluator evaluator(table);
    for (const Offset length : {3, 20}) {
        const auto layout = BufferDescriptor::packed(length);
        const auto source = randomValues<R>(kColumns * length, 4);
        std::vector<R> expected(kRows * length);
        evaluator.evaluate(source, layout, expected, layout, {0, kRows});
        for (Index first = 0; first < kRows; ++first)
            for (Index last = first; last <= kRows; ++last) {
                std::vector<R> result(expected.size(), 99), part = result;
                std::copy(expected.begin() + first * length, expected.begin() + last * length,
                          part.begin() + first * length);
                evaluator.evaluate(source, layout, result, layout, {first, last});
                ASSERT_EQ(result, part) << first << ' ' << last;
            }
    }
}

/// Compares results with sums in long double, for several numbers of components. Checks that any
/// number of threads and any range of rows give the same bits.
template <class Evaluator, class R>
void expectSums(const StencilTable<R>& table, const std::vector<R>& values) {
    const Index rowCount = table.rowCount();
    const Evaluator evaluator(table);
    // With 7 and 19, kernels evaluate some components twice.
    for (const Offset length : {1, 2, 3, 4, 5, 7, 12, 19}) {
        const BufferDescriptor layout = BufferDescriptor::packed(length);
        const auto source = std::span(values).first(table.columnCount() * length);
        std::vector<R> destination(rowCount * length);
        evaluator.evaluate(source, layout, destination, layout, {0, rowCount});
        // One rounding for each product and sum; rows have at most 60 entries.
        ASSERT_LE(test::errorOfSums<R>(table, source, length, destination), 61);
        for (const int threads : {1, 2, 8}) {
            std::vector<R> again(destination.size());
            test::withThreads(threads, [&] {
                evaluator.evaluate(source, layout, again, layout, {0, rowCount});
            });
            ASSERT_EQ(again, destination);
        }
        // A range in the middle, with gaps between entries and none after the last. Everything
        // outside the range stays as it was.
        const Index first = rowCount / 3, last = rowCount / 2;
        const BufferDescriptor spaced{1, length, length + 2};
        const R untouched = 99;
        std::vector<R> part(1 + (last - 1) * spaced.stride + length, untouched);
        evaluator.evaluate(source, layout, part, spaced, {first, last});
        for (std::size_t i = 0; i < part.size(); ++i) {
            const Offset row = (Offset(i) - 1) / spaced.stride;
            const Offset c = (Offset(i) - 1) % spaced.stride;
            const bool isWritten = i > 0 && row >= first && c < length;
            ASSERT_EQ(part[i], isWritten ? destination[row * length + c] : untouched) << i;
        }
    }
}

TYPED_TEST_P(EvaluatorTest, RandomTables) {
    using R = typename TestFixture::Real;
    expectSums<typename TestFixture::Evaluator, R>(randomTable<R>(5000, 60, 1),
                                                   randomValues<R>(60 * 19, 2));
}

TYPED_TEST_P(EvaluatorTest, RowsThatShareTheirColumns) {
    using R = typename TestFixture::Real;
    expectSums<typename TestFixture::Evaluator, R>(TestFixture::tableOfSets(90, 3),
                                                   randomValues<R>(90 * 19, 4));
}

TYPED_TEST_P(EvaluatorTest, RowsWithEqualWeights) {
    using R = typename TestFixture::Real;
    expectSums<typename TestFixture::Evaluator, R>(TestFixture::tableOfMasks(90, 5),
                                                   randomValues<R>(90 * 19, 6));
}

// Groups of rows have the same weights, but different columns.
TYPED_TEST_P(EvaluatorTest, GroupsWithEqualWeights) {
    using R = typename TestFixture::Real;
    expectSums<typename TestFixture::Evaluator, R>(TestFixture::tableOfEqualSets(90, 7),
                                                   randomValues<R>(90 * 19, 8));
}

TYPED_TEST_P(EvaluatorTest, RejectsBadArgumentsAndWritesNothing) {
    using R = typename TestFixture::Real;
    const std::vector<R> source(8, 1);
    std::vector<R> destination(6, 99);
    const auto expectRefused = [&](const char* why, std::span<const R> from,
                                   const BufferDescriptor& fromLayout, std::span<R> to,
                                   const BufferDescriptor& toLayout, RowRange rows) {
        EXPECT_REFUSED(Error, why,
                       typename TestFixture::Evaluator(this->small)
                           .evaluate(from, fromLayout, to, toLayout, rows));
        EXPECT_THAT(destination, Each(99));
    };
    const BufferDescriptor pairs{0, 2, 2};
    const std::span<const R> from(source);
    const std::span<R> to(destination);
    expectRefused("rows 0 to 4", from, pairs, to, pairs, {0, 4});
    expectRefused("rows -1 to 3", from, pairs, to, pairs, {-1, 3});
    expectRefused("rows 2 to 1", from, pairs, to, pairs, {2, 1});
    expectRefused("the source buffer holds 7", from.first(7), pairs, to, pairs, {0, 3});
    expectRefused("the destination buffer holds 5", from, pairs, to.first(5), pairs, {0, 3});
    expectRefused("the source buffer holds 8", from, {1, 2, 2}, to, pairs, {0, 3});
    expectRefused("stride 1", from, {0, 2, 1}, to, pairs, {0, 3});
    expectRefused("length 0", from, {0, 0, 2}, to, pairs, {0, 3});
    expectRefused("offset -1", from, {-1, 2, 2}, to, pairs, {0, 3});
    expectRefused("2 components, destination entries 1", from, pairs, to, {0, 1, 2}, {0, 3});
    // The product of this stride and the number of entries overflows.
    expectRefused("too few", from, {0, 2, Offset{1} << 62}, to, pairs, {0, 3});
}

// Layouts with the extreme values of their type are accepted or rejected as exact arithmetic
// decides; nothing outside the buffers is read or written.
TYPED_TEST_P(EvaluatorTest, LayoutsWithExtremeValues) {
    using R = typename TestFixture::Real;
    __extension__ typedef __int128 Wide;
    constexpr Offset kMax = std::numeric_limits<Offset>::max();
    constexpr Offset kMin = std::numeric_limits<Offset>::min();
    constexpr Offset kIndexMax = std::numeric_limits<Index>::max();
    const Offset corners[] = {kMin,          -1,       0,        1,        2,        3,   kIndexMax,
                              kIndexMax + 1, kMax / 8, kMax / 4, kMax - 2, kMax - 1, kMax};
    const std::vector<R> source(8, 1);
    std::vector<R> destination(8, 99);
    const StencilTable<R> withoutColumns(0, {0, 0, 0}, {}, {});
    const StencilTable<R> withoutRows(3, {0}, {}, {});
    const auto fits = [](const BufferDescriptor& layout, std::size_t size, Index entries) {
        if (layout.offset < 0 || layout.length < 1 || layout.stride < layout.length) return false;
        if (layout.length > kIndexMax || static_cast<Wide>(layout.offset) > Wide{size})
            return false;
        return entries == 0 ||
               Wide{layout.offset} + Wide{entries - 1} * layout.stride + layout.length <=
                   Wide{size};
    };
    int accepted = 0;
    const auto check = [&](const StencilTable<R>& table,
                           const typename TestFixture::Evaluator& evaluator, std::size_t size,
                           const BufferDescriptor& layout, bool isSource) {
        const BufferDescriptor packed = BufferDescriptor::packed(layout.length);
        const BufferDescriptor &from = isSource ? layout : packed, &to = isSource ? packed : layout;
        const std::size_t fromSize = isSource ? size : source.size();
        const std::size_t toSize = isSource ? destination.size() : size;
        const bool isGood =
            fits(from, fromSize, table.columnCount()) && fits(to, toSize, table.rowCount());
        accepted += isGood ? 1 : 0;
        try {
            evaluator.evaluate(std::span(source).first(fromSize), from,
                               std::span(destination).first(toSize), to, {0, table.rowCount()});
            EXPECT_TRUE(isGood) << layout.offset << ' ' << layout.length << ' ' << layout.stride;
        } catch (const Error&) {
            EXPECT_FALSE(isGood) << layout.offset << ' ' << layout.length << ' ' << layout.stride;
        } catch (const std::bad_alloc&) {
            // The padded copy would need entries of 2³¹ components, for which there is no memory.
            EXPECT_GE(layout.length, kIndexMax);
        }
    };
    for (const StencilTable<R>* table : {&this->small, &withoutColumns, &withoutRows}) {
        const typename TestFixture::Evaluator evaluator(*table);
        for (const std::size_t size : {std::size_t{0}, std::size_t{8}})
            for (const Offset offset : corners)
                for (const Offset length : corners)
                    for (const Offset stride : corners)
                        for (const bool isSource : {true, false})
                            check(*table, evaluator, size, {offset, length, stride}, isSource);
    }
    EXPECT_GT(accepted, 20);
}

REGISTER_TYPED_TEST_SUITE_P(EvaluatorTest, ByHand, OffsetsAndStrides,
                            IgnoresValuesBetweenSourceEntries, SubRangeWritesOnlyItsRows,
                            AnyRangeOfAGroupWritesOnlyItsRows, RandomTables,
                            RowsThatShareTheirColumns, RowsWithEqualWeights, GroupsWithEqualWeights,
                            RejectsBadArgumentsAndWritesNothing, LayoutsWithExtremeValues);

}  // namespace espalier::osd
