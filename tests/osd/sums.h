// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <espalier/stencils/stencil_table.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>
#include <span>

namespace espalier::test {

/// Returns the largest error of packed results, over all rows and components, relative to table ·
/// source in long double, in units of ε · Σ |w · x|. Infinite if a row without terms gives anything
/// but 0.
template <class Real>
double errorOfSums(const stencils::StencilTable<Real>& table, std::span<const Real> source,
                   Offset length, std::span<const Real> result) {
    long double largest = 0;
    for (Index row = 0; row < table.rowCount(); ++row)
        for (Offset c = 0; c < length; ++c) {
            long double sum = 0, size = 0;
            for (std::size_t k = 0; k < table.columns(row).size(); ++k) {
                const long double product = static_cast<long double>(table.weights(row)[k]) *
                                            source[table.columns(row)[k] * length + c];
                sum += product;
                size += std::abs(product);
            }
            const long double error = std::abs(result[row * length + c] - sum);
            if (!(error <= 0))
                largest = std::max(largest, error / (std::numeric_limits<Real>::epsilon() * size));
        }
    return double(largest);
}

}  // namespace espalier::test
