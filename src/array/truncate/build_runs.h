/* Internals of the builder: blocks in runs; one thread makes each run in separate memory. */
#ifndef CVOL_ARRAY_TRUNCATE_BUILD_RUNS_H
#define CVOL_ARRAY_TRUNCATE_BUILD_RUNS_H

#include "array/core/array.h"
#include "array/truncate/build_pack.h"
#include "array/truncate/build_select.h"
#include "array/truncate/producer.h"

/* With drops_isolated, a coefficient becomes 1 from CVOL_LEAST_ONE steps on, or from CVOL_LEAST_ONE
 * + isolated / (1 + n), n the sum of the magnitudes, in steps, of the three of next lower
 * frequency. At CVOL_ISOLATED, the least `isolated`, errors and the bits that they save balance. */
#define CVOL_LEAST_ONE 0.52
#define CVOL_ISOLATED 0.4

/* A coefficient whose key lies in the critical bin: packed, and perhaps removed later. */
typedef struct cvol_critical_candidate {
    uint32_t block, place; /* block: within the run */
    float key, value;
} cvol_critical_candidate;

typedef struct cvol_build_run {
    uint32_t *terms;
    size_t words;
    uint64_t coefficients;
    double lost, norm;  /* sums of squares */
    double block_lost;  /* at most, of the last block */
    double worst_point; /* bounds what any sample lost, before the post-filter */
    float max_abs;
    int code;
    cvol_critical_candidate *candidates;
    size_t candidate_count, candidate_capacity;
} cvol_build_run;

typedef struct cvol_builder {
    cvol_array *array;
    const cvol_producer *producer;
    size_t per_block, run_blocks, run_count;
    cvol_build_run *runs;
    uint8_t *forced;       /* for each place, 1 if it lies in the low box; NULL: none does */
    float least, critical; /* see cvol_selection */
    cvol_bins *counting;   /* the first pass of two; NULL: packing */
    size_t counted;        /* it counts one run in so many */
    double step;
    double expected_step; /* for the splits of blocks; 0: unknown */
    int drops_isolated;   /* with `isolated`, see CVOL_ISOLATED */
    double isolated;
    int hides; /* the loss of samples that the mask hides, or beyond the volume, does not count */
} cvol_builder;

/* The first block of a run; for the run behind the last, the number of blocks. */
size_t cvol_run_begin(const cvol_builder *b, size_t run_index);
/* Points the run's blocks to their terms, which are contiguous. */
void cvol_run_place_terms(const cvol_builder *b, size_t run_index);
/* The other slot of a pair (DFT); the place itself if it is its own mirror. */
uint32_t cvol_block_partner(const cvol_array *array, uint32_t place);

/* One pass over all blocks: counts them (b->counting), or packs them into the runs. Progress from
 * `from` to `to`. Errors: as cvol_build_blocks. */
int cvol_build_pass(cvol_context *context, cvol_builder *b, double from, double to);
/* Decides about the candidates, and removes those that are not kept from the runs. */
int cvol_build_commit(cvol_context *context, cvol_builder *b, const cvol_selection *selection);

#endif
