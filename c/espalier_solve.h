// SPDX-License-Identifier: Apache-2.0
#ifndef ESPALIER_SOLVE_H
#define ESPALIER_SOLVE_H

#include "espalier.h"

/// \file
/// Solves for lattices, from C (solve/): finds displacements that carry points to targets, vertices
/// to freeze so that a part stays, and poses that turn no cell inside out.
///
/// The rules of espalier.h on errors, ownership and threads apply.

#ifdef __cplusplus
extern "C" {
#endif

// ---- Fitting --------------------------------------------------------------------------------

/// Regularization: what displacements should satisfy besides reaching the targets
/// (solve/lattice_fit.h).
enum {
    ESPALIER_SMOOTHING_NONE = 0,
    ESPALIER_SMOOTHING_TIKHONOV = 1,  ///< small displacements
    ESPALIER_SMOOTHING_LAPLACIAN = 2  ///< displacements close to the mean of their neighbours
};

/// How displacements that the targets do not determine are treated.
enum {
    ESPALIER_UNDETERMINED_SMALLEST = 0,  ///< uses the smallest displacements that fit equally well
    ESPALIER_UNDETERMINED_REFUSE = 1
};

/// Options of a fit. Start from espalier_default_fit_options(), and change fields.
typedef struct espalier_fit_options {
    size_t size;           ///< sizeof(espalier_fit_options)
    int32_t smoothing;     ///< ESPALIER_SMOOTHING_...; default NONE
    int32_t undetermined;  ///< ESPALIER_UNDETERMINED_...; default SMALLEST
    double strength;  ///< weight of smoothing relative to the targets, 1e-4 to 1e4; default 1e-3
    int64_t frozen_count;   ///< default 0
    const int32_t* frozen;  ///< vertices that do not move: frozen_count numbers
    int64_t move_held;      ///< nonzero: vertices that the lattice holds may move, too; default 0
} espalier_fit_options;

static inline espalier_fit_options espalier_default_fit_options(void) {
    espalier_fit_options options;
    options.size = sizeof options;
    options.smoothing = ESPALIER_SMOOTHING_NONE;
    options.undetermined = ESPALIER_UNDETERMINED_SMALLEST;
    options.strength = 1e-3;
    options.frozen_count = 0;
    options.frozen = NULL;
    options.move_held = 0;
    return options;
}

/// How well displacements reach the targets.
typedef struct espalier_fit_quality {
    double largest_miss;  ///< largest distance of a point from its target
    double rms_miss;      ///< root mean square of these distances
    double condition;  ///< condition number of the least-squares matrix; infinite if the targets do
                       ///< not determine all displacements
} espalier_fit_quality;

/// Finds the displacements of the vertices of a lattice that carry points to targets, in the
/// least-squares sense.
///
/// \param deformation D: points × vertices of the lattice
/// \param lattice its edges define the neighbours for smoothing
/// \param target_count number of points that have targets
/// \param rows the rows of D of these points; null for all rows, in order
/// \param misses for each of these points, its target minus its rest position: 3 · target_count
///        numbers
/// \param options null for the defaults
/// \param vertex_count number of vertices of the lattice
/// \param displacements receives 3 · vertex_count numbers
/// \param quality may be null
/// \retval ESPALIER_ERROR_INPUT there are no targets; a row does not exist or is empty; misses are
///         not finite; options are out of range; a frozen vertex does not exist; under
///         ESPALIER_UNDETERMINED_REFUSE, the targets do not determine all displacements
/// \cost O(Σ entries² of the rows + a sparse Cholesky factorization over the vertices)
ESPALIER_C_API espalier_status espalier_lattice_fit(
    const espalier_table* deformation, const espalier_lattice* lattice, int32_t target_count,
    const int32_t* rows, const double* misses, const espalier_fit_options* options,
    int32_t vertex_count, double* displacements, espalier_fit_quality* quality);

// ---- Pulling --------------------------------------------------------------------------------

/// Options of a pull. Start from espalier_default_pull_options(), and change fields.
typedef struct espalier_pull_options {
    size_t size;            ///< sizeof(espalier_pull_options)
    int64_t frozen_count;   ///< default 0
    const int32_t* frozen;  ///< vertices that do not move: frozen_count numbers
    int64_t pin_count;      ///< default 0
    const int32_t* pins;  ///< the points that are to stay: pin_count numbers, 0 to point_count − 1
    double
        reach;  ///< vertices that are farther from all pulled points, without the pins, than this
                ///< part of the distance of the farthest one do not move: 0 to 1; default 0.5
    double tolerance;        ///< the iteration ends when no vertex moves by more than this part of
                             ///< the diagonal of the lattice: 0 or more; default 1e-6
    int32_t max_iterations;  ///< 1 or more; default 500. For one frame of a drag 20 are enough
    int64_t move_held;       ///< nonzero: vertices that the lattice holds may move, too; default 0
} espalier_pull_options;

static inline espalier_pull_options espalier_default_pull_options(void) {
    espalier_pull_options options;
    options.size = sizeof options;
    options.frozen_count = 0;
    options.frozen = NULL;
    options.pin_count = 0;
    options.pins = NULL;
    options.reach = 0.5;
    options.tolerance = 1e-6;
    options.max_iterations = 500;
    options.move_held = 0;
    return options;
}

/// Pulls points of a model while the cells of the lattice stay as rigid as they can: a pulled hand
/// bends its arm (solve/rigid_pull.h). Immutable.
typedef struct espalier_pull espalier_pull;

/// Prepares pulls of some points: factors the matrix of the vertices, for any number of targets.
///
/// \param positions rest positions of the vertices of the lattice, 3 · vertex_count numbers
/// \param deformation D: points × vertices of the lattice
/// \param point_count number of points that are pulled or pinned
/// \param rows the rows of D of these points; null for all rows, in order
/// \param options null for the defaults
/// \retval ESPALIER_ERROR_INPUT a row does not exist or is empty; sizes do not match; positions
///         or weights are not finite; options are out of range; a frozen vertex or a pin does not
///         exist; only frozen vertices move a pulled point
/// \cost a sparse Cholesky factorization over the vertices, and a solution with it for each point
ESPALIER_C_API espalier_status espalier_pull_create(const espalier_lattice* lattice,
                                                    int32_t vertex_count, const double* positions,
                                                    const espalier_table* deformation,
                                                    int32_t point_count, const int32_t* rows,
                                                    const espalier_pull_options* options,
                                                    espalier_pull** pull);
ESPALIER_C_API void espalier_pull_destroy(espalier_pull* pull);

/// Gives the vertices that do not move: frozen ones, and those beyond the reach; ascending.
ESPALIER_C_API espalier_status espalier_pull_fixed(const espalier_pull* pull, int32_t* vertex_count,
                                                   const int32_t** vertices);

/// How well a pull reaches its targets.
typedef struct espalier_pull_quality {
    double largest_miss;  ///< largest distance of a point from its target
    double rms_miss;      ///< root mean square of these distances
    double energy;        ///< 0 for a rigid motion; see solve/rigid_pull.h
    int32_t iterations;
    int32_t meets_barrier;  ///< 1 if cells would fold, or nearly, without the barrier that keeps
                            ///< them open: points may then stay away from their targets; else 0
} espalier_pull_quality;

/// Finds the displacements of the vertices for some targets.
///
/// \param misses for each point, its target minus its rest position: 3 · point_count numbers
/// \param start displacements to start from, 3 · vertex_count numbers, such as those of the last
///        frame of a drag; null to start from rest. May be the same array as `displacements`
/// \param displacements receives 3 · vertex_count numbers
/// \param quality may be null
/// \retval ESPALIER_ERROR_INPUT sizes do not match; a miss or a start is not finite
/// \cost 0.1 to 0.2 ms for each iteration in a lattice of 500 vertices
ESPALIER_C_API espalier_status espalier_pull_solve(const espalier_pull* pull, int32_t point_count,
                                                   const double* misses, int32_t vertex_count,
                                                   const double* start, double* displacements,
                                                   espalier_pull_quality* quality);

// ---- Holding --------------------------------------------------------------------------------

/// How the part that is held joins the part that moves (embed/continuity.h).
enum {
    ESPALIER_CONTINUITY_C0 = 0,  ///< positions are held
    ESPALIER_CONTINUITY_C1 = 1,  ///< tangent planes, too
    ESPALIER_CONTINUITY_C2 = 2   ///< curvatures, too; needs the same vertices as C1
};

/// Finds the vertices to freeze in order to hold faces of a lattice, for example the side where a
/// model extends beyond it. The result is for espalier_fit_options.frozen.
///
/// \param refiner its level 0 is held
/// \param faces faces of the lattice, on the boundary or inside, in any order;
///        espalier_refiner_cells() numbers them, at level 0
/// \param continuity ESPALIER_CONTINUITY_...
/// \param vertex_count number of vertices of the lattice, and size of `held`
/// \param held receives *held_count vertices, ascending; the elements after them are not written
/// \retval ESPALIER_ERROR_INPUT there are no faces, or a face does not exist; or the boundary is
///         open, so that a level covers less than the faces
/// \cost O(lattice + the cells around the faces, refined twice)
ESPALIER_C_API espalier_status espalier_hold_faces(const espalier_refiner* refiner,
                                                   int32_t face_count, const int32_t* faces,
                                                   int32_t continuity, int32_t vertex_count,
                                                   int32_t* held, int32_t* held_count);

/// Finds the vertices to freeze in order to hold points: a part of a model. A point outside the
/// lattice needs the vertices that move it; under ESPALIER_OUTSIDE_KEEP it needs none.
///
/// \param positions rest positions of the vertices of the lattice, 3 · vertex_count numbers
/// \param points 3 · point_count numbers
/// \param options as for binding the points, null for the defaults; limit_tolerance must be 0
/// \param held has vertex_count elements; receives *held_count vertices, ascending
/// \retval ESPALIER_ERROR_INPUT there are no points, or a point is not finite; as
///         espalier_binding_create()
/// \cost as espalier_binding_create()
ESPALIER_C_API espalier_status espalier_hold_points(const espalier_refiner* refiner,
                                                    int32_t vertex_count, const double* positions,
                                                    int32_t point_count, const double* points,
                                                    int32_t continuity,
                                                    const espalier_bind_options* options,
                                                    int32_t* held, int32_t* held_count);

/// Finds the vertices to freeze in order to hold the positions (C0) of points that are already
/// bound.
///
/// \param deformation D: points × vertices of the lattice
/// \param row_count number of points to hold
/// \param rows the rows of D of these points; null for all rows
/// \param vertex_count number of columns of D, and size of `held`
/// \param held receives *held_count vertices, ascending
/// \retval ESPALIER_ERROR_INPUT a row does not exist
/// \cost O(entries)
ESPALIER_C_API espalier_status espalier_hold_rows(const espalier_table* deformation,
                                                  int32_t row_count, const int32_t* rows,
                                                  int32_t vertex_count, int32_t* held,
                                                  int32_t* held_count);

// ---- Validity -------------------------------------------------------------------------------

/// Options of a validity check. Start from espalier_default_validity_options(), and change fields.
typedef struct espalier_validity_options {
    size_t size;    ///< sizeof(espalier_validity_options)
    int32_t level;  ///< the level whose cells are checked: 1 or more; default 3. For the limit, the
                    ///< level up to which irregular features are refined: 1 to 15
    int32_t of_limit;  ///< 0, the default, checks the cells of the level; 1 checks the limits of
                       ///< the cells of the lattice
} espalier_validity_options;

static inline espalier_validity_options espalier_default_validity_options(void) {
    espalier_validity_options options;
    options.size = sizeof options;
    options.level = 3;
    options.of_limit = 0;
    return options;
}

/// Finds out where poses turn the volume of a lattice inside out (solve/validity.h). Immutable.
typedef struct espalier_validity espalier_validity;

/// Prepares checks of the poses of a lattice. The level need not exist, and the refiner does not
/// change.
///
/// \param positions rest positions of the vertices of the lattice, 3 · vertex_count numbers
/// \param options null for the defaults
/// \retval ESPALIER_ERROR_INPUT the level is out of range; a position is not finite, or beyond
///         ±1e90; the rules have no limit
/// \cost O(cells): 1 µs for each cell of the level; 30 µs for each cell of the limit
ESPALIER_C_API espalier_status espalier_validity_create(const espalier_refiner* refiner,
                                                        int32_t vertex_count,
                                                        const double* positions,
                                                        const espalier_validity_options* options,
                                                        espalier_validity** validity);
ESPALIER_C_API void espalier_validity_destroy(espalier_validity* validity);

/// Gives the number of cells that are checked: all cells of the level, or all cells of the lattice
/// for the limit.
ESPALIER_C_API espalier_status espalier_validity_cell_count(const espalier_validity* validity,
                                                            int32_t* cell_count);

/// Gives the cells that are flat, folded or inside out at rest, ascending. The functions below
/// ignore them.
ESPALIER_C_API espalier_status espalier_validity_bad_at_rest(const espalier_validity* validity,
                                                             int32_t* cell_count,
                                                             const int32_t** cells);

/// Gives the cell of the lattice from which a cell descends.
/// \retval ESPALIER_ERROR_INPUT the cell does not exist
ESPALIER_C_API espalier_status espalier_validity_base_cell(const espalier_validity* validity,
                                                           int32_t cell, int32_t* base_cell);

/// The result of a check: how a pose changes the cells.
typedef struct espalier_pose_validity {
    int32_t inverted_count;  ///< cells that the pose turns inside out, wholly or in part
    int32_t smallest_cell;   ///< the cell with the smallest ratio, the lowest if there are several;
                             ///< −1 if no cell has a ratio
    double smallest_ratio;   ///< NaN if no cell has a ratio
} espalier_pose_validity;

/// Checks a pose.
///
/// \param pose positions of the vertices of the lattice, 3 · vertex_count numbers
/// \param cell_count as espalier_validity_cell_count() gives it; ignored if `ratios` is null
/// \param ratios may be null. Receives for each cell the smallest factor, over the whole cell, by
///        which the pose changes its volume. It is at most 0 if and only if the cell is inverted;
///        NaN for cells that are bad at rest or vanish in the limit
/// \retval ESPALIER_ERROR_INPUT sizes do not match, or a position is not finite
/// \cost O(cells): 2 µs for each cell of the level; 0.1 to 0.5 ms for each cell of the limit
ESPALIER_C_API espalier_status espalier_validity_check(const espalier_validity* validity,
                                                       int32_t vertex_count, const double* pose,
                                                       int32_t cell_count, double* ratios,
                                                       espalier_pose_validity* result);

/// How far a lattice can move towards a pose.
typedef struct espalier_largest_step {
    double length;          ///< fraction of the way to the pose up to which all cells stay valid
    int32_t limiting_cell;  ///< a cell that could not be proved valid beyond; −1 if `length` is
                            ///< `max_step`
    int32_t is_tight;  ///< 1: this cell becomes invalid right after `length`; 0: it may stay valid
} espalier_largest_step;

/// Finds the largest step from rest towards a pose, at most `max_step`, up to which no cell is
/// inverted.
///
/// \param max_step upper bound of the step: above 0, at most a million; 1 is the whole way
/// \retval ESPALIER_ERROR_INPUT as espalier_validity_check(), or `max_step` is out of range
/// \cost O(cells): 1 to 3 µs for each cell of the level; 0.15 ms for each cell of the limit
ESPALIER_C_API espalier_status espalier_validity_largest_step(const espalier_validity* validity,
                                                              int32_t vertex_count,
                                                              const double* pose, double max_step,
                                                              espalier_largest_step* step);

#ifdef __cplusplus
}
#endif

#endif
