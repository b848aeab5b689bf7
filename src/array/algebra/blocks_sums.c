/* Sums over samples from the terms of blocks, by Parseval. Blocks that reach beyond the array are
 * evaluated, and the samples inside are summed. Parseval does not hold for lapped volumes: all of
 * their samples are summed (lapped.h). Partial sums are over fixed runs of blocks, or parts of the
 * stream, and are added in order, so that they do not depend on the numbers of threads and
 * processes. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "array/algebra/operations.h"
#include "array/block/block_sums.h"
#include "array/block/lapped.h"
#include "array/core/share.h"
#include "base/context.h"
#include "base/cpu.h"
#include "base/memory.h"

enum { RUN_BLOCKS = 64 };

/* Over one run: sum a, sum b, sum a b (or sum (a - b)^2), without the offsets. */
typedef struct partial {
    double a, b, product;
} partial;

typedef struct sums {
    const cvol_array *a, *b; /* b may be a */
    int apart;               /* sum (a - b)^2 in place of sum a b */
    int whole;               /* no block reaches beyond the array */
    double root;             /* of a block's number of terms */
    partial *runs;
    size_t run_count;
    size_t first_piece; /* lapped volumes: the run of the stream's piece 0 */
} sums;

/* The working memory of one thread: one integer per place, zero between blocks, and samples. */
typedef struct workplace {
    int32_t *table;
    float *x, *y;
} workplace;

/* Counts the samples of the block within the array along each axis; returns 1 if all are. */
static int inside_of(size_t inside[3], const cvol_array *array, size_t index)
{
    size_t at[3];
    int whole = 1;
    cvol_block_origin(at, array, index);
    for (int i = 0; i < 3; i++) {
        const size_t side = cvol_block_side(array, i), left = array->grid.dims[i] - at[i];
        inside[i] = left < side ? left : side;
        whole = whole && left >= side;
    }
    return whole;
}

static void add_samples(partial *to, workplace *w, const sums *s, size_t index,
                        const size_t inside[3])
{
    const size_t row = cvol_block_side(s->a, 0), sheet = row * cvol_block_side(s->a, 1);
    const float *y = w->x;
    cvol_block_evaluate(w->x, s->a, index);
    if (s->a != s->b) {
        cvol_block_evaluate(w->y, s->b, index);
        y = w->y;
    }
    for (size_t k = 0; k < inside[2]; k++)
        for (size_t j = 0; j < inside[1]; j++)
            for (size_t i = 0; i < inside[0]; i++) {
                const size_t p = i + row * j + sheet * k;
                to->a += (double)w->x[p];
                to->b += (double)y[p];
                const double apart = (double)w->x[p] - (double)y[p];
                to->product += s->apart ? apart * apart : (double)w->x[p] * (double)y[p];
            }
}

CVOL_SIMD_DECLARE(double, cvol_block_squares, (const cvol_block *block, int place_bits));

double cvol_block_squares(const cvol_block *block, int place_bits)
{
    return CVOL_SIMD_CHOOSE(cvol_block_squares)(block, place_bits);
}

/* The sum of a split block's samples, from the constant terms of its sub-blocks. Frequency 0 of a
 * sub-block of side 8 is at 0 or 1 of each axis, of side 4 at 0 to 3. */
static double sum_of_parts(const cvol_block *block, int place_bits)
{
    const uint32_t *words = block->terms, *end = cvol_block_end(block);
    double sum = 0;
    while (words < end) {
        uint32_t place;
        const double value = (double)cvol_term_unpack(&words, &place, place_bits);
        const uint32_t u = place & 15, v = place >> 4 & 15, w = place >> 8;
        const uint32_t octant = (u & 1) + 2 * (v & 1) + 4 * (w & 1);
        const int fours = block->split >> (1 + octant) & 1;
        if ((u | v | w) < (fours ? 4 : 2))
            sum += value * sqrt(fours ? 64 : 512);
    }
    return sum;
}

/* The quantized value of the constant term. */
static double constant_of(const cvol_block *block, int place_bits)
{
    uint32_t place;
    const uint32_t *words = block->terms;
    if (!block->words)
        return 0;
    const int32_t value = cvol_term_unpack(&words, &place, place_bits);
    return place == 0 ? (double)value : 0;
}

/* Writes the block's values to their places. */
static void spread(int32_t *table, const cvol_block *block, int place_bits)
{
    const uint32_t mask = (UINT32_C(1) << place_bits) - 1;
    const int32_t escape = cvol_term_escape(place_bits);
    const uint32_t *words = block->terms, *end = cvol_block_end(block);
#pragma GCC unroll 4
    for (; words < end; words++) {
        const uint32_t place = *words & mask;
        int32_t value = (int32_t)*words >> place_bits;
        if (__builtin_expect(value == escape, 0))
            value = (int32_t) * ++words;
        table[place] = value;
    }
}

/* Sets them to zero again. It also takes second words of escapes for terms, which clears some more
 * of the per_block places (a power of two). */
static void clear(int32_t *table, const cvol_block *block, size_t per_block)
{
    const uint32_t mask = (uint32_t)per_block - 1;
    const uint32_t *words = block->terms, *end = cvol_block_end(block);
#pragma GCC unroll 8
    for (; words < end; words++)
        table[*words & mask] = 0;
}

/* Sum of products of the values at common places: one block is spread over a table, and the other
 * reads there. (In a merge each address would wait for the last comparison; here all addresses are
 * known at once.) A value without escape has 31 bits minus the bits of a place, so the sum of its
 * products with an int32_t over all places fits into an int64_t. */
static double products_of(int32_t *table, const cvol_block *x, const cvol_block *y,
                          const cvol_array *shape)
{
    const int place_bits = cvol_place_bits(shape->block_log2);
    const uint32_t mask = (UINT32_C(1) << place_bits) - 1;
    const int32_t escape = cvol_term_escape(place_bits);
    const uint32_t *words = y->terms, *end = words + y->words;
    int64_t small = 0;
    double large = 0;
    spread(table, x, place_bits);
#pragma GCC unroll 4
    for (; words < end; words++) {
        const uint32_t place = *words & mask;
        const int64_t value = (int32_t)*words >> place_bits;
        if (__builtin_expect(value == escape, 0))
            large += (double)(int32_t) * ++words * (double)table[place];
        else
            small += value * table[place];
    }
    clear(table, x, cvol_array_block_terms(shape));
    return (double)small + large;
}

/* Sum of squared differences of the terms, computed directly: sums would cancel. */
static double distance_of(int32_t *table, const cvol_block *x, double step_x, const cvol_block *y,
                          double step_y, int place_bits)
{
    const uint32_t *words = y->terms, *end = words + y->words;
    uint32_t place;
    double sum = 0;
    spread(table, x, place_bits);
    while (words < end) {
        const int32_t value = cvol_term_unpack(&words, &place, place_bits);
        const double apart = step_x * (double)table[place] - step_y * (double)value;
        sum += apart * apart;
        table[place] = 0;
    }
    words = x->terms;
    end = words + x->words;
    while (words < end) {
        (void)cvol_term_unpack(&words, &place, place_bits);
        const double left = step_x * (double)table[place];
        sum += left * left;
        table[place] = 0;
    }
    return sum;
}

static void add_block(partial *to, workplace *w, const sums *s, size_t index)
{
    const cvol_block *x = &s->a->block_table[index], *y = &s->b->block_table[index];
    size_t inside[3];
    if (!x->words && !y->words)
        return;
    if ((!s->whole || x->split != y->split) &&
        (!inside_of(inside, s->a, index) || x->split != y->split)) {
        add_samples(to, w, s, index, inside);
        return;
    }
    const int bits = cvol_place_bits(s->a->block_log2);
    const double step_a = (double)(float)s->a->step, step_b = (double)(float)s->b->step;
    to->a += step_a * (x->split ? sum_of_parts(x, bits) : s->root * constant_of(x, bits));
    to->b += step_b * (y->split ? sum_of_parts(y, bits) : s->root * constant_of(y, bits));
    if (s->apart)
        to->product += distance_of(w->table, x, step_a, y, step_b, bits);
    else if (s->a == s->b)
        to->product += step_a * step_a * cvol_block_squares(x, bits);
    else if (x->words && y->words)
        to->product += step_a * step_b * products_of(w->table, x, y, s->a);
}

static void add_runs(partial *total, const partial *runs, size_t count)
{
    memset(total, 0, sizeof *total);
    for (size_t r = 0; r < count; r++) {
        total->a += runs[r].a;
        total->b += runs[r].b;
        total->product += runs[r].product;
    }
}

/* ---- lapped volumes -------------------------------------------------------------------------- */

static void add_piece(void *user, const cvol_piece *piece)
{
    const sums *s = user;
    const size_t count = piece->end[0] - piece->begin[0];
    partial sum = {0};
    for (size_t z = 0; z < piece->end[2] - piece->begin[2]; z++)
        for (size_t y = 0; y < piece->end[1] - piece->begin[1]; y++) {
            const size_t at = y * piece->line + z * piece->sheet;
            const float *a = piece->samples[0] + at, *b = a;
            if (s->a != s->b)
                b = piece->samples[1] + at;
            for (size_t x = 0; x < count; x++) {
                const double apart = (double)a[x] - (double)b[x];
                sum.a += (double)a[x];
                sum.b += (double)b[x];
                sum.product += s->apart ? apart * apart : (double)a[x] * (double)b[x];
            }
        }
    s->runs[s->first_piece + piece->index] = sum;
}

/* Limits the stream to the pieces of a share: those of a layer of blocks end two slices before the
 * layer does, but for the last one. */
static void limit_stream(cvol_stream *stream, sums *s, const cvol_share *share)
{
    enum { BACK = 2 };
    if (share->layers[0] > 0) {
        stream->begin[2] = share->slices[0] - BACK;
        s->first_piece = (share->layers[0] - 1) * s->a->blocks[1];
    }
    if (share->layers[1] < s->a->blocks[2])
        stream->end[2] = share->slices[1] - BACK;
}

static int sum_lapped(cvol_context *context, partial *total, const cvol_array *a,
                      const cvol_array *b, int apart)
{
    sums s = {.a = a, .b = b, .apart = apart};
    const cvol_share share = cvol_share_of(context, a);
    cvol_stream stream = cvol_stream_of(a, a == b ? NULL : b);
    stream.take = add_piece;
    stream.user = &s;
    stream.what = "summing";
    s.run_count = cvol_stream_pieces(&stream);
    limit_stream(&stream, &s, &share);
    s.runs = cvol_allocate_zero(s.run_count, sizeof *s.runs);
    if (!s.runs)
        return cvol_fail_memory(context, s.run_count * sizeof *s.runs, "sums");
    int code = share.layers[0] < share.layers[1] ? cvol_stream_run(context, &stream) : CVOL_OK;
    code = cvol_team_complete(context, share.team, code, s.runs, sizeof *s.runs,
                              share.layers[0] * a->blocks[1], share.layers[1] * a->blocks[1]);
    add_runs(total, s.runs, s.run_count);
    free(s.runs);
    return code;
}

/* ---- all ------------------------------------------------------------------------------------- */

static int sum_blocks(cvol_context *context, partial *total, const cvol_array *a,
                      const cvol_array *b, int apart)
{
    const size_t per_block = cvol_array_block_terms(a);
    sums s = {.a = a,
              .b = b,
              .apart = apart,
              .whole = 1,
              .root = sqrt((double)per_block),
              .run_count = (a->block_count - 1) / RUN_BLOCKS + 1};
    memset(total, 0, sizeof *total);
    if (a->lapped || b->lapped)
        return sum_lapped(context, total, a, b, apart);
    const cvol_share share = cvol_share_of(context, a);
    const size_t first = cvol_share_group(&share, 0, RUN_BLOCKS),
                 end = cvol_share_group(&share, 1, RUN_BLOCKS);
    for (int i = 0; i < a->rank; i++)
        s.whole = s.whole && a->grid.dims[i] % (size_t)a->block == 0;
    s.runs = cvol_allocate_zero(s.run_count, sizeof *s.runs);
    if (!s.runs)
        return cvol_fail_memory(context, s.run_count * sizeof *s.runs, "sums");
    int failed = 0;
#pragma omp parallel num_threads(cvol_context_threads(context))
    {
        workplace w = {.table = cvol_allocate_zero(per_block, sizeof *w.table),
                       .x = cvol_allocate(per_block, sizeof *w.x),
                       .y = cvol_allocate(per_block, sizeof *w.y)};
        const int ready = w.table && w.x && w.y;
        if (!ready) {
#pragma omp atomic write
            failed = 1;
        }
#pragma omp for schedule(dynamic)
        for (size_t r = first; r < end; r++)
            for (size_t i = r * RUN_BLOCKS; ready && i < (r + 1) * RUN_BLOCKS; i++)
                if (i < a->block_count)
                    add_block(&s.runs[r], &w, &s, i);
        free(w.table);
        free(w.x);
        free(w.y);
    }
    int code = failed ? cvol_fail_memory(context, 3 * per_block * sizeof(float), "sums") : CVOL_OK;
    code = cvol_team_complete(context, share.team, code, s.runs, sizeof *s.runs, first, end);
    add_runs(total, s.runs, s.run_count);
    free(s.runs);
    return code;
}

int cvol_blocks_sums(cvol_context *context, double *sum, double *squares, double *variation,
                     const cvol_array *a)
{
    partial total;
    int code = sum_blocks(context, &total, a, a, 0);
    const double samples = (double)cvol_grid_samples(&a->grid);
    *variation = total.product - total.a * total.a / samples; /* offsets would cancel */
    *sum = total.a + a->offset * samples;
    *squares = total.product + a->offset * (2 * total.a + a->offset * samples);
    return code;
}

int cvol_blocks_inner(cvol_context *context, double *inner, const cvol_array *a,
                      const cvol_array *b)
{
    partial total;
    int code = sum_blocks(context, &total, a, b, 0);
    const double samples = (double)cvol_grid_samples(&a->grid);
    *inner = total.product + a->offset * total.b + b->offset * total.a +
             a->offset * b->offset * samples;
    return code;
}

int cvol_blocks_distance(cvol_context *context, double *squares, const cvol_array *a,
                         const cvol_array *b)
{
    partial total;
    int code = sum_blocks(context, &total, a, b, 1);
    const double samples = (double)cvol_grid_samples(&a->grid), offset = a->offset - b->offset;
    *squares = total.product + offset * (2 * (total.a - total.b) + offset * samples);
    return code;
}
