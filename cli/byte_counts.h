// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <espalier/stencils/factored_table.h>

#include <cstddef>

namespace espalier::cli {

/// A table's offsets, columns and weights.
template <class Real>
std::size_t bytesOf(const stencils::StencilTable<Real>& table) {
    return table.offsets().size_bytes() + table.columns().size_bytes() +
           table.weights().size_bytes();
}

/// Both tables'.
template <class Real>
std::size_t bytesOf(const stencils::FactoredTable<Real>& table) {
    return bytesOf(table.vertices) + bytesOf(table.points);
}

}  // namespace espalier::cli
