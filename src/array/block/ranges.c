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
#include "base/vector.h"
#include "transform/block.h"

static void find_bounds(float out[2], const float *samples, size_t count)
{
    float least[CVOL_LANES], most[CVOL_LANES];
    cvol_vf low = cvol_splat(samples[0]), high = low;
    size_t i = 0;
    for (; i + CVOL_LANES <= count; i += CVOL_LANES) {
        const cvol_vf here = cvol_load(samples + i);
        low = cvol_min(here, low);
        high = cvol_max(here, high);
    }
    cvol_store(least, low);
    cvol_store(most, high);
    for (int k = 0; i < count; i++, k++) {
        least[k] = samples[i] < least[k] ? samples[i] : least[k];
        most[k] = samples[i] > most[k] ? samples[i] : most[k];
    }
    out[0] = least[0];
    out[1] = most[0];
    for (int k = 1; k < CVOL_LANES; k++) {
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

/* ---- boxes of blocks ------------------------------------------------------------------------- */

typedef float bounds[2];

/* Blocks first[a] .. first[a] + count[a] - 1 along axis a; a table of their bounds has the first
 * axis fastest. */
typedef struct block_box {
    size_t first[3], count[3];
} block_box;

static size_t blocks_of(const block_box *box)
{
    return box->count[0] * box->count[1] * box->count[2];
}

/* The index in the array of block i of a box. */
static size_t block_at(const cvol_array *array, const block_box *box, size_t i)
{
    const size_t x = i % box->count[0], y = i / box->count[0] % box->count[1],
                 z = i / box->count[0] / box->count[1];
    return box->first[0] + x +
           array->blocks[0] * (box->first[1] + y + array->blocks[1] * (box->first[2] + z));
}

static int bound_blocks(cvol_context *context, bounds *out, const cvol_array *array,
                        const block_box *box)
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
        for (size_t i = 0; i < blocks_of(box); i++) {
            if (!samples)
                continue;
            cvol_block_evaluate(samples, array, block_at(array, box, i));
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
    const block_box *box;
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
    const block_box *box = to->box;
    const size_t B = (size_t)to->array->block;
    const size_t last_row = (piece->end[1] - 1) / B, last_layer = (piece->end[2] - 1) / B;
    for (size_t z = piece->begin[2]; z < piece->end[2]; z++)
        for (size_t y = piece->begin[1]; y < piece->end[1]; y++) {
            const size_t row = y / B - box->first[1], layer = z / B - box->first[2];
            const float *line = piece->samples[0] + (y - piece->begin[1]) * piece->line +
                                (z - piece->begin[2]) * piece->sheet;
            if (row >= box->count[1] || layer >= box->count[2])
                continue; /* see bound_lapped */
            bounds *blocks = to->table[(y / B < last_row) + 2 * (z / B < last_layer)] +
                             box->count[0] * (row + box->count[1] * layer);
            const size_t width = piece->end[0] - piece->begin[0];
            for (size_t x = 0; x < width; x += B) {
                bounds of;
                find_bounds(of, line + x, width - x < B ? width - x : B);
                widen(blocks[x / B], of);
            }
        }
}

/* The stream goes on for a line and a slice behind the box, so that its last pieces end in other
 * blocks than the ones before, as in the stream of the whole. */
static int bound_lapped(cvol_context *context, bounds *out, const cvol_array *array,
                        const block_box *box)
{
    const size_t count = blocks_of(box), B = (size_t)array->block;
    cvol_stream stream = cvol_stream_of(array, NULL);
    bounds *tables = cvol_allocate(count, 4 * sizeof *tables);
    if (!tables)
        return cvol_fail_memory(context, count * 4 * sizeof *tables, "block ranges");
    lapped_bounds to = {
        array, box, {tables, tables + count, tables + 2 * count, tables + 3 * count}};
    for (size_t i = 0; i < 4 * count; i++) {
        tables[i][0] = INFINITY;
        tables[i][1] = -INFINITY;
    }
    for (int a = 0; a < 3; a++) {
        const size_t end = (box->first[a] + box->count[a]) * B + (a > 0);
        stream.begin[a] = box->first[a] * B;
        stream.end[a] = end < stream.end[a] ? end : stream.end[a];
    }
    stream.take = bound_piece;
    stream.user = &to;
    stream.what = "finding ranges";
    int code = count ? cvol_stream_run(context, &stream) : CVOL_OK;
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
static void bound_background(bounds *of, const cvol_array *array, const block_box *box)
{
    const float value = (float)(cvol_array_background(array) - array->offset);
    const float only[2] = {value, value};
    uint8_t which[CVOL_BLOCK_MAX * CVOL_BLOCK_MAX * CVOL_BLOCK_MAX];
    for (size_t i = 0; i < blocks_of(box); i++) {
        size_t begin[3], end[3], count = 1;
        cvol_block_origin(begin, array, block_at(array, box, i));
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

static int find_box_bounds(cvol_context *context, bounds *out, const cvol_array *array,
                           const block_box *box)
{
    return array->lapped ? bound_lapped(context, out, array, box)
                         : bound_blocks(context, out, array, box);
}

/* Sets the range that codes refer to. */
static void set_range(cvol_array *array, const float (*of)[2], size_t count)
{
    float lo = of[0][0], hi = of[0][1];
    for (size_t i = 1; i < count; i++) {
        lo = of[i][0] < lo ? of[i][0] : lo;
        hi = of[i][1] > hi ? of[i][1] : hi;
    }
    array->range_min = array->offset + (double)lo;
    array->range_max = array->offset + (double)hi;
}

static void set_codes(cvol_array *array, const float (*of)[2], const block_box *box)
{
    for (size_t i = 0; i < blocks_of(box); i++) {
        cvol_block *block = &array->block_table[block_at(array, box, i)];
        block->range[0] = range_code(array, array->offset + (double)of[i][0], 0);
        block->range[1] = range_code(array, array->offset + (double)of[i][1], 1);
    }
}

static block_box whole_box(const cvol_array *array)
{
    return (block_box){.count = {array->blocks[0], array->blocks[1], array->blocks[2]}};
}

void cvol_array_set_ranges(cvol_array *array, const float (*of)[2])
{
    const block_box box = whole_box(array);
    set_range(array, of, array->block_count);
    set_codes(array, of, &box);
}

void cvol_array_widen_range(cvol_array *array, double least, double most)
{
    const cvol_array before = *array;
    array->range_min = fmin(least, before.range_min);
    array->range_max = fmax(most, before.range_max);
    for (size_t i = 0; i < array->block_count; i++) {
        cvol_block *block = &array->block_table[i];
        double ends[2];
        cvol_array_range(&before, i, &ends[0], &ends[1]);
        block->range[0] = range_code(array, ends[0], 0);
        block->range[1] = range_code(array, ends[1], 1);
    }
}

int cvol_array_find_ranges(cvol_context *context, cvol_array *array)
{
    bounds *of = cvol_allocate(array->block_count, sizeof *of);
    if (!of)
        return cvol_fail_memory(context, array->block_count * sizeof *of, "block ranges");
    const cvol_share share = cvol_share_of(context, array);
    const block_box whole = whole_box(array);
    block_box box = whole;
    box.first[2] = share.layers[0];
    box.count[2] = share.layers[1] - share.layers[0];
    int code = find_box_bounds(context, of + share.blocks[0], array, &box);
    code = cvol_team_complete(context, share.team, code, of, sizeof *of, share.blocks[0],
                              share.blocks[1]);
    if (code) {
        free(of);
        return code;
    }
    if (cvol_mask_is_background(array->mask))
        bound_background(of, array, &whole);
    cvol_array_set_ranges(array, (const float(*)[2])of);
    free(of);
    return CVOL_OK;
}

int cvol_array_find_box_ranges(cvol_context *context, cvol_array *array, const size_t begin[3],
                               const size_t end[3], cvol_range_widen *widen_range, void *user)
{
    block_box box;
    for (int a = 0; a < 3; a++) {
        const size_t side = cvol_block_side(array, a);
        box.first[a] = begin[a] / side;
        box.count[a] = (end[a] + side - 1) / side - box.first[a];
    }
    const size_t count = blocks_of(&box);
    double range[2] = {0, 0};
    bounds *of = cvol_allocate(count, sizeof *of);
    int code = of ? find_box_bounds(context, of, array, &box)
                  : cvol_fail_memory(context, count * sizeof *of, "block ranges");
    if (!code && cvol_mask_is_background(array->mask))
        bound_background(of, array, &box);
    if (!code) {
        set_range(array, (const float(*)[2])of, count);
        range[0] = array->range_min;
        range[1] = array->range_max;
    }
    code = widen_range(context, user, code, range);
    if (!code) {
        array->range_min = range[0];
        array->range_max = range[1];
        set_codes(array, (const float(*)[2])of, &box);
        array->has_ranges = 1;
    }
    free(of);
    return code;
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
