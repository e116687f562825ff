// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <espalier/base/api.h>
#include <espalier/embed/embedding.h>

#include <cstdint>
#include <utility>

namespace espalier::embed {

/// Holds all that is needed to deform a model: neither the lattice nor its topology is needed any
/// more. Table is StencilTable<Real>, FactoredTable<Real>, or limit::LimitTable.
///
/// With p' the base vertices of a pose, the deformed points are x' = D · p'. Points whose rows are
/// empty stay where they were.
///
/// \cite MacCracken & Joy 1996, section 5
template <class Table>
struct BindingOf {
    Table table;                     ///< D: points × base vertices
    std::vector<Index> kept;         ///< the points with empty rows, ascending
    std::vector<Point3> keptAt;      ///< positions of these points
    std::uint64_t topologyHash = 0;  ///< far::topologyHash of the base lattice

    friend bool operator==(const BindingOf&, const BindingOf&) = default;
};

using TableBinding = BindingOf<stencils::StencilTable<double>>;

/// Returns the binding with weights rounded to another precision. Bindings are made in double
/// precision.
template <class To, class Table>
auto convertBinding(BindingOf<Table> binding) {
    auto table = stencils::convertTable<To>(std::move(binding.table));
    return BindingOf<decltype(table)>{std::move(table), std::move(binding.kept),
                                      std::move(binding.keptAt), binding.topologyHash};
}

}  // namespace espalier::embed
