/* Means over boxes, slice by slice: the sums of a level are added to those of the next. */
#include "volume/formats/zarr/pyramid.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/context.h"
#include "base/doubles.h"
#include "base/for_type.h"
#include "base/memory.h"

/* Coarser levels are made until no side is longer. */
enum { SMALL_SIDE = 64 };
/* Samples that are converted at once: an even number. */
enum { STEP = 512 };

static void store(void *out, cvol_type type, const double *values, size_t count)
{
    const int is_integer = cvol_type_is_integer(type);
#define STORE(t)                       \
    for (size_t i = 0; i < count; i++) \
    ((t *)out)[i] = (t)(is_integer ? rint(values[i]) : values[i])
    CVOL_FOR_TYPE(type, STORE);
#undef STORE
}

int cvol_zarr_pyramid_open(cvol_context *context, cvol_zarr_pyramid *p, const cvol_grid *grid,
                           int labels)
{
    *p = (cvol_zarr_pyramid){.levels = 1,
                             .labels = labels,
                             .threads = cvol_context_threads(context),
                             .type = grid->type};
    memcpy(p->dims[0], grid->dims, sizeof grid->dims);
    for (; p->levels < CVOL_ZARR_LEVELS; p->levels++) {
        const size_t *before = p->dims[p->levels - 1];
        cvol_zarr_sums *s = &p->sums[p->levels];
        if (before[0] <= SMALL_SIDE && before[1] <= SMALL_SIDE && before[2] <= SMALL_SIDE)
            break;
        for (int a = 0; a < 3; a++)
            s->dims[a] = p->dims[p->levels][a] = before[a] / 2 + before[a] % 2;
        const size_t count = s->dims[0] * s->dims[1];
        s->sum = cvol_allocate_zero(count, sizeof *s->sum);
        s->count = cvol_allocate_zero(count, sizeof *s->count);
        if (!s->sum || !s->count)
            return cvol_fail_memory(context, count * sizeof *s->sum, "levels");
    }
    return CVOL_OK;
}

void cvol_zarr_pyramid_close(cvol_zarr_pyramid *pyramid)
{
    for (int k = 0; k < CVOL_ZARR_LEVELS; k++) {
        free(pyramid->sums[k].sum);
        free(pyramid->sums[k].count);
    }
    *pyramid = (cvol_zarr_pyramid){0};
}

/* ---- missing samples --------------------------------------------------------------------- */

int cvol_zarr_has_value(const cvol_zarr_missing *missing, double sample)
{
    for (int i = 0; i < missing->count; i++)
        if (sample >= missing->values[i] && sample <= missing->values[i])
            return 0;
    return isfinite(sample) != 0;
}

int cvol_zarr_missing_add(cvol_context *context, cvol_zarr_missing *missing, double value)
{
    if (!cvol_zarr_has_value(missing, value))
        return CVOL_OK;
    if (missing->count == CVOL_ZARR_MISSING_MOST)
        return cvol_fail(context, CVOL_ERROR_LIMIT,
                         "missing samples have more than %d different values",
                         CVOL_ZARR_MISSING_MOST);
    missing->values[missing->count++] = value;
    return CVOL_OK;
}

/* ---- means ---------------------------------------------------------------------------- */

/* A row of samples; those without a value do not count. */
static void add_samples(double *sum, uint32_t *count, const cvol_zarr_pyramid *p,
                        const uint8_t *row, size_t width)
{
    double values[STEP];
    for (size_t x = 0; x < width; x += STEP) {
        const size_t n = width - x < STEP ? width - x : STEP;
        cvol_doubles_load(values, p->type, row, x, n);
        for (size_t i = 0; i < n; i++) {
            const int counts = cvol_zarr_has_value(&p->missing, values[i]);
            sum[(x + i) / 2] += counts ? values[i] : 0;
            count[(x + i) / 2] += (uint32_t)counts;
        }
    }
}

/* A row of sums of the level before. */
static void add_sums(double *sum, uint32_t *count, const double *sums, const uint32_t *counts,
                     size_t width)
{
    for (size_t x = 0; x < width; x++) {
        sum[x / 2] += sums[x];
        count[x / 2] += counts[x];
    }
}

/* Adds a slice of samples, or the sums of level - 1, to a level. */
static void add_slice(cvol_zarr_pyramid *p, int level, const uint8_t *slice)
{
    cvol_zarr_sums *s = &p->sums[level];
    const cvol_zarr_sums *from = &p->sums[level - 1];
    const size_t *before = p->dims[level - 1];
    const size_t row = before[0] * cvol_type_size(p->type);
#pragma omp parallel for schedule(static) num_threads(p->threads)
    for (size_t y = 0; y < s->dims[1]; y++)
        for (size_t i = 2 * y; i < 2 * y + 2 && i < before[1]; i++) {
            double *sum = s->sum + y * s->dims[0];
            uint32_t *count = s->count + y * s->dims[0];
            if (slice)
                add_samples(sum, count, p, slice + i * row, before[0]);
            else
                add_sums(sum, count, from->sum + i * before[0], from->count + i * before[0],
                         before[0]);
        }
    s->slices++;
}

static void store_means(const cvol_zarr_pyramid *p, int level, uint8_t *out)
{
    double values[STEP];
    const cvol_zarr_sums *s = &p->sums[level];
    const double none = p->missing.count ? p->missing.values[0] : (double)NAN;
    const size_t all = s->dims[0] * s->dims[1], sample = cvol_type_size(p->type);
    for (size_t at = 0; at < all; at += STEP) {
        const size_t n = all - at < STEP ? all - at : STEP;
        for (size_t i = 0; i < n; i++)
            values[i] = s->count[at + i] ? s->sum[at + i] / s->count[at + i] : none;
        store(out + at * sample, p->type, values, n);
    }
}

/* The levels that slice number p->slice of level 0 completes: finer ones first. */
static int add_to_means(cvol_context *context, cvol_zarr_pyramid *p, const uint8_t *slice,
                        uint8_t *mean, const cvol_zarr_level_sink *sink)
{
    const int is_last = p->slice + 1 == p->dims[0][2];
    int code = CVOL_OK;
    for (int k = 1; k < p->levels && !code; k++) {
        cvol_zarr_sums *s = &p->sums[k];
        add_slice(p, k, k == 1 ? slice : NULL);
        if (k > 1) {
            const size_t count = p->sums[k - 1].dims[0] * p->sums[k - 1].dims[1];
            memset(p->sums[k - 1].sum, 0, count * sizeof(double));
            memset(p->sums[k - 1].count, 0, count * sizeof(uint32_t));
        }
        if (s->slices < 2 && !is_last)
            break;
        store_means(p, k, mean);
        code = sink->put(context, sink->user, k, mean);
        s->slices = 0;
        if (k + 1 == p->levels) {
            memset(s->sum, 0, s->dims[0] * s->dims[1] * sizeof(double));
            memset(s->count, 0, s->dims[0] * s->dims[1] * sizeof(uint32_t));
        }
    }
    return code;
}

/* ---- labels --------------------------------------------------------------------------- */

static int add_to_labels(cvol_context *context, const cvol_zarr_pyramid *p, const uint8_t *slice,
                         uint8_t *out, const cvol_zarr_level_sink *sink)
{
    const size_t sample = cvol_type_size(p->type), row = p->dims[0][0] * sample;
    int code = CVOL_OK;
    for (int k = 1; k < p->levels && !code && p->slice % ((size_t)1 << k) == 0; k++) {
        const size_t *dims = p->dims[k];
        for (size_t y = 0; y < dims[1]; y++)
            for (size_t x = 0; x < dims[0]; x++)
                memcpy(out + (y * dims[0] + x) * sample, slice + (y << k) * row + (x << k) * sample,
                       sample);
        code = sink->put(context, sink->user, k, out);
    }
    return code;
}

int cvol_zarr_pyramid_add(cvol_context *context, cvol_zarr_pyramid *p, const void *slice,
                          const cvol_zarr_level_sink *sink)
{
    int code = CVOL_OK;
    if (p->levels > 1) {
        const size_t bytes = p->dims[1][0] * p->dims[1][1] * cvol_type_size(p->type);
        uint8_t *out = cvol_allocate(bytes, 1);
        if (!out)
            return cvol_fail_memory(context, bytes, "levels");
        code = p->labels ? add_to_labels(context, p, slice, out, sink)
                         : add_to_means(context, p, slice, out, sink);
        free(out);
    }
    p->slice = p->slice + 1 == p->dims[0][2] ? 0 : p->slice + 1;
    return code;
}
