// SPDX-License-Identifier: Apache-2.0
#include "result_check.h"

#include <espalier/base/error.h>
#include <espalier/base/parallel.h>
#include <espalier/osd/cpu_evaluator.h>
#include <fmt/format.h>

#include <cmath>
#include <limits>
#include <utility>

namespace espalier::cli {
namespace {

using osd::BufferDescriptor;

constexpr Offset kGrain = 2048;

/// Bounds on rounded numbers, packed: for each number the size of its sum, Σ |w · x| through all
/// tables so far, and its largest error.
struct RoundingBounds {
    std::vector<double> sizes, errors;

    explicit RoundingBounds(Offset count) : sizes(count), errors(count) {}
};

template <class Real>
constexpr double kUlp = std::numeric_limits<Real>::epsilon();

/// Subnormal numbers are rounded to multiples of this.
template <class Real>
constexpr double kLeast = std::numeric_limits<Real>::denorm_min();

/// True if weights and values, which are given in double, are rounded before they are applied, by
/// half an ulp each.
template <class Real>
constexpr bool kRounds = sizeof(Real) < sizeof(double);

template <class Real>
RoundingBounds roundedValues(std::span<const double> values, const BufferDescriptor& layout,
                             Index count) {
    RoundingBounds result(count * layout.length);
    for (Index entry = 0; entry < count; ++entry)
        for (Offset c = 0; c < layout.length; ++c) {
            const Offset i = entry * layout.length + c;
            const double size = std::abs(values[layout.offset + entry * layout.stride + c]);
            result.sizes[i] = size;
            if (kRounds<Real>) result.errors[i] = kUlp<Real> / 2 * size + kLeast<Real>;
        }
    return result;
}

/// Returns the bounds after a table has been applied.
template <class Real>
RoundingBounds apply(const stencils::StencilTable<double>& table, const RoundingBounds& source,
                     Offset length, UlpBound bound) {
    RoundingBounds result(table.rowCount() * length);
    parallelFor(table.rowCount(), kGrain, [&](Offset first, Offset last) {
        for (Offset i = first * length; i < last * length; ++i) {
            const auto row = static_cast<Index>(i / length);
            const auto columns = table.columns(row);
            const auto weights = table.weights(row);
            double size = 0, error = 0;
            for (std::size_t k = 0; k < columns.size(); ++k) {
                const std::size_t from = columns[k] * length + i % length;
                size += std::abs(weights[k]) * source.sizes[from];
                error += std::abs(weights[k]) * source.errors[from];
            }
            const auto entries = static_cast<double>(columns.size());
            const double ulps = bound(entries) + (kRounds<Real> ? 0.5 : 0);
            result.sizes[i] = size;
            result.errors[i] = error + ulps * kUlp<Real> * size + entries * kLeast<Real>;
        }
    });
    return result;
}

}  // namespace

double plainUlpBound(double entries) {
    return (entries + 1) / 2;
}

double compiledUlpBound(double entries) {
    constexpr double kShort = 64;
    return entries <= kShort ? 4 : 4 + entries / 32;
}

ExpectedSums::ExpectedSums(const Table& matrix, UlpBound bound)
    : matrix_(&matrix), applied_{&matrix}, summed_{&matrix}, bound_(bound) {}

ExpectedSums::ExpectedSums(const Table& matrix, const stencils::FactoredTable<double>& factors,
                           UlpBound bound)
    : matrix_(&matrix),
      applied_{&factors.vertices, &factors.points},
      summed_{&matrix, &factors.points},
      bound_(bound) {
    if (factors.rowCount() != matrix.rowCount() || factors.columnCount() != matrix.columnCount())
        throw Error(fmt::format("the product of the factors is {} × {}, but the matrix is {} × {}",
                                factors.rowCount(), factors.columnCount(), matrix.rowCount(),
                                matrix.columnCount()));
}

template <class Real>
ExpectedSums::Numbers ExpectedSums::of(std::span<const double> values,
                                       const BufferDescriptor& layout) const {
    const Offset length = layout.length;
    RoundingBounds rounded = roundedValues<Real>(values, layout, matrix_->columnCount());
    for (const Table* table : applied_) rounded = apply<Real>(*table, rounded, length, bound_);

    Numbers numbers{std::vector<double>(rounded.sizes.size()), std::move(rounded.errors)};
    const auto packed = BufferDescriptor::packed(length);
    parallelFor(matrix_->rowCount(), kGrain, [&](Offset first, Offset last) {
        osd::ReferenceEvaluator::evaluate(*matrix_, values, layout, numbers.values, packed,
                                          {static_cast<Index>(first), static_cast<Index>(last)});
        for (Offset i = first * length; i < last * length; ++i) {
            const auto row = static_cast<Index>(i / length);
            // A weight of D = W · S has the rounding error of a sum over a row of W, relative to
            // Σ_k |W_ik · S_kj|. Multiplied by |x_j| and summed over j, this is again the size of
            // the sums of the factors. All of it is negligible if results are rounded to float.
            for (const Table* table : summed_) {
                const auto entries = static_cast<double>(table->columns(row).size());
                numbers.allowed[i] += plainUlpBound(entries) * kUlp<double> * rounded.sizes[i] +
                                      entries * kLeast<double>;
            }
        }
    });
    return numbers;
}

template <class Real>
void checkResults(const ExpectedSums& sums, std::span<const double> values,
                  std::span<const Real> results, const BufferDescriptor& layout,
                  const std::string& who) {
    const ExpectedSums::Numbers expected = sums.of<Real>(values, layout);
    for (std::size_t i = 0; i < expected.values.size(); ++i) {
        const Offset point = static_cast<Offset>(i) / layout.length;
        const Offset component = static_cast<Offset>(i) % layout.length;
        const double wanted = expected.values[i];
        const double got = double{results[layout.offset + point * layout.stride + component]};
        // Written this way, the condition also catches NaN.
        if (!(std::abs(got - wanted) <= expected.allowed[i]))
            throw Error(fmt::format(
                "{}: coordinate {} of point {} is {:.17g}, but the reference evaluator computes "
                "{:.17g}; "
                "they differ by {:.3g}, and {:.3g} is allowed",
                who, component, point, got, wanted, std::abs(got - wanted), expected.allowed[i]));
    }
}

template ExpectedSums::Numbers ExpectedSums::of<float>(std::span<const double>,
                                                       const BufferDescriptor&) const;
template ExpectedSums::Numbers ExpectedSums::of<double>(std::span<const double>,
                                                        const BufferDescriptor&) const;
template void checkResults(const ExpectedSums&, std::span<const double>, std::span<const float>,
                           const BufferDescriptor&, const std::string&);
template void checkResults(const ExpectedSums&, std::span<const double>, std::span<const double>,
                           const BufferDescriptor&, const std::string&);

}  // namespace espalier::cli
