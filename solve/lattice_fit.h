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

// solve/: computes lattices from goals.
//
// In: D and targets of points, or a pose. Out: displacements of the lattice, or volume ratios of
// its cells.
//
// Types: FitOptions and fitLattice() (this header), RigidPull, DesignVariables, SectionVariables,
// ReferenceAxis, Measures (constraints.h), ValidityCheck. bernstein.h has the proofs for
// ValidityCheck.
//
// Read this header, rigid_pull.h, design_variables.h, section_variables.h, reference_axis.h,
// constraints.h, validity.h.
namespace espalier::solve {

/// The regularisation of a fit: a second goal for the displacements, besides the targets.
enum class Smoothing {
    None,
    Tikhonov,  ///< displacements are small
    Laplacian  ///< each displacement is close to the mean of its neighbours' along edges
};
inline constexpr Word<Smoothing> kSmoothingWords[] = {{"none", Smoothing::None},
                                                      {"tikhonov", Smoothing::Tikhonov},
                                                      {"laplacian", Smoothing::Laplacian}};

/// The behaviour if the targets do not determine all displacements.
enum class Undetermined {
    Smallest,  ///< take the solution with the smallest sum of squares
    Refuse     ///< throw
};
inline constexpr Word<Undetermined> kUndeterminedWords[] = {{"smallest", Undetermined::Smallest},
                                                            {"refuse", Undetermined::Refuse}};

struct FitOptions {
    Smoothing smoothing = Smoothing::None;

    /// Weight of the smoothness; at 1 it counts about as much as the targets. Range 1e-4 to 1e4:
    /// below, smoothness would have no effect; above, the targets would have none.
    double strength = 1e-3;

    std::vector<Index> frozen = {};  ///< vertices that stay where they are
    Undetermined undetermined = Undetermined::Smallest;
};

/// Displacements of a lattice, and how well they fit.
struct LatticeFit {
    std::vector<Point3> displacements;  ///< one for each vertex
    double largestMiss = 0;             ///< largest distance of a point from its target
    double rmsMiss = 0;                 ///< root mean square of the distances

    /// Condition of the least-squares matrix, smoothing included: its largest singular value over
    /// its smallest. Infinity if the smallest is below 1e-5 of the largest, which counts as 0: the
    /// targets then do not determine the displacements.
    double condition = 1;
};

/// Thrown for a target that cannot be fitted.
class ESPALIER_API TargetError : public Error {
public:
    TargetError(Index row, const std::string& what) : Error(what), row_(row) {}

    /// Row of the target's point in the matrix D.
    Index row() const { return row_; }

private:
    Index row_;
};

/// Finds the displacements d of the lattice vertices that carry points to their targets (direct
/// manipulation). Minimises |D d − m|² + s² |R d|² and, among the minimisers, returns the smallest
/// d. R is 0, the identity or the Laplacian of the edges; s is the strength times the root of the
/// mean of the diagonal of DᵀD, over the vertices that may move.
///
/// D is linear in the lattice. To fit a lattice to a whole deformed model, pass all points as
/// targets.
///
/// \param deformation D: a row for each point that has a target (stencils::selectRows())
/// \param misses m: for each of these points its target minus its position at rest
/// \param base the lattice
/// \throws ArgumentError for a strength out of range and a frozen vertex that does not exist; Error
///         naming the offender: sizes that do not match, no points, weights that are not finite,
///         all vertices frozen, a point whose row is empty (it is outside); and under
///         Undetermined::Refuse undetermined displacements, naming a vertex. TargetError for a miss
///         that is not finite, and for targets so far away that a double cannot hold the squares of
///         the misses, naming the farthest
/// \cost O(Σ entries² of the rows + a sparse Cholesky factor of the vertices)
/// \cite MacCracken & Joy 1996, section 5: x' = D · p'
ESPALIER_API LatticeFit fitLattice(const stencils::StencilTable<double>& deformation,
                                   std::span<const Point3> misses, const far::CellComplex& base,
                                   const FitOptions& options = {});

}  // namespace espalier::solve
