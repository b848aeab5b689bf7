/* Measures the distance of samples from an array. */
#include "codec/rate/measure.h"

#include <float.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "array/block/lapped.h"
#include "array/evaluate/box.h"
#include "array/truncate/account.h"
#include "base/context.h"
#include "base/cpu.h"
#include "base/elementary.h"
#include "base/memory.h"
#include "codec/rate/compare_rows.h"
#include "cvol/codec.h"

/* Covers the rounding of differences and sums in double precision. */
#define SUMMING 1e-9

enum { ROW_MAX = 512, CELL = CVOL_MASK_CELL };

CVOL_SIMD_DECLARE(void, cvol_compare_samples,
                  (cvol_row_distance *, const void *, size_t, const void *, cvol_type, size_t));
CVOL_SIMD_DECLARE(void, cvol_compare_reals,
                  (cvol_row_distance *, const void *, size_t, const float *, double, cvol_type,
                   size_t));
CVOL_SIMD_DECLARE(void, cvol_compare_stored,
                  (cvol_row_distance *, const void *, size_t, const float *, size_t,
                   const cvol_sample_format *));

/* Adds a row to a block's distance; L2 norms are squares. */
static void add_row(cvol_distance *out, const cvol_row_distance *row)
{
    out->max_error = fmax(out->max_error, row->most);
    out->l2_error += row->squares;
    out->real_max_abs = fmax(out->real_max_abs, row->real_most);
    out->real_max_error = fmax(out->real_max_error, row->real_error);
    out->real_l2_error += row->real_squares;
    out->real_norm += row->real_norms;
}

/* Compares `count` samples from number `first` with decoded values, which lack the offset. */
static void compare_row(cvol_distance *out, const void *samples, size_t first, const float *real,
                        size_t count, const cvol_sample_format *as)
{
    cvol_row_distance row;
    CVOL_SIMD_CHOOSE(cvol_compare_stored)(&row, samples, first, real, count, as);
    add_row(out, &row);
}

/* Returns the decoded row that begins at sample `at` with the background filled in; uses the buffer
 * `row`. */
static const float *with_background(float *row, const float *real, const cvol_array *array,
                                    const size_t at[3], size_t count)
{
    if (!cvol_mask_is_background(array->mask))
        return real;
    const float value = (float)(cvol_array_background(array) - array->offset);
    const size_t line = at[1] % CELL + CELL * (at[2] % CELL);
    int is_copied = 0;
    for (size_t x = 0, width; x < count; x += width) {
        const size_t cell[3] = {(at[0] + x) / CELL, at[1] / CELL, at[2] / CELL},
                     first = (at[0] + x) % CELL;
        const cvol_mask_rows *rows;
        const uint8_t state = cvol_mask_cell_get(array->mask, cell, &rows);
        width = count - x < CELL - first ? count - x : CELL - first;
        uint32_t bits = state == CVOL_MASK_MIXED ? (uint32_t)rows->of[line] >> first
                        : state                  ? UINT16_MAX
                                                 : 0;
        bits &= (UINT32_C(1) << width) - 1;
        if (bits && !is_copied)
            memcpy(row, real, count * sizeof *row);
        is_copied |= bits != 0;
        while (bits) {
            const int begin = __builtin_ctz(bits), end = begin + __builtin_ctz(~(bits >> begin));
            for (int i = begin; i < end; i++)
                row[x + (size_t)i] = value;
            bits &= UINT32_MAX << end;
        }
    }
    return is_copied ? row : real;
}

void cvol_distances_add(cvol_distance *out, const cvol_distance *distances, size_t count)
{
    for (size_t i = 0; i < count; i++) {
        out->max_error = fmax(out->max_error, distances[i].max_error);
        out->real_max_abs = fmax(out->real_max_abs, distances[i].real_max_abs);
        out->real_max_error = fmax(out->real_max_error, distances[i].real_max_error);
        out->l2_error += distances[i].l2_error;
        out->real_l2_error += distances[i].real_l2_error;
        out->real_norm += distances[i].real_norm;
    }
}

double cvol_distance_rounding(const cvol_array *array, const cvol_distance *distance)
{
    const double samples = (double)cvol_grid_samples(&array->grid), offset = fabs(array->offset);
    const double underflow = fmin(offset, FLT_TRUE_MIN); /* of the offset as a float */
    return fmax(CVOL_ROUNDING * distance->real_norm, 0x1p-22 * offset * sqrt(samples)) +
           underflow * sqrt(samples);
}

void cvol_array_set_bounds(cvol_array *array, const cvol_distance *distance)
{
    cvol_error_bound *error_bound = &array->error_bound;
    const double rounding = cvol_distance_rounding(array, distance);
    error_bound->l2_error = distance->real_l2_error * (1 + SUMMING) + rounding;
    error_bound->max_abs = distance->real_max_abs + rounding;
    const double of_sample = array->block ? cvol_array_sample_rounding(array) : rounding;
    error_bound->point_error = distance->real_max_error * (1 + SUMMING) + of_sample;
}

void cvol_distance_finish(cvol_distance *sum, size_t samples)
{
    const double count = (double)samples;
    sum->l2_error = cvol_norm_of_squares(sum->l2_error, sum->max_error, count);
    sum->real_l2_error = cvol_norm_of_squares(sum->real_l2_error, sum->real_max_error, count);
    sum->real_norm = cvol_norm_of_squares(sum->real_norm, sum->real_max_abs, count);
}

/* Compares evaluated samples, as floats and in the stored type: `real` and `stored`, x fastest.
 * Without `stored` (whole arrays: they have no offset) it converts rows itself. */
static void compare_slice(cvol_distance *out, const cvol_array *array, const void *samples,
                          const float *real, const uint8_t *stored, size_t z)
{
    const cvol_grid *grid = &array->grid;
    const size_t size = cvol_type_size(grid->type), nx = grid->dims[0];
    double row[ROW_MAX];
    for (size_t y = 0; y < grid->dims[1]; y++)
        for (size_t x = 0; x < nx; x += ROW_MAX) {
            const size_t first = x + nx * (y + grid->dims[1] * z);
            const size_t count = nx - x < ROW_MAX ? nx - x : ROW_MAX;
            if (!stored)
                cvol_samples_store(row, real + first, count, array);
            cvol_row_distance distance = {0};
            CVOL_SIMD_CHOOSE(cvol_compare_samples)
            (&distance, samples, first, stored ? stored + first * size : (void *)row, grid->type,
             count);
            CVOL_SIMD_CHOOSE(cvol_compare_reals)
            (&distance, samples, first, real + first, 0, grid->type, count);
            add_row(out, &distance);
        }
}

/* The smaller ones of the array's bounds and the measured ones. */
static void lower_bounds(cvol_array *array, const cvol_distance *distance)
{
    const cvol_error_bound before = array->error_bound;
    cvol_error_bound *bound = &array->error_bound;
    cvol_array_set_bounds(array, distance);
    bound->point_error = fmin(cvol_error_bound_point(&before), cvol_error_bound_point(bound));
    bound->l2_error = fmin(before.l2_error, bound->l2_error);
    bound->max_abs = fmin(before.max_abs, bound->max_abs);
}

int cvol_array_measure(cvol_context *context, cvol_array *array, const void *samples)
{
    const size_t begin[3] = {0, 0, 0}, *dims = array->grid.dims, slices = dims[2];
    const size_t count = cvol_grid_samples(&array->grid), bytes = cvol_grid_bytes(&array->grid);
    cvol_distance *distances = cvol_allocate_zero(slices, sizeof *distances), sum = {0};
    float *real = cvol_allocate(count, sizeof *real);
    uint8_t *stored = array->block ? cvol_allocate(bytes, 1) : NULL;
    int code = CVOL_OK;
    if (!distances || !real || (array->block && !stored))
        code = cvol_fail_memory(context, count * sizeof *real + bytes, "the decoded samples");
    if (!code)
        code = cvol_array_evaluate_unmasked(context, real, array, begin, dims);
    if (!code && stored)
        code = cvol_array_evaluate_box(context, stored, array, begin, dims);
    if (!code) {
#pragma omp parallel for schedule(static) num_threads(cvol_context_threads(context))
        for (size_t z = 0; z < slices; z++)
            compare_slice(&distances[z], array, samples, real, stored, z);
        cvol_distances_add(&sum, distances, slices);
        cvol_distance_finish(&sum, count);
        cvol_array_set_measured(array, &sum);
        lower_bounds(array, &sum);
    }
    free(distances);
    free(real);
    free(stored);
    return code;
}

static cvol_distance compare_block(const cvol_array *array, const void *samples, size_t index,
                                   float *evaluated)
{
    const cvol_sample_format as = cvol_sample_format_of(array);
    const size_t B = (size_t)array->block, *dims = array->grid.dims;
    const size_t begin[3] = {index % array->blocks[0] * B,
                             index / array->blocks[0] % array->blocks[1] * B,
                             index / array->blocks[0] / array->blocks[1] * B};
    size_t inside[3];
    for (int a = 0; a < 3; a++)
        inside[a] = dims[a] - begin[a] < B ? dims[a] - begin[a] : B;
    cvol_distance distance = {0};
    float row[ROW_MAX];
    cvol_block_evaluate(evaluated, array, index);
    for (size_t z = 0; z < inside[2]; z++)
        for (size_t y = 0; y < inside[1]; y++) {
            size_t first = begin[0] + dims[0] * (begin[1] + y + dims[1] * (begin[2] + z));
            const size_t at[3] = {begin[0], begin[1] + y, begin[2] + z};
            compare_row(&distance, samples, first,
                        with_background(row, evaluated + B * (y + B * z), array, at, inside[0]),
                        inside[0], &as);
        }
    return distance;
}

static int measure_blocks(cvol_context *context, cvol_distance *out, const cvol_array *array,
                          const void *samples)
{
    const size_t B = (size_t)array->block, per_block = B * B * B;
    int failed = 0;
#pragma omp parallel num_threads(cvol_context_threads(context))
    {
        float *evaluated = cvol_allocate(per_block, sizeof *evaluated);
        if (!evaluated) {
#pragma omp atomic write
            failed = 1;
        }
#pragma omp for schedule(dynamic, 16)
        for (size_t i = 0; i < array->block_count; i++)
            if (evaluated)
                out[i] = compare_block(array, samples, i, evaluated);
        free(evaluated);
    }
    return failed ? cvol_fail_memory(context, per_block * sizeof(float), "a block") : CVOL_OK;
}

/* The distance of each part of a stream. */
typedef struct stream_distance {
    const cvol_array *array;
    const cvol_slab *slab;
    cvol_distance *pieces;
} stream_distance;

static void compare_piece(void *user, const cvol_piece *piece)
{
    const stream_distance *to = user;
    const cvol_grid *grid = &to->array->grid;
    const size_t nx = grid->dims[0];
    const cvol_sample_format as = cvol_sample_format_of(to->array);
    cvol_distance distance = {0};
    float row[ROW_MAX];
    for (size_t z = piece->begin[2]; z < piece->end[2]; z++)
        for (size_t y = piece->begin[1]; y < piece->end[1]; y++)
            for (size_t x = 0; x < nx; x += ROW_MAX) {
                const size_t first = x + cvol_slab_row(to->slab, nx, y, z);
                const size_t count = nx - x < ROW_MAX ? nx - x : ROW_MAX;
                const float *line = piece->samples[0] + x + (y - piece->begin[1]) * piece->line +
                                    (z - piece->begin[2]) * piece->sheet;
                const size_t at[3] = {x, y, z};
                compare_row(&distance, to->slab->samples, first,
                            with_background(row, line, to->array, at, count), count, &as);
            }
    to->pieces[piece->index] = distance;
}

int cvol_measure_pieces(cvol_context *context, cvol_piece_distances *out, const cvol_array *array,
                        const cvol_slab *slab, const cvol_box *box, const char *what)
{
    cvol_stream stream = cvol_stream_of(array, NULL);
    memcpy(stream.begin, box->begin, sizeof stream.begin);
    memcpy(stream.end, box->end, sizeof stream.end);
    out->count = cvol_stream_pieces(&stream);
    out->of = cvol_allocate_zero(out->count, sizeof *out->of);
    stream_distance to = {array, slab, out->of};
    if (!out->of)
        return cvol_fail_memory(context, out->count * sizeof *out->of, "distances of blocks");
    stream.take = compare_piece;
    stream.user = &to;
    stream.what = what;
    return cvol_stream_run(context, &stream);
}

int cvol_measure_box(cvol_context *context, cvol_distance *sum, const cvol_array *array,
                     const cvol_slab *slab, const cvol_box *box, const char *what)
{
    cvol_piece_distances pieces;
    const int code = cvol_measure_pieces(context, &pieces, array, slab, box, what);
    if (!code)
        cvol_distances_add(sum, pieces.of, pieces.count);
    free(pieces.of);
    return code;
}

int cvol_measure_distance(cvol_context *context, cvol_distance *out, const cvol_array *array,
                          const void *samples)
{
    *out = (cvol_distance){0};
    if (array->block == 16) {
        const cvol_slab all = cvol_slab_of(samples, &array->grid);
        const size_t *dims = array->grid.dims;
        const cvol_box whole = {.end = {dims[0], dims[1], dims[2]}};
        const int code = cvol_measure_box(context, out, array, &all, &whole, "measuring");
        cvol_distance_finish(out, cvol_grid_samples(&array->grid));
        return code;
    }
    cvol_distance *distances = cvol_allocate_zero(array->block_count, sizeof *distances);
    if (!distances)
        return cvol_fail_memory(context, array->block_count * sizeof *distances,
                                "distances of blocks");
    const int code = measure_blocks(context, distances, array, samples);
    if (!code)
        cvol_distances_add(out, distances, array->block_count);
    cvol_distance_finish(out, cvol_grid_samples(&array->grid));
    free(distances);
    return code;
}

void cvol_array_set_measured(cvol_array *array, const cvol_distance *distance)
{
    const double span = array->error_bound.value_max - array->error_bound.value_min;
    const double samples = (double)cvol_grid_samples(&array->grid);
    array->measured = 1;
    array->max_error = distance->max_error;
    array->psnr_db = (double)INFINITY;
    if (distance->l2_error > 0)
        array->psnr_db = 20 * cvol_log10(span * sqrt(samples) / distance->l2_error);
}
