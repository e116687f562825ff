/* SPDX-License-Identifier: Apache-2.0 */
/* Tests the inventory with options, and lattices of a single cell. */

#include <math.h>

#include "check.h"

/* Checks the numbers of vertices and cells of a lattice, and destroys it. */
static void check_counts(espalier_lattice** lattice, int32_t vertices, int32_t cells) {
    int32_t counts[4];
    OK(espalier_lattice_counts(*lattice, counts));
    CHECK(counts[0] == vertices && counts[3] == cells);
    espalier_lattice_destroy(*lattice);
    *lattice = NULL;
}

/* Returns the largest coordinate along an axis. */
static double largest(const espalier_lattice* lattice, int axis) {
    int32_t count = 0;
    const double* positions = NULL;
    double most = -INFINITY;
    OK(espalier_lattice_positions(lattice, &count, &positions));
    for (int32_t v = 0; v < count; ++v) most = fmax(most, positions[3 * v + axis]);
    return most;
}

static void test_torus(void) {
    espalier_lattice* l = NULL;
    OK(espalier_lattice_create_torus(NULL, &l));
    check_counts(&l, 8 * 4, 8);
    espalier_torus_options options = espalier_default_torus_options();
    options.section = ESPALIER_SECTION_DISK;
    options.segments = 5;
    options.sides = 7;
    OK(espalier_lattice_create_torus(&options, &l));
    check_counts(&l, 5 * 8, 5 * 7); /* a vertex in the middle, with wedges around it */
    options.core = ESPALIER_CORE_POLYGON;
    options.rings = 2;
    OK(espalier_lattice_create_torus(&options, &l));
    check_counts(&l, 5 * 14, 5 * 8);
    options = espalier_default_torus_options();
    options.grid_cells = 3;
    options.major_radius = 2;
    options.minor_radius = 0.5;
    OK(espalier_lattice_create_torus(&options, &l));
    CHECK(fabs(largest(l, 0) - 2.5) < 1e-12 && fabs(largest(l, 2) - 0.5) < 1e-12);
    check_counts(&l, 8 * 16, 8 * 9);
    options.minor_radius = 3;
    REFUSED(espalier_lattice_create_torus(&options, &l), ESPALIER_ERROR_INPUT,
            "torus: minor_radius: expected a number below major_radius (2), got 3");
    options = espalier_default_torus_options();
    options.section = 2;
    INVALID(espalier_lattice_create_torus(&options, &l), "section: expected 0 to 1, got 2");
    options = espalier_default_torus_options();
    options.core = -1;
    INVALID(espalier_lattice_create_torus(&options, &l), "core: expected 0 to 1, got -1");
    options.size = 4;
    INVALID(espalier_lattice_create_torus(&options, &l), "espalier_default_torus_options()");
    INVALID(espalier_lattice_create_torus(NULL, NULL), "lattice is null");
    CHECK(l == NULL);
}

static void test_star(void) {
    espalier_lattice* l = NULL;
    OK(espalier_lattice_create_star(NULL, &l));
    check_counts(&l, 2 * 11, 10);
    espalier_star_options options = espalier_default_star_options();
    options.points = 3;
    options.rings = 2;
    options.layers = 4;
    options.core = ESPALIER_CORE_POLYGON;
    options.inner_radius = 0.25;
    options.outer_radius = 3;
    options.height = 2;
    OK(espalier_lattice_create_star(&options, &l));
    CHECK(fabs(largest(l, 0) - 3) < 1e-12 && fabs(largest(l, 2) - 1) < 1e-12);
    check_counts(&l, 5 * 12, 4 * 7);
    options.inner_radius = 0;
    INVALID(espalier_lattice_create_star(&options, &l),
            "star: inner_radius: expected a finite number above 0, got 0");
    options.size = 0;
    INVALID(espalier_lattice_create_star(&options, &l), "espalier_default_star_options()");
    INVALID(espalier_lattice_create_star(NULL, NULL), "lattice is null");
    CHECK(l == NULL);
}

/* Exceeding a memory limit is not reported as an error of the input. */
static void test_memory(void) {
    const int32_t many[3] = {100, 100, 100};
    const double min[3] = {0, 0, 0}, max[3] = {1, 1, 1};
    espalier_lattice* l = NULL;
    espalier_memory_limit* limit = NULL;
    OK(espalier_memory_limit_create(1, &limit));
    REFUSED(espalier_lattice_create_box(many, min, max, &l), ESPALIER_ERROR_MEMORY,
            "the limit is 1");
    espalier_memory_limit_destroy(limit);
    CHECK(l == NULL);
}

/* A block is a pose of the barbell with the same numbers of cells. */
static void test_barbell(void) {
    espalier_lattice *l = NULL, *round = NULL;
    uint64_t hash = 0, other = 1;
    espalier_barbell_options options = espalier_default_barbell_options();
    OK(espalier_lattice_create_barbell(NULL, &round));
    options.roundness = 0;
    options.bar_half_width = options.end_radius;
    OK(espalier_lattice_create_barbell(&options, &l));
    CHECK(fabs(largest(l, 0) - 3) < 1e-12 && fabs(largest(l, 1) - 1) < 1e-12 &&
          fabs(largest(l, 2) - 0.25) < 1e-12);
    OK(espalier_lattice_topology_hash(l, &hash));
    OK(espalier_lattice_topology_hash(round, &other));
    CHECK(hash == other);
    espalier_lattice_destroy(l);
    l = NULL;
    options.layers = 2;
    OK(espalier_lattice_create_barbell(&options, &l));
    OK(espalier_lattice_topology_hash(l, &hash));
    CHECK(hash != other);
    espalier_lattice_destroy(l);
    espalier_lattice_destroy(round);
    l = NULL;
    options.roundness = 2;
    INVALID(espalier_lattice_create_barbell(&options, &l), "roundness");
    options = espalier_default_barbell_options();
    options.end_segments = 2;
    REFUSED(espalier_lattice_create_barbell(&options, &l), ESPALIER_ERROR_INPUT,
            "barbell: end_segments: expected 3 or more, got 2");
    options.size = 0;
    INVALID(espalier_lattice_create_barbell(&options, &l), "espalier_default_barbell_options()");
    INVALID(espalier_lattice_create_barbell(NULL, NULL), "lattice is null");
    CHECK(l == NULL);
}

static void test_arm(void) {
    espalier_lattice* l = NULL;
    OK(espalier_lattice_create_arm(NULL, &l));
    CHECK(fabs(largest(l, 0) - 2.5) < 1e-12);
    check_counts(&l, 7 * 4, 6);
    const espalier_arm_joint joints[2] = {{{0, 0, 0}, 0.5, 0}, {{0, 0, 4}, 0.25, 1}};
    espalier_arm_options options = espalier_default_arm_options();
    options.joints = joints;
    options.joint_count = 2;
    options.segments = 3;
    options.core = ESPALIER_CORE_WEDGES;
    INVALID(espalier_lattice_create_arm(&options, &l), "up");
    options.up[0] = 1;
    options.up[2] = 0;
    OK(espalier_lattice_create_arm(&options, &l));
    CHECK(fabs(largest(l, 0) - 0.5) < 1e-12 && fabs(largest(l, 2) - 4) < 1e-12);
    check_counts(&l, 4 * 5, 3 * 4);
    options.joint_count = 1;
    INVALID(espalier_lattice_create_arm(&options, &l), "joints");
    options.joints = NULL;
    INVALID(espalier_lattice_create_arm(&options, &l), "joints is null");
    options.size = 0;
    INVALID(espalier_lattice_create_arm(&options, &l), "espalier_default_arm_options()");
    INVALID(espalier_lattice_create_arm(NULL, NULL), "lattice is null");
    CHECK(l == NULL);
}

static void test_around(void) {
    espalier_lattice* l = NULL;
    static const double corners[6] = {0, 0, 0, 4, 2, 1};
    const double margin = 0.05 * sqrt(21);
    OK(espalier_lattice_create_around(2, corners, NULL, &l));
    CHECK(fabs(largest(l, 0) - (4 + margin)) < 1e-12);
    CHECK(fabs(largest(l, 2) - (1 + margin)) < 1e-12);
    check_counts(&l, 5 * 3 * 2, 4 * 2);
    espalier_around_options options = espalier_default_around_options();
    options.margin = 0;
    options.cells_along_longest = 8;
    OK(espalier_lattice_create_around(2, corners, &options, &l));
    check_counts(&l, 9 * 5 * 3, 8 * 4 * 2);
    options.cell_size = 1;
    OK(espalier_lattice_create_around(2, corners, &options, &l));
    check_counts(&l, 5 * 3 * 2, 4 * 2);
    options.cells[0] = options.cells[1] = options.cells[2] = 1;
    OK(espalier_lattice_create_around(2, corners, &options, &l));
    check_counts(&l, 8, 1);
    options.cells[1] = -1;
    INVALID(espalier_lattice_create_around(2, corners, &options, &l), "cells[1]");
    options = espalier_default_around_options();
    options.cells_along_longest = 0;
    INVALID(espalier_lattice_create_around(2, corners, &options, &l), "cells_along_longest");
    options.size = 0;
    INVALID(espalier_lattice_create_around(2, corners, &options, &l),
            "espalier_default_around_options()");
    INVALID(espalier_lattice_create_around(0, corners, NULL, &l), "there are no points");
    INVALID(espalier_lattice_create_around(2, NULL, NULL, &l), "points is null");
    INVALID(espalier_lattice_create_around(2, corners, NULL, NULL), "lattice is null");
    /* A turned segment: the oriented box is as long as the segment, and the box with sides along
     * the axes is not. */
    static const double segment[6] = {0, 0, 0, 3, 4, 0};
    options = espalier_default_around_options();
    options.margin = 0.1;
    options.oriented = 1;
    OK(espalier_lattice_create_around(2, segment, &options, &l));
    check_counts(&l, 5 * 2 * 2, 4);
    CHECK(l == NULL);
}

static void test_cage(void) {
    /* The sides of a box of 4 × 2 × 1. */
    static const double points[3 * 8] = {0, 0, 0, 4, 0, 0, 0, 2, 0, 4, 2, 0,
                                         0, 0, 1, 4, 0, 1, 0, 2, 1, 4, 2, 1};
    static const int64_t offsets[7] = {0, 4, 8, 12, 16, 20, 24};
    static const int32_t corners[24] = {0, 2, 3, 1, 4, 5, 7, 6, 0, 1, 5, 4,
                                        2, 6, 7, 3, 0, 4, 6, 2, 1, 3, 7, 5};
    espalier_polygons faces = {6, offsets, corners};
    espalier_cage_options options = espalier_default_cage_options();
    espalier_lattice* l = NULL;
    espalier_binding* binding = NULL;
    int32_t counts[4];
    options.vertices = 60;
    OK(espalier_lattice_create_cage(8, points, &faces, &options, &l));
    OK(espalier_lattice_counts(l, counts));
    CHECK(counts[0] >= 48 && counts[0] <= 72);
    /* The lattice contains every point. */
    espalier_refiner* refiner = NULL;
    int32_t vertex_count = 0;
    const double* positions = NULL;
    espalier_bind_options bind = espalier_default_bind_options();
    bind.outside = ESPALIER_OUTSIDE_REFUSE;
    OK(espalier_refiner_create(l, NULL, &refiner));
    OK(espalier_lattice_positions(l, &vertex_count, &positions));
    OK(espalier_binding_create(refiner, vertex_count, positions, 8, points, &bind, &binding));
    espalier_refiner_destroy(refiner);
    espalier_binding_destroy(binding);
    espalier_lattice_destroy(l);
    options.cell_size = 1;
    options.margin = 0.1;
    OK(espalier_lattice_create_cage(8, points, &faces, &options, &l));
    CHECK(largest(l, 0) > 4.3);
    espalier_lattice_destroy(l);
    l = NULL;

    options.cell_size = -1;
    INVALID(espalier_lattice_create_cage(8, points, &faces, &options, &l),
            "cell_size: expected 0 to 1e+90, got -1");
    options = espalier_default_cage_options();
    options.vertices = 7;
    INVALID(espalier_lattice_create_cage(8, points, &faces, &options, &l),
            "vertices: expected 8 to 100000, got 7");
    options = espalier_default_cage_options();
    options.symmetric = 9;
    INVALID(espalier_lattice_create_cage(8, points, &faces, &options, &l),
            "symmetric: expected 0 to 8, got 9");
    options.symmetric = ESPALIER_SYMMETRIC_NONE;
    options.symmetry = 2;
    INVALID(espalier_lattice_create_cage(8, points, &faces, &options, &l),
            "symmetry: expected 0 to 1, got 2");
    options.size = 0;
    INVALID(espalier_lattice_create_cage(8, points, &faces, &options, &l),
            "espalier_default_cage_options()");
    INVALID(espalier_lattice_create_cage(7, points, &faces, NULL, &l), "point 7");
    INVALID(espalier_lattice_create_cage(8, NULL, &faces, NULL, &l), "points is null");
    INVALID(espalier_lattice_create_cage(8, points, NULL, NULL, &l), "faces is null");
    INVALID(espalier_lattice_create_cage(8, points, &faces, NULL, NULL), "lattice is null");
    faces.corners = NULL;
    INVALID(espalier_lattice_create_cage(8, points, &faces, NULL, &l), "corners is null");
    faces.face_count = -1;
    INVALID(espalier_lattice_create_cage(8, points, &faces, NULL, &l), "offsets: the count is -1");
    faces.face_count = 0;
    INVALID(espalier_lattice_create_cage(8, points, &faces, NULL, &l), "no faces");
    CHECK(l == NULL);
}

static void test_solids(void) {
    espalier_lattice* l = NULL;
    static const int32_t vertices[5] = {4, 8, 6, 20, 12}, over_pentagon[3] = {10, 6, 7};
    for (int32_t solid = 0; solid < 5; ++solid) {
        int32_t count = 0;
        const double* p = NULL;
        OK(espalier_lattice_create_regular_solid(solid, 2, &l));
        OK(espalier_lattice_positions(l, &count, &p));
        CHECK(fabs(sqrt(p[0] * p[0] + p[1] * p[1] + p[2] * p[2]) - 2) < 1e-12);
        check_counts(&l, vertices[solid], 1);
    }
    for (int32_t solid = 0; solid < 3; ++solid) {
        OK(espalier_lattice_create_polygonal_solid(solid, 5, 2, 3, &l));
        CHECK(fabs(largest(l, 0) - 2) < 1e-12 && fabs(largest(l, 2) - 1.5) < 1e-12);
        check_counts(&l, over_pentagon[solid], 1);
    }
    INVALID(espalier_lattice_create_regular_solid(5, 1, &l), "solid: expected 0 to 4, got 5");
    INVALID(espalier_lattice_create_regular_solid(0, 0, &l), "radius");
    INVALID(espalier_lattice_create_regular_solid(0, 1, NULL), "lattice is null");
    INVALID(espalier_lattice_create_polygonal_solid(3, 3, 1, 1, &l),
            "solid: expected 0 to 2, got 3");
    INVALID(espalier_lattice_create_polygonal_solid(0, 2, 1, 1, &l), "sides");
    INVALID(espalier_lattice_create_polygonal_solid(0, 3, 1, 1, NULL), "lattice is null");
    CHECK(l == NULL);
}

static void test_collar(void) {
    const int32_t cells[3] = {2, 2, 2};
    const double low[3] = {0, 0, 0}, high[3] = {2, 2, 2};
    const double box[6] = {-5, -6, -7, 8, 9, 10};
    espalier_lattice *base = NULL, *l = NULL;
    OK(espalier_lattice_create_box(cells, low, high, &base));
    espalier_collar_options options = espalier_default_collar_options();
    options.layers = 2;
    options.reach = 1;
    OK(espalier_lattice_create_collar(base, &options, &l));
    CHECK(largest(l, 0) == 3);
    double weights[7 * 7 * 7];
    for (int i = 0; i < 343; ++i) weights[i] = 0.5;
    OK(espalier_lattice_held_weights(l, 343, weights));
    /* The 27 vertices of the box are the first ones, and all others are held. */
    for (int i = 0; i < 343; ++i) CHECK(weights[i] == (i < 27 ? 0.5 : 0));
    INVALID(espalier_lattice_held_weights(l, 342, weights), "343");
    check_counts(&l, 343, 216);
    options.reach = 0;
    options.until = box;
    OK(espalier_lattice_create_collar(base, &options, &l));
    CHECK(largest(l, 2) == 10);
    check_counts(&l, 343, 216);
    options.open[4] = options.open[5] = 1;
    OK(espalier_lattice_create_collar(base, &options, &l));
    check_counts(&l, 7 * 7 * 3, 6 * 6 * 2);
    INVALID(espalier_lattice_create_collar(base, NULL, &l), "reach: expected a length above 0");
    options.layers = 0;
    INVALID(espalier_lattice_create_collar(base, &options, &l), "layers: expected 1 to 100, got 0");
    INVALID(espalier_lattice_create_collar(NULL, &options, &l), "lattice is null");
    espalier_lattice_destroy(base);
}

static void test_symmetry(void) {
    const double points[6] = {0, 0, 0, 1, 2, 3};
    espalier_lattice* l = NULL;
    espalier_around_options options = espalier_default_around_options();
    options.symmetry_axis = 1;
    options.symmetry_at = 2;
    OK(espalier_lattice_create_around(2, points, &options, &l));
    CHECK(largest(l, 1) == 2 && largest(l, 0) > 1);
    espalier_lattice_destroy(l);
    l = NULL;
    options.symmetry_axis = 3;
    INVALID(espalier_lattice_create_around(2, points, &options, &l), "symmetry");
}

int main(void) {
    test_collar();
    test_symmetry();
    test_torus();
    test_star();
    test_barbell();
    test_memory();
    test_arm();
    test_around();
    test_cage();
    test_solids();
    return 0;
}
