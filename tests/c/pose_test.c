/* SPDX-License-Identifier: Apache-2.0 */
/* Tests poses: selections, operations and files, on the box of 2 × 2 × 2 cells. */

#include <math.h>
#include <string.h>

#include "box.h"
#include "check.h"

/* A few roundings of numbers of size 1. */
static const double tolerance = 1e-15;

enum { N = BOX_VERTICES };
static double rest[3 * N];
static int32_t cells[8 * BOX_CELLS];
static const double x_axis[3] = {2, 0, 0}, z_axis[3] = {0, 0, 3}, zero[3] = {0, 0, 0};

static void test_selections(void) {
    double weights[N];
    const double low[3] = {1, 1, 0.4}, high[3] = {-1, -1, 0.6};
    OK(espalier_select_box(N, rest, low, high, NULL, weights));
    for (int v = 0; v < N; ++v) CHECK(weights[v] == (rest[3 * v + 2] == 0.5));
    /* 0.4 above the box, of a radius of 0.8: half of the way. */
    espalier_falloff falloff = {ESPALIER_FALLOFF_LINEAR, 0.8};
    OK(espalier_select_box(N, rest, low, high, &falloff, weights));
    CHECK(fabs(weights[N - 1] - 0.5) < tolerance && weights[BOX_CENTRE] == 1);
    falloff.radius = 1.6; /* u = 1/4, and 1 − 3u² + 2u³ = 27/32 */
    falloff.profile = ESPALIER_FALLOFF_SMOOTH;
    OK(espalier_select_box(N, rest, low, high, &falloff, weights));
    CHECK(fabs(weights[N - 1] - 27. / 32) < tolerance);

    OK(espalier_select_ball(N, rest, rest, 0.5, NULL, weights));
    for (int v = 0; v < N; ++v) CHECK(weights[v] == (v == 0 || v == 1 || v == 3 || v == 9));
    OK(espalier_select_half_space(N, rest, rest + 3 * BOX_CENTRE, x_axis, NULL, weights));
    for (int v = 0; v < N; ++v) CHECK(weights[v] == (v % 3 > 0));
    OK(espalier_select_end(N, rest, z_axis, NULL, weights));
    for (int v = 0; v < N; ++v) CHECK(weights[v] == (v >= 18));
    const int32_t some[3] = {4, 26, 4};
    OK(espalier_select_numbers(N, rest, 3, some, NULL, weights));
    for (int v = 0; v < N; ++v) CHECK(weights[v] == (v == 4 || v == 26));
    OK(espalier_select_numbers(N, rest, 0, NULL, NULL, weights));
    for (int v = 0; v < N; ++v) CHECK(weights[v] == 0);
    OK(espalier_select_box(0, NULL, low, high, NULL, NULL));
}

/* Selections along the cells of the box, which has no limb. */
static void test_selections_along_cells(void) {
    double weights[N];
    espalier_lattice* lattice;
    espalier_section section = {-1, {-1, -1, -1}};
    OK(espalier_lattice_create_hexahedra(N, rest, BOX_CELLS, cells, &lattice));
    for (int v = 0; v < N; ++v) weights[v] = -7;
    INVALID(espalier_select_limb(lattice, N, rest, zero, NULL, weights, &section),
            "the lattice has no limb at (0, 0, 0)");
    CHECK(weights[0] == -7 && section.area == -1);
    const double middle[3] = {0.3, 0.3, 0.5};
    int32_t face;
    OK(espalier_nearest_inner_face(lattice, N, rest, middle, &face));
    OK(espalier_select_beyond(lattice, N, rest, face, NULL, weights, &section));
    CHECK(fabs(section.area - 1) < tolerance);
    for (int k = 0; k < 3; ++k) CHECK(fabs(section.center[k] - 0.5) < tolerance);
    int selected = 0;
    for (int v = 0; v < N; ++v) selected += weights[v] == 1;
    CHECK(selected == 18);
    OK(espalier_selection_border(lattice, N, rest, weights, &section));
    CHECK(fabs(section.area - 1) < tolerance);

    /* Vertex 0, its three neighbours, and those of its cells. */
    const int32_t corner = 0;
    const espalier_falloff falloff = {ESPALIER_FALLOFF_LINEAR, 1};
    OK(espalier_select_along_cells(lattice, N, rest, 1, &corner, &falloff, weights));
    CHECK(weights[0] == 1 && fabs(weights[1] - 0.5) < tolerance && weights[2] == 0);
    OK(espalier_select_near(lattice, N, rest, zero, 0.5, NULL, weights));
    for (int v = 0; v < N; ++v) CHECK(weights[v] == (v == 0 || v == 1 || v == 3 || v == 9));
    OK(espalier_selection_grow(lattice, N, -1, weights));
    for (int v = 0; v < N; ++v) CHECK(weights[v] == (v == 0));
    OK(espalier_selection_grow(lattice, N, 1, weights));
    for (int v = 0; v < N; ++v) CHECK(weights[v] == (v == 0 || v == 1 || v == 3 || v == 9));
    OK(espalier_selection_grow(lattice, N, INT32_MAX, weights));
    for (int v = 0; v < N; ++v) CHECK(weights[v] == 1);
    INVALID(espalier_selection_border(lattice, N, rest, weights, &section),
            "the selection has no border");
    OK(espalier_selection_grow(lattice, N, INT32_MIN, weights));
    CHECK(weights[0] == 1); /* no vertex is outside */

    INVALID(espalier_select_limb(NULL, N, rest, zero, NULL, weights, NULL), "lattice is null");
    INVALID(espalier_select_limb(lattice, N, rest, NULL, NULL, weights, NULL), "point is null");
    INVALID(espalier_select_beyond(lattice, N, rest, -1, NULL, weights, NULL),
            "face: expected 0 to 35, got -1");
    INVALID(espalier_select_near(lattice, N, rest, zero, -1, NULL, weights),
            "radius: expected a finite number of 0 or more, got -1");
    INVALID(espalier_select_near(lattice, 1, rest, zero, 1, NULL, weights), "got 1 positions");
    INVALID(espalier_selection_grow(lattice, 3, 1, weights), "got 3 weights of vertices");
    INVALID(espalier_selection_border(lattice, N, rest, weights, NULL), "section is null");
    INVALID(espalier_nearest_inner_face(lattice, N, rest, middle, NULL), "face is null");
    espalier_lattice_destroy(lattice);
}

static void test_bad_selections(void) {
    double weights[N];
    for (int v = 0; v < N; ++v) weights[v] = -7;
    const int32_t beyond = N;
    const double odd[3] = {0, NAN, 0};
    espalier_falloff falloff = {2, 1};
    INVALID(espalier_select_box(N, rest, odd, zero, NULL, weights),
            "select_box: corner: expected finite numbers, got (0, nan");
    INVALID(espalier_select_box(N, rest, NULL, zero, NULL, weights), "corner is null");
    INVALID(espalier_select_box(N, rest, zero, NULL, NULL, weights), "opposite is null");
    INVALID(espalier_select_box(N, NULL, zero, zero, NULL, weights), "positions is null");
    INVALID(espalier_select_box(N, rest, zero, zero, NULL, NULL), "weights is null");
    INVALID(espalier_select_box(-1, rest, zero, zero, NULL, weights), "the count is -1");
    INVALID(espalier_select_box(N, rest, zero, zero, &falloff, weights),
            "profile: expected 0 to 1, got 2");
    falloff.profile = ESPALIER_FALLOFF_SMOOTH;
    falloff.radius = -1;
    INVALID(espalier_select_ball(N, rest, zero, 1, &falloff, weights),
            "falloff.radius: expected a finite number of 0 or more, got -1");
    INVALID(espalier_select_ball(N, rest, zero, -1, NULL, weights),
            "select_ball: radius: expected a finite number of 0 or more, got -1");
    INVALID(espalier_select_ball(N, rest, NULL, 1, NULL, weights), "center is null");
    INVALID(espalier_select_half_space(N, rest, zero, zero, NULL, weights),
            "normal: expected a vector other than 0");
    INVALID(espalier_select_half_space(N, rest, NULL, x_axis, NULL, weights), "point is null");
    INVALID(espalier_select_half_space(N, rest, zero, NULL, NULL, weights), "normal is null");
    INVALID(espalier_select_end(N, rest, zero, NULL, weights), "select_end: direction");
    INVALID(espalier_select_end(0, rest, x_axis, NULL, weights), "there are no positions");
    INVALID(espalier_select_numbers(N, rest, 1, &beyond, NULL, weights),
            "numbers[0]: expected 0 to 26, got 27");
    INVALID(espalier_select_numbers(N, rest, 1, NULL, NULL, weights), "numbers is null");
    for (int v = 0; v < N; ++v) CHECK(weights[v] == -7);
}

static void test_operations(void) {
    double pose[3 * N];
    const double offset[3] = {1, 2, 3}, factors[3] = {2, 1, 0.5};
    OK(espalier_pose_move(N, rest, offset, NULL, pose));
    for (int i = 0; i < 3 * N; ++i) CHECK(pose[i] == rest[i] + offset[i % 3]);

    /* About the centre (1/2, 1/2, 1/2): by a quarter turn, (x, y) goes to (1 − y, x). */
    const double quarter = acos(0);
    OK(espalier_pose_rotate(N, rest, z_axis, quarter, NULL, pose));
    for (int v = 0; v < N; ++v) {
        const double* p = rest + 3 * v;
        CHECK(fabs(pose[3 * v] - (1 - p[1])) < tolerance &&
              fabs(pose[3 * v + 1] - p[0]) < tolerance);
        CHECK(fabs(pose[3 * v + 2] - p[2]) < tolerance);
    }
    /* A twist by a half turn: at half height a quarter turn. Written over its own input. */
    memcpy(pose, rest, sizeof pose);
    OK(espalier_pose_twist(N, pose, z_axis, 2 * quarter, NULL, pose));
    for (int v = 0; v < N; ++v) {
        const double* p = rest + 3 * v;
        const double x = p[2] == 0 ? p[0] : p[2] == 1 ? 1 - p[0] : 1 - p[1];
        const double y = p[2] == 0 ? p[1] : p[2] == 1 ? 1 - p[1] : p[0];
        CHECK(fabs(pose[3 * v] - x) < tolerance && fabs(pose[3 * v + 1] - y) < tolerance);
    }
    OK(espalier_pose_scale(N, rest, factors, NULL, pose));
    for (int i = 0; i < 3 * N; ++i)
        CHECK(fabs(pose[i] - (0.5 + factors[i % 3] * (rest[i] - 0.5))) < tolerance);
    OK(espalier_pose_taper(N, rest, z_axis, 3, NULL, pose));
    for (int v = 0; v < N; ++v)
        for (int k = 0; k < 3; ++k) {
            const double factor = k == 2 ? 1 : 1 + 2 * rest[3 * v + 2];
            CHECK(fabs(pose[3 * v + k] - (0.5 + factor * (rest[3 * v + k] - 0.5))) < tolerance);
        }
    /* The axis of length 1 bends into a quarter of a circle of radius r = 2/π: its end (the middle
     * of the top) goes from (1/2, 1/2, 1) to (1/2 + r, 1/2, r). */
    OK(espalier_pose_bend(N, rest, z_axis, quarter, x_axis, NULL, pose));
    const double r = 1 / quarter;
    CHECK(fabs(pose[3 * 22] - (0.5 + r)) < tolerance && fabs(pose[3 * 22 + 1] - 0.5) < tolerance &&
          fabs(pose[3 * 22 + 2] - r) < tolerance);
    OK(espalier_pose_move(0, NULL, offset, NULL, NULL));
}

static void test_options(void) {
    double pose[3 * N], weights[N];
    const double center[3] = {0, 0, 7}, range[2] = {0.5, 1}, offset[3] = {4, 0, 0};
    espalier_pose_options options = espalier_default_pose_options();
    for (int v = 0; v < N; ++v) weights[v] = v == 3 ? 0.25 : 0;
    options.weights = weights;
    OK(espalier_pose_move(N, rest, offset, &options, pose));
    for (int i = 0; i < 3 * N; ++i) CHECK(pose[i] == rest[i] + (i == 9 ? 1 : 0));
    options.weights = NULL;
    options.center = center;
    options.range = range;
    OK(espalier_pose_twist(N, rest, z_axis, acos(-1), &options, pose));
    for (int v = 0; v < N; ++v) {
        const double sign = rest[3 * v + 2] == 1 ? -1 : 1;
        CHECK(fabs(pose[3 * v] - sign * rest[3 * v]) < tolerance);
        CHECK(fabs(pose[3 * v + 1] - sign * rest[3 * v + 1]) < tolerance);
    }
}

static void test_bad_operations(void) {
    double pose[3 * N], weights[N] = {0};
    for (int i = 0; i < 3 * N; ++i) pose[i] = -7;
    const double odd[3] = {0, INFINITY, 0}, one[3] = {1, 1, 1}, backwards[2] = {1, 0};
    espalier_pose_options options = espalier_default_pose_options();
    INVALID(espalier_pose_move(N, rest, odd, NULL, pose),
            "move: offset: expected finite numbers, got (0, inf, 0)");
    INVALID(espalier_pose_move(N, rest, NULL, NULL, pose), "offset is null");
    INVALID(espalier_pose_move(N, NULL, one, NULL, pose), "positions is null");
    INVALID(espalier_pose_move(N, rest, one, NULL, NULL), "pose is null");
    INVALID(espalier_pose_move(-1, rest, one, NULL, pose), "the count is -1");
    INVALID(espalier_pose_rotate(N, rest, zero, 1, NULL, pose),
            "rotate: axis: expected a vector other than 0");
    INVALID(espalier_pose_rotate(N, rest, z_axis, NAN, NULL, pose),
            "rotate: angle: expected a finite number, got nan");
    INVALID(espalier_pose_rotate(N, rest, NULL, 1, NULL, pose), "axis is null");
    INVALID(espalier_pose_scale(N, rest, odd, NULL, pose), "scale: factors");
    INVALID(espalier_pose_scale(N, rest, NULL, NULL, pose), "factors is null");
    INVALID(espalier_pose_twist(N, rest, NULL, 1, NULL, pose), "axis is null");
    INVALID(espalier_pose_taper(N, rest, z_axis, -1, NULL, pose),
            "taper: factor: expected 0 or more, got -1");
    INVALID(espalier_pose_taper(N, rest, NULL, 1, NULL, pose), "axis is null");
    INVALID(espalier_pose_bend(N, rest, z_axis, 1, z_axis, NULL, pose), "bend: toward");
    INVALID(espalier_pose_mirror(N, NULL, rest, 0, NULL, NULL, pose, NULL), "positions is null");
    INVALID(espalier_pose_mirror(N, rest, NULL, 0, NULL, NULL, pose, NULL), "rest is null");
    INVALID(espalier_pose_mirror(N, rest, rest, 0, NULL, NULL, NULL, NULL), "pose is null");
    INVALID(espalier_pose_mirror(N, rest, rest, -1, NULL, NULL, pose, NULL),
            "mirror: axis: expected 0 to 2, got -1");
    const double far_away = 9;
    INVALID(espalier_pose_mirror(N, rest, rest, 2, &far_away, NULL, pose, NULL),
            "has a mirror image at z = 9");
    INVALID(espalier_pose_bend(N, rest, z_axis, 1, NULL, NULL, pose), "toward is null");
    INVALID(espalier_pose_bend(N, rest, NULL, 1, x_axis, NULL, pose), "axis is null");
    options.range = backwards;
    INVALID(espalier_pose_twist(N, rest, z_axis, 1, &options, pose),
            "range[1]: expected a number above range[0]");
    options = espalier_default_pose_options();
    options.weights = weights;
    INVALID(espalier_pose_twist(N, rest, z_axis, 1, &options, pose),
            "no position has a weight above 0");
    weights[3] = 2;
    INVALID(espalier_pose_move(N, rest, one, &options, pose), "weights[3] is 2");
    options = espalier_default_pose_options();
    options.center = odd;
    INVALID(espalier_pose_scale(N, rest, one, &options, pose), "scale: center");
    options.size = 1;
    INVALID(espalier_pose_scale(N, rest, one, &options, pose), "espalier_default_pose_options()");
    for (int i = 0; i < 3 * N; ++i) CHECK(pose[i] == -7);
}

/* What the vertices at z = 1 do, those at z = 0 do as well. */
static void test_mirror(void) {
    double pose[3 * N], weights[N], changed[3 * N];
    OK(espalier_select_end(N, rest, z_axis, NULL, weights));
    const double up[3] = {0.25, 0, 0.5};
    espalier_pose_options options = espalier_default_pose_options();
    options.weights = weights;
    OK(espalier_pose_move(N, rest, up, &options, pose));
    int32_t without_image = -1;
    OK(espalier_pose_mirror(N, pose, rest, 2, NULL, weights, pose, &without_image));
    CHECK(without_image == 0);
    for (int v = 0; v < N; ++v) {
        const double z = rest[3 * v + 2];
        CHECK(pose[3 * v] == rest[3 * v] + (z == 0.5 ? 0 : 0.25));
        CHECK(pose[3 * v + 2] == (z == 0 ? -0.5 : z == 1 ? 1.5 : 0.5));
    }
    /* The image of vertex 0 is elsewhere now, about z = 1/2 as well as about z = 0.3. */
    memcpy(changed, rest, sizeof rest);
    changed[3 * 18] = -0.25;
    const double plane = 0.5;
    OK(espalier_pose_mirror(N, changed, changed, 2, &plane, NULL, pose, &without_image));
    CHECK(without_image == 2);
    CHECK(memcmp(pose, changed, sizeof changed) == 0);
}

/* Cages and lattice files are read back bit for bit, for a lattice and for a binding to it. */
static void test_files(const char* folder) {
    char path[4][1000];
    static const char* const names[4] = {"twisted.obj", "twisted.ply", "twisted.vtu",
                                         "twisted.espb"};
    for (int i = 0; i < 4; ++i) snprintf(path[i], sizeof path[i], "%s/%s", folder, names[i]);
    espalier_lattice *lattice = NULL, *moved = NULL, *other = NULL;
    espalier_refiner* refiner = NULL;
    espalier_binding *binding = NULL, *loaded = NULL;
    double pose[3 * N], back[3 * N];
    OK(espalier_pose_twist(N, rest, z_axis, 0.1, NULL, pose));
    OK(espalier_lattice_create_hexahedra(N, rest, BOX_CELLS, cells, &lattice));
    OK(espalier_lattice_create_hexahedra(N, pose, BOX_CELLS, cells, &moved));
    OK(espalier_lattice_write_editor_mesh(moved, path[0]));
    OK(espalier_lattice_write_editor_mesh(moved, path[1]));
    OK(espalier_lattice_write(moved, path[2]));
    OK(espalier_refiner_create(lattice, NULL, &refiner));
    OK(espalier_binding_create(refiner, N, rest, 1, rest + 3 * BOX_CENTRE, NULL, &binding));
    OK(espalier_binding_save(binding, path[3]));
    OK(espalier_binding_load(path[3], &loaded));
    for (int i = 0; i < 3; ++i) {
        memset(back, 0, sizeof back);
        OK(espalier_lattice_read_pose(lattice, path[i], N, back));
        CHECK(memcmp(back, pose, sizeof pose) == 0);
        memset(back, 0, sizeof back);
        OK(espalier_binding_read_pose(i == 0 ? binding : loaded, path[i], N, back));
        CHECK(memcmp(back, pose, sizeof pose) == 0);
    }

    /* The same vertices with other cells: one instead of eight. */
    for (int i = 0; i < 3 * N; ++i) back[i] = -7;
    static const int32_t corners[8] = {0, 1, 2, 3, 4, 5, 6, 7};
    OK(espalier_lattice_create_hexahedra(8, rest, 1, corners, &other));
    INVALID(espalier_lattice_read_pose(other, path[0], N, back), "expected 8");
    REFUSED(espalier_lattice_read_pose(other, path[0], 8, back), ESPALIER_ERROR_FILE,
            "it has 27 points; expected one for each of the 8 vertices");
    REFUSED(espalier_lattice_read_pose(lattice, "none.obj", N, back), ESPALIER_ERROR_FILE,
            "none.obj");
    FILE* file = fopen(path[0], "a");
    fputs("f 1 3 27\n", file);
    fclose(file);
    REFUSED(espalier_lattice_read_pose(lattice, path[0], N, back), ESPALIER_ERROR_FILE,
            "is not a face of the lattice");
    REFUSED(espalier_binding_read_pose(loaded, path[0], N, back), ESPALIER_ERROR_FILE,
            "is not a pose of the lattice of the binding: face 36 of the file");
    REFUSED(espalier_lattice_write_editor_mesh(lattice, path[2]), ESPALIER_ERROR_FILE,
            ".obj or .ply");
    INVALID(espalier_lattice_write_editor_mesh(NULL, path[0]), "lattice is null");
    INVALID(espalier_lattice_write_editor_mesh(lattice, NULL), "path is null");
    INVALID(espalier_lattice_read_pose(NULL, path[0], N, back), "lattice is null");
    INVALID(espalier_lattice_read_pose(lattice, NULL, N, back), "path is null");
    INVALID(espalier_lattice_read_pose(lattice, path[1], N, NULL), "pose is null");
    INVALID(espalier_binding_read_pose(NULL, path[1], N, back), "binding is null");
    INVALID(espalier_binding_read_pose(binding, NULL, N, back), "path is null");
    INVALID(espalier_binding_read_pose(binding, path[1], 26, back), "expected 27");
    INVALID(espalier_binding_read_pose(binding, path[1], N, NULL), "pose is null");
    for (int i = 0; i < 3 * N; ++i) CHECK(back[i] == -7);
    espalier_binding_destroy(loaded);
    espalier_binding_destroy(binding);
    espalier_refiner_destroy(refiner);
    espalier_lattice_destroy(other);
    espalier_lattice_destroy(moved);
    espalier_lattice_destroy(lattice);
}

int main(int count, char** arguments) {
    CHECK(count == 2);
    make_box(rest, cells);
    test_selections();
    test_selections_along_cells();
    test_bad_selections();
    test_operations();
    test_options();
    test_bad_operations();
    test_mirror();
    test_files(arguments[1]);
    return 0;
}
