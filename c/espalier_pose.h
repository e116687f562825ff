// SPDX-License-Identifier: Apache-2.0
#ifndef ESPALIER_POSE_H
#define ESPALIER_POSE_H

#include "espalier.h"

/// \file
/// Poses of a lattice, from C: selections of its vertices (shapes/selection.h), operations that
/// move them (shapes/pose.h), and poses as files (io/pose_file.h).
///
/// The functions take positions, such as those that espalier_lattice_positions() gives, and write
/// weights or new positions:
///
///     espalier_select_end(count, rest, up, NULL, weights);
///     options.weights = weights;
///     espalier_pose_twist(count, rest, z_axis, 1.5, &options, pose);
///     espalier_binding_apply(binding, count, pose, point_count, points);
///
/// `positions` are 3 · vertex_count numbers. Angles are in radians. A function that fails has
/// written nothing; the message names the first argument that is not finite or out of range. The
/// rules of espalier.h on errors, ownership and threads apply.

#ifdef __cplusplus
extern "C" {
#endif

// ---- Selections -----------------------------------------------------------------------------

// Each function gives one weight per position: 1 in the selected region, 0 far from it. Positions
// that rounding alone puts outside count as inside (1e-9 of the diagonal of the box around all).

/// How weights decrease with the distance d from the selected region, as u = d / radius grows from
/// 0 to 1.
enum {
    ESPALIER_FALLOFF_LINEAR = 0,  ///< 1 − u
    ESPALIER_FALLOFF_SMOOTH = 1   ///< 1 − 3u² + 2u³
};

/// The decrease of weights outside a selected region. Functions accept null for it: then all
/// weights are 0 or 1.
typedef struct espalier_falloff {
    int32_t profile;  ///< ESPALIER_FALLOFF_...
    double radius;    ///< distance from which on the weights are 0; 0 or more
} espalier_falloff;

/// Selects the box with two opposite corners, in any order.
/// \param weights receives vertex_count numbers, 0 to 1
/// \cost O(vertex_count)
ESPALIER_C_API espalier_status espalier_select_box(int32_t vertex_count, const double* positions,
                                                   const double corner[3], const double opposite[3],
                                                   const espalier_falloff* falloff,
                                                   double* weights);

/// Selects a ball.
/// \param radius 0 or more
ESPALIER_C_API espalier_status espalier_select_ball(int32_t vertex_count, const double* positions,
                                                    const double center[3], double radius,
                                                    const espalier_falloff* falloff,
                                                    double* weights);

/// Selects the half-space on the side of a plane that a normal points to.
/// \param point on the plane
/// \param normal not zero, of any length
ESPALIER_C_API espalier_status espalier_select_half_space(
    int32_t vertex_count, const double* positions, const double point[3], const double normal[3],
    const espalier_falloff* falloff, double* weights);

/// Selects the positions within 1 % of the extent along a direction from the farthest one: the last
/// layer of vertices of a lattice in layers across the direction.
/// \param vertex_count 1 or more
/// \param direction not zero, of any length
ESPALIER_C_API espalier_status espalier_select_end(int32_t vertex_count, const double* positions,
                                                   const double direction[3],
                                                   const espalier_falloff* falloff,
                                                   double* weights);

/// Selects positions by number. The falloff uses the distance from the nearest selected position.
/// \param number_count 0 or more
/// \param numbers 0 to vertex_count − 1; repeated numbers count once
/// \cost O(vertex_count); with a falloff O(vertex_count · number_count)
ESPALIER_C_API espalier_status espalier_select_numbers(int32_t vertex_count,
                                                       const double* positions,
                                                       int64_t number_count, const int32_t* numbers,
                                                       const espalier_falloff* falloff,
                                                       double* weights);

// ---- Selections along the cells -------------------------------------------------------------

// These functions follow the cells of a lattice (shapes/limb.h, shapes/cell_selection.h):
// distances, also of falloffs, are measured along the cells. `positions` has a position for each
// vertex of the lattice, such as a pose.

/// Faces across a lattice: where a limb joins the body.
typedef struct espalier_section {
    double area;
    double center[3];  ///< the mean of the middles of the faces, weighted by their areas
} espalier_section;

/// Selects the limb at a point, such as an arm with its hand: the part of the lattice beyond its
/// narrowest section, where it opens into the body, with the vertices of the section.
/// \param point three numbers, inside or outside the lattice
/// \param weights receives vertex_count numbers
/// \param section may be null; receives the section
/// \retval ESPALIER_ERROR_INPUT the lattice has no limb there: no section is narrow, as in a box
ESPALIER_C_API espalier_status espalier_select_limb(const espalier_lattice* lattice,
                                                    int32_t vertex_count, const double* positions,
                                                    const double point[3],
                                                    const espalier_falloff* falloff,
                                                    double* weights, espalier_section* section);

/// Selects the smaller part of the lattice beyond a face between two cells, with the vertices of
/// the section: the cells that are joined to it on one side of the plane of the face.
/// \param face as espalier_refiner_cells() numbers it at level 0
/// \param section may be null
/// \retval ESPALIER_ERROR_INPUT the face does not exist, or is on the boundary
ESPALIER_C_API espalier_status espalier_select_beyond(const espalier_lattice* lattice,
                                                      int32_t vertex_count, const double* positions,
                                                      int32_t face, const espalier_falloff* falloff,
                                                      double* weights, espalier_section* section);

/// Gives the face between two cells that is nearest to a point, for espalier_select_beyond().
/// \retval ESPALIER_ERROR_INPUT no face is between two cells
ESPALIER_C_API espalier_status espalier_nearest_inner_face(const espalier_lattice* lattice,
                                                           int32_t vertex_count,
                                                           const double* positions,
                                                           const double point[3], int32_t* face);

/// Selects the vertices within a distance of a point along the cells.
/// \param radius 0 or more
ESPALIER_C_API espalier_status espalier_select_near(const espalier_lattice* lattice,
                                                    int32_t vertex_count, const double* positions,
                                                    const double point[3], double radius,
                                                    const espalier_falloff* falloff,
                                                    double* weights);

/// Selects vertices by number, with a falloff along the cells.
/// \param numbers 0 to vertex_count − 1; repeated numbers count once
ESPALIER_C_API espalier_status espalier_select_along_cells(
    const espalier_lattice* lattice, int32_t vertex_count, const double* positions,
    int64_t number_count, const int32_t* numbers, const espalier_falloff* falloff, double* weights);

/// Grows or shrinks a selection along the edges. Vertices with a weight above 0 are selected; the
/// new weights are 0 and 1.
/// \param steps number of edges; below 0 the selection shrinks
/// \param weights vertex_count numbers, 0 to 1, which are replaced
ESPALIER_C_API espalier_status espalier_selection_grow(const espalier_lattice* lattice,
                                                       int32_t vertex_count, int32_t steps,
                                                       double* weights);

/// Sets the weights of the vertices that the lattice holds in place, such as the outer vertices of
/// a collar (shapes/held.h), to 0, so that no operation moves them. \param weights vertex_count
/// numbers, 0 to 1, which are changed
ESPALIER_C_API espalier_status espalier_lattice_held_weights(const espalier_lattice* lattice,
                                                             int32_t vertex_count, double* weights);

/// Gives the section between the vertices with a weight above 0 and the rest. Its middle is the
/// joint about which a selected limb turns.
/// \param weights vertex_count numbers, 0 to 1, without a falloff
/// \retval ESPALIER_ERROR_INPUT no vertex or all vertices are selected, or no face has selected
///         vertices only
ESPALIER_C_API espalier_status espalier_selection_border(const espalier_lattice* lattice,
                                                         int32_t vertex_count,
                                                         const double* positions,
                                                         const double* weights,
                                                         espalier_section* section);

// ---- Operations -----------------------------------------------------------------------------

/// The positions that an operation moves, its centre and its range. Start from
/// espalier_default_pose_options(): later versions may add fields, and `size` tells the library
/// which fields exist. Operations ignore fields that they do not need.
typedef struct espalier_pose_options {
    size_t size;  ///< sizeof(espalier_pose_options)

    /// vertex_count numbers, 0 to 1: the part of the operation that each position gets. A position
    /// with weight 0 stays bit for bit. Default null: 1 for all.
    const double* weights;

    /// x, y, z: a point on the axis, or the fixed point of a scaling. Default null: the middle of
    /// the box around the positions with a weight above 0.
    const double* center;

    /// Two coordinates along the unit vector of the axis, the second above the first. Twist, bend
    /// and taper grow from nothing to all between them. Default null: the interval of the positions
    /// with a weight above 0.
    const double* range;
} espalier_pose_options;

static inline espalier_pose_options espalier_default_pose_options(void) {
    espalier_pose_options options;
    options.size = sizeof options;
    options.weights = NULL;
    options.center = NULL;
    options.range = NULL;
    return options;
}

/// Moves by weight · offset.
/// \param options null for the defaults
/// \param pose receives 3 · vertex_count numbers; may be the same array as `positions`
/// \cost O(vertex_count)
ESPALIER_C_API espalier_status espalier_pose_move(int32_t vertex_count, const double* positions,
                                                  const double offset[3],
                                                  const espalier_pose_options* options,
                                                  double* pose);

/// Rotates by weight · angle about an axis through the centre, anticlockwise seen from its tip.
/// \param axis not zero, of any length
ESPALIER_C_API espalier_status espalier_pose_rotate(int32_t vertex_count, const double* positions,
                                                    const double axis[3], double angle,
                                                    const espalier_pose_options* options,
                                                    double* pose);

/// Scales by 1 + weight (factors − 1) along x, y and z about the centre.
ESPALIER_C_API espalier_status espalier_pose_scale(int32_t vertex_count, const double* positions,
                                                   const double factors[3],
                                                   const espalier_pose_options* options,
                                                   double* pose);

/// Rotates about an axis: by 0 at the start of the range, by weight · angle at its end and beyond.
ESPALIER_C_API espalier_status espalier_pose_twist(int32_t vertex_count, const double* positions,
                                                   const double axis[3], double angle,
                                                   const espalier_pose_options* options,
                                                   double* pose);

/// Bends the part of an axis in the range into an arc of a circle of the same length; the parts
/// beyond it remain straight.
/// \param toward direction that the end of the range bends to; not parallel to the axis
ESPALIER_C_API espalier_status espalier_pose_bend(int32_t vertex_count, const double* positions,
                                                  const double axis[3], double angle,
                                                  const double toward[3],
                                                  const espalier_pose_options* options,
                                                  double* pose);

/// Scales across an axis: by 1 at the start of the range, by 1 + weight (factor − 1) at its end and
/// beyond.
/// \param factor 0 or more
ESPALIER_C_API espalier_status espalier_pose_taper(int32_t vertex_count, const double* positions,
                                                   const double axis[3], double factor,
                                                   const espalier_pose_options* options,
                                                   double* pose);

/// Mirrors a pose from one side to the other: moves the mirror image of each position to the
/// mirrored place of the position. Images are found in the lattice at rest, within a thousandth of
/// the diagonal of the box around it. A position and its image are a pair, of which the position
/// with the larger weight stays. If their weights are equal, the position stays that is on the side
/// of the plane whose weights have the larger sum. A position that is its own image moves into the
/// plane.
/// \param rest 3 · vertex_count numbers: the lattice at rest
/// \param axis 0 to 2: the plane is across this axis
/// \param plane may be null; the coordinate of the plane on the axis. Default: of the middle of the
///        box around the lattice at rest
/// \param weights null, for 1 everywhere; or vertex_count numbers, 0 to 1, which choose the
///        positions whose images follow
/// \param pose receives 3 · vertex_count numbers; may be the same array as `positions`
/// \param without_image may be null; receives the number of positions with a weight above 0 that
///        have no mirror image, and so stay
/// \retval ESPALIER_ERROR_INPUT no position with a weight above 0 has a mirror image
/// \cost O(vertex_count · log vertex_count)
ESPALIER_C_API espalier_status espalier_pose_mirror(int32_t vertex_count, const double* positions,
                                                    const double* rest, int32_t axis,
                                                    const double* plane, const double* weights,
                                                    double* pose, int32_t* without_image);

// ---- Files ----------------------------------------------------------------------------------

/// Writes a lattice as an editor mesh: an .obj or .ply with the vertices in their order,
/// with all digits, and with every face, also interior faces.
/// \retval ESPALIER_ERROR_FILE the file cannot be written, or has another extension
ESPALIER_C_API espalier_status espalier_lattice_write_editor_mesh(const espalier_lattice* lattice,
                                                                  const char* path);

/// Reads a pose of a lattice: a lattice file (.ovm, .vtu, .vtk) with the same cells on the same
/// vertex numbers, or an editor mesh (.obj, .ply) with one point per vertex and only faces of the
/// lattice.
///
/// \param vertex_count number of vertices of the lattice
/// \param pose receives 3 · vertex_count numbers
/// \retval ESPALIER_ERROR_FILE the file cannot be read, or is not a pose of this lattice; the
///         message names the first difference
ESPALIER_C_API espalier_status espalier_lattice_read_pose(const espalier_lattice* lattice,
                                                          const char* path, int32_t vertex_count,
                                                          double* pose);

/// Reads a pose of the lattice to which points are bound, in the same way.
ESPALIER_C_API espalier_status espalier_binding_read_pose(const espalier_binding* binding,
                                                          const char* path, int32_t vertex_count,
                                                          double* pose);

#ifdef __cplusplus
}
#endif

#endif
