/* SPDX-License-Identifier: Apache-2.0 */
/* Tests lattices from arrays and files, marks, levels and level tables. */

#include <math.h>

#include "box.h"
#include "check.h"

/* The rounding of a few dozen products of numbers up to 1: a few units of 1e-16 each. */
static const double tolerance = 1e-13;

static espalier_lattice* make_box_lattice(void) {
    double positions[3 * BOX_VERTICES];
    int32_t cells[8 * BOX_CELLS];
    make_box(positions, cells);
    espalier_lattice* lattice = NULL;
    OK(espalier_lattice_create_hexahedra(BOX_VERTICES, positions, BOX_CELLS, cells, &lattice));
    return lattice;
}

static espalier_refiner* make_refiner(const espalier_lattice* lattice, int32_t level) {
    espalier_refiner* refiner = NULL;
    OK(espalier_refiner_create(lattice, NULL, &refiner));
    OK(espalier_refiner_refine(refiner, level));
    int32_t finest = -1;
    OK(espalier_refiner_max_level(refiner, &finest));
    CHECK(finest == level);
    return refiner;
}

static void check_counts(const int32_t counts[4], int32_t vertices, int32_t edges, int32_t faces,
                         int32_t cells) {
    CHECK(counts[0] == vertices);
    CHECK(counts[1] == edges);
    CHECK(counts[2] == faces);
    CHECK(counts[3] == cells);
}

/* A cube with a pyramid on top. Each cell has its own faces, and some of these wind inwards. */
static void test_cells_of_any_shape(void) {
    static const double positions[27] = {0, 0, 0, 1, 0, 0, 1, 1, 0, 0, 1,   0,   0, 0,
                                         1, 1, 0, 1, 1, 1, 1, 0, 1, 1, 0.5, 0.5, 2};
    static const int64_t cell_offsets[3] = {0, 6, 11};
    static const int64_t face_offsets[12] = {0, 4, 8, 12, 16, 20, 24, 28, 31, 34, 37, 40};
    static const int32_t face_vertices[40] = {0, 3, 2, 1, 4, 5, 6, 7, 0, 1, 5, 4, 1, 2,
                                              6, 5, 2, 3, 7, 6, 3, 0, 4, 7, 4, 5, 6, 7,
                                              4, 5, 8, 5, 6, 8, 6, 7, 8, 4, 7, 8};
    espalier_cells cells = {9, 11, 2, cell_offsets, NULL, face_offsets, face_vertices};
    espalier_lattice* lattice = NULL;
    OK(espalier_lattice_create(&cells, positions, &lattice));
    int32_t counts[4];
    OK(espalier_lattice_counts(lattice, counts));
    check_counts(counts, 9, 16, 10, 2);

    /* The same lattice with the face between the cells given once. */
    static const int32_t cell_faces[11] = {0, 1, 2, 3, 4, 5, 1, 6, 7, 8, 9};
    static const int64_t shared_offsets[11] = {0, 4, 8, 12, 16, 20, 24, 27, 30, 33, 36};
    static const int32_t shared_vertices[36] = {0, 3, 2, 1, 4, 5, 6, 7, 0, 1, 5, 4,
                                                1, 2, 6, 5, 2, 3, 7, 6, 3, 0, 4, 7,
                                                4, 5, 8, 5, 6, 8, 6, 7, 8, 4, 7, 8};
    const espalier_cells shared = {
        9, 10, 2, cell_offsets, cell_faces, shared_offsets, shared_vertices};
    espalier_lattice* same = NULL;
    OK(espalier_lattice_create(&shared, positions, &same));
    uint64_t hash = 0, same_hash = 1;
    OK(espalier_lattice_topology_hash(lattice, &hash));
    OK(espalier_lattice_topology_hash(same, &same_hash));
    CHECK(hash == same_hash);

    /* Each corner of a cell becomes a cell: those of the cube, and those of the pyramid, where
     * the apex gives one of type 4. */
    espalier_refiner* refiner = make_refiner(same, 1);
    espalier_cells level;
    OK(espalier_refiner_cells(refiner, 1, &level));
    CHECK(level.cell_count == 8 + 4 + 1);
    int type_four = 0;
    for (int32_t c = 0; c < level.cell_count; ++c)
        type_four += level.cell_offsets[c + 1] - level.cell_offsets[c] == 8;
    CHECK(type_four == 1);
    espalier_refiner_destroy(refiner);
    espalier_lattice_destroy(same);
    espalier_lattice_destroy(lattice);
}

static void test_positions_and_files(const char* rest_path, const char* pose_path) {
    espalier_lattice* lattice = make_box_lattice();
    int32_t count = 0;
    const double* positions = NULL;
    OK(espalier_lattice_positions(lattice, &count, &positions));
    CHECK(count == BOX_VERTICES);
    CHECK(positions[3 * BOX_CENTRE] == 0.5);

    double moved[3 * BOX_VERTICES];
    for (int i = 0; i < 3 * BOX_VERTICES; ++i) moved[i] = positions[i] + 1 + i % 3;
    OK(espalier_lattice_write(lattice, rest_path));
    OK(espalier_lattice_set_positions(lattice, BOX_VERTICES, moved));
    CHECK(positions[3 * BOX_CENTRE] == 1.5);
    OK(espalier_lattice_write(lattice, pose_path));

    espalier_lattice* read = NULL;
    OK(espalier_lattice_read(pose_path, &read));
    OK(espalier_lattice_positions(read, &count, &positions));
    CHECK(count == BOX_VERTICES);
    CHECK(memcmp(positions, moved, sizeof moved) == 0);
    uint64_t hash = 0, read_hash = 1;
    OK(espalier_lattice_topology_hash(lattice, &hash));
    OK(espalier_lattice_topology_hash(read, &read_hash));
    CHECK(hash == read_hash);
    espalier_lattice_destroy(read);
    espalier_lattice_destroy(lattice);
}

/* Returns the number of vertices of the lattice on which a vertex of level 1 depends. */
static int64_t entries_of(const espalier_lattice* lattice, int32_t vertex) {
    espalier_refiner* refiner = make_refiner(lattice, 1);
    espalier_table* table = NULL;
    OK(espalier_table_create_stencils(refiner, 1, &table));
    espalier_refiner_destroy(refiner);
    espalier_csr csr;
    OK(espalier_table_csr(table, &csr));
    const int64_t entries = csr.offsets[vertex + 1] - csr.offsets[vertex];
    espalier_table_destroy(table);
    return entries;
}

static void test_marks(void) {
    espalier_lattice* lattice = make_box_lattice();
    CHECK(entries_of(lattice, BOX_CENTRE) == 27);
    const int32_t centre = BOX_CENTRE;
    const double sharp = ESPALIER_SHARP;
    OK(espalier_lattice_mark_vertices(lattice, 1, &centre, &sharp));
    CHECK(entries_of(lattice, BOX_CENTRE) == 1);
    OK(espalier_lattice_clear_marks(lattice));
    CHECK(entries_of(lattice, BOX_CENTRE) == 27);

    /* A crease through the middle of the box, which contains the vertex in the centre. */
    const int32_t line[4] = {4, BOX_CENTRE, 22, BOX_CENTRE};
    const double both[2] = {ESPALIER_SHARP, ESPALIER_SHARP};
    OK(espalier_lattice_mark_edges(lattice, 2, line, both));
    CHECK(entries_of(lattice, BOX_CENTRE) == 3);
    espalier_lattice_destroy(lattice);
}

/* Returns six times the volume of the pyramid with its apex at the origin over a triangle. */
static double determinant(const double* a, const double* b, const double* c) {
    return a[0] * (b[1] * c[2] - b[2] * c[1]) + a[1] * (b[2] * c[0] - b[0] * c[2]) +
           a[2] * (b[0] * c[1] - b[1] * c[0]);
}

/* The cells of level 1 fill the cube, and the faces of each cell are oriented outwards. */
static void test_level_topology(void) {
    espalier_lattice* lattice = make_box_lattice();
    espalier_refiner* refiner = make_refiner(lattice, 1);
    int32_t counts[4];
    OK(espalier_refiner_counts(refiner, 1, counts));
    check_counts(counts, 125, 300, 240, 64);

    const double* base = NULL;
    int32_t base_count = 0;
    OK(espalier_lattice_positions(lattice, &base_count, &base));
    double positions[3 * 125];
    OK(espalier_refiner_carry_values(refiner, 1, 3, base, 3 * BOX_VERTICES, positions, 3 * 125));

    espalier_cells cells;
    const int8_t* signs = NULL;
    OK(espalier_refiner_cells(refiner, 1, &cells));
    OK(espalier_refiner_face_signs(refiner, 1, &signs));
    CHECK(cells.vertex_count == 125 && cells.face_count == 240 && cells.cell_count == 64);
    CHECK(cells.cell_offsets[64] == 6 * 64 && cells.face_offsets[240] == 4 * 240);
    double whole = 0;
    for (int32_t c = 0; c < cells.cell_count; ++c) {
        double volume = 0;
        for (int64_t i = cells.cell_offsets[c]; i < cells.cell_offsets[c + 1]; ++i) {
            const int64_t first = cells.face_offsets[cells.cell_faces[i]];
            const int64_t last = cells.face_offsets[cells.cell_faces[i] + 1];
            const double* corner = positions + 3 * cells.face_vertices[first];
            for (int64_t k = first + 1; k + 1 < last; ++k)
                volume += signs[i] *
                          determinant(corner, positions + 3 * cells.face_vertices[k],
                                      positions + 3 * cells.face_vertices[k + 1]) /
                          6;
        }
        CHECK(volume > 0);
        whole += volume;
    }
    CHECK(fabs(whole - 1) < tolerance);

    /* The arrays of a level can be passed in again, and stay valid when the next level is made. */
    espalier_lattice* again = NULL;
    OK(espalier_lattice_create(&cells, positions, &again));
    OK(espalier_refiner_refine(refiner, 2));
    CHECK(cells.cell_offsets[64] == 6 * 64);
    OK(espalier_lattice_counts(again, counts));
    check_counts(counts, 125, 300, 240, 64);
    espalier_lattice_destroy(again);
    espalier_refiner_destroy(refiner);
    espalier_lattice_destroy(lattice);
}

/* Computes table · values, one number for each column. */
static void multiply(const espalier_table* table, const double* values, double* result) {
    espalier_csr csr;
    OK(espalier_table_csr(table, &csr));
    for (int32_t r = 0; r < csr.row_count; ++r) {
        result[r] = 0;
        double sum = 0;
        for (int64_t i = csr.offsets[r]; i < csr.offsets[r + 1]; ++i) {
            CHECK(i == csr.offsets[r] || csr.columns[i - 1] < csr.columns[i]);
            result[r] += csr.weights[i] * values[csr.columns[i]];
            sum += csr.weights[i];
        }
        CHECK(fabs(sum - 1) < tolerance);
    }
}

enum { LEVEL_2 = 9 * 9 * 9 };

/* S_2 = R_2 · R_1, and S_0 is the identity. */
static void test_tables(void) {
    espalier_lattice* lattice = make_box_lattice();
    espalier_refiner* refiner = make_refiner(lattice, 2);
    espalier_table *whole = NULL, *none = NULL, *first = NULL, *second = NULL;
    OK(espalier_table_create_stencils(refiner, 2, &whole));
    OK(espalier_table_create_stencils(refiner, 0, &none));
    OK(espalier_table_create_level(refiner, 1, &first));
    OK(espalier_table_create_level(refiner, 2, &second));

    double values[BOX_VERTICES], same[BOX_VERTICES], between[125];
    static double at_once[LEVEL_2], step_by_step[LEVEL_2], carried[LEVEL_2];
    for (int i = 0; i < BOX_VERTICES; ++i) values[i] = sin(i);
    multiply(none, values, same);
    CHECK(memcmp(same, values, sizeof values) == 0);
    multiply(whole, values, at_once);
    multiply(first, values, between);
    multiply(second, between, step_by_step);
    OK(espalier_refiner_carry_values(refiner, 2, 1, values, BOX_VERTICES, carried, LEVEL_2));
    for (int i = 0; i < LEVEL_2; ++i) {
        CHECK(fabs(at_once[i] - step_by_step[i]) < tolerance);
        CHECK(fabs(at_once[i] - carried[i]) < tolerance);
    }
    espalier_table_destroy(second);
    espalier_table_destroy(first);
    espalier_table_destroy(none);
    espalier_table_destroy(whole);
    espalier_refiner_destroy(refiner);
    espalier_lattice_destroy(lattice);
}

/* Without boundary rules the region shrinks. */
static void test_open_boundary(void) {
    espalier_lattice* lattice = make_box_lattice();
    espalier_refine_options options = espalier_default_refine_options();
    options.boundary = ESPALIER_BOUNDARY_OPEN;
    espalier_refiner* refiner = NULL;
    OK(espalier_refiner_create(lattice, &options, &refiner));
    OK(espalier_refiner_refine(refiner, 1));
    int32_t counts[4];
    /* Of 2 × 2 × 2 cells, only the children at the inner vertex remain. */
    OK(espalier_refiner_counts(refiner, 1, counts));
    CHECK(counts[3] == 8);
    espalier_refiner_destroy(refiner);
    espalier_lattice_destroy(lattice);
}

int main(int count, char** arguments) {
    CHECK(count == 3);
    test_cells_of_any_shape();
    test_positions_and_files(arguments[1], arguments[2]);
    test_marks();
    test_level_topology();
    test_tables();
    test_open_boundary();
    return 0;
}
