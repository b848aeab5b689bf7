/* Selection by a histogram of all magnitudes, for the rules that depend on all of them.
 *
 * Magnitudes (keys) fall into bins of 1/128 octave by their bits. Sums within a bin are sums of
 * integers, so they are exact and do not depend on the order in which threads add. The bin that
 * contains a rule's limit is resolved exactly among its own coefficients, the candidates. */
#ifndef CVOL_ARRAY_TRUNCATE_BUILD_SELECT_H
#define CVOL_ARRAY_TRUNCATE_BUILD_SELECT_H

#include "array/core/array.h"

enum { CVOL_BIN_SHIFT = 16, CVOL_BINS = 1 << (31 - CVOL_BIN_SHIFT) };

typedef struct cvol_bin {
    uint64_t count, sum, squares; /* of the key's low CVOL_BIN_SHIFT bits */
} cvol_bin;

typedef struct cvol_bins {
    cvol_bin *bins;   /* CVOL_BINS */
    uint64_t forced;  /* terms that are always kept */
    uint64_t escapes; /* coefficients that take two words */
} cvol_bins;

int cvol_bins_make(cvol_bins *out); /* 0: no memory */
void cvol_bins_free(cvol_bins *bins);
void cvol_bins_merge(cvol_bins *to, const cvol_bins *from);

/* Adds a key, not negative. */
static inline void cvol_bins_add(cvol_bin *bins, uint32_t key_bits)
{
    cvol_bin *bin = &bins[key_bits >> CVOL_BIN_SHIFT];
    const uint64_t low = key_bits & ((1u << CVOL_BIN_SHIFT) - 1);
    bin->count++;
    bin->sum += low;
    bin->squares += low * low;
}

/* The selection: keys of at least `critical`, and of the candidates, keys from `least` up to it,
 * the largest within the limit. least = critical: there are none. */
typedef struct cvol_selection {
    float least, critical;
    uint64_t most;  /* number of candidates; or */
    double budget;  /* their allowed loss, a sum of squares; negative: `most` decides */
    double rounded; /* the loss of a kept one */
} cvol_selection;

/* One of the rules TERMS, RHO, RATIO, PSNR, L2 (PSNR: of the error bound's value range);
 * array->step is set. base_bytes: the bytes of the array without terms. Errors: TARGET. */
int cvol_select(cvol_context *context, cvol_selection *out, const cvol_array *array,
                const cvol_keep *keep, const cvol_bins *bins, uint64_t base_bytes);

/* A candidate, ordered by key, the largest first, then by block and group. Candidates of one group
 * are kept or dropped together. */
typedef struct cvol_candidate {
    uint64_t block;
    uint32_t group;
    float key;
} cvol_candidate;

/* < 0, 0, > 0 if a comes before, with, after b. */
int cvol_candidate_order(const cvol_candidate *a, const cvol_candidate *b);
/* Sorts them; returns how many of the first are kept. */
size_t cvol_select_candidates(cvol_candidate *candidates, size_t count,
                              const cvol_selection *selection);

/* The L2 norm that the rules PSNR and L2 allow to drop. */
double cvol_select_allowed(const cvol_array *array, const cvol_keep *keep);

/* About the largest step that loses no more than the L2 norm `allowed`, if keys below `dead_zone`
 * steps become zero and the others are rounded. 0: every step loses more, or there are no keys. */
double cvol_select_step(const cvol_bins *bins, double allowed, double dead_zone);

#endif
