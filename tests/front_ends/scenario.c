/* SPDX-License-Identifier: Apache-2.0 */
#include "../c/check.h"

/* Does a scenario by the C interface, for front_ends_test.py:

       scenario REST MODEL BOUND.espb TO LEVEL OUTSIDE RULES BOUNDARY SHARP_EDGES CREASING TRIANGLES
                FALLOFF ATTRIBUTE POSE...

   The words are the numbers of their constants. TO is "level", "limit" or the number of a basis.
   ATTRIBUTE has the weights of the points; "-" for none.
   Prints the statuses of the points, and the points of each pose; then the same by the binding that
   it saved and loaded. */

static void print_points(const espalier_binding* binding, int32_t count, char** poses,
                         int pose_count) {
    int32_t vertex_count = 0, point_count = 0;
    const double *rest = NULL, *points = NULL;
    OK(espalier_binding_rest(binding, &vertex_count, &rest, &point_count, &points));
    CHECK(point_count == count);
    double* pose = malloc(3 * sizeof(double) * (size_t)vertex_count);
    double* moved = malloc(3 * sizeof(double) * (size_t)count);
    CHECK(pose && moved);
    espalier_deformer_f64* deformer = NULL;
    OK(espalier_deformer_f64_create(binding, &deformer));
    for (int i = 0; i < pose_count; ++i) {
        OK(espalier_binding_read_pose(binding, poses[i], vertex_count, pose));
        OK(espalier_deformer_f64_deform(deformer, pose, 3 * (int64_t)vertex_count, moved,
                                        3 * (int64_t)count));
        for (int32_t point = 0; point < count; ++point)
            printf("%.17g %.17g %.17g\n", moved[3 * point], moved[3 * point + 1],
                   moved[3 * point + 2]);
    }
    espalier_deformer_f64_destroy(deformer);
    free(moved);
    free(pose);
}

int main(int count, char** arguments) {
    CHECK(count > 14);
    const char* const to = arguments[4];
    espalier_lattice* lattice = NULL;
    espalier_model* model = NULL;
    espalier_refiner* refiner = NULL;
    espalier_binding *binding = NULL, *loaded = NULL;
    const double *positions = NULL, *points = NULL;
    const uint8_t* statuses = NULL;
    int32_t vertex_count = 0, point_count = 0, status_count = 0;
    OK(espalier_lattice_read(arguments[1], &lattice));
    OK(espalier_lattice_positions(lattice, &vertex_count, &positions));
    OK(espalier_model_read(arguments[2], &model));
    OK(espalier_model_points(model, &point_count, &points));
    espalier_bind_options options = espalier_default_bind_options();
    options.level = atoi(arguments[5]);
    options.outside = atoi(arguments[6]);
    options.falloff = atof(arguments[12]);
    double* weights = malloc(sizeof(double) * (size_t)point_count);
    CHECK(weights);
    if (strcmp(arguments[13], "-") != 0) {
        OK(espalier_model_weights(model, arguments[13], 0, NULL, point_count, weights));
        options.weights = weights;
    }
    if (strcmp(to, "limit") == 0) options.limit_tolerance = 1e-6;
    if (strcmp(to, "level") == 0 || strcmp(to, "limit") == 0) {
        espalier_refine_options refine = espalier_default_refine_options();
        refine.rules = atoi(arguments[7]);
        refine.boundary = atoi(arguments[8]);
        refine.sharp_edges = atoi(arguments[9]);
        refine.creasing = atoi(arguments[10]);
        refine.triangles = atoi(arguments[11]);
        OK(espalier_refiner_create(lattice, &refine, &refiner));
        OK(espalier_binding_create(refiner, vertex_count, positions, point_count, points, &options,
                                   &binding));
    } else {
        OK(espalier_binding_create_tensor(lattice, atoi(to), point_count, points, &options,
                                          &binding));
    }
    OK(espalier_binding_statuses(binding, &status_count, &statuses));
    for (int32_t i = 0; i < status_count; ++i) printf("%d\n", statuses[i]);
    OK(espalier_binding_save(binding, arguments[3]));
    OK(espalier_binding_load(arguments[3], &loaded));
    print_points(binding, point_count, arguments + 14, count - 14);
    print_points(loaded, point_count, arguments + 14, count - 14);
    free(weights);
    espalier_binding_destroy(loaded);
    espalier_binding_destroy(binding);
    espalier_refiner_destroy(refiner);
    espalier_model_destroy(model);
    espalier_lattice_destroy(lattice);
    return 0;
}
