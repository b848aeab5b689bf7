/* Lack of memory: in each step of the tour the n-th allocation fails, for n = 1, 2, 3, ... (from
 * the sixtieth on only some), alone or with all that follow it. The result is the step's work or
 * CVOL_ERROR_MEMORY with a message, never a file reported as damaged, and no crash; all memory is
 * freed. Runs if the C library lets a program replace its allocation. */
#include "test.h"

#include <limits.h>

#include "support.h"
#include "support_allocation.h"
#include "support_context.h"
#include "support_files.h"
#include "support_tour.h"

/* ---- steps ------------------------------------------------------------------------------ */

static tour t;

/* 1: the step ended before anything failed. */
static int try(const tour_step *step, long n, allocation_failure how)
{
    const long before = allocation_count();
    allocation_fail(n, how);
    const int code = step->go(&t);
    const int done = allocation_stop();
    const long kept = allocation_count() - before;
    if ((code && code != CVOL_ERROR_MEMORY) || kept)
        fail_msg("%s, allocation %ld%s: code %d, '%s', %ld pieces of memory are not freed",
                 step->name, n, how == ALLOCATION_ALL_FROM ? " and more" : "", code,
                 cvol_context_message(t.context), kept);
    return done;
}

static void try_all(const tour_step *steps)
{
    if (!allocation_is_replaced())
        skip();
    for (; steps->name; steps++) {
        long n = 1;
        assert_int_equal(steps->go(&t), CVOL_OK); /* allocations that happen once per process */
        for (; !try(steps, n, ALLOCATION_ONE); n += n < 60 ? 1 : n / 3)
            (void)try(steps, n, ALLOCATION_ALL_FROM);
        if (test_verbose())
            print_message("%s: %ld allocations\n", steps->name, n);
    }
}

/* Files of all kinds: each of these steps writes one. */
static void read_files_of(const tour_step *steps)
{
    if (!allocation_is_replaced())
        skip();
    for (; steps->name; steps++) {
        assert_int_equal(steps->go(&t), CVOL_OK);
        if (test_verbose())
            print_message("%s:\n", steps->name);
        try_all(tour_reading);
    }
}

static void reading_volumes(void **state)
{
    (void)state;
    const tour_step some[] = {
        tour_compressing[0], tour_compressing[6], tour_compressing[7], {NULL, NULL}};
    read_files_of(some); /* to a ratio, without loss, with a fill */
}

static void reading_arrays(void **state)
{
    (void)state;
    read_files_of(tour_operations);
}

static void pictures(void **state)
{
    (void)state;
    assert_int_equal(tour_write(&t, 1), CVOL_OK);
    try_all(tour_pictures);
}

/* No machine has this many processors, and OpenMP would end the process. */
static void threads_are_limited(void **state)
{
    (void)state;
    cvol_context *many = cvol_context_create(), *before = t.context;
    assert_int_equal(tour_write(&t, 1), CVOL_OK); /* earlier steps leave other files */
    cvol_context_set_threads(many, INT_MAX);
    assert_in_range(cvol_context_threads(many), 1, 1 << 14);
    t.context = many;
    const int code = tour_reading[0].go(&t);
    t.context = before;
    cvol_context_free(many);
    assert_int_equal(code, CVOL_OK);
}

static int start(void **state)
{
    if (files_setup(state))
        return -1;
    cvol_context_set_threads(context, 1); /* OpenMP ends a process if it cannot start threads */
    return !tour_begin(&t, context, file_path) || tour_write(&t, 0);
}

static int stop(void **state)
{
    free(t.volume.data);
    return files_teardown(state);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(reading_volumes),
        cmocka_unit_test(reading_arrays),
        cmocka_unit_test(pictures),
        cmocka_unit_test(threads_are_limited),
    };
    if (getenv("CVOL_TEST_ONLY"))
        cmocka_set_test_filter(getenv("CVOL_TEST_ONLY"));
    return cmocka_run_group_tests(tests, start, stop);
}
