// SPDX-License-Identifier: Apache-2.0
#ifndef ESPALIER_MODEL_H
#define ESPALIER_MODEL_H

#include "espalier.h"

/// \file
/// Models, from C: files with points that a lattice deforms (io/model.h). A model is written in the
/// format from which it was read, with new coordinates; all other bytes of the file stay as they
/// were.
///
/// The rules of espalier.h on errors, ownership and threads apply.

#ifdef __cplusplus
extern "C" {
#endif

/// A file with points, such as .obj (docs/file-formats.md). Immutable.
typedef struct espalier_model espalier_model;

/// Reads a model in the format that its extension names.
/// \retval ESPALIER_ERROR_FILE the extension is not known; the file cannot be read, is malformed
///         (the message names the line, or the byte), or has no points
ESPALIER_C_API espalier_status espalier_model_read(const char* path, espalier_model** model);

/// Reads a model from a file that is in memory.
/// \param name names the format by its extension, and the file in messages
ESPALIER_C_API espalier_status espalier_model_read_bytes(const char* name, int64_t size,
                                                         const void* bytes, espalier_model** model);
ESPALIER_C_API void espalier_model_destroy(espalier_model* model);

/// Gives the points, in the order of the file: 3 · *point_count numbers, all finite. The first
/// finite point stands in for points of the file that are not, which espalier_model_write() keeps.
ESPALIER_C_API espalier_status espalier_model_points(const espalier_model* model,
                                                     int32_t* point_count, const double** points);

/// Gives the faces, which are read from the file on the first call. In an .stl, corners at equal
/// places are one point: the first of them.
///
/// \retval ESPALIER_ERROR_FILE a face is malformed, or names a point that does not exist
/// \cost one pass over the file; for an .stl O(n log n)
ESPALIER_C_API espalier_status espalier_model_faces(const espalier_model* model,
                                                    espalier_polygons* faces);

/// How a model looks. The model owns the arrays; an array is null if the file has none of its kind.
/// Corners are the corners of espalier_model_faces(), faces its faces.
typedef struct espalier_appearance {
    int32_t texture_count;           ///< number of pairs of texture coordinates
    const double* textures;          ///< u and v, with v upwards, of each pair
    const int32_t* texture_corners;  ///< for each corner the number of its pair

    int32_t normal_count;
    const double* normals;          ///< 3 numbers for each normal
    const int32_t* normal_corners;  ///< for each corner the number of its normal; null if there is
                                    ///< a normal for each point

    /// For each point red, green and blue as screens show them (sRGB), and the opacity: 0 to 1.
    const float* colors;

    /// For each point the covariance xx, xy, xz, yy, yz and zz of its Gaussian splat.
    const float* covariances;

    int32_t material_count;
    const char* const* materials;   ///< names: of an .obj in the order of their first use; of glTF
                                    ///< of all materials, which may be empty
    const int32_t* face_materials;  ///< for each face the number of its material, or -1
} espalier_appearance;

/// Gives what is known of how the model looks: texture coordinates, normals, colours and names of
/// materials (io::ModelSurface). They are read from the file on the first call.
///
/// \retval ESPALIER_ERROR_FILE the file is malformed
/// \cost one pass over the file, which also reads the faces; further passes for the colours in a
///       .ply and in the files of VTK
ESPALIER_C_API espalier_status espalier_model_appearance(const espalier_model* model,
                                                         espalier_appearance* appearance);

/// Tells whether the file has directions at the points, normals, tangents or splats, that
/// espalier_model_write() can carry.
ESPALIER_C_API espalier_status espalier_model_has_directions(const espalier_model* model,
                                                             int32_t* has_directions);

/// Gives notes on parts of the file that were skipped, or are kept without being understood: one
/// line, "a.obj: kept 1 line whose first word no OBJ has (\"foo\" in line 7)"; empty if there are
/// none.
///
/// \param notes the text of the model, in UTF-8 if the name and the file are
ESPALIER_C_API espalier_status espalier_model_notes(const espalier_model* model,
                                                    const char** notes);

/// Gives the names of the numbers at the points that can be weights (io::Model::attributes()):
/// properties of a .ply, "NAME:0" for the first of several numbers. The model owns the names.
/// \retval ESPALIER_ERROR_FILE the file is malformed
ESPALIER_C_API espalier_status espalier_model_attributes(const espalier_model* model,
                                                         int32_t* count, const char* const** names);

/// Gives the names of the groups of points (io::Model::groups()). An .obj has groups, objects and
/// materials; glTF has meshes, nodes and materials; a mesh of a simulation has patches, markers or
/// groups. The model owns the names.
/// \retval ESPALIER_ERROR_FILE the file is malformed
/// \cost one pass over the file on the first call
ESPALIER_C_API espalier_status espalier_model_groups(const espalier_model* model, int32_t* count,
                                                     const char* const** names);

/// Computes the weights of the points of a part of the model (io/model_part.h), for
/// espalier_bind_options.weights.
///
/// \param attribute the name of an attribute of 0 to 1; or null, and the weights are 1
/// \param group_count 0 for the whole model
/// \param groups names of groups. A point that is in none of them gets the weight 0
/// \param point_count number of points of the model
/// \param weights receives point_count numbers
/// \retval ESPALIER_ERROR_FILE the model has no attribute or group of a name (the message lists the
///         names that it has), or a number of the attribute is below 0 or above 1
/// \cost some passes over the file
ESPALIER_C_API espalier_status espalier_model_weights(const espalier_model* model,
                                                      const char* attribute, int32_t group_count,
                                                      const char* const* groups,
                                                      int32_t point_count, double* weights);

/// Holds points of the model: the points in some groups get the weight 0.
///
/// \param group_count number of groups
/// \param groups names of groups, such as the patches of a mesh
/// \param point_count number of points of the model
/// \param weights point_count numbers, which are changed for the points in the groups
/// \retval ESPALIER_ERROR_FILE the model has no group of a name (the message lists the names that
/// it
///         has)
ESPALIER_C_API espalier_status espalier_model_hold(const espalier_model* model, int32_t group_count,
                                                   const char* const* groups, int32_t point_count,
                                                   double* weights);

/// Keeps the points of patches in the planes, cylinders, lines or circles that they are on at rest
/// (solve/sliding_points.h). Immutable; it does not need the model any more.
typedef struct espalier_sliding_points espalier_sliding_points;

/// Finds the shapes of patches.
///
/// \param patch_count number of patches
/// \param patches names of groups, such as the patches of a mesh
/// \retval ESPALIER_ERROR_FILE the model has no group of a name
/// \retval ESPALIER_ERROR_INPUT the points of a patch are on no such shape (the message names a
///         point and its distance)
ESPALIER_C_API espalier_status espalier_sliding_points_create(const espalier_model* model,
                                                              int32_t patch_count,
                                                              const char* const* patches,
                                                              espalier_sliding_points** sliding);
ESPALIER_C_API void espalier_sliding_points_destroy(espalier_sliding_points* sliding);

/// Moves deformed points to the nearest places of their shapes. A point that is where it is at rest
/// stays.
///
/// \param point_count number of points of the model
/// \param points 3 · point_count numbers, which are changed for the points of the patches
/// \param largest receives the largest distance that a point was moved back; may be null
/// \retval ESPALIER_ERROR_INPUT a point finds no place on its shapes; no point is changed then
ESPALIER_C_API espalier_status espalier_sliding_points_slide(const espalier_sliding_points* sliding,
                                                             int32_t point_count, double* points,
                                                             double* largest);

/// Computes the slopes of weights along the faces of the model, for
/// espalier_bind_options.weight_slopes: at each point the slope in the tangent plane that fits the
/// weights at the ends of its edges best (bind/point_weights.h). They are 0 for points in no face.
///
/// \param point_count number of points of the model
/// \param weights point_count numbers
/// \param slopes receives 3 · point_count numbers
/// \retval ESPALIER_ERROR_INPUT the model has faces, and a weight is not finite
ESPALIER_C_API espalier_status espalier_model_weight_slopes(const espalier_model* model,
                                                            int32_t point_count,
                                                            const double* weights, double* slopes);

/// Writes the model with new points, to a file with the extension of its format. An existing file
/// is replaced only after everything has been written. If no point has moved, the file is a copy.
///
/// \param point_count number of points of the model
/// \param points 3 · point_count numbers
/// \param gradients null, and normals, tangents and splats stay; or the deformation gradient at
///        each point, row by row: 9 · point_count numbers (espalier_binding_gradients())
/// \retval ESPALIER_ERROR_INPUT a point or a gradient is not finite, or too large for the format
ESPALIER_C_API espalier_status espalier_model_write(const espalier_model* model, const char* path,
                                                    int32_t point_count, const double* points,
                                                    const double* gradients);

#ifdef __cplusplus
}
#endif

#endif
