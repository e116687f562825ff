// SPDX-License-Identifier: Apache-2.0
#include "result_check.h"

#include <espalier/far/error.h>
#include <espalier/far/parallel.h>
#include <espalier/osd/reference_evaluator.h>
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

namespace espalier::cli {
namespace {

using far::Index;
using far::Offset;

/// Σ |w · x| of a row.
double sizeOf(const stencils::StencilTable<double>& table, Index row,
              std::span<const double> values, const osd::BufferDescriptor& layout,
              Offset component) {
    double size = 0;
    const auto columns = table.columns(row);
    const auto weights = table.weights(row);
    for (std::size_t k = 0; k < columns.size(); ++k)
        size += std::abs(weights[k] * values[static_cast<std::size_t>(
                                          layout.offset + columns[k] * layout.stride + component)]);
    return size;
}

/// What the reference may be off the exact sum of what was evaluated, in ulp of Real.
template <class Real>
double referenceUlpBound(double entries) {
    // Its own roundings are nothing in float; those of a weight and of a value are half an ulp
    // each.
    return sizeof(Real) == sizeof(double) ? plainUlpBound(entries) : 1;
}

}  // namespace

double plainUlpBound(double entries) {
    return (entries + 1) / 2;
}

double compiledUlpBound(double entries) {
    constexpr double kShort = 64;
    return entries <= kShort ? 4 : 4 + entries / 32;
}

template <class Real>
void checkResults(const stencils::StencilTable<double>& table, std::span<const double> values,
                  std::span<const Real> results, const osd::BufferDescriptor& layout,
                  UlpBound bound, const std::string& who) {
    constexpr Offset kGrain = 2048;
    const Offset length = layout.length;
    std::vector<double> expected(static_cast<std::size_t>(table.rowCount() * length));
    const auto packed = osd::BufferDescriptor::packed(length);
    far::parallelFor(table.rowCount(), kGrain, [&](Offset first, Offset last) {
        osd::ReferenceEvaluator::evaluate(table, values, layout, expected, packed,
                                          {static_cast<Index>(first), static_cast<Index>(last)});
        for (Offset i = first * length; i < last * length; ++i) {
            const auto row = static_cast<Index>(i / length);
            const Offset component = i % length;
            const auto entries = static_cast<double>(table.columns(row).size());
            const double allowed = bound(entries) + referenceUlpBound<Real>(entries);
            const double ulp = double{std::numeric_limits<Real>::epsilon()} *
                               sizeOf(table, row, values, layout, component);
            // Numbers below the normal ones are rounded to multiples of the least.
            const double underflow =
                (entries + 1) * double{std::numeric_limits<Real>::denorm_min()};
            const double wanted = expected[static_cast<std::size_t>(i)];
            const double got = double{
                results[static_cast<std::size_t>(layout.offset + row * layout.stride + component)]};
            // Not as >, which NaN would pass.
            if (!(std::abs(got - wanted) <= allowed * ulp + underflow))
                throw Error(fmt::format(
                    "{}: coordinate {} of point {} is {:.17g}, but {:.17g} by the reference "
                    "evaluator: {:.3g} ulp of the sum of |weight * position| apart, where {:.3g} "
                    "are allowed",
                    who, component, row, got, wanted, std::abs(got - wanted) / ulp, allowed));
        }
    });
}

template void checkResults(const stencils::StencilTable<double>&, std::span<const double>,
                           std::span<const float>, const osd::BufferDescriptor&, UlpBound,
                           const std::string&);
template void checkResults(const stencils::StencilTable<double>&, std::span<const double>,
                           std::span<const double>, const osd::BufferDescriptor&, UlpBound,
                           const std::string&);

}  // namespace espalier::cli
