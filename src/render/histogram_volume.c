/* The histogram of a dense volume, from every s-th sample along each axis.
 *
 * s is the smallest step that leaves at most 4 million samples. Steps per axis, and not every
 * s^3-th sample in memory, so that the subset does not fall into a few columns of the grid.
 * Smallest and largest value are the subset's own; NaN and infinity are left out.
 */
#include <math.h>

#include "render/histogram.h"

#define SAMPLES_MAX ((size_t)4 << 20)

typedef double (*fetch_fn)(const void *data, size_t index);

#define DEFINE_FETCH(name, type)                               \
    static double fetch_##name(const void *data, size_t index) \
    {                                                          \
        return (double)((const type *)data)[index];            \
    }
DEFINE_FETCH(uint8, uint8_t)
DEFINE_FETCH(int8, int8_t)
DEFINE_FETCH(uint16, uint16_t)
DEFINE_FETCH(int16, int16_t)
DEFINE_FETCH(uint32, uint32_t)
DEFINE_FETCH(int32, int32_t)
DEFINE_FETCH(float32, float)
DEFINE_FETCH(float64, double)

static const fetch_fn fetch_of[] = {
    [CVOL_UINT8] = fetch_uint8,     [CVOL_INT8] = fetch_int8,       [CVOL_UINT16] = fetch_uint16,
    [CVOL_INT16] = fetch_int16,     [CVOL_UINT32] = fetch_uint32,   [CVOL_INT32] = fetch_int32,
    [CVOL_FLOAT32] = fetch_float32, [CVOL_FLOAT64] = fetch_float64,
};

static size_t subset_step(const size_t dims[3])
{
    for (size_t step = 1;; step++) {
        double samples = 1;
        for (int a = 0; a < 3; a++)
            samples *= (double)((dims[a] - 1) / step + 1);
        if (samples <= (double)SAMPLES_MAX)
            return step;
    }
}

static void visit_subset(const cvol_sample_source *source, void (*visit)(void *user, double value),
                         void *user)
{
    const cvol_volume *volume = source->of;
    const size_t *n = volume->grid.dims;
    fetch_fn fetch = fetch_of[volume->grid.type];
    size_t step = subset_step(n);
    for (size_t z = 0; z < n[2]; z += step)
        for (size_t y = 0; y < n[1]; y += step)
            for (size_t x = 0; x < n[0]; x += step) {
                double value = fetch(volume->data, x + n[0] * (y + n[1] * z));
                if (isfinite(value))
                    visit(user, value);
            }
}

static void widen(void *user, double value)
{
    cvol_histogram *histogram = user;
    histogram->min = fmin(histogram->min, value);
    histogram->max = fmax(histogram->max, value);
}

int cvol_volume_histogram(cvol_context *context, cvol_histogram *out, const cvol_volume *volume)
{
    const cvol_sample_source source = {volume, visit_subset};
    *out = (cvol_histogram){.min = INFINITY, .max = -INFINITY};
    int code = cvol_grid_check(context, &volume->grid, "volume");
    if (!code) {
        out->chord = cvol_histogram_chord(&volume->grid);
        visit_subset(&source, widen, out);
    }
    if (!(out->min <= out->max))
        out->min = out->max = 0;
    else
        cvol_histogram_count(out, &source);
    return code;
}
