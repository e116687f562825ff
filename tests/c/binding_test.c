/* SPDX-License-Identifier: Apache-2.0 */
/* Tests bindings: poses, gradients, saving and loading. */

#include <math.h>

#include "box.h"
#include "check.h"

/* The rounding of up to 27 products of numbers up to 4: a few units of 1e-16 each. */
static const double tolerance = 1e-13;

enum { POINTS = 6, OUTSIDE = 4 };
static const double points[3 * POINTS] = {0.1, 0.2, 0.3, 0.5, 0.5, 0.5, 0.9, 0.1, 0.7,
                                          0,   1,   0.5, 2,   2,   2,   0.3, 0.8, 0.05};

/* The objects that every test uses. */
typedef struct fixture {
    double rest[3 * BOX_VERTICES];
    double pose[3 * BOX_VERTICES];
    espalier_lattice* lattice;
    espalier_refiner* refiner;
    espalier_binding* binding;
    espalier_table* table;
} fixture;

static fixture set_up(void) {
    fixture f;
    int32_t cells[8 * BOX_CELLS];
    make_box(f.rest, cells);
    for (int i = 0; i < 3 * BOX_VERTICES; ++i) f.pose[i] = f.rest[i] + 0.2 * sin(i);
    OK(espalier_lattice_create_hexahedra(BOX_VERTICES, f.rest, BOX_CELLS, cells, &f.lattice));
    OK(espalier_refiner_create(f.lattice, NULL, &f.refiner));
    espalier_bind_options options = espalier_default_bind_options();
    options.level = 1;
    OK(espalier_binding_create(f.refiner, BOX_VERTICES, f.rest, POINTS, points, &options,
                               &f.binding));
    OK(espalier_binding_table(f.binding, &f.table));
    return f;
}

static void tear_down(fixture* f) {
    /* The lattice first: objects can be destroyed in any order. */
    espalier_lattice_destroy(f->lattice);
    espalier_refiner_destroy(f->refiner);
    espalier_binding_destroy(f->binding);
    espalier_table_destroy(f->table);
}

static void apply(const espalier_binding* binding, const double* pose, double* moved) {
    OK(espalier_binding_apply(binding, BOX_VERTICES, pose, POINTS, moved));
}

static void test_point_statuses(void) {
    fixture f = set_up();
    int32_t count = 0;
    const uint8_t* statuses = NULL;
    OK(espalier_binding_statuses(f.binding, &count, &statuses));
    CHECK(count == POINTS);
    for (int i = 0; i < POINTS; ++i)
        CHECK(statuses[i] == (i == OUTSIDE ? ESPALIER_POINT_OUTSIDE : ESPALIER_POINT_INSIDE));
    double residual = -1;
    OK(espalier_binding_largest_residual(f.binding, &residual));
    CHECK(residual >= 0 && residual < tolerance);
    uint64_t hash = 0, bound_hash = 1;
    OK(espalier_lattice_topology_hash(f.lattice, &hash));
    OK(espalier_binding_topology_hash(f.binding, &bound_hash));
    CHECK(hash == bound_hash);
    tear_down(&f);
}

/* A lattice that moves moves its points; at rest they stay. */
static void test_apply(void) {
    fixture f = set_up();
    double moved[3 * POINTS];
    apply(f.binding, f.rest, moved);
    CHECK(memcmp(moved, points, sizeof points) == 0);
    for (int i = 0; i < 3 * BOX_VERTICES; ++i) f.pose[i] = f.rest[i] + 1 + i % 3;
    apply(f.binding, f.pose, moved);
    for (int i = 0; i < 3 * POINTS; ++i)
        CHECK(fabs(moved[i] - points[i] - (i / 3 == OUTSIDE ? 0 : 1 + i % 3)) < tolerance);
    tear_down(&f);
}

/* An evaluator computes D · p: in single precision with its accuracy, for a single row, and after
 * the table is gone. Numbers between entries are not written. */
static void test_evaluators(void) {
    fixture f = set_up();
    double moved[3 * POINTS];
    apply(f.binding, f.pose, moved);
    for (int k = 0; k < 3; ++k) moved[3 * OUTSIDE + k] = 0; /* its row is empty */
    /* The evaluators outlive the table, and the table outlives the binding. */
    espalier_evaluator_f64* f64 = NULL;
    espalier_evaluator_f32* f32 = NULL;
    OK(espalier_evaluator_f64_create(f.table, &f64));
    OK(espalier_evaluator_f32_create(f.table, &f32));

    const espalier_buffer_layout xyz = espalier_packed_layout(3);
    const espalier_buffer_layout apart = {1, 3, 5};
    double wide[5 * POINTS];
    for (int i = 0; i < 5 * POINTS; ++i) wide[i] = -7;
    OK(espalier_evaluator_f64_evaluate(f64, f.pose, 3 * BOX_VERTICES, xyz, wide, 5 * POINTS, apart,
                                       0, POINTS, NULL));
    for (int i = 0; i < POINTS; ++i) {
        for (int k = 0; k < 3; ++k) CHECK(fabs(wide[5 * i + 1 + k] - moved[3 * i + k]) < tolerance);
        CHECK(wide[5 * i] == -7 && wide[5 * i + 4] == -7);
    }

    float source[3 * BOX_VERTICES], result[3 * POINTS];
    for (int i = 0; i < 3 * BOX_VERTICES; ++i) source[i] = (float)f.pose[i];
    OK(espalier_evaluator_f32_evaluate(f32, source, 3 * BOX_VERTICES, xyz, result, 3 * POINTS, xyz,
                                       0, POINTS, NULL));
    /* A few units of 6e-8 for each of 27 products. */
    for (int i = 0; i < 3 * POINTS; ++i) CHECK(fabs((double)result[i] - moved[i]) < 1e-5);

    /* A single row. */
    double row[3 * POINTS] = {0};
    OK(espalier_evaluator_f64_evaluate(f64, f.pose, 3 * BOX_VERTICES, xyz, row, 3 * POINTS, xyz, 1,
                                       2, NULL));
    CHECK(row[0] == 0 && row[6] == 0 && fabs(row[3] - moved[3]) < tolerance);
    tear_down(&f);
    OK(espalier_evaluator_f64_evaluate(f64, f.pose, 3 * BOX_VERTICES, xyz, row, 3 * POINTS, xyz, 0,
                                       POINTS, NULL));
    CHECK(fabs(row[0] - moved[0]) < tolerance);
    espalier_evaluator_f64_destroy(f64);
    espalier_evaluator_f32_destroy(f32);
}

/* Deformers in both precisions give the points of espalier_binding_apply(), for six poses in one
 * call; at rest each point stays exactly where it is. They outlive the binding. */
static void test_deformers(void) {
    fixture f = set_up();
    enum { POSES = 6, POSE = 3 * BOX_VERTICES, MODEL = 3 * POINTS };
    int32_t vertex_count = 0, point_count = 0;
    const double *vertices = NULL, *at_rest = NULL;
    OK(espalier_binding_rest(f.binding, &vertex_count, &vertices, &point_count, &at_rest));
    CHECK(vertex_count == BOX_VERTICES && point_count == POINTS);
    CHECK(memcmp(vertices, f.rest, sizeof f.rest) == 0);
    CHECK(memcmp(at_rest, points, sizeof points) == 0);

    espalier_deformer_f64* f64 = NULL;
    espalier_deformer_f32* f32 = NULL;
    OK(espalier_deformer_f64_create(f.binding, &f64));
    OK(espalier_deformer_f32_create(f.binding, &f32));
    double poses[POSES * POSE], result[POSES * MODEL], expected[POSES * MODEL];
    float poses_f32[POSES * POSE], result_f32[POSES * MODEL];
    for (int pose = 0; pose < POSES; ++pose) {
        double* const own = poses + pose * POSE;
        for (int i = 0; i < POSE; ++i) {
            own[i] = f.rest[i] + pose * (f.pose[i] - f.rest[i]);
            poses_f32[pose * POSE + i] = (float)own[i];
        }
        apply(f.binding, own, expected + pose * MODEL);
    }
    espalier_binding_destroy(f.binding);
    f.binding = NULL;
    OK(espalier_deformer_f64_deform(f64, poses, POSES * POSE, result, POSES * MODEL));
    OK(espalier_deformer_f32_deform(f32, poses_f32, POSES * POSE, result_f32, POSES * MODEL));
    for (int i = 0; i < POSES * MODEL; ++i) {
        CHECK(fabs(result[i] - expected[i]) < tolerance);
        CHECK(fabs((double)result_f32[i] - expected[i]) < 1e-5);
    }
    CHECK(memcmp(result, points, sizeof points) == 0);
    for (int i = 0; i < MODEL; ++i) CHECK(result_f32[i] == (float)points[i]);

    /* Two vertices move: the points that depend on them, and no others, are computed again. */
    const int32_t changed[2] = {BOX_VERTICES - 1, 0}, bad = BOX_VERTICES;
    for (int k = 0; k < 2; ++k) {
        poses[3 * changed[k]] += 0.25;
        poses_f32[3 * changed[k]] += 0.25f;
    }
    double whole[MODEL];
    float whole_f32[MODEL];
    OK(espalier_deformer_f64_deform_changed(f64, poses, POSE, 2, changed, result, MODEL));
    OK(espalier_deformer_f32_deform_changed(f32, poses_f32, POSE, 2, changed, result_f32, MODEL));
    OK(espalier_deformer_f64_deform(f64, poses, POSE, whole, MODEL));
    OK(espalier_deformer_f32_deform(f32, poses_f32, POSE, whole_f32, MODEL));
    CHECK(memcmp(result, whole, sizeof whole) == 0);
    CHECK(memcmp(result_f32, whole_f32, sizeof whole_f32) == 0);
    INVALID(espalier_deformer_f64_deform_changed(f64, poses, POSE, 1, &bad, result, MODEL),
            "vertex 27 is not in the lattice, which has 27 vertices");

    INVALID(espalier_deformer_f64_deform(f64, poses, POSE - 1, result, MODEL),
            "each pose of 27 vertices has 81 numbers; got 80");
    INVALID(espalier_deformer_f32_deform(f32, poses_f32, POSE, result_f32, MODEL + 1),
            "the points of 1 pose are 18 numbers; there is room for 19");
    INVALID(espalier_deformer_f32_deform_changed(f32, poses_f32, 2 * POSE, 2, changed, result_f32,
                                                 2 * MODEL),
            "a change is of one pose; got 2");
    espalier_deformer_f64_destroy(f64);
    espalier_deformer_f32_destroy(f32);
    tear_down(&f);
}

/* <D p, g> = <p, Dᵀ g> */
static void test_adjoint(void) {
    fixture f = set_up();
    espalier_evaluator_f64 *forward = NULL, *backward = NULL;
    espalier_evaluator_f32* single = NULL;
    OK(espalier_evaluator_f64_create(f.table, &forward));
    OK(espalier_evaluator_f64_create_adjoint(f.table, &backward));
    OK(espalier_evaluator_f32_create_adjoint(f.table, &single));
    double gradient[3 * POINTS], moved[3 * POINTS], carried[3 * BOX_VERTICES];
    float gradient_f32[3 * POINTS], carried_f32[3 * BOX_VERTICES];
    for (int i = 0; i < 3 * POINTS; ++i) {
        gradient[i] = cos(i);
        gradient_f32[i] = (float)gradient[i];
    }
    const espalier_buffer_layout xyz = espalier_packed_layout(3);
    OK(espalier_evaluator_f64_evaluate(forward, f.pose, 3 * BOX_VERTICES, xyz, moved, 3 * POINTS,
                                       xyz, 0, POINTS, NULL));
    OK(espalier_evaluator_f64_evaluate(backward, gradient, 3 * POINTS, xyz, carried,
                                       3 * BOX_VERTICES, xyz, 0, BOX_VERTICES, NULL));
    OK(espalier_evaluator_f32_evaluate(single, gradient_f32, 3 * POINTS, xyz, carried_f32,
                                       3 * BOX_VERTICES, xyz, 0, BOX_VERTICES, NULL));
    double left = 0, right = 0;
    for (int i = 0; i < 3 * POINTS; ++i) left += moved[i] * gradient[i];
    for (int i = 0; i < 3 * BOX_VERTICES; ++i) {
        right += f.pose[i] * carried[i];
        /* A few units of 6e-8 for each of 6 products. */
        CHECK(fabs((double)carried_f32[i] - carried[i]) < 1e-5);
    }
    CHECK(fabs(left) > 0.1);
    CHECK(fabs(left - right) < tolerance);
    espalier_evaluator_f64_destroy(forward);
    espalier_evaluator_f64_destroy(backward);
    espalier_evaluator_f32_destroy(single);
    tear_down(&f);
}

/* A loaded binding equals the saved one, bit for bit. */
static void test_save_and_load(const char* path) {
    fixture f = set_up();
    double before[3 * POINTS], after[3 * POINTS];
    apply(f.binding, f.pose, before);
    OK(espalier_binding_save(f.binding, path));
    espalier_binding* loaded = NULL;
    OK(espalier_binding_load(path, &loaded));
    apply(loaded, f.pose, after);
    CHECK(memcmp(before, after, sizeof before) == 0);

    espalier_table* loaded_table = NULL;
    OK(espalier_binding_table(loaded, &loaded_table));
    espalier_csr a, b;
    OK(espalier_table_csr(f.table, &a));
    OK(espalier_table_csr(loaded_table, &b));
    CHECK(a.row_count == POINTS && a.column_count == BOX_VERTICES);
    CHECK(a.row_count == b.row_count && a.column_count == b.column_count);
    const size_t rows = POINTS, entries = (size_t)a.offsets[POINTS];
    CHECK(memcmp(a.offsets, b.offsets, (rows + 1) * sizeof *a.offsets) == 0);
    CHECK(memcmp(a.columns, b.columns, entries * sizeof *a.columns) == 0);
    CHECK(memcmp(a.weights, b.weights, entries * sizeof *a.weights) == 0);
    uint64_t hash = 0, loaded_hash = 1;
    OK(espalier_binding_topology_hash(f.binding, &hash));
    OK(espalier_binding_topology_hash(loaded, &loaded_hash));
    CHECK(hash == loaded_hash);

    int32_t count = 0, vertex_count = 0;
    const double *vertices = NULL, *at_rest = NULL;
    OK(espalier_binding_rest(loaded, &vertex_count, &vertices, &count, &at_rest));
    CHECK(vertex_count == BOX_VERTICES && memcmp(vertices, f.rest, sizeof f.rest) == 0);
    CHECK(count == POINTS && memcmp(at_rest, points, sizeof points) == 0);

    const uint8_t* statuses = NULL;
    double residual = 0;
    OK(espalier_binding_statuses(loaded, &count, &statuses));
    CHECK(count == POINTS && statuses[OUTSIDE] == ESPALIER_POINT_OUTSIDE && statuses[0] == 0);
    OK(espalier_binding_largest_residual(loaded, &residual));
    CHECK(residual < tolerance);
    espalier_table_destroy(loaded_table);
    espalier_binding_destroy(loaded);
    tear_down(&f);
}

static void test_points_outside(void) {
    fixture f = set_up();
    espalier_bind_options options = espalier_default_bind_options();
    options.level = 1;
    options.outside = ESPALIER_OUTSIDE_NEAREST;
    espalier_binding* nearest = NULL;
    OK(espalier_binding_create(f.refiner, BOX_VERTICES, f.rest, POINTS, points, &options,
                               &nearest));
    /* The weights of the point would sum to more than 8: it stays. */
    double moved[3 * POINTS];
    for (int i = 0; i < 3 * BOX_VERTICES; ++i) f.pose[i] = f.rest[i] + 1;
    apply(nearest, f.pose, moved);
    CHECK(moved[3 * OUTSIDE] == 2 && fabs(moved[0] - 1.1) < tolerance);
    espalier_binding_destroy(nearest);
    double near[3 * POINTS];
    memcpy(near, points, sizeof near);
    for (int axis = 0; axis < 3; ++axis) near[3 * OUTSIDE + axis] = axis == 2 ? 1.2 : 0.5;
    OK(espalier_binding_create(f.refiner, BOX_VERTICES, f.rest, POINTS, near, &options, &nearest));
    apply(nearest, f.pose, moved);
    CHECK(fabs(moved[3 * OUTSIDE] - 1.5) < tolerance);
    espalier_binding_destroy(nearest);

    espalier_binding* none = NULL;
    options.outside = ESPALIER_OUTSIDE_REFUSE;
    INVALID(
        espalier_binding_create(f.refiner, BOX_VERTICES, f.rest, POINTS, points, &options, &none),
        "point 4");
    CHECK(none == NULL);
    /* With a tolerance this large, the point counts as inside. */
    options.tolerance = 2;
    OK(espalier_binding_create(f.refiner, BOX_VERTICES, f.rest, POINTS, points, &options, &none));
    espalier_binding_destroy(none);
    tear_down(&f);
}

static espalier_binding* bind_with_gradients(const fixture* f, const double* at,
                                             double limit_tolerance) {
    espalier_bind_options options = espalier_default_bind_options();
    options.limit_tolerance = limit_tolerance;
    options.gradients = 1;
    espalier_binding* binding = NULL;
    OK(espalier_binding_create(f->refiner, BOX_VERTICES, f->rest, POINTS, at, &options, &binding));
    return binding;
}

/* An affine pose has its matrix as gradient everywhere; the point outside has the identity. */
static void test_gradients_of_an_affine_pose(void) {
    fixture f = set_up();
    const double matrix[9] = {1.5, 0.25, 0, 0, 1, -0.5, 0.125, 0, 2};
    for (int v = 0; v < BOX_VERTICES; ++v)
        for (int i = 0; i < 3; ++i) {
            f.pose[3 * v + i] = i;
            for (int j = 0; j < 3; ++j) f.pose[3 * v + i] += matrix[3 * i + j] * f.rest[3 * v + j];
        }
    /* 0 is a level; in the limit points are placed within 1e-12, and cells are 1/2 wide or more. */
    for (int is_limit = 0; is_limit < 2; ++is_limit) {
        espalier_binding* binding = bind_with_gradients(&f, points, is_limit ? 1e-6 : 0);
        double found[9 * POINTS];
        OK(espalier_binding_gradients(binding, BOX_VERTICES, f.pose, POINTS, found));
        for (int point = 0; point < POINTS; ++point)
            for (int k = 0; k < 9; ++k) {
                const double expected = point == OUTSIDE ? k % 4 == 0 : matrix[k];
                CHECK(fabs(found[9 * point + k] - expected) < 1e-10);
            }
        espalier_binding_destroy(binding);
    }
    tear_down(&f);
}

/* Of another pose, the gradient is the limit of difference quotients. */
static void test_gradients_are_difference_quotients(void) {
    fixture f = set_up();
    const double h = 1e-4;
    double found[9 * POINTS];
    espalier_binding* binding = bind_with_gradients(&f, points, 1e-6);
    OK(espalier_binding_gradients(binding, BOX_VERTICES, f.pose, POINTS, found));
    espalier_binding_destroy(binding);
    for (int j = 0; j < 3; ++j) {
        double moved[2][3 * POINTS];
        for (int side = 0; side < 2; ++side) {
            double at[3 * POINTS];
            memcpy(at, points, sizeof at);
            for (int point = 0; point < POINTS; ++point) at[3 * point + j] += side ? h : -h;
            espalier_binding* beside = bind_with_gradients(&f, at, 1e-6);
            apply(beside, f.pose, moved[side]);
            espalier_binding_destroy(beside);
        }
        for (int point = 0; point < POINTS; ++point) {
            if (point == 3 || point == OUTSIDE) continue; /* a point beside point 3 is outside */
            for (int i = 0; i < 3; ++i) {
                const double quotient =
                    (moved[1][3 * point + i] - moved[0][3 * point + i]) / (2 * h);
                /* The pose moves vertices by 0.2: third derivatives are below 100 in cells of 1/2,
                   so the error is below 100 h^2 / 6 = 2e-7. */
                CHECK(fabs(found[9 * point + 3 * i + j] - quotient) < 2e-7);
            }
        }
    }
    tear_down(&f);
}

static void test_gradients_that_are_missing(void) {
    fixture f = set_up();
    double found[9 * POINTS];
    INVALID(espalier_binding_gradients(f.binding, BOX_VERTICES, f.pose, POINTS, found),
            "the binding has no gradients");
    tear_down(&f);
}

/* The displacements are those of full weights, times the weights. */
static void test_weights(void) {
    fixture f = set_up();
    espalier_bind_options options = espalier_default_bind_options();
    options.level = 1;
    double weights[POINTS], slopes[3 * POINTS], full[3 * POINTS], moved[3 * POINTS];
    for (int i = 0; i < POINTS; ++i) weights[i] = i % 3 * 0.5;
    for (int i = 0; i < 3 * POINTS; ++i) slopes[i] = 0.25;
    espalier_binding* binding = NULL;
    apply(f.binding, f.pose, full);
    options.weights = weights;
    OK(espalier_binding_create(f.refiner, BOX_VERTICES, f.rest, POINTS, points, &options,
                               &binding));
    apply(binding, f.pose, moved);
    const uint8_t* statuses = NULL;
    int32_t count = 0;
    OK(espalier_binding_statuses(binding, &count, &statuses));
    for (int i = 0; i < 3 * POINTS; ++i) {
        const double expected = points[i] + weights[i / 3] * (full[i] - points[i]);
        CHECK(fabs(moved[i] - expected) < 1e-14); /* rounding */
        CHECK((statuses[i / 3] == ESPALIER_POINT_NOT_BOUND) == (weights[i / 3] == 0));
    }
    espalier_binding_destroy(binding);
    /* F = 1 + w (F of full weights - 1) + d slopes^T. */
    double gradients[9 * POINTS], ofFull[9 * POINTS];
    options.gradients = 1;
    options.weight_slopes = slopes;
    OK(espalier_binding_create(f.refiner, BOX_VERTICES, f.rest, POINTS, points, &options,
                               &binding));
    OK(espalier_binding_gradients(binding, BOX_VERTICES, f.pose, POINTS, gradients));
    espalier_binding_destroy(binding);
    options.weights = options.weight_slopes = NULL;
    OK(espalier_binding_create(f.refiner, BOX_VERTICES, f.rest, POINTS, points, &options,
                               &binding));
    OK(espalier_binding_gradients(binding, BOX_VERTICES, f.pose, POINTS, ofFull));
    espalier_binding_destroy(binding);
    for (int i = 0; i < 9 * POINTS; ++i) {
        const int point = i / 9, row = i % 9 / 3, column = i % 3;
        const double one = row == column, d = full[3 * point + row] - points[3 * point + row];
        const double expected =
            weights[point] == 0 ? one : one + weights[point] * (ofFull[i] - one) + 0.25 * d;
        CHECK(fabs(gradients[i] - expected) < 1e-13); /* rounding */
    }
    /* Only bindings have weights. */
    espalier_table* table = NULL;
    options.falloff = 0.5;
    espalier_table* own = NULL;
    OK(espalier_binding_table(f.binding, &own));
    double* child_pose = malloc(sizeof f.rest[0] * 3 * BOX_VERTICES);
    CHECK(child_pose);
    memcpy(child_pose, f.rest, sizeof f.rest[0] * 3 * BOX_VERTICES);
    options.gradients = 0;
    INVALID(espalier_table_create_nested(own, BOX_VERTICES, child_pose, f.refiner, BOX_VERTICES,
                                         f.rest, &options, &table),
            "falloff");
    free(child_pose);
    espalier_table_destroy(own);
    tear_down(&f);
}

/* Programs that were compiled with the options of an earlier version still bind to the level. */
static void test_options_of_an_earlier_version(void) {
    fixture f = set_up();
    espalier_bind_options options = espalier_default_bind_options();
    espalier_binding* binding = NULL;
    double expected[3 * POINTS], moved[3 * POINTS];
    OK(espalier_binding_create(f.refiner, BOX_VERTICES, f.rest, POINTS, points, &options,
                               &binding));
    apply(binding, f.pose, expected);
    espalier_binding_destroy(binding);
    options.size = offsetof(espalier_bind_options, limit_tolerance);
    options.limit_tolerance = 1e-6; /* ignored, since `size` ends before it */
    OK(espalier_binding_create(f.refiner, BOX_VERTICES, f.rest, POINTS, points, &options,
                               &binding));
    apply(binding, f.pose, moved);
    CHECK(memcmp(moved, expected, sizeof moved) == 0);
    espalier_binding_destroy(binding);
    tear_down(&f);
}

/* A refiner with more levels gives the same binding. */
static void test_binding_ignores_levels_of_the_refiner(void) {
    fixture f = set_up();
    double before[3 * POINTS], after[3 * POINTS];
    apply(f.binding, f.pose, before);
    OK(espalier_refiner_refine(f.refiner, 2));
    espalier_bind_options options = espalier_default_bind_options();
    options.level = 1;
    espalier_binding* other = NULL;
    OK(espalier_binding_create(f.refiner, BOX_VERTICES, f.rest, POINTS, points, &options, &other));
    apply(other, f.pose, after);
    CHECK(memcmp(before, after, sizeof before) == 0);
    espalier_binding_destroy(other);
    tear_down(&f);
}

int main(int count, char** arguments) {
    CHECK(count == 2);
    test_point_statuses();
    test_apply();
    test_evaluators();
    test_deformers();
    test_adjoint();
    test_save_and_load(arguments[1]);
    test_points_outside();
    test_gradients_of_an_affine_pose();
    test_gradients_are_difference_quotients();
    test_gradients_that_are_missing();
    test_weights();
    test_options_of_an_earlier_version();
    test_binding_ignores_levels_of_the_refiner();
    return 0;
}
