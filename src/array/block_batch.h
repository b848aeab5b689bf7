/* Terms in batches, unpacked by vectors.
 *
 * To be included by kernel files only: each compiles it for its instruction set.
 */
#ifndef CVOL_ARRAY_BLOCK_BATCH_H
#define CVOL_ARRAY_BLOCK_BATCH_H

#include "array/array.h"
#include "base/vector.h"

/* Their coefficients and where they go. */
#define CVOL_BATCH 16
typedef struct cvol_term_batch {
    float value[CVOL_BATCH] __attribute__((aligned(64)));
    uint32_t place[CVOL_BATCH] __attribute__((aligned(64)));
    int32_t keep[CVOL_BATCH] __attribute__((aligned(64))); /* -1: on the line of the one before */
    uint32_t last_line;
} cvol_term_batch;

/* Unpacks CVOL_BATCH words at once; 0, and nothing done, if one of them is an escape. */
CVOL_INLINE int cvol_batch_unpack(cvol_term_batch *batch, const uint32_t *words, float step,
                                  int block_log2)
{
    const int place_bits = cvol_place_bits(block_log2);
    const int32_t mask = (1 << place_bits) - 1, escape = cvol_term_escape(place_bits);
    cvol_vi escapes = {0};
    for (int i = 0; i < CVOL_BATCH; i += CVOL_LANES) {
        cvol_vi word;
        memcpy(&word, words + i, sizeof word);
        cvol_vi value = word >> place_bits, place = word & mask;
        escapes |= value == escape;
        cvol_store(batch->value + i, cvol_to_float(value) * step);
        memcpy(batch->place + i, &place, sizeof place);
    }
    if (cvol_any(escapes))
        return 0;
    uint32_t line = batch->last_line;
    for (int i = 0; i < CVOL_BATCH; i++) {
        batch->keep[i] = batch->place[i] >> block_log2 == line ? -1 : 0;
        line = batch->place[i] >> block_log2;
    }
    batch->last_line = line;
    return 1;
}

/* The same for fewer terms, or where there are escapes; how many there are goes to *count. */
CVOL_INLINE const uint32_t *cvol_batch_unpack_slowly(cvol_term_batch *batch, int *count,
                                                     const uint32_t *words, const uint32_t *end,
                                                     float step, int block_log2)
{
    int i = 0;
    for (; i < CVOL_BATCH && words < end; i++) {
        batch->value[i] = step * (float)cvol_term_unpack(&words, &batch->place[i],
                                                         cvol_place_bits(block_log2));
        uint32_t line = batch->place[i] >> block_log2;
        batch->keep[i] = line == batch->last_line ? -1 : 0;
        batch->last_line = line;
    }
    *count = i;
    return words;
}

/* The next batch, how many are in it to *count; what follows it. */
CVOL_INLINE const uint32_t *cvol_batch_next(cvol_term_batch *batch, int *count,
                                            const uint32_t *words, const uint32_t *end, float step,
                                            int block_log2)
{
    *count = CVOL_BATCH;
    if (end - words >= CVOL_BATCH && cvol_batch_unpack(batch, words, step, block_log2))
        return words + CVOL_BATCH;
    return cvol_batch_unpack_slowly(batch, count, words, end, step, block_log2);
}

#endif
