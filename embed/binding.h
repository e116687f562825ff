// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <espalier/base/api.h>
#include <espalier/embed/embedding.h>
#include <espalier/embed/tensor_product.h>

#include <cstdint>

namespace espalier::embed {

/// A model frozen to a lattice: all that is needed to deform it, without the lattice or its
/// topology. Table is StencilTable<Real>, or FactoredTable<Real>.
///
/// With p' the base vertices of a pose, the deformed points are x' = D · p', except for the points
/// whose rows are empty, which are kept where they were.
///
/// \cite MacCracken & Joy 1996, section 5
template <class Real, class Table = stencils::StencilTable<Real>>
struct Binding {
    Table table;                     ///< D: points × base vertices
    std::vector<Index> kept;         ///< the points with empty rows, ascending
    std::vector<Point3> keptAt;      ///< where those were, and stay
    std::uint64_t topologyHash = 0;  ///< far::topologyHash of the base lattice

    friend bool operator==(const Binding&, const Binding&) = default;
};

/// Collects D and what it keeps.
/// \param points as they were embedded
/// \throws Error if their number is not that of the embedding, or that is in another level
template <class Real>
ESPALIER_API Binding<Real> makeBinding(const far::TopologyRefiner& refiner, int level,
                                       stencils::Rules rules, const Embedding& embedding,
                                       std::span<const Point3> points);

/// The same for a box lattice with Bézier or B-spline weights.
template <class Real>
ESPALIER_API Binding<Real> makeBinding(const TensorLattice& lattice,
                                       const TensorEmbedding& embedding,
                                       std::span<const Point3> points);

}  // namespace espalier::embed
