// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <espalier/base/api.h>
#include <espalier/base/index.h>
#include <espalier/base/point.h>
#include <espalier/embed/binding.h>

#include <petscmat.h>

#include <memory>
#include <span>
#include <type_traits>
#include <vector>

namespace espalier::petsc {

/// The points, or the lattice vertices, of one rank: first to last − 1 of all. Those of rank 0 come
/// first, then those of rank 1.
struct OwnedRange {
    Offset first = 0;
    Offset last = 0;

    Offset count() const { return last - first; }
    friend bool operator==(const OwnedRange&, const OwnedRange&) = default;
};

/// The part of `rank` of an even split, as PetscSplitOwnership makes it: the first ranks have one
/// more where it does not come out even.
/// \throws Error unless total ≥ 0 and 0 ≤ rank < size
ESPALIER_API OwnedRange evenRange(Offset total, int rank, int size);

/// The deformation matrix D of a model that is spread over the ranks of an MPI communicator, as
/// PETSc's MATMPIAIJ (on one rank MATSEQAIJ), with MATMAIJ over it for the components:
///
///     D           points × lattice vertices; each rank has the rows of its own points
///     blocked     (components · points) × (components · vertices): D for each component
///     evaluate    point values = D · vertex values
///     ...Adjoint  vertex gradients = Dᵀ · point gradients
///
/// Values are packed, `components` an entry, as {x, y, z}; a rank passes those of its own points
/// and of its own vertices, and no rank ever has all of them. Points are numbered through the
/// ranks: first those of rank 0. So are the vertices; their numbers are the columns of the rows.
///
/// MPI and PETSc are the caller's to initialise, and to finalise when the table is gone. The
/// constructors, both evaluations and the destructor are collective: all ranks of the communicator
/// must call them, in the same order. So is assignment, which destroys what the table had. A table
/// that was moved from may only be assigned to or destroyed.
///
/// On each rank arguments are checked, and copies made, before any goes on; what fails on one is
/// thrown on all, with its rank. Only where PETSc itself fails on some ranks, out of memory say,
/// may the others wait for ever. Not for several threads at a time.
///
/// Messages: evaluate() receives ghostCount() · components doubles, at most one message from each
/// rank that owns some of these vertices, while the rank's own vertices are already multiplied;
/// evaluateAdjoint() sends as many back. Each also reduces one int over all ranks, for the checks.
/// Memory of a rank: 12 bytes an entry, 44 bytes a point (on one rank 20), and 52 a ghost; where
/// PETSc's integers have 64 bits, 16 bytes an entry and 88 a point (40). docs/scaling.md has the
/// sums.
///
/// \cite MacCracken & Joy 1996, section 5: x' = D · p'
class ESPALIER_API DistributedTable {
public:
    /// \param ownRows the rows of this rank's points, over all vertices of the lattice: the table
    ///        of embed::bindPoints() for these points. It is copied, so that it may go
    /// \param ownVertexCount how many of the vertices are this rank's; evenRange() splits them.
    ///        A rank may have no vertices, or no points
    /// \param components numbers an entry, the same on all ranks
    /// \throws Error on all ranks if PETSc is not initialised; if the vertices of all ranks are not
    ///         the columns of each; for weights that are not finite, naming rank and row; if
    ///         PETSc's integers do not hold the entries of a rank or the rows of `blocked`
    /// \cost O(entries). Meanwhile ownRows is there too, and with PETSc's integers of 64 bits a
    ///       copy of its columns: 24 bytes an entry, or 36
    DistributedTable(MPI_Comm comm, const stencils::StencilTable<double>& ownRows,
                     Offset ownVertexCount, int components = 3);

    /// The same for positions of points of which some are kept in place: evaluate() puts these
    /// where they stay, as osd::evaluateBinding() does; in the adjoint their gradients count for
    /// nothing. (With the constructor above, rows that are empty give 0.)
    ///
    /// \throws Error also for kept points that are not the rank's
    DistributedTable(MPI_Comm comm, const embed::Binding& own, Offset ownVertexCount);

    int components() const { return components_; }
    OwnedRange ownPoints() const { return ownPoints_; }
    OwnedRange ownVertices() const { return ownVertices_; }
    Offset pointCount() const { return pointCount_; }    ///< of all ranks
    Offset vertexCount() const { return vertexCount_; }  ///< of all ranks

    /// Vertices of other ranks that the points of this one depend on.
    Offset ghostCount() const { return ghostCount_; }

    /// Results differ with the number of ranks, by the order of the sums: they are off the exact
    /// ones by at most one ulp of Σ |w · x| for each entry. For the same ranks and rows they are
    /// the same bit for bit, in both directions: PETSc adds what other ranks send in the order of
    /// these, not in that of arrival.
    ///
    /// \param ownVertexValues components() for each of ownVertices()
    /// \param ownPointValues components() for each of ownPoints(); must not overlap
    /// \throws Error on all ranks if a span has another size, naming the rank. Nothing is written
    /// \cost O(entries of the rank × components), and the messages above
    void evaluate(std::span<const double> ownVertexValues, std::span<double> ownPointValues);

    /// As evaluate(), from gradients by the points to gradients by the vertices.
    void evaluateAdjoint(std::span<const double> ownPointGradients,
                         std::span<double> ownVertexGradients);

    // For PETSc's solvers, KSPLSQR say. They stay the table's: neither to be destroyed nor changed.
    Mat matrix() const { return matrix_.get(); }    ///< D
    Mat blocked() const { return blocked_.get(); }  ///< D for each component; D where there is one

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
    Owned<Vec> points_, vertices_;  ///< of no memory of their own: the caller's arrays are put in
    std::vector<Index> kept_;
    std::vector<Point3> keptAt_;
};

}  // namespace espalier::petsc
