// SPDX-License-Identifier: Apache-2.0
#ifndef ESPALIER_SOLVE_H
#define ESPALIER_SOLVE_H

#include "espalier.h"

/// \file
/// Lattices from wishes, from C (solve/): the displacements that carry points to targets, and the
/// vertices to freeze so that a part stays.
///
/// What espalier.h says of errors, ownership and threads holds here, too.

#ifdef __cplusplus
extern "C" {
#endif

// ---- Fitting --------------------------------------------------------------------------------

/// What is asked of displacements besides that they reach the targets (solve/lattice_fit.h).
enum {
    ESPALIER_SMOOTHING_NONE = 0,
    ESPALIER_SMOOTHING_TIKHONOV = 1,  ///< that they are small
    ESPALIER_SMOOTHING_LAPLACIAN = 2  ///< that each is like those of the neighbours
};

/// What is done where the targets leave some displacements open.
enum {
    ESPALIER_UNDETERMINED_SMALLEST = 0,  ///< of all that fit as well, the smallest
    ESPALIER_UNDETERMINED_REFUSE = 1
};

/// How a lattice is fitted. Begin with espalier_default_fit_options(), as with those above.
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

/// How a part that is held meets the part that moves (stencils/continuity.h).
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

#ifdef __cplusplus
}
#endif

#endif
