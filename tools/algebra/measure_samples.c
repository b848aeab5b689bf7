/* Counts and sums over a region of samples (measure_samples.h). */
#include "tools/algebra/measure_samples.h"

#include <math.h>
#include <string.h>

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

void measure_samples(cvol_region_statistics *statistics, cvol_region *region, const input *in,
                     const size_t begin[3], const size_t end[3], cvol_region_shape shape,
                     double least, double largest)
{
    const size_t *dims = in->volume->grid.dims;
    const double shift = sample_at(in->volume,
                                   begin[0] + dims[0] * (begin[1] + dims[1] * begin[2]));
    double all = 0, all_squares = 0;
    *region = (cvol_region){0};
    *statistics = (cvol_region_statistics){.least = (double)INFINITY, .largest = -(double)INFINITY};
    for (size_t z = begin[2]; z < end[2]; z++)
        for (size_t y = begin[1]; y < end[1]; y++) {
            const double square = square_along(begin, end, 1, y) + square_along(begin, end, 2, z);
            double sum = 0, squares = 0; /* of a row, so that sums of many samples stay exact */
            for (size_t x = begin[0]; x < end[0]; x++) {
                const double value = sample_at(in->volume, x + dims[0] * (y + dims[1] * z));
                if (in->has_fill && (value == in->fill || (isnan(value) && isnan(in->fill))))
                    continue;
                if (shape == CVOL_REGION_ELLIPSOID &&
                    square + square_along(begin, end, 0, x) > surface)
                    continue;
                statistics->samples++;
                region->inside += value >= least && value <= largest;
                statistics->least = fmin(statistics->least, value);
                statistics->largest = fmax(statistics->largest, value);
                sum += value - shift;
                squares += (value - shift) * (value - shift);
            }
            all += sum;
            all_squares += squares;
        }
    region->samples = statistics->samples;
    region->inside_least = region->inside_most = region->inside;
    if (!statistics->samples) {
        *statistics = (cvol_region_statistics){0};
        return;
    }
    const double n = (double)statistics->samples;
    statistics->mean = shift + all / n;
    statistics->standard_deviation = sqrt(fmax(0, all_squares - all * all / n) / n);
}
