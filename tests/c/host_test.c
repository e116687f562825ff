/* SPDX-License-Identifier: Apache-2.0 */
/* Tests the control of a host over threads, progress and cancelling. Results stay the same, bit
 * for bit. */

#include "box.h"
#include "check.h"

/* Enough points to be bound in more than one range. */
enum { POINTS = 17000 };
static double points[3 * POINTS], before[3 * POINTS], after[3 * POINTS];
static double pose[3 * BOX_VERTICES];
static espalier_refiner* refiner;

/* Scattered points in the cube. */
static void set_up(void) {
    int32_t cells[8 * BOX_CELLS];
    espalier_lattice* lattice = NULL;
    make_box(pose, cells);
    OK(espalier_lattice_create_hexahedra(BOX_VERTICES, pose, BOX_CELLS, cells, &lattice));
    OK(espalier_refiner_create(lattice, NULL, &refiner));
    espalier_lattice_destroy(lattice);
    uint32_t state = 1;
    for (int i = 0; i < 3 * POINTS; ++i) {
        state = state * 1664525u + 1013904223u;
        points[i] = state / 4294967296.0;
    }
}

/* Binds, applies the binding, and destroys it. */
static espalier_status deform(double* result) {
    espalier_bind_options options = espalier_default_bind_options();
    options.level = 1;
    espalier_binding* binding = NULL;
    espalier_status status =
        espalier_binding_create(refiner, BOX_VERTICES, pose, POINTS, points, &options, &binding);
    if (status == ESPALIER_OK)
        status = espalier_binding_apply(binding, BOX_VERTICES, pose, POINTS, result);
    espalier_binding_destroy(binding);
    return status;
}

static void test_thread_limit(void) {
    espalier_thread_limit* limit = NULL;
    OK(espalier_thread_limit_create(1, &limit));
    OK(deform(after));
    CHECK(memcmp(before, after, sizeof before) == 0);
    espalier_thread_limit_destroy(limit);
}

static void test_memory_limit(void) {
    espalier_memory_limit* limit = NULL;
    OK(espalier_memory_limit_create(1, &limit));
    CHECK(deform(after) == ESPALIER_ERROR_MEMORY);
    CHECK(strstr(espalier_last_error(), "the limit is 1 B") != NULL);
    espalier_memory_limit_destroy(limit);
    OK(deform(after));
    CHECK(memcmp(before, after, sizeof before) == 0);
}

/* A loop of the host, which runs backwards. */
static void run_backwards(void* user, int64_t count, espalier_task task, void* work) {
    ++*(int*)user;
    for (int64_t i = count; i > 0; --i) task(work, i - 1);
}

static void test_executors(void) {
    int runs = 0;
    espalier_executor_scope* scope = NULL;
    OK(espalier_executor_scope_create(run_backwards, &runs, &scope));
    OK(deform(after));
    espalier_executor_scope_destroy(scope);
    CHECK(runs > 0);
    CHECK(memcmp(before, after, sizeof before) == 0);
    const int runs_in_scope = runs;
    OK(espalier_executor_scope_create(NULL, NULL, &scope));
    OK(deform(after));
    espalier_executor_scope_destroy(scope);
    CHECK(memcmp(before, after, sizeof before) == 0);
    CHECK(runs == runs_in_scope);
}

typedef struct listener {
    int calls;
    int32_t goes_on;
} listener;

static int32_t listen(void* user, const espalier_progress* progress) {
    listener* own = user;
    CHECK(progress->stage >= 0 && progress->done >= 0 && progress->done <= progress->count);
    ++own->calls;
    return own->goes_on;
}

static void test_progress(void) {
    listener patient = {0, 1}, impatient = {0, 0};
    espalier_progress_scope* scope = NULL;
    OK(espalier_progress_scope_create(listen, &patient, 0, &scope));
    OK(deform(after));
    espalier_progress_scope_destroy(scope);
    CHECK(patient.calls > 0);
    CHECK(memcmp(before, after, sizeof before) == 0);

    OK(espalier_progress_scope_create(listen, &impatient, 0, &scope));
    REFUSED(deform(after), ESPALIER_CANCELLED, "cancel");
    espalier_progress_scope_destroy(scope);
    CHECK(impatient.calls == 1);
    OK(deform(after));
}

int main(void) {
    set_up();
    OK(deform(before));
    test_thread_limit();
    test_memory_limit();
    test_executors();
    test_progress();
    espalier_refiner_destroy(refiner);
    return 0;
}
