/* SPDX-License-Identifier: Apache-2.0 */
/* Puts a lattice around points, twists it, and moves the points with it, from C. */

#include <espalier_pose.h>
#include <espalier_shapes.h>
#include <stdio.h>
#include <stdlib.h>

static void check(espalier_status status) {
    if (status == ESPALIER_OK) return;
    fprintf(stderr, "%s\n", espalier_last_error());
    exit(1);
}

int main(void) {
    /* The corners of a block of 1 by 1 by 4. */
    double points[24];
    for (int i = 0; i < 8; ++i)
        for (int axis = 0; axis < 3; ++axis)
            points[3 * i + axis] = (i >> axis & 1) * (axis < 2 ? 1 : 4);

    espalier_lattice* lattice;
    espalier_refiner* refiner;
    espalier_binding* binding;
    int32_t vertices;
    const double* rest;
    check(espalier_lattice_create_around(8, points, NULL, &lattice));
    check(espalier_lattice_positions(lattice, &vertices, &rest));
    check(espalier_refiner_create(lattice, NULL, &refiner));
    check(espalier_binding_create(refiner, vertices, rest, 8, points, NULL, &binding));

    /* A quarter turn of the upper half; the lower half stays. */
    double* pose = malloc(3 * (size_t)vertices * sizeof *pose);
    const double up[3] = {0, 0, 1}, range[2] = {2, 4};
    espalier_pose_options options = espalier_default_pose_options();
    options.range = range;
    check(espalier_pose_twist(vertices, rest, up, 1.5707963267948966, &options, pose));
    check(espalier_binding_apply(binding, vertices, pose, 8, points));
    for (int i = 0; i < 8; ++i)
        printf("%.3f %.3f %.3f\n", points[3 * i], points[3 * i + 1], points[3 * i + 2]);

    free(pose);
    espalier_binding_destroy(binding);
    espalier_refiner_destroy(refiner);
    espalier_lattice_destroy(lattice);
}
