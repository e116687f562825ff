// SPDX-License-Identifier: Apache-2.0
#include "result_check.h"

#include <espalier/far/error.h>
#include <espalier/osd/compiled_table.h>
#include <espalier/osd/cpu_evaluator.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <limits>
#include <random>
#include <vector>

namespace espalier::cli {
namespace {

using far::Index;
using far::Offset;
using osd::BufferDescriptor;
using ::testing::HasSubstr;

/// Rows of 60 entries, which sum to about 1, and values of two sets of three components.
template <class Real>
class ResultCheckTest : public ::testing::Test {
protected:
    static constexpr Index kRows = 5000, kColumns = 90, kEntries = 60;

    ResultCheckTest() {
        std::mt19937 random(1);
        std::uniform_real_distribution<double> uniform(0, 2.0 / kEntries), place(-1, 1);
        std::vector<Offset> offsets = {0};
        std::vector<Index> columns;
        std::vector<double> weights;
        for (Index row = 0; row < kRows; ++row) {
            for (Index k = 0; k < kEntries; ++k) {
                columns.push_back(row % (kColumns - kEntries) + k);
                weights.push_back(uniform(random));
            }
            offsets.push_back(static_cast<Offset>(columns.size()));
        }
        table = stencils::StencilTable<double>(kColumns, {offsets.begin(), offsets.end()},
                                               {columns.begin(), columns.end()},
                                               {weights.begin(), weights.end()});
        for (Index i = 0; i < 6 * kColumns; ++i) values.push_back(place(random));
        const auto rounded = [&] {
            if constexpr (sizeof(Real) == sizeof(float))
                return stencils::convertTable<float>(table);
            else
                return table;
        }();
        const std::vector<Real> source(values.begin(), values.end());
        const auto layout = BufferDescriptor::packed(6);
        plain.resize(6 * kRows);
        osd::CpuEvaluator::evaluate(rounded, source, layout, plain, layout, {0, kRows});
        compiled.resize(6 * kRows);
        osd::CompiledTable<Real>(rounded).evaluate(source, layout, compiled, layout, {0, kRows});
    }

    void check(const std::vector<Real>& results, UlpBound bound) const {
        for (const Offset offset : {0, 3})
            checkResults<Real>(table, values, results, {offset, 3, 6}, bound, "the test");
    }

    /// What is said of results of which one number is another.
    std::string complaint(std::size_t at, Real number) const {
        std::vector<Real> wrong = compiled;
        wrong[at] = number;
        try {
            check(wrong, compiledUlpBound);
        } catch (const Error& error) {
            return error.what();
        }
        return "none";
    }

    stencils::StencilTable<double> table;
    std::vector<double> values;
    std::vector<Real> plain, compiled;
};
using Reals = ::testing::Types<float, double>;
TYPED_TEST_SUITE(ResultCheckTest, Reals);

TYPED_TEST(ResultCheckTest, AcceptsWhatTheEvaluatorsMake) {
    this->check(this->plain, plainUlpBound);
    this->check(this->compiled, compiledUlpBound);
}

TYPED_TEST(ResultCheckTest, NamesTheFirstThatIsOff) {
    using Real = TypeParam;
    // Component 4 of point 1234 is coordinate 1 of the second set. Σ |w · x| is below 2, as 60
    // weights are at most 2/60 and values at most 1: what is added is 40 ulp of it or more, and in
    // double 4 + 61/2 are allowed, in float 4 + 1.
    const std::size_t at = 6 * 1234 + 4;
    const Real off = 80 * std::numeric_limits<Real>::epsilon();
    for (const Real number : {this->compiled[at] + off, this->compiled[at] - off}) {
        const std::string text = this->complaint(at, number);
        EXPECT_THAT(text, HasSubstr("the test: coordinate 1 of point 1234 is"));
        EXPECT_THAT(
            text, HasSubstr(sizeof(Real) == sizeof(float) ? "5 are allowed" : "34.5 are allowed"));
    }
    EXPECT_THAT(this->complaint(at, std::numeric_limits<Real>::quiet_NaN()),
                HasSubstr("point 1234"));
    EXPECT_EQ(this->complaint(at, this->compiled[at]), "none");
}

// Rows of points that are kept in place are empty, and give exactly 0.
TEST(ResultCheck, EmptyRows) {
    const stencils::StencilTable<double> table(1, {0, 0}, {}, {});
    const std::vector<double> values = {1};
    const auto layout = BufferDescriptor::packed(1);
    checkResults<double>(table, values, std::vector<double>{0}, layout, plainUlpBound, "");
    EXPECT_THROW(
        checkResults<double>(table, values, std::vector<double>{1e-300}, layout, plainUlpBound, ""),
        Error);
}

}  // namespace
}  // namespace espalier::cli
