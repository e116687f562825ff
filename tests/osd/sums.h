// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <espalier/stencils/stencil_table.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>
#include <span>
#include <vector>

namespace espalier::test {

/// Returns the largest error of packed results, over all rows and components, relative to table ·
/// source in long double, in units of ε · Σ |w · x|. Infinite if a row without terms gives anything
/// but 0.
template <class Real>
double errorOfSums(const stencils::StencilTable<Real>& table, std::span<const Real> source,
                   Offset length, std::span<const Real> result) {
    // Pointers and plain loops: tests are compiled without optimisation.
    long double largest = 0;
    std::vector<long double> sums(length), sizes(length);
    for (Index row = 0; row < table.rowCount(); ++row) {
        std::fill(sums.begin(), sums.end(), 0);
        std::fill(sizes.begin(), sizes.end(), 0);
        long double *const sum = sums.data(), *const size = sizes.data();
        const auto columns = table.columns(row);
        const Real* weight = table.weights(row).data();
        for (const Index column : columns) {
            const long double factor = *weight++;
            const Real* const values = source.data() + column * length;
            for (Offset c = 0; c < length; ++c) {
                const long double product = factor * values[c];
                sum[c] += product;
                size[c] += product < 0 ? -product : product;
            }
        }
        for (Offset c = 0; c < length; ++c) {
            const long double error = std::abs(result[row * length + c] - sum[c]);
            if (!(error <= 0))
                largest =
                    std::max(largest, error / (std::numeric_limits<Real>::epsilon() * size[c]));
        }
    }
    return double(largest);
}

}  // namespace espalier::test
