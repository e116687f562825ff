// SPDX-License-Identifier: Apache-2.0
#ifndef ESPALIER_H
#define ESPALIER_H

#include <stddef.h>
#include <stdint.h>

/// \file
/// The C interface of Espalier, which deforms models by lattices of any polyhedral topology. C11,
/// also C++.
///
///     cells, or a file ──► espalier_lattice ──► espalier_refiner ──► espalier_table     S_n, R_k
///                                                      │
///                                   points ──► espalier_binding ──► espalier_table      D
///                                                      │                  │
///                                              espalier_deformer  espalier_evaluator    D·v, Dᵀ·g
///                                                      │
///                                       poses ──► moved points
///
/// These rules hold for all functions:
///
/// Errors. A function that can fail returns a status: ESPALIER_OK, or an error, for which
/// espalier_last_error() gives the message of the C++ library, with the names of C. After an error
/// the function has written nothing, unless its documentation says otherwise. A null pointer where
/// an object or an array is needed is an error, and never a crash. No function throws, prints or
/// aborts.
///
/// Ownership. A function named ..._create, ..._read, ..._load or ..._table makes an object. The
/// caller destroys it with the destroy function of its type; destroying null does nothing. Objects
/// keep what they need of each other, so they can be destroyed in any order. Arrays that are passed
/// in are copied or read, and never kept. Arrays that are returned (const pointers) belong to the
/// object that returned them. They stay valid and unchanged until that object is destroyed, or
/// changed by a function that takes it without const.
///
/// Threads. Any number of threads may use an object at the same time through const pointers. A
/// thread that changes or destroys an object must be the only one that uses it. Long work runs on
/// all cores, unless an object of the section "In a host" says otherwise. Results do not depend on
/// the number of threads, bit for bit.
///
/// Numbers. Entities (vertices, edges, faces, cells, rows, points) are numbered from 0. Positions
/// are x, y, z in double precision, without gaps between vertices or points, in the caller's unit
/// of length. A "count" is a number of entities; a "size" is a number of array elements. An array
/// may be null if its count is 0.
///
/// Some comments name a C++ header, which describes the operation and its cost in more detail.
///
/// This header is the core. espalier_shapes.h makes ready lattices, espalier_pose.h poses them, and
/// espalier_solve.h fits lattices and checks poses. All three include this header.

#if defined(__GNUC__)
#define ESPALIER_C_API __attribute__((visibility("default")))
#else
#define ESPALIER_C_API
#endif

#ifdef __cplusplus
extern "C" {
#endif

// ---- The library ----------------------------------------------------------------------------

/// The version of this header. Below 1.0, a library works only with a header of the same minor
/// version.
#define ESPALIER_VERSION_MAJOR 0
#define ESPALIER_VERSION_MINOR 1
#define ESPALIER_VERSION_PATCH 0

/// Returns the version of the library that runs, such as "0.1.0".
ESPALIER_C_API const char* espalier_version(void);

/// The result of a call. Later versions may add values.
typedef int32_t espalier_status;
enum {
    ESPALIER_OK = 0,
    ESPALIER_ERROR_INPUT = 1,    ///< an argument or a lattice is invalid
    ESPALIER_ERROR_FILE = 2,     ///< a file cannot be read or written, or is malformed
    ESPALIER_ERROR_MEMORY = 3,   ///< not enough memory, or more than a limit allows
    ESPALIER_CANCELLED = 4,      ///< the callback of an espalier_progress_scope cancelled the call
    ESPALIER_ERROR_INTERNAL = 5  ///< a bug in the library: please report it
};

/// Returns why the last failed call of this thread failed: one line in UTF-8 that names the cause.
/// Without memory for the message, it says so. "" if no call has failed. The string stays the same
/// until another call of this thread fails.
ESPALIER_C_API const char* espalier_last_error(void);

// ---- In a host ------------------------------------------------------------------------------

// Each object of this section is in effect while it lives. Scopes affect only the calls of the
// thread that made them; limits affect the whole process. Destroy scopes on the thread that made
// them, in reverse order. If two scopes of the same kind are nested, the inner one is in effect.
/// The progress of a call. A call is a sequence of stages (base/progress.h). Later versions may add
/// fields at the end.
typedef struct espalier_progress {
    int64_t stage;  ///< number of stages that have ended since the scope began
    int64_t done;   ///< number of items (points, rows, cells) of this stage that are done
    int64_t count;  ///< number of items of this stage; 0 between two stages
} espalier_progress;

/// Returns 0 to cancel, and any other value to continue. Any thread that works for the thread of
/// the scope may call it, but never two at once. Must not throw.
typedef int32_t (*espalier_progress_callback)(void* user, const espalier_progress* progress);

typedef struct espalier_progress_scope espalier_progress_scope;

/// Reports progress to a callback. After the callback has cancelled, it is not called again, and
/// calls return ESPALIER_CANCELLED as soon as possible until the scope is destroyed. All objects
/// stay usable.
///
/// \param user passed to the callback
/// \param milliseconds minimum time between two calls of the callback; 20 is a good value
ESPALIER_C_API espalier_status espalier_progress_scope_create(espalier_progress_callback callback,
                                                              void* user, int32_t milliseconds,
                                                              espalier_progress_scope** scope);
ESPALIER_C_API void espalier_progress_scope_destroy(espalier_progress_scope* scope);

/// Does part `index` of the work.
typedef void (*espalier_task)(void* work, int64_t index);

/// A parallel loop of the host. It calls task(work, 0) to task(work, count − 1), in any order and
/// on any threads, the calling one included, and returns when all calls have ended. Loops may be
/// nested, and must end even if no other thread is free (base/executor.h). Must not throw.
typedef void (*espalier_run)(void* user, int64_t count, espalier_task task, void* work);

typedef struct espalier_executor_scope espalier_executor_scope;

/// Lets the threads of the host do the work.
///
/// \param run null to use no other threads: the calling thread does all work, and takes no lock
/// \param user passed to `run`
ESPALIER_C_API espalier_status espalier_executor_scope_create(espalier_run run, void* user,
                                                              espalier_executor_scope** scope);
ESPALIER_C_API void espalier_executor_scope_destroy(espalier_executor_scope* scope);

/// An upper bound on the number of threads of oneTBB in the whole process, also for other users of
/// oneTBB. The lowest of several limits counts.
typedef struct espalier_thread_limit espalier_thread_limit;

/// \param threads 1 or more
ESPALIER_C_API espalier_status espalier_thread_limit_create(int32_t threads,
                                                            espalier_thread_limit** limit);
ESPALIER_C_API void espalier_thread_limit_destroy(espalier_thread_limit* limit);

/// An upper bound on the memory of the whole process, including the memory of the host. The lowest
/// of several limits counts. Work fails with ESPALIER_ERROR_MEMORY: before it allocates, if it is
/// known to exceed the limit, otherwise soon after it does (base/memory.h).
typedef struct espalier_memory_limit espalier_memory_limit;

/// \param bytes 1 or more
ESPALIER_C_API espalier_status espalier_memory_limit_create(int64_t bytes,
                                                            espalier_memory_limit** limit);
ESPALIER_C_API void espalier_memory_limit_destroy(espalier_memory_limit* limit);

// ---- Lattices -------------------------------------------------------------------------------

/// Polyhedral cells, given by their faces; and faces, given by their vertices.
///
/// Cell c has the faces   cell_faces[i],     cell_offsets[c] <= i < cell_offsets[c + 1],
/// face f the vertices    face_vertices[i],  face_offsets[f] <= i < face_offsets[f + 1],
///
/// in the order around the face. The first offset is 0; the last offset is the length of the array
/// into which the offsets point.
typedef struct espalier_cells {
    int32_t vertex_count;
    int32_t face_count;
    int32_t cell_count;
    const int64_t* cell_offsets;   ///< cell_count + 1 numbers
    const int32_t* cell_faces;     ///< cell_offsets[cell_count] numbers
    const int64_t* face_offsets;   ///< face_count + 1 numbers
    const int32_t* face_vertices;  ///< face_offsets[face_count] numbers
} espalier_cells;

/// Faces of points, such as the faces of a model. Face f has the points corners[i], offsets[f] <= i
/// < offsets[f + 1], in the order around the face. offsets[0] is 0.
typedef struct espalier_polygons {
    int64_t face_count;
    const int64_t* offsets;  ///< face_count + 1 numbers
    const int32_t* corners;  ///< offsets[face_count] numbers
} espalier_polygons;

/// A control lattice: cells, positions of the vertices, and marks.
typedef struct espalier_lattice espalier_lattice;

/// Makes a lattice from cells of any shape.
///
/// Two faces with the same vertices become one, so the caller may give each cell its own faces.
/// Each face must belong to a cell. Faces may start at any vertex and go round in either direction;
/// the library orients them consistently. Vertices and cells keep their numbers; edges and faces
/// are numbered in the order in which they first occur.
///
/// \param cells checked completely; cell_faces may be null and means 0, 1, 2, ... then
/// \param positions 3 · cells->vertex_count numbers
/// \retval ESPALIER_ERROR_INPUT the cells do not form a lattice (far/cell_complex.h), or a position
///         is not finite; the message names the first invalid entity
/// \cost O(n log n) in the length of the arrays.
ESPALIER_C_API espalier_status espalier_lattice_create(const espalier_cells* cells,
                                                       const double* positions,
                                                       espalier_lattice** lattice);

/// Makes a lattice from hexahedra.
///
/// \param vertices 8 for each cell, in VTK's order: the corners of one quadrilateral, anticlockwise
///        as seen from the opposite one, then the corners of the opposite one
/// \param positions 3 · vertex_count numbers
ESPALIER_C_API espalier_status espalier_lattice_create_hexahedra(int32_t vertex_count,
                                                                 const double* positions,
                                                                 int32_t cell_count,
                                                                 const int32_t* vertices,
                                                                 espalier_lattice** lattice);

/// Reads a lattice and its marks from a file whose extension names the format, or from the mesh of
/// a simulation (docs/file-formats.md). Vertices that belong to no cell are dropped, which lowers
/// the numbers of the vertices after them.
ESPALIER_C_API espalier_status espalier_lattice_read(const char* path, espalier_lattice** lattice);

/// Writes a lattice in the format of the extension, so that reading it gives the same lattice. An
/// existing file is replaced only after everything has been written.
ESPALIER_C_API espalier_status espalier_lattice_write(const espalier_lattice* lattice,
                                                      const char* path);

ESPALIER_C_API void espalier_lattice_destroy(espalier_lattice* lattice);

/// Gives the numbers of vertices, edges, faces and cells, in this order.
ESPALIER_C_API espalier_status espalier_lattice_counts(const espalier_lattice* lattice,
                                                       int32_t counts[4]);

/// Gives the positions of the vertices.
/// \param positions 3 · *vertex_count numbers
ESPALIER_C_API espalier_status espalier_lattice_positions(const espalier_lattice* lattice,
                                                          int32_t* vertex_count,
                                                          const double** positions);

/// Replaces the positions of all vertices.
/// \param vertex_count number of vertices of the lattice
/// \retval ESPALIER_ERROR_INPUT a position is not finite; no position is replaced
ESPALIER_C_API espalier_status espalier_lattice_set_positions(espalier_lattice* lattice,
                                                              int32_t vertex_count,
                                                              const double* positions);

/// Infinite sharpness: refinement never uses it up. A sharpness between 0 and this is semi-sharp
/// and decreases by 1 at each level. 0 removes the sharpness that an edge or a vertex would have by
/// rule.
#define ESPALIER_SHARP 10.0

/// Marks edges: as sharp with ESPALIER_SHARP, as creases with less (far/marks.h). A later mark of
/// an edge replaces an earlier one. Existing refiners do not change.
///
/// \param vertices the two ends of each edge, in any order
/// \param sharpness one number for each edge, 0 or more
/// \retval ESPALIER_ERROR_INPUT an edge does not exist, or a sharpness is negative; nothing is
///         marked
ESPALIER_C_API espalier_status espalier_lattice_mark_edges(espalier_lattice* lattice, int64_t count,
                                                           const int32_t* vertices,
                                                           const double* sharpness);

/// Marks vertices, in the same way: as corners with ESPALIER_SHARP.
ESPALIER_C_API espalier_status espalier_lattice_mark_vertices(espalier_lattice* lattice,
                                                              int64_t count,
                                                              const int32_t* vertices,
                                                              const double* sharpness);

/// Gives the numbers of marked edges and of marked vertices, for espalier_lattice_marks(). A later
/// mark of the same edge or vertex replaces an earlier one, and counts separately.
ESPALIER_C_API espalier_status espalier_lattice_mark_counts(const espalier_lattice* lattice,
                                                            int64_t* edge_count,
                                                            int64_t* vertex_count);

/// Gives the marks, in the order in which they were set or read.
///
/// \param edge_count, vertex_count as espalier_lattice_mark_counts() gives them
/// \param edge_ends receives 2 · edge_count vertices
/// \param edge_sharpness receives edge_count numbers; ESPALIER_SHARP if infinite
/// \param vertices receives vertex_count vertices
/// \param vertex_sharpness receives vertex_count numbers
ESPALIER_C_API espalier_status espalier_lattice_marks(const espalier_lattice* lattice,
                                                      int64_t edge_count, int32_t* edge_ends,
                                                      double* edge_sharpness, int64_t vertex_count,
                                                      int32_t* vertices, double* vertex_sharpness);

/// Removes all marks, including the marks that were read from a file.
ESPALIER_C_API espalier_status espalier_lattice_clear_marks(espalier_lattice* lattice);

/// Computes a hash that is equal for lattices with the same cells on the same vertices, on every
/// machine. Lattices with equal hashes can be poses of each other. The order of cells and faces
/// does not matter.
ESPALIER_C_API espalier_status espalier_lattice_topology_hash(const espalier_lattice* lattice,
                                                              uint64_t* hash);

// ---- Refinement -----------------------------------------------------------------------------

/// Refinement rules: Catmull-Clark, in two editions of the rule for interior edges
/// (stencils/masks.h), or multilinear cell averaging, which has no smooth triangles
/// (stencils/mlca.h).
enum { ESPALIER_RULES_SIGGRAPH96 = 0, ESPALIER_RULES_CSE96 = 1, ESPALIER_RULES_MLCA = 2 };

/// Rules at the boundary (far/strata.h).
enum {
    ESPALIER_BOUNDARY_SHARP = 0,      ///< corners, sharp edges and surfaces by their own rules
    ESPALIER_BOUNDARY_EDGE_ONLY = 1,  ///< the same, but single cells have no corners
    ESPALIER_BOUNDARY_OPEN = 2        ///< no boundary rules, so the region shrinks
};

/// Selects the boundary edges that are sharp (far/strata.h).
enum {
    ESPALIER_SHARP_EDGES_SINGLE_CELL = 0,  ///< edges that belong to one cell
    ESPALIER_SHARP_EDGES_LITERAL = 1       ///< edges between vertices of at most two cells each
};

/// How the sharpness of semi-sharp edges decreases (far/marks.h).
enum { ESPALIER_CREASING_UNIFORM = 0, ESPALIER_CREASING_CHAIKIN = 1 };

/// The weights of triangles on the surface (far/topology_refiner.h).
enum { ESPALIER_TRIANGLES_CATMARK = 0, ESPALIER_TRIANGLES_SMOOTH = 1 };

/// Options of refinement. Start from espalier_default_refine_options(): later versions may add
/// fields, and `size` tells the library which fields exist.
typedef struct espalier_refine_options {
    size_t size;          ///< sizeof(espalier_refine_options)
    int32_t rules;        ///< ESPALIER_RULES_...; default SIGGRAPH96
    int32_t boundary;     ///< ESPALIER_BOUNDARY_...; default SHARP
    int32_t sharp_edges;  ///< ESPALIER_SHARP_EDGES_...; default SINGLE_CELL
    int32_t creasing;     ///< ESPALIER_CREASING_...; default UNIFORM
    int32_t triangles;    ///< ESPALIER_TRIANGLES_...; default CATMARK
} espalier_refine_options;

static inline espalier_refine_options espalier_default_refine_options(void) {
    espalier_refine_options options;
    options.size = sizeof options;
    options.rules = ESPALIER_RULES_SIGGRAPH96;
    options.boundary = ESPALIER_BOUNDARY_SHARP;
    options.sharp_edges = ESPALIER_SHARP_EDGES_SINGLE_CELL;
    options.creasing = ESPALIER_CREASING_UNIFORM;
    options.triangles = ESPALIER_TRIANGLES_CATMARK;
    return options;
}

/// The topology of a lattice and of its levels, without positions. Level 0 is the lattice itself;
/// level k has about 8 times the cells of level k − 1 (far/topology_refiner.h).
typedef struct espalier_refiner espalier_refiner;

/// Makes a refiner, which has level 0 only, from the current cells and marks of the lattice.
///
/// \param options null for the defaults
/// \retval ESPALIER_ERROR_INPUT a mark is impossible: smooth where the topology makes a corner; or
///         smooth triangles with the rules of MLCA
ESPALIER_C_API espalier_status espalier_refiner_create(const espalier_lattice* lattice,
                                                       const espalier_refine_options* options,
                                                       espalier_refiner** refiner);
ESPALIER_C_API void espalier_refiner_destroy(espalier_refiner* refiner);

/// Refines up to `level`. Does nothing if the level exists. Arrays of existing levels stay valid.
/// After an error, levels that were completed before it stay.
///
/// \retval ESPALIER_ERROR_INPUT an int32_t cannot count the entities; or nothing is left inside an
///         open boundary
/// \cost O(entities of the new levels)
ESPALIER_C_API espalier_status espalier_refiner_refine(espalier_refiner* refiner, int32_t level);

/// Gives the finest existing level.
ESPALIER_C_API espalier_status espalier_refiner_max_level(const espalier_refiner* refiner,
                                                          int32_t* level);

/// Gives the numbers of vertices, edges, faces and cells of a level, in this order.
ESPALIER_C_API espalier_status espalier_refiner_counts(const espalier_refiner* refiner,
                                                       int32_t level, int32_t counts[4]);

/// Gives the cells, faces and vertices of a level, for example to draw it. A face between two cells
/// is listed once; all faces of level 1 and above are quadrilaterals. Vertices have the same
/// numbers as the rows of S_level.
///
/// \cost O(entities of the level) on the first call for the level, then constant.
ESPALIER_C_API espalier_status espalier_refiner_cells(const espalier_refiner* refiner,
                                                      int32_t level, espalier_cells* cells);

/// Gives the orientations of the faces in their cells.
///
/// \param signs one for each of `cell_faces` of the level: 1 if the vertices of the face go round
///        anticlockwise as seen from outside the cell, −1 if clockwise. A face between two cells
///        has both signs. The orientation of the majority of the given faces decides which side is
///        outside
ESPALIER_C_API espalier_status espalier_refiner_face_signs(const espalier_refiner* refiner,
                                                           int32_t level, const int8_t** signs);

/// Gives the edges of a level, for example to draw it.
///
/// \param edge_count receives the number of edges
/// \param ends receives the two vertices of each edge: 2 · *edge_count numbers
ESPALIER_C_API espalier_status espalier_refiner_edges(const espalier_refiner* refiner,
                                                      int32_t level, int32_t* edge_count,
                                                      const int32_t** ends);

/// Gives the strata of the entities of a level: the dimension of the feature on which an entity
/// lies. 0 is a corner, 1 a sharp edge, 2 the boundary surface, 3 the interior (far/strata.h).
///
/// \param dimension of the entities: 0 for vertices, 1 for edges, 2 for faces, 3 for cells
/// \param count receives the number of entities
/// \param strata one number for each of them
ESPALIER_C_API espalier_status espalier_refiner_strata(const espalier_refiner* refiner,
                                                       int32_t level, int32_t dimension,
                                                       int32_t* count, const uint8_t** strata);

/// Refines values on the vertices of the lattice, such as positions or texture coordinates, to
/// values on the vertices of a level: R_level · ... · R_1 · values.
///
/// \param components numbers for each vertex, 1 or more; 3 for positions
/// \param size components · vertices of level 0
/// \param result_size components · vertices of the level
/// \cost O(entries of the level tables). For many poses, make a table once.
ESPALIER_C_API espalier_status espalier_refiner_carry_values(const espalier_refiner* refiner,
                                                             int32_t level, int32_t components,
                                                             const double* values, int64_t size,
                                                             double* result, int64_t result_size);

// ---- Tables ---------------------------------------------------------------------------------

/// An immutable sparse matrix of weights (stencils/stencil_table.h).
typedef struct espalier_table espalier_table;

/// The arrays of a table in compressed sparse rows, the format of SciPy, Eigen and MKL. Row r has
/// entries offsets[r] to offsets[r + 1] − 1. The columns of a row ascend, without duplicates. Every
/// row sums to 1, except empty rows, which belong to points that no pose moves, rows of points with
/// weights (espalier_bind_options), which sum to the weight, and rows of derivatives, which sum to
/// 0. A table that was read from a file has the rows of the file.
typedef struct espalier_csr {
    int32_t row_count;
    int32_t column_count;
    const int64_t* offsets;  ///< row_count + 1 numbers; offsets[0] is 0
    const int32_t* columns;  ///< offsets[row_count] numbers
    const double* weights;   ///< offsets[row_count] numbers
} espalier_csr;

/// Makes S_level: vertices of the level × vertices of the lattice. For level 0 it is the identity.
/// \cost O(products of entries); at most 64 entries in each row in regular regions.
ESPALIER_C_API espalier_status espalier_table_create_stencils(const espalier_refiner* refiner,
                                                              int32_t level,
                                                              espalier_table** table);

/// Makes R_level: vertices of the level × vertices of the level before. Level 1 or above.
ESPALIER_C_API espalier_status espalier_table_create_level(const espalier_refiner* refiner,
                                                           int32_t level, espalier_table** table);

/// Makes the table of limit positions of the vertices of a level: vertices of the level × vertices
/// of the lattice (limit/vertex_limits.h).
///
/// \retval ESPALIER_ERROR_INPUT no such level, or the rules or the boundary have no limit here
ESPALIER_C_API espalier_status espalier_table_create_limits(const espalier_refiner* refiner,
                                                            int32_t level, espalier_table** table);

/// Options of limit stencils. Start from espalier_default_limit_stencil_options(), and change
/// fields.
typedef struct espalier_limit_stencil_options {
    size_t size;          ///< sizeof(espalier_limit_stencil_options)
    int32_t derivatives;  ///< maximum order: 0, 1 or 2; default 0
    double tolerance;  ///< error of the rows near irregular features, as a fraction of the size of
                       ///< what surrounds a cell: 1e-14 to 0.1; default 1e-6
} espalier_limit_stencil_options;

static inline espalier_limit_stencil_options espalier_default_limit_stencil_options(void) {
    espalier_limit_stencil_options options;
    options.size = sizeof options;
    options.derivatives = 0;
    options.tolerance = 1e-6;
    return options;
}

/// The number of tables that espalier_table_create_limit_stencils() makes: 1, 4 or 10.
#define ESPALIER_LIMIT_STENCIL_TABLES(derivatives) \
    ((derivatives) == 0 ? 1 : (derivatives) == 1 ? 4 : 10)

/// Makes tables of limit positions, and of derivatives there: places × vertices of the lattice
/// (limit/limit_stencils.h). Rows of positions sum to 1, rows of derivatives to 0.
///
/// A place is a hexahedron of the level with coordinates (u, v, w) in it, each from 0 to 1. (0, 0,
/// 0) is the first vertex of the cell's first face (espalier_refiner_cells()). If the sign of this
/// face (espalier_refiner_face_signs()) is −1, u goes to its second vertex and v to its fourth; if
/// the sign is 1, u goes to the fourth and v to the second. w goes away from the face.
///
/// \param level an existing level
/// \param cells for each place a cell of the level, which must be a hexahedron
/// \param uvw 3 · place_count numbers
/// \param options null for the defaults
/// \param table_count size of `tables`: ESPALIER_LIMIT_STENCIL_TABLES(options->derivatives)
/// \param tables the table of positions; then of the first derivatives by u, v, w; then of the
///        second derivatives by uu, uv, uw, vv, vw, ww. The caller destroys each. After an error
///        there are none
/// \retval ESPALIER_ERROR_INPUT the level or a cell does not exist; a cell is not a hexahedron; a
///         place is outside [0, 1]³, or in a cell that vanishes in the limit; options are out of
///         range; the rules have no limit
/// \cost O(entries); near irregular features about 0.2 ms for each level of refinement there
ESPALIER_C_API espalier_status espalier_table_create_limit_stencils(
    const espalier_refiner* refiner, int32_t level, int32_t place_count, const int32_t* cells,
    const double* uvw, const espalier_limit_stencil_options* options, int32_t table_count,
    espalier_table** tables);

ESPALIER_C_API void espalier_table_destroy(espalier_table* table);

/// Writes a table in the format of the extension (io/matrices/matrix_file.h): .mtx, .npz for SciPy,
/// .npy (three files) or .petsc.
ESPALIER_C_API espalier_status espalier_table_write(const espalier_table* table, const char* path);

/// Reads a table in the format of the extension: .mtx, .npz or .petsc. Rows need not sum to 1.
ESPALIER_C_API espalier_status espalier_table_read(const char* path, espalier_table** table);

/// Gives the arrays of a table without copying them.
ESPALIER_C_API espalier_status espalier_table_csr(const espalier_table* table, espalier_csr* csr);

// ---- Bindings -------------------------------------------------------------------------------

/// How a point outside the lattice is treated.
enum {
    ESPALIER_OUTSIDE_KEEP = 0,     ///< the point stays in place: its row of D is empty
    ESPALIER_OUTSIDE_NEAREST = 1,  ///< the nearest cell moves the point, along the tangent of its
                                   ///< map. The point stays in place if the absolute values of
                                   ///< its weights would sum to more than 8
    ESPALIER_OUTSIDE_REFUSE = 2    ///< binding fails
};

/// Where binding found a point. It does not depend on ESPALIER_OUTSIDE_...
enum {
    ESPALIER_POINT_INSIDE = 0,
    ESPALIER_POINT_OUTSIDE = 1,
    ESPALIER_POINT_NOT_CONVERGED = 2,  ///< the cell is degenerate, or a coordinate is not finite;
                                       ///< the point stays in place
    ESPALIER_POINT_NOT_BOUND = 3       ///< the weight of the point is 0, or the point is
                                       ///< beyond the falloff; it stays in place
};

/// Options of binding. Start from espalier_default_bind_options(), and change fields.
typedef struct espalier_bind_options {
    size_t size;       ///< sizeof(espalier_bind_options)
    int32_t level;     ///< level whose cells hold the points: 1 to 20; default 3
    int32_t outside;   ///< ESPALIER_OUTSIDE_...; default KEEP
    double tolerance;  ///< maximum distance from the lattice at which a point counts as inside, as
                       ///< a fraction of the diagonal of the bounding box of the lattice; default
                       ///< 1e-6
    double limit_tolerance;  ///< 0, the default, binds points to the level; a value of 1e-14 to 0.1
                             ///< binds them to the limit volume within this tolerance, whatever
                             ///< the level (limit/limit_binding.h); 1e-6 is usual
    int32_t gradients;  ///< 1 makes the gradients too, for espalier_binding_gradients(); the limit
                        ///< is then met within 1e-12; default 0
    const double* weights;        ///< how far each point follows: a number of 0 to 1 for each point
                                  ///< (bind/point_weights.h); default null: all follow fully
    const double* weight_slopes;  ///< the derivatives of the weights by the points, for the
                                  ///< gradients: three numbers for each point; default null: 0
    double falloff;  ///< above 0: points outside follow as under ESPALIER_OUTSIDE_NEAREST, with a
                     ///< weight that falls from 1 at the lattice to 0 at this distance; default 0
} espalier_bind_options;

static inline espalier_bind_options espalier_default_bind_options(void) {
    espalier_bind_options options;
    options.size = sizeof options;
    options.level = 3;
    options.outside = ESPALIER_OUTSIDE_KEEP;
    options.tolerance = 1e-6;
    options.limit_tolerance = 0;
    options.gradients = 0;
    options.weights = NULL;
    options.weight_slopes = NULL;
    options.falloff = 0;
    return options;
}

/// Points that are bound to a lattice, with D, the points and the lattice at rest. Immutable.
typedef struct espalier_binding espalier_binding;

/// Binds points to a level of a lattice (embed/local_binding.h), or to its limit. The level need
/// not exist: binding refines only the parts of the lattice around the points, and does not change
/// the refiner.
///
/// \param positions rest positions of the vertices of the lattice, 3 · vertex_count numbers
/// \param points 3 · point_count numbers
/// \param options null for the defaults
/// \retval ESPALIER_ERROR_INPUT a position of the lattice is not finite; options are out of range;
///         under ESPALIER_OUTSIDE_REFUSE, a point is not inside: the message names the first;
///         under it, there is a falloff; a weight is not 0 to 1, or a slope is not finite
/// \cost O(points · (level + log cells)), and memory for D, with 64 entries for each point in
///       regular regions. The limit costs about as much as level 5.
ESPALIER_C_API espalier_status espalier_binding_create(const espalier_refiner* refiner,
                                                       int32_t vertex_count,
                                                       const double* positions, int32_t point_count,
                                                       const double* points,
                                                       const espalier_bind_options* options,
                                                       espalier_binding** binding);

/// The basis functions of a box lattice that deforms without subdivision (embed/basis_functions.h).
enum {
    ESPALIER_BASIS_BEZIER = 0,  ///< Bernstein polynomials over the whole lattice
    ESPALIER_BASIS_BSPLINE = 1  ///< uniform cubic B-splines
};

/// Binds points to a box lattice by products of basis functions. This is classical free-form
/// deformation (embed/tensor_product.h).
///
/// \param lattice a box of hexahedra on an evenly divided parallelepiped, without marks
/// \param basis ESPALIER_BASIS_...
/// \param points 3 · point_count numbers
/// \param options null for the defaults; `level` is ignored, and limit_tolerance must be 0
/// \retval ESPALIER_ERROR_INPUT the lattice is not such a box, has marks, or has fewer than 3 cells
///         along an axis under ESPALIER_BASIS_BSPLINE; as espalier_binding_create()
/// \cost O(points · weights of a point), which are at most 64 for B-splines, and all vertices for
///       Bernstein polynomials
ESPALIER_C_API espalier_status espalier_binding_create_tensor(const espalier_lattice* lattice,
                                                              int32_t basis, int32_t point_count,
                                                              const double* points,
                                                              const espalier_bind_options* options,
                                                              espalier_binding** binding);
ESPALIER_C_API void espalier_binding_destroy(espalier_binding* binding);

/// Writes a binding without loss (.espb, io/binding_file.h), for espalier_binding_load() and for
/// `espalier apply`, which writes the points as a model points.obj if the binding was not loaded
/// with a model. An existing file is replaced only after everything has been written.
/// \retval ESPALIER_ERROR_INPUT a point is not finite
ESPALIER_C_API espalier_status espalier_binding_save(const espalier_binding* binding,
                                                     const char* path);

/// Reads a binding that espalier_binding_save() or `espalier bind` wrote. `espalier bind` also
/// stores the file of the model, and the gradients if the model has normals, tangents or splats. A
/// later espalier_binding_save() writes both again.
///
/// \retval ESPALIER_ERROR_FILE the file cannot be read, is damaged, or was written by an older
///         version (io/binding_file.h)
/// \cost O(size of the file)
ESPALIER_C_API espalier_status espalier_binding_load(const char* path, espalier_binding** binding);

/// Gives D: points × vertices of the lattice, which is also the Jacobian of the points by the
/// vertices. The table shares its arrays with the binding.
ESPALIER_C_API espalier_status espalier_binding_table(const espalier_binding* binding,
                                                      espalier_table** table);

/// Gives the hash of the lattice to which the points are bound: see
/// espalier_lattice_topology_hash().
ESPALIER_C_API espalier_status espalier_binding_topology_hash(const espalier_binding* binding,
                                                              uint64_t* hash);

/// Gives ESPALIER_POINT_... for each point.
ESPALIER_C_API espalier_status espalier_binding_statuses(const espalier_binding* binding,
                                                         int32_t* point_count,
                                                         const uint8_t** statuses);

/// Gives the largest distance at rest between a point and its position by D, over the points whose
/// rows of D are not empty.
ESPALIER_C_API espalier_status espalier_binding_largest_residual(const espalier_binding* binding,
                                                                 double* residual);

/// Gives the positions of the lattice and of the points at rest: 3 · *vertex_count and 3 ·
/// *point_count numbers.
ESPALIER_C_API espalier_status espalier_binding_rest(const espalier_binding* binding,
                                                     int32_t* vertex_count, const double** vertices,
                                                     int32_t* point_count, const double** points);

/// Computes the points for a pose of the lattice: x + D · (p' − p), where x and p are the points
/// and the lattice at rest. So points that no moved vertex influences, and points whose row of D
/// is empty, stay exactly where they were. For many poses a deformer is faster; its results differ
/// by rounding, since it adds the products of a row in another order.
///
/// \param vertex_count number of vertices of the lattice
/// \param pose positions of the vertices, 3 · vertex_count numbers
/// \param point_count number of points of the binding
/// \param points receives 3 · point_count numbers
/// \retval ESPALIER_ERROR_INPUT sizes do not match, or a position is not finite
/// \cost O(entries of D).
ESPALIER_C_API espalier_status espalier_binding_apply(const espalier_binding* binding,
                                                      int32_t vertex_count, const double* pose,
                                                      int32_t point_count, double* points);

/// Computes the deformation gradient F of each point for a pose of the lattice: the derivatives of
/// the deformed position by the position at rest, row by row, F(i, j) = dx'_i / dX_j. A point that
/// no moved vertex influences has exactly the identity. espalier_model_write() carries normals by
/// the cofactors of F, and tangents by F (embed/gradients.h).
///
/// \param vertex_count number of vertices of the lattice
/// \param pose positions of the vertices, 3 · vertex_count numbers
/// \param point_count number of points of the binding
/// \param gradients receives 9 · point_count numbers
/// \retval ESPALIER_ERROR_INPUT the binding has no gradients: it was made without
///         espalier_bind_options.gradients, or loaded from a file without them; a position is not
///         finite
/// \cost 0.5 µs for each point in a regular cell; for the others three times that of
///       espalier_binding_apply()
ESPALIER_C_API espalier_status espalier_binding_gradients(const espalier_binding* binding,
                                                          int32_t vertex_count, const double* pose,
                                                          int32_t point_count, double* gradients);

/// Binds points to a lattice in a lattice: the points lie in a child lattice, which lies in a
/// parent lattice. Makes D = D_child · D_parent, points × vertices of the parent
/// (embed/nested_lattices.h). The parent may itself be a child, to any depth.
///
/// \param child D_child, points × vertices of the child
/// \param child_pose positions of the vertices of the child while the parent is at rest: 3 ·
///        child_vertex_count numbers
/// \param parent_positions rest positions of the vertices of the parent, 3 · parent_vertex_count
///        numbers
/// \param options null for the defaults; limit_tolerance must be 0. A vertex of the child may be
///        outside the parent only under ESPALIER_OUTSIDE_NEAREST
/// \retval ESPALIER_ERROR_INPUT sizes do not match, or a vertex of the child is outside the parent
/// \cost as espalier_binding_create() for the vertices of the child, plus the product of the
///       tables.
ESPALIER_C_API espalier_status espalier_table_create_nested(
    const espalier_table* child, int32_t child_vertex_count, const double* child_pose,
    const espalier_refiner* parent, int32_t parent_vertex_count, const double* parent_positions,
    const espalier_bind_options* options, espalier_table** table);

// ---- Evaluators -----------------------------------------------------------------------------

/// Describes how entries are laid out in a buffer: component c of entry i is at offset + i · stride
/// + c (osd/evaluation.h).
typedef struct espalier_buffer_layout {
    int64_t offset;  ///< offset of the first component of entry 0: 0 or more
    int64_t length;  ///< number of components of an entry: 1 or more
    int64_t stride;  ///< distance from one entry to the next: `length` or more
} espalier_buffer_layout;

/// Returns the layout of entries of `length` components without gaps; 3 for x, y, z.
static inline espalier_buffer_layout espalier_packed_layout(int64_t length) {
    espalier_buffer_layout layout;
    layout.offset = 0;
    layout.length = length;
    layout.stride = length;
    return layout;
}

/// A table in the form that is fastest to apply, in double and in single precision. It shares
/// nothing with the table that it is made from (osd/compiled_table.h, osd/compiled_adjoint.h).
/// Immutable.
typedef struct espalier_evaluator_f64 espalier_evaluator_f64;
typedef struct espalier_evaluator_f32 espalier_evaluator_f32;

/// Makes an evaluator that applies a table; D turns a pose into points.
/// \cost O(entries + rows log rows).
ESPALIER_C_API espalier_status espalier_evaluator_f64_create(const espalier_table* table,
                                                             espalier_evaluator_f64** evaluator);
ESPALIER_C_API espalier_status espalier_evaluator_f32_create(const espalier_table* table,
                                                             espalier_evaluator_f32** evaluator);

/// Makes an evaluator that applies the transpose of a table. Its rows are the columns of the table,
/// and its columns the rows. Dᵀ turns gradients by the points into gradients by the vertices of the
/// lattice.
ESPALIER_C_API espalier_status espalier_evaluator_f64_create_adjoint(
    const espalier_table* table, espalier_evaluator_f64** evaluator);
ESPALIER_C_API espalier_status espalier_evaluator_f32_create_adjoint(
    const espalier_table* table, espalier_evaluator_f32** evaluator);

ESPALIER_C_API void espalier_evaluator_f64_destroy(espalier_evaluator_f64* evaluator);
ESPALIER_C_API void espalier_evaluator_f32_destroy(espalier_evaluator_f32* evaluator);

/// Keeps the temporary memory of an evaluation for the next one. An evaluation allocates only if it
/// needs more than any earlier one with the same workspace. Only one evaluation at a time may use a
/// workspace: give each thread its own.
///
/// For real time, evaluate once with a workspace in advance, and then within an
/// espalier_executor_scope without `run`: such an evaluation allocates nothing and takes no lock.
typedef struct espalier_workspace espalier_workspace;

/// Makes a workspace, which has no memory yet.
ESPALIER_C_API espalier_status espalier_workspace_create(espalier_workspace** workspace);
ESPALIER_C_API void espalier_workspace_destroy(espalier_workspace* workspace);

/// Computes, for each row from first_row to last_row − 1,
///
///     destination[row][c] = Σ_k weights(row)[k] · source[columns(row)[k]][c]
///
/// Row i goes to entry i of the destination, whatever the range. Numbers between entries are not
/// written. A row without entries gives 0. One call serves any number of components. A deformer
/// computes the points of a binding, and leaves points without entries where they are.
///
/// \param source, destination buffers that do not overlap: one entry for each column, and one for
///        each row
/// \param source_size, destination_size number of elements of each buffer
/// \param workspace null to allocate the memory in this call and free it afterwards
/// \retval ESPALIER_ERROR_INPUT a layout is invalid, the layouts have different lengths, a buffer
///         is too small, or the range exceeds the table
/// \cost O(entries of the range × components).
ESPALIER_C_API espalier_status espalier_evaluator_f64_evaluate(
    const espalier_evaluator_f64* evaluator, const double* source, int64_t source_size,
    espalier_buffer_layout source_layout, double* destination, int64_t destination_size,
    espalier_buffer_layout destination_layout, int32_t first_row, int32_t last_row,
    espalier_workspace* workspace);
ESPALIER_C_API espalier_status espalier_evaluator_f32_evaluate(
    const espalier_evaluator_f32* evaluator, const float* source, int64_t source_size,
    espalier_buffer_layout source_layout, float* destination, int64_t destination_size,
    espalier_buffer_layout destination_layout, int32_t first_row, int32_t last_row,
    espalier_workspace* workspace);

/// Deforms the points of a binding, for many poses (osd/deformer.h). It owns all that this takes,
/// so the binding may be destroyed: D in the form that is fastest to evaluate, the points and the
/// lattice at rest, and temporary memory. f32 and f64 are the precision of poses and points. Any
/// number of threads may use it at once.
typedef struct espalier_deformer_f64 espalier_deformer_f64;
typedef struct espalier_deformer_f32 espalier_deformer_f32;

/// \cost O(entries of D)
ESPALIER_C_API espalier_status espalier_deformer_f64_create(const espalier_binding* binding,
                                                            espalier_deformer_f64** deformer);
ESPALIER_C_API espalier_status espalier_deformer_f32_create(const espalier_binding* binding,
                                                            espalier_deformer_f32** deformer);

ESPALIER_C_API void espalier_deformer_f64_destroy(espalier_deformer_f64* deformer);
ESPALIER_C_API void espalier_deformer_f32_destroy(espalier_deformer_f32* deformer);

/// Computes the points for one or more poses of the lattice: x + D · (p' − p), where x and p are
/// the points and the lattice at rest, rounded to the precision of the deformer. So points that no
/// moved vertex influences, and points whose row of D is empty, stay exactly there. A pose alone
/// and among others may differ by rounding. A call allocates only if it needs more memory than
/// earlier calls, or if more calls run at once than before (osd/deformer.h).
///
/// \param poses the positions of all vertices, one pose after the other
/// \param poses_size 3 · vertices numbers for each pose
/// \param points receives the points, one pose after the other; must not overlap the poses
/// \param points_size 3 · points numbers for each pose
/// \retval ESPALIER_ERROR_INPUT a size is wrong
/// \cost O(entries of D) for each pose; less for several poses in one call than in several calls
ESPALIER_C_API espalier_status espalier_deformer_f64_deform(const espalier_deformer_f64* deformer,
                                                            const double* poses, int64_t poses_size,
                                                            double* points, int64_t points_size);
ESPALIER_C_API espalier_status espalier_deformer_f32_deform(const espalier_deformer_f32* deformer,
                                                            const float* poses, int64_t poses_size,
                                                            float* points, int64_t points_size);

/// Computes the points that depend on some vertices of the lattice, for example while they are
/// dragged, with the same results. If `points` has the points of one pose, and the next pose
/// differs from it in these vertices only, it then has the points of the next pose.
///
/// \param pose positions of all vertices, 3 · vertices numbers; they must be finite
/// \param changed vertices, in any order
/// \retval ESPALIER_ERROR_INPUT a size is wrong, or a vertex is not in the lattice
/// \cost O(entries of these rows), and O(points / 64). The first call also takes O(entries of D)
ESPALIER_C_API espalier_status espalier_deformer_f64_deform_changed(
    const espalier_deformer_f64* deformer, const double* pose, int64_t pose_size,
    int32_t changed_count, const int32_t* changed, double* points, int64_t points_size);
ESPALIER_C_API espalier_status espalier_deformer_f32_deform_changed(
    const espalier_deformer_f32* deformer, const float* pose, int64_t pose_size,
    int32_t changed_count, const int32_t* changed, float* points, int64_t points_size);

#ifdef __cplusplus
}
#endif

#endif
