// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <espalier/base/api.h>
#include <espalier/embed/local_binding.h>

#include <array>
#include <functional>
#include <span>
#include <utility>

// limit/: the volume that refining goes to.
//
// In: a lattice at rest and points, or places in cells. Out: D on the limit volume, with
// derivatives.
//
// Types: VertexRing, a vertex with its neighbours, whose subdivision matrix has the limit mask as
// its eigenvector; TricubicPatch, a regular cell; LimitSearch, which finds a point; LimitTable, D
// with its gradients.
//
// Read vertex_ring.h, vertex_limits.h, limit_stencils.h, then this header and limit_search.h.
//
// Notation: F = ∂x'/∂X is the deformation gradient by the rest pose X.
namespace espalier::limit {

/// How close to the limit is close enough, unless said otherwise.
inline constexpr double kLimitTolerance = 1e-6;

struct LimitOptions {
    embed::EmbeddingOptions embedding = {};

    /// The size of what is left around irregular features, where the limit is blended from exact
    /// ones: its corners are no further apart than this fraction of the size of the base, in any
    /// pose. 1e-14 to 1e-1.
    double tolerance = kLimitTolerance;

    /// Whether to make LimitTable::gradients. Points are then placed with a tolerance of 1e-12 at
    /// most, whatever `tolerance` is: at irregular features that takes more levels.
    bool gradients = false;

    /// Called now and then with the number of points done, from any thread; or empty.
    std::function<void(Offset)> progress = {};
};

/// D, and the gradient of the deformation.
///
/// With p' the base vertices of a pose, column j of the deformation gradient F = ∂x'/∂X at a point
/// is gradients[j] · p', where X is the rest pose: F is the identity at rest. Normals go with the
/// cofactor matrix of F, tangents with F. Rows of gradients sum to 0. They are empty where that of
/// the point is, or where the lattice at rest has no volume at the point.
///
/// For an affine pose F is its matrix to some 1e-12, at any tolerance. For any other pose F is
/// exact in regular cells of all levels, and at the features themselves, by the eigenvectors of
/// their rings. Where it changes faster than points are rounded, near irregular edges, it is good
/// to 1e-6.
struct LimitTable {
    stencils::StencilTable<double> points;  ///< D: points × base vertices
    std::array<stencils::StencilTable<double>, 3> gradients =
        {};  ///< the same shape; or 0 × 0 if not asked for

    friend bool operator==(const LimitTable&, const LimitTable&) = default;
};

/// Binds points to the limit volume itself, not to a level of it: to the volume that refining goes
/// to, in which no trilinear cell approximates anything.
///
/// A regular cell of any level is a tricubic polynomial there, in which a point is found by
/// Newton's method. Cells at irregular features are refined, no further than points ask for, until
/// they are regular, or smaller than the tolerance; in these, the exact limits of the cell's
/// vertices are blended as points of a level are. So D has rows of 64 entries in regular regions,
/// as that of a level has.
///
/// Statuses are those of the embedding. A point outside that is carried goes with the tangent of
/// the nearest place. A point in the gap between a patch and what is left at an irregular feature,
/// less wide than the tolerance, is inside.
///
/// \throws Error as bindPoints(); for a cell, a face or a vertex of more than 1,000 faces or edges,
///         around which the levels would take all memory; for a tolerance that is out of range; and
///         under Rules::Rats
/// \cost O(points · entries of D a point); near an irregular feature also its distance's logarithm,
///       some 0.2 ms a level. In parallel; the result does not depend on the number of threads
/// \cite MacCracken & Joy 1996, sections 2.2, 3 and 6 (whose trilinear cells this goes past)
ESPALIER_API embed::BindingResultOf<LimitTable> bindLimit(const embed::RestLattice& lattice,
                                                          std::span<const Point3> points,
                                                          const LimitOptions& options = {});

/// The same without gradients: the result of binding to a level, for all that takes such.
inline embed::BindingResult withoutGradients(embed::BindingResultOf<LimitTable> result) {
    auto& [table, kept, keptAt, topologyHash] = result.binding;
    return {{std::move(table.points), std::move(kept), std::move(keptAt), topologyHash},
            std::move(result.statuses),
            result.largestResidual};
}

}  // namespace espalier::limit
