// SPDX-License-Identifier: Apache-2.0
// Times the C interface on one thread, and prints JSON: milliseconds, the least of several runs.
// speed.mjs runs it natively, and does the same in Chromium.
//
//   speed POINTS
#include <stdio.h>
#include <stdlib.h>
#include <time.h>

#include "espalier_shapes.h"

static double now(void) {
    struct timespec time;
    clock_gettime(CLOCK_MONOTONIC, &time);
    return 1e3 * (double)time.tv_sec + 1e-6 * (double)time.tv_nsec;
}

static void check(espalier_status status) {
    if (status == ESPALIER_OK) return;
    fprintf(stderr, "%s\n", espalier_last_error());
    exit(1);
}

/// The numbers of a linear congruential generator, which JavaScript computes too: from 0.02 to
/// 0.98.
static double nextPlace(unsigned* state) {
    *state = *state * 1664525u + 1013904223u;
    return 0.02 + 0.96 * (*state / 4294967296.0);
}

#define LEAST(name, runs, work)                   \
    do {                                          \
        double least = 1e300;                     \
        for (int run = 0; run < (runs); ++run) {  \
            const double start = now();           \
            work;                                 \
            const double took = now() - start;    \
            if (took < least) least = took;       \
        }                                         \
        printf(",\n  \"%s\": %.4f", name, least); \
    } while (0)

int main(int argc, char** argv) {
    const int count = argc > 1 ? atoi(argv[1]) : 100000;
    espalier_thread_limit* one;
    check(espalier_thread_limit_create(1, &one));

    const int32_t cells[3] = {4, 4, 4};
    const double low[3] = {0, 0, 0}, high[3] = {1, 1, 1};
    espalier_lattice* lattice;
    check(espalier_lattice_create_box(cells, low, high, &lattice));
    int32_t vertexCount;
    const double* positions;
    check(espalier_lattice_positions(lattice, &vertexCount, &positions));
    espalier_refiner* refiner;
    check(espalier_refiner_create(lattice, NULL, &refiner));

    double* points = malloc(sizeof(double) * 3 * (size_t)count);
    unsigned state = 1;
    for (int i = 0; i < 3 * count; ++i) points[i] = nextPlace(&state);
    float* pose = malloc(sizeof(float) * 3 * (size_t)vertexCount);
    for (int i = 0; i < 3 * vertexCount; ++i) pose[i] = (float)positions[i];
    float* moved = malloc(sizeof(float) * 3 * (size_t)count);

    const int few = count > 200000 ? 2 : 5, many = count > 200000 ? 40 : 200;
    printf("{\n  \"points\": %d", count);
    espalier_binding* binding = NULL;
    LEAST("bind", few, {
        espalier_binding_destroy(binding);
        check(espalier_binding_create(refiner, vertexCount, positions, count, points, NULL,
                                      &binding));
    });
    espalier_deformer_f32* deformer = NULL;
    LEAST("compile", few, {
        espalier_deformer_f32_destroy(deformer);
        check(espalier_deformer_f32_create(binding, &deformer));
    });
    LEAST("pose", many,
          check(espalier_deformer_f32_deform(deformer, pose, 3 * vertexCount, moved,
                                             3 * (int64_t)count)));
    const int32_t middle = 62;  // the vertex in the middle of 125: the most points depend on it
    LEAST("drag", many,
          check(espalier_deformer_f32_deform_changed(deformer, pose, 3 * vertexCount, 1, &middle,
                                                     moved, 3 * (int64_t)count)));
    printf("\n}\n");
    return 0;
}
