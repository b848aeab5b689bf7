/* Terms in batches, unpacked by vectors.
 *
 * Only kernel files include this file: each compiles it for its instruction set. */
#ifndef CVOL_ARRAY_BLOCK_BLOCK_BATCH_H
#define CVOL_ARRAY_BLOCK_BLOCK_BATCH_H

#include "array/core/array.h"
#include "base/vector.h"

/* Their coefficients, and their positions in the block. */
#define CVOL_BATCH 16
typedef struct cvol_term_batch {
    float value[CVOL_BATCH] __attribute__((aligned(64)));
    uint32_t place[CVOL_BATCH] __attribute__((aligned(64)));
    /* Set by cvol_batch_set_targets. */
    int32_t line[CVOL_BATCH] __attribute__((aligned(64)));
    int32_t basis[CVOL_BATCH] __attribute__((aligned(64)));
    int32_t sheet[CVOL_BATCH] __attribute__((aligned(64)));
    int32_t rows[CVOL_BATCH] __attribute__((aligned(64)));
} cvol_term_batch;

/* Unpacks CVOL_BATCH words; returns 0 and does nothing if one of them is an escape. */
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
    return !cvol_any(escapes);
}

/* The same for fewer terms, or with escapes; *count: the number of terms. */
CVOL_INLINE const uint32_t *cvol_batch_unpack_any(cvol_term_batch *batch, int *count,
                                                  const uint32_t *words, const uint32_t *end,
                                                  float step, int block_log2)
{
    int i = 0;
    for (; i < CVOL_BATCH && words < end; i++) {
        batch->value[i] = step * (float)cvol_term_unpack(&words, &batch->place[i],
                                                         cvol_place_bits(block_log2));
    }
    *count = i;
    return words;
}

/* Unpacks the next batch; *count: the number of terms in it. Returns the word behind it. */
CVOL_INLINE const uint32_t *cvol_batch_next(cvol_term_batch *batch, int *count,
                                            const uint32_t *words, const uint32_t *end, float step,
                                            int block_log2)
{
    *count = CVOL_BATCH;
    if (end - words >= CVOL_BATCH && cvol_batch_unpack(batch, words, step, block_log2))
        return words + CVOL_BATCH;
    return cvol_batch_unpack_any(batch, count, words, end, step, block_log2);
}

/* Finds the targets of a batch's terms on this view of the axes: on line (sheet, row), which begins
 * `line` floats behind the first; times the row of the lane basis that begins `basis` floats behind
 * its first, or, for octants whose bit of `split` is set, `parts` further. */
CVOL_INLINE void cvol_batch_set_targets(cvol_term_batch *batch, int block_log2, int width, int lane,
                                        int row, int sheet, int split, int parts)
{
    const int32_t mask = (1 << block_log2) - 1;
    for (int i = 0; i < CVOL_BATCH; i += CVOL_LANES) {
        cvol_vi place;
        memcpy(&place, batch->place + i, sizeof place);
        const cvol_vi f = place >> lane * block_log2 & mask, r = place >> row * block_log2 & mask,
                      s = place >> sheet * block_log2 & mask, rows = r + 1,
                      line = ((s << block_log2) + r) * width;
        cvol_vi basis = f * width;
        if (split) {
            const cvol_vi octant = (place & 1) | (place >> (block_log2 - 1) & 2) |
                                   (place >> (2 * block_log2 - 2) & 4);
            basis += ((split - (cvol_vi){0}) >> (octant + 1) & 1) * parts;
        }
        memcpy(batch->line + i, &line, sizeof line);
        memcpy(batch->basis + i, &basis, sizeof basis);
        memcpy(batch->sheet + i, &s, sizeof s);
        memcpy(batch->rows + i, &rows, sizeof rows);
    }
}

/* Adds a batch's terms to their lines. Within a slice the rows of terms never decrease, for any
 * order of axes. */
CVOL_INLINE void cvol_batch_add(float *first, uint8_t *rows, const cvol_term_batch *batch,
                                int count, const float *lane_basis, int width)
{
    for (int i = 0; i < count; i++) {
        float *line = first + batch->line[i];
        const float *basis = lane_basis + batch->basis[i];
        rows[batch->sheet[i]] = (uint8_t)batch->rows[i];
        for (int part = 0; part < width; part += CVOL_LANES)
            cvol_store(line + part,
                       cvol_load(line + part) + batch->value[i] * cvol_load(basis + part));
    }
}

#endif
