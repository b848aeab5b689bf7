/* The warp: a forward and a backward filter convert values to spline coefficients; pixels
 * interpolate 4 x 4 of these. */
#include "image/spline_warp.h"

#include <string.h>

#include "base/context.h"
#include "base/memory.h"
#include "image/spline_row.h"

typedef float pixel __attribute__((vector_size(16)));

static pixel load(const float *from)
{
    pixel v;
    memcpy(&v, from, sizeof v);
    return v;
}

static void store(float *to, pixel v)
{
    memcpy(to, &v, sizeof v);
}

/* ---- from samples to spline coefficients: a forward and a backward filter -------------------- */

#define POLE -0.26794919f

/* One line of n places, `stride` floats apart; zeros lie around it. */
static void filter_line(float *line, size_t n, size_t stride)
{
    pixel carry = {0};
    for (size_t i = 0; i < n; i++)
        store(line + i * stride, carry = 6 * load(line + i * stride) + POLE * carry);
    /* adds the tail of the forward pass beyond the end */
    carry *= POLE * POLE / (POLE * POLE - 1);
    for (size_t i = n; i-- > 0;)
        store(line + i * stride, carry = POLE * (carry - load(line + i * stride)));
}

static void filter(float *places, const size_t dims[2], int threads)
{
#pragma omp parallel num_threads(threads)
    {
#pragma omp for schedule(static)
        for (size_t y = 0; y < dims[1]; y++)
            filter_line(places + 4 * dims[0] * y, dims[0], 4);
#pragma omp for schedule(static)
        for (size_t x = 0; x < dims[0]; x++)
            filter_line(places + 4 * x, dims[1], 4 * dims[0]);
    }
}

/* ---- occupied places ------------------------------------------------------------------------- */

/* Spline coefficients are negligible at this distance, in places, from the nearest pixel that is
 * not empty. */
#define SPREAD 8

/* For each row, spans[0] to spans[1]: places near pixels that are not empty, in all rows that such
 * a pixel needs. */
static void find_spans(int (*spans)[2], const float *places, const size_t dims[2])
{
    const ptrdiff_t width = (ptrdiff_t)dims[0], height = (ptrdiff_t)dims[1];
    const pixel zero = {0};
    for (ptrdiff_t y = 0; y < height; y++) {
        spans[y][0] = (int)width;
        spans[y][1] = 0;
    }
    for (ptrdiff_t y = 0; y < height; y++) {
        const float *row = places + 4 * width * y;
        ptrdiff_t from = 0, to = width;
        while (from < to && !memcmp(row + 4 * from, &zero, sizeof zero))
            from++;
        while (to > from && !memcmp(row + 4 * (to - 1), &zero, sizeof zero))
            to--;
        for (ptrdiff_t j = y - SPREAD - 2; j <= y + SPREAD + 1 && from < to; j++) {
            if (j < 0 || j >= height)
                continue;
            spans[j][0] = (int)(from - SPREAD < spans[j][0] ? from - SPREAD : spans[j][0]);
            spans[j][1] = (int)(to + SPREAD > spans[j][1] ? to + SPREAD : spans[j][1]);
        }
    }
}

/* ---- the picture ----------------------------------------------------------------------------- */

int cvol_spline_warp(cvol_context *context, cvol_image *image, float *places, const size_t dims[2],
                     const double to_intermediate[2][3], const double background[3])
{
    const double(*m)[3] = to_intermediate;
    const int threads = cvol_context_threads(context);
    int(*spans)[2] = cvol_allocate(dims[1], sizeof *spans);
    if (!spans)
        return cvol_fail_memory(context, dims[1] * sizeof *spans, "a picture");
    find_spans(spans, places, dims);
    filter(places, dims, threads);
#pragma omp parallel for schedule(static) num_threads(threads)
    for (int y = 0; y < image->height; y++) {
        const cvol_spline_row row = {
            .places = places,
            .spans = spans,
            .dims = {(ptrdiff_t)dims[0], (ptrdiff_t)dims[1]},
            .start = {m[0][1] * y + m[0][2], m[1][1] * y + m[1][2]},
            .step = {m[0][0], m[1][0]},
            .ground = {(float)background[0], (float)background[1], (float)background[2]},
            .out = image->values ? NULL : image->rgba + 4 * (size_t)y * (size_t)image->width,
            .values = image->values ? image->values + 4 * (size_t)y * (size_t)image->width : NULL,
            .count = image->width};
        CVOL_SIMD_CHOOSE(cvol_spline_sample)(&row);
    }
    free(spans);
    return CVOL_OK;
}
