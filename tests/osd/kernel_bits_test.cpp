// SPDX-License-Identifier: Apache-2.0
#include <espalier/osd/kernels/kernels.h>

#include <algorithm>
#include <bit>
#include <cstdint>
#include <numeric>
#include <vector>

#include "osd/kernels/scratch.h"
#include "support/test.h"

// The kernels give the same bits for any tuning of the compiler. CMakeLists.txt compiles them a
// second time, for a processor for which GCC does not fuse products in loops by itself; and those
// for every processor, as if every processor could fuse.

namespace espalier::osd::kernels {
namespace tuned_baseline {
extern const Kernels<float> kFloatKernels;
extern const Kernels<double> kDoubleKernels;
}  // namespace tuned_baseline
namespace tuned_avx2 {
extern const Kernels<float> kFloatKernels;
extern const Kernels<double> kDoubleKernels;
}  // namespace tuned_avx2

namespace {

constexpr Index kRowCount = 37;  // not whole panels

/// Runs kernels and collects their results.
template <class Real>
class Runs {
public:
    explicit Runs(const Kernels<Real>& kernels) : kernels_(kernels) {
        std::iota(rows_.begin(), rows_.end(), Index{0});
    }

    const std::vector<Real>& results() const { return results_; }

    /// Any number of columns.
    void addPanels(Index columnCount, Offset length) {
        const auto weights = random(std::size_t(columnCount) * paddedRows(), 1);
        const auto points = random(std::size_t(columnCount * paddedLength(length)), 2);
        collect(length, [&](const Destination<Real>& to) {
            kernels_.panels({weights.data(), points.data(), paddedLength(length), columnCount,
                             rows_.data(), kRowCount},
                            to);
        });
    }

    void addProducts(Index n, Index m, Index l, Offset length) {
        const auto factors = random(std::size_t(n + m + l) * paddedRows(), 3);
        const auto points = random(std::size_t(n * m * l * paddedLength(length)), 4);
        collect(length, [&](const Destination<Real>& to) {
            kernels_.products({factors.data(),
                               points.data(),
                               paddedLength(length),
                               {n, m, l},
                               rows_.data(),
                               kRowCount},
                              to);
        });
    }

    void addRows(Index rowLength, bool isShared, Offset length) {
        const auto weights = random(std::size_t(rowLength * kRowCount), 5);
        const auto points = random(std::size_t(kRowCount * paddedLength(length)), 6);
        std::vector<Index> columns(std::size_t(rowLength * kRowCount));
        for (std::size_t i = 0; i < columns.size(); ++i) columns[i] = Index(i * 7 % kRowCount);
        collect(length, [&](const Destination<Real>& to) {
            kernels_.rows({weights.data(), isShared, columns.data(), rowLength, points.data(),
                           paddedLength(length), rows_.data(), kRowCount},
                          to);
        });
    }

    /// \param n, m, l the size of outer products, or 0
    void addAdjoint(Index n, Index m, Index l, Index columnCount, Offset length) {
        const Index numbers = n == 0 ? columnCount : n + m + l;
        const auto weights = random(std::size_t(numbers * kRowCount + kLanes<Real>), 7);
        const auto source = random(std::size_t(kRowCount * length), 8);
        AlignedVector<Real> sums(std::size_t(adjointSumCount<Real>(columnCount)));
        std::vector<Real> result(std::size_t(columnCount * length));
        kernels_.adjoint({weights.data(), {n, m, l}, columnCount, rows_.data(), kRowCount},
                         {source.data(), length, length}, result.data(), sums.data());
        results_.insert(results_.end(), result.begin(), result.end());
    }

    /// Rows that are outer products up to a few roundings, so that the check decides either way.
    void addFactors() {
        constexpr Index kSides[] = {4, 3, 2};
        constexpr std::size_t kColumns = 24, kFactors = 9;
        std::vector<Real> rows(kColumns * kRowCount);
        for (std::size_t r = 0; r < kRowCount; ++r) {
            const auto own = random(kFactors, unsigned(100 + r));
            for (std::size_t i = 0; i < kColumns; ++i)
                rows[r * kColumns + i] = own[i % 4] * own[4 + i / 4 % 3] * own[7 + i / 12] *
                                         (1 + Real(r % 5) * std::numeric_limits<Real>::epsilon());
        }
        std::vector<const Real*> weights;
        for (std::size_t r = 0; r < kRowCount; ++r) weights.push_back(&rows[r * kColumns]);
        std::vector<Index> sources(kColumns);
        std::iota(sources.begin(), sources.end(), Index{0});
        AlignedVector<Real> memory(
            std::size_t(factorizingCount<Real>(Offset(kColumns), Offset(kFactors))));
        std::vector<Real> factors(kFactors * kRowCount);
        std::vector<char> isProduct(kRowCount);
        kernels_.factorize({weights.data(),
                            kRowCount,
                            Index(kColumns),
                            sources.data(),
                            {kSides[0], kSides[1], kSides[2]},
                            memory.data()},
                           factors.data(), isProduct.data());
        results_.insert(results_.end(), factors.begin(), factors.end());
        results_.insert(results_.end(), isProduct.begin(), isProduct.end());
    }

private:
    static std::size_t paddedRows() {
        return std::size_t((kRowCount + kLanes<Real> - 1) / kLanes<Real> * kLanes<Real>);
    }

    static AlignedVector<Real> random(std::size_t count, unsigned seed) {
        const auto values = test::randomValues<Real>(count, seed);
        return {values.begin(), values.end()};
    }

    template <class Run>
    void collect(Offset length, Run run) {
        std::vector<Real> values(std::size_t(kRowCount * length));
        run({values.data(), length, length, 0, kRowCount, true, nullptr, 0, 1});
        results_.insert(results_.end(), values.begin(), values.end());
    }

    const Kernels<Real>& kernels_;
    std::vector<Index> rows_ = std::vector<Index>(kRowCount);
    std::vector<Real> results_;
};

template <class Real>
std::vector<Real> resultsOf(const Kernels<Real>& kernels) {
    Runs<Real> runs(kernels);
    for (const Offset length : {1, 2, 3, 4, 7, 19}) {
        for (const Index columnCount : {5, 16, 60}) runs.addPanels(columnCount, length);
        runs.addProducts(4, 4, 4, length);
        runs.addProducts(3, 3, 2, length);
        runs.addProducts(2, 2, 2, length);
        for (const Index rowLength : {4, 5, 9, 12})
            for (const bool isShared : {false, true}) runs.addRows(rowLength, isShared, length);
        runs.addAdjoint(0, 0, 0, 21, length);
        runs.addAdjoint(4, 4, 4, 64, length);
        runs.addAdjoint(3, 3, 2, 18, length);
    }
    runs.addFactors();
    return runs.results();
}

TEST(KernelBits, DoNotDependOnTheTuningOfTheCompiler) {
    EXPECT_EQ(resultsOf(tuned_baseline::kFloatKernels),
              resultsOf(kernelsFor<float>(Simd::Baseline)));
    EXPECT_EQ(resultsOf(tuned_baseline::kDoubleKernels),
              resultsOf(kernelsFor<double>(Simd::Baseline)));
    if (!hasSimd(Simd::Avx2)) GTEST_SKIP() << "this processor has no AVX2";
    EXPECT_EQ(resultsOf(tuned_avx2::kFloatKernels), resultsOf(kernelsFor<float>(Simd::Avx2)));
    EXPECT_EQ(resultsOf(tuned_avx2::kDoubleKernels), resultsOf(kernelsFor<double>(Simd::Avx2)));
}

}  // namespace
}  // namespace espalier::osd::kernels
