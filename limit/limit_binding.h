// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <espalier/base/api.h>
#include <espalier/embed/local_binding.h>

#include <array>
#include <functional>
#include <span>
#include <utility>

// limit/: computes the limit volume of a lattice, which its levels converge to.
//
// In: a lattice at rest, and points or places in cells. Out: D on the limit volume, with its
// derivatives.
//
// Types: a VertexRing holds a vertex with its neighbours; the left eigenvector of its subdivision
// matrix gives the limit of the vertex. An embed::TricubicPatch is the limit of a regular cell.
// LimitSearch finds points, on irregular edges by an EdgeRefinement.
//
// Read vertex_ring.h, vertex_limits.h, limit_stencils.h, then this header, limit_search.h and
// layered_edge.h.
//
// Notation: F = ∂x'/∂X is the deformation gradient; X is the rest pose, x' the deformed one.
namespace espalier::limit {

/// The default of LimitOptions::tolerance.
inline constexpr double kLimitTolerance = 1e-6;

struct LimitOptions {
    embed::EmbeddingOptions embedding = {};

    /// Largest size of a blended cell, as a fraction of the size of the base. Cells at irregular
    /// features are refined until their corners are at most this far apart in any pose; then the
    /// exact limits of their corners are blended. A point within this distance of the limit of an
    /// irregular edge gets a place on the edge. 1e-14 to 1e-1. Errors call it `limitTolerance`,
    /// since `embedding` has a tolerance as well.
    double tolerance = kLimitTolerance;

    /// Makes the gradients of D, by the derivatives of the limit. Points are then placed with a
    /// tolerance of at most 1e-12, whatever `tolerance` is, which takes more levels at irregular
    /// features. F is exact in regular cells of all levels, and exact at irregular features, where
    /// it comes from the eigenvectors of their rings. Near irregular edges F may change faster than
    /// the rounding of the points resolves; it is accurate to 1e-6 there.
    bool gradients = false;

    /// Called now and then with the number of points done, from any thread; or empty.
    std::function<void(Offset)> progress = {};
};

/// Binds points to the limit volume itself instead of a level, without an approximation by
/// trilinear cells.
///
/// In the regular cells of the base, points are bound as bindPoints() binds them, without
/// refinement. In a regular cell of any level the limit is a tricubic
/// polynomial, and Newton's method finds the place of a point. Cells at irregular features are
/// refined, only where there are points, until they are regular or smaller than the tolerance. In
/// the small ones the exact limits of the cell's vertices are blended in the way a level blends its
/// vertices. D has rows of 64 entries in regular regions, the same as the D of a level.
///
/// A point on an irregular edge needs no further levels if the cells around the edge continue
/// beyond both of its ends: its weights follow from repeated halving of the edge. A point within
/// the tolerance of the limit of the edge follows the tangent there. The gradient at the point
/// differs from the gradient on the edge by a power of their distance; so the error is smaller than
/// the distance, times the change of the gradient.
///
/// Statuses have the meaning that they have for a level. A point outside that is carried follows
/// the tangent at the nearest place. A point in the gap between a patch and a blended cell counts
/// as inside; the gap is narrower than the tolerance.
///
/// \throws Error under OutsidePolicy::Error if a point is not inside (names the first one); if the
///         base is not a lattice or has been refined, or the positions do not fit it or are not
///         finite; for a cell, a face or a vertex of more than 1,000 faces or edges, around which
///         the levels would take all memory; and under Rules::Rats; ArgumentError for a tolerance
///         that is out of range; TopologyError if a level has too many entities or, under
///         Boundary::Open, no cells; MemoryError if D exceeds a MemoryLimit
/// \cost O(points · entries of D per point); on an irregular edge 20 µs per point, and beside it or
///       near an irregular vertex times the logarithm of the distance to it, about 0.8 ms per
///       level. In parallel; the result does not depend on the number of threads. A few points at a
///       time are taken to fine levels, with 15 MB for each
/// \cite MacCracken & Joy 1996, sections 2.2, 3 and 6 (the limit replaces their trilinear cells)
ESPALIER_API embed::BoundRows<> bindLimit(const embed::RestLattice& lattice,
                                          std::span<const Point3> points,
                                          const LimitOptions& options = {});

/// Binds points to the limit, as bindLimit() does, but makes no D: gives the rows of each group of
/// points to `sink` (embed::bindInGroups()).
/// \throws Error, ArgumentError, TopologyError as bindLimit()
ESPALIER_API void bindLimitInGroups(const embed::RestLattice& lattice,
                                    std::span<const Point3> points, const LimitOptions& options,
                                    embed::RowSink sink);

}  // namespace espalier::limit
