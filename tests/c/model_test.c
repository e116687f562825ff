/* SPDX-License-Identifier: Apache-2.0 */
/* Tests models, and the functions that edit lattices for a user interface. */

#include <math.h>

#include "check.h"

/* A tetrahedron with a comment and a normal, which stay when it is written. */
static const char kTetrahedron[] =
    "# four points\n"
    "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\n"
    "vn 0 0 -1\n"
    "f 1//1 3//1 2//1\nf 1 2 4\nf 2 3 4\nf 1 4 3\n";

static espalier_model* tetrahedron(void) {
    espalier_model* model = NULL;
    OK(espalier_model_read_bytes("four.obj", sizeof kTetrahedron - 1, kTetrahedron, &model));
    return model;
}

/* Returns the bytes of a file, with a zero after them. */
static char* bytes_of(const char* path) {
    FILE* file = fopen(path, "rb");
    CHECK(file != NULL);
    char* bytes = calloc(1000, 1);
    CHECK(bytes != NULL && fread(bytes, 1, 999, file) < 999);
    fclose(file);
    return bytes;
}

static void test_reading(const char* path) {
    espalier_model* model = tetrahedron();
    int32_t count = 0, has_directions = 0;
    const double* points = NULL;
    OK(espalier_model_points(model, &count, &points));
    CHECK(count == 4 && points[3] == 1 && points[11] == 1);
    espalier_polygons faces;
    OK(espalier_model_faces(model, &faces));
    CHECK(faces.face_count == 4 && faces.offsets[4] == 12);
    CHECK(faces.corners[0] == 0 && faces.corners[1] == 2 && faces.corners[2] == 1);
    OK(espalier_model_has_directions(model, &has_directions));
    CHECK(has_directions == 1);
    const char* notes = NULL;
    OK(espalier_model_notes(model, &notes));
    CHECK(strcmp(notes, "") == 0);
    INVALID(espalier_model_notes(model, NULL), "notes");

    OK(espalier_model_write(model, path, 4, points, NULL));
    char* same = bytes_of(path);
    CHECK(strcmp(same, kTetrahedron) == 0);
    free(same);
    /* A quarter turn about x with its gradient, which turns the normal. */
    double turned[12], gradients[36];
    for (int v = 0; v < 4; ++v) {
        const double* from = points + 3 * v;
        const double to[3] = {from[0], -from[2], from[1]};
        const double gradient[9] = {1, 0, 0, 0, 0, -1, 0, 1, 0};
        memcpy(turned + 3 * v, to, sizeof to);
        memcpy(gradients + 9 * v, gradient, sizeof gradient);
    }
    OK(espalier_model_write(model, path, 4, turned, gradients));
    char* moved = bytes_of(path);
    CHECK(strstr(moved, "v 0 -0 1\nv 0 -1 0\nvn 0 1 0\nf 1//1") != NULL);
    CHECK(strncmp(moved, "# four points\n", 14) == 0);
    free(moved);

    OK(espalier_model_write(model, path, 4, points, NULL));
    espalier_model* again = NULL;
    OK(espalier_model_read(path, &again));
    espalier_model_destroy(again);
    INVALID(espalier_model_write(model, path, 3, points, NULL), "4");
    turned[5] = NAN;
    INVALID(espalier_model_write(model, path, 4, turned, NULL), "not finite");
    espalier_model_destroy(model);
    model = NULL;
    REFUSED(espalier_model_read_bytes("a.obj", 4, "v 1 ", &model), ESPALIER_ERROR_FILE, "a.obj:1");
    REFUSED(espalier_model_read_bytes("a.xyz", 4, "v 1 ", &model), ESPALIER_ERROR_FILE, "a.xyz");
    INVALID(espalier_model_read_bytes("a.obj", -1, "", &model), "-1");
    OK(espalier_model_read_bytes("a.obj", 12, "v 0 0 0\nfoo\n", &model));
    OK(espalier_model_notes(model, &notes));
    CHECK(strcmp(notes, "a.obj: kept 1 line whose first word no OBJ has ('foo' in line 2)") == 0);
    espalier_model_destroy(model);
    model = NULL;
    INVALID(espalier_model_points(NULL, &count, &points), "model is null");
    CHECK(model == NULL);
    espalier_model_destroy(NULL);
}

/* The names of the attributes and groups of a model, and the weights of a part of it. */
static void test_parts(void) {
    static const char text[] =
        "v 0 0 0 1 0 0\nv 1 0 0 0.5 0 0\nv 1 1 0 0.25 0 0\nv 0 1 0 0 0 0\n"
        "g a\nf 1 2 3\ng b\nf 1 3 4\n";
    espalier_model* model = NULL;
    OK(espalier_model_read_bytes("two.obj", sizeof text - 1, text, &model));
    int32_t count = 0;
    const char* const* names = NULL;
    OK(espalier_model_attributes(model, &count, &names));
    CHECK(count == 3 && strcmp(names[0], "red") == 0 && strcmp(names[2], "blue") == 0);
    OK(espalier_model_groups(model, &count, &names));
    CHECK(count == 2 && strcmp(names[0], "a") == 0 && strcmp(names[1], "b") == 0);
    INVALID(espalier_model_groups(model, NULL, &names), "count");
    INVALID(espalier_model_attributes(model, &count, NULL), "names");
    double weights[4], slopes[12];
    OK(espalier_model_weights(model, NULL, 0, NULL, 4, weights));
    CHECK(weights[0] == 1 && weights[3] == 1);
    OK(espalier_model_weights(model, "red", 1, names, 4, weights));
    CHECK(weights[0] == 1 && weights[1] == 0.5 && weights[2] == 0.25 && weights[3] == 0);
    /* Point 1 is in the first triangle only: the weight falls by 0.5 along x and 0.25 along y. */
    OK(espalier_model_weight_slopes(model, 4, weights, slopes));
    CHECK(fabs(slopes[3] + 0.5) < 1e-15 && fabs(slopes[4] + 0.25) < 1e-15); /* rounding */
    CHECK(fabs(slopes[5]) < 1e-15);
    OK(espalier_model_hold(model, 1, names + 1, 4, weights));
    CHECK(weights[0] == 0 && weights[1] == 0.5 && weights[2] == 0 && weights[3] == 0);
    INVALID(espalier_model_hold(model, 1, NULL, 4, weights), "groups is null");
    INVALID(espalier_model_hold(model, 0, NULL, 3, weights), "4");
    INVALID(espalier_model_hold(model, 0, NULL, 4, NULL), "weights is null");
    const char* const wrong[] = {"a", "c"};
    REFUSED(espalier_model_hold(model, 2, wrong, 4, weights), ESPALIER_ERROR_FILE,
            "has no group 'c' of points; it has 'a', 'b'");
    REFUSED(espalier_model_weights(model, NULL, 2, wrong, 4, weights), ESPALIER_ERROR_FILE,
            "has no group 'c' of points; it has 'a', 'b'");
    REFUSED(espalier_model_weights(model, "bend", 0, NULL, 4, weights), ESPALIER_ERROR_FILE,
            "two.obj: has no attribute 'bend'");
    INVALID(espalier_model_weights(model, NULL, 0, NULL, 3, weights), "4");
    INVALID(espalier_model_weights(model, NULL, 1, NULL, 4, weights), "groups is null");
    INVALID(espalier_model_weight_slopes(model, 4, NULL, slopes), "weights is null");
    espalier_model_destroy(model);
    model = tetrahedron();
    OK(espalier_model_attributes(model, &count, &names));
    CHECK(count == 0);
    espalier_model_destroy(model);
}

/* The four walls of a bar: the points of a corner stay on the line of two planes, and all four
 * corners of the end stay with both patches. */
static void test_sliding_points(void) {
    static const char text[] =
        "v 0 0 0\nv 0 1 0\nv 0 1 1\nv 0 0 1\nv 3 0 0\nv 3 1 0\nv 3 1 1\nv 3 0 1\n"
        "g walls\nf 1 2 6 5\nf 2 3 7 6\nf 3 4 8 7\nf 4 1 5 8\ng end\nf 1 4 3 2\n";
    espalier_model* model = NULL;
    OK(espalier_model_read_bytes("bar.obj", sizeof text - 1, text, &model));
    const char* const names[] = {"walls", "end", "none"};
    espalier_sliding_points* sliding = NULL;
    OK(espalier_sliding_points_create(model, 2, names, &sliding));
    int32_t count = 0;
    const double* rest = NULL;
    OK(espalier_model_points(model, &count, &rest));
    double points[24], largest = -1;
    for (int i = 0; i < 24; ++i) points[i] = rest[i] + 0.1 * (i % 3 + 1);
    OK(espalier_sliding_points_slide(sliding, 8, points, &largest));
    for (int i = 0; i < 24; ++i) {
        const double moved = i >= 12 && i % 3 == 0 ? 0.1 : 0;
        CHECK(fabs(points[i] - rest[i] - moved) < 1e-15); /* rounding */
    }
    /* The corners of the end were moved by (0.1, 0.2, 0.3). */
    CHECK(fabs(largest - sqrt(0.14)) < 1e-15);
    OK(espalier_sliding_points_slide(sliding, 8, points, NULL));
    INVALID(espalier_sliding_points_slide(sliding, 7, points, NULL), "8");
    INVALID(espalier_sliding_points_slide(sliding, 8, NULL, NULL), "points is null");
    INVALID(espalier_sliding_points_slide(NULL, 8, points, NULL), "sliding is null");
    espalier_sliding_points_destroy(sliding);
    espalier_sliding_points_destroy(NULL);
    REFUSED(espalier_sliding_points_create(model, 3, names, &sliding), ESPALIER_ERROR_FILE,
            "has no group 'none' of points");
    INVALID(espalier_sliding_points_create(model, 1, NULL, &sliding), "patches is null");
    INVALID(espalier_sliding_points_create(model, 1, names, NULL), "sliding is null");
    INVALID(espalier_sliding_points_create(NULL, 1, names, &sliding), "model is null");
    espalier_model_destroy(model);
}

/* Texture coordinates, normals, colours and materials: of an .obj per corner, of a .ply per point.
 */
static void test_appearance(void) {
    static const char text[] =
        "v 0 0 0 1 0 0\nv 1 0 0 0.5 0 0\nv 1 1 0 0.25 0 0\nv 0 1 0 0 0 0\n"
        "vt 0 0\nvt 0.5 0.25\nvn 0 0 1\n"
        "f 1/1/1 2/2/1 3/1/1\nusemtl wood\nf 1/1/1 3/2/1 4/2/1\n";
    espalier_model* model = NULL;
    OK(espalier_model_read_bytes("two.obj", sizeof text - 1, text, &model));
    espalier_appearance look;
    OK(espalier_model_appearance(model, &look));
    CHECK(look.texture_count == 2 && look.textures[2] == 0.5 && look.textures[3] == 0.25);
    CHECK(look.texture_corners[1] == 1 && look.texture_corners[5] == 1);
    CHECK(look.normal_count == 1 && look.normals[2] == 1 && look.normal_corners[5] == 0);
    CHECK(look.colors[4] == 0.5F && look.colors[15] == 1);
    CHECK(look.material_count == 1 && strcmp(look.materials[0], "wood") == 0);
    CHECK(look.face_materials[0] == -1 && look.face_materials[1] == 0);
    INVALID(espalier_model_appearance(model, NULL), "appearance is null");
    INVALID(espalier_model_appearance(NULL, &look), "model is null");
    espalier_model_destroy(model);
    static const char points[] =
        "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\n"
        "property float z\nproperty float nx\nproperty float ny\nproperty float nz\n"
        "property uchar red\nproperty uchar green\nproperty uchar blue\n"
        "property float s\nproperty float t\n"
        "element face 1\nproperty list uchar int vertex_indices\nend_header\n"
        "0 0 0 0 0 1 255 0 51 0 1\n1 0 0 0 0 1 255 0 51 1 1\n0 1 0 0 1 0 255 0 51 0 0\n3 0 1 2\n";
    OK(espalier_model_read_bytes("three.ply", sizeof points - 1, points, &model));
    OK(espalier_model_appearance(model, &look));
    CHECK(look.texture_count == 3 && look.textures[2] == 1 && look.texture_corners[2] == 2);
    CHECK(look.normal_count == 3 && look.normals[7] == 1 && look.normal_corners == NULL);
    CHECK(look.colors[0] == 1 && look.colors[2] == 0.2F && look.colors[11] == 1);
    CHECK(look.material_count == 0 && look.materials == NULL && look.face_materials == NULL);
    espalier_model_destroy(model);
    OK(espalier_model_read_bytes("a.obj", 8, "v 0 0 0\n", &model));
    OK(espalier_model_appearance(model, &look));
    CHECK(look.textures == NULL && look.texture_corners == NULL && look.texture_count == 0);
    CHECK(look.normals == NULL && look.colors == NULL && look.covariances == NULL);
    espalier_model_destroy(model);
}

/* Grows a cell on a cube and removes it again. */
static void test_editing(void) {
    espalier_lattice *cube = NULL, *two = NULL, *with_tip = NULL, *one = NULL;
    const int32_t cells[3] = {1, 1, 1};
    const double min[3] = {0, 0, 0}, max[3] = {1, 1, 1}, up[3] = {0, 0, 1}, tip[3] = {0.5, 0.5, 2};
    OK(espalier_lattice_create_box(cells, min, max, &cube));

    /* The upper face is the face all of whose vertices have z = 1. */
    espalier_refiner* refiner = NULL;
    espalier_cells level;
    int32_t vertex_count = 0, upper = -1;
    const double* positions = NULL;
    OK(espalier_lattice_positions(cube, &vertex_count, &positions));
    OK(espalier_refiner_create(cube, NULL, &refiner));
    OK(espalier_refiner_cells(refiner, 0, &level));
    for (int32_t face = 0; face < level.face_count; ++face) {
        double lowest = 1;
        for (int64_t i = level.face_offsets[face]; i < level.face_offsets[face + 1]; ++i)
            lowest = fmin(lowest, positions[3 * level.face_vertices[i] + 2]);
        if (lowest == 1) upper = face;
    }
    CHECK(upper >= 0);
    int32_t counts[4], edge_count = 0, entity_count = 0;
    const int32_t* ends = NULL;
    const uint8_t* strata = NULL;
    OK(espalier_refiner_edges(refiner, 0, &edge_count, &ends));
    CHECK(edge_count == 12 && ends[0] != ends[1]);
    OK(espalier_refiner_strata(refiner, 0, 0, &entity_count, &strata));
    CHECK(entity_count == 8 && strata[0] == 0); /* corners */
    OK(espalier_refiner_refine(refiner, 1));
    OK(espalier_refiner_strata(refiner, 1, 0, &entity_count, &strata));
    int32_t of_stratum[4] = {0, 0, 0, 0};
    CHECK(entity_count == 27);
    for (int32_t v = 0; v < entity_count; ++v) ++of_stratum[strata[v]];
    CHECK(of_stratum[0] == 8 && of_stratum[1] == 12 && of_stratum[2] == 6 && of_stratum[3] == 1);
    INVALID(espalier_refiner_strata(refiner, 1, 4, &entity_count, &strata),
            "dimension: expected 0 to 3, got 4");
    INVALID(espalier_refiner_edges(refiner, 2, &edge_count, &ends), "2");

    OK(espalier_lattice_create_with_prism(cube, upper, up, &two));
    OK(espalier_lattice_counts(two, counts));
    CHECK(counts[0] == 12 && counts[3] == 2);
    OK(espalier_lattice_create_with_pyramid(cube, upper, tip, &with_tip));
    OK(espalier_lattice_counts(with_tip, counts));
    CHECK(counts[0] == 9 && counts[3] == 2);
    const int32_t first = 0, none = 2;
    OK(espalier_lattice_create_without_cells(two, 1, &first, &one));
    OK(espalier_lattice_counts(one, counts));
    CHECK(counts[0] == 8 && counts[3] == 1);
    espalier_lattice_destroy(one);
    one = NULL;
    INVALID(espalier_lattice_create_without_cells(two, 1, &none, &one), "2");
    INVALID(espalier_lattice_create_without_cells(cube, 1, &first, &one), "");
    INVALID(espalier_lattice_create_with_prism(cube, 99, up, &one), "99");
    CHECK(one == NULL);

    /* Marks come back as they were set. */
    const int32_t edge[2] = {0, 1};
    const int32_t vertex = 3;
    const double creased = 1.5, sharp = ESPALIER_SHARP;
    OK(espalier_lattice_mark_edges(cube, 1, edge, &creased));
    OK(espalier_lattice_mark_vertices(cube, 1, &vertex, &sharp));
    int64_t edge_marks = 0, vertex_marks = 0;
    OK(espalier_lattice_mark_counts(cube, &edge_marks, &vertex_marks));
    CHECK(edge_marks == 1 && vertex_marks == 1);
    int32_t got_ends[2], got_vertex;
    double got_crease, got_sharp;
    OK(espalier_lattice_marks(cube, 1, got_ends, &got_crease, 1, &got_vertex, &got_sharp));
    CHECK(got_ends[0] == 0 && got_ends[1] == 1 && got_crease == 1.5);
    CHECK(got_vertex == 3 && got_sharp == ESPALIER_SHARP);
    INVALID(espalier_lattice_marks(cube, 2, got_ends, &got_crease, 1, &got_vertex, &got_sharp),
            "edges");

    espalier_refiner_destroy(refiner);
    espalier_lattice_destroy(with_tip);
    espalier_lattice_destroy(two);
    espalier_lattice_destroy(cube);
}

int main(int argc, char** argv) {
    CHECK(argc == 2);
    char path[1000];
    snprintf(path, sizeof path, "%s/model.obj", argv[1]);
    test_reading(path);
    test_parts();
    test_sliding_points();
    test_appearance();
    test_editing();
    return 0;
}
