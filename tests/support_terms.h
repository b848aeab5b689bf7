/* Volumes of random terms, for tests of files. */
#ifndef CVOL_TESTS_SUPPORT_TERMS_H
#define CVOL_TESTS_SUPPORT_TERMS_H

#include "array/array.h"

/* A volume of float32 in blocks of `block`, with terms of any size, most of low frequencies; of 16:
 * every second cell split somehow if `split`, and `lapped`. */
cvol_array *support_terms_make(cvol_context *context, const size_t dims[3], int block, int split,
                               int lapped, uint64_t seed);
/* The test fails unless both have the same terms and splits. */
void support_terms_expect_same(const cvol_array *a, const cvol_array *b);

#endif
