/* Statistics of samples: extremes, mean, difference of two volumes; replacing NaN.
 *
 * Volumes are cut into chunks of fixed length; threads take chunks, and the chunks' results are
 * combined in order, so sums do not depend on the number of threads. Within a chunk samples are
 * converted to doubles, a short buffer at a time, and are summed in LANES lanes, so that the
 * compiler may use vectors without changing the order of sums. */
#include <float.h>
#include <math.h>
#include <stdlib.h>

#include "base/context.h"
#include "base/elementary.h"
#include "base/memory.h"
#include "volume/io/dense.h"

#define CHUNK_SAMPLES ((size_t)1 << 16)
#define BUFFER_SAMPLES ((size_t)1 << 10)
#define LANES 8

/* ---- samples as doubles -------------------------------------------------------------- */

static void load(double *restrict out, const cvol_volume *volume, size_t first, size_t count)
{
    switch (volume->grid.type) {
#define LOAD(constant, ctype)                                           \
    case constant: {                                                    \
        const ctype *restrict in = (const ctype *)volume->data + first; \
        for (size_t i = 0; i < count; i++)                              \
            out[i] = (double)in[i];                                     \
        break;                                                          \
    }
        LOAD(CVOL_UINT8, uint8_t)
        LOAD(CVOL_INT8, int8_t)
        LOAD(CVOL_UINT16, uint16_t)
        LOAD(CVOL_INT16, int16_t)
        LOAD(CVOL_UINT32, uint32_t)
        LOAD(CVOL_INT32, int32_t)
        LOAD(CVOL_FLOAT32, float)
        LOAD(CVOL_FLOAT64, double)
#undef LOAD
    }
}

static size_t smaller(size_t a, size_t b)
{
    return a < b ? a : b;
}

/* ---- one volume ---------------------------------------------------------------------- */

typedef struct part {
    double min, max, sum;
    size_t bad_count, bad_first;
} part;

static part part_empty(void)
{
    return (part){.min = INFINITY, .max = -INFINITY, .bad_first = SIZE_MAX};
}

static void part_join(part *total, const part *more)
{
    total->min = more->min < total->min ? more->min : total->min;
    total->max = more->max > total->max ? more->max : total->max;
    total->sum += more->sum;
    total->bad_count += more->bad_count;
    total->bad_first = smaller(total->bad_first, more->bad_first);
}

/* Sums finite samples, LANES at a time. */
static void add_finite(part *result, const double *values, size_t count)
{
    double min[LANES], max[LANES], sum[LANES] = {0};
    for (int l = 0; l < LANES; l++) {
        min[l] = INFINITY;
        max[l] = -INFINITY;
    }
    size_t whole = count - count % LANES;
    for (size_t i = 0; i < whole; i += LANES)
        for (size_t l = 0; l < LANES; l++) {
            double v = values[i + l];
            min[l] = v < min[l] ? v : min[l];
            max[l] = v > max[l] ? v : max[l];
            sum[l] += v;
        }
    for (size_t i = whole; i < count; i++) {
        part one = {.min = values[i], .max = values[i], .sum = values[i], .bad_first = SIZE_MAX};
        part_join(result, &one);
    }
    for (int l = 0; l < LANES; l++) {
        part lane = {.min = min[l], .max = max[l], .sum = sum[l], .bad_first = SIZE_MAX};
        part_join(result, &lane);
    }
}

/* Removes NaN and infinite values from the buffer, and counts them. Returns the number of remaining
 * values. */
static size_t remove_bad(part *result, double *values, size_t count, size_t first)
{
    size_t kept = 0;
    for (size_t i = 0; i < count; i++) {
        if (isfinite(values[i]))
            values[kept++] = values[i];
        else {
            result->bad_count++;
            result->bad_first = smaller(result->bad_first, first + i);
        }
    }
    return kept;
}

static part chunk_stats(const cvol_volume *volume, size_t first, size_t count)
{
    double buffer[BUFFER_SAMPLES];
    int may_be_bad = !cvol_type_is_integer(volume->grid.type);
    part result = part_empty();
    for (size_t done = 0; done < count;) {
        size_t some = smaller(BUFFER_SAMPLES, count - done), good = some;
        load(buffer, volume, first + done, some);
        if (may_be_bad)
            good = remove_bad(&result, buffer, some, first + done);
        add_finite(&result, buffer, good);
        done += some;
    }
    return result;
}

int cvol_volume_compute_statistics(cvol_context *context, cvol_volume_statistics *out,
                                   const cvol_volume *volume)
{
    int code = cvol_dense_check(context, volume, "volume");
    if (code)
        return code;
    size_t samples = cvol_grid_samples(&volume->grid);
    size_t chunks = (samples - 1) / CHUNK_SAMPLES + 1;
    part *parts = cvol_allocate(chunks, sizeof *parts);
    if (!parts)
        return cvol_fail_memory(context, chunks * sizeof *parts, "statistics");
#pragma omp parallel for schedule(dynamic) num_threads(cvol_context_threads(context))
    for (size_t c = 0; c < chunks; c++) {
        size_t first = c * CHUNK_SAMPLES;
        parts[c] = chunk_stats(volume, first, smaller(CHUNK_SAMPLES, samples - first));
    }
    part total = part_empty();
    for (size_t c = 0; c < chunks; c++)
        part_join(&total, &parts[c]);
    free(parts);
    *out = (cvol_volume_statistics){.bad_count = total.bad_count};
    if (total.bad_count)
        out->bad_first = total.bad_first;
    if (total.bad_count < samples) {
        out->min = total.min;
        out->max = total.max;
        out->mean = total.sum / (double)(samples - total.bad_count);
    }
    return CVOL_OK;
}

int cvol_volume_fill(cvol_context *context, cvol_volume *volume, double value)
{
    int code = cvol_dense_check(context, volume, "volume");
    if (code)
        return code;
    cvol_type type = volume->grid.type;
    if (!isfinite(value) || (type == CVOL_FLOAT32 && fabs(value) > FLT_MAX))
        return cvol_fail(context, CVOL_ERROR_ARGUMENT, "%g cannot fill samples of %s", value,
                         cvol_type_name(type));
    size_t samples = cvol_grid_samples(&volume->grid);
    float *f = type == CVOL_FLOAT32 ? volume->data : NULL;
    double *d = type == CVOL_FLOAT64 ? volume->data : NULL;
#pragma omp parallel for num_threads(cvol_context_threads(context)) if (f || d)
    for (size_t i = 0; i < (f || d ? samples : 0); i++) {
        if (f && !isfinite(f[i]))
            f[i] = (float)value;
        else if (d && !isfinite(d[i]))
            d[i] = value;
    }
    return CVOL_OK;
}

/* ---- two volumes --------------------------------------------------------------------- */

typedef struct apart {
    double squares, largest;
    size_t missing; /* samples without a value in both */
} apart;

/* Samples that are equal, or both NaN, do not differ; a finite one and one that is not differ
 * infinitely. */
static double difference_of(double a, double b)
{
    if (a == b || (isnan(a) && isnan(b)))
        return 0;
    double difference = fabs(a - b);
    return isnan(difference) ? INFINITY : difference;
}

/* Sets a to |a - b|. Integers need no second test. */
static void subtract(double *restrict a, const double *restrict b, size_t count, int integers)
{
    if (integers)
        for (size_t i = 0; i < count; i++)
            a[i] = fabs(a[i] - b[i]);
    else
        for (size_t i = 0; i < count; i++)
            a[i] = difference_of(a[i], b[i]);
}

/* Adds differences times `scale`. */
static void add_differences(apart *result, const double *values, size_t count, double scale)
{
    double squares[LANES] = {0}, largest[LANES] = {0};
    size_t whole = count - count % LANES;
    for (size_t i = 0; i < whole; i += LANES)
        for (size_t l = 0; l < LANES; l++) {
            double v = scale * values[i + l];
            squares[l] += v * v;
            largest[l] = v > largest[l] ? v : largest[l];
        }
    for (size_t i = whole; i < count; i++) {
        double v = scale * values[i];
        squares[i - whole] += v * v;
        largest[i - whole] = fmax(largest[i - whole], v);
    }
    for (int l = 0; l < LANES; l++) {
        result->squares += squares[l];
        result->largest = fmax(result->largest, largest[l]);
    }
}

/* Samples that are both NaN, or the same infinity. */
static size_t count_missing(const double *a, const double *b, size_t count)
{
    size_t missing = 0;
    for (size_t i = 0; i < count; i++)
        missing += !isfinite(a[i]) && (a[i] == b[i] || (isnan(a[i]) && isnan(b[i])));
    return missing;
}

static apart chunk_compare(const cvol_volume *a, const cvol_volume *b, double scale, size_t first,
                           size_t count)
{
    double in_a[BUFFER_SAMPLES], in_b[BUFFER_SAMPLES];
    int integers = cvol_type_is_integer(a->grid.type) && cvol_type_is_integer(b->grid.type);
    apart result = {0, 0, 0};
    for (size_t done = 0; done < count;) {
        size_t some = smaller(BUFFER_SAMPLES, count - done);
        load(in_a, a, first + done, some);
        load(in_b, b, first + done, some);
        result.missing += integers ? 0 : count_missing(in_a, in_b, some);
        subtract(in_a, in_b, some, integers);
        add_differences(&result, in_a, some, scale);
        done += some;
    }
    return result;
}

static int compare_samples(cvol_context *context, apart *total, const cvol_volume *a,
                           const cvol_volume *b, double scale)
{
    size_t samples = cvol_grid_samples(&a->grid);
    size_t chunks = (samples - 1) / CHUNK_SAMPLES + 1;
    apart *parts = cvol_allocate(chunks, sizeof *parts);
    if (!parts)
        return cvol_fail_memory(context, chunks * sizeof *parts, "the difference");
#pragma omp parallel for schedule(dynamic) num_threads(cvol_context_threads(context))
    for (size_t c = 0; c < chunks; c++) {
        size_t first = c * CHUNK_SAMPLES;
        parts[c] = chunk_compare(a, b, scale, first, smaller(CHUNK_SAMPLES, samples - first));
    }
    *total = (apart){0, 0, 0};
    for (size_t c = 0; c < chunks; c++) {
        total->squares += parts[c].squares;
        total->missing += parts[c].missing;
        total->largest = parts[c].largest > total->largest ? parts[c].largest : total->largest;
    }
    free(parts);
    return CVOL_OK;
}

int cvol_volume_compare(cvol_context *context, cvol_volume_difference *out, const cvol_volume *a,
                        const cvol_volume *b)
{
    cvol_volume_statistics stats;
    apart total = {0, 0, 0};
    double scale = 1;
    int code = cvol_dense_check(context, b, "volume");
    if (!code)
        code = cvol_volume_compute_statistics(context, &stats, a);
    for (int i = 0; !code && i < 3; i++)
        if (a->grid.dims[i] != b->grid.dims[i])
            code = cvol_fail(context, CVOL_ERROR_ARGUMENT,
                             "volumes of %zu x %zu x %zu and %zu x %zu x %zu samples cannot be "
                             "compared",
                             a->grid.dims[0], a->grid.dims[1], a->grid.dims[2], b->grid.dims[0],
                             b->grid.dims[1], b->grid.dims[2]);
    if (!code)
        code = compare_samples(context, &total, a, b, scale);
    const double largest = total.largest;
    if (!code && largest > 0 && isfinite(largest) && !(largest > 1e-140 && largest < 1e140)) {
        /* Squares would underflow or overflow. */
        scale = ldexp(1, (int)fmin(fmax(-ilogb(largest), -1000), 1000));
        code = compare_samples(context, &total, a, b, scale);
    }
    if (code)
        return code;
    const size_t samples = cvol_grid_samples(&a->grid) - total.missing;
    const double scaled = samples ? sqrt(total.squares / (double)samples) : 0;
    out->rmse = scaled / scale;
    out->max_abs_error = largest;
    out->peak = stats.max - stats.min;
    /* Halves, because the range may be more than the largest double. */
    const double half = stats.max / 2 - stats.min / 2;
    out->psnr_db = scaled > 0 ? 20 * (cvol_log10(half / (scaled / 2)) + cvol_log10(scale))
                              : INFINITY;
    return CVOL_OK;
}
