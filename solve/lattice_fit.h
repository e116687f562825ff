// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <espalier/base/api.h>
#include <espalier/base/error.h>
#include <espalier/base/point.h>
#include <espalier/base/word.h>
#include <espalier/far/cell_complex.h>
#include <espalier/stencils/stencil_table.h>

#include <span>
#include <string>
#include <vector>

// solve/: from wishes to poses.
//
// In: D, and targets of points; or a pose. Out: displacements of the lattice; or volume ratios of
// its cells.
//
// Types: FitOptions and fitLattice() (this header), DesignVariables, ValidityCheck, whose proofs
// stand in bernstein.h.
//
// Read this header, design_variables.h, validity.h.
namespace espalier::solve {

/// What is asked of displacements besides that they reach the targets.
enum class Smoothing {
    None,
    Tikhonov,  ///< that they are small
    Laplacian  ///< that each is the mean of those of the vertices that it shares an edge with
};
inline constexpr Word<Smoothing> kSmoothingWords[] = {{"none", Smoothing::None},
                                                      {"tikhonov", Smoothing::Tikhonov},
                                                      {"laplacian", Smoothing::Laplacian}};

/// What is done where the targets leave some displacements open.
enum class Undetermined {
    Smallest,  ///< of all that fit as well, the smallest, by the sum of their squares
    Refuse
};
inline constexpr Word<Undetermined> kUndeterminedWords[] = {{"smallest", Undetermined::Smallest},
                                                            {"refuse", Undetermined::Refuse}};

struct FitOptions {
    Smoothing smoothing = Smoothing::None;

    /// How much smoothness weighs against the targets: 1 is about as much. From 1e-4, below which
    /// it would count as none, to 1e4, above which the targets would.
    double strength = 1e-3;

    std::vector<Index> frozen = {};  ///< vertices that stay where they are
    Undetermined undetermined = Undetermined::Smallest;
};

/// Displacements of a lattice, and how well they do.
struct LatticeFit {
    std::vector<Point3> displacements;  ///< one a vertex
    double largestMiss = 0;             ///< how far a point is from its target
    double meanMiss = 0;                ///< root of the mean of their squares

    /// Of the least-squares matrix, smoothing included: its largest singular value over its least.
    /// Infinity where that is less than 1e-5 of the largest, which counts as none: the
    /// displacements are then not determined.
    double condition = 1;
};

/// A target that cannot be fitted.
class ESPALIER_API TargetError : public Error {
public:
    TargetError(Index row, const std::string& what) : Error(what), row_(row) {}

    /// The row of the target's point in the matrix D.
    Index row() const { return row_; }

private:
    Index row_;
};

/// Finds the displacements d of the lattice vertices that carry points to where they are wanted
/// (direct manipulation), in the sense of least squares: of |D d − m|² + s² |R d|², the least, and
/// of all such d the smallest. R is nothing, the identity or the Laplacian of the edges; s is the
/// strength times the root of the mean of the diagonal of DᵀD, over the vertices that may move.
///
/// D is linear in the lattice, so to fit a lattice to a whole deformed model is the same, with all
/// points as targets.
///
/// \param deformation D: a row for each point that has a target (stencils::selectRows())
/// \param misses of each of these points: its target, less where it is at rest
/// \param base the lattice
/// \throws Error naming the offender: sizes that do not match, misses and weights that are not
///         finite, no points, a frozen vertex that is not there, all vertices frozen, a point whose
///         row is empty (it lies outside), a strength out of range, targets so far away that a
///         double does not hold the squares; and under Undetermined::Refuse displacements that are
///         left open, naming a vertex. TargetError for a miss that is not finite, and for targets
///         so far away, of which it names the farthest
/// \cost O(Σ entries² of the rows + a sparse Cholesky factor of the vertices)
/// \cite MacCracken & Joy 1996, section 5: x' = D · p'
ESPALIER_API LatticeFit fitLattice(const stencils::StencilTable<double>& deformation,
                                   std::span<const Point3> misses, const far::CellComplex& base,
                                   const FitOptions& options = {});

}  // namespace espalier::solve
