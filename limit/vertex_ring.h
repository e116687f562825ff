// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <espalier/base/api.h>
#include <espalier/far/topology_refiner.h>

#include <Eigen/Core>
#include <Eigen/SparseCore>
#include <complex>
#include <vector>

namespace espalier::limit {

/// What is left around a vertex, level after level: its one-ring, which the same matrix takes to
/// that of the next level for ever.
///
/// The ring one level on has a vertex for each entity that contains the vertex v, v itself among
/// them: their new points. One more level on, the entities around v are the children [v, x] of
/// these, one for one, and so are their new points: ring' = M ring. The rules of those see nothing
/// but the ring. Where a feature is semi-sharp, it is so from the level on where that has run out.
///
/// At a vertex of the surface M takes the points of the surface among themselves, and likewise in
/// each stratum.
///
/// \cite MacCracken & Joy 1996, section 2.2 (the rules); Halstead, Kass, DeRose 1993 (the limit as
///       the left eigenvector)
struct VertexRing {
    /// What contains the vertex, by dimension and number: point i of the ring is the new point of
    /// entity i. The vertex itself is the first.
    std::vector<Entity> entities;

    /// M: row i holds the weights of point i of the next ring. Rows sum to 1.
    Eigen::SparseMatrix<double> subdivision;

    std::vector<Index> vertices;  ///< verticesAround() the vertex

    /// Row i holds the weights of point i of the first ring over `vertices`.
    Eigen::SparseMatrix<double> start;

    int levels = 1;  ///< how far on the first ring is
};

/// The vertices of all that contains a vertex, ascending.
ESPALIER_API std::vector<Index> verticesAround(const far::CellComplex& complex, Index vertex);

/// \param level any, of a curve, a mesh or a lattice; all that contains the vertex must be there
/// \param options of the refiner that it is a level of
/// \param vertex of it, not open
/// \throws Error under Rules::Rats, whose rules look further than the ring; for a vertex that is
///         not there; and for one on the open boundary, which does not stay
/// \cost O(entries of the ring's matrices)
ESPALIER_API VertexRing ringOf(const far::Level& level, const far::RefinerOptions& options,
                               Index vertex);

/// The weights of the ring in the limit of the vertex: ℓ with ℓM = ℓ, of sum 1, which the row of
/// the vertex in Mᵏ goes to.
/// \throws Error if it goes to nothing: the rules do not converge there
/// \cost O(entries of M), some hundred times
ESPALIER_API Eigen::VectorXd limitMask(const VertexRing& ring);

/// Rings of more points are refused by eigenvalues(), whose time grows with their cube.
inline constexpr Index kMaxEigenvalues = 2000;

/// The eigenvalues of M by descending modulus; the first is 1.
/// \throws Error if the ring has more than kMaxEigenvalues points
/// \cost O(n³) in the points of the ring
ESPALIER_API std::vector<std::complex<double>> eigenvalues(const VertexRing& ring);

}  // namespace espalier::limit
