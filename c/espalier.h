// SPDX-License-Identifier: Apache-2.0
#ifndef ESPALIER_H
#define ESPALIER_H

#include <stddef.h>
#include <stdint.h>

/// \file
/// Espalier from C: lattices of any polyhedral topology deform models. C11, and C++ as well.
///
///     cells, or a file ──► espalier_lattice ──► espalier_refiner ──► espalier_table     S_n, R_k
///                                                      │
///                                   points ──► espalier_binding ──► espalier_table      D
///                                                      │                  │
///                                        pose ──► moved points    espalier_evaluator    D·p', Dᵀ·g
///
/// What holds of every function:
///
/// Errors. A function that can fail returns a status: ESPALIER_OK, or another, and then
/// espalier_last_error() says what is wrong, in the words of the C++ library. It has written
/// nothing then, but for what it says itself. Null where something must be is an error, and never a
/// crash. No exception leaves a function; none prints, none aborts.
///
/// Ownership. A function named ..._create, ..._read, ..._load or ..._table makes an object, which
/// the caller destroys with the function of its type; to destroy null does nothing. Objects keep
/// what they need of each other: they can be destroyed in any order. Arrays that are passed in are
/// copied or read, and never kept. Arrays that come out (const pointers) belong to the object that
/// they were asked of, and stay as they are until that is destroyed, or changed by a function that
/// takes it without const.
///
/// Threads. Any number of threads may use an object at once through const pointers; a thread that
/// changes or destroys it must be alone with it. Long work is done on all cores, if nothing of the
/// section "In a host" says otherwise. Results do not depend on the number of threads, bit for bit.
///
/// Numbers. Entities (vertices, edges, faces, cells, rows, points) are counted from 0. Positions
/// are x, y, z in double precision, one vertex or point behind the other, in the caller's unit of
/// length. A count is that of the entities, not of the numbers; where it is that of numbers, it is
/// called a size. An array may be null where its count is 0.
///
/// The C++ headers that are named say in more detail what an operation means and costs.
///
/// This header is the core. espalier_shapes.h has the inventory of lattices, and espalier_solve.h
/// the fit of a lattice and the checks of its poses; both include this one.

#if defined(__GNUC__)
#define ESPALIER_C_API __attribute__((visibility("default")))
#else
#define ESPALIER_C_API
#endif

#ifdef __cplusplus
extern "C" {
#endif

// ---- The library ----------------------------------------------------------------------------

/// The version of this header. Below 1.0, libraries of another minor version do not fit it.
#define ESPALIER_VERSION_MAJOR 0
#define ESPALIER_VERSION_MINOR 1
#define ESPALIER_VERSION_PATCH 0

/// The version of the library that runs: "0.1.0".
ESPALIER_C_API const char* espalier_version(void);

/// What became of a call. Others may be added.
typedef int32_t espalier_status;
enum {
    ESPALIER_OK = 0,
    ESPALIER_ERROR_INPUT = 1,    ///< an argument, or a lattice, that is refused
    ESPALIER_ERROR_FILE = 2,     ///< a file that cannot be read or written, or is malformed
    ESPALIER_ERROR_MEMORY = 3,   ///< not enough memory, or more than a limit allows
    ESPALIER_CANCELLED = 4,      ///< by the callback of an espalier_progress_scope
    ESPALIER_ERROR_INTERNAL = 5  ///< not foreseen: please report it
};

/// Why the last call of this thread that failed did so: one line, in UTF-8, that names the
/// offender, or says that there was no memory to do so; "" if none has failed. Stays as it is until
/// another call of this thread fails.
ESPALIER_C_API const char* espalier_last_error(void);

// ---- In a host ------------------------------------------------------------------------------

// While one of the objects of this section lives, it holds for what the thread that made it asks of
// the library, and not for other threads; a thread limit for the whole process. Scopes are
// destroyed on the thread that made them, in the reverse order. Of two of a kind, the inner one
// counts.

/// How far a call has come. A call is a sequence of stages (base/progress.h). Later versions may
/// add fields at the end.
typedef struct espalier_progress {
    int64_t stage;  ///< stages that ended before, since the scope began
    int64_t done;   ///< items (points, rows, cells) of this stage that are done
    int64_t count;  ///< its items; 0 between two stages
} espalier_progress;

/// Returns other than 0 to go on, and 0 to cancel. Called from any thread that works for this one,
/// but never from two at once. Throws nothing.
typedef int32_t (*espalier_progress_callback)(void* user, const espalier_progress* progress);

typedef struct espalier_progress_scope espalier_progress_scope;

/// Has a callback hear of progress. Once it cancels it is not called again, and calls return
/// ESPALIER_CANCELLED as soon as they can until the scope is destroyed; all objects are as usable
/// as before.
///
/// \param user handed to the callback
/// \param milliseconds from one call of it to the next, at least; 20 is a good number
ESPALIER_C_API espalier_status espalier_progress_scope_create(espalier_progress_callback callback,
                                                              void* user, int32_t milliseconds,
                                                              espalier_progress_scope** scope);
ESPALIER_C_API void espalier_progress_scope_destroy(espalier_progress_scope* scope);

/// Does part `index` of the work.
typedef void (*espalier_task)(void* work, int64_t index);

/// A parallel loop of the host's: calls task(work, 0) to task(work, count − 1), in any order and
/// from any threads, this one included, and returns when all have ended. Calls nest, and must end
/// even if no other thread is free (base/executor.h). Throws nothing.
typedef void (*espalier_run)(void* user, int64_t count, espalier_task task, void* work);

typedef struct espalier_executor_scope espalier_executor_scope;

/// Has the work done by the threads of the host.
///
/// \param run null for no threads: the thread that calls does all of it, without a lock
/// \param user handed to it
ESPALIER_C_API espalier_status espalier_executor_scope_create(espalier_run run, void* user,
                                                              espalier_executor_scope** scope);
ESPALIER_C_API void espalier_executor_scope_destroy(espalier_executor_scope* scope);

/// An upper bound on the threads of oneTBB, for the whole process and whatever else uses oneTBB
/// there; of several the lowest counts.
typedef struct espalier_thread_limit espalier_thread_limit;

/// \param threads 1 or more
ESPALIER_C_API espalier_status espalier_thread_limit_create(int32_t threads,
                                                            espalier_thread_limit** limit);
ESPALIER_C_API void espalier_thread_limit_destroy(espalier_thread_limit* limit);

/// An upper bound on the memory of the whole process, that of the host included; of several the
/// lowest counts. What is known to take more gives ESPALIER_ERROR_MEMORY before memory is taken for
/// it, what turns out to, soon after (base/memory.h).
typedef struct espalier_memory_limit espalier_memory_limit;

/// \param bytes 1 or more
ESPALIER_C_API espalier_status espalier_memory_limit_create(int64_t bytes,
                                                            espalier_memory_limit** limit);
ESPALIER_C_API void espalier_memory_limit_destroy(espalier_memory_limit* limit);

// ---- Lattices -------------------------------------------------------------------------------

/// Polyhedral cells, by their faces, by their vertices.
///
/// Cell c has the faces   cell_faces[i],     cell_offsets[c] <= i < cell_offsets[c + 1],
/// face f the vertices    face_vertices[i],  face_offsets[f] <= i < face_offsets[f + 1],
///
/// in the order in which they go round the face. The first offset is 0, and the last is the length
/// of the array that the offsets are for.
typedef struct espalier_cells {
    int32_t vertex_count;
    int32_t face_count;
    int32_t cell_count;
    const int64_t* cell_offsets;   ///< cell_count + 1
    const int32_t* cell_faces;     ///< cell_offsets[cell_count]
    const int64_t* face_offsets;   ///< face_count + 1
    const int32_t* face_vertices;  ///< face_offsets[face_count]
} espalier_cells;

/// A control lattice: cells, the positions of its vertices, and marks.
typedef struct espalier_lattice espalier_lattice;

/// Makes a lattice from cells of any shape.
///
/// Two faces with the same vertices are one, so a caller may give each cell faces of its own; none
/// may be in no cell. How
/// faces wind, and where they start, is free: they are oriented coherently. Vertices and cells keep
/// their numbers; edges and faces are numbered as they come.
///
/// \param cells checked as a whole; cell_faces may be null, and stands for 0, 1, 2, ... then
/// \param positions 3 · cells->vertex_count numbers
/// \retval ESPALIER_ERROR_INPUT the cells do not form a lattice (far/cell_complex.h): the message
///         names the first offender
/// \cost O(n log n) in the length of the arrays.
ESPALIER_C_API espalier_status espalier_lattice_create(const espalier_cells* cells,
                                                       const double* positions,
                                                       espalier_lattice** lattice);

/// The same from hexahedra.
///
/// \param vertices 8 a cell, in VTK's order: the corners of a quadrilateral, anticlockwise as seen
///        from the other one, then the corners of that
/// \param positions 3 · vertex_count numbers
ESPALIER_C_API espalier_status espalier_lattice_create_hexahedra(int32_t vertex_count,
                                                                 const double* positions,
                                                                 int32_t cell_count,
                                                                 const int32_t* vertices,
                                                                 espalier_lattice** lattice);

/// Reads a lattice in the format of its extension: .ovm, .vtu or .vtk, with marks (io/). Vertices
/// that no cell uses are dropped, and the vertices after them get lower numbers.
ESPALIER_C_API espalier_status espalier_lattice_read(const char* path, espalier_lattice** lattice);

/// Writes a lattice in the format of the extension, so that it reads back the same. A file that is
/// there is replaced when all is written.
ESPALIER_C_API espalier_status espalier_lattice_write(const espalier_lattice* lattice,
                                                      const char* path);

ESPALIER_C_API void espalier_lattice_destroy(espalier_lattice* lattice);

/// How many vertices, edges, faces and cells there are, in this order.
ESPALIER_C_API espalier_status espalier_lattice_counts(const espalier_lattice* lattice,
                                                       int32_t counts[4]);

/// \param positions 3 · *vertex_count numbers
ESPALIER_C_API espalier_status espalier_lattice_positions(const espalier_lattice* lattice,
                                                          int32_t* vertex_count,
                                                          const double** positions);

/// \param vertex_count that of the lattice
ESPALIER_C_API espalier_status espalier_lattice_set_positions(espalier_lattice* lattice,
                                                              int32_t vertex_count,
                                                              const double* positions);

/// A sharpness that no refinement uses up. Between 0 and this lies what is semi-sharp: it loses 1 a
/// level. 0 takes away the sharpness that an edge or a vertex would have by rule.
#define ESPALIER_SHARP 10.0

/// Marks edges: at ESPALIER_SHARP as sharp edges, below as creases (far/marks.h). Of two marks on
/// one edge the later counts. Refiners that are there do not change.
///
/// \param vertices the two ends of each edge, in any order
/// \param sharpness one an edge, 0 or more
/// \retval ESPALIER_ERROR_INPUT no such edge, or a negative sharpness; nothing is marked then
ESPALIER_C_API espalier_status espalier_lattice_mark_edges(espalier_lattice* lattice, int64_t count,
                                                           const int32_t* vertices,
                                                           const double* sharpness);

/// Marks vertices: at ESPALIER_SHARP as corners. As above.
ESPALIER_C_API espalier_status espalier_lattice_mark_vertices(espalier_lattice* lattice,
                                                              int64_t count,
                                                              const int32_t* vertices,
                                                              const double* sharpness);

/// Takes away all marks, those of its file too.
ESPALIER_C_API espalier_status espalier_lattice_clear_marks(espalier_lattice* lattice);

/// A number that is equal for lattices of the same cells on the same vertices, on every machine:
/// whether one can be a pose of the other. The order of cells and faces does not count.
ESPALIER_C_API espalier_status espalier_lattice_topology_hash(const espalier_lattice* lattice,
                                                              uint64_t* hash);

// ---- Refinement -----------------------------------------------------------------------------

/// Catmull-Clark's, in two editions of the rule for edges in the volume (stencils/masks.h); and
/// multilinear cell averaging, for which there are no smooth triangles (stencils/mlca.h).
enum { ESPALIER_RULES_SIGGRAPH96 = 0, ESPALIER_RULES_CSE96 = 1, ESPALIER_RULES_MLCA = 2 };

/// What happens at the boundary (far/strata.h).
enum {
    ESPALIER_BOUNDARY_SHARP = 0,      ///< corners, sharp edges and surfaces by their own rules
    ESPALIER_BOUNDARY_EDGE_ONLY = 1,  ///< the same without the corners of single cells
    ESPALIER_BOUNDARY_OPEN = 2        ///< none: the region shrinks, as of a uniform B-spline
};

/// Which boundary edges are sharp (far/strata.h).
enum {
    ESPALIER_SHARP_EDGES_SINGLE_CELL = 0,  ///< those in one cell
    ESPALIER_SHARP_EDGES_LITERAL = 1       ///< those between vertices of at most two cells each
};

/// How semi-sharp edges lose their sharpness (far/marks.h).
enum { ESPALIER_CREASING_UNIFORM = 0, ESPALIER_CREASING_CHAIKIN = 1 };

/// The weights of triangles on the surface (far/topology_refiner.h).
enum { ESPALIER_TRIANGLES_CATMARK = 0, ESPALIER_TRIANGLES_SMOOTH = 1 };

/// How a lattice is refined. Begin with espalier_default_refine_options(): later versions may add
/// fields, and `size` says which there are.
typedef struct espalier_refine_options {
    size_t size;          ///< of this struct: sizeof(espalier_refine_options)
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

/// The topology of a lattice and its levels: level 0 is the lattice itself, and level k has about 8
/// times the cells of level k − 1. No positions (far/topology_refiner.h).
typedef struct espalier_refiner espalier_refiner;

/// A refiner of the cells and the marks that the lattice has now; level 0 only.
///
/// \param options null for the defaults
/// \retval ESPALIER_ERROR_INPUT a mark that cannot be: smooth, where the topology makes a corner;
///         smooth triangles by the rules of MLCA
ESPALIER_C_API espalier_status espalier_refiner_create(const espalier_lattice* lattice,
                                                       const espalier_refine_options* options,
                                                       espalier_refiner** refiner);
ESPALIER_C_API void espalier_refiner_destroy(espalier_refiner* refiner);

/// Adds levels until there is this one; does nothing if there is. Arrays of levels that are there
/// stay valid. If it fails, the levels that were made before it did stay.
///
/// \retval ESPALIER_ERROR_INPUT more entities than an int32_t counts; or an open boundary, and
///         nothing left inside
/// \cost O(entities of the new levels)
ESPALIER_C_API espalier_status espalier_refiner_refine(espalier_refiner* refiner, int32_t level);

/// The finest level that is there.
ESPALIER_C_API espalier_status espalier_refiner_max_level(const espalier_refiner* refiner,
                                                          int32_t* level);

/// How many vertices, edges, faces and cells a level has, in this order.
ESPALIER_C_API espalier_status espalier_refiner_counts(const espalier_refiner* refiner,
                                                       int32_t level, int32_t counts[4]);

/// The cells, faces and vertices of a level, to draw it. Faces between two cells are there once;
/// all faces of level 1 and above are quadrilaterals. Vertices are numbered as rows of S_level.
///
/// \cost O(entities of the level) on the first call for it, then constant.
ESPALIER_C_API espalier_status espalier_refiner_cells(const espalier_refiner* refiner,
                                                      int32_t level, espalier_cells* cells);

/// How the faces lie in their cells.
///
/// \param signs one for each of `cell_faces` of the level: 1 where the vertices of the face go
///        round anticlockwise, seen from outside of the cell, and −1 where clockwise. A face
///        between two cells has both. What is outside follows from how most of the faces were given
ESPALIER_C_API espalier_status espalier_refiner_face_signs(const espalier_refiner* refiner,
                                                           int32_t level, const int8_t** signs);

/// Carries values on the vertices of the lattice, such as positions or texture coordinates, to
/// those of a level: R_level · ... · R_1 · values.
///
/// \param components numbers a vertex, 1 or more; 3 of positions
/// \param size components · vertices of level 0
/// \param result_size components · vertices of the level
/// \cost O(entries of the level tables). For many poses, make a table once.
ESPALIER_C_API espalier_status espalier_refiner_carry_values(const espalier_refiner* refiner,
                                                             int32_t level, int32_t components,
                                                             const double* values, int64_t size,
                                                             double* result, int64_t result_size);

// ---- Tables ---------------------------------------------------------------------------------

/// A sparse matrix of weights, immutable (stencils/stencil_table.h).
typedef struct espalier_table espalier_table;

/// Its numbers in compressed sparse rows, the form of SciPy, Eigen and MKL. Row r has the entries
/// offsets[r] to offsets[r + 1] − 1. Columns ascend and are unique in a row. Every row sums to 1,
/// or is empty: that of a point that is kept in place. Rows of derivatives sum to 0. (Tables that
/// were read are as their files.)
typedef struct espalier_csr {
    int32_t row_count;
    int32_t column_count;
    const int64_t* offsets;  ///< row_count + 1; offsets[0] is 0
    const int32_t* columns;  ///< offsets[row_count]
    const double* weights;   ///< offsets[row_count]
} espalier_csr;

/// S_level: vertices of the level × vertices of the lattice. Level 0 is the identity.
/// \cost O(products of entries); at most 64 entries a row in regular regions.
ESPALIER_C_API espalier_status espalier_table_create_stencils(const espalier_refiner* refiner,
                                                              int32_t level,
                                                              espalier_table** table);

/// R_level: vertices of the level × vertices of the level before. Level 1 or above.
ESPALIER_C_API espalier_status espalier_table_create_level(const espalier_refiner* refiner,
                                                           int32_t level, espalier_table** table);

/// Where the vertices of a level go in the limit: vertices of the level × vertices of the lattice
/// (limit/vertex_limits.h).
///
/// \retval ESPALIER_ERROR_INPUT no such level; rules or a boundary without a limit here
ESPALIER_C_API espalier_status espalier_table_create_limits(const espalier_refiner* refiner,
                                                            int32_t level, espalier_table** table);

/// The rows for places in the limit. Fill it by espalier_default_limit_stencil_options() first,
/// then change fields.
typedef struct espalier_limit_stencil_options {
    size_t size;          ///< of this struct: sizeof(espalier_limit_stencil_options)
    int32_t derivatives;  ///< 0, 1 or 2: up to which order; default 0
    double tolerance;     ///< how close rows come to the limit around irregular features, 1e-14 to
                          ///< 0.1 of the size of what surrounds a cell; default 1e-6
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

/// Positions in the limit, and derivatives there: places × vertices of the lattice
/// (limit/limit_stencils.h). Rows of positions sum to 1, rows of derivatives to 0.
///
/// A place is a hexahedron of the level, and (u, v, w) in it, each from 0 to 1. (0, 0, 0) is the
/// first vertex of the cell's first face (espalier_refiner_cells()). Where the sign of that face
/// (espalier_refiner_face_signs()) is -1, u goes to its second vertex, and v to its fourth; where
/// the sign is 1, u goes to the fourth and v to the second. w goes away from the face.
///
/// \param level one that is there
/// \param cells of the level, all hexahedra: one a place
/// \param uvw 3 · place_count numbers
/// \param options null for the defaults
/// \param table_count room for the tables: ESPALIER_LIMIT_STENCIL_TABLES(options->derivatives)
/// \param tables of positions; of first derivatives by u, v, w; of second ones by uu, uv, uw, vv,
///        vw, ww. The caller destroys each. If the function fails, no table is made
/// \retval ESPALIER_ERROR_INPUT no such level; a cell that is not there or no hexahedron; a place
///         outside of [0, 1]³, or on a cell that shrinks away; options out of range; rules without
///         a limit
/// \cost O(entries), and near irregular features about 0.2 ms for each level of refinement there
ESPALIER_C_API espalier_status espalier_table_create_limit_stencils(
    const espalier_refiner* refiner, int32_t level, int32_t place_count, const int32_t* cells,
    const double* uvw, const espalier_limit_stencil_options* options, int32_t table_count,
    espalier_table** tables);

ESPALIER_C_API void espalier_table_destroy(espalier_table* table);

/// Writes a table in the format of the extension (io/matrices/matrix_file.h): .mtx, .npz of SciPy,
/// .npy (three files), or .petsc.
ESPALIER_C_API espalier_status espalier_table_write(const espalier_table* table, const char* path);

/// Reads a table in the format of the extension: .mtx, .npz or .petsc. Rows need not sum to 1.
ESPALIER_C_API espalier_status espalier_table_read(const char* path, espalier_table** table);

/// The numbers of a table, without a copy.
ESPALIER_C_API espalier_status espalier_table_csr(const espalier_table* table, espalier_csr* csr);

// ---- Bindings -------------------------------------------------------------------------------

/// What becomes of a point outside the lattice.
enum {
    ESPALIER_OUTSIDE_KEEP = 0,     ///< it stays in place: its row of D is empty
    ESPALIER_OUTSIDE_NEAREST = 1,  ///< the nearest cell carries it, along the tangent of its map
    ESPALIER_OUTSIDE_REFUSE = 2    ///< binding fails
};

/// Where a point was found.
enum {
    ESPALIER_POINT_INSIDE = 0,
    ESPALIER_POINT_OUTSIDE = 1,
    ESPALIER_POINT_NOT_CONVERGED = 2  ///< in a degenerate cell, or not finite: kept in place
};

/// How points are bound. Fill it by espalier_default_bind_options() first, then change fields.
typedef struct espalier_bind_options {
    size_t size;       ///< of this struct: sizeof(espalier_bind_options)
    int32_t level;     ///< 1 to 20: whose cells hold the points; default 3
    int32_t outside;   ///< ESPALIER_OUTSIDE_...; default KEEP
    double tolerance;  ///< how far outside is still inside, as a fraction of the diagonal of the
                       ///< lattice's bounding box; default 1e-6
    double limit_tolerance;  ///< 0, the default: points are bound to the level. Above, 1e-14 to
                             ///< 0.1: to the limit volume, whatever the level, and so close to it
                             ///< (limit/limit_binding.h); 1e-6 is usual
} espalier_bind_options;

static inline espalier_bind_options espalier_default_bind_options(void) {
    espalier_bind_options options;
    options.size = sizeof options;
    options.level = 3;
    options.outside = ESPALIER_OUTSIDE_KEEP;
    options.tolerance = 1e-6;
    options.limit_tolerance = 0;
    return options;
}

/// Points frozen to a lattice: x' = D · p', but for the points that are kept in place. Immutable.
typedef struct espalier_binding espalier_binding;

/// Binds points to a level of a lattice (embed/local_binding.h), or to its limit. The level need
/// not be there: no more of the lattice is refined than the points ask for, and the refiner stays
/// as it is.
///
/// \param positions of the vertices of the lattice at rest, 3 · vertex_count numbers
/// \param points 3 · point_count numbers
/// \param options null for the defaults
/// \retval ESPALIER_ERROR_INPUT a position of the lattice that is not finite; under
///         ESPALIER_OUTSIDE_REFUSE a point that is not inside, of which the message names the
///         first; options that are out of range
/// \cost O(points · (level + log cells)), and memory for D: 64 entries a point in regular regions.
///
/// The limit costs about as much as level 5.
ESPALIER_C_API espalier_status espalier_binding_create(const espalier_refiner* refiner,
                                                       int32_t vertex_count,
                                                       const double* positions, int32_t point_count,
                                                       const double* points,
                                                       const espalier_bind_options* options,
                                                       espalier_binding** binding);

/// The basis functions by which a box lattice weighs its vertices without subdivision
/// (embed/basis_functions.h).
enum {
    ESPALIER_BASIS_BEZIER = 0,  ///< Bernstein polynomials over the whole lattice
    ESPALIER_BASIS_BSPLINE = 1  ///< uniform cubic B-splines
};

/// Binds points to a box lattice by products of basis functions, the free-form deformation that
/// came before lattices of any topology (embed/tensor_product.h).
///
/// \param lattice a box of hexahedra that lies on an evenly divided parallelepiped; without marks
/// \param basis ESPALIER_BASIS_...
/// \param points 3 · point_count numbers
/// \param options null for the defaults; `level` is not read, and limit_tolerance must be 0
/// \retval ESPALIER_ERROR_INPUT the lattice is no such box, has marks, or under
///         ESPALIER_BASIS_BSPLINE fewer than 3 cells along an axis; as espalier_binding_create()
/// \cost O(points · weights of a point): at most 64 of B-splines, all vertices of Bernstein
///       polynomials
ESPALIER_C_API espalier_status espalier_binding_create_tensor(const espalier_lattice* lattice,
                                                              int32_t basis, int32_t point_count,
                                                              const double* points,
                                                              const espalier_bind_options* options,
                                                              espalier_binding** binding);
ESPALIER_C_API void espalier_binding_destroy(espalier_binding* binding);

/// Writes a binding (.espb, io/binding_file.h), to the last bit. A file that is there is replaced
/// when all is written.
ESPALIER_C_API espalier_status espalier_binding_save(const espalier_binding* binding,
                                                     const char* path);

/// Reads a binding that this or `espalier bind` wrote. The model that the latter puts beside it is
/// written again by espalier_binding_save(), with the gradients of a binding to the limit, which
/// carry its normals; `espalier apply` wants a model.
ESPALIER_C_API espalier_status espalier_binding_load(const char* path, espalier_binding** binding);

/// D: points × vertices of the lattice. Also the Jacobian of the points by the vertices. The table
/// shares its numbers with the binding.
ESPALIER_C_API espalier_status espalier_binding_table(const espalier_binding* binding,
                                                      espalier_table** table);

/// The hash of the lattice that the points were bound to: see espalier_lattice_topology_hash().
ESPALIER_C_API espalier_status espalier_binding_topology_hash(const espalier_binding* binding,
                                                              uint64_t* hash);

/// ESPALIER_POINT_... of each point.
/// \retval ESPALIER_ERROR_INPUT the binding was loaded; a file does not have them
ESPALIER_C_API espalier_status espalier_binding_statuses(const espalier_binding* binding,
                                                         int32_t* point_count,
                                                         const uint8_t** statuses);

/// The largest distance of a point from where D puts it at rest, of those that are not kept.
/// \retval ESPALIER_ERROR_INPUT as above
ESPALIER_C_API espalier_status espalier_binding_largest_residual(const espalier_binding* binding,
                                                                 double* residual);

/// The points that are kept in place, ascending, and where: 3 · *count numbers.
ESPALIER_C_API espalier_status espalier_binding_kept(const espalier_binding* binding,
                                                     int32_t* count, const int32_t** points,
                                                     const double** positions);

/// The points for a pose of the lattice: D · p', and the kept points where they were. For many
/// poses an evaluator is faster.
///
/// \param vertex_count that of the lattice
/// \param pose positions of its vertices, 3 · vertex_count numbers
/// \param point_count as many as were bound
/// \param points 3 · point_count numbers are written
/// \cost O(entries of D).
ESPALIER_C_API espalier_status espalier_binding_apply(const espalier_binding* binding,
                                                      int32_t vertex_count, const double* pose,
                                                      int32_t point_count, double* points);

/// Carries points by a lattice, the child, that lies in another, the parent: D = D_child ·
/// D_parent, points × vertices of the parent (embed/nested_lattices.h). Nests go as deep as
/// wanted.
///
/// \param child D_child, points × vertices of the child
/// \param child_pose of the vertices of the child, where the parent is at rest: 3 ·
///        child_vertex_count numbers
/// \param parent_positions of the vertices of the parent at rest, 3 · parent_vertex_count numbers
/// \param options null for the defaults; limit_tolerance must be 0. Under ESPALIER_OUTSIDE_NEAREST
/// a
///        vertex of the child outside of the parent is taken along, and refused under any other
/// \retval ESPALIER_ERROR_INPUT sizes that do not match; a vertex of the child that is outside
/// \cost as espalier_binding_create() for the vertices of the child, and the product of tables.
ESPALIER_C_API espalier_status espalier_table_create_nested(
    const espalier_table* child, int32_t child_vertex_count, const double* child_pose,
    const espalier_refiner* parent, int32_t parent_vertex_count, const double* parent_positions,
    const espalier_bind_options* options, espalier_table** table);

// ---- Evaluators -----------------------------------------------------------------------------

/// How the values of an entry lie in a buffer: component c of entry i is at
/// offset + i · stride + c (osd/evaluation.h).
typedef struct espalier_buffer_layout {
    int64_t offset;  ///< of the first component of entry 0: 0 or more
    int64_t length;  ///< components an entry: 1 or more
    int64_t stride;  ///< from one entry to the next: `length` or more
} espalier_buffer_layout;

/// Entries of `length` components, one behind the other: 3 for x, y, z.
static inline espalier_buffer_layout espalier_packed_layout(int64_t length) {
    espalier_buffer_layout layout;
    layout.offset = 0;
    layout.length = length;
    layout.stride = length;
    return layout;
}

/// A table in the form that is fastest to apply, in double and in single precision; it shares
/// nothing with the table (osd/compiled_table.h, osd/compiled_adjoint.h). Immutable.
typedef struct espalier_evaluator_f64 espalier_evaluator_f64;
typedef struct espalier_evaluator_f32 espalier_evaluator_f32;

/// Applies a table: pose → points, where that is D.
/// \cost O(entries + rows log rows).
ESPALIER_C_API espalier_status espalier_evaluator_f64_create(const espalier_table* table,
                                                             espalier_evaluator_f64** evaluator);
ESPALIER_C_API espalier_status espalier_evaluator_f32_create(const espalier_table* table,
                                                             espalier_evaluator_f32** evaluator);

/// Applies the transpose of a table: its rows are the columns of the table, its columns the rows.
/// Of D it carries gradients by the points to gradients by the vertices of the lattice.
ESPALIER_C_API espalier_status espalier_evaluator_f64_create_adjoint(
    const espalier_table* table, espalier_evaluator_f64** evaluator);
ESPALIER_C_API espalier_status espalier_evaluator_f32_create_adjoint(
    const espalier_table* table, espalier_evaluator_f32** evaluator);

ESPALIER_C_API void espalier_evaluator_f64_destroy(espalier_evaluator_f64* evaluator);
ESPALIER_C_API void espalier_evaluator_f32_destroy(espalier_evaluator_f32* evaluator);

/// Memory that an evaluation takes besides what it is given, kept for the next one: an evaluation
/// allocates only if no earlier one with the same workspace needed as much. For one evaluation at a
/// time; threads that evaluate at once have one each.
///
/// In real time: evaluate once with a workspace beforehand, and then within an
/// espalier_executor_scope without `run`. That allocates nothing and takes no lock.
typedef struct espalier_workspace espalier_workspace;

/// One without memory yet.
ESPALIER_C_API espalier_status espalier_workspace_create(espalier_workspace** workspace);
ESPALIER_C_API void espalier_workspace_destroy(espalier_workspace* workspace);

/// For each row of first_row to last_row − 1
///
///     destination[row][c] = Σ_k weights(row)[k] · source[columns(row)[k]][c]
///
/// Entry i of the destination is row i, whatever the range; what lies between entries is not
/// touched. A row without entries gives 0: see espalier_binding_put_kept_f64(). Any number of
/// components goes through at once: several poses are several components.
///
/// \param source, destination buffers that do not overlap, with one entry a column and a row
/// \param source_size, destination_size numbers that each buffer holds
/// \param workspace null for memory that is allocated and freed by the call
/// \retval ESPALIER_ERROR_INPUT a layout without sense, layouts of different lengths, too small a
///         buffer, a range that is not in the table
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

/// Applies again what depends on a few columns of a table, and nothing else: while vertices of a
/// lattice are dragged, for example (osd/change_evaluator.h). Immutable.
typedef struct espalier_change_evaluator_f64 espalier_change_evaluator_f64;
typedef struct espalier_change_evaluator_f32 espalier_change_evaluator_f32;

/// \param evaluator one that applies a table, not an adjoint
/// \cost O(entries).
ESPALIER_C_API espalier_status espalier_change_evaluator_f64_create(
    const espalier_evaluator_f64* evaluator, espalier_change_evaluator_f64** changes);
ESPALIER_C_API espalier_status espalier_change_evaluator_f32_create(
    const espalier_evaluator_f32* evaluator, espalier_change_evaluator_f32** changes);

ESPALIER_C_API void espalier_change_evaluator_f64_destroy(espalier_change_evaluator_f64* changes);
ESPALIER_C_API void espalier_change_evaluator_f32_destroy(espalier_change_evaluator_f32* changes);

/// Applies the rows that depend on one of `changed`, with the result of an evaluation of the whole
/// table, bit for bit, and writes no others: kept points, too, stay as they were put.
///
/// \param changed columns of the table, in any order; vertices of the lattice, where it is D
/// \param source, ..., workspace as for the whole table
/// \retval ESPALIER_ERROR_INPUT as for the whole table; or a column that is not in it
/// \cost O(entries of these rows × components), and O(rows / 64).
ESPALIER_C_API espalier_status espalier_change_evaluator_f64_evaluate(
    const espalier_change_evaluator_f64* changes, const double* source, int64_t source_size,
    espalier_buffer_layout source_layout, double* destination, int64_t destination_size,
    espalier_buffer_layout destination_layout, int32_t changed_count, const int32_t* changed,
    espalier_workspace* workspace);
ESPALIER_C_API espalier_status espalier_change_evaluator_f32_evaluate(
    const espalier_change_evaluator_f32* changes, const float* source, int64_t source_size,
    espalier_buffer_layout source_layout, float* destination, int64_t destination_size,
    espalier_buffer_layout destination_layout, int32_t changed_count, const int32_t* changed,
    espalier_workspace* workspace);

/// Puts the kept points of a binding where they stay, after its table was applied; the others are
/// not touched.
///
/// \param destination entries of length 3, one a point; destination_size is in numbers
/// \cost O(kept points).
ESPALIER_C_API espalier_status espalier_binding_put_kept_f64(const espalier_binding* binding,
                                                             double* destination,
                                                             int64_t destination_size,
                                                             espalier_buffer_layout layout);
ESPALIER_C_API espalier_status espalier_binding_put_kept_f32(const espalier_binding* binding,
                                                             float* destination,
                                                             int64_t destination_size,
                                                             espalier_buffer_layout layout);

#ifdef __cplusplus
}
#endif

#endif
