/* SPDX-License-Identifier: Apache-2.0 */
/* Tests each way in which a call can fail: its status, its message, and that it wrote nothing. */

#include <math.h>

#include "box.h"
#include "check.h"

static double positions[3 * BOX_VERTICES];
static int32_t cells[8 * BOX_CELLS];
static espalier_lattice* lattice;
static espalier_refiner* refiner;
static espalier_binding* binding;
static espalier_table* table;
static espalier_evaluator_f64* f64;
static espalier_evaluator_f32* f32;

static const double point[3] = {0.5, 0.5, 0.5};

static void set_up(void) {
    make_box(positions, cells);
    OK(espalier_lattice_create_hexahedra(BOX_VERTICES, positions, BOX_CELLS, cells, &lattice));
    OK(espalier_refiner_create(lattice, NULL, &refiner));
    OK(espalier_binding_create(refiner, BOX_VERTICES, positions, 1, point, NULL, &binding));
    OK(espalier_binding_table(binding, &table));
    OK(espalier_evaluator_f64_create(table, &f64));
    OK(espalier_evaluator_f32_create(table, &f32));
}

static void test_destroying_null_does_nothing(void) {
    espalier_progress_scope_destroy(NULL);
    espalier_executor_scope_destroy(NULL);
    espalier_thread_limit_destroy(NULL);
    espalier_memory_limit_destroy(NULL);
    espalier_workspace_destroy(NULL);
    espalier_lattice_destroy(NULL);
    espalier_refiner_destroy(NULL);
    espalier_table_destroy(NULL);
    espalier_binding_destroy(NULL);
    espalier_evaluator_f64_destroy(NULL);
    espalier_evaluator_f32_destroy(NULL);
    espalier_deformer_f64_destroy(NULL);
    espalier_deformer_f32_destroy(NULL);
}

static int32_t keep_going(void* user, const espalier_progress* progress) {
    (void)user;
    (void)progress;
    return 1;
}

/* Passes null for every pointer of every function. */
static void test_null_is_an_error(void) {
    const espalier_buffer_layout xyz = espalier_packed_layout(3);
    espalier_progress_scope* progress = NULL;
    espalier_lattice* l = NULL;
    espalier_refiner* r = NULL;
    espalier_table* t = NULL;
    espalier_binding* b = NULL;
    espalier_evaluator_f64* e = NULL;
    espalier_evaluator_f32* s = NULL;
    int32_t counts[4], count = 0;
    const int32_t* numbers = NULL;
    const int8_t* signs = NULL;
    const uint8_t* statuses = NULL;
    const double* view = NULL;
    double values[3 * BOX_VERTICES];
    float singles[3 * BOX_VERTICES] = {0};
    uint64_t hash = 0;
    espalier_cells c = {0, 0, 0, NULL, NULL, NULL, NULL};
    espalier_csr csr;

    INVALID(espalier_progress_scope_create(NULL, NULL, 20, &progress), "callback is null");
    INVALID(espalier_progress_scope_create(keep_going, NULL, 20, NULL), "scope is null");
    INVALID(espalier_executor_scope_create(NULL, NULL, NULL), "scope is null");
    INVALID(espalier_thread_limit_create(1, NULL), "limit is null");
    INVALID(espalier_memory_limit_create(1, NULL), "limit is null");
    INVALID(espalier_workspace_create(NULL), "workspace is null");

    INVALID(espalier_lattice_create(NULL, positions, &l), "cells is null");
    INVALID(espalier_lattice_create(&c, positions, NULL), "lattice is null");
    INVALID(espalier_lattice_create(&c, positions, &l), "cell_offsets is null");
    INVALID(espalier_lattice_create_hexahedra(BOX_VERTICES, NULL, BOX_CELLS, cells, &l),
            "positions is null");
    INVALID(espalier_lattice_create_hexahedra(BOX_VERTICES, positions, BOX_CELLS, NULL, &l),
            "vertices is null");
    INVALID(espalier_lattice_create_hexahedra(BOX_VERTICES, positions, BOX_CELLS, cells, NULL),
            "lattice is null");
    INVALID(espalier_lattice_read(NULL, &l), "path is null");
    INVALID(espalier_lattice_read("none.vtu", NULL), "lattice is null");
    INVALID(espalier_lattice_write(NULL, "none.vtu"), "lattice is null");
    INVALID(espalier_lattice_write(lattice, NULL), "path is null");
    INVALID(espalier_lattice_counts(NULL, counts), "lattice is null");
    INVALID(espalier_lattice_counts(lattice, NULL), "counts is null");
    INVALID(espalier_lattice_positions(NULL, &count, &view), "lattice is null");
    INVALID(espalier_lattice_positions(lattice, NULL, &view), "vertex_count is null");
    INVALID(espalier_lattice_positions(lattice, &count, NULL), "positions is null");
    INVALID(espalier_lattice_set_positions(NULL, BOX_VERTICES, positions), "lattice is null");
    INVALID(espalier_lattice_set_positions(lattice, BOX_VERTICES, NULL), "positions is null");
    INVALID(espalier_lattice_mark_edges(NULL, 1, cells, point), "lattice is null");
    INVALID(espalier_lattice_mark_edges(lattice, 1, NULL, point), "vertices is null");
    INVALID(espalier_lattice_mark_edges(lattice, 1, cells, NULL), "sharpness is null");
    INVALID(espalier_lattice_mark_vertices(NULL, 1, cells, point), "lattice is null");
    INVALID(espalier_lattice_mark_vertices(lattice, 1, NULL, point), "vertices is null");
    INVALID(espalier_lattice_mark_vertices(lattice, 1, cells, NULL), "sharpness is null");
    INVALID(espalier_lattice_clear_marks(NULL), "lattice is null");
    INVALID(espalier_lattice_topology_hash(NULL, &hash), "lattice is null");
    INVALID(espalier_lattice_topology_hash(lattice, NULL), "hash is null");

    INVALID(espalier_refiner_create(NULL, NULL, &r), "lattice is null");
    INVALID(espalier_refiner_create(lattice, NULL, NULL), "refiner is null");
    INVALID(espalier_refiner_refine(NULL, 1), "refiner is null");
    INVALID(espalier_refiner_max_level(NULL, &count), "refiner is null");
    INVALID(espalier_refiner_max_level(refiner, NULL), "level is null");
    INVALID(espalier_refiner_counts(NULL, 0, counts), "refiner is null");
    INVALID(espalier_refiner_counts(refiner, 0, NULL), "counts is null");
    INVALID(espalier_refiner_cells(NULL, 0, &c), "refiner is null");
    INVALID(espalier_refiner_cells(refiner, 0, NULL), "cells is null");
    INVALID(espalier_refiner_face_signs(NULL, 0, &signs), "refiner is null");
    INVALID(espalier_refiner_face_signs(refiner, 0, NULL), "signs is null");
    INVALID(espalier_refiner_carry_values(NULL, 0, 3, positions, 81, values, 81),
            "refiner is null");
    INVALID(espalier_refiner_carry_values(refiner, 0, 3, NULL, 81, values, 81), "values is null");
    INVALID(espalier_refiner_carry_values(refiner, 0, 3, positions, 81, NULL, 81),
            "result is null");

    INVALID(espalier_table_create_stencils(NULL, 0, &t), "refiner is null");
    INVALID(espalier_table_create_stencils(refiner, 0, NULL), "table is null");
    INVALID(espalier_table_create_level(NULL, 1, &t), "refiner is null");
    INVALID(espalier_table_create_level(refiner, 1, NULL), "table is null");
    INVALID(espalier_table_csr(NULL, &csr), "table is null");
    INVALID(espalier_table_csr(table, NULL), "csr is null");

    INVALID(espalier_binding_create(NULL, BOX_VERTICES, positions, 1, point, NULL, &b),
            "refiner is null");
    INVALID(espalier_binding_create(refiner, BOX_VERTICES, NULL, 1, point, NULL, &b),
            "positions is null");
    INVALID(espalier_binding_create(refiner, BOX_VERTICES, positions, 1, NULL, NULL, &b),
            "points is null");
    INVALID(espalier_binding_create(refiner, BOX_VERTICES, positions, 1, point, NULL, NULL),
            "binding is null");
    INVALID(espalier_binding_save(NULL, "none.espb"), "binding is null");
    INVALID(espalier_binding_save(binding, NULL), "path is null");
    INVALID(espalier_binding_load(NULL, &b), "path is null");
    INVALID(espalier_binding_load("none.espb", NULL), "binding is null");
    INVALID(espalier_binding_table(NULL, &t), "binding is null");
    INVALID(espalier_binding_table(binding, NULL), "table is null");
    INVALID(espalier_binding_topology_hash(NULL, &hash), "binding is null");
    INVALID(espalier_binding_topology_hash(binding, NULL), "hash is null");
    INVALID(espalier_binding_statuses(NULL, &count, &statuses), "binding is null");
    INVALID(espalier_binding_statuses(binding, NULL, &statuses), "point_count is null");
    INVALID(espalier_binding_statuses(binding, &count, NULL), "statuses is null");
    INVALID(espalier_binding_largest_residual(NULL, values), "binding is null");
    INVALID(espalier_binding_largest_residual(binding, NULL), "residual is null");
    INVALID(espalier_binding_apply(NULL, BOX_VERTICES, positions, 1, values), "binding is null");
    INVALID(espalier_binding_apply(binding, BOX_VERTICES, NULL, 1, values), "pose is null");
    INVALID(espalier_binding_apply(binding, BOX_VERTICES, positions, 1, NULL), "points is null");
    INVALID(espalier_binding_rest(NULL, &count, &view, &count, &view), "binding is null");
    INVALID(espalier_binding_rest(binding, NULL, &view, &count, &view), "vertex_count is null");
    INVALID(espalier_binding_rest(binding, &count, NULL, &count, &view), "vertices is null");
    INVALID(espalier_binding_rest(binding, &count, &view, NULL, &view), "point_count is null");
    INVALID(espalier_binding_rest(binding, &count, &view, &count, NULL), "points is null");

    INVALID(espalier_evaluator_f64_create(NULL, &e), "table is null");
    INVALID(espalier_evaluator_f64_create(table, NULL), "evaluator is null");
    INVALID(espalier_evaluator_f32_create(NULL, &s), "table is null");
    INVALID(espalier_evaluator_f32_create(table, NULL), "evaluator is null");
    INVALID(espalier_evaluator_f64_create_adjoint(NULL, &e), "table is null");
    INVALID(espalier_evaluator_f64_create_adjoint(table, NULL), "evaluator is null");
    INVALID(espalier_evaluator_f32_create_adjoint(NULL, &s), "table is null");
    INVALID(espalier_evaluator_f32_create_adjoint(table, NULL), "evaluator is null");
    INVALID(espalier_evaluator_f64_evaluate(NULL, positions, 81, xyz, values, 3, xyz, 0, 1, NULL),
            "evaluator is null");
    INVALID(espalier_evaluator_f64_evaluate(f64, NULL, 81, xyz, values, 3, xyz, 0, 1, NULL),
            "source is null");
    INVALID(espalier_evaluator_f64_evaluate(f64, positions, 81, xyz, NULL, 3, xyz, 0, 1, NULL),
            "destination is null");
    INVALID(espalier_evaluator_f32_evaluate(NULL, singles, 81, xyz, singles, 3, xyz, 0, 1, NULL),
            "evaluator is null");
    INVALID(espalier_evaluator_f32_evaluate(f32, NULL, 81, xyz, singles, 3, xyz, 0, 1, NULL),
            "source is null");
    INVALID(espalier_evaluator_f32_evaluate(f32, singles, 81, xyz, NULL, 3, xyz, 0, 1, NULL),
            "destination is null");

    espalier_deformer_f64* d = NULL;
    espalier_deformer_f32* d32 = NULL;
    INVALID(espalier_deformer_f64_create(NULL, &d), "binding is null");
    INVALID(espalier_deformer_f64_create(binding, NULL), "deformer is null");
    INVALID(espalier_deformer_f32_create(NULL, &d32), "binding is null");
    INVALID(espalier_deformer_f32_create(binding, NULL), "deformer is null");
    CHECK(d32 == NULL);
    const int32_t one = 0;
    INVALID(espalier_deformer_f64_deform(NULL, positions, 81, values, 3), "deformer is null");
    INVALID(espalier_deformer_f32_deform(NULL, singles, 81, singles, 3), "deformer is null");
    INVALID(espalier_deformer_f64_deform_changed(NULL, positions, 81, 1, &one, values, 3),
            "deformer is null");
    INVALID(espalier_deformer_f32_deform_changed(NULL, singles, 81, 1, &one, singles, 3),
            "deformer is null");
    OK(espalier_deformer_f64_create(binding, &d));
    OK(espalier_deformer_f32_create(binding, &d32));
    INVALID(espalier_deformer_f64_deform(d, NULL, 81, values, 3), "poses is null");
    INVALID(espalier_deformer_f64_deform(d, positions, 81, NULL, 3), "points is null");
    INVALID(espalier_deformer_f32_deform(d32, NULL, 81, singles, 3), "poses is null");
    INVALID(espalier_deformer_f32_deform(d32, singles, 81, NULL, 3), "points is null");
    INVALID(espalier_deformer_f64_deform_changed(d, NULL, 81, 1, &one, values, 3), "pose is null");
    INVALID(espalier_deformer_f64_deform_changed(d, positions, 81, 1, NULL, values, 3),
            "changed is null");
    INVALID(espalier_deformer_f64_deform_changed(d, positions, 81, 1, &one, NULL, 3),
            "points is null");
    INVALID(espalier_deformer_f32_deform_changed(d32, singles, 81, 1, NULL, singles, 3),
            "changed is null");
    espalier_deformer_f64_destroy(d);
    espalier_deformer_f32_destroy(d32);

    CHECK(progress == NULL && l == NULL && r == NULL && t == NULL && b == NULL && e == NULL &&
          s == NULL);
    CHECK(view == NULL && numbers == NULL && signs == NULL && statuses == NULL);
}

static void test_bad_cells(void) {
    espalier_lattice* l = NULL;
    INVALID(espalier_lattice_create_hexahedra(-1, positions, BOX_CELLS, cells, &l), "-1");
    INVALID(espalier_lattice_create_hexahedra(BOX_VERTICES, positions, -1, cells, &l), "-1");
    INVALID(espalier_lattice_create_hexahedra(BOX_VERTICES, positions, 0, NULL, &l), "cell");
    INVALID(espalier_lattice_create_hexahedra(26, positions, BOX_CELLS, cells, &l),
            "names vertex 26");

    int64_t cell_offsets[2] = {0, 4};
    int64_t face_offsets[5] = {0, 3, 6, 9, 12};
    int32_t cell_faces[4] = {0, 1, 2, 3};
    const int32_t tetrahedron[12] = {0, 2, 1, 0, 1, 3, 1, 2, 3, 2, 0, 3};
    espalier_cells c = {4, 4, 1, cell_offsets, cell_faces, face_offsets, tetrahedron};
    cell_offsets[0] = 1;
    INVALID(espalier_lattice_create(&c, positions, &l), "cell_offsets[0] is 1");
    cell_offsets[0] = 0;
    face_offsets[2] = 2;
    INVALID(espalier_lattice_create(&c, positions, &l), "face_offsets[2] is 2");
    face_offsets[2] = 6;
    cell_faces[3] = 4;
    INVALID(espalier_lattice_create(&c, positions, &l), "cell 0 names face 4");
    cell_faces[3] = -1;
    INVALID(espalier_lattice_create(&c, positions, &l), "cell 0 names face -1");
    cell_offsets[1] = 3;
    INVALID(espalier_lattice_create(&c, positions, &l), "face 3 is in no cell");
    c.face_count = 3;
    INVALID(espalier_lattice_create(&c, positions, &l), "edge");
    c.face_count = 4;
    cell_offsets[1] = 5;
    c.cell_faces = NULL;
    INVALID(espalier_lattice_create(&c, positions, &l), "cell 0 names face 4");
    c.face_count = -1;
    INVALID(espalier_lattice_create(&c, positions, &l), "face_offsets");
    CHECK(l == NULL);
}

static void test_bad_marks(void) {
    const int32_t none[2] = {0, 26}, beyond = 27;
    const double sharp = ESPALIER_SHARP, negative = -1;
    INVALID(espalier_lattice_mark_edges(lattice, 1, none, &sharp), "26");
    INVALID(espalier_lattice_mark_vertices(lattice, 1, &beyond, &sharp), "27");
    INVALID(espalier_lattice_mark_vertices(lattice, 1, cells, &negative), "-1");
    INVALID(espalier_lattice_mark_vertices(lattice, -1, cells, &sharp), "-1");
    /* Nothing has been marked. */
    espalier_refiner* r = NULL;
    OK(espalier_refiner_create(lattice, NULL, &r));
    espalier_refiner_destroy(r);
}

static void test_bad_options(void) {
    espalier_refiner* r = NULL;
    espalier_binding* b = NULL;
    espalier_refine_options refine = espalier_default_refine_options();
    refine.size = 0;
    INVALID(espalier_refiner_create(lattice, &refine, &r), "espalier_default_refine_options()");
    static const int32_t beyond[5] = {3, 3, 2, 2, 2};
    static const char* const names[5] = {"rules", "boundary", "sharp_edges", "creasing",
                                         "triangles"};
    for (int i = 0; i < 5; ++i) {
        refine = espalier_default_refine_options();
        int32_t* const fields[5] = {&refine.rules, &refine.boundary, &refine.sharp_edges,
                                    &refine.creasing, &refine.triangles};
        *fields[i] = -1;
        INVALID(espalier_refiner_create(lattice, &refine, &r), names[i]);
        *fields[i] = beyond[i];
        INVALID(espalier_refiner_create(lattice, &refine, &r), names[i]);
        --*fields[i];
        OK(espalier_refiner_create(lattice, &refine, &r));
        espalier_refiner_destroy(r);
        r = NULL;
    }

    espalier_bind_options bind = espalier_default_bind_options();
    bind.size += 8;
    INVALID(espalier_binding_create(refiner, BOX_VERTICES, positions, 1, point, &bind, &b),
            "espalier_default_bind_options()");
    bind = espalier_default_bind_options();
    bind.outside = 3;
    INVALID(espalier_binding_create(refiner, BOX_VERTICES, positions, 1, point, &bind, &b),
            "outside: expected 0 to 2, got 3");
    bind = espalier_default_bind_options();
    bind.level = 0;
    INVALID(espalier_binding_create(refiner, BOX_VERTICES, positions, 1, point, &bind, &b),
            "level: expected 1 to 20 to bind points, got 0");
    bind = espalier_default_bind_options();
    bind.tolerance = NAN;
    INVALID(espalier_binding_create(refiner, BOX_VERTICES, positions, 1, point, &bind, &b),
            "tolerance: expected a finite number of 0 or more, got nan");
    bind = espalier_default_bind_options();
    bind.limit_tolerance = -1;
    INVALID(espalier_binding_create(refiner, BOX_VERTICES, positions, 1, point, &bind, &b),
            "limit_tolerance: expected 1e-14 to 0.1, got -1");
    espalier_progress_scope* progress = NULL;
    INVALID(espalier_progress_scope_create(keep_going, NULL, -1, &progress),
            "milliseconds: expected 0 or more, got -1");
    espalier_thread_limit* limit = NULL;
    INVALID(espalier_thread_limit_create(0, &limit), "threads: expected 1 or more, got 0");
    espalier_memory_limit* memory = NULL;
    INVALID(espalier_memory_limit_create(0, &memory), "bytes: expected 1 or more, got 0");
    CHECK(b == NULL && limit == NULL && progress == NULL);
}

static void test_bad_sizes(void) {
    double values[3 * BOX_VERTICES];
    int32_t counts[4];
    espalier_binding* b = NULL;
    espalier_table* t = NULL;
    const espalier_buffer_layout xyz = espalier_packed_layout(3), xy = espalier_packed_layout(2);
    const espalier_buffer_layout senseless = {0, 3, 2};
    INVALID(espalier_lattice_set_positions(lattice, 26, positions), "expected 27");
    INVALID(espalier_refiner_refine(refiner, -1), "level: expected 0 or more, got -1");
    INVALID(espalier_refiner_counts(refiner, 1, counts), "level 1");
    INVALID(espalier_table_create_stencils(refiner, 1, &t), "level 1");
    INVALID(espalier_table_create_level(refiner, 0, &t), "level 0");
    INVALID(espalier_refiner_carry_values(refiner, 0, 3, positions, 80, values, 81), "80");
    INVALID(espalier_refiner_carry_values(refiner, 0, 3, positions, 81, values, 80), "80");
    INVALID(espalier_refiner_carry_values(refiner, 0, 0, positions, 0, values, 0),
            "components: expected 1 or more, got 0");
    INVALID(espalier_refiner_carry_values(refiner, 0, -1, positions, 0, values, 0),
            "components: expected 1 or more, got -1");
    INVALID(espalier_binding_create(refiner, 26, positions, 1, point, NULL, &b), "26");
    INVALID(espalier_binding_apply(binding, 26, positions, 1, values), "26");
    INVALID(espalier_binding_apply(binding, BOX_VERTICES, positions, 2, values), "got 2");
    values[0] = -7;
    INVALID(espalier_evaluator_f64_evaluate(f64, positions, 80, xyz, values, 3, xyz, 0, 1, NULL),
            "source");
    INVALID(espalier_evaluator_f64_evaluate(f64, positions, 81, xyz, values, 2, xyz, 0, 1, NULL),
            "destination");
    INVALID(espalier_evaluator_f64_evaluate(f64, positions, 81, xyz, values, 3, xy, 0, 1, NULL),
            "components");
    INVALID(
        espalier_evaluator_f64_evaluate(f64, positions, 81, senseless, values, 3, xyz, 0, 1, NULL),
        "stride 2");
    INVALID(espalier_evaluator_f64_evaluate(f64, positions, 81, xyz, values, 3, xyz, 0, 2, NULL),
            "rows 0 to 2");
    INVALID(espalier_evaluator_f64_evaluate(f64, positions, -1, xyz, values, 3, xyz, 0, 1, NULL),
            "-1");
    CHECK(values[0] == -7 && b == NULL && t == NULL);
}

static void test_files(void) {
    espalier_lattice* l = NULL;
    espalier_binding* b = NULL;
    REFUSED(espalier_lattice_read("none.vtu", &l), ESPALIER_ERROR_FILE, "none.vtu: ");
    REFUSED(espalier_lattice_read("none.txt", &l), ESPALIER_ERROR_FILE, "none.txt: ");
    REFUSED(espalier_lattice_write(lattice, "no/such/folder.vtu"), ESPALIER_ERROR_FILE, "no/such");
    REFUSED(espalier_binding_load("none.espb", &b), ESPALIER_ERROR_FILE, "none.espb: ");
    REFUSED(espalier_binding_save(binding, "no/such/folder.espb"), ESPALIER_ERROR_FILE, "no/such");
    CHECK(l == NULL && b == NULL);
}

int main(void) {
    CHECK(strcmp(espalier_last_error(), "") == 0);
    set_up();
    CHECK(strcmp(espalier_last_error(), "") == 0);
    test_destroying_null_does_nothing();
    test_null_is_an_error();
    test_bad_cells();
    test_bad_marks();
    test_bad_options();
    test_bad_sizes();
    test_files();
    /* A call that succeeds keeps the message of the last call that failed. */
    espalier_thread_limit* limit = NULL;
    OK(espalier_thread_limit_create(1, &limit));
    CHECK(strstr(espalier_last_error(), "no/such") != NULL);
    espalier_thread_limit_destroy(limit);

    espalier_evaluator_f32_destroy(f32);
    espalier_evaluator_f64_destroy(f64);
    espalier_table_destroy(table);
    espalier_binding_destroy(binding);
    espalier_refiner_destroy(refiner);
    espalier_lattice_destroy(lattice);
    return 0;
}
