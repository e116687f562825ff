// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <espalier/base/api.h>
#include <espalier/embed/embedding.h>
#include <espalier/embed/tensor_product.h>

#include <cstdint>
#include <utility>

namespace espalier::embed {

/// A model frozen to a lattice: all that is needed to deform it, without the lattice or its
/// topology. Table is StencilTable<Real>, FactoredTable<Real>, or limit::LimitTable.
///
/// With p' the base vertices of a pose, the deformed points are x' = D · p', except for the points
/// whose rows are empty, which are kept where they were.
///
/// \cite MacCracken & Joy 1996, section 5
template <class Table>
struct BindingOf {
    Table table;                     ///< D: points × base vertices
    std::vector<Index> kept;         ///< the points with empty rows, ascending
    std::vector<Point3> keptAt;      ///< where those were, and stay
    std::uint64_t topologyHash = 0;  ///< far::topologyHash of the base lattice

    friend bool operator==(const BindingOf&, const BindingOf&) = default;
};

using Binding = BindingOf<stencils::StencilTable<double>>;

/// The same binding with weights rounded to another precision: bindings are made in double.
template <class To, class Table>
auto convertBinding(BindingOf<Table> binding) {
    auto table = stencils::convertTable<To>(std::move(binding.table));
    return BindingOf<decltype(table)>{std::move(table), std::move(binding.kept),
                                      std::move(binding.keptAt), binding.topologyHash};
}

/// Collects D and what it keeps for a box lattice with Bézier or B-spline weights. (To a level of
/// a lattice points are bound by bindPoints().)
/// \param points as they were embedded
/// \throws Error if their number is not that of the embedding, or that is in another lattice
ESPALIER_API Binding makeBinding(const TensorLattice& lattice, const TensorEmbedding& embedding,
                                 std::span<const Point3> points);

}  // namespace espalier::embed
