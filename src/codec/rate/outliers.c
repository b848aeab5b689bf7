/* Outliers: see outliers.h.
 *
 * An outlier is farther from the middle 99.8 % of the samples than eight times their range, or
 * beyond the range of terms in single precision. */
#include "codec/rate/outliers.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "array/core/array.h"
#include "base/context.h"
#include "base/memory.h"

enum { SAMPLED_MAX = 1 << 16, TAIL = 1000, WIDTHS = 8, SHARE = 1024 };
#define TERMS_MAX 1e34

static int compare(const void *a, const void *b)
{
    const double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

static double value_at(const void *samples, cvol_type type, size_t i)
{
    return type == CVOL_FLOAT32 ? (double)((const float *)samples)[i]
                                : ((const double *)samples)[i];
}

/* Finds the range of samples that are no outliers, by samples from all over the volume. Returns 0
 * if memory is short. */
static int find_outlier_limits(double limit[2], const void *samples, const cvol_grid *grid)
{
    const size_t count = cvol_grid_samples(grid),
                 stride = count / SAMPLED_MAX + 1 + (count > SAMPLED_MAX && grid->dims[0] % 2 == 0),
                 taken = (count - 1) / stride + 1, tail = taken / TAIL;
    double *values = cvol_allocate(taken, sizeof *values);
    if (!values)
        return 0;
    for (size_t i = 0; i < taken; i++)
        values[i] = value_at(samples, grid->type, i * stride);
    qsort(values, taken, sizeof *values, compare);
    /* Each tail has at least one sample. */
    const size_t cut = taken > 2 ? (tail ? tail : 1) : 0;
    const double lo = values[cut], hi = values[taken - 1 - cut], width = WIDTHS * (hi - lo);
    limit[0] = fmax(lo - width, -TERMS_MAX);
    limit[1] = fmin(hi + width, TERMS_MAX);
    free(values);
    return 1;
}

static double clamp(double value, const double limit[2])
{
    return value < limit[0] ? limit[0] : value > limit[1] ? limit[1] : value;
}

static size_t count_outside(const void *samples, const cvol_grid *grid, const double limit[2])
{
    const size_t count = cvol_grid_samples(grid);
    size_t outside = 0;
    for (size_t i = 0; i < count; i++) {
        const double value = value_at(samples, grid->type, i);
        outside += value < limit[0] || value > limit[1];
    }
    return outside;
}

static void clamp_all(void *to, const void *samples, const cvol_grid *grid, const double limit[2])
{
    const size_t count = cvol_grid_samples(grid);
    for (size_t i = 0; i < count; i++) {
        const double value = clamp(value_at(samples, grid->type, i), limit);
        if (grid->type == CVOL_FLOAT32)
            ((float *)to)[i] = (float)value;
        else
            ((double *)to)[i] = value;
    }
}

int cvol_outliers_clamp(cvol_context *context, void **clamped, const void *samples,
                        const cvol_grid *grid)
{
    const size_t count = cvol_grid_samples(grid);
    double limit[2];
    *clamped = NULL;
    if (cvol_type_is_integer(grid->type))
        return CVOL_OK;
    if (!find_outlier_limits(limit, samples, grid))
        return cvol_fail_memory(context, SAMPLED_MAX * sizeof(double), "a sample of the values");
    size_t outside = count_outside(samples, grid, limit);
    if (outside > count / SHARE + 1) { /* too many: then only values beyond the range of terms */
        limit[0] = -TERMS_MAX;
        limit[1] = TERMS_MAX;
        outside = count_outside(samples, grid, limit);
    }
    if (!outside)
        return CVOL_OK;
    *clamped = cvol_allocate(cvol_grid_bytes(grid), 1);
    if (!*clamped)
        return cvol_fail_memory(context, cvol_grid_bytes(grid), "samples without outliers");
    clamp_all(*clamped, samples, grid, limit);
    return CVOL_OK;
}

int cvol_samples_nan_alone(const void *samples, const cvol_grid *grid)
{
    const size_t count = cvol_grid_samples(grid);
    int nan = 0, infinite = 0;
    for (size_t i = 0; i < count && !cvol_type_is_integer(grid->type); i++) {
        const double value = value_at(samples, grid->type, i);
        nan |= isnan(value);
        infinite |= isinf(value);
    }
    return nan && !infinite;
}
