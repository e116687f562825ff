/* SPDX-License-Identifier: Apache-2.0 */
/* Calls every function with the extreme values of the types of its numbers. Each is accepted or
 * rejected, but nothing outside an array is read or written, and nothing ends the program.
 * symbols_test.py checks that no function with a number is missing here.
 *
 * The library cannot know how long an array is. So where an array is read to its end, counts
 * that exceed it but could be right are not tried. */

#include <float.h>
#include <limits.h>
#include <math.h>

#include "box.h"
#include "check.h"

#define COUNT(array) (sizeof(array) / sizeof((array)[0]))

static const int32_t int32s[] = {INT32_MIN, INT32_MIN + 1, -2,       -1, 0, 1, 2, 3, 25, 27,
                                 28,        INT32_MAX - 1, INT32_MAX};
/* Lengths of arrays. Each is rejected, since no memory holds that many numbers. */
static const int64_t lengths[] = {INT64_MIN,        INT64_MIN + 1,    -1,
                                  (int64_t)1 << 61, (int64_t)1 << 62, INT64_MAX / 3,
                                  INT64_MAX / 2,    INT64_MAX - 2,    INT64_MAX - 1,
                                  INT64_MAX};
static const int64_t int64s[] = {INT64_MIN,
                                 INT64_MIN + 1,
                                 -1,
                                 0,
                                 1,
                                 2,
                                 3,
                                 80,
                                 81,
                                 82,
                                 INT32_MAX,
                                 (int64_t)INT32_MAX + 1,
                                 UINT32_MAX,
                                 (int64_t)1 << 59,
                                 (int64_t)1 << 60,
                                 ((int64_t)1 << 61) - 1,
                                 (int64_t)1 << 62,
                                 INT64_MAX - 3,
                                 INT64_MAX - 2,
                                 INT64_MAX - 1,
                                 INT64_MAX};
static const double doubles[] = {NAN,     -INFINITY, INFINITY, -DBL_MAX, DBL_MAX, -1, -DBL_MIN, 0,
                                 DBL_MIN, 1e-300,    1e-14,    0.1,      1,       10, 1e300};

/* Counts that are right or nearly right are read before they are found to be wrong. */
#define MAX_COUNT 4096
static double positions[MAX_COUNT], values[MAX_COUNT];
static float singles[MAX_COUNT], single_results[MAX_COUNT];
static int32_t cells[MAX_COUNT];
static const double point[MAX_COUNT] = {0.5, 0.5, 0.5};
static const float single_point[MAX_COUNT] = {0.5f, 0.5f, 0.5f};
static espalier_lattice* lattice;
static espalier_refiner* refiner;
static espalier_binding* binding;
static espalier_table* table;

static int tried, accepted;

/* The object that a call made, until record() destroys it. */
static espalier_lattice* made_lattice;
static espalier_refiner* made_refiner;
static espalier_binding* made_binding;
static espalier_table* made_table;
static espalier_validity* made_validity;
static espalier_model* made_model;
static espalier_pull* made_pull;

/* Counts a call, and destroys the object that it made. */
static int record(espalier_status status) {
    espalier_lattice_destroy(made_lattice), made_lattice = NULL;
    espalier_pull_destroy(made_pull), made_pull = NULL;
    espalier_refiner_destroy(made_refiner), made_refiner = NULL;
    espalier_binding_destroy(made_binding), made_binding = NULL;
    espalier_table_destroy(made_table), made_table = NULL;
    espalier_validity_destroy(made_validity), made_validity = NULL;
    espalier_model_destroy(made_model), made_model = NULL;
    ++tried;
    CHECK(status == ESPALIER_OK || status == ESPALIER_ERROR_INPUT ||
          status == ESPALIER_ERROR_MEMORY);
    CHECK(status == ESPALIER_OK || strlen(espalier_last_error()) > 0);
    accepted += status == ESPALIER_OK;
    return status == ESPALIER_OK;
}

#define REFUSES(call) CHECK(!record(call))

static void set_up(void) {
    make_box(positions, cells);
    for (int i = 0; i < 3 * BOX_VERTICES; ++i) singles[i] = (float)positions[i];
    OK(espalier_lattice_create_hexahedra(BOX_VERTICES, positions, BOX_CELLS, cells, &lattice));
    OK(espalier_refiner_create(lattice, NULL, &refiner));
    OK(espalier_refiner_refine(refiner, 1));
    OK(espalier_binding_create(refiner, BOX_VERTICES, positions, 1, point, NULL, &binding));
    OK(espalier_binding_table(binding, &table));
}

static int32_t keep_going(void* user, const espalier_progress* progress) {
    (void)user;
    (void)progress;
    return 1;
}

static void test_host(void) {
    for (size_t i = 0; i < COUNT(int32s); ++i) {
        espalier_progress_scope* progress = NULL;
        CHECK(record(espalier_progress_scope_create(keep_going, NULL, int32s[i], &progress)) ==
              (int32s[i] >= 0));
        if (progress != NULL)
            OK(espalier_binding_apply(binding, BOX_VERTICES, positions, 1, values));
        espalier_progress_scope_destroy(progress);
        espalier_thread_limit* threads = NULL;
        CHECK(record(espalier_thread_limit_create(int32s[i], &threads)) == (int32s[i] >= 1));
        if (threads != NULL)
            OK(espalier_binding_apply(binding, BOX_VERTICES, positions, 1, values));
        espalier_thread_limit_destroy(threads);
    }
    for (size_t i = 0; i < COUNT(int64s); ++i) {
        espalier_memory_limit* memory = NULL;
        CHECK(record(espalier_memory_limit_create(int64s[i], &memory)) == (int64s[i] >= 1));
        espalier_memory_limit_destroy(memory);
    }
}

static void try_cells(const espalier_cells* c) {
    record(espalier_lattice_create(c, positions, &made_lattice));
}

static void test_cells(void) {
    int64_t cell_offsets[2] = {0, 4}, face_offsets[5] = {0, 3, 6, 9, 12};
    int32_t cell_faces[4] = {0, 1, 2, 3};
    int32_t tetrahedron[12] = {0, 2, 1, 0, 1, 3, 1, 2, 3, 2, 0, 3};
    const espalier_cells good = {4, 4, 1, cell_offsets, cell_faces, face_offsets, tetrahedron};
    try_cells(&good);
    CHECK(accepted > 0);
    for (int has_faces = 0; has_faces < 2; ++has_faces)
        for (size_t i = 0; i < COUNT(int64s); ++i) {
            espalier_cells c = good;
            if (!has_faces) c.cell_faces = NULL;
            for (int at = 0; at < 2; ++at) {
                const int64_t before = cell_offsets[at];
                cell_offsets[at] = int64s[i];
                try_cells(&c);
                cell_offsets[at] = before;
            }
            for (int at = 0; at < 5; ++at) {
                const int64_t before = face_offsets[at];
                face_offsets[at] = int64s[i];
                try_cells(&c);
                face_offsets[at] = before;
            }
        }
    for (size_t i = 0; i < COUNT(int32s); ++i) {
        espalier_cells c = good;
        c.vertex_count = int32s[i];
        try_cells(&c);
        c = good;
        if (int32s[i] <= 4) {
            c.face_count = int32s[i];
            try_cells(&c);
        }
        if (int32s[i] <= 1) {
            c = good;
            c.cell_count = int32s[i];
            try_cells(&c);
        }
        cell_faces[1] = int32s[i];
        try_cells(&good);
        cell_faces[1] = 1;
        tetrahedron[1] = int32s[i];
        try_cells(&good);
        tetrahedron[1] = 2;

        CHECK(record(espalier_lattice_create_hexahedra(int32s[i], positions, BOX_CELLS, cells,
                                                       &made_lattice)) ==
              (int32s[i] == BOX_VERTICES));
        if (int32s[i] < BOX_CELLS)
            REFUSES(espalier_lattice_create_hexahedra(BOX_VERTICES, positions, int32s[i], cells,
                                                      &made_lattice));
        cells[3] = int32s[i];
        record(espalier_lattice_create_hexahedra(BOX_VERTICES, positions, BOX_CELLS, cells,
                                                 &made_lattice));
        make_box(positions, cells);
    }
    for (size_t i = 0; i < COUNT(doubles); ++i) {
        positions[0] = doubles[i];
        record(espalier_lattice_create_hexahedra(BOX_VERTICES, positions, BOX_CELLS, cells,
                                                 &made_lattice));
    }
    make_box(positions, cells);
}

static void test_lattice(void) {
    espalier_lattice* own = NULL;
    OK(espalier_lattice_create_hexahedra(BOX_VERTICES, positions, BOX_CELLS, cells, &own));
    const double sharp = ESPALIER_SHARP;
    for (size_t i = 0; i < COUNT(int32s); ++i) {
        CHECK(record(espalier_lattice_set_positions(own, int32s[i], positions)) ==
              (int32s[i] == BOX_VERTICES));
        const int32_t ends[2] = {0, int32s[i]}, vertex = int32s[i];
        record(espalier_lattice_mark_edges(own, 1, ends, &sharp));
        record(espalier_lattice_mark_vertices(own, 1, &vertex, &sharp));
    }
    for (size_t i = 0; i < COUNT(lengths); ++i) {
        REFUSES(espalier_lattice_mark_edges(own, lengths[i], cells, &sharp));
        REFUSES(espalier_lattice_mark_vertices(own, lengths[i], cells, &sharp));
    }
    for (size_t i = 0; i < COUNT(doubles); ++i) {
        record(espalier_lattice_mark_edges(own, 1, cells, &doubles[i]));
        record(espalier_lattice_mark_vertices(own, 1, cells, &doubles[i]));
    }
    espalier_lattice_destroy(own);
}

static void test_refine_options(void) {
    const size_t sizes[] = {0,
                            1,
                            4,
                            sizeof(espalier_refine_options) - 1,
                            (size_t)1 << 31,
                            SIZE_MAX / 2,
                            SIZE_MAX - 1,
                            SIZE_MAX};
    for (size_t i = 0; i < COUNT(sizes); ++i) {
        espalier_refine_options options = espalier_default_refine_options();
        options.size = sizes[i];
        REFUSES(espalier_refiner_create(lattice, &options, &made_refiner));
    }
    for (size_t i = 0; i < COUNT(int32s); ++i)
        for (int field = 0; field < 5; ++field) {
            espalier_refine_options options = espalier_default_refine_options();
            *(&options.rules + field) = int32s[i];
            record(espalier_refiner_create(lattice, &options, &made_refiner));
        }
}

static void test_levels(void) {
    espalier_refiner* own = NULL;
    OK(espalier_refiner_create(lattice, NULL, &own));
    for (size_t i = 0; i < COUNT(int32s); ++i) {
        const int32_t level = int32s[i];
        CHECK(record(espalier_refiner_refine(own, level)) == (level >= 0 && level <= 3));
        int32_t counts[4];
        espalier_cells c;
        const int8_t* signs = NULL;
        const int is_there = level == 0 || level == 1;
        CHECK(record(espalier_refiner_counts(refiner, level, counts)) == is_there);
        CHECK(record(espalier_refiner_cells(refiner, level, &c)) == is_there);
        CHECK(record(espalier_refiner_face_signs(refiner, level, &signs)) == is_there);
        CHECK(record(espalier_table_create_stencils(refiner, level, &made_table)) == is_there);
        CHECK(record(espalier_table_create_limits(refiner, level, &made_table)) == is_there);
        CHECK(record(espalier_table_create_level(refiner, level, &made_table)) == (level == 1));
        record(espalier_refiner_carry_values(refiner, level, 3, positions, 81, values, 81));
        record(espalier_refiner_carry_values(refiner, 0, level, positions, 81, values, 81));
    }
    for (size_t i = 0; i < COUNT(int64s); ++i) {
        const int64_t size = int64s[i];
        CHECK(record(espalier_refiner_carry_values(refiner, 0, 3, positions, size, values, 81)) ==
              (size == 81));
        CHECK(record(espalier_refiner_carry_values(refiner, 0, 3, positions, 81, values, size)) ==
              (size == 81));
        for (size_t k = 0; k < COUNT(int32s); ++k)
            if (int32s[k] != 3)
                REFUSES(espalier_refiner_carry_values(refiner, 0, int32s[k], positions, size,
                                                      values, size));
    }
    espalier_refiner_destroy(own);
}

static void try_bind(const espalier_bind_options* options) {
    record(espalier_binding_create(refiner, BOX_VERTICES, positions, 1, point, options,
                                   &made_binding));
}

static void test_binding(void) {
    const size_t sizes[] = {0, 1, 4, 23, 40, 48, SIZE_MAX / 2, SIZE_MAX - 1, SIZE_MAX};
    for (size_t i = 0; i < COUNT(sizes); ++i) {
        espalier_bind_options options = espalier_default_bind_options();
        options.size = sizes[i];
        try_bind(&options);
    }
    espalier_binding* limit_binding = NULL;
    espalier_bind_options limit = espalier_default_bind_options();
    limit.limit_tolerance = 1e-6;
    limit.gradients = 1;
    OK(espalier_binding_create(refiner, BOX_VERTICES, positions, 1, point, &limit, &limit_binding));
    for (size_t i = 0; i < COUNT(int32s); ++i) {
        espalier_bind_options options = espalier_default_bind_options();
        options.level = int32s[i];
        try_bind(&options);
        options = espalier_default_bind_options();
        options.outside = int32s[i];
        try_bind(&options);
        options = espalier_default_bind_options();
        options.limit_tolerance = 1e-6;
        options.gradients = int32s[i];
        CHECK(record(espalier_binding_create(refiner, BOX_VERTICES, positions, 1, point, &options,
                                             &made_binding)) == (int32s[i] == 0 || int32s[i] == 1));

        CHECK(record(espalier_binding_create(refiner, int32s[i], positions, 1, point, NULL,
                                             &made_binding)) == (int32s[i] == BOX_VERTICES));
        if (int32s[i] <= 1) {
            CHECK(record(espalier_binding_create(refiner, BOX_VERTICES, positions, int32s[i], point,
                                                 NULL, &made_binding)) == (int32s[i] >= 0));
        }
        CHECK(record(espalier_binding_apply(binding, int32s[i], positions, 1, values)) ==
              (int32s[i] == BOX_VERTICES));
        CHECK(record(espalier_binding_apply(binding, BOX_VERTICES, positions, int32s[i], values)) ==
              (int32s[i] == 1));
        CHECK(record(espalier_binding_gradients(limit_binding, int32s[i], positions, 1, values)) ==
              (int32s[i] == BOX_VERTICES));
        CHECK(record(espalier_binding_gradients(limit_binding, BOX_VERTICES, positions, int32s[i],
                                                values)) == (int32s[i] == 1));
    }
    espalier_binding_destroy(limit_binding);
    for (size_t i = 0; i < COUNT(doubles); ++i) {
        espalier_bind_options options = espalier_default_bind_options();
        options.tolerance = doubles[i];
        try_bind(&options);
        options = espalier_default_bind_options();
        options.limit_tolerance = doubles[i];
        try_bind(&options);
        const double odd[3] = {0.5, doubles[i], 0.5};
        record(
            espalier_binding_create(refiner, BOX_VERTICES, positions, 1, odd, NULL, &made_binding));
    }
}

static void test_tensor(void) {
    for (size_t i = 0; i < COUNT(int32s); ++i) {
        record(espalier_binding_create_tensor(lattice, int32s[i], 1, point, NULL, &made_binding));
        if (int32s[i] <= 1) {
            CHECK(record(espalier_binding_create_tensor(lattice, 0, int32s[i], point, NULL,
                                                        &made_binding)) == (int32s[i] >= 0));
        }
    }
    for (size_t i = 0; i < COUNT(doubles); ++i) {
        const double odd[3] = {0.5, doubles[i], 0.5};
        espalier_bind_options options = espalier_default_bind_options();
        for (int32_t outside = 0; outside < 3; ++outside) {
            options.outside = outside;
            record(espalier_binding_create_tensor(lattice, 0, 1, odd, &options, &made_binding));
        }
        options.tolerance = doubles[i];
        record(espalier_binding_create_tensor(lattice, 0, 1, point, &options, &made_binding));
    }
}

static void test_shapes(void) {
    const double from[3] = {0, 0, 0}, to[3] = {1, 1, 1};
    for (size_t i = 0; i < COUNT(int32s); ++i)
        for (int k = 0; k < 3; ++k) {
            int32_t counts[3] = {3, 1, 1};
            counts[k] = int32s[i];
            record(espalier_lattice_create_box(counts, from, to, &made_lattice));
            record(
                espalier_lattice_create_cylinder(3, 1, int32s[i], 1, 1, from, to, &made_lattice));
            record(espalier_lattice_create_cylinder(counts[0], counts[1], 0, counts[2], 1, from, to,
                                                    &made_lattice));
        }
    const espalier_lattice* both[2] = {lattice, lattice};
    for (size_t i = 0; i < COUNT(doubles); ++i) {
        const double odd[3] = {doubles[i], 0, 0};
        const int32_t ones[3] = {1, 1, 1};
        record(espalier_lattice_create_box(ones, odd, to, &made_lattice));
        record(espalier_lattice_create_cylinder(3, 1, 0, 1, doubles[i], from, to, &made_lattice));
        record(espalier_lattice_create_merged(1, both, doubles[i], &made_lattice));
    }
    for (size_t i = 0; i < COUNT(lengths); ++i)
        REFUSES(espalier_lattice_create_merged(lengths[i], both, 1e-6, &made_lattice));
    REFUSES(espalier_lattice_create_merged(0, both, 1e-6, &made_lattice));
}

/* Tries a shape with options: each number with the extreme values of its type, and sizes of the
 * struct. `create` makes `l` from `options`; `field` is the first of `integers` fields of type
 * int32_t; `length` is the first of `reals` fields of type double. */
#define TRY_SHAPE(shape, create, field, integers, length, reals)                       \
    do {                                                                               \
        static const size_t sizes[] = {0, 1, 4, SIZE_MAX / 2, SIZE_MAX - 1, SIZE_MAX}; \
        espalier_##shape##_options options = espalier_default_##shape##_options();     \
        for (size_t i = 0; i < COUNT(sizes); ++i) {                                    \
            options.size = sizes[i];                                                   \
            REFUSES(create);                                                           \
        }                                                                              \
        for (int at = 0; at < (integers); ++at)                                        \
            for (size_t i = 0; i < COUNT(int32s); ++i) {                               \
                options = espalier_default_##shape##_options();                        \
                *(&options.field + at) = int32s[i];                                    \
                record(create);                                                        \
            }                                                                          \
        for (int at = 0; at < (reals); ++at)                                           \
            for (size_t i = 0; i < COUNT(doubles); ++i) {                              \
                options = espalier_default_##shape##_options();                        \
                *(&options.length + at) = doubles[i];                                  \
                record(create);                                                        \
            }                                                                          \
    } while (0)

static void test_inventory(void) {
    TRY_SHAPE(torus, espalier_lattice_create_torus(&options, &made_lattice), segments, 6,
              major_radius, 2);
    TRY_SHAPE(star, espalier_lattice_create_star(&options, &made_lattice), points, 4, inner_radius,
              3);
    TRY_SHAPE(barbell, espalier_lattice_create_barbell(&options, &made_lattice), end_segments, 6,
              end_radius, 5);
    static const double corners[6] = {0, 0, 0, 4, 2, 1};
    TRY_SHAPE(around, espalier_lattice_create_around(2, corners, &options, &made_lattice), cells[0],
              5, cell_size, 2);
    for (size_t i = 0; i < COUNT(lengths); ++i)
        REFUSES(espalier_lattice_create_around(lengths[i], corners, NULL, &made_lattice));
    for (size_t i = 0; i < COUNT(doubles); ++i) {
        const double odd[6] = {0, 0, 0, 4, 2, doubles[i]};
        record(espalier_lattice_create_around(2, odd, NULL, &made_lattice));
    }
    static const int32_t counts[3] = {2, 1, 1};
    static const double low[3] = {0, 0, 0}, high[3] = {2, 1, 1};
    espalier_lattice* base = NULL;
    OK(espalier_lattice_create_box(counts, low, high, &base));
    TRY_SHAPE(collar, espalier_lattice_create_collar(base, &options, &made_lattice), layers, 2,
              reach, 1);
    espalier_collar_options of_collar = espalier_default_collar_options();
    for (size_t i = 0; i < COUNT(doubles); ++i) {
        const double box[6] = {-1, -1, -1, 4, 4, doubles[i]};
        of_collar.until = box;
        record(espalier_lattice_create_collar(base, &of_collar, &made_lattice));
    }
    espalier_lattice_destroy(base);
    static const int64_t offsets[2] = {0, 3};
    static const int32_t triangle[3] = {0, 1, 2};
    /* Small, so that cells of the size 0.1 are few. */
    static const double corner_points[9] = {0, 0, 0, 0.4, 0, 0, 0, 0.2, 0.1};
    const espalier_polygons faces = {1, offsets, triangle};
    TRY_SHAPE(cage, espalier_lattice_create_cage(3, corner_points, &faces, &options, &made_lattice),
              vertices, 1, cell_size, 1);
    espalier_cage_options of_cage = espalier_default_cage_options();
    of_cage.vertices = 8; /* a wide margin takes long with many vertices */
    for (size_t i = 0; i < COUNT(doubles); ++i) {
        of_cage.margin = doubles[i];
        record(espalier_lattice_create_cage(3, corner_points, &faces, &of_cage, &made_lattice));
    }
    of_cage.margin = 0;
    for (size_t i = 0; i < COUNT(doubles); ++i) {
        of_cage.shell = doubles[i];
        record(espalier_lattice_create_cage(3, corner_points, &faces, &of_cage, &made_lattice));
    }
    for (size_t i = 0; i < COUNT(lengths); ++i) {
        const espalier_polygons wrong = {lengths[i], offsets, triangle};
        REFUSES(espalier_lattice_create_cage(3, corner_points, &wrong, NULL, &made_lattice));
    }
    TRY_SHAPE(arm, espalier_lattice_create_arm(&options, &made_lattice), segments, 4, up[0], 3);
    for (size_t i = 0; i < COUNT(lengths); ++i) {
        espalier_arm_options options = espalier_default_arm_options();
        options.joint_count = lengths[i];
        REFUSES(espalier_lattice_create_arm(&options, &made_lattice));
    }
    for (size_t i = 0; i < COUNT(doubles); ++i)
        for (int at = 0; at < 5; ++at) {
            espalier_arm_joint joints[2] = {{{0, 0, 0}, 1, 0}, {{2, 0, 0}, 1, 0}};
            espalier_arm_options options = espalier_default_arm_options();
            options.joints = joints;
            options.joint_count = 2;
            *(at < 3    ? &joints[1].position[at]
              : at == 3 ? &joints[1].radius
                        : &joints[1].twist) = doubles[i];
            record(espalier_lattice_create_arm(&options, &made_lattice));
        }
    for (size_t i = 0; i < COUNT(int32s); ++i)
        for (int at = 0; at < 3; ++at) {
            record(
                at == 0 ? espalier_lattice_create_regular_solid(int32s[i], 1, &made_lattice)
                : at == 1
                    ? espalier_lattice_create_polygonal_solid(int32s[i], 3, 1, 1, &made_lattice)
                    : espalier_lattice_create_polygonal_solid(0, int32s[i], 1, 1, &made_lattice));
        }
    for (size_t i = 0; i < COUNT(doubles); ++i)
        for (int at = 0; at < 3; ++at) {
            record(at == 0 ? espalier_lattice_create_regular_solid(0, doubles[i], &made_lattice)
                           : espalier_lattice_create_polygonal_solid(0, 3, at == 1 ? doubles[i] : 1,
                                                                     at == 2 ? doubles[i] : 1,
                                                                     &made_lattice));
        }
}

static void test_poses(void) {
    const double z[3] = {0, 0, 1}, x[3] = {1, 0, 0};
    const int32_t zero = 0;
    for (size_t i = 0; i < COUNT(int32s); ++i) {
        const int32_t n = int32s[i];
        const espalier_falloff falloff = {n, 1};
        record(espalier_select_ball(1, point, z, 1, &falloff, values));
        record(espalier_select_numbers(1, point, 1, &n, NULL, values));
        if (n != BOX_VERTICES) {
            REFUSES(espalier_lattice_read_pose(lattice, "none.obj", n, values));
            REFUSES(espalier_binding_read_pose(binding, "none.obj", n, values));
        }
        if (n > 27) continue;
        record(espalier_select_box(n, point, z, x, NULL, values));
        record(espalier_select_half_space(n, point, z, x, NULL, values));
        record(espalier_select_end(n, point, z, NULL, values));
        record(espalier_pose_move(n, point, z, NULL, values));
    }
    for (size_t i = 0; i < COUNT(lengths); ++i)
        REFUSES(espalier_select_numbers(1, point, lengths[i], &zero, NULL, values));
    for (size_t i = 0; i < COUNT(doubles); ++i) {
        const double d = doubles[i];
        const double odd[6] = {0, d, 0, 1, 1, 1}, range[2] = {0, d};
        const espalier_falloff falloff = {0, d};
        record(espalier_select_ball(2, odd, z, d, NULL, values));
        record(espalier_select_ball(1, point, z, 1, &falloff, values));
        record(espalier_select_box(1, point, odd, z, NULL, values));
        record(espalier_select_half_space(1, point, z, odd, NULL, values));
        record(espalier_select_end(1, point, odd, NULL, values));
        espalier_pose_options options = espalier_default_pose_options();
        for (int field = 0; field < 4; ++field) {
            options.center = field == 1 ? odd : NULL;
            options.weights = field == 2 ? odd : NULL;
            options.range = field == 3 ? range : NULL;
            record(espalier_pose_move(2, odd, odd, &options, values));
            record(espalier_pose_rotate(2, positions, odd, d, &options, values));
            record(espalier_pose_scale(2, positions, odd, &options, values));
            record(espalier_pose_twist(2, positions, z, d, &options, values));
            record(espalier_pose_bend(2, positions, x, d, odd, &options, values));
            record(espalier_pose_taper(2, positions, odd, d, &options, values));
        }
        record(espalier_pose_mirror(2, odd, positions, 0, &d, odd, values, NULL));
        record(espalier_pose_mirror(2, positions, odd, 2, NULL, NULL, values, NULL));
    }
    const size_t sizes[] = {0, 1, 4, SIZE_MAX / 2, SIZE_MAX - 1, SIZE_MAX};
    for (size_t i = 0; i < COUNT(sizes); ++i) {
        espalier_pose_options options = espalier_default_pose_options();
        options.size = sizes[i];
        REFUSES(espalier_pose_move(1, point, z, &options, values));
    }
}

static void test_selections_along_cells(void) {
    const int32_t zero = 0;
    const int32_t n = BOX_VERTICES;
    espalier_section section;
    int32_t face;
    for (size_t i = 0; i < COUNT(int32s); ++i) {
        const int32_t odd = int32s[i];
        const espalier_falloff falloff = {odd, 1};
        record(espalier_select_near(lattice, n, positions, point, 1, &falloff, values));
        record(espalier_select_beyond(lattice, n, positions, odd, NULL, values, &section));
        record(espalier_select_along_cells(lattice, n, positions, 1, &odd, NULL, values));
        record(espalier_selection_grow(lattice, n, odd, values));
        if (odd == n || odd > 28) continue;
        REFUSES(espalier_select_limb(lattice, odd, positions, point, NULL, values, &section));
        REFUSES(espalier_select_beyond(lattice, odd, positions, 0, NULL, values, NULL));
        REFUSES(espalier_nearest_inner_face(lattice, odd, positions, point, &face));
        REFUSES(espalier_select_near(lattice, odd, positions, point, 1, NULL, values));
        REFUSES(espalier_select_along_cells(lattice, odd, positions, 0, NULL, NULL, values));
        REFUSES(espalier_selection_grow(lattice, odd, 1, values));
        REFUSES(espalier_lattice_held_weights(lattice, odd, values));
        REFUSES(espalier_selection_border(lattice, odd, positions, values, &section));
    }
    for (size_t i = 0; i < COUNT(lengths); ++i)
        REFUSES(
            espalier_select_along_cells(lattice, n, positions, lengths[i], &zero, NULL, values));
    for (size_t i = 0; i < COUNT(doubles); ++i) {
        const double d = doubles[i], odd[3] = {0, d, 0};
        const espalier_falloff falloff = {0, d};
        record(espalier_select_limb(lattice, n, positions, odd, &falloff, values, &section));
        record(espalier_nearest_inner_face(lattice, n, positions, odd, &face));
        record(espalier_select_near(lattice, n, positions, odd, d, &falloff, values));
        values[0] = d;
        record(espalier_selection_border(lattice, n, positions, values, &section));
        record(espalier_selection_grow(lattice, n, 1, values));
        values[0] = 0;
    }
}

static void test_models(void) {
    static const char four[] =
        "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 2 3 4\nf 1 4 3\n";
    espalier_model* model = NULL;
    const double* points = NULL;
    int32_t count = 0;
    OK(espalier_model_read_bytes("four.obj", sizeof four - 1, four, &model));
    OK(espalier_model_points(model, &count, &points));
    espalier_sliding_points *sliding = NULL, *none = NULL;
    OK(espalier_sliding_points_create(model, 0, NULL, &none));
    for (size_t i = 0; i < COUNT(lengths); ++i) {
        if (lengths[i] < 0) /* AddressSanitizer ends the program for a size that no memory has */
            REFUSES(espalier_model_read_bytes("four.obj", lengths[i], four, &made_model));
        REFUSES(espalier_lattice_marks(lattice, lengths[i], NULL, NULL, 0, NULL, NULL));
        REFUSES(espalier_lattice_marks(lattice, 0, NULL, NULL, lengths[i], NULL, NULL));
    }
    for (size_t i = 0; i < COUNT(int32s); ++i) {
        const int32_t n = int32s[i];
        if (n == count) continue;
        double weights[4] = {0}, slopes[12] = {0};
        REFUSES(espalier_model_write(model, "none.obj", n, points, NULL));
        REFUSES(espalier_model_weights(model, NULL, 0, NULL, n, weights));
        if (n != 0) REFUSES(espalier_model_weights(model, NULL, n, NULL, count, weights));
        REFUSES(espalier_model_weight_slopes(model, n, weights, slopes));
        REFUSES(espalier_model_hold(model, 0, NULL, n, weights));
        if (n != 0) REFUSES(espalier_model_hold(model, n, NULL, count, weights));
        if (n != 0) REFUSES(espalier_sliding_points_create(model, n, NULL, &sliding));
        REFUSES(espalier_sliding_points_slide(none, n, slopes, NULL));
    }
    espalier_sliding_points_destroy(none);
    espalier_model_destroy(model);
}

static void test_editing(void) {
    int32_t count = 0;
    const int32_t* ends = NULL;
    const uint8_t* strata = NULL;
    for (size_t i = 0; i < COUNT(int32s); ++i) {
        const int32_t n = int32s[i];
        record(espalier_refiner_edges(refiner, n, &count, &ends));
        record(espalier_refiner_strata(refiner, n, 0, &count, &strata));
        record(espalier_refiner_strata(refiner, 0, n, &count, &strata));
        record(espalier_lattice_create_with_prism(lattice, n, point, &made_lattice));
        record(espalier_lattice_create_with_pyramid(lattice, n, point, &made_lattice));
        record(espalier_lattice_create_without_cells(lattice, 1, &n, &made_lattice));
        if (n <= 8) record(espalier_lattice_create_without_cells(lattice, n, cells, &made_lattice));
    }
    for (size_t i = 0; i < COUNT(doubles); ++i) {
        const double odd[3] = {0, 0, doubles[i]};
        record(espalier_lattice_create_with_prism(lattice, 0, odd, &made_lattice));
        record(espalier_lattice_create_with_pyramid(lattice, 0, odd, &made_lattice));
    }
}

static void test_nested(void) {
    for (int k = 0; k < 5; ++k)
        for (size_t i = 0; i < COUNT(int32s); ++i) {
            espalier_bind_options options = espalier_default_bind_options();
            int32_t child = BOX_VERTICES, parent = BOX_VERTICES;
            *(k == 0   ? &child
              : k == 1 ? &parent
              : k == 2 ? &options.level
                       : &options.outside) = int32s[i];
            if (k == 4) options.tolerance = doubles[i % COUNT(doubles)];
            record(espalier_table_create_nested(table, child, positions, refiner, parent, positions,
                                                &options, &made_table));
        }
}

static void try_fit(int32_t targets, const int32_t* rows, const espalier_fit_options* options,
                    int32_t vertices) {
    static const double miss[MAX_COUNT] = {0.1, 0, 0};
    record(
        espalier_lattice_fit(table, lattice, targets, rows, miss, options, vertices, values, NULL));
}

static void test_fit(void) {
    const int32_t frozen[1] = {0};
    for (size_t i = 0; i < COUNT(int32s); ++i) {
        const int32_t row = int32s[i];
        espalier_fit_options options = espalier_default_fit_options();
        try_fit(1, NULL, NULL, int32s[i]);
        try_fit(int32s[i], NULL, NULL, BOX_VERTICES);
        if (row <= 1) try_fit(row, frozen, NULL, BOX_VERTICES);
        try_fit(1, &row, NULL, BOX_VERTICES);
        options.smoothing = int32s[i];
        try_fit(1, NULL, &options, BOX_VERTICES);
        options = espalier_default_fit_options();
        options.undetermined = int32s[i];
        try_fit(1, NULL, &options, BOX_VERTICES);
        options = espalier_default_fit_options();
        options.frozen = &row;
        options.frozen_count = 1;
        try_fit(1, NULL, &options, BOX_VERTICES);
    }
    for (size_t i = 0; i < COUNT(lengths); ++i) {
        espalier_fit_options options = espalier_default_fit_options();
        options.frozen = frozen;
        options.frozen_count = lengths[i];
        try_fit(1, NULL, &options, BOX_VERTICES);
    }
    for (size_t i = 0; i < COUNT(doubles); ++i) {
        espalier_fit_options options = espalier_default_fit_options();
        options.smoothing = ESPALIER_SMOOTHING_LAPLACIAN;
        options.strength = doubles[i];
        try_fit(1, NULL, &options, BOX_VERTICES);
    }
}

/* The arguments of the functions with layouts. */
typedef struct buffers {
    int64_t source_size;
    espalier_buffer_layout source;
    int64_t destination_size;
    espalier_buffer_layout destination;
    int32_t first, last;
} buffers;

/* Evaluators of a table of 1 row and 27 columns, and of its adjoint. */
static espalier_evaluator_f64 *f64, *adjoint_f64;
static espalier_evaluator_f32 *f32, *adjoint_f32;
static espalier_deformer_f64* deformer_f64; /* of 1 point and 27 vertices */
static espalier_deformer_f32* deformer_f32;
/* Evaluators of a binding of no points, which read or write no number of the points. */
static espalier_evaluator_f64 *empty_f64, *empty_adjoint_f64;
static espalier_binding* empty;

static void set_up_evaluators(void) {
    espalier_table* own = NULL;
    OK(espalier_evaluator_f64_create(table, &f64));
    OK(espalier_evaluator_f32_create(table, &f32));
    OK(espalier_evaluator_f64_create_adjoint(table, &adjoint_f64));
    OK(espalier_evaluator_f32_create_adjoint(table, &adjoint_f32));
    OK(espalier_deformer_f64_create(binding, &deformer_f64));
    OK(espalier_deformer_f32_create(binding, &deformer_f32));
    OK(espalier_binding_create(refiner, BOX_VERTICES, positions, 0, NULL, NULL, &empty));
    OK(espalier_binding_table(empty, &own));
    OK(espalier_evaluator_f64_create(own, &empty_f64));
    OK(espalier_evaluator_f64_create_adjoint(own, &empty_adjoint_f64));
    espalier_table_destroy(own);
}

static void evaluate_all(const buffers* b, const buffers* a) {
    record(espalier_evaluator_f64_evaluate(f64, positions, b->source_size, b->source, values,
                                           b->destination_size, b->destination, b->first, b->last,
                                           NULL));
    record(espalier_evaluator_f32_evaluate(f32, singles, b->source_size, b->source, single_results,
                                           b->destination_size, b->destination, b->first, b->last,
                                           NULL));
    record(espalier_evaluator_f64_evaluate(adjoint_f64, positions, a->source_size, a->source,
                                           values, a->destination_size, a->destination, a->first,
                                           a->last, NULL));
    record(espalier_evaluator_f32_evaluate(adjoint_f32, singles, a->source_size, a->source,
                                           single_results, a->destination_size, a->destination,
                                           a->first, a->last, NULL));
    record(espalier_evaluator_f64_evaluate(empty_f64, positions, b->source_size, b->source, values,
                                           b->destination_size, b->destination, 0, 0, NULL));
    record(espalier_evaluator_f64_evaluate(empty_adjoint_f64, positions, a->source_size, a->source,
                                           values, a->destination_size, a->destination, a->first,
                                           a->last, NULL));
}

static void test_hold(void) {
    static int32_t held[MAX_COUNT];
    int32_t count = 0;
    const int32_t zero = 0;
    for (size_t i = 0; i < COUNT(int32s); ++i) {
        const int32_t n = int32s[i];
        record(espalier_hold_faces(refiner, 1, &n, 1, BOX_VERTICES, held, &count));
        record(espalier_hold_faces(refiner, 1, &zero, n, BOX_VERTICES, held, &count));
        CHECK(record(espalier_hold_faces(refiner, 1, &zero, 1, n, held, &count)) ==
              (n == BOX_VERTICES));
        if (n <= 1) record(espalier_hold_faces(refiner, n, &zero, 1, BOX_VERTICES, held, &count));
        CHECK(record(espalier_hold_points(refiner, n, positions, 1, point, 1, NULL, held,
                                          &count)) == (n == BOX_VERTICES));
        if (n <= 1)
            record(espalier_hold_points(refiner, BOX_VERTICES, positions, n, point, 1, NULL, held,
                                        &count));
        record(espalier_hold_points(refiner, BOX_VERTICES, positions, 1, point, n, NULL, held,
                                    &count));
        espalier_bind_options options = espalier_default_bind_options();
        options.level = n;
        record(espalier_hold_points(refiner, BOX_VERTICES, positions, 1, point, 1, &options, held,
                                    &count));
        CHECK(record(espalier_hold_rows(table, 1, &n, BOX_VERTICES, held, &count)) == (n == 0));
        CHECK(record(espalier_hold_rows(table, 1, NULL, n, held, &count)) == (n == BOX_VERTICES));
        CHECK(record(espalier_hold_rows(table, n, NULL, BOX_VERTICES, held, &count)) == (n == 1));
    }
    for (size_t i = 0; i < COUNT(doubles); ++i) {
        const double odd[3] = {0.5, doubles[i], 0.5};
        record(
            espalier_hold_points(refiner, BOX_VERTICES, positions, 1, odd, 1, NULL, held, &count));
    }
}

static void test_validity(void) {
    espalier_validity* own = NULL;
    espalier_pose_validity result;
    espalier_largest_step step;
    static double ratios[MAX_COUNT];
    int32_t base;
    espalier_validity_options options = espalier_default_validity_options();
    options.level = 1;
    OK(espalier_validity_create(refiner, BOX_VERTICES, positions, &options, &own));
    for (size_t i = 0; i < COUNT(int32s); ++i) {
        const int32_t n = int32s[i];
        CHECK(record(espalier_validity_create(refiner, n, positions, &options, &made_validity)) ==
              (n == BOX_VERTICES));
        for (int32_t limit = 0; limit < 2; ++limit) {
            espalier_validity_options odd = {sizeof odd, n, limit};
            record(
                espalier_validity_create(refiner, BOX_VERTICES, positions, &odd, &made_validity));
        }
        espalier_validity_options odd = {sizeof odd, 1, n};
        CHECK(record(espalier_validity_create(refiner, BOX_VERTICES, positions, &odd,
                                              &made_validity)) == (n == 0 || n == 1));
        CHECK(record(espalier_validity_base_cell(own, n, &base)) == (n >= 0 && n < 8 * BOX_CELLS));
        CHECK(record(espalier_validity_check(own, n, positions, 64, ratios, &result)) ==
              (n == BOX_VERTICES));
        REFUSES(espalier_validity_check(own, BOX_VERTICES, positions, n, ratios, &result));
        CHECK(record(espalier_validity_largest_step(own, n, positions, 1, &step)) ==
              (n == BOX_VERTICES));
    }
    for (size_t i = 0; i < COUNT(doubles); ++i) {
        record(espalier_validity_largest_step(own, BOX_VERTICES, positions, doubles[i], &step));
        memcpy(values, positions, sizeof values);
        values[5] = doubles[i];
        record(espalier_validity_largest_step(own, BOX_VERTICES, values, 1, &step));
        record(espalier_validity_check(own, BOX_VERTICES, values, 64, ratios, &result));
        record(espalier_validity_create(refiner, BOX_VERTICES, values, &options, &made_validity));
    }
    espalier_validity_destroy(own);
}

static void try_limit_stencils(int32_t level, int32_t count, int32_t cell, double u,
                               int32_t derivatives, double tolerance, int32_t table_count) {
    espalier_table* tables[10] = {NULL};
    const double uvw[3] = {u, 0.5, 0.5};
    espalier_limit_stencil_options options = espalier_default_limit_stencil_options();
    options.derivatives = derivatives;
    options.tolerance = tolerance;
    const int made = record(espalier_table_create_limit_stencils(refiner, level, count, &cell, uvw,
                                                                 &options, table_count, tables));
    for (int t = 0; t < 10; ++t) {
        CHECK((tables[t] != NULL) == (made && t < table_count));
        espalier_table_destroy(tables[t]);
    }
}

static void try_pull(int32_t vertices, int32_t points, const int32_t* rows,
                     const espalier_pull_options* options) {
    record(espalier_pull_create(lattice, vertices, positions, table, points, rows, options,
                                &made_pull));
}

static void test_pull(void) {
    const int32_t zero = 0;
    const int32_t n = BOX_VERTICES;
    espalier_pull* pull = NULL;
    OK(espalier_pull_create(lattice, n, positions, table, 1, NULL, NULL, &pull));
    const int32_t* fixed;
    int32_t count;
    OK(espalier_pull_fixed(pull, &count, &fixed));
    for (size_t i = 0; i < COUNT(int32s); ++i) {
        const int32_t odd = int32s[i];
        espalier_pull_options options = espalier_default_pull_options();
        try_pull(odd, 1, NULL, NULL);
        try_pull(n, odd, NULL, NULL);
        if (odd <= 1) try_pull(n, odd, &zero, NULL);
        try_pull(n, 1, &odd, NULL);
        options.frozen = &odd;
        options.frozen_count = 1;
        try_pull(n, 1, NULL, &options);
        options = espalier_default_pull_options();
        options.pins = &odd;
        options.pin_count = 1;
        try_pull(n, 1, NULL, &options);
        options = espalier_default_pull_options();
        options.max_iterations = odd;
        try_pull(n, 1, NULL, &options);
        if (odd <= 28) record(espalier_pull_solve(pull, odd, point, n, NULL, values, NULL));
        record(espalier_pull_solve(pull, 1, point, odd, NULL, values, NULL));
    }
    for (size_t i = 0; i < COUNT(lengths); ++i)
        for (int field = 0; field < 2; ++field) {
            espalier_pull_options options = espalier_default_pull_options();
            options.frozen = options.pins = &zero;
            *(field == 0 ? &options.frozen_count : &options.pin_count) = lengths[i];
            try_pull(n, 1, NULL, &options);
        }
    for (size_t i = 0; i < COUNT(doubles); ++i) {
        const double odd[3] = {0, doubles[i], 0};
        espalier_pull_options options = espalier_default_pull_options();
        options.reach = doubles[i];
        try_pull(n, 1, NULL, &options);
        options = espalier_default_pull_options();
        options.tolerance = doubles[i];
        try_pull(n, 1, NULL, &options);
        record(espalier_pull_solve(pull, 1, odd, n, NULL, values, NULL));
    }
    espalier_pull_options options = espalier_default_pull_options();
    options.size = 1;
    REFUSES(espalier_pull_create(lattice, n, positions, table, 1, NULL, &options, &made_pull));
    espalier_pull_destroy(pull);
}

static void test_limit_stencils(void) {
    for (size_t i = 0; i < COUNT(int32s); ++i) {
        const int32_t n = int32s[i];
        try_limit_stencils(n, 1, 0, 0.5, 0, 1e-6, 1);
        if (n <= 1) try_limit_stencils(0, n, 0, 0.5, 1, 1e-6, 4);
        try_limit_stencils(0, 1, n, 0.5, 2, 1e-6, 10);
        try_limit_stencils(0, 1, 0, 0.5, n, 1e-6, 10);
        try_limit_stencils(0, 1, 0, 0.5, 0, 1e-6, n);
    }
    for (size_t i = 0; i < COUNT(doubles); ++i) {
        try_limit_stencils(0, 1, 0, doubles[i], 2, 1e-6, 10);
        try_limit_stencils(0, 1, 0, 0.5, 2, doubles[i], 10);
    }
}

static void test_evaluators(void) {
    const espalier_buffer_layout xyz = espalier_packed_layout(3);
    const buffers good = {81, xyz, 3, xyz, 0, 1}, adjoint = {3, xyz, 81, xyz, 0, BOX_VERTICES};
    const int before = accepted;
    evaluate_all(&good, &adjoint);
    CHECK(accepted == before + 6);
    for (size_t i = 0; i < COUNT(int64s); ++i) {
        buffers b = good, a = adjoint;
        /* A size beyond the array is wrong, but harmless: only what the layout covers is
         * accessed. */
        b.source_size = a.source_size = int64s[i];
        evaluate_all(&b, &a);
        b = good, a = adjoint;
        b.destination_size = a.destination_size = int64s[i];
        evaluate_all(&b, &a);
        for (size_t k = 0; k < COUNT(int64s); ++k)
            for (int field = 0; field < 9; ++field) {
                espalier_buffer_layout layout = xyz;
                if (field / 3 == 0) layout.offset = int64s[i], layout.stride = int64s[k];
                if (field / 3 == 1) layout.length = int64s[i], layout.stride = int64s[k];
                if (field / 3 == 2) layout.offset = int64s[i], layout.length = int64s[k];
                b = good, a = adjoint;
                if (field % 3 != 1) b.source = a.source = layout;
                if (field % 3 != 0) b.destination = a.destination = layout;
                evaluate_all(&b, &a);
                b.source_size = b.destination_size = a.source_size = a.destination_size = 0;
                evaluate_all(&b, &a);
            }
    }
    for (size_t i = 0; i < COUNT(int32s); ++i)
        for (size_t k = 0; k < COUNT(int32s); ++k) {
            buffers b = good, a = adjoint;
            b.first = a.first = int32s[i];
            b.last = a.last = int32s[k];
            evaluate_all(&b, &a);
        }
}

static void test_deformers(void) {
    const int32_t one = BOX_CENTRE;
    for (size_t i = 0; i < COUNT(int64s); ++i)
        for (size_t k = 0; k < COUNT(int64s) + 2; ++k) {
            /* The two right sizes are among them. */
            const int64_t poses = k == COUNT(int64s) ? 81 : int64s[i];
            const int64_t moved = k < COUNT(int64s) ? int64s[k] : 3;
            const int is_right = poses == 81 && moved == 3, is_none = poses == 0 && moved == 0;
            CHECK(record(espalier_deformer_f64_deform(deformer_f64, positions, poses, values,
                                                      moved)) == (is_right || is_none));
            CHECK(record(espalier_deformer_f32_deform(deformer_f32, singles, poses, single_results,
                                                      moved)) == (is_right || is_none));
            CHECK(record(espalier_deformer_f64_deform_changed(deformer_f64, positions, poses, 1,
                                                              &one, values, moved)) == is_right);
            CHECK(record(espalier_deformer_f32_deform_changed(deformer_f32, singles, poses, 1, &one,
                                                              single_results, moved)) == is_right);
        }
    for (size_t i = 0; i < COUNT(int32s); ++i) {
        const int32_t vertex = int32s[i];
        const int is_vertex = vertex >= 0 && vertex < BOX_VERTICES;
        CHECK(record(espalier_deformer_f64_deform_changed(deformer_f64, positions, 81, 1, &vertex,
                                                          values, 3)) == is_vertex);
        CHECK(record(espalier_deformer_f32_deform_changed(deformer_f32, singles, 81, 1, &vertex,
                                                          single_results, 3)) == is_vertex);
        if (vertex > 1) continue;
        CHECK(record(espalier_deformer_f64_deform_changed(deformer_f64, positions, 81, vertex,
                                                          cells, values, 3)) == (vertex >= 0));
        CHECK(record(espalier_deformer_f32_deform_changed(deformer_f32, singles, 81, vertex, cells,
                                                          single_results, 3)) == (vertex >= 0));
    }
}

int main(void) {
    espalier_memory_limit* limit = NULL;
    set_up();
    set_up_evaluators();
    test_host();
    test_cells();
    /* Levels that need more memory than the machine has. */
    OK(espalier_memory_limit_create((int64_t)1 << 30, &limit));
    test_levels();
    test_lattice();
    test_refine_options();
    test_binding();
    test_tensor();
    test_shapes();
    test_inventory();
    test_poses();
    test_selections_along_cells();
    test_models();
    test_editing();
    test_nested();
    test_fit();
    test_pull();
    test_limit_stencils();
    test_hold();
    test_validity();
    test_evaluators();
    test_deformers();
    printf("%d calls, %d accepted\n", tried, accepted);

    espalier_memory_limit_destroy(limit);
    espalier_evaluator_f64_destroy(f64);
    espalier_evaluator_f64_destroy(adjoint_f64);
    espalier_evaluator_f64_destroy(empty_f64);
    espalier_evaluator_f64_destroy(empty_adjoint_f64);
    espalier_evaluator_f32_destroy(f32);
    espalier_evaluator_f32_destroy(adjoint_f32);
    espalier_deformer_f64_destroy(deformer_f64);
    espalier_deformer_f32_destroy(deformer_f32);
    espalier_binding_destroy(empty);
    espalier_table_destroy(table);
    espalier_binding_destroy(binding);
    espalier_refiner_destroy(refiner);
    espalier_lattice_destroy(lattice);
    return 0;
}
