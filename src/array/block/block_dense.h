/* Step 1 of the inverse (block_inverse.h) for a block with many terms. The terms go to their
 * positions in a dense box, and its lines are summed from there, several together, in registers.
 * The sums have the same order as term by term, where each would wait for the one before.
 *
 * Only kernel files include this file: each compiles it for its instruction set. */
#ifndef CVOL_ARRAY_BLOCK_BLOCK_DENSE_H
#define CVOL_ARRAY_BLOCK_BLOCK_DENSE_H

#include "array/block/block_batch.h"
#include "array/block/block_inverse_steps.h"

/* Blocks of 16^3 only. */
enum { CVOL_DENSE = 16, CVOL_DENSE_LOG2 = 4 };

/* Lines summed together. */
#if CVOL_LANES == 16
#define CVOL_DENSE_LINES 8
#else
#define CVOL_DENSE_LINES 4
#endif

/* Returns 1 if a block has enough terms, by measured clocks of both ways. */
CVOL_INLINE int cvol_dense_is_cheaper(const cvol_block *block, int lane, int row, int sheet)
{
    const uint32_t lines = (uint32_t)(block->low[row] * block->low[sheet]);
    /* With lane = x, consecutive terms mostly belong to the same line. */
    return block->words * (lane == 0 ? 2 : 1) > lines * (uint32_t)(4 + block->low[lane] / 2);
}

/* Terms unpacked before they are stored. They are read from memory: that is cheaper than extracting
 * them one by one from vectors. */
enum { CVOL_DENSE_CHUNK = 64, CVOL_DENSE_PLACE_BITS = 3 * CVOL_DENSE_LOG2 };

CVOL_INLINE cvol_vi cvol_dense_place(cvol_vi word, int lane, int row, int sheet)
{
    const int32_t mask = CVOL_DENSE - 1;
    return (word >> lane * CVOL_DENSE_LOG2 & mask) |
           (word >> row * CVOL_DENSE_LOG2 & mask) << CVOL_DENSE_LOG2 |
           (word >> sheet * CVOL_DENSE_LOG2 & mask) << 2 * CVOL_DENSE_LOG2;
}

/* Writes terms, as integers, to box[(sheet 16 + row) 16 + lane]. */
CVOL_INLINE void cvol_dense_put(int32_t *box, const cvol_block *block, int lane, int row, int sheet)
{
    int32_t values[CVOL_DENSE_CHUNK] __attribute__((aligned(64)));
    int32_t places[CVOL_DENSE_CHUNK] __attribute__((aligned(64)));
    for (int s = 0; s < block->low[sheet]; s++)
        memset(box + s * CVOL_DENSE * CVOL_DENSE, 0,
               sizeof *box * (size_t)(block->low[row] * CVOL_DENSE));
    const uint32_t *words = block->terms, *end = cvol_block_end(block);
    while (words < end) {
        int count = 0;
        for (; count < CVOL_DENSE_CHUNK && end - words >= CVOL_LANES; count += CVOL_LANES) {
            cvol_vi word;
            memcpy(&word, words, sizeof word);
            const cvol_vi value = word >> CVOL_DENSE_PLACE_BITS;
            const cvol_vi place = cvol_dense_place(word, lane, row, sheet);
            memcpy(values + count, &value, sizeof value);
            memcpy(places + count, &place, sizeof place);
            if (__builtin_expect(cvol_any(value == cvol_term_escape(CVOL_DENSE_PLACE_BITS)), 0))
                break;
            words += CVOL_LANES;
        }
#pragma GCC unroll 8
        for (int i = 0; i < count; i++)
            box[places[i]] = values[i];
        if (count == CVOL_DENSE_CHUNK)
            continue;
        for (int i = 0; i < CVOL_LANES && words < end; i++) {
            uint32_t place;
            const int32_t value = cvol_term_unpack(&words, &place, CVOL_DENSE_PLACE_BITS);
            const cvol_vi at = cvol_dense_place((int32_t)place - (cvol_vi){0}, lane, row, sheet);
            box[at[0]] = value;
        }
    }
}

/* Sums `count` lines `stride` apart; column f has the basis bases[f & 1] + 16 f. */
CVOL_INLINE void cvol_dense_sum(float *out, const int32_t *box, ptrdiff_t stride, int count,
                                float step, const float *const bases[2])
{
    float values[CVOL_DENSE_LINES * CVOL_DENSE] __attribute__((aligned(64)));
    cvol_vi any[CVOL_DENSE / CVOL_LANES];
    uint32_t columns = 0;
    for (int part = 0; part < CVOL_DENSE; part += CVOL_LANES) {
        any[part / CVOL_LANES] = (cvol_vi){0};
        for (int i = 0; i < count; i++) {
            cvol_vi terms;
            memcpy(&terms, box + i * stride + part, sizeof terms);
            any[part / CVOL_LANES] |= terms;
            cvol_store(values + i * CVOL_DENSE + part, cvol_to_float(terms) * step);
        }
#if CVOL_LANES == 16
        columns = _mm512_test_epi32_mask((__m512i)any[0], (__m512i)any[0]);
#else
        if (cvol_any(any[part / CVOL_LANES]))
            columns |= ((1u << CVOL_LANES) - 1) << part;
#endif
    }
    for (int part = 0; part < CVOL_DENSE; part += CVOL_LANES) {
        cvol_vf sums[CVOL_DENSE_LINES];
        for (int i = 0; i < count; i++)
            sums[i] = (cvol_vf){0};
        for (uint32_t left = columns; left; left &= left - 1) {
            const int f = __builtin_ctz(left);
            const cvol_vf basis = cvol_load(bases[f & 1] + f * CVOL_DENSE + part);
            for (int i = 0; i < count; i++)
                sums[i] += values[i * CVOL_DENSE + f] * basis;
        }
        for (int i = 0; i < count; i++)
            cvol_store(out + i * stride + part, sums[i]);
    }
}

/* The number of the `rows` lines up to the last nonzero one. */
CVOL_INLINE int cvol_dense_rows(const int32_t *box, int rows)
{
    for (; rows > 1; rows--) {
        cvol_vi any = {0}, terms;
        for (int part = 0; part < CVOL_DENSE; part += CVOL_LANES) {
            memcpy(&terms, box + (rows - 1) * CVOL_DENSE + part, sizeof terms);
            any |= terms;
        }
        if (cvol_any(any))
            break;
    }
    return rows;
}

/* Lines begin, begin + way, ... below end, of one slice. */
CVOL_INLINE void cvol_dense_lines(float *out, int32_t *box, int begin, int end, int way, float step,
                                  const float *const bases[2])
{
    const ptrdiff_t stride = (ptrdiff_t)way * CVOL_DENSE;
    int r = begin;
    for (; r + (CVOL_DENSE_LINES - 1) * way < end; r += CVOL_DENSE_LINES * way)
        cvol_dense_sum(out + r * CVOL_DENSE, box + r * CVOL_DENSE, stride, CVOL_DENSE_LINES, step,
                       bases);
    for (; r + way < end; r += 2 * way)
        cvol_dense_sum(out + r * CVOL_DENSE, box + r * CVOL_DENSE, stride, 2, step, bases);
    for (; r < end; r += way)
        cvol_dense_sum(out + r * CVOL_DENSE, box + r * CVOL_DENSE, stride, 1, step, bases);
}

/* Step 1, for the first `low_row` rows and `low_sheet` slices. Lines of row r in slice s have the
 * bases [s & 1][r & 1], by the last bit of the column; `way` 1: all rows have the same bases, else
 * 2. One function for all axes, since it is long. */
static __attribute__((noinline)) void
cvol_dense_lanes(float *first, int32_t *box, cvol_block_rows *rows, const cvol_block *block,
                 const float *const bases[2][2][2], int way, float step, int lane, int row,
                 int sheet, int low_row, int low_sheet)
{
    cvol_dense_put(box, block, lane, row, sheet);
    for (int s = 0; s < low_sheet; s++) {
        const ptrdiff_t at = (ptrdiff_t)s * CVOL_DENSE * CVOL_DENSE;
        const int count = cvol_dense_rows(box + at, low_row);
        rows->count[s] = (uint8_t)count;
        for (int half = 0; half < way; half++)
            cvol_dense_lines(first + at, box + at, half, count, way, step, bases[s & 1][half]);
    }
}

#endif
