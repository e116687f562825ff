/* SPDX-License-Identifier: Apache-2.0 */
#ifndef ESPALIER_TESTS_BOX_H
#define ESPALIER_TESTS_BOX_H

#include <stdint.h>

/* The unit cube as 2 × 2 × 2 hexahedra; vertex (i, j, k) is i + 3 (j + 3 k). */
enum { BOX_VERTICES = 27, BOX_CELLS = 8, BOX_CENTRE = 13 };

static inline void make_box(double positions[3 * BOX_VERTICES], int32_t cells[8 * BOX_CELLS]) {
    for (int v = 0; v < BOX_VERTICES; ++v) {
        positions[3 * v] = 0.5 * (v % 3);
        positions[3 * v + 1] = 0.5 * (v / 3 % 3);
        positions[3 * v + 2] = 0.5 * (v / 9);
    }
    static const int32_t corners[8] = {0, 1, 4, 3, 9, 10, 13, 12};
    for (int c = 0; c < BOX_CELLS; ++c)
        for (int i = 0; i < 8; ++i)
            cells[8 * c + i] = corners[i] + c % 2 + 3 * (c / 2 % 2) + 9 * (c / 4);
}

#endif
