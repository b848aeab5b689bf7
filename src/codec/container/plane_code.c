/* Converts planes between arrays and numbers. */
#include "codec/container/plane_code.h"

#include <float.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/context.h"
#include "base/memory.h"

/* Coefficients below this fraction of a step are dropped: their bits cost more than they gain. */
#define DEAD_ZONE 0.6

static void tile_counts(size_t out[2], const cvol_plane_shape *shape)
{
    for (int a = 0; a < 2; a++)
        out[a] = shape->block ? (shape->dims[a] - 1) / (size_t)shape->block + 1 : 1;
}

uint64_t cvol_plane_tiles(const cvol_plane_shape *shape)
{
    size_t tiles[2];
    tile_counts(tiles, shape);
    return (uint64_t)tiles[0] * tiles[1];
}

uint64_t cvol_plane_places(const cvol_plane_shape *shape)
{
    if (!shape->block)
        return (uint64_t)shape->dims[0] * shape->dims[1];
    return cvol_plane_tiles(shape) * (uint64_t)(shape->block * shape->block);
}

/* ---- coding --------------------------------------------------------------------------------- */

int cvol_plane_code(const cvol_tile_coder *coder, int32_t *values, const int32_t *before,
                    const cvol_plane_shape *shape)
{
    size_t tiles[2];
    tile_counts(tiles, shape);
    cvol_tile tile = {.transform = shape->transform, .is_whole = !shape->block};
    for (int a = 0; a < 2; a++)
        tile.size[a] = shape->block ? (size_t)shape->block : shape->dims[a];
    const size_t per_tile = tile.size[0] * tile.size[1];
    for (size_t j = 0; j < tiles[1]; j++)
        for (size_t i = 0; i < tiles[0]; i++) {
            int32_t *at = values + per_tile * (i + tiles[0] * j);
            tile.left = i ? at - per_tile : NULL;
            tile.above = j ? at - per_tile * tiles[0] : NULL;
            tile.before = before ? before + (at - values) : NULL;
            if (!cvol_tile_code(coder, at, &tile))
                return 0;
        }
    return 1;
}

/* ---- arrays to numbers ---------------------------------------------------------------------- */

static int fail_size(cvol_context *context)
{
    return cvol_fail(context, CVOL_ERROR_DATA,
                     "a plane's coefficients are too large for its step: scale it down, or keep it "
                     "with a larger step");
}

static int whole_values(cvol_context *context, int32_t *out, const cvol_array *array, double step)
{
    const cvol_spectrum *whole = &array->whole;
    const size_t count = cvol_grid_samples(&array->grid);
    float *slots = cvol_allocate(count, sizeof *slots);
    int fits = 1;
    if (!slots)
        return cvol_fail_memory(context, count * sizeof *slots, "a plane");
    cvol_spectrum_scatter(slots, whole, array->grid.dims);
    for (size_t i = 0; i < count && fits; i++) {
        const double value = (double)slots[i] / step;
        fits = fabs(value) <= (double)CVOL_TILE_LIMIT;
        out[i] = fits ? (int32_t)lrint(value) : 0;
    }
    free(slots);
    return fits ? CVOL_OK : fail_size(context);
}

static int block_values(cvol_context *context, int32_t *out, const cvol_array *array)
{
    const size_t per_block = cvol_array_block_terms(array);
    memset(out, 0, array->block_count * per_block * sizeof *out);
    for (size_t b = 0; b < array->block_count; b++) {
        const uint32_t *words = array->block_table[b].terms;
        const uint32_t *end = cvol_block_end(&array->block_table[b]);
        while (words < end) {
            uint32_t place;
            const int32_t value = cvol_term_unpack(&words, &place,
                                                   cvol_place_bits(array->block_log2));
            if (value > CVOL_TILE_LIMIT || value < -CVOL_TILE_LIMIT)
                return fail_size(context);
            out[b * per_block + place] = value;
        }
    }
    return CVOL_OK;
}

int cvol_plane_values(cvol_context *context, int32_t **out, const cvol_array *array, double step)
{
    const size_t count = array->block ? array->block_count * cvol_array_block_terms(array)
                                      : cvol_grid_samples(&array->grid);
    *out = cvol_allocate(count, sizeof **out);
    if (!*out)
        return cvol_fail_memory(context, count * sizeof **out, "a plane");
    const int code = array->block ? block_values(context, *out, array)
                                  : whole_values(context, *out, array, step);
    if (code) {
        free(*out);
        *out = NULL;
    }
    return code;
}

/* ---- numbers to arrays ---------------------------------------------------------------------- */

/* No sample, and no intermediate value, may exceed float32. */
static int are_small(const int32_t *values, size_t count, double step)
{
    uint64_t sum = 0; /* magnitudes are at most 2^29, the number of places is below 2^33 */
    for (size_t i = 0; i < count; i++)
        sum += (uint32_t)abs(values[i]);
    return (double)sum * step < (double)FLT_MAX / 16;
}

static int fill_whole(cvol_context *context, cvol_array *array, const int32_t *values, double step)
{
    const size_t count = cvol_grid_samples(&array->grid), none[3] = {0, 0, 0};
    size_t terms = 0;
    for (size_t i = 0; i < count; i++)
        terms += values[i] != 0;
    cvol_spectrum *whole = &array->whole;
    int code = cvol_spectrum_start(context, whole, array->transform, array->grid.dims, none);
    if (!code)
        code = cvol_spectrum_reserve(context, whole, terms);
    for (size_t i = 0; i < count && !code; i++)
        if (values[i]) {
            whole->places[whole->sparse_count] = (uint32_t)i;
            whole->values[whole->sparse_count++] = (float)(values[i] * step);
        }
    return code;
}

/* True if 8 values are zero, which is the common case. */
static int are_zero(const int32_t *values)
{
    int32_t any = 0;
    for (int i = 0; i < 8; i++)
        any |= values[i];
    return !any;
}

static int fill_blocks(cvol_context *context, cvol_array *array, const int32_t *values)
{
    const size_t per_block = cvol_array_block_terms(array), count = array->block_count * per_block;
    const int place_bits = cvol_place_bits(array->block_log2);
    size_t words = 0;
    for (size_t i = 0; i < count; i++)
        words += values[i] ? 2 : 0;
    uint32_t *pool = malloc(words ? words * sizeof *pool : 1), *to = pool;
    if (!pool)
        return cvol_fail_memory(context, words * sizeof *pool, "a plane");
    for (size_t b = 0; b < array->block_count; b++) {
        cvol_block *block = &array->block_table[b];
        block->terms = to;
        for (size_t i = 0; i < per_block; i++) {
            if (i % 8 == 0 && are_zero(values + b * per_block + i)) {
                i += 7;
                continue;
            }
            if (values[b * per_block + i]) {
                to += cvol_term_pack(to, (uint32_t)i, values[b * per_block + i], place_bits);
                array->coefficients++;
            }
        }
        block->words = (uint32_t)(to - block->terms);
        cvol_block_find_low(block, array->block_log2);
    }
    const int code = cvol_array_adopt_pool(context, array, pool, words);
    if (code)
        free(pool);
    return code;
}

int cvol_plane_array(cvol_context *context, cvol_array **out, const int32_t *values,
                     const cvol_plane_shape *shape, double step, const char *name)
{
    const cvol_grid grid = cvol_grid_make(shape->dims[0], shape->dims[1], 1, CVOL_FLOAT32);
    *out = NULL;
    if (!are_small(values, (size_t)cvol_plane_places(shape), step))
        return cvol_fail(context, CVOL_ERROR_CORRUPT, "%s: terms are too large for float32", name);
    cvol_array *array;
    int code = cvol_array_create_as(context, &array, &grid, 2, shape->transform, shape->block);
    if (code)
        return code;
    if (shape->block)
        array->step = step;
    code = shape->block ? fill_blocks(context, array, values)
                        : fill_whole(context, array, values, step);
    if (code)
        cvol_array_free(array);
    else
        *out = array;
    return code;
}

/* ---- rounding ------------------------------------------------------------------------------- */

/* Writes all coefficients, in the order of cvol_plane_values. */
static void scatter(float *out, const cvol_array *array)
{
    const size_t per_block = cvol_array_block_terms(array);
    if (!array->block) {
        cvol_spectrum_scatter(out, &array->whole, array->grid.dims);
        return;
    }
    memset(out, 0, array->block_count * per_block * sizeof *out);
    for (size_t b = 0; b < array->block_count; b++) {
        const uint32_t *words = array->block_table[b].terms;
        const uint32_t *end = cvol_block_end(&array->block_table[b]);
        while (words < end) {
            uint32_t place;
            const int32_t value = cvol_term_unpack(&words, &place,
                                                   cvol_place_bits(array->block_log2));
            out[b * per_block + place] = (float)(value * array->step);
        }
    }
}

/* Rounds values; *lost and *norm are L2 norms. Returns 0 if a value is beyond the coder's range. */
static int round_values(int32_t *out, double *lost, double *norm, const float *in, size_t count,
                        double step)
{
    double squares[2] = {0, 0};
    for (size_t i = 0; i < count; i++) {
        const double exact = (double)in[i], units = fabs(exact) / step;
        if (units > (double)CVOL_TILE_LIMIT)
            return 0;
        const int32_t size = units < DEAD_ZONE ? 0 : (int32_t)(units + 0.5);
        out[i] = exact < 0 ? -size : size;
        const double off = exact - out[i] * step;
        squares[0] += off * off;
        squares[1] += exact * exact;
    }
    *lost = sqrt(squares[0]);
    *norm = sqrt(squares[1]);
    return 1;
}

int cvol_plane_quantise(cvol_context *context, cvol_array **out, const cvol_array *array,
                        double step)
{
    const size_t *dims = array->grid.dims;
    const cvol_plane_shape shape = {{dims[0], dims[1]}, array->transform, array->block};
    const size_t count = (size_t)cvol_plane_places(&shape);
    float *exact = cvol_allocate(count, sizeof *exact);
    int32_t *values = cvol_allocate(count, sizeof *values);
    double lost = 0, norm = 0;
    int code = exact && values ? CVOL_OK
                               : cvol_fail_memory(context, 2 * count * sizeof *exact, "a plane");
    *out = NULL;
    if (!code)
        scatter(exact, array);
    if (!code && !round_values(values, &lost, &norm, exact, count, step))
        code = fail_size(context);
    if (!code)
        code = cvol_plane_array(context, out, values, &shape, step, "a plane");
    if (!code) {
        (*out)->error_bound = array->error_bound;
        cvol_error_bound_drop(&(*out)->error_bound, lost, norm, (double)INFINITY);
        cvol_array_derive_figures(*out);
    }
    free(exact);
    free(values);
    return code;
}
