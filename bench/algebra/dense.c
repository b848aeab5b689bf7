/* The classical way: see dense.h. */
#define _DEFAULT_SOURCE /* M_SQRT2 */
#include "dense.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "timing.h"

/* ---- plans ----------------------------------------------------------------------------------- */

static int axes(int n[3], const size_t dims[3])
{
    int rank = 0;
    for (int a = 2; a >= 0; a--)
        if (dims[a] > 1 || (a == 0 && !rank))
            n[rank++] = (int)dims[a];
    return rank;
}

static void plan_dct(dense *d, int rank, const int *n, unsigned planner)
{
    fftwf_r2r_kind inverse[3], forward[3];
    for (int i = 0; i < 3; i++) {
        inverse[i] = FFTW_REDFT01;
        forward[i] = FFTW_REDFT10;
    }
    d->inverse_a = fftwf_plan_r2r(rank, n, d->a, d->a, inverse, planner);
    d->inverse_b = fftwf_plan_r2r(rank, n, d->b, d->b, inverse, planner);
    d->forward = fftwf_plan_r2r(rank, n, d->a, d->a, forward, planner);
    d->scale = 1;
    for (int i = 0; i < rank; i++)
        d->scale /= sqrt(2 * (double)n[i]);
}

static void plan_dft(dense *d, int rank, const int *n, unsigned planner)
{
    fftwf_complex *spectrum = (fftwf_complex *)d->spectrum;
    d->inverse_a = fftwf_plan_dft_c2r(rank, n, spectrum, d->a, planner | FFTW_DESTROY_INPUT);
    d->inverse_b = fftwf_plan_dft_c2r(rank, n, spectrum, d->b, planner | FFTW_DESTROY_INPUT);
    d->forward = fftwf_plan_dft_r2c(rank, n, d->a, spectrum, planner | FFTW_DESTROY_INPUT);
    d->forward_b = fftwf_plan_dft_r2c(rank, n, d->b, (fftwf_complex *)d->spectrum_b,
                                      planner | FFTW_DESTROY_INPUT);
    d->scale = 1 / sqrt((double)d->samples);
}

void dense_start(dense *out, cvol_transform transform, const size_t dims[3], unsigned planner)
{
    *out = (dense){.transform = transform, .complex = transform != CVOL_DCT};
    memcpy(out->dims, dims, sizeof out->dims);
    out->samples = dims[0] * dims[1] * dims[2];
    out->coefficients = out->complex ? (dims[0] / 2 + 1) * dims[1] * dims[2] : out->samples;
    out->a = bench_allocate(4 * out->samples);
    out->b = bench_allocate(4 * out->samples);
    int n[3];
    const int rank = axes(n, dims);
    if (out->complex) {
        out->spectrum = bench_allocate(8 * out->coefficients);
        out->spectrum_b = bench_allocate(8 * out->coefficients);
        plan_dft(out, rank, n, planner);
    } else {
        plan_dct(out, rank, n, planner);
    }
    if (!out->inverse_a || !out->inverse_b || !out->forward)
        bench_fail("FFTW has no plan");
}

void dense_stop(dense *d)
{
    fftwf_destroy_plan(d->inverse_a);
    fftwf_destroy_plan(d->inverse_b);
    fftwf_destroy_plan(d->forward);
    if (d->forward_b)
        fftwf_destroy_plan(d->forward_b);
    free(d->spectrum);
    free(d->spectrum_b);
    free(d->a);
    free(d->b);
}

/* ---- terms ----------------------------------------------------------------------------------- */

void dense_terms_make(dense_terms *out, const dense *d, dense_run *runs, size_t count)
{
    *out = (dense_terms){.runs = runs, .run_count = count};
    for (size_t i = 0; i < count; i++)
        out->value_count += (size_t)(d->complex + 1) * runs[i].length;
    out->values = bench_allocate(4 * out->value_count);
}

void dense_terms_free(dense_terms *terms)
{
    free(terms->runs);
    free(terms->values);
}

/* Frequency i of a low box along y or z; SIZE_MAX behind the last. */
static size_t low_frequency(const dense *d, int axis, size_t i, size_t k)
{
    const size_t n = d->dims[axis], box = !d->complex ? k : 2 * k - 1 < n ? 2 * k - 1 : n;
    if (i >= box)
        return SIZE_MAX;
    return i < k ? i : n - box + i;
}

void dense_low_box(dense_terms *out, const dense *d, const size_t low[3])
{
    const size_t row = d->complex ? d->dims[0] / 2 + 1 : d->dims[0];
    dense_run *runs = bench_allocate(sizeof *runs * d->dims[1] * d->dims[2]);
    size_t count = 0, y, z;
    for (size_t l = 0; (z = low_frequency(d, 2, l, low[2])) != SIZE_MAX; l++)
        for (size_t j = 0; (y = low_frequency(d, 1, j, low[1])) != SIZE_MAX; j++)
            runs[count++] = (dense_run){(uint32_t)(row * (y + d->dims[1] * z)), (uint32_t)low[0]};
    dense_terms_make(out, d, runs, count);
}

/* FFTW's DCT has other weights where a frequency is 0: sqrt 2 for each. */
static float dct_weight(const dense *d, size_t index, int to_fftw)
{
    const size_t u[3] = {index % d->dims[0], index / d->dims[0] % d->dims[1],
                         index / d->dims[0] / d->dims[1]};
    double weight = 1;
    for (int a = 0; a < 3; a++)
        if (!u[a] && d->dims[a] > 1)
            weight *= M_SQRT2;
    return (float)(to_fftw ? weight : 1 / weight);
}

static void scatter(const dense *d, float *spectrum, const dense_terms *terms)
{
    const size_t floats = (size_t)d->complex + 1;
    memset(spectrum, 0, 4 * floats * d->coefficients);
    const float *values = terms->values;
    for (size_t i = 0; i < terms->run_count; i++) {
        const size_t length = floats * terms->runs[i].length;
        memcpy(spectrum + floats * terms->runs[i].start, values, 4 * length);
        values += length;
    }
    /* Only the few rows on an axis have weights other than 1. */
    if (!d->complex)
        for (size_t i = 0; i < terms->run_count; i++) {
            const size_t start = terms->runs[i].start;
            const size_t y = start / d->dims[0] % d->dims[1], z = start / d->dims[0] / d->dims[1];
            const int on_axis = (!y && d->dims[1] > 1) || (!z && d->dims[2] > 1);
            const size_t length = on_axis ? terms->runs[i].length : start % d->dims[0] == 0;
            for (size_t j = 0; j < length; j++)
                spectrum[start + j] *= dct_weight(d, start + j, 1);
        }
}

static void gather(const dense *d, const float *spectrum, dense_terms *terms, double scale)
{
    const size_t floats = (size_t)d->complex + 1;
    float *values = terms->values;
    for (size_t i = 0; i < terms->run_count; i++) {
        const size_t start = terms->runs[i].start, length = floats * terms->runs[i].length;
        const float *from = spectrum + floats * start;
        for (size_t j = 0; j < length; j++)
            values[j] = (float)scale * from[j];
        if (!d->complex)
            for (size_t j = 0; j < length; j++)
                values[j] *= dct_weight(d, start + j, 0);
        values += length;
    }
}

void dense_analyse(dense *d, dense_terms *terms)
{
    fftwf_execute(d->forward);
    gather(d, d->complex ? d->spectrum : d->a, terms, d->scale);
}

void dense_synthesise(dense *d, const dense_terms *terms)
{
    scatter(d, d->complex ? d->spectrum : d->a, terms);
    fftwf_execute(d->inverse_a);
    for (size_t i = 0; i < d->samples; i++)
        d->a[i] *= (float)d->scale;
}

/* ---- the largest ----------------------------------------------------------------------------- */

/* Squared magnitude's upper 16 bits: rises with the magnitude. */
static uint32_t rank_of(const float *spectrum, size_t i, int complex)
{
    const float square = complex ? spectrum[2 * i] * spectrum[2 * i] +
                                       spectrum[2 * i + 1] * spectrum[2 * i + 1]
                                 : spectrum[i] * spectrum[i];
    uint32_t bits;
    memcpy(&bits, &square, 4);
    return bits >> 12;
}

/* Two passes: a histogram of magnitudes, then a selection of those at or above the level that it
 * gives. Of the last level it keeps as many as are still needed. */
static void keep_largest(const dense *d, const float *spectrum, dense_terms *out, double scale,
                         size_t floats, uint32_t *places)
{
    enum { LEVELS = 1 << 20 };
    uint32_t *histogram = calloc(LEVELS, sizeof *histogram);
    if (!histogram)
        bench_fail("no memory for a histogram");
    for (size_t i = 0; i < d->coefficients; i++)
        histogram[rank_of(spectrum, i, d->complex)]++;
    const size_t wanted = floats / ((size_t)d->complex + 1);
    size_t above = 0;
    uint32_t level = LEVELS - 1;
    while (level > 0 && above + histogram[level] <= wanted)
        above += histogram[level--];
    size_t last = wanted - above, count = 0;
    free(histogram);
    for (size_t i = 0; i < d->coefficients; i++) {
        const uint32_t rank = rank_of(spectrum, i, d->complex);
        if (rank < level || (rank == level && !last))
            continue;
        last -= rank == level;
        places[count] = (uint32_t)i;
        if (d->complex) {
            out->values[2 * count] = (float)scale * spectrum[2 * i];
            out->values[2 * count + 1] = (float)scale * spectrum[2 * i + 1];
        } else {
            out->values[count] = (float)scale * spectrum[i] * dct_weight(d, i, 0);
        }
        count++;
    }
    out->run_count = count;
    for (size_t i = 0; i < count; i++)
        out->runs[i] = (dense_run){places[i], 1};
}

/* ---- operations ------------------------------------------------------------------------------ */

void dense_operate(dense *d, dense_terms *out, dense_operation operation, const dense_terms *a,
                   const dense_terms *b, size_t largest, uint32_t *places)
{
    float *spectrum = d->complex ? d->spectrum : d->a;
    scatter(d, spectrum, a);
    fftwf_execute(d->inverse_a);
    scatter(d, d->complex ? d->spectrum : d->b, b);
    fftwf_execute(d->inverse_b);
    double scale = d->scale * d->scale; /* forward and back, linear */
    if (operation == DENSE_ADD) {
        for (size_t i = 0; i < d->samples; i++)
            d->a[i] += d->b[i];
    } else if (operation == DENSE_MULTIPLY) {
        for (size_t i = 0; i < d->samples; i++)
            d->a[i] *= d->b[i];
        scale *= d->scale;
    } else {
        fftwf_execute(d->forward_b);
    }
    fftwf_execute(d->forward);
    if (operation == DENSE_CONVOLVE) { /* sqrt(N) A B, each transformed forward and back */
        for (size_t i = 0; i < d->coefficients; i++) {
            const float x = d->spectrum[2 * i], y = d->spectrum[2 * i + 1];
            const float p = d->spectrum_b[2 * i], q = d->spectrum_b[2 * i + 1];
            d->spectrum[2 * i] = x * p - y * q;
            d->spectrum[2 * i + 1] = x * q + y * p;
        }
        scale = scale * scale / d->scale;
    }
    if (largest)
        keep_largest(d, spectrum, out, scale, largest, places);
    else
        gather(d, spectrum, out, scale);
}
