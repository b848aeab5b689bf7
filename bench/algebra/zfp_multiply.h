/* zfp's compressed arrays of 3-D floats, multiplied element by element. */
#ifndef BENCH_ALGEBRA_ZFP_MULTIPLY_H
#define BENCH_ALGEBRA_ZFP_MULTIPLY_H

#include <stddef.h>

#ifdef __cplusplus
extern "C" {
#endif

typedef struct zfp_pair zfp_pair;

/* The implementation of c = a b. */
enum zfp_way {
    ZFP_ITERATORS, /* *c = *a * *b through zfp::array3f::iterator, which go block by block */
    ZFP_INDICES,   /* c(i, j, k) = a(i, j, k) * b(i, j, k), with three loops */
    ZFP_WHOLE,     /* a.get(), b.get(), a product of dense floats, c.set() */
    ZFP_WAYS
};

/* Compresses both and makes c, at the rate, in bits per value; zfp rounds it up: zfp_pair_rate. */
zfp_pair *zfp_pair_make(const float *a, const float *b, const size_t dims[3], double rate);
double zfp_pair_rate(const zfp_pair *pair);
/* c = a b; all of c is compressed when it returns. */
void zfp_pair_multiply(zfp_pair *pair, int way);
/* c's samples. */
void zfp_pair_result(zfp_pair *pair, float *out);
void zfp_pair_free(zfp_pair *pair);

#ifdef __cplusplus
}
#endif
#endif
