/* Compressed arrays: making, owning and describing them. */
#include "array/core/array.h"

#include <float.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "array/core/summary.h"
#include "base/context.h"
#include "base/elementary.h"
#include "base/memory.h"
#include "transform/lap.h"

static int block_log2_of(int block)
{
    return block == 8 ? 3 : block == 16 ? 4 : block == 32 ? 5 : 0;
}

const char *cvol_transform_name(cvol_transform transform)
{
    switch (transform) {
    case CVOL_DCT:
        return "dct";
    case CVOL_DHT:
        return "dht";
    case CVOL_DFT:
        return "dft";
    }
    return NULL;
}

cvol_transform cvol_transform_from_name(const char *name)
{
    for (int t = CVOL_DCT; t <= CVOL_DFT; t++)
        if (!strcmp(name, cvol_transform_name((cvol_transform)t)))
            return (cvol_transform)t;
    return (cvol_transform)0;
}

/* ---- making ----------------------------------------------------------------------------- */

static int check_shape(cvol_context *context, const cvol_grid *grid, int rank,
                       cvol_transform transform, int block)
{
    if (block != 0 && !block_log2_of(block))
        return cvol_fail(context, CVOL_ERROR_ARGUMENT, "block is %d, must be 0, 8, 16 or 32",
                         block);
    if (!cvol_transform_name(transform))
        return cvol_fail(context, CVOL_ERROR_ARGUMENT,
                         "transform is %d, must be 1 (dct), 2 (dht) or 3 (dft)", (int)transform);
    if (rank < 1 || rank > 3)
        return cvol_fail(context, CVOL_ERROR_ARGUMENT, "rank is %d, must be 1, 2 or 3", rank);
    int code = cvol_grid_check(context, grid, "array");
    for (int a = rank; a < 3 && !code; a++)
        if (grid->dims[a] != 1)
            code = cvol_fail(context, CVOL_ERROR_ARGUMENT,
                             "dims[%d] is %zu in an array of rank %d, must be 1", a, grid->dims[a],
                             rank);
    if (!code && block == 0 && cvol_grid_samples(grid) > UINT32_MAX)
        code = cvol_fail(context, CVOL_ERROR_LIMIT,
                         "a whole array (block 0) of %zu samples; it may have %u at most: use "
                         "blocks",
                         cvol_grid_samples(grid), UINT32_MAX);
    return code;
}

int cvol_array_create_as(cvol_context *context, cvol_array **out, const cvol_grid *grid, int rank,
                         cvol_transform transform, int block)
{
    *out = NULL;
    int code = check_shape(context, grid, rank, transform, block);
    if (code)
        return code;
    cvol_array *array = calloc(1, sizeof *array);
    if (!array)
        return cvol_fail_memory(context, sizeof *array, "an array");
    array->grid = *grid;
    array->rank = rank;
    array->transform = transform;
    array->block = block;
    array->block_log2 = block_log2_of(block);
    array->step = block ? 1 : 0;
    array->psnr_db = (double)INFINITY;
    array->block_count = 1;
    for (int a = 0; a < 3; a++) {
        array->blocks[a] = block ? (grid->dims[a] - 1) / (size_t)block + 1 : 1;
        array->block_count *= array->blocks[a];
    }
    if (block) {
        /* calloc: if only part of a huge volume is read, most pages are never touched. */
        array->block_table = calloc(array->block_count, sizeof *array->block_table);
        if (!array->block_table) {
            code = cvol_fail_memory(context, array->block_count * sizeof *array->block_table,
                                    "the block table");
            cvol_array_free(array);
            return code;
        }
    }
    *out = array;
    return CVOL_OK;
}

int cvol_array_create(cvol_context *context, cvol_array **out, const cvol_grid *grid, int block)
{
    if (!block_log2_of(block)) {
        *out = NULL;
        return cvol_fail(context, CVOL_ERROR_ARGUMENT, "block is %d, must be 8, 16 or 32", block);
    }
    return cvol_array_create_as(context, out, grid, 3, CVOL_DCT, block);
}

int cvol_array_create_like(cvol_context *context, cvol_array **out, const cvol_array *like)
{
    cvol_grid grid = like->grid;
    grid.type = CVOL_FLOAT32;
    grid.value_scale = 1;
    grid.value_offset = 0;
    const int made = cvol_array_create_as(context, out, &grid, like->rank, like->transform,
                                          like->block);
    if (made)
        return made;
    const int copied = cvol_array_set_coding(context, *out, like, NULL);
    if (copied) {
        cvol_array_free(*out);
        *out = NULL;
    }
    return copied;
}

int cvol_array_set_coding(cvol_context *context, cvol_array *array, const cvol_array *bricks,
                          const cvol_array *terms)
{
    const cvol_coding *shape = bricks ? bricks->coding : NULL, *as = terms ? terms->coding : NULL;
    const cvol_coding *any = shape ? shape : as;
    cvol_coding *coding = any ? any->ops->make(shape, as) : NULL;
    if (any && !coding)
        return cvol_fail_memory(context, sizeof *coding, "an array's coding");
    if (array->coding)
        array->coding->ops->destroy(array->coding);
    array->coding = coding;
    return CVOL_OK;
}

double cvol_array_quantised_step(const cvol_array *array)
{
    const cvol_coding *coding = array->coding;
    return coding ? ldexp(array->step, coding->ops->finer_bits(coding)) : array->step;
}

/* Frees the terms; they only borrow the array's mask. */
static void drop_decoded(cvol_residual *residual)
{
    if (residual->decoded)
        residual->decoded->mask = NULL;
    cvol_array_free(residual->decoded);
    residual->decoded = NULL;
}

void cvol_array_drop_residual(cvol_array *array)
{
    if (array->residual) {
        drop_decoded(array->residual);
        array->residual->free(array->residual);
    }
    cvol_mask_free(array->mask);
    array->mask = NULL;
    array->residual = NULL;
}

void cvol_array_free(cvol_array *array)
{
    if (!array)
        return;
    for (size_t i = 0; i < array->pool_count; i++)
        free(array->pools[i]);
    free(array->pools);
    free(array->block_table);
    cvol_spectrum_free(&array->whole);
    free(array->attributes);
    free(array->summary);
    if (array->coding)
        array->coding->ops->destroy(array->coding);
    cvol_array_drop_residual(array);
    free(array);
}

int cvol_array_adopt_pool(cvol_context *context, cvol_array *array, uint32_t *terms, size_t words)
{
    if (array->pool_count == array->pool_capacity) {
        size_t capacity = 2 * array->pool_capacity + 16;
        uint32_t **pools = realloc(array->pools, capacity * sizeof *pools);
        if (!pools)
            return cvol_fail_memory(context, capacity * sizeof *pools, "the coefficients");
        array->pools = pools;
        array->pool_capacity = capacity;
    }
    array->pools[array->pool_count++] = terms;
    array->pool_words += words;
    return CVOL_OK;
}

const cvol_grid *cvol_array_grid(const cvol_array *array)
{
    return &array->grid;
}

size_t cvol_array_block_terms(const cvol_array *array)
{
    return (size_t)1 << array->rank * array->block_log2;
}

static uint64_t resident_bytes(const cvol_array *array)
{
    const cvol_spectrum *whole = &array->whole;
    uint64_t bytes = CVOL_ARRAY_BYTES + array->pool_capacity * sizeof *array->pools +
                     array->pool_words * sizeof(uint32_t);
    if (array->block)
        bytes += array->block_count * sizeof *array->block_table;
    if (array->summary)
        bytes += sizeof *array->summary;
    if (array->mask)
        bytes += cvol_mask_bytes(array->mask);
    if (array->residual)
        bytes += array->residual->bytes(array->residual) +
                 (array->residual->decoded ? resident_bytes(array->residual->decoded) : 0);
    return bytes + whole->low_count * sizeof *whole->low_values +
           whole->sparse_capacity * (sizeof *whole->places + sizeof *whole->values);
}

void cvol_array_get_info(cvol_array_info *out, const cvol_array *array)
{
    const double samples = (double)cvol_grid_samples(&array->grid);
    memset(out, 0, sizeof *out);
    out->rank = array->rank;
    out->transform = array->transform;
    out->block = array->block;
    memcpy(out->blocks, array->blocks, sizeof out->blocks);
    memcpy(out->low, array->whole.low, sizeof out->low);
    out->step = cvol_array_quantised_step(array);
    out->coefficients = array->coefficients;
    out->rho = (double)array->coefficients / samples;
    if (!array->block) {
        out->coefficients = array->whole.low_count + array->whole.sparse_count;
        out->rho = ((double)array->whole.low_count + 2 * (double)array->whole.sparse_count) /
                   samples;
    }
    out->resident_bytes = resident_bytes(array);
    out->value_min = array->error_bound.value_min;
    out->value_max = array->error_bound.value_max;
    out->l2_error = array->error_bound.l2_error;
    out->point_error = cvol_error_bound_point(&array->error_bound);
    out->max_abs = array->error_bound.max_abs;
    if (array->residual) /* residual samples are within the range */
        out->max_abs = fmax(out->max_abs,
                            cvol_error_bound_largest(&array->error_bound) * (1 + CVOL_ROUNDING));
    out->measured = array->measured;
    out->psnr_db = array->psnr_db;
    out->max_error = array->max_error;
    for (int a = 0; a < 3 && cvol_array_is_volume(array); a++)
        out->brick[a] = CVOL_BRICK_SIDE;
    if (cvol_array_is_volume(array) && array->coding)
        array->coding->ops->brick_sides(out->brick, array->coding);
    if (cvol_mask_is_background(array->mask)) {
        out->background_samples = cvol_mask_samples(array->mask);
        out->background = cvol_array_background(array);
    }
    out->missing_samples = cvol_grid_samples(&array->grid) - cvol_array_valued_samples(array);
}

size_t cvol_array_valued_samples(const cvol_array *array)
{
    const uint64_t missing = cvol_mask_is_void(array->mask) ? cvol_mask_samples(array->mask) : 0;
    return cvol_grid_samples(&array->grid) - (size_t)missing;
}

void cvol_array_derive_figures(cvol_array *array)
{
    const cvol_error_bound *error_bound = &array->error_bound;
    const double samples = (double)cvol_array_valued_samples(array);
    /* Rounding to integers adds up to a half to every sample. */
    const double half = cvol_type_is_integer(array->grid.type) ? 0.5 : 0;
    const double l2_error = error_bound->l2_error + half * sqrt(samples);
    array->measured = 0;
    array->max_error = cvol_error_bound_point(error_bound) + half;
    array->psnr_db = (double)INFINITY;
    if (l2_error > 0 && samples > 0)
        array->psnr_db = 20 * cvol_log10((error_bound->value_max - error_bound->value_min) *
                                         sqrt(samples) / l2_error);
}

double cvol_array_rms_error(const cvol_array *array)
{
    const cvol_error_bound *bound = &array->error_bound;
    const double all = bound->l2_error / sqrt((double)cvol_grid_samples(&array->grid));
    const double error = fmax(0, all - CVOL_ROUNDING * fabs(array->offset));
    /* Measured figures of integers are those of rounded samples. */
    if (!array->measured || !isfinite(array->psnr_db) || cvol_type_is_integer(array->grid.type))
        return error;
    return fmin(error, (bound->value_max - bound->value_min) * cvol_pow(10, -array->psnr_db / 20));
}

/* Lapped volumes: |pre-filtered block| <= CVOL_LAP_PRE_NORM_3 |block and two samples around it|,
 * sqrt(20^3) max_abs, which is less than 4 sqrt(16^3) max_abs. */
double cvol_array_coefficient_bound(const cvol_array *array)
{
    return (array->lapped ? 4 : 1) * sqrt((double)cvol_array_block_terms(array)) *
           (array->error_bound.max_abs + fabs(array->offset));
}

/* ---- requirements of operations on their operands ------------------------------------------ */

double cvol_array_background(const cvol_array *array)
{
    return cvol_mask_is_background(array->mask)
               ? cvol_fills_value(cvol_mask_fills(array->mask), 0, array->grid.type)
               : 0;
}

int cvol_array_compatible(cvol_context *context, const cvol_array *a, const cvol_array *b)
{
    const size_t *m = a->grid.dims, *n = b->grid.dims;
    if (a->rank != b->rank)
        return cvol_fail(context, CVOL_ERROR_ARGUMENT,
                         "rank is %d in one array and %d in the other", a->rank, b->rank);
    if (m[0] != n[0] || m[1] != n[1] || m[2] != n[2])
        return cvol_fail(context, CVOL_ERROR_ARGUMENT,
                         "dims are %zux%zux%zu in one array and %zux%zux%zu in the other; resample "
                         "or crop one before compressing",
                         m[0], m[1], m[2], n[0], n[1], n[2]);
    if (a->transform != b->transform)
        return cvol_fail(context, CVOL_ERROR_ARGUMENT,
                         "transform is %s in one array and %s in the other; compress both with the "
                         "same",
                         cvol_transform_name(a->transform), cvol_transform_name(b->transform));
    if (a->block != b->block)
        return cvol_fail(
            context, CVOL_ERROR_ARGUMENT,
            "block is %d in one array and %d in the other; compress both with the same", a->block,
            b->block);
    for (int i = 0; i < a->rank; i++)
        if (!(fabs(a->grid.spacing[i] - b->grid.spacing[i]) <=
              1e-5 * fabs(a->grid.spacing[i]) + 1e-12))
            return cvol_fail(context, CVOL_ERROR_ARGUMENT,
                             "spacing along %c is %g in one array and %g in the other", "xyz"[i],
                             a -> grid.spacing[i], b->grid.spacing[i]);
    return CVOL_OK;
}

int cvol_array_has_splits(const cvol_array *array)
{
    for (size_t i = 0; array->block_table && i < array->block_count; i++)
        if (array->block_table[i].split)
            return 1;
    return 0;
}

int cvol_array_is_volume(const cvol_array *array)
{
    return array->rank == 3 && array->transform == CVOL_DCT && array->block;
}

int cvol_array_need_volume(cvol_context *context, const cvol_array *array, const char *what)
{
    if (cvol_array_is_volume(array))
        return CVOL_OK;
    return cvol_fail(context, CVOL_ERROR_UNSUPPORTED,
                     "%s needs a volume in DCT blocks; this is rank %d, %s, block %d: compress it "
                     "with transform dct and block 16",
                     what, array->rank, cvol_transform_name(array->transform), array->block);
}

/* ---- terms ------------------------------------------------------------------------------- */

void cvol_block_find_low(cvol_block *block, int block_log2)
{
    const uint32_t mask = (UINT32_C(1) << block_log2) - 1;
    memset(block->low, 0, sizeof block->low);
    const uint32_t *words = block->terms, *end = cvol_block_end(block);
    while (words < end) {
        uint32_t place;
        (void)cvol_term_unpack(&words, &place, cvol_place_bits(block_log2));
        for (int a = 0; a < 3; a++) {
            uint32_t frequency = place >> a * block_log2 & mask;
            if (block->low[a] <= frequency)
                block->low[a] = (uint8_t)(frequency + 1);
        }
    }
}
