// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <espalier/base/api.h>
#include <espalier/far/topology_refiner.h>

#include <Eigen/Core>
#include <Eigen/SparseCore>
#include <complex>
#include <vector>

// Computes how refinement acts on a vertex's ring: its matrix, limit mask and eigenvalues.
namespace espalier::limit {

/// The ring of a vertex, and the matrix that takes it to the ring of the next level. The matrix is
/// the same on all levels, so its eigenvectors give the limit.
///
/// On the next level, the ring of a vertex v has a point for each entity that contains v, v itself
/// included: the new point of the entity. On that level, the entities around v are the children [v,
/// x], one for each entity x that contains v. Their new points are the ring of the level after it:
/// ring' = M ring. Their rules use only points of the ring. Where a feature is semi-sharp, the ring
/// starts at the level on which no sharpness is left.
///
/// At a vertex of the surface, M maps the points of the surface to points of the surface, and
/// likewise in each stratum.
///
/// \cite MacCracken & Joy 1996, section 2.2 (the rules); Halstead, Kass, DeRose 1993 (the limit as
///       the left eigenvector)
struct VertexRing {
    /// Entities that contain the vertex, by dimension and number: point i of the ring is the new
    /// point of entity i. The vertex itself is the first.
    std::vector<Entity> entities;

    /// M: row i holds the weights of point i of the next ring. Rows sum to 1.
    Eigen::SparseMatrix<double> subdivision;

    std::vector<Index> vertices;  ///< verticesAround() of the vertex

    /// Row i holds the weights of point i of the first ring over `vertices`.
    Eigen::SparseMatrix<double> start;

    int levels = 1;  ///< number of levels from the vertex's level to the first ring
};

/// Returns the vertices of all entities that contain a vertex, ascending.
ESPALIER_API std::vector<Index> verticesAround(const far::CellComplex& complex, Index vertex);

/// Builds the ring of a vertex.
/// \param level any level of a curve, a mesh or a lattice, with all entities that contain the
///        vertex
/// \param options options of the refiner that has this level
/// \param vertex a vertex of the level, not open
/// \throws Error under Rules::Rats, whose rules use points outside the ring; for a vertex that does
///         not exist; and for a vertex on the open boundary, which does not persist under
///         refinement
/// \cost O(entries of the ring's matrices)
ESPALIER_API VertexRing ringOf(const far::Level& level, const far::RefinerOptions& options,
                               Index vertex);

/// Returns the weights of the ring's points in the limit of the vertex: the left eigenvector ℓM = ℓ
/// of sum 1. It is the limit of the vertex's row in Mᵏ.
/// \throws Error if the rows do not converge
/// \cost O(entries of M), some hundred times
ESPALIER_API Eigen::VectorXd limitMask(const VertexRing& ring);

/// Largest ring for which eigenvalues() works, in points. Its time grows with the cube of the
/// number.
inline constexpr Index kMaxEigenvalues = 2000;

/// Returns the eigenvalues of M by descending modulus; the first is 1.
/// \throws Error if the ring has more than kMaxEigenvalues points
/// \cost O(n³) for a ring of n points
ESPALIER_API std::vector<std::complex<double>> eigenvalues(const VertexRing& ring);

}  // namespace espalier::limit
