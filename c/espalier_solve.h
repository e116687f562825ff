// SPDX-License-Identifier: Apache-2.0
#ifndef ESPALIER_SOLVE_H
#define ESPALIER_SOLVE_H

#include "espalier.h"

/// \file
/// Lattices from wishes, from C (solve/): the displacements that carry points to targets.
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

#ifdef __cplusplus
}
#endif

#endif
