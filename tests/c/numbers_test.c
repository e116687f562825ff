/* SPDX-License-Identifier: Apache-2.0 */
/* Passes NaN and the infinities for each real number of each function. The message must name the
 * argument. symbols_test.py checks that no function with a real number is missing here.
 *
 * These functions pass numbers on as they are, because they are products with a matrix, which also
 * run where no error can be handled:
 *   espalier_evaluator_f64_evaluate(), espalier_evaluator_f32_evaluate(),
 *   espalier_deformer_f64_deform(), espalier_deformer_f32_deform(),
 *   espalier_deformer_f64_deform_changed(), espalier_deformer_f32_deform_changed(),
 *   espalier_refiner_carry_values(). */

#include <math.h>

#include "box.h"
#include "check.h"

enum { N = BOX_VERTICES };

static double rest[3 * N];
static int32_t cells[8 * BOX_CELLS];
static espalier_lattice* lattice;
static espalier_refiner* refiner;

/* What the calls make; destroyed after each. */
static espalier_lattice* made;
static espalier_binding* binding;
static espalier_table* table;
static espalier_validity* validity;

static void destroy_results(void) {
    espalier_lattice_destroy(made);
    espalier_binding_destroy(binding);
    espalier_table_destroy(table);
    espalier_validity_destroy(validity);
    made = NULL;
    binding = NULL;
    table = NULL;
    validity = NULL;
}

/* Checks that a call succeeds, and that it is refused, with a message that contains `text`, once
 * `number` is not finite. */
#define FINITE(number, text, call)                                                       \
    do {                                                                                 \
        const double bad[3] = {NAN, INFINITY, -INFINITY}, good_ = (number);              \
        OK(call);                                                                        \
        destroy_results();                                                               \
        for (int bad_ = 0; bad_ < 3; ++bad_) {                                           \
            (number) = bad[bad_];                                                        \
            INVALID(call, text);                                                         \
            CHECK(made == NULL && binding == NULL && table == NULL && validity == NULL); \
            (number) = good_;                                                            \
        }                                                                                \
    } while (0)

static void test_lattices(void) {
    double positions[3 * N];
    memcpy(positions, rest, sizeof rest);
    FINITE(positions[5], "positions[1] is (0.5, 0, ",
           espalier_lattice_create_hexahedra(N, positions, BOX_CELLS, cells, &made));
    FINITE(positions[5], "positions[1] is (0.5, 0, ",
           espalier_lattice_set_positions(lattice, N, positions));
    int64_t cell_offsets[2] = {0, 4}, face_offsets[5] = {0, 3, 6, 9, 12};
    int32_t cell_faces[4] = {0, 1, 2, 3};
    const int32_t faces[12] = {0, 2, 1, 0, 1, 3, 1, 2, 3, 2, 0, 3};
    const espalier_cells tetrahedron = {4, 4, 1, cell_offsets, cell_faces, face_offsets, faces};
    double corners[12] = {0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1};
    FINITE(corners[0], "positions[0] is (", espalier_lattice_create(&tetrahedron, corners, &made));

    /* An infinite sharpness is sharp. */
    double sharpness = NAN;
    INVALID(espalier_lattice_mark_edges(lattice, 1, cells, &sharpness), "sharpness nan");
    INVALID(espalier_lattice_mark_vertices(lattice, 1, cells, &sharpness), "sharpness nan");
    sharpness = -INFINITY;
    INVALID(espalier_lattice_mark_edges(lattice, 1, cells, &sharpness), "sharpness -inf");
    INVALID(espalier_lattice_mark_vertices(lattice, 1, cells, &sharpness), "sharpness -inf");
}

static void test_shapes(void) {
    const int32_t counts[3] = {1, 1, 1};
    double low[3] = {0, 0, 0}, high[3] = {1, 1, 1};
    FINITE(low[1], "min[1]: expected", espalier_lattice_create_box(counts, low, high, &made));
    FINITE(high[2], "max[2]: expected", espalier_lattice_create_box(counts, low, high, &made));

    double points[6] = {0, 0, 0, 4, 2, 1};
    espalier_around_options around = espalier_default_around_options();
    FINITE(points[4], "points[1] is (4, ",
           espalier_lattice_create_around(2, points, &around, &made));
    FINITE(around.cell_size, "cell_size: expected",
           espalier_lattice_create_around(2, points, &around, &made));
    FINITE(around.margin, "margin: expected",
           espalier_lattice_create_around(2, points, &around, &made));

    around.symmetry_axis = 0;
    FINITE(around.symmetry_at, "symmetry_at: expected",
           espalier_lattice_create_around(2, points, &around, &made));

    espalier_lattice* base = NULL;
    OK(espalier_lattice_create_box(counts, low, high, &base));
    espalier_collar_options collar = espalier_default_collar_options();
    collar.reach = 1;
    FINITE(collar.reach, "reach: expected", espalier_lattice_create_collar(base, &collar, &made));
    double box[6] = {-1, -1, -1, 4, 4, 4};
    collar.reach = 0;
    collar.until = box;
    FINITE(box[4], "until", espalier_lattice_create_collar(base, &collar, &made));
    espalier_lattice_destroy(base);

    double radius = 1, height = 1, from[3] = {0, 0, 0}, to[3] = {0, 0, 1};
#define CYLINDER espalier_lattice_create_cylinder(4, 1, 0, 1, radius, from, to, &made)
    FINITE(radius, "radius: expected", CYLINDER);
    FINITE(from[0], "from: expected", CYLINDER);
    FINITE(to[2], "to: expected", CYLINDER);
    FINITE(radius, "radius: expected", espalier_lattice_create_regular_solid(0, radius, &made));
    FINITE(radius, "radius: expected",
           espalier_lattice_create_polygonal_solid(0, 3, radius, height, &made));
    FINITE(height, "height: expected",
           espalier_lattice_create_polygonal_solid(0, 3, radius, height, &made));

    espalier_torus_options torus = espalier_default_torus_options();
    FINITE(torus.major_radius, "major_radius: expected",
           espalier_lattice_create_torus(&torus, &made));
    FINITE(torus.minor_radius, "minor_radius: expected",
           espalier_lattice_create_torus(&torus, &made));
    espalier_star_options star = espalier_default_star_options();
    FINITE(star.inner_radius, "inner_radius: expected", espalier_lattice_create_star(&star, &made));
    FINITE(star.outer_radius, "outer_radius: expected", espalier_lattice_create_star(&star, &made));
    FINITE(star.height, "height: expected", espalier_lattice_create_star(&star, &made));
    espalier_barbell_options barbell = espalier_default_barbell_options();
#define BARBELL espalier_lattice_create_barbell(&barbell, &made)
    FINITE(barbell.end_radius, "end_radius: expected", BARBELL);
    FINITE(barbell.bar_length, "bar_length: expected", BARBELL);
    FINITE(barbell.bar_half_width, "bar_half_width: expected", BARBELL);
    FINITE(barbell.roundness, "roundness: expected", BARBELL);
    FINITE(barbell.height, "height: expected", BARBELL);
    espalier_arm_joint joints[2] = {{{0, 0, 0}, 1, 0}, {{4, 0, 0}, 1, 0}};
    espalier_arm_options arm = espalier_default_arm_options();
    arm.joints = joints;
    arm.joint_count = 2;
#define ARM espalier_lattice_create_arm(&arm, &made)
    FINITE(joints[1].position[0], "joints[1].position: expected", ARM);
    FINITE(joints[1].radius, "joints[1].radius: expected", ARM);
    FINITE(joints[1].twist, "joints[1].twist: expected", ARM);
    FINITE(arm.up[1], "up: expected", ARM);
}

static void test_lattices_of_others(void) {
    const espalier_lattice* const parts[1] = {lattice};
    double tolerance = 1e-6;
    FINITE(tolerance, "tolerance: expected",
           espalier_lattice_create_merged(1, parts, tolerance, &made));
    /* Face 0 is on the side of the lowest x. */
    double offset[3] = {-1, 0, 0}, apex[3] = {-1, 0.25, 0.25};
    FINITE(offset[0], "offset: expected",
           espalier_lattice_create_with_prism(lattice, 0, offset, &made));
    FINITE(apex[1], "apex: expected",
           espalier_lattice_create_with_pyramid(lattice, 0, apex, &made));

    double points[3 * 8] = {0, 0, 0, 4, 0, 0, 0, 2, 0, 4, 2, 0, 0, 0, 1, 4, 0, 1, 0, 2, 1, 4, 2, 1};
    static const int64_t offsets[7] = {0, 4, 8, 12, 16, 20, 24};
    static const int32_t corners[24] = {0, 2, 3, 1, 4, 5, 7, 6, 0, 1, 5, 4,
                                        2, 6, 7, 3, 0, 4, 6, 2, 1, 3, 7, 5};
    const espalier_polygons faces = {6, offsets, corners};
    espalier_cage_options cage = espalier_default_cage_options();
    cage.vertices = 40;
#define CAGE espalier_lattice_create_cage(8, points, &faces, &cage, &made)
    FINITE(points[3], "point 1 is not finite", CAGE);
    FINITE(cage.cell_size, "cell_size: expected", CAGE);
    FINITE(cage.margin, "margin: expected", CAGE);
    FINITE(cage.shell, "shell: expected", CAGE);
    FINITE(cage.symmetry, "symmetry: expected", CAGE);
}

static void test_poses(void) {
    double positions[3 * N], weights[N], pose[3 * N];
    memcpy(positions, rest, sizeof rest);
    double a[3] = {0, 0, 0}, b[3] = {1, 1, 1}, z[3] = {0, 0, 1}, radius = 1;
    espalier_falloff falloff = {ESPALIER_FALLOFF_LINEAR, 1};
#define SELECTED(select)                               \
    FINITE(positions[3], "positions[1] is (", select); \
    FINITE(falloff.radius, "radius: expected", select)
    SELECTED(espalier_select_box(N, positions, a, b, &falloff, weights));
    FINITE(a[0], "corner: expected", espalier_select_box(N, positions, a, b, &falloff, weights));
    FINITE(b[0], "opposite: expected", espalier_select_box(N, positions, a, b, &falloff, weights));
    SELECTED(espalier_select_ball(N, positions, a, radius, &falloff, weights));
    FINITE(a[0], "center: expected",
           espalier_select_ball(N, positions, a, radius, &falloff, weights));
    FINITE(radius, "radius: expected",
           espalier_select_ball(N, positions, a, radius, &falloff, weights));
    SELECTED(espalier_select_half_space(N, positions, a, z, &falloff, weights));
    FINITE(a[0], "point: expected",
           espalier_select_half_space(N, positions, a, z, &falloff, weights));
    FINITE(z[0], "normal: expected",
           espalier_select_half_space(N, positions, a, z, &falloff, weights));
    SELECTED(espalier_select_end(N, positions, z, &falloff, weights));
    FINITE(z[0], "direction: expected", espalier_select_end(N, positions, z, &falloff, weights));
    SELECTED(espalier_select_numbers(N, positions, 1, cells, &falloff, weights));

    double chosen[N] = {0, 0.5, 1}, point[3] = {0.2, 0.2, 0.5};
    int32_t face = 0;
    espalier_section section;
#define ALONG_CELLS(select)                        \
    FINITE(positions[3], "positions[1] ", select); \
    FINITE(point[0], "point: expected", select)
    ALONG_CELLS(espalier_nearest_inner_face(lattice, N, positions, point, &face));
    ALONG_CELLS(espalier_select_near(lattice, N, positions, point, radius, &falloff, weights));
    SELECTED(espalier_select_near(lattice, N, positions, point, radius, &falloff, weights));
    FINITE(radius, "radius: expected",
           espalier_select_near(lattice, N, positions, point, radius, &falloff, weights));
    SELECTED(espalier_select_along_cells(lattice, N, positions, 1, cells, &falloff, weights));
    SELECTED(espalier_select_beyond(lattice, N, positions, face, &falloff, weights, &section));
    OK(espalier_select_beyond(lattice, N, positions, face, NULL, weights, NULL));
    FINITE(positions[3], "positions[1] ",
           espalier_selection_border(lattice, N, positions, weights, &section));
    FINITE(weights[0], "weights[0] is ",
           espalier_selection_border(lattice, N, positions, weights, &section));
    FINITE(chosen[1], "weights[1] is ", espalier_selection_grow(lattice, N, 1, chosen));
    /* The box has no limb; a barbell has two. */
    espalier_lattice* barbell = NULL;
    OK(espalier_lattice_create_barbell(NULL, &barbell));
    int32_t count = 0;
    const double* places = NULL;
    OK(espalier_lattice_positions(barbell, &count, &places));
    double ends[3 * 64], limb[64], end[3] = {-3, 0, 0};
    CHECK(count <= 64);
    memcpy(ends, places, 3 * sizeof(double) * (size_t)count);
#define LIMB espalier_select_limb(barbell, count, ends, end, &falloff, limb, &section)
    FINITE(ends[3], "positions[1] ", LIMB);
    FINITE(end[1], "point: expected", LIMB);
    FINITE(falloff.radius, "radius: expected", LIMB);
    espalier_lattice_destroy(barbell);

    double x[3] = {1, 0, 0}, given[N], center[3] = {0, 0, 0}, range[2] = {0, 1}, number = 0.5;
    for (int v = 0; v < N; ++v) given[v] = 1;
    espalier_pose_options options = espalier_default_pose_options();
    options.weights = given;
    options.center = center;
    options.range = range;
#define PLACED(operate)                                 \
    FINITE(positions[3], "positions[1] is (", operate); \
    FINITE(given[2], "weights[2] is ", operate)
#define CENTERED(operate) \
    PLACED(operate);      \
    FINITE(center[0], "center: expected", operate)
#define ALONG(name, operate)                                  \
    CENTERED(operate);                                        \
    FINITE(z[0], "axis: expected", operate);                  \
    FINITE(number, name ": expected", operate);               \
    FINITE(range[0], "range[0]: expected a finite", operate); \
    FINITE(range[1], "range[1]: expected", operate)
    PLACED(espalier_pose_move(N, positions, x, &options, pose));
    FINITE(x[0], "offset: expected", espalier_pose_move(N, positions, x, &options, pose));
    CENTERED(espalier_pose_rotate(N, positions, z, number, &options, pose));
    FINITE(z[0], "axis: expected", espalier_pose_rotate(N, positions, z, number, &options, pose));
    FINITE(number, "angle: expected",
           espalier_pose_rotate(N, positions, z, number, &options, pose));
    CENTERED(espalier_pose_scale(N, positions, b, &options, pose));
    FINITE(b[1], "factors: expected", espalier_pose_scale(N, positions, b, &options, pose));
    ALONG("angle", espalier_pose_twist(N, positions, z, number, &options, pose));
    ALONG("angle", espalier_pose_bend(N, positions, z, number, x, &options, pose));
    FINITE(x[0], "toward: expected",
           espalier_pose_bend(N, positions, z, number, x, &options, pose));
    ALONG("factor", espalier_pose_taper(N, positions, z, number, &options, pose));
    FINITE(positions[5], "positions[1] is (",
           espalier_pose_mirror(N, positions, rest, 0, &number, NULL, pose, NULL));
    FINITE(positions[5], "rest[1] is (",
           espalier_pose_mirror(N, rest, positions, 0, &number, NULL, pose, NULL));
    FINITE(number, "plane: expected a finite number",
           espalier_pose_mirror(N, positions, rest, 0, &number, NULL, pose, NULL));
}

static void test_bindings(void) {
    double positions[3 * N], points[6] = {0.5, 0.5, 0.5, 0.2, 0.3, 0.4}, moved[6], gradients[18];
    memcpy(positions, rest, sizeof rest);
    espalier_bind_options bind = espalier_default_bind_options();
#define BIND espalier_binding_create(refiner, N, positions, 2, points, &bind, &binding)
    FINITE(positions[5], "the position of lattice vertex 1 is not finite", BIND);
    FINITE(bind.tolerance, "tolerance: expected a finite number of 0 or more", BIND);
    FINITE(bind.limit_tolerance, "limit_tolerance: expected", BIND);
    FINITE(bind.falloff, "falloff: expected a finite distance of 0 or more", BIND);
    double weights[2] = {1, 0.5}, slopes[6] = {0};
    bind.weights = weights;
    bind.weight_slopes = slopes;
    FINITE(weights[1], "the weight of point 1 is ", BIND);
    FINITE(slopes[3], "the slope of the weight of point 1 is not finite", BIND);
    bind.weights = bind.weight_slopes = NULL;
    double of_three[3] = {1, 0.5, 0.25}, slopes_of_three[9];
    static const char triangle[] = "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n";
    espalier_model* model = NULL;
    OK(espalier_model_read_bytes("triangle.obj", sizeof triangle - 1, triangle, &model));
    FINITE(of_three[1], "the weight of point 1 is not finite",
           espalier_model_weight_slopes(model, 3, of_three, slopes_of_three));
    espalier_model_destroy(model);
    FINITE(bind.tolerance, "tolerance: expected",
           espalier_binding_create_tensor(lattice, 0, 2, points, &bind, &binding));
    /* A point that is not finite stays where it is, and its status says so. */
    double far[6] = {0.5, 0.5, 0.5, NAN, 0, INFINITY};
    OK(espalier_binding_create(refiner, N, positions, 2, far, NULL, &binding));
    const uint8_t* statuses = NULL;
    int32_t count = 0;
    OK(espalier_binding_statuses(binding, &count, &statuses));
    CHECK(count == 2 && statuses[0] == ESPALIER_POINT_INSIDE &&
          statuses[1] == ESPALIER_POINT_NOT_CONVERGED);
    destroy_results();

    espalier_binding* bound = NULL;
    bind.limit_tolerance = 1e-6;
    bind.gradients = 1;
    OK(espalier_binding_create(refiner, N, positions, 2, points, &bind, &bound));
    FINITE(positions[5], "pose[1] is (", espalier_binding_apply(bound, N, positions, 2, moved));
    FINITE(positions[5], "pose[1] is (",
           espalier_binding_gradients(bound, N, positions, 2, gradients));
    espalier_table* child = NULL;
    OK(espalier_binding_table(bound, &child));
    bind = espalier_default_bind_options();
    double child_pose[3 * N];
    for (int i = 0; i < 3 * N; ++i) child_pose[i] = 0.25 + rest[i] / 2;
#define NESTED \
    espalier_table_create_nested(child, N, child_pose, refiner, N, positions, &bind, &table)
    FINITE(child_pose[5], "the position of vertex 1 of the child is not finite", NESTED);
    FINITE(positions[5], "the position of lattice vertex 1 is not finite", NESTED);
    FINITE(bind.tolerance, "tolerance: expected", NESTED);

    double uvw[3] = {0.5, 0.5, 0.5};
    const int32_t cell = 0;
    espalier_limit_stencil_options stencils = espalier_default_limit_stencil_options();
#define LIMITS espalier_table_create_limit_stencils(refiner, 0, 1, &cell, uvw, &stencils, 1, &table)
    FINITE(uvw[1], "place 0 is at ", LIMITS);
    FINITE(stencils.tolerance, ": expected 1e-14 to 0.1", LIMITS);

    double misses[6] = {0}, displacements[3 * N];
    espalier_fit_options fit = espalier_default_fit_options();
#define FIT espalier_lattice_fit(child, lattice, 2, NULL, misses, &fit, N, displacements, NULL)
    FINITE(misses[4], "the target of point 1 is not finite", FIT);
    FINITE(fit.strength, "strength: expected", FIT);
    espalier_pull_options options = espalier_default_pull_options();
    espalier_pull* made_pull = NULL;
#define PULL                                             \
    (espalier_pull_destroy(made_pull), made_pull = NULL, \
     espalier_pull_create(lattice, N, positions, child, 2, NULL, &options, &made_pull))
    FINITE(positions[5], "the position of vertex 1 is not finite", PULL);
    FINITE(options.reach, "reach: expected", PULL);
    FINITE(options.tolerance, "tolerance: expected", PULL);
    OK(PULL);
    double start[3 * N] = {0};
#define SOLVE espalier_pull_solve(made_pull, 2, misses, N, start, displacements, NULL)
    FINITE(misses[4], "the target of point 1 is not finite", SOLVE);
    FINITE(start[3], "the displacement of vertex 1 to start from", SOLVE);
    espalier_pull_destroy(made_pull);
    espalier_table_destroy(child);
    espalier_binding_destroy(bound);

    int32_t held[N], held_count = 0;
#define HOLD espalier_hold_points(refiner, N, positions, 2, points, 2, &bind, held, &held_count)
    FINITE(positions[5], "the position of lattice vertex 1 is not finite", HOLD);
    FINITE(points[4], "point 1 to hold is not finite", HOLD);
    FINITE(bind.tolerance, "tolerance: expected", HOLD);
}

static void test_validity(void) {
    double positions[3 * N];
    memcpy(positions, rest, sizeof rest);
    /* A level has other vertices than the lattice, so that the number in the message differs. */
    FINITE(positions[5], "the rest of vertex ",
           espalier_validity_create(refiner, N, positions, NULL, &validity));
    espalier_validity* check = NULL;
    espalier_pose_validity result;
    espalier_largest_step step;
    double max_step = 1;
    OK(espalier_validity_create(refiner, N, positions, NULL, &check));
    FINITE(positions[5], "the pose of vertex ",
           espalier_validity_check(check, N, positions, 0, NULL, &result));
    FINITE(positions[5], "the pose of vertex ",
           espalier_validity_largest_step(check, N, positions, max_step, &step));
    FINITE(max_step, "max_step: expected",
           espalier_validity_largest_step(check, N, positions, max_step, &step));
    espalier_validity_destroy(check);
}

static void test_models(const char* path) {
    static const char text[] = "v 0 0 0\nv 1 0 0\nv 0 1 0\nvn 0 0 1\nf 1//1 2//1 3//1\n";
    espalier_model* model = NULL;
    OK(espalier_model_read_bytes("three.obj", sizeof text - 1, text, &model));
    double points[9] = {0, 0, 0, 1, 0, 0, 0, 2, 0}, gradients[27] = {0};
    for (int i = 0; i < 27; i += 9) gradients[i] = gradients[i + 4] = gradients[i + 8] = 1;
    FINITE(points[4], "point 1 is not finite",
           espalier_model_write(model, path, 3, points, gradients));
    FINITE(gradients[20], "the gradient of point 2 is not finite",
           espalier_model_write(model, path, 3, points, gradients));
    espalier_model_destroy(model);
}

int main(int argc, char** argv) {
    CHECK(argc == 2);
    make_box(rest, cells);
    OK(espalier_lattice_create_hexahedra(N, rest, BOX_CELLS, cells, &lattice));
    OK(espalier_refiner_create(lattice, NULL, &refiner));
    test_lattices();
    test_shapes();
    test_lattices_of_others();
    test_poses();
    test_bindings();
    test_validity();
    test_models(argv[1]);
    espalier_refiner_destroy(refiner);
    espalier_lattice_destroy(lattice);
    return 0;
}
