/* The context of a file of tests: one for all of them, or one for each. */
#ifndef CVOL_TESTS_SUPPORT_CONTEXT_H
#define CVOL_TESTS_SUPPORT_CONTEXT_H

#include "cvol/base.h"

extern cvol_context *context;

/* For cmocka: makes the context, with one thread per processor, with one or with two; and frees
 * it. */
int context_setup(void **state);
int context_setup_one(void **state);
int context_setup_two(void **state);
int context_teardown(void **state);

/* The test fails with the context's message unless the code is CVOL_OK. */
void check_ok(int code);

#endif
