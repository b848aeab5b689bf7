/* Volumes of random terms, for tests of files. */
#ifndef CVOL_TESTS_SUPPORT_TERMS_H
#define CVOL_TESTS_SUPPORT_TERMS_H

#include "array/core/array.h"

typedef struct support_terms {
    size_t dims[3];
    int block;
    int split, lapped; /* blocks of 16: every second cell split somehow; lapped */
    int small_values;  /* only small values; else some are very large */
    uint64_t seed;
} support_terms;

/* A volume of float32 with these properties; most terms are of low frequencies, some blocks have
 * none. */
cvol_array *support_terms_make(cvol_context *context, const support_terms *how);
/* The test fails unless both have the same terms and splits. */
void support_terms_expect_same(const cvol_array *a, const cvol_array *b);

#endif
