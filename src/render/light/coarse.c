/* Low-resolution volumes (coarse.h). */
#include "render/light/coarse.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/context.h"
#include "base/for_type.h"
#include "base/memory.h"

#define CELLS 48 /* the longest axis has more cells than this */
/* Cells longer than this only if the longest axis would have more than CELLS_MAX. */
#define LEVEL_MAX 3
#define CELLS_MAX 255
/* Samples of this magnitude and more have no value. */
#define NO_VALUE 1e30

int cvol_coarse_level(const cvol_grid *grid)
{
    size_t longest = grid->dims[0];
    for (int a = 1; a < 3; a++)
        longest = grid->dims[a] > longest ? grid->dims[a] : longest;
    int level = 1;
    while (level < LEVEL_MAX && longest >> (level + 1) > CELLS)
        level++;
    while (longest >> level > CELLS_MAX)
        level++;
    return level;
}

int cvol_coarse_allocate(cvol_context *context, cvol_coarse *out, const cvol_grid *grid, int level,
                         int has_cover)
{
    const double mean = (grid->spacing[0] + grid->spacing[1] + grid->spacing[2]) / 3;
    *out = (cvol_coarse){.cover = NULL};
    for (int a = 0; a < 3; a++) {
        const size_t pitch = grid->dims[a] > 1 ? (size_t)1 << level : 1;
        out->dims[a] = (grid->dims[a] + pitch - 1) / pitch;
        out->pitch[a] = (double)pitch;
        out->first[a] = ((double)pitch - 1) / 2;
        out->length[a] = (double)pitch * grid->spacing[a] / mean;
    }
    const size_t count = cvol_coarse_count(out);
    out->values = cvol_allocate(count, sizeof *out->values);
    out->cover = has_cover ? cvol_allocate(count, sizeof *out->cover) : NULL;
    if (out->values && (out->cover || !has_cover))
        return CVOL_OK;
    cvol_coarse_free(out);
    return cvol_fail_memory(context, count * sizeof *out->values, "a volume of low resolution");
}

void cvol_coarse_free(cvol_coarse *coarse)
{
    free(coarse->values);
    free(coarse->cover);
    *coarse = (cvol_coarse){.values = NULL};
}

int cvol_coarse_surround(cvol_context *context, cvol_coarse *coarse)
{
    cvol_coarse out = *coarse;
    size_t n[3];
    for (int a = 0; a < 3; a++) {
        out.dims[a] = coarse->dims[a] + 2;
        out.first[a] -= out.pitch[a];
        n[a] = coarse->dims[a];
    }
    const size_t count = cvol_coarse_count(&out);
    out.values = cvol_allocate(count, sizeof *out.values);
    out.cover = cvol_allocate_zero(count, sizeof *out.cover);
    if (!out.values || !out.cover) {
        cvol_coarse_free(&out);
        cvol_coarse_free(coarse);
        return cvol_fail_memory(context, 2 * count * sizeof *out.values,
                                "a volume of low resolution");
    }
    for (size_t i = 0; i < count; i++) {
        const size_t at[3] = {i % out.dims[0], i / out.dims[0] % out.dims[1],
                              i / out.dims[0] / out.dims[1]};
        size_t from[3];
        int is_inside = 1;
        for (int a = 0; a < 3; a++) {
            is_inside &= at[a] > 0 && at[a] <= n[a];
            from[a] = at[a] == 0 ? 0 : at[a] > n[a] ? n[a] - 1 : at[a] - 1;
        }
        const size_t source = from[0] + n[0] * (from[1] + n[1] * from[2]);
        out.values[i] = coarse->values[source];
        if (is_inside)
            out.cover[i] = coarse->cover ? coarse->cover[source] : 1;
    }
    cvol_coarse_free(coarse);
    *coarse = out;
    return CVOL_OK;
}

/* A value near those of the samples: the first one that counts; 0 if none does. */
static double find_offset(const cvol_volume *volume, const uint8_t *mask)
{
    const size_t count = cvol_grid_samples(&volume->grid);
#define FIND(t)                                                \
    for (size_t i = 0; i < count; i++) {                       \
        const double v = (double)((const t *)volume->data)[i]; \
        if (!(mask && mask[i]) && fabs(v) < NO_VALUE)          \
            return v;                                          \
    }
    CVOL_FOR_TYPE(volume->grid.type, FIND)
#undef FIND
    return 0;
}

/* The cells of one row along x. */
typedef struct row_job {
    const cvol_volume *volume;
    const uint8_t *mask;
    const cvol_coarse *out;
    size_t y, z;
} row_job;

/* Adds a row of samples to the cells that it crosses. */
static void add_row(double *sums, double *counts, const row_job *job, size_t at, size_t pitch)
{
    const size_t n = job->volume->grid.dims[0];
    const double offset = job->out->offset;
#define ADD(t)                                                             \
    do {                                                                   \
        const t *samples = (const t *)job->volume->data + at;              \
        for (size_t x = 0; x < n; x++) {                                   \
            const double v = (double)samples[x];                           \
            if ((job->mask && job->mask[at + x]) || !(fabs(v) < NO_VALUE)) \
                continue;                                                  \
            sums[x / pitch] += v - offset;                                 \
            counts[x / pitch] += 1;                                        \
        }                                                                  \
    } while (0)
    CVOL_FOR_TYPE(job->volume->grid.type, ADD);
#undef ADD
}

static void average_row(const row_job *job, double *sums, double *counts)
{
    const cvol_coarse *out = job->out;
    const size_t *n = job->volume->grid.dims, cells = out->dims[0];
    size_t pitch[3], end[3] = {n[0], 0, 0};
    for (int a = 0; a < 3; a++)
        pitch[a] = (size_t)out->pitch[a];
    memset(sums, 0, cells * sizeof *sums);
    memset(counts, 0, cells * sizeof *counts);
    end[1] = (job->y + 1) * pitch[1] < n[1] ? (job->y + 1) * pitch[1] : n[1];
    end[2] = (job->z + 1) * pitch[2] < n[2] ? (job->z + 1) * pitch[2] : n[2];
    for (size_t z = job->z * pitch[2]; z < end[2]; z++)
        for (size_t y = job->y * pitch[1]; y < end[1]; y++)
            add_row(sums, counts, job, n[0] * (y + n[1] * z), pitch[0]);
    const size_t first = cells * (job->y + out->dims[1] * job->z);
    for (size_t x = 0; x < cells; x++) {
        const size_t width = (x + 1) * pitch[0] < n[0] ? pitch[0] : n[0] - x * pitch[0];
        const size_t samples = width * (end[1] - job->y * pitch[1]) * (end[2] - job->z * pitch[2]);
        out->values[first + x] = counts[x] > 0 ? (float)(sums[x] / counts[x]) : 0;
        if (out->cover)
            out->cover[first + x] = (float)(counts[x] / (double)samples);
    }
}

int cvol_coarse_of_volume(cvol_context *context, cvol_coarse *out, const cvol_volume *volume,
                          const uint8_t *mask)
{
    const int code = cvol_coarse_allocate(context, out, &volume->grid,
                                          cvol_coarse_level(&volume->grid), mask != NULL);
    if (code)
        return code;
    const size_t rows = out->dims[1] * out->dims[2];
    int failed = 0;
    out->offset = find_offset(volume, mask);
#pragma omp parallel num_threads(cvol_context_threads(context))
    {
        double *sums = cvol_allocate(2 * out->dims[0], sizeof *sums);
        if (!sums) {
#pragma omp atomic write
            failed = 1;
        }
#pragma omp for
        for (size_t i = 0; i < rows; i++) {
            const row_job job = {volume, mask, out, i % out->dims[1], i / out->dims[1]};
            if (sums)
                average_row(&job, sums, sums + out->dims[0]);
        }
        free(sums);
    }
    if (!failed)
        return CVOL_OK;
    cvol_coarse_free(out);
    return cvol_fail_memory(context, 2 * out->dims[0] * sizeof(double), "a row of cells");
}
