// SPDX-License-Identifier: Apache-2.0
#include "result_check.h"
#include "support/test.h"

#include <espalier/osd/compiled_chain.h>
#include <espalier/osd/compiled_table.h>
#include <espalier/osd/cpu_evaluator.h>
#include <espalier/stencils/composition.h>

#include <utility>

namespace espalier::cli {
namespace {

using osd::BufferDescriptor;
using stencils::FactoredTable;
using stencils::StencilTable;

template <class Real>
constexpr Real kUlp = std::numeric_limits<Real>::epsilon();

/// Returns a table whose rows have `entries` consecutive columns. The first column moves on by one
/// from row to row, and starts again at 0.
template <class Weight>
StencilTable<double> bandTable(Index rows, Index columnCount, Index entries, Weight weight) {
    std::vector<Offset> offsets = {0};
    std::vector<Index> columns;
    std::vector<double> weights;
    for (Index row = 0; row < rows; ++row) {
        for (Index k = 0; k < entries; ++k) {
            columns.push_back(row % (columnCount - entries) + k);
            weights.push_back(weight());
        }
        offsets.push_back(Offset(columns.size()));
    }
    return {columnCount,
            {offsets.begin(), offsets.end()},
            {columns.begin(), columns.end()},
            {weights.begin(), weights.end()}};
}

/// Returns the table with one weight replaced.
StencilTable<double> withWeight(const StencilTable<double>& table, Index row, std::size_t entry,
                                double weight) {
    Array<double> weights(table.weights().begin(), table.weights().end());
    weights[std::size_t(table.offsets()[row]) + entry] = weight;
    return {table.columnCount(),
            {table.offsets().begin(), table.offsets().end()},
            {table.columns().begin(), table.columns().end()},
            std::move(weights)};
}

template <class Real>
StencilTable<Real> rounded(const StencilTable<double>& table) {
    return stencils::convertTable<Real>(StencilTable<double>(table));
}

/// Provides random values with two sets of three components, and evaluates tables on them.
template <class Real>
class ResultCheckTest : public ::testing::Test {
protected:
    static constexpr Index kRows = 5000, kColumns = 90;

    ResultCheckTest() {
        for (Index i = 0; i < 6 * kColumns; ++i) values.push_back(uniform(-1, 1));
        source.assign(values.begin(), values.end());
    }

    double uniform(double low, double high) {
        return std::uniform_real_distribution<double>(low, high)(random);
    }

    /// Returns a table with rows of 60 weights, which sum to about 1.
    StencilTable<double> table() {
        constexpr Index kEntries = 60;
        return bandTable(kRows, kColumns, kEntries, [&] { return uniform(0, 2.0 / kEntries); });
    }

    template <class Compiled>
    std::vector<Real> evaluate(const Compiled& compiled) const {
        std::vector<Real> results(6 * kRows);
        compiled.evaluate(source, layout, results, layout, {0, kRows});
        return results;
    }
    std::vector<Real> evaluate(const FactoredTable<double>& factors) const {
        return evaluate(osd::CompiledChain<Real>(
            FactoredTable<Real>{rounded<Real>(factors.vertices), rounded<Real>(factors.points)}));
    }

    void check(const ExpectedSums& sums, const std::vector<Real>& results) const {
        for (const Offset offset : {0, 3})
            checkResults<Real>(sums, values, results, {offset, 3, 6}, "the test");
    }

    /// Returns the message of the check, or "" if it accepts the results.
    std::string complaint(const ExpectedSums& sums, const std::vector<Real>& results) const {
        return messageOf([&] { check(sums, results); });
    }

    std::mt19937 random{1};
    std::vector<double> values;
    std::vector<Real> source;  ///< the values rounded
    BufferDescriptor layout = BufferDescriptor::packed(6);
};
TYPED_TEST_SUITE(ResultCheckTest, Reals);

TYPED_TEST(ResultCheckTest, AcceptsResultsOfTheEvaluators) {
    const StencilTable<double> table = this->table();
    const StencilTable<TypeParam> applied = rounded<TypeParam>(table);
    std::vector<TypeParam> plain(6 * this->kRows);
    osd::CpuEvaluator::evaluate(applied, this->source, this->layout, plain, this->layout,
                                {0, this->kRows});
    this->check({table, plainUlpBound}, plain);
    this->check({table, compiledUlpBound}, this->evaluate(osd::CompiledTable<TypeParam>(applied)));
}

TYPED_TEST(ResultCheckTest, NamesTheFirstWrongResult) {
    using Real = TypeParam;
    const StencilTable<double> table = this->table();
    const ExpectedSums sums(table, compiledUlpBound);
    auto results = this->evaluate(osd::CompiledTable<Real>(rounded<Real>(table)));
    // Component 4 of point 1234 is coordinate 1 of the second set. Σ |w · x| is below 2, because
    // the 60 weights are at most 2/60 and the values at most 1. So 80 ulp of 1 are at least 40 ulp
    // of Σ |w · x|. The allowed error is 4 + 61/2 ulp in double, and 4 + 1 ulp in float.
    Real& number = results[6 * 1234 + 4];
    const Real right = number;
    for (const Real wrong : {right + 80 * kUlp<Real>, right - 80 * kUlp<Real>}) {
        number = wrong;
        EXPECT_THAT(this->complaint(sums, results),
                    HasSubstr("the test: coordinate 1 of point 1234 is"));
    }
    number = std::numeric_limits<Real>::quiet_NaN();
    EXPECT_THAT(this->complaint(sums, results), HasSubstr("point 1234"));
    number = right;
    EXPECT_EQ(this->complaint(sums, results), "");
}

/// Provides factors W and S of a matrix D = W · S. W has large weights of both signs, as for points
/// far outside, but D has small weights: rows of W sum to 1, and rows of S are nearly equal.
template <class Real>
class FactorsCheckTest : public ResultCheckTest<Real> {
protected:
    static constexpr Index kVertices = 400;

    FactorsCheckTest() {
        constexpr Index kAll = ResultCheckTest<Real>::kColumns - 1, kCorners = 8;
        factors.vertices = bandTable(kVertices, this->kColumns, kAll,
                                     [&] { return this->uniform(1, 1.001) / kAll; });
        Index k = 0;
        double rest = 1;
        factors.points = bandTable(this->kRows, kVertices, kCorners, [&] {
            const bool isLast = ++k % kCorners == 0;
            const double weight = isLast ? rest : this->uniform(-1000, 1000);
            rest = isLast ? 1 : rest - weight;
            return weight;
        });
        matrix = stencils::multiply(factors.points, factors.vertices);
    }

    FactoredTable<double> factors;
    StencilTable<double> matrix;
};
TYPED_TEST_SUITE(FactorsCheckTest, Reals);

TYPED_TEST(FactorsCheckTest, AcceptsResultsOfTheChain) {
    const auto results = this->evaluate(this->factors);
    this->check({this->matrix, this->factors, compiledUlpBound}, results);
    // The rounding errors come from the sums over the factors, whose terms are larger than the
    // terms of the matrix's sums. So the bound for the matrix alone is too small.
    EXPECT_NE(this->complaint({this->matrix, compiledUlpBound}, results), "");
}

// The expected values come from the matrix. So wrong factors are found even if the chain evaluates
// them exactly.
TYPED_TEST(FactorsCheckTest, NamesTheFirstPointThatAWrongFactorMoves) {
    const auto expectCaught = [&](const FactoredTable<double>& wrong, const char* point) {
        EXPECT_THAT(this->complaint({this->matrix, wrong, compiledUlpBound}, this->evaluate(wrong)),
                    HasSubstr(point));
    };
    // Σ |w · x| is a few thousand. The allowed error is 13 ulp of it in float, which is a few
    // thousandths, and 65 ulp in double. The wrong weights change results by about 500 · 1/2 and
    // 1000 · 1/20: values at vertices are about 1/20.
    FactoredTable<double> wrong = this->factors;
    wrong.vertices = withWeight(wrong.vertices, 100, 50, 1);
    expectCaught(wrong, " of point 93 is");  // Rows 93 to 100 use vertex 100.
    wrong = this->factors;
    wrong.points = withWeight(wrong.points, 1234, 2, wrong.points.weights(1234)[2] + 1000);
    expectCaught(wrong, " of point 1234 is");
}

template <class Real>
std::vector<double> allowedFor(const ExpectedSums& sums, const std::vector<double>& values) {
    return sums.of<Real>(values, BufferDescriptor::packed(1)).allowed;
}

// The numbers are computed by hand: D = (3 −2) · (1 1; 1 −1) = (1 5), and both values are 1.
TEST(ExpectedSums, AddsUpTheBoundsOfAllTables) {
    const FactoredTable<double> factors = {{2, {0, 2, 4}, {0, 1, 0, 1}, {1, 1, 1, -1}},
                                           {2, {0, 2}, {0, 1}, {3, -2}}};
    const StencilTable<double> matrix(2, {0, 2}, {0, 1}, {1, 5});
    const std::vector<double> values = {1, 1};
    const ExpectedSums byMatrix(matrix, compiledUlpBound);
    const ExpectedSums byFactors(matrix, factors, compiledUlpBound);
    EXPECT_EQ(byMatrix.of<double>(values, BufferDescriptor::packed(1)).values[0], 6);
    EXPECT_EQ(byFactors.of<double>(values, BufferDescriptor::packed(1)).values[0], 6);

    // By the matrix, Σ |w · x| is 6, and the reference's bound is 3/2 ulp. By the factors,
    // Σ |w · x| is 2 for each vertex and 3 · 2 + 2 · 2 for the point. The reference's bound counts
    // twice, because the weights of D are sums too. The allowance for subnormal numbers is
    // negligible beside an ulp of 1.
    EXPECT_DOUBLE_EQ(allowedFor<double>(byMatrix, values)[0], (4 + 1.5) * 6 * kUlp<double>);
    EXPECT_DOUBLE_EQ(allowedFor<double>(byFactors, values)[0],
                     (3 * (4 * 2) + 2 * (4 * 2) + 4 * 10 + (1.5 + 1.5) * 10) * kUlp<double>);

    // In float, each weight and each value is rounded by half an ulp. The reference computes in
    // double: its bound is 3 · 2^-29 ulp of float.
    constexpr double kRelative = 1e-8;
    const double matrixBound = (4 + 0.5 + 0.5) * 6 * double{kUlp<float>};
    EXPECT_NEAR(allowedFor<float>(byMatrix, values)[0], matrixBound, kRelative * matrixBound);
    const double vertexBound = 0.5 * 2 + (4 + 0.5) * 2;
    const double pointBound = (3 + 2) * vertexBound + (4 + 0.5) * 10;
    EXPECT_NEAR(allowedFor<float>(byFactors, values)[0], pointBound * double{kUlp<float>},
                kRelative * pointBound * double{kUlp<float>});
}

// Near 0, results and intermediate values are multiples of the smallest subnormal number.
TEST(ExpectedSums, AllowsForSubnormalNumbers) {
    constexpr double kLeast = std::numeric_limits<float>::denorm_min();
    const FactoredTable<double> factors = {{1, {0, 1}, {0}, {0.5}}, {1, {0, 1}, {0}, {10}}};
    const StencilTable<double> matrix(1, {0, 1}, {0}, {5});
    // The value at the vertex is half of the smallest number. It may be rounded to 0 or to the
    // smallest number, and the result is ten times as large.
    const auto check = [&](float result) {
        const ExpectedSums sums(matrix, factors, compiledUlpBound);
        checkResults<float>(sums, std::vector<double>{kLeast}, std::vector<float>{result},
                            BufferDescriptor::packed(1), "");
    };
    check(0);
    check(10 * float(kLeast));
    EXPECT_THROW(check(100 * float(kLeast)), Error);
}

TEST(ExpectedSums, RefusesFactorsOfAnotherMatrix) {
    const FactoredTable<double> factors = {{2, {0, 1}, {1}, {1}}, {1, {0, 1}, {0}, {1}}};
    const auto expectRefused = [&](const StencilTable<double>& matrix, const char* why) {
        EXPECT_REFUSED(Error, why, ExpectedSums(matrix, factors, compiledUlpBound));
    };
    expectRefused({2, {0, 1, 2}, {0, 1}, {1, 1}}, "factors is 1 × 2, but the matrix is 2 × 2");
    expectRefused({3, {0, 1}, {0}, {1}}, "factors is 1 × 2, but the matrix is 1 × 3");
}

// Points that are kept in place have empty rows, which give exactly 0.
TEST(ResultCheck, EmptyRows) {
    const StencilTable<double> table(1, {0, 0}, {}, {});
    const FactoredTable<double> factors = {{1, {0}, {}, {}}, {0, {0, 0}, {}, {}}};
    for (const ExpectedSums& sums :
         {ExpectedSums(table, plainUlpBound), ExpectedSums(table, factors, compiledUlpBound)}) {
        const auto check = [&](double result) {
            checkResults<double>(sums, std::vector<double>{1}, std::vector<double>{result},
                                 BufferDescriptor::packed(1), "");
        };
        check(0);
        EXPECT_THROW(check(1e-300), Error);
    }
}

}  // namespace
}  // namespace espalier::cli
