// SPDX-License-Identifier: Apache-2.0
#ifndef ESPALIER_MODEL_H
#define ESPALIER_MODEL_H

#include "espalier.h"

/// \file
/// Models, from C: files with points that a lattice deforms (io/model.h), and cages around them
/// (cages/cage.h). A model is written in the format from which it was read, with new coordinates;
/// all other bytes of the file stay as they were.
///
/// The rules of espalier.h on errors, ownership and threads apply.

#ifdef __cplusplus
extern "C" {
#endif

/// A file with points: .obj, .ply, .stl, .vtu, .vtp or .vtk. Immutable.
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

/// Gives the points, in the order of the file: 3 · *point_count numbers, all finite.
ESPALIER_C_API espalier_status espalier_model_points(const espalier_model* model,
                                                     int32_t* point_count, const double** points);

/// Faces of points. Face f has the points corners[i], offsets[f] <= i < offsets[f + 1], in the
/// order around it.
typedef struct espalier_polygons {
    int64_t face_count;
    const int64_t* offsets;  ///< face_count + 1 numbers
    const int32_t* corners;  ///< offsets[face_count] numbers
} espalier_polygons;

/// Gives the faces, which are read from the file on the first call. In an .stl, corners at equal
/// places are one point: the first of them.
///
/// \retval ESPALIER_ERROR_FILE a face is malformed, or names a point that does not exist
/// \cost one pass over the file; for an .stl O(n log n)
ESPALIER_C_API espalier_status espalier_model_faces(const espalier_model* model,
                                                    espalier_polygons* faces);

/// Tells whether the file has directions at the points, normals or tangents, that
/// espalier_model_write() can carry.
ESPALIER_C_API espalier_status espalier_model_has_directions(const espalier_model* model,
                                                             int32_t* has_directions);

/// Writes the model with new points, to a file with the extension of its format. An existing file
/// is replaced only after everything has been written. If no point has moved, the file is a copy.
///
/// \param point_count number of points of the model
/// \param points 3 · point_count numbers
/// \param gradients null, and normals and tangents stay; or the deformation gradient at each point,
///        row by row: 9 · point_count numbers (espalier_binding_gradients())
/// \retval ESPALIER_ERROR_INPUT a point or a gradient is not finite, or too large for the format
ESPALIER_C_API espalier_status espalier_model_write(const espalier_model* model, const char* path,
                                                    int32_t point_count, const double* points,
                                                    const double* gradients);

/// Options of a cage. Start from espalier_default_cage_options(), and change fields.
typedef struct espalier_cage_options {
    size_t size;         ///< sizeof(espalier_cage_options)
    int32_t vertices;    ///< number of vertices of the cage, 8 to 100,000; the result has between
                         ///< 0.8 and 1.2 times as many; not used if cell_size is set; default 200
    int32_t keep_apart;  ///< nonzero: parts of the model that are nearer to each other than a cell
                         ///< stay separate; default 0
    double cell_size;    ///< edge of the cells before they are fitted, in the units of the points;
                         ///< default 0: not set
    double margin;       ///< least distance between the model and the boundary of the cage, as a
                         ///< fraction of the diagonal of the box around the points; default 0
    double shell;        ///< above 0: the cage is made around the surface only, and contains all
                         ///< points within half of this distance; default 0: around the solid
} espalier_cage_options;

static inline espalier_cage_options espalier_default_cage_options(void) {
    espalier_cage_options options;
    options.size = sizeof options;
    options.vertices = 200;
    options.keep_apart = 0;
    options.cell_size = 0;
    options.margin = 0;
    options.shell = 0;
    return options;
}

/// Makes a lattice of hexahedra that follows the shape of a model: every point of the faces is
/// inside it, at level 3 and in the limit, and no cell is folded.
///
/// \param points 3 · point_count numbers
/// \param faces any polygons, such as espalier_model_faces() gives
/// \param options null for the defaults
/// \retval ESPALIER_ERROR_INPUT there are no faces; a face names a point that does not exist; a
///         point is not finite; an option is out of range; or no cage of about this size can be
///         fitted
/// \cost about 5 s for 100,000 triangles and 500 vertices on one thread
ESPALIER_C_API espalier_status espalier_lattice_create_cage(int32_t point_count,
                                                            const double* points,
                                                            const espalier_polygons* faces,
                                                            const espalier_cage_options* options,
                                                            espalier_lattice** lattice);

#ifdef __cplusplus
}
#endif

#endif
