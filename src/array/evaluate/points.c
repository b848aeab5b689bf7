/* Arrays at scattered points: the interpolant (array/evaluate/interpolant.h), summed term by term
 * in double precision. The low box is summed row by row over tables of one dimension; sparse terms
 * one by one. Split blocks and blocks of lapped volumes use the DCT of their samples as
 * interpolant. The mask of the samples divides space as their nearest neighbours do. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "array/block/block_transform.h"
#include "array/block/halo.h"
#include "array/core/array.h"
#include "array/evaluate/decoded_terms.h"
#include "array/evaluate/interpolant.h"
#include "base/context.h"
#include "base/memory.h"
#include "base/thread.h"

/* Points between two calls of the progress callback. */
#define CHUNK 4096

typedef struct point_sum {
    const cvol_array *array;
    float *box;    /* a whole array's low box times g, as pairs */
    float *sparse; /* the sparse terms times g, as pairs */
    /* Tables of phi, pairs, one for each axis: of the box's indices or (tabled) of all places. */
    size_t table_first[3], table_floats;
    int tabled;
} point_sum;

/* ---- whole arrays --------------------------------------------------------------------------- */

static int prepare_whole(cvol_context *context, point_sum *sum)
{
    const cvol_spectrum *whole = &sum->array->whole;
    const size_t *dims = sum->array->grid.dims, *low = whole->low, *box = whole->box;
    const cvol_transform transform = sum->array->transform;
    sum->box = cvol_allocate(whole->low_count, 2 * sizeof *sum->box);
    sum->sparse = cvol_allocate(whole->sparse_count, 2 * sizeof *sum->sparse);
    if (!sum->box || !sum->sparse)
        return cvol_fail_memory(
            context, (whole->low_count + whole->sparse_count) * 2 * sizeof(float), "the terms");
    size_t i = 0;
    double g[2];
    for (size_t w = 0; w < box[2]; w++)
        for (size_t v = 0; v < box[1]; v++)
            for (size_t u = 0; u < box[0]; u++, i++) {
                const size_t place[3] = {cvol_box_place(u, low[0], box[0], dims[0]),
                                         cvol_box_place(v, low[1], box[1], dims[1]),
                                         cvol_box_place(w, low[2], box[2], dims[2])};
                cvol_slot_factor(g, transform, place, dims);
                sum->box[2 * i] = (float)(g[0] * (double)whole->low_values[i]);
                sum->box[2 * i + 1] = (float)(g[1] * (double)whole->low_values[i]);
            }
    for (i = 0; i < whole->sparse_count; i++) {
        size_t place[3];
        cvol_place_split(place, whole->places[i], dims);
        cvol_slot_factor(g, transform, place, dims);
        sum->sparse[2 * i] = (float)(g[0] * (double)whole->values[i]);
        sum->sparse[2 * i + 1] = (float)(g[1] * (double)whole->values[i]);
    }
    /* Tables of all places pay if there are more sparse terms than places along the axes. */
    sum->tabled = dims[0] + dims[1] + dims[2] <= 2 * whole->sparse_count;
    for (int a = 0; a < 3; a++) {
        sum->table_first[a] = sum->table_floats;
        sum->table_floats += 2 * (sum->tabled ? dims[a] : box[a]);
    }
    return CVOL_OK;
}

static void fill_tables(double *table, const point_sum *sum, const double x[3])
{
    const cvol_spectrum *whole = &sum->array->whole;
    for (int a = 0; a < 3; a++) {
        const size_t n = sum->array->grid.dims[a];
        const size_t entries = sum->tabled ? n : whole->box[a];
        double *phi = table + sum->table_first[a];
        for (size_t i = 0; i < entries; i++)
            cvol_axis_value(phi + 2 * i, sum->array->transform,
                            sum->tabled ? i : cvol_box_place(i, whole->low[a], whole->box[a], n),
                            x[a], n);
    }
}

static void multiply(double out[2], const double a[2], const double b[2])
{
    const double re = a[0] * b[0] - a[1] * b[1];
    out[1] = a[0] * b[1] + a[1] * b[0];
    out[0] = re;
}

/* Adds box indices [begin, end) of a row; they are contiguous in the table from phi on. */
static void add_row(double out[2], const float *terms, const double *phi, size_t count)
{
    double re = 0, im = 0;
    for (size_t i = 0; i < count; i++) {
        const double a = (double)terms[2 * i], b = (double)terms[2 * i + 1];
        re += a * phi[2 * i] - b * phi[2 * i + 1];
        im += a * phi[2 * i + 1] + b * phi[2 * i];
    }
    out[0] += re;
    out[1] += im;
}

/* The position of box index i in the axis's table. */
static const double *box_phi(const double *table, const point_sum *sum, int axis, size_t i)
{
    const cvol_spectrum *whole = &sum->array->whole;
    const size_t at = sum->tabled ? cvol_box_place(i, whole->low[axis], whole->box[axis],
                                                   sum->array->grid.dims[axis])
                                  : i;
    return table + sum->table_first[axis] + 2 * at;
}

static double sum_box(const double *table, const point_sum *sum)
{
    const cvol_spectrum *whole = &sum->array->whole;
    const size_t *low = whole->low, *box = whole->box;
    const float *terms = sum->box;
    double result = 0;
    for (size_t w = 0; w < box[2]; w++)
        for (size_t v = 0; v < box[1]; v++, terms += 2 * box[0]) {
            double row[2] = {0}, rest[2];
            add_row(row, terms, box_phi(table, sum, 0, 0), low[0]);
            if (box[0] > low[0])
                add_row(row, terms + 2 * low[0], box_phi(table, sum, 0, low[0]), box[0] - low[0]);
            multiply(rest, box_phi(table, sum, 1, v), box_phi(table, sum, 2, w));
            result += row[0] * rest[0] - row[1] * rest[1];
        }
    return result;
}

static double sum_sparse(const double *table, const point_sum *sum, const double x[3])
{
    const cvol_spectrum *whole = &sum->array->whole;
    const size_t *dims = sum->array->grid.dims;
    double result = 0;
    for (size_t i = 0; i < whole->sparse_count; i++) {
        size_t place[3];
        cvol_place_split(place, whole->places[i], dims);
        double product[2] = {(double)sum->sparse[2 * i], (double)sum->sparse[2 * i + 1]};
        for (int a = 0; a < sum->array->rank; a++) {
            double phi[2];
            if (sum->tabled)
                memcpy(phi, table + sum->table_first[a] + 2 * place[a], sizeof phi);
            else
                cvol_axis_value(phi, sum->array->transform, place[a], x[a], dims[a]);
            multiply(product, product, phi);
        }
        result += product[0];
    }
    return result;
}

/* ---- blocks ------------------------------------------------------------------------------- */

/* A thread's cache of the block that it last read. */
typedef struct cell_work {
    size_t index; /* 1 + the block's; 0: none */
    float *samples, *slots;
    void *halo;
} cell_work;

static void free_cells(cell_work *work, int threads)
{
    for (int t = 0; work && t < threads; t++) {
        free(work[t].samples);
        free(work[t].slots);
        free(work[t].halo);
    }
    free(work);
}

static int make_cells(cvol_context *context, cell_work **out, const cvol_array *array, int threads)
{
    const size_t floats = cvol_array_block_terms(array), bytes = cvol_halo_bytes(array);
    cell_work *work = *out = cvol_allocate_zero((size_t)threads, sizeof *work);
    for (int t = 0; work && t < threads; t++) {
        work[t].samples = cvol_allocate(floats, sizeof(float));
        work[t].slots = cvol_allocate(floats, sizeof(float));
        work[t].halo = cvol_allocate_zero(bytes, 1);
        if (!work[t].samples || !work[t].slots || !work[t].halo) {
            free_cells(work, threads);
            work = *out = NULL;
        }
    }
    return work ? CVOL_OK
                : cvol_fail_memory(context, (size_t)threads * (2 * floats * sizeof(float) + bytes),
                                   "cells of points");
}

static size_t nearest_sample(const cvol_array *array, int axis, double x)
{
    return (size_t)fmin(fmax(rint(x), 0), (double)(array->grid.dims[axis] - 1));
}

/* Finds the block with the nearest sample, and x relative to its first sample. */
static const cvol_block *find_block(double local[3], const cvol_array *array, const double x[3])
{
    size_t index = 0, stride = 1;
    for (int a = 0; a < 3; a++) {
        const size_t block = a < array->rank ? nearest_sample(array, a, x[a]) / (size_t)array->block
                                             : 0;
        local[a] = x[a] - (double)(block * (size_t)array->block);
        index += stride * block;
        stride *= array->blocks[a];
    }
    return &array->block_table[index];
}

/* Evaluates the DCT of the block's samples at x, relative to the first of them; under DCT phi is
 * real. */
static double sum_cell(double *table, cell_work *work, const cvol_array *array, size_t index,
                       const double local[3])
{
    const size_t B = (size_t)array->block;
    if (work->index != index + 1) {
        cvol_halo_evaluate(work->samples, work->halo, array, index);
        (void)cvol_halo_finish(work->slots, work->samples, array, index);
        work->index = index + 1;
    }
    for (size_t a = 0; a < 3; a++)
        for (size_t u = 0; u < B; u++) {
            double phi[2];
            cvol_axis_value(phi, CVOL_DCT, u, local[a], B);
            table[B * a + u] = phi[0] * sqrt((u ? 2.0 : 1.0) / (double)B);
        }
    double result = 0;
    for (size_t w = 0; w < B; w++)
        for (size_t v = 0; v < B; v++) {
            const float *row = work->slots + B * (v + B * w);
            double sum = 0;
            for (size_t u = 0; u < B; u++)
                sum += (double)row[u] * table[u];
            result += sum * table[B + v] * table[2 * B + w];
        }
    return result + array->offset;
}

static double sum_block(double *table, cell_work *cell, const cvol_array *array, const double x[3])
{
    const size_t B = (size_t)array->block, log2 = (size_t)array->block_log2;
    size_t dims[3];
    double local[3];
    const cvol_block *block = find_block(local, array, x);
    if (array->lapped || block->split)
        return sum_cell(table, cell, array, (size_t)(block - array->block_table), local);
    for (int a = 0; a < 3; a++) {
        dims[a] = a < array->rank ? B : 1;
        for (size_t u = 0; u < dims[a]; u++)
            cvol_axis_value(table + 2 * (B * (size_t)a + u), array->transform, u, local[a],
                            dims[a]);
    }
    double result = 0;
    const uint32_t *words = block->terms, *end = cvol_block_end(block);
    while (words < end) {
        uint32_t at;
        const int32_t value = cvol_term_unpack(&words, &at, cvol_place_bits(array->block_log2));
        const size_t place[3] = {at & (B - 1), at >> log2 & (B - 1), at >> 2 * log2};
        double product[2];
        cvol_slot_factor(product, array->transform, place, dims);
        for (size_t a = 0; a < 3; a++)
            multiply(product, product, table + 2 * (B * a + place[a]));
        result += (double)value * product[0];
    }
    return array->step * result + array->offset;
}

/* ---- points ---------------------------------------------------------------------------------- */

/* 1 if the nearest sample is masked; *value: its fill. */
static int is_masked(double *value, const cvol_array *array, const double x[3])
{
    size_t begin[3], end[3];
    uint8_t which;
    if (!array->mask)
        return 0;
    for (int a = 0; a < 3; a++) {
        begin[a] = nearest_sample(array, a, x[a]);
        end[a] = begin[a] + 1;
    }
    if (!cvol_mask_get(&which, array->mask, begin, end))
        return 0;
    *value = cvol_fills_value(cvol_mask_fills(array->mask), which - 1, array->grid.type);
    return 1;
}

static double evaluate_point(double *table, cell_work *cell, const point_sum *sum,
                             const double x[3])
{
    const cvol_array *array = sum->array;
    double fill;
    if (is_masked(&fill, array, x))
        return fill;
    if (array->block)
        return sum_block(table, cell, array, x);
    fill_tables(table, sum, x);
    return sum_box(table, sum) + sum_sparse(table, sum, x) + array->offset;
}

static int check_points(cvol_context *context, const double *points, size_t count, int rank)
{
    for (size_t i = 0; i < count * (size_t)rank; i++)
        if (!isfinite(points[i]))
            return cvol_fail(context, CVOL_ERROR_ARGUMENT, "coordinate %zu of point %zu is %g",
                             i % (size_t)rank, i / (size_t)rank, points[i]);
    return CVOL_OK;
}

int cvol_array_evaluate_points(cvol_context *context, float *out, const cvol_array *array,
                               const double *points, size_t count)
{
    int code = cvol_array_decoded_terms(context, &array, array);
    if (code)
        return code;
    const size_t rank = (size_t)array->rank;
    const int threads = cvol_context_threads(context);
    point_sum sum = {.array = array};
    double *tables = NULL;
    cell_work *cells = NULL;
    const int sampled = array->lapped || cvol_array_has_splits(array);
    code = check_points(context, points, count, array->rank);
    if (!code && !array->block)
        code = prepare_whole(context, &sum);
    if (array->block)
        sum.table_floats = 2 * 3 * (size_t)array->block;
    if (!code && sampled)
        code = make_cells(context, &cells, array, threads);
    if (code)
        goto done;
    tables = cvol_allocate(sum.table_floats, (size_t)threads * sizeof *tables);
    if (!tables) {
        code = cvol_fail_memory(context, sum.table_floats * (size_t)threads * sizeof *tables,
                                "tables of points");
        goto done;
    }
    for (size_t begin = 0; begin < count && !code; begin += CHUNK) {
        const size_t end = count - begin < CHUNK ? count : begin + CHUNK;
#pragma omp parallel for num_threads(threads) schedule(static)
        for (size_t i = begin; i < end; i++) {
            double x[3] = {0};
            memcpy(x, points + rank * i, rank * sizeof *x);
            const size_t thread = (size_t)cvol_thread_index();
            out[i] = (float)evaluate_point(tables + sum.table_floats * thread,
                                           sampled ? &cells[thread] : NULL, &sum, x);
        }
        code = cvol_report_progress(context, "evaluating", (double)end / (double)count);
    }
done:
    free_cells(cells, threads);
    free(tables);
    free(sum.box);
    free(sum.sparse);
    return code;
}
