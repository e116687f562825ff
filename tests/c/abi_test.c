/* SPDX-License-Identifier: Apache-2.0 */
/* Checks what is compiled into programs that use the headers: the values of constants, and the
 * offsets of fields in structs. None of these may change without a new SOVERSION. Constants, and
 * fields of options, may be added at the end. (symbols.txt lists the functions.) */

#include <assert.h>

#include "check.h"

static_assert(ESPALIER_OK == 0 && ESPALIER_ERROR_INPUT == 1 && ESPALIER_ERROR_FILE == 2 &&
                  ESPALIER_ERROR_MEMORY == 3 && ESPALIER_CANCELLED == 4 &&
                  ESPALIER_ERROR_INTERNAL == 5 && sizeof(espalier_status) == 4,
              "status");
static_assert(ESPALIER_RULES_SIGGRAPH96 == 0 && ESPALIER_RULES_CSE96 == 1 &&
                  ESPALIER_RULES_MLCA == 2,
              "rules");
static_assert(ESPALIER_BOUNDARY_SHARP == 0 && ESPALIER_BOUNDARY_EDGE_ONLY == 1 &&
                  ESPALIER_BOUNDARY_OPEN == 2,
              "boundary");
static_assert(ESPALIER_SHARP_EDGES_SINGLE_CELL == 0 && ESPALIER_SHARP_EDGES_LITERAL == 1,
              "sharp edges");
static_assert(ESPALIER_CREASING_UNIFORM == 0 && ESPALIER_CREASING_CHAIKIN == 1, "creasing");
static_assert(ESPALIER_TRIANGLES_CATMARK == 0 && ESPALIER_TRIANGLES_SMOOTH == 1, "triangles");
static_assert(ESPALIER_OUTSIDE_KEEP == 0 && ESPALIER_OUTSIDE_NEAREST == 1 &&
                  ESPALIER_OUTSIDE_REFUSE == 2,
              "outside");
static_assert(ESPALIER_SMOOTHING_NONE == 0 && ESPALIER_SMOOTHING_TIKHONOV == 1 &&
                  ESPALIER_SMOOTHING_LAPLACIAN == 2,
              "smoothing");
static_assert(ESPALIER_UNDETERMINED_SMALLEST == 0 && ESPALIER_UNDETERMINED_REFUSE == 1,
              "undetermined");
static_assert(ESPALIER_POINT_INSIDE == 0 && ESPALIER_POINT_OUTSIDE == 1 &&
                  ESPALIER_POINT_NOT_CONVERGED == 2 && ESPALIER_POINT_NOT_BOUND == 3,
              "points");

static_assert(ESPALIER_BASIS_BEZIER == 0 && ESPALIER_BASIS_BSPLINE == 1, "bases");
static_assert(ESPALIER_CONTINUITY_C0 == 0 && ESPALIER_CONTINUITY_C1 == 1 &&
                  ESPALIER_CONTINUITY_C2 == 2,
              "continuity");
static_assert(ESPALIER_CORE_WEDGES == 0 && ESPALIER_CORE_POLYGON == 1, "cores");
static_assert(ESPALIER_SECTION_GRID == 0 && ESPALIER_SECTION_DISK == 1, "sections");
static_assert(ESPALIER_SOLID_TETRAHEDRON == 0 && ESPALIER_SOLID_CUBE == 1 &&
                  ESPALIER_SOLID_OCTAHEDRON == 2 && ESPALIER_SOLID_DODECAHEDRON == 3 &&
                  ESPALIER_SOLID_ICOSAHEDRON == 4,
              "regular solids");
static_assert(ESPALIER_SOLID_PRISM == 0 && ESPALIER_SOLID_PYRAMID == 1 &&
                  ESPALIER_SOLID_BIPYRAMID == 2,
              "polygonal solids");

static_assert(ESPALIER_FALLOFF_LINEAR == 0 && ESPALIER_FALLOFF_SMOOTH == 1, "falloffs");

/* Fields follow each other, with no more padding than their alignment needs. */
#define IS_AT(type, field, place) static_assert(offsetof(type, field) == (place), #type "." #field)

IS_AT(espalier_refine_options, size, 0);
IS_AT(espalier_refine_options, rules, sizeof(size_t));
IS_AT(espalier_refine_options, boundary, sizeof(size_t) + 4);
IS_AT(espalier_refine_options, sharp_edges, sizeof(size_t) + 8);
IS_AT(espalier_refine_options, creasing, sizeof(size_t) + 12);
IS_AT(espalier_refine_options, triangles, sizeof(size_t) + 16);

IS_AT(espalier_bind_options, size, 0);
IS_AT(espalier_bind_options, level, sizeof(size_t));
IS_AT(espalier_bind_options, outside, sizeof(size_t) + 4);
IS_AT(espalier_bind_options, tolerance, sizeof(size_t) + 8);
IS_AT(espalier_bind_options, limit_tolerance, sizeof(size_t) + 16);
IS_AT(espalier_bind_options, gradients, sizeof(size_t) + 24);
IS_AT(espalier_bind_options, falloff, sizeof(espalier_bind_options) - 8);

IS_AT(espalier_fit_options, size, 0);
IS_AT(espalier_fit_options, smoothing, sizeof(size_t));
IS_AT(espalier_fit_options, undetermined, sizeof(size_t) + 4);
IS_AT(espalier_fit_options, strength, sizeof(size_t) + 8);
IS_AT(espalier_fit_options, frozen_count, sizeof(size_t) + 16);
IS_AT(espalier_fit_options, frozen, sizeof(size_t) + 24);
IS_AT(espalier_fit_options, move_held, sizeof(espalier_fit_options) - 8);
static_assert(sizeof(espalier_fit_quality) == 24, "espalier_fit_quality cannot grow");

IS_AT(espalier_pull_options, size, 0);
IS_AT(espalier_pull_options, frozen_count, 8);
IS_AT(espalier_pull_options, frozen, 16);
IS_AT(espalier_pull_options, max_iterations, sizeof(espalier_pull_options) - 16);
IS_AT(espalier_pull_options, move_held, sizeof(espalier_pull_options) - 8);

/* The first versions of options that have grown. A field that was added begins at their end or
 * after it: the padding at the end of a struct can hold anything. */
typedef struct {
    size_t size;
    int32_t smoothing, undetermined;
    double strength;
    int64_t frozen_count;
    const int32_t* frozen;
} first_fit_options;
static_assert(offsetof(espalier_fit_options, move_held) >= sizeof(first_fit_options), "fits");
typedef struct {
    size_t size;
    int64_t frozen_count;
    const int32_t* frozen;
    int64_t pin_count;
    const int32_t* pins;
    double reach, tolerance;
    int32_t max_iterations;
} first_pull_options;
static_assert(offsetof(espalier_pull_options, move_held) >= sizeof(first_pull_options), "pulls");

IS_AT(espalier_limit_stencil_options, size, 0);
IS_AT(espalier_limit_stencil_options, derivatives, sizeof(size_t));
IS_AT(espalier_limit_stencil_options, tolerance, sizeof(size_t) + 8);
static_assert(ESPALIER_LIMIT_STENCIL_TABLES(0) == 1 && ESPALIER_LIMIT_STENCIL_TABLES(1) == 4 &&
                  ESPALIER_LIMIT_STENCIL_TABLES(2) == 10,
              "tables of limit stencils");

IS_AT(espalier_validity_options, size, 0);
IS_AT(espalier_validity_options, level, sizeof(size_t));
IS_AT(espalier_validity_options, of_limit, sizeof(size_t) + 4);
IS_AT(espalier_pose_validity, smallest_cell, 4);
IS_AT(espalier_pose_validity, smallest_ratio, 8);
static_assert(sizeof(espalier_pose_validity) == 16, "espalier_pose_validity cannot grow");
IS_AT(espalier_largest_step, limiting_cell, 8);
IS_AT(espalier_largest_step, is_tight, 12);
static_assert(sizeof(espalier_largest_step) == 16, "espalier_largest_step cannot grow");

IS_AT(espalier_torus_options, size, 0);
IS_AT(espalier_torus_options, segments, sizeof(size_t));
IS_AT(espalier_torus_options, section, sizeof(size_t) + 4);
IS_AT(espalier_torus_options, grid_cells, sizeof(size_t) + 8);
IS_AT(espalier_torus_options, sides, sizeof(size_t) + 12);
IS_AT(espalier_torus_options, rings, sizeof(size_t) + 16);
IS_AT(espalier_torus_options, core, sizeof(size_t) + 20);
IS_AT(espalier_torus_options, major_radius, sizeof(size_t) + 24);
IS_AT(espalier_torus_options, minor_radius, sizeof(size_t) + 32);

IS_AT(espalier_star_options, size, 0);
IS_AT(espalier_star_options, points, sizeof(size_t));
IS_AT(espalier_star_options, rings, sizeof(size_t) + 4);
IS_AT(espalier_star_options, core, sizeof(size_t) + 8);
IS_AT(espalier_star_options, layers, sizeof(size_t) + 12);
IS_AT(espalier_star_options, inner_radius, sizeof(size_t) + 16);
IS_AT(espalier_star_options, outer_radius, sizeof(size_t) + 24);
IS_AT(espalier_star_options, height, sizeof(size_t) + 32);

IS_AT(espalier_barbell_options, size, 0);
IS_AT(espalier_barbell_options, end_segments, sizeof(size_t));
IS_AT(espalier_barbell_options, bar_segments, sizeof(size_t) + 4);
IS_AT(espalier_barbell_options, bar_across, sizeof(size_t) + 8);
IS_AT(espalier_barbell_options, rings, sizeof(size_t) + 12);
IS_AT(espalier_barbell_options, core, sizeof(size_t) + 16);
IS_AT(espalier_barbell_options, layers, sizeof(size_t) + 20);
IS_AT(espalier_barbell_options, end_radius, sizeof(size_t) + 24);
IS_AT(espalier_barbell_options, bar_length, sizeof(size_t) + 32);
IS_AT(espalier_barbell_options, bar_half_width, sizeof(size_t) + 40);
IS_AT(espalier_barbell_options, roundness, sizeof(size_t) + 48);
IS_AT(espalier_barbell_options, height, sizeof(size_t) + 56);

IS_AT(espalier_arm_options, size, 0);
IS_AT(espalier_arm_options, segments, sizeof(size_t));
IS_AT(espalier_arm_options, sides, sizeof(size_t) + 4);
IS_AT(espalier_arm_options, rings, sizeof(size_t) + 8);
IS_AT(espalier_arm_options, core, sizeof(size_t) + 12);
IS_AT(espalier_arm_options, joint_count, sizeof(size_t) + 16);
IS_AT(espalier_arm_options, joints, sizeof(size_t) + 24);
IS_AT(espalier_arm_joint, radius, 24);
IS_AT(espalier_arm_joint, twist, 32);
static_assert(sizeof(espalier_arm_joint) == 40, "espalier_arm_joint cannot grow");

IS_AT(espalier_falloff, profile, 0);
IS_AT(espalier_falloff, radius, 8);
static_assert(sizeof(espalier_falloff) == 16, "espalier_falloff cannot grow");
IS_AT(espalier_pose_options, size, 0);
IS_AT(espalier_pose_options, weights, sizeof(size_t));
IS_AT(espalier_pose_options, center, sizeof(size_t) + sizeof(void*));
IS_AT(espalier_pose_options, range, sizeof(size_t) + 2 * sizeof(void*));

IS_AT(espalier_cells, vertex_count, 0);
IS_AT(espalier_cells, face_count, 4);
IS_AT(espalier_cells, cell_count, 8);
IS_AT(espalier_cells, cell_offsets, 16); /* 12 bytes, and 4 of padding if pointers have 8 */
IS_AT(espalier_cells, cell_faces, 16 + sizeof(void*));
IS_AT(espalier_cells, face_offsets, 16 + 2 * sizeof(void*));
IS_AT(espalier_cells, face_vertices, 16 + 3 * sizeof(void*));
static_assert(sizeof(espalier_cells) == 16 + 4 * sizeof(void*), "espalier_cells cannot grow");

IS_AT(espalier_csr, row_count, 0);
IS_AT(espalier_csr, column_count, 4);
IS_AT(espalier_csr, offsets, 8);
IS_AT(espalier_csr, columns, 8 + sizeof(void*));
IS_AT(espalier_csr, weights, 8 + 2 * sizeof(void*));
static_assert(sizeof(espalier_csr) == 8 + 3 * sizeof(void*), "espalier_csr cannot grow");

IS_AT(espalier_buffer_layout, offset, 0);
IS_AT(espalier_buffer_layout, length, 8);
IS_AT(espalier_buffer_layout, stride, 16);
static_assert(sizeof(espalier_buffer_layout) == 24, "espalier_buffer_layout cannot grow");

int main(void) {
    char version[32];
    snprintf(version, sizeof version, "%d.%d.%d", ESPALIER_VERSION_MAJOR, ESPALIER_VERSION_MINOR,
             ESPALIER_VERSION_PATCH);
    CHECK(strcmp(espalier_version(), version) == 0);
    return 0;
}
