// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <espalier/base/api.h>
#include <espalier/base/index.h>
#include <espalier/base/point.h>
#include <espalier/far/cell_complex.h>
#include <espalier/solve/lattice_fit.h>
#include <espalier/stencils/stencil_table.h>

#include <memory>
#include <span>
#include <vector>

namespace espalier::solve {

/// Options of RigidPull.
struct RigidPullOptions {
    /// Vertices that stay where they are.
    std::vector<Index> frozen = {};

    /// Rows of the matrix D that are pins: their points are to stay. They have misses as the pulls
    /// have, usually 0, but do not count for `reach`.
    std::vector<Index> pins = {};

    /// Vertices that are farther from all pulls than this part of the distance of the farthest
    /// vertex stay, too: 0.5 keeps the farther half, so that a pulled hand bends its arm and does
    /// not carry the body along. Distances are along the cells (shapes/cell_selection.h). Range 0
    /// to 1; at 1 all vertices move that are not frozen.
    double reach = 0.5;

    /// The iteration ends when no vertex moves by more than this part of the diagonal of the box
    /// around the lattice, 0 or more; or after this number of iterations, 1 or more. At the
    /// barrier, the quasi-Newton method adds at most as many again.
    double tolerance = 1e-6;
    int maxIterations = 500;

    /// Keep cells from folding: see RigidPull.
    bool preventsFolds = true;
};

/// A pose of a lattice whose cells stay as rigid as they can.
struct RigidPose {
    std::vector<Point3> displacements;  ///< one for each vertex
    double largestMiss = 0;             ///< largest distance of a point from its target
    double rmsMiss = 0;                 ///< root mean square of the distances
    double energy = 0;                  ///< E without the barrier: see RigidPull
    int iterations = 0;
    bool meetsBarrier = false;  ///< cells would fold, or nearly, without the barrier
};

/// Pulls points of a model, while the cells of the lattice stay as rigid as they can: a pulled hand
/// bends its arm. fitLattice() moves single vertices instead, as little as possible.
///
/// For displaced vertices x = p + d, minimises
///
///     E = Σ_c w_c Σ_v |x_v − x̄_c − R_c (p_v − p̄_c)|² + s² Σ_k |D_k d − m_k|²
///
/// over d and one rotation R_c for each cell c. The sum over v is over the vertices of the cell; a
/// bar is their mean. The weight w_c is the root mean square of |p_v − p̄_c|, so that E does not
/// depend on the number of vertices of a cell. s² is 1e8 of the mean of the diagonal of the first
/// sum, so that points reach their targets up to about 1e-8 of the way. The first sum over all
/// pairs of vertices of a cell is the energy of Chao et al. with the weights w_c / (number of
/// vertices).
///
/// Two steps alternate: the best rotations for given vertices, then the best vertices for given
/// rotations, whose matrix is factored once. Neither can increase E. The iteration begins at the
/// rigid motion of all pulls, pins and frozen vertices, if there is one; else at the rigid motion
/// that fits best, if no vertex stays; else at rest. The result is a local minimum.
///
/// If cells of that pose fold, or nearly fold, E gets a barrier, which grows without bound as a
/// refined cell folds (solve/fold_barrier.h), and s² is 1e3 of the mean of the diagonal: so cells
/// stay valid, and points that cannot reach their targets stay away from them by `largestMiss`. A
/// quasi-Newton method with the same factors begins at a valid pose, and each of its steps leads to
/// a pose that is valid at the places where the barrier looks. Between these places a cell may
/// still fold, if a pull is longer than the limb that it pushes together; solve::ValidityCheck
/// finds these cells. The barrier assumes the default options of refinement. Lattices of which
/// cells are bad at rest have it in their other cells.
///
/// Immutable; any number of threads may use one at once. Results do not depend on the number of
/// threads.
///
/// \cite Liu, Bouaziz & Kavan 2017, Quasi-Newton methods for real-time simulation of hyperelastic
///       materials
/// \cite Sorkine & Alexa 2007, As-rigid-as-possible surface modeling, sections 2 and 3
/// \cite Chao, Pinkall, Sanan & Schröder 2010, A simple geometric model for elastic deformations
class ESPALIER_API RigidPull {
public:
    /// Factors the matrix of the vertices.
    /// \param base the lattice
    /// \param rest positions of its vertices
    /// \param deformation D: a row for each point that is pulled or pinned (stencils::selectRows())
    /// \throws ArgumentError for an option out of range, a frozen vertex or a pin that does not
    ///         exist; Error naming the offender: no lattice, positions that do not fit it, are not
    ///         finite or more than 1e90 apart, sizes that do not match, a weight that is not
    ///         finite, a point whose row is empty (it is outside), a pulled point that only
    ///         vertices move that stay
    /// \cost a sparse Cholesky factor of the vertices, and a solution with it for each point; for
    ///       the barrier, refinement to level 2, and of an eighth of the cells to level 3
    RigidPull(const far::CellComplex& base, std::span<const Point3> rest,
              const stencils::StencilTable<double>& deformation,
              const RigidPullOptions& options = {});

    /// The vertices that stay: frozen ones, and those beyond the reach; ascending.
    const std::vector<Index>& fixedVertices() const;

    /// Finds the pose for some targets. If all misses are 0, and no start is given, the
    /// displacements are 0.
    /// \param misses for each row of D, its target minus its position at rest
    /// \param start displacements where the iteration begins, such as the last frame of a drag; one
    ///        per vertex, finite. Empty: see above
    /// \throws Error for sizes that do not match; TargetError for a miss that is not finite or
    ///         larger than 1e90
    /// \cost for each iteration O(Σ vertices of the cells + entries of the factor); 0.2 ms for a
    ///       lattice of 500 vertices. At the barrier, each of the additional iterations takes
    ///       1.5 ms: with 10 iterations, a frame of a drag takes 16 ms
    RigidPose solve(std::span<const Point3> misses, std::span<const Point3> start = {}) const;

private:
    struct Data;
    std::shared_ptr<const Data> data_;
};

}  // namespace espalier::solve
