/* Tiles: the choice of their terms, and arrays of these.
 *
 * A term's weight is its effect on the picture. The footprint h turns the DCT's function of
 * frequency u of a tile into h * D_u. A term A[u, v] is measured by
 *
 *     |A[u, v]| |h * D_u| |h * D_v|,
 *
 * and the terms of all tiles, slices and planes compete with each other. */
#include <math.h>
#include <string.h>

#include "array/block/block_transform.h"
#include "array/truncate/account.h"
#include "array/truncate/build.h"
#include "array/truncate/producer.h"
#include "base/context.h"
#include "base/memory.h"
#include "render/spectral/frame.h"
#include "transform/block.h"

/* The number of steps of values in the threshold, and at least that fine. */
#define FINE 16.0
/* The precision of single precision for terms up to 38; slices of one value have only rounding as
 * further terms. */
#define STEP_MIN 0x1p-24
#define STEP_MAX (1.0 / 256)
/* If all terms are kept, those from rounding are dropped. */
#define LEAST 1e-7
/* Slices hide the part behind them: an error of opacity is an error of all of that. */
#define OPACITY_WEIGHT 1.5f

void cvol_tile_weights_make(cvol_tile_weights *out, const cvol_footprint_shape *shape, int tile)
{
    const cvol_intermediate_grid on = {.step = 1};
    const cvol_intermediate_line line = cvol_intermediate_line_make(&on, shape, 0, 0);
    const float *basis = cvol_block_basis(tile);
    for (int u = 0; u < tile; u++) {
        double energy = 0;
        for (int x = line.low; x < tile + line.high; x++) {
            double sum = 0;
            for (int q = line.low; q <= line.high; q++)
                if (x - q >= 0 && x - q < tile)
                    sum += line.weights[q - line.low] * (double)basis[u * tile + x - q];
            energy += sum * sum;
        }
        for (int c = 0; c < CVOL_PLANES; c++)
            out->of[c][u] = (float)sqrt(energy) * (c == CVOL_PLANE_OPACITY ? OPACITY_WEIGHT : 1);
    }
    /* a term's weight is the product of two */
    for (int u = 0; u < tile; u++)
        out->of[CVOL_PLANE_OPACITY][u] /= sqrtf(OPACITY_WEIGHT);
}

float cvol_tile_threshold(const uint64_t *bins, uint64_t count)
{
    uint32_t bin = CVOL_TILE_BINS;
    uint64_t taken = 0;
    while (bin > 0 && taken + bins[bin - 1] <= count)
        taken += bins[--bin];
    const uint32_t bits = bin << 16;
    float least;
    memcpy(&least, &bits, sizeof least);
    return least;
}

/* ---- one tile -------------------------------------------------------------------------------- */

/* Samples of tile `index`; returns 1 if one of them is not 0. */
static int gather(float *out, const float *samples, const cvol_array *shape, size_t index)
{
    const size_t *dims = shape->grid.dims, B = (size_t)shape->block;
    const size_t left = index % shape->blocks[0] * B, top = index / shape->blocks[0] * B;
    const size_t width = dims[0] - left < B ? dims[0] - left : B;
    const size_t height = dims[1] - top < B ? dims[1] - top : B;
    const float *row = samples + dims[0] * top + left;
    uint32_t any = 0;
    for (size_t y = 0; y < B; y++, out += B) {
        memcpy(out, row, width * sizeof *out);
        for (size_t x = 0; x < width; x++)
            any |= row[x] != 0;
        for (size_t x = width; x < B; x++)
            out[x] = row[width - 1];
        row += y + 1 < height ? dims[0] : 0;
    }
    return any != 0;
}

void cvol_tiles_count(uint64_t *bins, const float *samples, const cvol_array *like,
                      const float *weights, float *scratch)
{
    const int B = like->block;
    float *slots = scratch + B * B;
    for (size_t index = 0; index < like->block_count; index++) {
        if (!gather(scratch, samples, like, index))
            continue;
        cvol_block_to_slots(slots, scratch, like);
        for (int v = 0; v < B; v++)
            for (int u = 0; u < B; u++)
                bins[cvol_tile_bin(fabsf(slots[v * B + u]) * weights[u] * weights[v])]++;
    }
}

typedef struct dense_plane {
    const float *samples, *weights;
    const cvol_array *shape;
    float least;
} dense_plane;

static int produce_empty(cvol_dense_block *block)
{
    memset(block->box, 0, sizeof block->box);
    block->count = 0;
    block->energy = 0;
    block->max_abs = 0;
    return CVOL_OK;
}

static int produce(const void *user, cvol_dense_block *block, size_t index, void *scratch)
{
    const dense_plane *plane = user;
    const int B = plane->shape->block;
    float *samples = scratch, *slots = samples + B * B;
    if (!gather(samples, plane->samples, plane->shape, index))
        return produce_empty(block);
    cvol_block_to_slots(slots, samples, plane->shape);
    double energy = 0;
    block->count = 0;
    for (int v = 0; v < B; v++)
        for (int u = 0; u < B; u++) {
            const float value = slots[v * B + u];
            energy += (double)value * (double)value;
            if (value == 0 || fabsf(value) * plane->weights[u] * plane->weights[v] < plane->least)
                continue;
            block->places[block->count] = (uint32_t)(v * B + u);
            block->values[block->count++] = value;
        }
    block->energy = energy;
    block->max_abs = 1;
    return CVOL_OK;
}

/* An array in tiles for slices of this size, without terms. */
static int create(cvol_context *context, cvol_array **out, const size_t dims[2], int tile)
{
    const cvol_grid grid = cvol_grid_make(dims[0], dims[1], 1, CVOL_FLOAT32);
    const int code = cvol_array_create_as(context, out, &grid, 2, CVOL_DCT, tile);
    if (!code)
        (*out)->error_bound = (cvol_error_bound){.max_abs = 1, .value_max = 1};
    return code;
}

static int build(cvol_context *context, cvol_array *array, const cvol_producer *producer,
                 double least, double error)
{
    cvol_build_result result;
    const double step = fmax(fmin(least / FINE, STEP_MAX), STEP_MIN);
    const cvol_keep keep = least > 0 ? cvol_keep_step(exp2(floor(log2(step))))
                                     : cvol_keep_threshold(LEAST);
    const int code = cvol_build_blocks(context, array, &result, producer, &keep);
    if (code)
        return code;
    const double dropped = sqrt(result.dropped * result.dropped + error * error);
    array->error_bound = (cvol_error_bound){.value_max = 1, .max_abs = 1};
    cvol_error_bound_drop(&array->error_bound, dropped, result.norm, result.sample + error);
    array->error_bound.point_error = 0; /* the sample's share lacks its rounding */
    return CVOL_OK;
}

int cvol_tiles_compress(cvol_context *context, cvol_array **out, const float *samples,
                        const size_t dims[2], int tile, const float *weights, float least)
{
    int code = create(context, out, dims, tile);
    if (code)
        return code;
    const dense_plane plane = {samples, weights, *out, least};
    const cvol_producer producer = {.produce = produce,
                                    .user = &plane,
                                    .scratch_bytes = 2 * sizeof(float) * (size_t)(tile * tile),
                                    .what = "transforming slices"};
    code = build(context, *out, &producer, (double)least, 0);
    if (code) {
        cvol_array_free(*out);
        *out = NULL;
    }
    return code;
}

/* ---- truncation of stored planes ------------------------------------------------------------- */

typedef struct sparse_plane {
    const cvol_array *array;
    const float *weights;
    float least;
} sparse_plane;

static float key_of(const sparse_plane *plane, uint32_t place, int32_t value)
{
    const uint32_t log2 = (uint32_t)plane->array->block_log2;
    const uint32_t u = place & ((UINT32_C(1) << log2) - 1), v = place >> log2;
    return fabsf((float)(value * plane->array->step)) * plane->weights[u] * plane->weights[v];
}

static void count_terms(uint64_t *bins, const sparse_plane *plane)
{
    const int bits = cvol_place_bits(plane->array->block_log2);
    for (size_t b = 0; b < plane->array->block_count; b++) {
        const cvol_block *block = &plane->array->block_table[b];
        const uint32_t *at = block->terms, *end = cvol_block_end(block);
        while (at < end) {
            uint32_t place;
            const int32_t value = cvol_term_unpack(&at, &place, bits);
            bins[cvol_tile_bin(key_of(plane, place, value))]++;
        }
    }
}

static int produce_fewer(const void *user, cvol_dense_block *out, size_t index, void *scratch)
{
    const sparse_plane *plane = user;
    const cvol_block *block = &plane->array->block_table[index];
    const int bits = cvol_place_bits(plane->array->block_log2);
    const uint32_t *at = block->terms, *end = cvol_block_end(block);
    (void)scratch;
    produce_empty(out);
    while (at < end) {
        uint32_t place;
        const int32_t value = cvol_term_unpack(&at, &place, bits);
        const float real = (float)(value * plane->array->step);
        out->energy += (double)real * (double)real;
        if (key_of(plane, place, value) < plane->least)
            continue;
        out->places[out->count] = place;
        out->values[out->count++] = real;
    }
    out->max_abs = 1;
    return CVOL_OK;
}

static int reduce_plane(cvol_context *context, cvol_array **out, const sparse_plane *plane)
{
    int code = create(context, out, plane->array->grid.dims, plane->array->block);
    if (code)
        return code;
    const cvol_producer producer = {
        .produce = produce_fewer, .user = plane, .what = "leaving out terms"};
    code = build(context, *out, &producer, (double)plane->least,
                 plane->array->error_bound.l2_error);
    if (code) {
        cvol_array_free(*out);
        *out = NULL;
    }
    return code;
}

static int reduce_tiles(cvol_context *context, cvol_baked *out, const cvol_baked *baked,
                        const cvol_footprint_shape *shape, uint64_t most)
{
    cvol_tile_weights weights;
    cvol_tile_weights_make(&weights, shape, baked->tile);
    uint64_t *bins = cvol_allocate_zero(CVOL_TILE_BINS, sizeof *bins);
    if (!bins)
        return cvol_fail_memory(context, CVOL_TILE_BINS * sizeof *bins, "counts of terms");
    for (size_t k = 0; k < baked->slices; k++)
        for (int c = 0; c < CVOL_PLANES; c++)
            if (baked->planes[k][c])
                count_terms(bins, &(sparse_plane){baked->planes[k][c], weights.of[c], 0});
    const float least = cvol_tile_threshold(bins, most);
    int code = CVOL_OK;
    for (size_t k = 0; k < baked->slices && !code; k++)
        for (int c = 0; c < CVOL_PLANES && !code; c++)
            if (baked->planes[k][c])
                code = reduce_plane(context, &out->planes[k][c],
                                    &(sparse_plane){baked->planes[k][c], weights.of[c], least});
    free(bins);
    return code;
}

static int reduce_whole(cvol_context *context, cvol_baked *out, const cvol_baked *baked,
                        double places)
{
    int code = CVOL_OK;
    for (size_t k = 0; k < baked->slices && !code; k++)
        for (int c = 0; c < CVOL_PLANES && !code; c++)
            if (baked->planes[k][c]) {
                const size_t *dims = baked->planes[k][c]->grid.dims;
                const cvol_keep keep = cvol_keep_rho(places / (double)(dims[0] * dims[1]));
                code = cvol_array_truncate(context, &out->planes[k][c], baked->planes[k][c], &keep);
            }
    return code;
}

int cvol_baked_reduce(cvol_context *context, cvol_baked *out, const cvol_baked *baked,
                      const cvol_footprint_shape *shape, double rho)
{
    const double places = rho * (double)baked->samples[0] * (double)baked->samples[1];
    *out = *baked;
    out->filled = NULL;
    out->planes = cvol_allocate_zero(baked->slices, sizeof *out->planes);
    if (!out->planes)
        return cvol_fail_memory(context, baked->slices * sizeof *out->planes, "slices");
    int code = baked->tile ? reduce_tiles(context, out, baked, shape,
                                          (uint64_t)(places * (double)cvol_baked_planes(baked)))
                           : reduce_whole(context, out, baked, places);
    if (!code)
        code = cvol_baked_count(context, out);
    if (code)
        cvol_baked_free(out);
    return code;
}
