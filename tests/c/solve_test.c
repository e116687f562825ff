/* SPDX-License-Identifier: Apache-2.0 */
/* Tests fitting, holding, validity, nested lattices, and tables in files. */

#include <math.h>
#include <stddef.h>
#include <string.h>

#include "box.h"
#include "check.h"

/* The rounding of a few products of numbers up to 1: a few units of 1e-16 each. */
static const double tolerance = 1e-12;

static double rest[3 * BOX_VERTICES];
static int32_t cells[8 * BOX_CELLS];
static espalier_lattice* lattice;
static espalier_refiner* refiner;
static espalier_binding* binding;
static espalier_table* table;

enum { POINTS = 2 };
static const double points[3 * POINTS] = {0.5, 0.5, 0.5, 0.25, 0.5, 0.6};

static void set_up(void) {
    make_box(rest, cells);
    OK(espalier_lattice_create_hexahedra(BOX_VERTICES, rest, BOX_CELLS, cells, &lattice));
    OK(espalier_refiner_create(lattice, NULL, &refiner));
    OK(espalier_binding_create(refiner, BOX_VERTICES, rest, POINTS, points, NULL, &binding));
    OK(espalier_binding_table(binding, &table));
}

static void tear_down(void) {
    espalier_table_destroy(table);
    espalier_binding_destroy(binding);
    espalier_refiner_destroy(refiner);
    espalier_lattice_destroy(lattice);
}

/* The displacements carry the points to their targets. */
static void test_fit(void) {
    const double misses[3 * POINTS] = {0.1, 0, 0, 0, -0.2, 0.05};
    double moved[3 * BOX_VERTICES], carried[3 * POINTS];
    espalier_fit_quality quality = {-1, -1, -1};
    OK(espalier_lattice_fit(table, lattice, POINTS, NULL, misses, NULL, BOX_VERTICES, moved,
                            &quality));
    CHECK(quality.largest_miss >= 0 && quality.largest_miss < 1e-9);
    CHECK(isinf(quality.condition));
    for (int i = 0; i < 3 * BOX_VERTICES; ++i) moved[i] += rest[i];
    OK(espalier_binding_apply(binding, BOX_VERTICES, moved, POINTS, carried));
    for (int i = 0; i < 3 * POINTS; ++i) CHECK(fabs(carried[i] - points[i] - misses[i]) < 1e-9);

    /* A single row, and frozen vertices. */
    const int32_t second = 1, frozen[2] = {BOX_CENTRE, 0};
    espalier_fit_options options = espalier_default_fit_options();
    options.frozen = frozen;
    options.frozen_count = 2;
    OK(espalier_lattice_fit(table, lattice, 1, &second, misses + 3, &options, BOX_VERTICES, moved,
                            NULL));
    for (int i = 0; i < 2; ++i)
        for (int k = 0; k < 3; ++k) CHECK(moved[3 * frozen[i] + k] == 0);
    options.undetermined = ESPALIER_UNDETERMINED_REFUSE;
    moved[0] = -7;
    INVALID(espalier_lattice_fit(table, lattice, 1, &second, misses, &options, BOX_VERTICES, moved,
                                 NULL),
            "vertex");
    const int32_t none = POINTS;
    INVALID(espalier_lattice_fit(table, lattice, 1, &none, misses, NULL, BOX_VERTICES, moved, NULL),
            "no row 2");
    CHECK(moved[0] == -7);
    INVALID(espalier_lattice_fit(NULL, lattice, 1, &none, misses, NULL, BOX_VERTICES, moved, NULL),
            "deformation is null");
    INVALID(espalier_lattice_fit(table, NULL, 1, &none, misses, NULL, BOX_VERTICES, moved, NULL),
            "lattice is null");
    INVALID(
        espalier_lattice_fit(table, lattice, POINTS, NULL, NULL, NULL, BOX_VERTICES, moved, NULL),
        "misses is null");
    INVALID(
        espalier_lattice_fit(table, lattice, POINTS, NULL, misses, NULL, BOX_VERTICES, NULL, NULL),
        "displacements is null");
}

/* Two points move rigidly, so the lattice does; frozen vertices and pins stay. */
static void test_pull(void) {
    const double misses[3 * POINTS] = {0.1, 0, -0.2, 0.1, 0, -0.2};
    double moved[3 * BOX_VERTICES], carried[3 * POINTS];
    espalier_pull_options options = espalier_default_pull_options();
    options.reach = 1;
    espalier_pull* pull;
    OK(espalier_pull_create(lattice, BOX_VERTICES, rest, table, POINTS, NULL, &options, &pull));
    const int32_t* fixed;
    int32_t count;
    OK(espalier_pull_fixed(pull, &count, &fixed));
    CHECK(count == 0);
    espalier_pull_quality quality;
    OK(espalier_pull_solve(pull, POINTS, misses, BOX_VERTICES, NULL, moved, &quality));
    for (int i = 0; i < 3 * BOX_VERTICES; ++i) CHECK(fabs(moved[i] - misses[i % 3]) < 1e-9);
    CHECK(quality.largest_miss < 1e-9 && quality.rms_miss < 1e-9 && quality.energy < 1e-12);
    CHECK(quality.iterations >= 1 && quality.meets_barrier == 0);
    /* From the pose before, which is the result. */
    OK(espalier_pull_solve(pull, POINTS, misses, BOX_VERTICES, moved, moved, NULL));
    for (int i = 0; i < 3 * BOX_VERTICES; ++i) CHECK(fabs(moved[i] - misses[i % 3]) < 1e-9);
    moved[0] = -7;
    INVALID(espalier_pull_solve(pull, 1, misses, BOX_VERTICES, NULL, moved, NULL),
            "got 1 targets for 2 points");
    INVALID(espalier_pull_solve(pull, POINTS, misses, 3, NULL, moved, NULL), "got 3 vertices");
    INVALID(espalier_pull_solve(pull, POINTS, NULL, BOX_VERTICES, NULL, moved, NULL),
            "misses is null");
    INVALID(espalier_pull_solve(NULL, POINTS, misses, BOX_VERTICES, NULL, moved, NULL),
            "pull is null");
    CHECK(moved[0] == -7);
    INVALID(espalier_pull_fixed(pull, &count, NULL), "vertices is null");
    espalier_pull_destroy(pull);

    const int32_t frozen[2] = {0, 26}, pin = 1, none = POINTS;
    options.frozen = frozen;
    options.frozen_count = 2;
    options.pins = &pin;
    options.pin_count = 1;
    const double up[3 * POINTS] = {0, 0, 0.1, 0, 0, 0};
    OK(espalier_pull_create(lattice, BOX_VERTICES, rest, table, POINTS, NULL, &options, &pull));
    OK(espalier_pull_fixed(pull, &count, &fixed));
    CHECK(count == 2 && fixed[0] == 0 && fixed[1] == 26);
    OK(espalier_pull_solve(pull, POINTS, up, BOX_VERTICES, NULL, moved, NULL));
    for (int k = 0; k < 3; ++k) CHECK(moved[k] == 0 && moved[3 * 26 + k] == 0);
    for (int i = 0; i < 3 * BOX_VERTICES; ++i) moved[i] += rest[i];
    OK(espalier_binding_apply(binding, BOX_VERTICES, moved, POINTS, carried));
    for (int i = 0; i < 3 * POINTS; ++i) CHECK(fabs(carried[i] - points[i] - up[i]) < 1e-6);
    espalier_pull_destroy(pull);

    /* The first point is pushed through the lattice, whose farther vertices stay. */
    const double through[3 * POINTS] = {3, 3, 3, 0, 0, 0};
    OK(espalier_pull_create(lattice, BOX_VERTICES, rest, table, POINTS, NULL, NULL, &pull));
    OK(espalier_pull_solve(pull, POINTS, through, BOX_VERTICES, NULL, moved, &quality));
    CHECK(quality.meets_barrier == 1);
    espalier_pull_destroy(pull);
    espalier_pull_destroy(NULL);

    INVALID(espalier_pull_create(lattice, BOX_VERTICES, rest, table, 1, &none, NULL, &pull),
            "no row 2");
    options.pins = &none;
    INVALID(espalier_pull_create(lattice, BOX_VERTICES, rest, table, POINTS, NULL, &options, &pull),
            "pins[0]: expected a row, 0 to 1, got 2");
    INVALID(espalier_pull_create(NULL, BOX_VERTICES, rest, table, POINTS, NULL, NULL, &pull),
            "lattice is null");
    INVALID(espalier_pull_create(lattice, BOX_VERTICES, rest, NULL, POINTS, NULL, NULL, &pull),
            "deformation is null");
}

/* Pulls and fits keep the vertices that the lattice holds, unless told otherwise; also those of
 * programs that were compiled before there was `move_held`, with anything in the padding. */
static void test_held(void) {
    enum { ALL = 5 * 5 * 5, HELD = ALL - BOX_VERTICES };
    espalier_lattice* with_collar;
    espalier_collar_options collar = espalier_default_collar_options();
    collar.layers = 1;
    collar.reach = 1;
    OK(espalier_lattice_create_collar(lattice, &collar, &with_collar));
    double moved[3 * ALL];
    const double* positions;
    int32_t all;
    OK(espalier_lattice_positions(with_collar, &all, &positions));
    CHECK(all == ALL);
    espalier_refiner* levels;
    OK(espalier_refiner_create(with_collar, NULL, &levels));
    espalier_binding* bound;
    OK(espalier_binding_create(levels, ALL, positions, POINTS, points, NULL, &bound));
    espalier_table* rows;
    OK(espalier_binding_table(bound, &rows));

    espalier_pull_options pulls[3];
    memset(pulls, 0xff, sizeof pulls);
    for (int i = 0; i < 3; ++i) {
        espalier_pull_options defaults = espalier_default_pull_options();
        defaults.reach = 1;
        memcpy(&pulls[i], &defaults, offsetof(espalier_pull_options, max_iterations));
        pulls[i].max_iterations = defaults.max_iterations;
    }
    pulls[0].size = offsetof(espalier_pull_options, move_held);
    pulls[1].move_held = 0;
    pulls[2].move_held = 1;
    for (int i = 0; i < 3; ++i) {
        espalier_pull* pull;
        OK(espalier_pull_create(with_collar, ALL, positions, rows, POINTS, NULL, &pulls[i], &pull));
        const int32_t* fixed;
        int32_t count;
        OK(espalier_pull_fixed(pull, &count, &fixed));
        CHECK(count == (i < 2 ? HELD : 0));
        espalier_pull_destroy(pull);
    }

    const double misses[3 * POINTS] = {0.1, 0, -0.2, 0, 0, 0};
    for (int i = 0; i < 3; ++i) {
        espalier_fit_options fit = espalier_default_fit_options();
        if (i == 0) fit.size = offsetof(espalier_fit_options, move_held);
        fit.move_held = i == 1 ? 0 : 1;
        OK(espalier_lattice_fit(rows, with_collar, POINTS, NULL, misses, &fit, ALL, moved, NULL));
        int moves_held = 0;
        for (int k = 3 * BOX_VERTICES; k < 3 * ALL; ++k) moves_held |= moved[k] != 0;
        CHECK(moves_held == (i == 2));
    }
    espalier_table_destroy(rows);
    espalier_binding_destroy(bound);
    espalier_refiner_destroy(levels);
    espalier_lattice_destroy(with_collar);
}

/* Holds the side x = 0 of the box: its 9 vertices for positions, and the next layer for tangent
 * planes. */
static void test_hold(void) {
    int32_t held[BOX_VERTICES], count = -1, side[4], sides = 0;
    espalier_cells topology;
    OK(espalier_refiner_cells(refiner, 0, &topology));
    for (int32_t f = 0; f < topology.face_count; ++f) {
        int on_side = 1;
        for (int64_t i = topology.face_offsets[f]; i < topology.face_offsets[f + 1]; ++i)
            if (topology.face_vertices[i] % 3 != 0) on_side = 0;
        if (on_side) side[sides++] = f;
    }
    CHECK(sides == 4);
    OK(espalier_hold_faces(refiner, 4, side, ESPALIER_CONTINUITY_C0, BOX_VERTICES, held, &count));
    CHECK(count == 9);
    for (int i = 0; i < 9; ++i) CHECK(held[i] == 3 * i);
    OK(espalier_hold_faces(refiner, 4, side, ESPALIER_CONTINUITY_C1, BOX_VERTICES, held, &count));
    CHECK(count == 18);
    for (int i = 0; i < 18; ++i) CHECK(held[i] == 3 * (i / 2) + i % 2);

    /* A corner of the box is a vertex of the lattice. Continuity adds more vertices to those
     * that hold a bound point. */
    const double corner[3] = {0, 0, 0};
    OK(espalier_hold_points(refiner, BOX_VERTICES, rest, 1, corner, ESPALIER_CONTINUITY_C0, NULL,
                            held, &count));
    CHECK(count == 1 && held[0] == 0);
    OK(espalier_hold_points(refiner, BOX_VERTICES, rest, 1, corner, ESPALIER_CONTINUITY_C1, NULL,
                            held, &count));
    CHECK(count > 1 && held[0] == 0);

    /* The vertices that hold a row are its columns. */
    const int32_t first = 0;
    espalier_csr csr;
    OK(espalier_table_csr(table, &csr));
    OK(espalier_hold_rows(table, 1, &first, BOX_VERTICES, held, &count));
    CHECK(count == csr.offsets[1]);
    for (int32_t i = 0; i < count; ++i) CHECK(held[i] == csr.columns[i]);
    OK(espalier_hold_rows(table, POINTS, NULL, BOX_VERTICES, held, &count));
    CHECK(count == BOX_VERTICES);

    count = -7;
    held[0] = -7;
    INVALID(espalier_hold_faces(refiner, 0, NULL, 0, BOX_VERTICES, held, &count), "face");
    side[0] = topology.face_count;
    INVALID(espalier_hold_faces(refiner, 4, side, 0, BOX_VERTICES, held, &count), "face");
    side[0] = 0;
    INVALID(espalier_hold_faces(refiner, 4, side, 3, BOX_VERTICES, held, &count),
            "continuity: expected 0 to 2, got 3");
    INVALID(espalier_hold_faces(NULL, 4, side, 0, BOX_VERTICES, held, &count), "refiner is null");
    INVALID(espalier_hold_faces(refiner, 4, NULL, 0, BOX_VERTICES, held, &count), "faces is null");
    INVALID(espalier_hold_faces(refiner, 4, side, 0, 26, held, &count), "got 26");
    INVALID(espalier_hold_faces(refiner, 4, side, 0, BOX_VERTICES, NULL, &count), "held is null");
    INVALID(espalier_hold_faces(refiner, 4, side, 0, BOX_VERTICES, held, NULL),
            "held_count is null");
    INVALID(espalier_hold_points(NULL, BOX_VERTICES, rest, 1, corner, 0, NULL, held, &count),
            "refiner is null");
    INVALID(espalier_hold_points(refiner, BOX_VERTICES, NULL, 1, corner, 0, NULL, held, &count),
            "positions is null");
    INVALID(espalier_hold_points(refiner, BOX_VERTICES, rest, 1, NULL, 0, NULL, held, &count),
            "points is null");
    INVALID(espalier_hold_points(refiner, BOX_VERTICES, rest, 1, corner, 0, NULL, NULL, &count),
            "held is null");
    INVALID(espalier_hold_points(refiner, BOX_VERTICES, rest, 1, corner, 0, NULL, held, NULL),
            "held_count is null");
    espalier_bind_options options = espalier_default_bind_options();
    options.limit_tolerance = 1e-6;
    INVALID(espalier_hold_points(refiner, BOX_VERTICES, rest, 1, corner, 0, &options, held, &count),
            "limit_tolerance");
    INVALID(espalier_hold_rows(NULL, 1, &first, BOX_VERTICES, held, &count), "deformation is null");
    INVALID(espalier_hold_rows(table, 1, NULL, BOX_VERTICES, held, &count), "got 1 rows");
    INVALID(espalier_hold_rows(table, 1, &first, BOX_VERTICES, NULL, &count), "held is null");
    INVALID(espalier_hold_rows(table, 1, &first, BOX_VERTICES, held, NULL), "held_count is null");
    CHECK(count == -7 && held[0] == -7);
}

/* If the box is stretched to twice its length, all ratios are 2. If it is mirrored, all cells
 * are inverted, and half of the way is the largest valid step. */
static void check_poses(int32_t of_limit) {
    espalier_validity* validity = NULL;
    espalier_validity_options options = espalier_default_validity_options();
    espalier_pose_validity result = {-7, -7, -7};
    espalier_largest_step step = {-7, -7, -7};
    double pose[3 * BOX_VERTICES], ratios[8 * BOX_CELLS];
    const int32_t cell_count = of_limit ? BOX_CELLS : 8 * BOX_CELLS;
    int32_t count = -1;
    const int32_t* bad = NULL;
    options.level = 1;
    options.of_limit = of_limit;
    OK(espalier_validity_create(refiner, BOX_VERTICES, rest, &options, &validity));
    OK(espalier_validity_cell_count(validity, &count));
    CHECK(count == cell_count);
    OK(espalier_validity_bad_at_rest(validity, &count, &bad));
    CHECK(count == 0);
    OK(espalier_validity_base_cell(validity, cell_count - 1, &count));
    CHECK(count == BOX_CELLS - 1);

    for (int i = 0; i < 3 * BOX_VERTICES; ++i) pose[i] = (i % 3 == 0 ? 2 : 1) * rest[i];
    OK(espalier_validity_check(validity, BOX_VERTICES, pose, cell_count, ratios, &result));
    CHECK(result.inverted_count == 0);
    CHECK(result.smallest_ratio <= 2 && result.smallest_ratio > 1.99);
    CHECK(ratios[result.smallest_cell] == result.smallest_ratio);
    for (int32_t i = 0; i < cell_count; ++i) CHECK(ratios[i] <= 2 && ratios[i] > 1.99);
    OK(espalier_validity_largest_step(validity, BOX_VERTICES, pose, 1, &step));
    CHECK(step.length == 1 && step.limiting_cell == -1);

    for (int i = 0; i < 3 * BOX_VERTICES; ++i) pose[i] = (i % 3 == 0 ? -1 : 1) * rest[i];
    OK(espalier_validity_check(validity, BOX_VERTICES, pose, 0, NULL, &result));
    CHECK(result.inverted_count == cell_count && result.smallest_ratio <= 0);
    OK(espalier_validity_largest_step(validity, BOX_VERTICES, pose, 1, &step));
    CHECK(step.length <= 0.5 && step.length > 0.5 - 1e-5);
    CHECK(step.limiting_cell >= 0 && step.limiting_cell < cell_count && step.is_tight == 1);

    ratios[0] = result.smallest_ratio = step.length = -7;
    INVALID(espalier_validity_check(validity, 26, pose, 0, NULL, &result), "got 26");
    INVALID(espalier_validity_check(validity, BOX_VERTICES, pose, cell_count - 1, ratios, &result),
            "cells in the array");
    INVALID(espalier_validity_check(NULL, BOX_VERTICES, pose, 0, NULL, &result),
            "validity is null");
    INVALID(espalier_validity_check(validity, BOX_VERTICES, NULL, 0, NULL, &result),
            "pose is null");
    INVALID(espalier_validity_check(validity, BOX_VERTICES, pose, 0, NULL, NULL), "result is null");
    INVALID(espalier_validity_largest_step(validity, BOX_VERTICES, pose, 0, &step), "0");
    INVALID(espalier_validity_largest_step(validity, BOX_VERTICES, NULL, 1, &step), "pose is null");
    INVALID(espalier_validity_largest_step(NULL, BOX_VERTICES, pose, 1, &step), "validity is null");
    INVALID(espalier_validity_largest_step(validity, BOX_VERTICES, pose, 1, NULL), "step is null");
    pose[4] = NAN;
    INVALID(espalier_validity_check(validity, BOX_VERTICES, pose, cell_count, ratios, &result),
            "finite");
    CHECK(ratios[0] == -7 && result.smallest_ratio == -7 && step.length == -7);
    INVALID(espalier_validity_base_cell(validity, cell_count, &count), "there is no cell");
    INVALID(espalier_validity_base_cell(NULL, 0, &count), "validity is null");
    INVALID(espalier_validity_base_cell(validity, 0, NULL), "base_cell is null");
    INVALID(espalier_validity_bad_at_rest(NULL, &count, &bad), "validity is null");
    INVALID(espalier_validity_bad_at_rest(validity, NULL, &bad), "cell_count is null");
    INVALID(espalier_validity_bad_at_rest(validity, &count, NULL), "cells is null");
    INVALID(espalier_validity_cell_count(NULL, &count), "validity is null");
    INVALID(espalier_validity_cell_count(validity, NULL), "cell_count is null");
    espalier_validity_destroy(validity);
}

static void test_validity(void) {
    check_poses(0);
    check_poses(1);

    /* The cell at the origin is flat at rest. */
    double flat[3 * BOX_VERTICES];
    memcpy(flat, rest, sizeof flat);
    for (int v = 1; v < 14; v += 3)
        if (v % 9 < 6) flat[3 * v] = 0;
    espalier_validity* validity = NULL;
    espalier_validity_options options = espalier_default_validity_options();
    espalier_pose_validity result;
    int32_t count = -1, base = -1;
    const int32_t* bad = NULL;
    double ratios[8 * BOX_CELLS];
    options.level = 1;
    OK(espalier_validity_create(refiner, BOX_VERTICES, flat, &options, &validity));
    OK(espalier_validity_bad_at_rest(validity, &count, &bad));
    CHECK(count > 0);
    OK(espalier_validity_base_cell(validity, bad[0], &base));
    CHECK(base == 0);
    OK(espalier_validity_check(validity, BOX_VERTICES, rest, 8 * BOX_CELLS, ratios, &result));
    CHECK(isnan(ratios[bad[0]]) && result.inverted_count == 0);
    espalier_validity_destroy(validity);
    validity = NULL;

    espalier_validity_destroy(NULL);
    options.level = 0;
    INVALID(espalier_validity_create(refiner, BOX_VERTICES, rest, &options, &validity),
            "level: expected 1 or more, got 0");
    options.of_limit = 1;
    INVALID(espalier_validity_create(refiner, BOX_VERTICES, rest, &options, &validity), "0");
    options.of_limit = 2;
    INVALID(espalier_validity_create(refiner, BOX_VERTICES, rest, &options, &validity),
            "of_limit: expected 0 to 1, got 2");
    options.size = 4;
    INVALID(espalier_validity_create(refiner, BOX_VERTICES, rest, &options, &validity),
            "espalier_default_validity_options()");
    INVALID(espalier_validity_create(NULL, BOX_VERTICES, rest, NULL, &validity), "refiner is null");
    INVALID(espalier_validity_create(refiner, BOX_VERTICES, NULL, NULL, &validity),
            "positions is null");
    INVALID(espalier_validity_create(refiner, 26, rest, NULL, &validity), "got 26");
    INVALID(espalier_validity_create(refiner, BOX_VERTICES, rest, NULL, NULL), "validity is null");
    CHECK(validity == NULL);
}

/* A child lattice in a parent of twice its size. While the parent is at rest the points stay,
 * and they follow a move of the parent. */
static void test_nested(void) {
    double parent[3 * BOX_VERTICES], moved[3 * POINTS];
    for (int i = 0; i < 3 * BOX_VERTICES; ++i) parent[i] = 2 * rest[i] - 0.5;
    espalier_table* nested = NULL;
    espalier_evaluator_f64* evaluator = NULL;
    OK(espalier_table_create_nested(table, BOX_VERTICES, rest, refiner, BOX_VERTICES, parent, NULL,
                                    &nested));
    OK(espalier_evaluator_f64_create(nested, &evaluator));
    for (int i = 0; i < 3 * BOX_VERTICES; ++i) parent[i] += i % 3;
    const espalier_buffer_layout xyz = espalier_packed_layout(3);
    OK(espalier_evaluator_f64_evaluate(evaluator, parent, 3 * BOX_VERTICES, xyz, moved, 3 * POINTS,
                                       xyz, 0, POINTS, NULL));
    for (int i = 0; i < 3 * POINTS; ++i) CHECK(fabs(moved[i] - points[i] - i % 3) < tolerance);
    espalier_evaluator_f64_destroy(evaluator);
    espalier_table_destroy(nested);
    nested = NULL;
    INVALID(espalier_table_create_nested(table, BOX_VERTICES, rest, refiner, BOX_VERTICES, parent,
                                         NULL, &nested),
            "vertex");
    INVALID(espalier_table_create_nested(NULL, BOX_VERTICES, rest, refiner, BOX_VERTICES, parent,
                                         NULL, &nested),
            "child is null");
    INVALID(
        espalier_table_create_nested(table, 26, rest, refiner, BOX_VERTICES, parent, NULL, &nested),
        "got 26");
    CHECK(nested == NULL);
}

static void test_shapes(void) {
    const int32_t cubes[3] = {2, 2, 2};
    const double origin[3] = {0, 0, 0}, corner[3] = {1, 1, 1}, beside[3] = {1, 0, 0},
                 far[3] = {2, 1, 1}, top[3] = {0, 0, 2};
    espalier_lattice *one = NULL, *two = NULL, *both = NULL, *round = NULL;
    uint64_t hash = 0, other = 1;
    int32_t counts[4];
    /* The box of the other tests. */
    OK(espalier_lattice_create_box(cubes, origin, corner, &one));
    OK(espalier_lattice_topology_hash(lattice, &hash));
    OK(espalier_lattice_topology_hash(one, &other));
    CHECK(hash == other);
    int32_t count = 0;
    const double* positions = NULL;
    OK(espalier_lattice_positions(one, &count, &positions));
    for (int i = 0; i < 3 * BOX_VERTICES; ++i) CHECK(positions[i] == rest[i]);
    /* Two boxes share 9 vertices. */
    OK(espalier_lattice_create_box(cubes, beside, far, &two));
    const espalier_lattice* parts[2] = {one, two};
    OK(espalier_lattice_create_merged(2, parts, 1e-6, &both));
    OK(espalier_lattice_counts(both, counts));
    CHECK(counts[0] == 45 && counts[3] == 16);
    /* 8 wedges around the axis in each of 3 layers; 4 times an axis vertex and 8 vertices around
     * it. */
    OK(espalier_lattice_create_cylinder(8, 1, ESPALIER_CORE_WEDGES, 3, 0.5, origin, top, &round));
    OK(espalier_lattice_counts(round, counts));
    CHECK(counts[0] == 36 && counts[3] == 24);
    espalier_lattice_destroy(one);
    espalier_lattice_destroy(two);
    espalier_lattice_destroy(both);
    espalier_lattice_destroy(round);
    one = NULL;
    parts[1] = NULL;
    INVALID(espalier_lattice_create_merged(1, parts + 1, 1e-6, &one),
            "one of the lattices is null");
    INVALID(espalier_lattice_create_box(NULL, origin, corner, &one), "cells is null");
    INVALID(espalier_lattice_create_cylinder(8, 1, 0, 1, 1, NULL, top, &one), "from is null");
    CHECK(one == NULL);
}

/* By symmetry the vertex in the middle stays where it was. Its mask is (1, 4, 1)/6 along each
 * axis, so its own weight is (4/6)³. */
static void test_limits(void) {
    espalier_table* limits = NULL;
    espalier_csr csr;
    OK(espalier_table_create_limits(refiner, 0, &limits));
    OK(espalier_table_csr(limits, &csr));
    CHECK(csr.row_count == BOX_VERTICES && csr.column_count == BOX_VERTICES);
    const int64_t first = csr.offsets[BOX_CENTRE];
    CHECK(csr.offsets[BOX_CENTRE + 1] - first == BOX_VERTICES);
    CHECK(fabs(csr.weights[first + BOX_CENTRE] - 8.0 / 27) < tolerance);
    espalier_table_destroy(limits);
    limits = NULL;
    INVALID(espalier_table_create_limits(refiner, 1, &limits), "level 1");
    INVALID(espalier_table_create_limits(NULL, 0, &limits), "refiner is null");
    CHECK(limits == NULL);
}

/* The position of (0, 0, 0) in a cell of the box, and its axes u, v, w, as espalier.h defines
 * them. */
static void make_frame(int32_t cell, double frame[4][3]) {
    espalier_cells topology;
    const int8_t* signs = NULL;
    OK(espalier_refiner_cells(refiner, 0, &topology));
    OK(espalier_refiner_face_signs(refiner, 0, &signs));
    const int64_t first = topology.cell_offsets[cell];
    const int32_t* loop =
        topology.face_vertices + topology.face_offsets[topology.cell_faces[first]];
    const int32_t u = signs[first] < 0 ? loop[1] : loop[3];
    const int32_t v = signs[first] < 0 ? loop[3] : loop[1];
    for (int k = 0; k < 3; ++k) {
        frame[0][k] = rest[3 * loop[0] + k];
        frame[1][k] = rest[3 * u + k] - frame[0][k];
        frame[2][k] = rest[3 * v + k] - frame[0][k];
    }
    /* The cells are cubes of side 0.5, and their axes are right-handed. */
    for (int k = 0; k < 3; ++k) {
        const int l = (k + 1) % 3, m = (k + 2) % 3;
        frame[3][k] = 2 * (frame[1][l] * frame[2][m] - frame[1][m] * frame[2][l]);
    }
}

/* Evaluated at rest, positions are the places, and their derivatives are the edges of the cell. */
static void test_limit_stencils(void) {
    enum { TABLES = ESPALIER_LIMIT_STENCIL_TABLES(2), PLACES = 2 };
    const int32_t some[PLACES] = {0, 7};
    const double places[3 * PLACES] = {0.5, 0.5, 0.5, 0.25, 0.5, 0.75};
    espalier_table* tables[TABLES] = {NULL};
    espalier_limit_stencil_options options = espalier_default_limit_stencil_options();
    options.derivatives = 2;
    OK(espalier_table_create_limit_stencils(refiner, 0, PLACES, some, places, &options, TABLES,
                                            tables));
    for (int t = 0; t < TABLES; ++t) {
        espalier_csr csr;
        OK(espalier_table_csr(tables[t], &csr));
        CHECK(csr.row_count == PLACES && csr.column_count == BOX_VERTICES);
        for (int row = 0; row < PLACES; ++row) {
            double sum = 0, at[3] = {0, 0, 0};
            for (int64_t i = csr.offsets[row]; i < csr.offsets[row + 1]; ++i) {
                sum += csr.weights[i];
                for (int k = 0; k < 3; ++k) at[k] += csr.weights[i] * rest[3 * csr.columns[i] + k];
            }
            CHECK(fabs(sum - (t == 0)) < tolerance);
            /* The box equals its limit. */
            double frame[4][3];
            make_frame(some[row], frame);
            for (int k = 0; k < 3; ++k) {
                double expected = t >= 1 && t <= 3 ? frame[t][k] : 0;
                if (t == 0) expected = frame[0][k];
                for (int axis = 0; axis < 3 && t == 0; ++axis)
                    expected += places[3 * row + axis] * frame[axis + 1][k];
                CHECK(fabs(at[k] - expected) < tolerance);
            }
        }
        espalier_table_destroy(tables[t]);
        tables[t] = NULL;
    }
    OK(espalier_table_create_limit_stencils(refiner, 0, PLACES, some, places, NULL, 1, tables));
    espalier_table_destroy(tables[0]);
    tables[0] = NULL;

    const int32_t none[PLACES] = {0, BOX_CELLS};
    const double outside[3 * PLACES] = {0.5, 0.5, 0.5, 0.5, 1.5, 0.5};
    INVALID(espalier_table_create_limit_stencils(refiner, 0, PLACES, none, places, &options, TABLES,
                                                 tables),
            "8");
    INVALID(espalier_table_create_limit_stencils(refiner, 0, PLACES, some, outside, &options,
                                                 TABLES, tables),
            "1.5");
    INVALID(espalier_table_create_limit_stencils(refiner, 1, PLACES, some, places, &options, TABLES,
                                                 tables),
            "level 1");
    INVALID(
        espalier_table_create_limit_stencils(refiner, 0, PLACES, some, places, &options, 4, tables),
        "got 4 tables");
    INVALID(espalier_table_create_limit_stencils(NULL, 0, PLACES, some, places, &options, TABLES,
                                                 tables),
            "refiner is null");
    INVALID(espalier_table_create_limit_stencils(refiner, 0, PLACES, NULL, places, &options, TABLES,
                                                 tables),
            "cells is null");
    INVALID(espalier_table_create_limit_stencils(refiner, 0, PLACES, some, NULL, &options, TABLES,
                                                 tables),
            "uvw is null");
    INVALID(espalier_table_create_limit_stencils(refiner, 0, PLACES, some, places, &options, TABLES,
                                                 NULL),
            "tables is null");
    options.derivatives = 3;
    INVALID(espalier_table_create_limit_stencils(refiner, 0, PLACES, some, places, &options, TABLES,
                                                 tables),
            "derivatives: expected 0 to 2, got 3");
    options.size = 0;
    INVALID(espalier_table_create_limit_stencils(refiner, 0, PLACES, some, places, &options, TABLES,
                                                 tables),
            "espalier_default_limit_stencil_options()");
    for (int t = 0; t < TABLES; ++t) CHECK(tables[t] == NULL);
}

/* In the middle of an axis with 2 cells, the Bernstein polynomials of degree 2 are 1/4, 1/2,
 * 1/4. In the middle of an axis with 4 cells, which is a grid point, the B-splines are 1/6, 4/6,
 * 1/6. */
static void test_tensor(void) {
    espalier_binding* b = NULL;
    espalier_table* t = NULL;
    espalier_csr csr;
    espalier_lattice* fine = NULL;
    const double middle[3] = {0.5, 0.5, 0.5}, zero[3] = {0, 0, 0}, one[3] = {1, 1, 1};
    const int32_t fours[3] = {4, 4, 4}, vertex = 0;
    OK(espalier_binding_create_tensor(lattice, ESPALIER_BASIS_BEZIER, 1, middle, NULL, &b));
    OK(espalier_binding_table(b, &t));
    OK(espalier_table_csr(t, &csr));
    CHECK(csr.row_count == 1 && csr.offsets[1] == BOX_VERTICES);
    CHECK(fabs(csr.weights[0] - 1.0 / 64) < tolerance);
    CHECK(fabs(csr.weights[BOX_CENTRE] - 1.0 / 8) < tolerance);
    espalier_table_destroy(t);
    espalier_binding_destroy(b);
    b = NULL;
    INVALID(espalier_binding_create_tensor(lattice, ESPALIER_BASIS_BSPLINE, 1, middle, NULL, &b),
            "cells");

    OK(espalier_lattice_create_box(fours, zero, one, &fine));
    OK(espalier_binding_create_tensor(fine, ESPALIER_BASIS_BSPLINE, 1, middle, NULL, &b));
    OK(espalier_binding_table(b, &t));
    OK(espalier_table_csr(t, &csr));
    double centre = 0;
    for (int64_t i = 0; i < csr.offsets[1]; ++i)
        if (csr.columns[i] == 62) centre = csr.weights[i];
    CHECK(fabs(centre - 8.0 / 27) < tolerance);
    espalier_table_destroy(t);
    espalier_binding_destroy(b);
    b = NULL;

    const double sharp = ESPALIER_SHARP;
    OK(espalier_lattice_mark_vertices(fine, 1, &vertex, &sharp));
    INVALID(espalier_binding_create_tensor(fine, 0, 1, middle, NULL, &b), "marks");
    espalier_lattice_destroy(fine);
    espalier_bind_options options = espalier_default_bind_options();
    options.limit_tolerance = 1e-6;
    INVALID(espalier_binding_create_tensor(lattice, 0, 1, middle, &options, &b), "limit_tolerance");
    INVALID(espalier_binding_create_tensor(lattice, 2, 1, middle, NULL, &b),
            "basis: expected 0 to 1, got 2");
    INVALID(espalier_binding_create_tensor(NULL, 0, 1, middle, NULL, &b), "lattice is null");
    INVALID(espalier_binding_create_tensor(lattice, 0, 1, NULL, NULL, &b), "points is null");
    INVALID(espalier_binding_create_tensor(lattice, 0, 1, middle, NULL, NULL), "binding is null");
    CHECK(b == NULL);
}

static void test_files(const char* path) {
    espalier_table* other = NULL;
    espalier_csr a, b;
    OK(espalier_table_write(table, path));
    OK(espalier_table_read(path, &other));
    OK(espalier_table_csr(table, &a));
    OK(espalier_table_csr(other, &b));
    CHECK(a.row_count == b.row_count && a.column_count == b.column_count);
    for (int32_t i = 0; i <= a.row_count; ++i) CHECK(a.offsets[i] == b.offsets[i]);
    for (int64_t i = 0; i < a.offsets[a.row_count]; ++i)
        CHECK(a.columns[i] == b.columns[i] && a.weights[i] == b.weights[i]);
    espalier_table_destroy(other);
    other = NULL;
    REFUSED(espalier_table_read("none.npz", &other), ESPALIER_ERROR_FILE, "none.npz");
    REFUSED(espalier_table_read("none.npy", &other), ESPALIER_ERROR_FILE, "none.npy");
    INVALID(espalier_table_read(NULL, &other), "path is null");
    INVALID(espalier_table_read(path, NULL), "table is null");
    INVALID(espalier_table_write(NULL, path), "table is null");
    REFUSED(espalier_table_write(table, "no/such/table.npz"), ESPALIER_ERROR_FILE, "no/such");
    CHECK(other == NULL);
}

int main(int argc, char** argv) {
    set_up();
    test_fit();
    test_pull();
    test_held();
    test_hold();
    test_validity();
    test_nested();
    test_shapes();
    test_limits();
    test_limit_stencils();
    test_tensor();
    for (int i = 1; i < argc; ++i) test_files(argv[i]);
    tear_down();
    return 0;
}
