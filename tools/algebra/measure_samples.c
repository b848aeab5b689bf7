/* Counts and sums over a region of samples (measure_samples.h). */
#include "tools/algebra/measure_samples.h"

#include <math.h>
#include <stdlib.h>

/* Samples on the surface of the ellipsoid belong to it, however their sum is rounded. */
static const double surface = 1 + 1e-12;

static double sample_at(const cvol_volume *volume, size_t at)
{
    switch (volume->grid.type) {
#define SAMPLE(constant, ctype) \
    case constant:              \
        return (double)((const ctype *)volume->data)[at];
        SAMPLE(CVOL_UINT8, uint8_t)
        SAMPLE(CVOL_INT8, int8_t)
        SAMPLE(CVOL_UINT16, uint16_t)
        SAMPLE(CVOL_INT16, int16_t)
        SAMPLE(CVOL_UINT32, uint32_t)
        SAMPLE(CVOL_INT32, int32_t)
        SAMPLE(CVOL_FLOAT32, float)
        SAMPLE(CVOL_FLOAT64, double)
#undef SAMPLE
    }
    return (double)NAN;
}

/* The square of the distance from the centre of the box along an axis; 1 at its faces. */
static double square_along(const size_t begin[3], const size_t end[3], int axis, size_t at)
{
    const double along = (2 * (double)at - (double)(begin[axis] + end[axis] - 1)) /
                         (double)(end[axis] - begin[axis]);
    return along * along;
}

/* 1 if a sample has a value. */
static int has_value(const input *in, double sample)
{
    return isfinite(sample) && !(in->has_fill && sample >= in->fill && sample <= in->fill);
}

/* The middle of the range of all samples: sums of differences from it stay exact. */
static double middle_of(const input *in)
{
    double least = (double)INFINITY, largest = -(double)INFINITY;
    for (size_t i = 0; i < cvol_grid_samples(&in->volume->grid); i++) {
        const double value = sample_at(in->volume, i);
        if (has_value(in, value)) {
            least = fmin(least, value);
            largest = fmax(largest, value);
        }
    }
    const double middle = 0.5 * (least + largest);
    return isfinite(middle) ? middle : 0;
}

typedef struct sums {
    double count, sum, variation; /* variation: sum of (value - mean)^2 */
} sums;

/* Adds a row of values (Chan, Golub and LeVeque, The American Statistician 37, 1983, 2.1), so that
 * nothing cancels. */
static void join_row(sums *s, const double *values, size_t count)
{
    if (!count)
        return;
    const double m = (double)count;
    double sum = 0, variation = 0;
    for (size_t i = 0; i < count; i++)
        sum += values[i];
    const double mean = sum / m, apart = s->count > 0 ? mean - s->sum / s->count : 0;
    for (size_t i = 0; i < count; i++)
        variation += (values[i] - mean) * (values[i] - mean);
    s->variation += variation + apart * apart * (s->count * m / (s->count + m));
    s->sum += sum;
    s->count += m;
}

int measure_samples(cvol_region_statistics *statistics, cvol_region *region, const input *in,
                    const size_t begin[3], const size_t end[3], cvol_region_shape shape,
                    double least, double largest)
{
    const size_t *dims = in->volume->grid.dims;
    const double shift = middle_of(in);
    double *row = malloc((end[0] - begin[0]) * sizeof *row);
    sums s = {0};
    if (!row)
        return report_error(EXIT_FAILED, "not enough memory");
    *region = (cvol_region){0};
    *statistics = (cvol_region_statistics){.least = (double)INFINITY, .largest = -(double)INFINITY};
    for (size_t z = begin[2]; z < end[2]; z++)
        for (size_t y = begin[1]; y < end[1]; y++) {
            const double square = square_along(begin, end, 1, y) + square_along(begin, end, 2, z);
            size_t values = 0;
            for (size_t x = begin[0]; x < end[0]; x++) {
                const double value = sample_at(in->volume, x + dims[0] * (y + dims[1] * z));
                if (!has_value(in, value) || (shape == CVOL_REGION_ELLIPSOID &&
                                              square + square_along(begin, end, 0, x) > surface))
                    continue;
                region->inside += value >= least && value <= largest;
                statistics->least = fmin(statistics->least, value);
                statistics->largest = fmax(statistics->largest, value);
                row[values++] = value - shift;
            }
            statistics->samples += values;
            join_row(&s, row, values);
        }
    free(row);
    region->samples = statistics->samples;
    region->inside_least = region->inside_most = region->inside;
    if (statistics->samples) {
        statistics->mean = shift + s.sum / s.count;
        statistics->standard_deviation = sqrt(s.variation / s.count);
    } else {
        *statistics = (cvol_region_statistics){0};
    }
    return EXIT_DONE;
}
