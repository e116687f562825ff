/* SPDX-License-Identifier: Apache-2.0 */
/* Deforms points by a lattice, from C: deform REST POSE */

#include <espalier.h>
#include <stdio.h>
#include <stdlib.h>

static void check(espalier_status status) {
    if (status == ESPALIER_OK) return;
    fprintf(stderr, "%s\n", espalier_last_error());
    exit(1);
}

int main(int count, char** arguments) {
    if (count != 3) return 2;
    double points[] = {0.1, 0.2, 0.3, 0.5, 0.5, 0.5, 0.9, 0.1, 0.7};
    espalier_lattice *rest, *pose;
    check(espalier_lattice_read(arguments[1], &rest));
    check(espalier_lattice_read(arguments[2], &pose));
    const double *from, *to;
    int32_t vertices, pose_vertices;
    check(espalier_lattice_positions(rest, &vertices, &from));
    check(espalier_lattice_positions(pose, &pose_vertices, &to));

    /* Once: find each point in level 3 of the lattice, and compose the matrix. */
    espalier_refiner* refiner;
    espalier_binding* binding;
    check(espalier_refiner_create(rest, NULL, &refiner));
    check(espalier_binding_create(refiner, vertices, from, 3, points, NULL, &binding));

    /* For every pose: one sparse product. */
    check(espalier_binding_apply(binding, pose_vertices, to, 3, points));
    for (int i = 0; i < 3; ++i)
        printf("%g %g %g\n", points[3 * i], points[3 * i + 1], points[3 * i + 2]);

    espalier_binding_destroy(binding);
    espalier_refiner_destroy(refiner);
    espalier_lattice_destroy(pose);
    espalier_lattice_destroy(rest);
}
