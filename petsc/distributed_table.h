// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <espalier/base/api.h>
#include <espalier/base/index.h>
#include <espalier/stencils/stencil_table.h>

#include <petscmat.h>

#include <memory>
#include <span>
#include <type_traits>

// Applies the deformation matrix over the ranks of MPI, with PETSc.
namespace espalier::petsc {

/// The points, or the lattice vertices, of one rank: numbers first to last − 1. Ranks own
/// consecutive ranges, in order of rank.
struct OwnedRange {
    Offset first = 0;
    Offset last = 0;

    Offset count() const { return last - first; }
    friend bool operator==(const OwnedRange&, const OwnedRange&) = default;
};

/// Returns the range of `rank` in an even split, the same as PetscSplitOwnership: if the total is
/// not a multiple of the number of ranks, the first ranks get one more.
/// \throws Error unless total ≥ 0 and 0 ≤ rank < size
ESPALIER_API OwnedRange evenRange(Offset total, int rank, int size);

/// Applies the deformation matrix D of a model, and its transpose, over the ranks of an MPI
/// communicator. D is stored as PETSc's MATMPIAIJ (on one rank MATSEQAIJ), with MATMAIJ over it for
/// the components:
///
///     D           points × lattice vertices; each rank has the rows of its own points
///     blocked     (components · points) × (components · vertices): D for each component
///     evaluate    point values = D · vertex values
///     ...Adjoint  vertex gradients = Dᵀ · point gradients
///
/// Values are packed, `components` per entry, for example {x, y, z}. A rank passes the values of
/// its own points and vertices; no rank ever has all of them. Points are numbered across the ranks:
/// first the points of rank 0, then those of rank 1, and so on. Vertices are numbered in the same
/// way; their numbers are the columns of the rows.
///
/// The caller initialises MPI and PETSc, and finalises them after the table is destroyed.
/// Constructors, both evaluations and the destructor are collective: all ranks of the communicator
/// must call them in the same order. Assignment is collective too, since it destroys the previous
/// contents. A table that was moved from may only be assigned to or destroyed.
///
/// Before any rank continues, all ranks check their arguments and make their copies. An error on
/// one rank is thrown on all, with the number of the rank. The exception is a failure of PETSc
/// itself on some ranks only, for example out of memory: then the other ranks may wait forever. Not
/// thread-safe.
///
/// Messages: a ghost is a vertex of another rank that this rank's points depend on. evaluate()
/// receives ghostCount() · components doubles, in at most one message from each rank that owns
/// ghosts, and multiplies the rank's own vertices meanwhile. evaluateAdjoint() sends the same
/// amount back. Both also reduce one int over all ranks, for the checks. Memory of a rank: 12 bytes
/// per entry, 44 bytes per point (20 on one rank), and 52 per ghost; if PETSc's integers have 64
/// bits, 16 bytes per entry and 88 per point (40). docs/scaling.md derives these numbers.
///
/// \cite MacCracken & Joy 1996, section 5: x' = D · p'
class ESPALIER_API DistributedTable {
public:
    /// Distributes D.
    ///
    /// \param ownRows rows of this rank's points, over all vertices of the lattice: the table of
    ///        embed::bindPoints() for these points. It is copied
    /// \param ownVertexCount number of vertices of this rank; evenRange() splits them evenly. A
    ///        rank may have no vertices, or no points
    /// \param components numbers per entry, the same on all ranks
    /// \throws Error on all ranks if PETSc is not initialised; if the vertices of all ranks
    ///         together are not the columns of each rank's rows; for weights that are not finite,
    ///         naming rank and row; if PETSc's integers cannot count the entries of a rank or the
    ///         rows of `blocked`
    /// \cost O(entries). During construction ownRows exists too, and with 64-bit integers of PETSc
    ///       a copy of its columns: 24 bytes per entry, or 36
    DistributedTable(MPI_Comm comm, const stencils::StencilTable<double>& ownRows,
                     Offset ownVertexCount, int components = 3);

    int components() const { return components_; }
    OwnedRange ownPoints() const { return ownPoints_; }
    OwnedRange ownVertices() const { return ownVertices_; }
    Offset pointCount() const { return pointCount_; }    ///< number of points on all ranks
    Offset vertexCount() const { return vertexCount_; }  ///< number of vertices on all ranks

    /// Number of vertices of other ranks that this rank's points depend on.
    Offset ghostCount() const { return ghostCount_; }

    /// Computes the values of this rank's points.
    ///
    /// Results depend on the number of ranks through the order of summation: they differ from the
    /// exact sums by at most one ulp of Σ |w · x| for each entry. For the same ranks and rows they
    /// are identical bit for bit, in both directions: PETSc adds contributions in the order of the
    /// ranks, not in the order of arrival.
    ///
    /// With the displacements of the lattice as values and the points at rest as the addend, the
    /// result is x + D · (p' − p), as osd::evaluateBinding() computes it.
    ///
    /// \param ownVertexValues components() numbers for each of ownVertices()
    /// \param ownPointValues components() numbers for each of ownPoints(); must not overlap
    /// \param ownAddend is added to ownPointValues; has its size, or is empty and adds nothing
    /// \throws Error on all ranks if a span has the wrong size, naming the rank. Nothing is written
    /// \cost O(entries of the rank × components), and the messages above
    void evaluate(std::span<const double> ownVertexValues, std::span<double> ownPointValues,
                  std::span<const double> ownAddend = {});

    /// Computes the gradients of this rank's vertices, from gradients of the points; otherwise as
    /// evaluate().
    void evaluateAdjoint(std::span<const double> ownPointGradients,
                         std::span<double> ownVertexGradients);

    // The matrices, for use in PETSc's solvers, for example KSPLSQR. The table owns the matrices:
    // do not destroy or change them.
    Mat matrix() const { return matrix_.get(); }  ///< D
    /// D for each component; D itself for one component.
    Mat blocked() const { return blocked_.get(); }

private:
    struct Destroy {
        void operator()(Mat matrix) const;
        void operator()(Vec vector) const;
    };
    template <class Handle>
    using Owned = std::unique_ptr<std::remove_pointer_t<Handle>, Destroy>;

    int components_ = 0;
    OwnedRange ownPoints_, ownVertices_;
    Offset pointCount_ = 0, vertexCount_ = 0, ghostCount_ = 0;
    Owned<Mat> matrix_, blocked_;
    /// Vectors without memory of their own. During an evaluation they use the caller's arrays.
    Owned<Vec> points_, vertices_;
};

}  // namespace espalier::petsc
