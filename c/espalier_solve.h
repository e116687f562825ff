// SPDX-License-Identifier: Apache-2.0
#ifndef ESPALIER_SOLVE_H
#define ESPALIER_SOLVE_H

#include "espalier.h"

/// \file
/// Lattices from wishes, from C (solve/): the displacements that carry points to targets, the
/// vertices to freeze so that a part stays, and the poses that turn no cell inside out.
///
/// The rules of espalier.h on errors, ownership and threads hold here, too.

#ifdef __cplusplus
extern "C" {
#endif

// ---- Fitting --------------------------------------------------------------------------------

/// Further wishes for displacements, besides that they reach the targets (solve/lattice_fit.h).
enum {
    ESPALIER_SMOOTHING_NONE = 0,
    ESPALIER_SMOOTHING_TIKHONOV = 1,  ///< that they are small
    ESPALIER_SMOOTHING_LAPLACIAN = 2  ///< that each is like those of the neighbours
};

/// The rule for displacements that the targets leave open.
enum {
    ESPALIER_UNDETERMINED_SMALLEST = 0,  ///< of all that fit as well, the smallest
    ESPALIER_UNDETERMINED_REFUSE = 1
};

/// How a lattice is fitted. Fill it by espalier_default_fit_options() first, then change fields.
typedef struct espalier_fit_options {
    size_t size;            ///< of this struct: sizeof(espalier_fit_options)
    int32_t smoothing;      ///< ESPALIER_SMOOTHING_...; default NONE
    int32_t undetermined;   ///< ESPALIER_UNDETERMINED_...; default SMALLEST
    double strength;        ///< of smoothing against targets, 1e-4 to 1e4; default 1e-3
    int64_t frozen_count;   ///< default 0
    const int32_t* frozen;  ///< vertices that stay where they are: frozen_count numbers
} espalier_fit_options;

static inline espalier_fit_options espalier_default_fit_options(void) {
    espalier_fit_options options;
    options.size = sizeof options;
    options.smoothing = ESPALIER_SMOOTHING_NONE;
    options.undetermined = ESPALIER_UNDETERMINED_SMALLEST;
    options.strength = 1e-3;
    options.frozen_count = 0;
    options.frozen = NULL;
    return options;
}

/// How well displacements do.
typedef struct espalier_fit_quality {
    double largest_miss;  ///< how far a point is from its target
    double rms_miss;      ///< the root of the mean of the squares of these distances
    double condition;     ///< of the least-squares matrix; infinity where displacements are open
} espalier_fit_quality;

/// The displacements of the vertices of a lattice that carry points to where they are wanted, in
/// the sense of least squares.
///
/// \param deformation D: points × vertices of the lattice
/// \param lattice whose edges are the neighbours of smoothing
/// \param target_count points that have targets
/// \param rows the rows of D that these points have; null for all rows, in order
/// \param misses of each of these points: its target, less where it is at rest. 3 · target_count
///        numbers
/// \param options null for the defaults
/// \param vertex_count that of the lattice
/// \param displacements 3 · vertex_count numbers are written
/// \param quality may be null
/// \retval ESPALIER_ERROR_INPUT no targets; a row that is not there, or is empty; misses that are
/// not
///         finite; options out of range; a frozen vertex that is not there; open displacements
///         under ESPALIER_UNDETERMINED_REFUSE
/// \cost O(Σ entries² of the rows + a sparse Cholesky factor of the vertices)
ESPALIER_C_API espalier_status espalier_lattice_fit(
    const espalier_table* deformation, const espalier_lattice* lattice, int32_t target_count,
    const int32_t* rows, const double* misses, const espalier_fit_options* options,
    int32_t vertex_count, double* displacements, espalier_fit_quality* quality);

// ---- Holding --------------------------------------------------------------------------------

/// How a part that is held meets the part that moves (embed/continuity.h).
enum {
    ESPALIER_CONTINUITY_C0 = 0,  ///< in its place
    ESPALIER_CONTINUITY_C1 = 1,  ///< and with its tangent planes
    ESPALIER_CONTINUITY_C2 = 2   ///< and with its curvatures, by the same vertices
};

/// The vertices to freeze to hold faces of a lattice: the side where a model leaves it, for
/// example. The result is for espalier_fit_options.frozen.
///
/// \param refiner its level 0 is held
/// \param faces of the lattice, as espalier_refiner_cells() numbers them at level 0; in any order,
///        on the boundary or inside
/// \param continuity ESPALIER_CONTINUITY_...
/// \param vertex_count that of the lattice: the room for the result
/// \param held *held_count vertices are written, ascending; the numbers after them stay
/// \retval ESPALIER_ERROR_INPUT no faces, or one that is not there; an open boundary, where a level
///         covers less than the faces
/// \cost O(lattice + the cells around the faces, twice refined)
ESPALIER_C_API espalier_status espalier_hold_faces(const espalier_refiner* refiner,
                                                   int32_t face_count, const int32_t* faces,
                                                   int32_t continuity, int32_t vertex_count,
                                                   int32_t* held, int32_t* held_count);

/// The same to hold points: a part of a model. A point outside of the lattice asks for the vertices
/// that carry it; under ESPALIER_OUTSIDE_KEEP for none.
///
/// \param positions of the vertices of the lattice at rest, 3 · vertex_count numbers
/// \param points 3 · point_count numbers
/// \param options as the points are bound, null for the defaults; limit_tolerance must be 0
/// \param held room for vertex_count numbers; *held_count are written, ascending
/// \retval ESPALIER_ERROR_INPUT no points; one that is not finite; as espalier_binding_create()
/// \cost as espalier_binding_create()
ESPALIER_C_API espalier_status espalier_hold_points(const espalier_refiner* refiner,
                                                    int32_t vertex_count, const double* positions,
                                                    int32_t point_count, const double* points,
                                                    int32_t continuity,
                                                    const espalier_bind_options* options,
                                                    int32_t* held, int32_t* held_count);

/// The same to hold points in their places (C0) that are bound already.
///
/// \param deformation D: points × vertices of the lattice
/// \param row_count points to hold
/// \param rows the rows of D that these points have; null for all rows
/// \param vertex_count the columns of D: the room for the result
/// \param held *held_count vertices are written, ascending
/// \retval ESPALIER_ERROR_INPUT a row that is not there
/// \cost O(entries)
ESPALIER_C_API espalier_status espalier_hold_rows(const espalier_table* deformation,
                                                  int32_t row_count, const int32_t* rows,
                                                  int32_t vertex_count, int32_t* held,
                                                  int32_t* held_count);

// ---- Validity -------------------------------------------------------------------------------

/// Options of a check. Begin with espalier_default_validity_options(), as with those of espalier.h.
typedef struct espalier_validity_options {
    size_t size;       ///< of this struct: sizeof(espalier_validity_options)
    int32_t level;     ///< 1 or more; default 3: whose cells are checked; of the limit, how far
                       ///< irregular features are refined, 1 to 15
    int32_t of_limit;  ///< 0, the default: the cells of the level are checked; 1: the limits of the
                       ///< cells of the lattice
} espalier_validity_options;

static inline espalier_validity_options espalier_default_validity_options(void) {
    espalier_validity_options options;
    options.size = sizeof options;
    options.level = 3;
    options.of_limit = 0;
    return options;
}

/// Tells where poses of a lattice turn its volume inside out (solve/validity.h). Immutable.
typedef struct espalier_validity espalier_validity;

/// The level need not be there, and the refiner stays as it is.
///
/// \param positions of the vertices of the lattice at rest, 3 · vertex_count numbers
/// \param options null for the defaults
/// \retval ESPALIER_ERROR_INPUT a level out of range; a position that is not finite, or beyond
///         ±1e90; rules without a limit
/// \cost O(cells): 1 µs a cell of the level; 30 µs a cell of the limit
ESPALIER_C_API espalier_status espalier_validity_create(const espalier_refiner* refiner,
                                                        int32_t vertex_count,
                                                        const double* positions,
                                                        const espalier_validity_options* options,
                                                        espalier_validity** validity);
ESPALIER_C_API void espalier_validity_destroy(espalier_validity* validity);

/// The number of cells that are checked: those of the level; those of the lattice for the limit.
ESPALIER_C_API espalier_status espalier_validity_cell_count(const espalier_validity* validity,
                                                            int32_t* cell_count);

/// The cells that are flat, folded or inside out at rest, ascending. They do not count in the
/// answers of the functions below.
ESPALIER_C_API espalier_status espalier_validity_bad_at_rest(const espalier_validity* validity,
                                                             int32_t* cell_count,
                                                             const int32_t** cells);

/// The cell of the lattice that a cell descends from.
/// \retval ESPALIER_ERROR_INPUT no such cell
ESPALIER_C_API espalier_status espalier_validity_base_cell(const espalier_validity* validity,
                                                           int32_t cell, int32_t* base_cell);

/// The result of a check: how a pose changes the cells.
typedef struct espalier_pose_validity {
    int32_t inverted_count;  ///< cells that the pose turns inside out, wholly or in part
    int32_t smallest_cell;   ///< the lowest cell of the smallest ratio; −1 if no cell has a ratio
    double smallest_ratio;   ///< not a number if no cell has one
} espalier_pose_validity;

/// Checks a pose.
///
/// \param pose positions of the vertices of the lattice, 3 · vertex_count numbers
/// \param cell_count that of espalier_validity_cell_count(); not read if `ratios` is null
/// \param ratios may be null. For each cell the factor by which the pose changes its volume, the
///        least all over the cell. It is at most 0 if and only if the cell is inverted, and not a
///        number for cells that are bad at rest, or shrink away in the limit
/// \retval ESPALIER_ERROR_INPUT sizes that do not match; a position that is not finite
/// \cost O(cells): 2 µs a cell of the level; 0.1 to 0.5 ms a cell of the limit
ESPALIER_C_API espalier_status espalier_validity_check(const espalier_validity* validity,
                                                       int32_t vertex_count, const double* pose,
                                                       int32_t cell_count, double* ratios,
                                                       espalier_pose_validity* result);

/// How far a lattice can go towards a pose.
typedef struct espalier_largest_step {
    double length;          ///< all cells stay valid up to here, as a part of the way to the pose
    int32_t limiting_cell;  ///< one that could not be proved valid further on; −1 where `length` is
                            ///< the most
    int32_t is_tight;  ///< 1: that cell goes bad right after; 0: it may stay valid
} espalier_largest_step;

/// The largest step from rest towards a pose, up to `most`, on which no cell is inverted.
///
/// \param most above 0, up to a million; 1 is the whole way
/// \retval ESPALIER_ERROR_INPUT as espalier_validity_check(); `most` out of range
/// \cost O(cells): 1 to 3 µs a cell of the level; 0.15 ms a cell of the limit
ESPALIER_C_API espalier_status espalier_validity_largest_step(const espalier_validity* validity,
                                                              int32_t vertex_count,
                                                              const double* pose, double most,
                                                              espalier_largest_step* step);

#ifdef __cplusplus
}
#endif

#endif
