/* Block ranges: bounds of the samples that each block evaluates to. Files and the renderer need
 * them. Operations do not compute them, since that means evaluating every block. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "array/block/lapped.h"
#include "array/core/array.h"
#include "array/core/share.h"
#include "array/core/summary.h"
#include "base/context.h"
#include "base/memory.h"
#include "transform/block.h"

/* Adjacent samples, which compilers combine into vectors. */
#define SIDE 16

static void find_bounds(float out[2], const float *samples, size_t count)
{
    float least[SIDE], most[SIDE];
    size_t i = 0;
    for (int k = 0; k < SIDE; k++)
        least[k] = most[k] = samples[0];
    for (; i + SIDE <= count; i += SIDE)
        for (int k = 0; k < SIDE; k++) {
            least[k] = samples[i + (size_t)k] < least[k] ? samples[i + (size_t)k] : least[k];
            most[k] = samples[i + (size_t)k] > most[k] ? samples[i + (size_t)k] : most[k];
        }
    for (int k = 0; i < count; i++, k++) {
        least[k] = samples[i] < least[k] ? samples[i] : least[k];
        most[k] = samples[i] > most[k] ? samples[i] : most[k];
    }
    out[0] = least[0];
    out[1] = most[0];
    for (int k = 1; k < SIDE; k++) {
        out[0] = least[k] < out[0] ? least[k] : out[0];
        out[1] = most[k] > out[1] ? most[k] : out[1];
    }
}

/* The code of the largest value not above (up = 0), or of the smallest not below, `value`. */
static uint8_t range_code(const cvol_array *array, double value, int up)
{
    double span = array->range_max - array->range_min;
    double exact = span > 0 ? 255 * (value - array->range_min) / span : up ? 255 : 0;
    int code = (int)exact;
    if (up && code < exact && code < 255)
        code++;
    /* The division may round across a step: widen until the bound holds. */
    double unit = span / 255;
    while (!up && code > 0 && array->range_min + unit * code > value)
        code--;
    while (up && code < 255 && array->range_min + unit * code < value)
        code++;
    return (uint8_t)(code < 0 ? 0 : code > 255 ? 255 : code);
}

/* ---- all blocks ------------------------------------------------------------------------------ */

typedef float bounds[2];

static int bound_blocks(cvol_context *context, bounds *out, const cvol_array *array,
                        const cvol_share *share)
{
    const size_t per_block = cvol_array_block_terms(array);
    int failed = 0;
#pragma omp parallel num_threads(cvol_context_threads(context))
    {
        float *samples = cvol_allocate(per_block, sizeof *samples);
        if (!samples) {
#pragma omp atomic write
            failed = 1;
        }
#pragma omp for schedule(dynamic, 16)
        for (size_t i = share->blocks[0]; i < share->blocks[1]; i++) {
            if (!samples)
                continue;
            cvol_block_evaluate(samples, array, i);
            find_bounds(out[i], samples, per_block);
        }
        free(samples);
    }
    return failed ? cvol_fail_memory(context, per_block * sizeof(float), "a block") : CVOL_OK;
}

/* Pieces of a lapped volume begin two lines and two slices before the blocks in which they end. So
 * up to four pieces contribute to the bounds of a block, each in a table of its own. */
typedef struct lapped_bounds {
    const cvol_array *array;
    bounds *table[4]; /* 1: of the lines, 2: of the slices before the last blocks of the piece */
} lapped_bounds;

static void widen(float out[2], const float by[2])
{
    out[0] = by[0] < out[0] ? by[0] : out[0];
    out[1] = by[1] > out[1] ? by[1] : out[1];
}

static void bound_piece(void *user, const cvol_piece *piece)
{
    const lapped_bounds *to = user;
    const size_t *blocks = to->array->blocks, B = (size_t)to->array->block;
    const size_t last_row = (piece->end[1] - 1) / B, last_layer = (piece->end[2] - 1) / B;
    for (size_t z = piece->begin[2]; z < piece->end[2]; z++)
        for (size_t y = piece->begin[1]; y < piece->end[1]; y++) {
            const float *line = piece->samples[0] + (y - piece->begin[1]) * piece->line +
                                (z - piece->begin[2]) * piece->sheet;
            bounds *row = to->table[(y / B < last_row) + 2 * (z / B < last_layer)] +
                          blocks[0] * (y / B + blocks[1] * (z / B));
            for (size_t x = 0; x < piece->end[0]; x += B) {
                const size_t left = piece->end[0] - x;
                bounds of;
                find_bounds(of, line + x, left < B ? left : B);
                widen(row[x / B], of);
            }
        }
}

/* The stream goes on for a slice behind the share, so that its last piece ends in another layer of
 * blocks than the one before, as in the stream of the whole. */
static int bound_lapped(cvol_context *context, bounds *out, const cvol_array *array,
                        const cvol_share *share)
{
    const size_t count = array->block_count;
    cvol_stream stream = cvol_stream_of(array, NULL);
    bounds *tables = cvol_allocate(count, 4 * sizeof *tables);
    if (!tables)
        return cvol_fail_memory(context, count * 4 * sizeof *tables, "block ranges");
    lapped_bounds to = {array, {tables, tables + count, tables + 2 * count, tables + 3 * count}};
    for (size_t i = 0; i < 4 * count; i++) {
        tables[i][0] = INFINITY;
        tables[i][1] = -INFINITY;
    }
    stream.begin[2] = share->slices[0];
    if (share->slices[1] < stream.end[2])
        stream.end[2] = share->slices[1] + 1;
    stream.take = bound_piece;
    stream.user = &to;
    stream.what = "finding ranges";
    int code = share->blocks[0] < share->blocks[1] ? cvol_stream_run(context, &stream) : CVOL_OK;
    for (size_t i = 0; i < count; i++) {
        for (int k = 1; k < 4; k++)
            widen(to.table[0][i], to.table[k][i]);
        memcpy(out[i], to.table[0][i], sizeof out[i]);
    }
    free(tables);
    return code;
}

/* A block with background samples includes the background value; a block of background only has
 * just that value. */
static void bound_background(bounds *of, const cvol_array *array)
{
    const float value = (float)(cvol_array_background(array) - array->offset);
    const float only[2] = {value, value};
    uint8_t which[CVOL_BLOCK_MAX * CVOL_BLOCK_MAX * CVOL_BLOCK_MAX];
    for (size_t i = 0; i < array->block_count; i++) {
        size_t begin[3], end[3], count = 1;
        cvol_block_origin(begin, array, i);
        for (int a = 0; a < 3; a++) {
            end[a] = begin[a] + (size_t)array->block;
            end[a] = end[a] < array->grid.dims[a] ? end[a] : array->grid.dims[a];
            count *= end[a] - begin[a];
        }
        const size_t masked = cvol_mask_get(which, array->mask, begin, end);
        if (masked == count)
            memcpy(of[i], only, sizeof only);
        else if (masked)
            widen(of[i], only);
    }
}

void cvol_array_set_ranges(cvol_array *array, const float (*of)[2])
{
    float lo = of[0][0], hi = of[0][1];
    for (size_t i = 1; i < array->block_count; i++) {
        lo = of[i][0] < lo ? of[i][0] : lo;
        hi = of[i][1] > hi ? of[i][1] : hi;
    }
    array->range_min = array->offset + (double)lo;
    array->range_max = array->offset + (double)hi;
    for (size_t i = 0; i < array->block_count; i++) {
        array->block_table[i].range[0] = range_code(array, array->offset + (double)of[i][0], 0);
        array->block_table[i].range[1] = range_code(array, array->offset + (double)of[i][1], 1);
    }
}

int cvol_array_find_ranges(cvol_context *context, cvol_array *array)
{
    bounds *of = cvol_allocate(array->block_count, sizeof *of);
    if (!of)
        return cvol_fail_memory(context, array->block_count * sizeof *of, "block ranges");
    const cvol_share share = cvol_share_of(context, array);
    int code = array->lapped ? bound_lapped(context, of, array, &share)
                             : bound_blocks(context, of, array, &share);
    code = cvol_team_complete(context, share.team, code, of, sizeof *of, share.blocks[0],
                              share.blocks[1]);
    if (code) {
        free(of);
        return code;
    }
    if (cvol_mask_is_background(array->mask))
        bound_background(of, array);
    cvol_array_set_ranges(array, (const float(*)[2])of);
    free(of);
    return CVOL_OK;
}

int cvol_array_ensure_ranges(cvol_context *context, cvol_array *array)
{
    int code = cvol_array_find_ranges(context, array);
    if (code)
        return code;
    const double largest = fmax(fabs(array->range_min), fabs(array->range_max));
    array->error_bound.max_abs = fmin(array->error_bound.max_abs,
                                      largest + CVOL_ROUNDING * (largest + fabs(array->offset)));
    array->has_ranges = 1;
    return CVOL_OK;
}

int cvol_array_share(cvol_context *context, cvol_array **out, const cvol_array *array)
{
    const size_t bytes = array->block_count * sizeof *array->block_table;
    *out = malloc(sizeof **out);
    cvol_block *table = cvol_allocate(array->block_count, sizeof *table);
    if (!*out || !table) {
        free(*out);
        free(table);
        *out = NULL;
        return cvol_fail_memory(context, bytes, "the block table");
    }
    **out = *array;
    memcpy(table, array->block_table, bytes);
    (*out)->block_table = table;
    (*out)->attributes = NULL;
    (*out)->summary = NULL;
    (*out)->coding = NULL;
    (*out)->mask = NULL;
    (*out)->residual = NULL;
    (*out)->pools = NULL;
    (*out)->pool_count = (*out)->pool_capacity = 0;
    int code = cvol_array_set_summary(context, *out, cvol_array_summary(array));
    if (!code)
        code = cvol_array_set_coding(context, *out, array, array);
    if (code) {
        cvol_array_free(*out);
        *out = NULL;
    }
    return code;
}
