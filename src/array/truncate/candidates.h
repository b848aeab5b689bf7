/* Iteration over the candidates of a truncation in the order of their places. */
#ifndef CVOL_ARRAY_TRUNCATE_CANDIDATES_H
#define CVOL_ARRAY_TRUNCATE_CANDIDATES_H

#include <stddef.h>
#include <stdint.h>

#include "cvol/array.h"

/* The candidates: all N slots, or a box of them (wrapped like a low box), or a list. */
typedef struct cvol_candidates {
    const float *slots;     /* dense candidates: a box of `box` around the origin, x fastest */
    size_t low[3], box[3];  /* as in cvol_spectrum; low = box = dims for all N (DCT) */
    const uint32_t *places; /* further ones, strictly rising, none within the box; may be NULL */
    const float *values;
    size_t count;
} cvol_candidates;

static inline size_t cvol_candidates_dense(const cvol_candidates *c)
{
    return c->slots ? c->box[0] * c->box[1] * c->box[2] : 0;
}

/* Writes the magnitude of every candidate, first the dense ones in their order, then the listed
 * ones. DCT, DHT: |slot|. DFT: for both slots of a pair |F| = sqrt((slot[p]^2 + slot[-p]^2) / 2),
 * so that a term's share of its pair's energy decides; a partner that is not listed counts as 0. */
void cvol_candidates_keys(cvol_context *context, float *keys, const cvol_candidates *c,
                          cvol_transform transform, const size_t dims[3]);

/* The place of the other slot of a pair. DCT, DHT: the place itself. */
size_t cvol_mirror_place(cvol_transform transform, size_t place, const size_t dims[3]);

/* ---- runs ------------------------------------------------------------------------------------ */

/* A run of consecutive candidates: `count` from dense index or list index `first` on. Dense ones
 * have neighbouring places from `place` on; listed ones have their own. */
typedef struct cvol_run {
    int listed;
    size_t first, count, place;
} cvol_run;

/* The remaining candidates: dense indices dense .. dense_end - 1, list indices list .. list_end -
 * 1. */
typedef struct cvol_run_cursor {
    size_t dense, dense_end, list, list_end;
} cvol_run_cursor;

/* Part `part` of `parts` of all; the parts' places rise. */
cvol_run_cursor cvol_runs_start(const cvol_candidates *c, const size_t dims[3], size_t part,
                                size_t parts);
/* 0: there are no more. */
int cvol_runs_next(cvol_run_cursor *cursor, cvol_run *run, const cvol_candidates *c,
                   const size_t dims[3]);

#endif
