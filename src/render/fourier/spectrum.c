/* From samples to a padded spectrum, stored as half floats.
 *
 * A slice interpolates between places of the spectrum. In space, interpolation multiplies by the
 * kernel's gain, so the samples are divided by it first (Malzbender, "Fourier volume rendering",
 * 1993). It also adds ghosts of the volume's periodic copies; padding moves the copies away and
 * makes the ghosts weaker. At 1.5 a ghost is 0.00003 of its sample, root mean square, and at most
 * 0.0001, for samples at the faces. That is small enough for rays of one sample's length, whose
 * mean is a small sum divided by a small length.
 *
 * Half floats have an error of 1/4096 of each value: noise of 1/10,000 of the samples. The scale is
 * such that the largest possible value, the sum of all samples' magnitudes, fits.
 *
 * Slices are transformed along x and y as they arrive, then all along z. Only the latter needs all
 * padded places in memory. */
#include "render/fourier/spectrum.h"

#include <math.h>
#include <string.h>

#include "array/core/array.h"
#include "base/context.h"
#include "base/memory.h"
#include "render/fourier/slab.h"
#include "transform/fft.h"

#define HALF_LARGEST 60000.0
#define AROUND ((size_t)CVOL_FOURIER_BEFORE + CVOL_FOURIER_BEHIND)
/* Columns along z that are transformed together. */
#define BATCH ((size_t)32)

static size_t least(size_t a, size_t b)
{
    return a < b ? a : b;
}

/* ---- along x and y --------------------------------------------------------------------------- */

/* A spectrum under construction. */
typedef struct build {
    cvol_fourier_spectrum *out;
    size_t n[3];
    float *factors[3]; /* of samples along each axis */
    size_t width;      /* pairs in a row of a plane */
    float *planes;     /* n[2] planes of dims[1] rows */
    double *sums;      /* of magnitudes, for each slice */
    double base;
    int of_cover; /* of 1 for samples with a value, not of the values */
} build;

static size_t plane_floats(const build *of)
{
    return 2 * of->width * of->out->dims[1];
}

/* A slice's rows, divided by the gain, centred at index 0 of the padded ones. */
static void prepare_rows(const build *of, float *rows, const cvol_fourier_slab *from, size_t slice)
{
    const size_t *n = of->n, N = of->out->dims[0], middle = n[0] / 2;
    const float *fx = of->factors[0];
    const float base = (float)of->base;
    double total = 0;
    memset(rows, 0, n[1] * N * sizeof *rows);
    for (size_t y = 0; y < n[1]; y++) {
        const float *in = from->samples + (slice * n[1] + y) * n[0];
        const uint8_t *none = from->mask ? from->mask + (slice * n[1] + y) * n[0] : NULL;
        const float factor = of->factors[1][y] * of->factors[2][from->first + slice];
        float *out = rows + y * N, sum = 0;
        for (size_t x = 0; x < n[0]; x++) {
            float value = of->of_cover ? 1 : in[x] - base;
            value = none && none[x] ? 0 : value * factor * fx[x];
            out[x < middle ? x + N - middle : x - middle] = value;
            sum += fabsf(value);
        }
        total += (double)sum;
    }
    of->sums[from->first + slice] = total;
}

static int transform_slice(cvol_context *context, const build *of, float *rows,
                           const cvol_fourier_slab *from, size_t slice)
{
    const size_t *n = of->n, N = of->out->dims[0], M = of->out->dims[1], middle = n[1] / 2;
    float *plane = of->planes + (from->first + slice) * plane_floats(of);
    prepare_rows(of, rows, from, slice);
    memset(plane, 0, plane_floats(of) * sizeof *plane);
    cvol_fft_lines lines = {N, middle, 1, N, 1, of->width};
    int code = cvol_fft_along(context, CVOL_FFT_FORWARD, &lines,
                              plane + 2 * of->width * (M - middle), rows);
    lines.count = n[1] - middle;
    if (!code)
        code = cvol_fft_along(context, CVOL_FFT_FORWARD, &lines, plane, rows + middle * N);
    const cvol_fft_lines columns = {M, N / 2 + 1, of->width, 1, of->width, 1};
    if (!code)
        code = cvol_fft_along(context, CVOL_FFT_COMPLEX_FORWARD, &columns, plane, plane);
    return code;
}

static int transform_slab(cvol_context *context, const build *of, const cvol_fourier_slab *from)
{
    const size_t floats = of->n[1] * of->out->dims[0];
    int code = CVOL_OK;
#pragma omp parallel num_threads(cvol_context_threads(context))
    {
        cvol_context quiet = *context;
        float *rows = cvol_fft_allocate(floats);
#pragma omp for schedule(dynamic)
        for (size_t slice = 0; slice < from->count; slice++) {
            const int failed = rows ? transform_slice(&quiet, of, rows, from, slice)
                                    : CVOL_ERROR_MEMORY;
            if (failed) {
#pragma omp atomic write
                code = failed;
            }
        }
        free(rows);
    }
    return code ? cvol_fail_memory(context, floats * sizeof(float), "a padded slice") : CVOL_OK;
}

/* ---- along z --------------------------------------------------------------------------------- */

static uint16_t *place(const cvol_fourier_spectrum *of, size_t u, size_t v, size_t w)
{
    return of->values + 2 * (u + of->stride_v * v + of->stride_w * w);
}

/* Columns from..from + count - 1 of row v, at all w. */
static int transform_columns(cvol_context *context, const build *of, float *batch, size_t v,
                             size_t from, size_t count, float scale)
{
    const size_t N = of->out->dims[2], middle = of->n[2] / 2, plane = plane_floats(of);
    memset(batch, 0, 2 * N * BATCH * sizeof *batch);
    for (size_t z = 0; z < of->n[2]; z++)
        memcpy(batch + 2 * BATCH * (z < middle ? z + N - middle : z - middle),
               of->planes + z * plane + 2 * (v * of->width + from), 2 * count * sizeof *batch);
    const cvol_fft_lines lines = {N, BATCH, BATCH, 1, BATCH, 1};
    const int code = cvol_fft_along(context, CVOL_FFT_COMPLEX_FORWARD, &lines, batch, batch);
    if (code)
        return code;
    for (size_t w = 0; w < N; w++)
        CVOL_SIMD_CHOOSE(cvol_fourier_pack)
    (place(of->out, from + CVOL_FOURIER_BEFORE, v + CVOL_FOURIER_BEFORE, w + CVOL_FOURIER_BEFORE),
     batch + 2 * BATCH * w, 2 * count, scale);
    return CVOL_OK;
}

static int transform_along_z(cvol_context *context, const build *of, float scale)
{
    const size_t half = of->out->dims[0] / 2 + 1, batches = (half + BATCH - 1) / BATCH;
    const size_t items = batches * of->out->dims[1], floats = 2 * of->out->dims[2] * BATCH;
    int code = CVOL_OK;
#pragma omp parallel num_threads(cvol_context_threads(context))
    {
        cvol_context quiet = *context;
        float *batch = cvol_fft_allocate(floats);
#pragma omp for schedule(dynamic)
        for (size_t i = 0; i < items; i++) {
            const size_t from = i % batches * BATCH;
            const int failed = batch ? transform_columns(&quiet, of, batch, i / batches, from,
                                                         least(BATCH, half - from), scale)
                                     : CVOL_ERROR_MEMORY;
            if (failed) {
#pragma omp atomic write
                code = failed;
            }
        }
        free(batch);
    }
    return code ? cvol_fail_memory(context, floats * sizeof(float), "a batch of columns") : CVOL_OK;
}

/* Fills conjugates beyond both ends of x from existing rows, then copies beyond the ends of y and
 * z. */
static void fill_around(const cvol_fourier_spectrum *of)
{
    const size_t *N = of->dims, half = N[0] / 2, before = CVOL_FOURIER_BEFORE;
    for (size_t w = 0; w < N[2]; w++)
        for (size_t v = 0; v < N[1]; v++)
            for (size_t k = 0; k < AROUND; k++) {
                /* u = -1, -2, then beyond half */
                const size_t to = k < before ? before - 1 - k : half + 1 + k;
                const size_t from = 2 * before + (k < before ? 0 : 2 * half) - to;
                const uint16_t *in = place(of, from, (N[1] - v) % N[1] + before,
                                           (N[2] - w) % N[2] + before);
                uint16_t *out = place(of, to, v + before, w + before);
                out[0] = in[0];
                out[1] = in[1] ^ 0x8000;
            }
    const size_t row = 2 * of->stride_v * sizeof *of->values;
    for (size_t w = before; w < N[2] + before; w++) {
        memcpy(place(of, 0, 0, w), place(of, 0, N[1], w), before * row);
        for (size_t k = 0; k < CVOL_FOURIER_BEHIND; k++)
            memcpy(place(of, 0, N[1] + before + k, w), place(of, 0, before + k, w), row);
    }
    const size_t sheet = 2 * of->stride_w * sizeof *of->values;
    memcpy(place(of, 0, 0, 0), place(of, 0, 0, N[2]), before * sheet);
    for (size_t k = 0; k < CVOL_FOURIER_BEHIND; k++)
        memcpy(place(of, 0, 0, N[2] + before + k), place(of, 0, 0, before + k), sheet);
}

/* ---- whole spectra --------------------------------------------------------------------------- */

static int spectrum_start(cvol_context *context, cvol_fourier_spectrum *out, const size_t n[3])
{
    *out = (cvol_fourier_spectrum){.unit = 1};
    for (int a = 0; a < 3; a++) {
        const size_t padded = n[a] + (n[a] + 1) / 2;
        out->dims[a] = cvol_fft_good_length(padded < n[a] + 10 ? n[a] + 10 : padded, 1);
    }
    out->stride_v = out->dims[0] / 2 + 1 + AROUND;
    if (cvol_size_multiply(&out->stride_w, out->stride_v, out->dims[1] + AROUND) &&
        cvol_size_multiply(&out->places, out->stride_w, out->dims[2] + AROUND))
        out->values = cvol_allocate(out->places + CVOL_FOURIER_ROW, 2 * sizeof *out->values);
    if (out->values) /* reads go beyond the last row */
        memset(out->values + 2 * out->places, 0, CVOL_FOURIER_ROW * 2 * sizeof *out->values);
    return out->values ? CVOL_OK
                       : cvol_fail_memory(context, 2 * out->places * sizeof *out->values,
                                          "a padded spectrum");
}

static int build_start(cvol_context *context, build *of)
{
    of->width = (of->out->dims[0] / 2 + 8) / 8 * 8;
    for (int a = 0; a < 3; a++) {
        const size_t n = of->n[a], N = of->out->dims[a];
        of->factors[a] = cvol_allocate(n, sizeof(float));
        if (!of->factors[a])
            return cvol_fail_memory(context, n * sizeof(float), "factors of samples");
        for (size_t i = 0; i < n; i++) {
            const double x = ((double)i - (double)(n / 2)) / (double)N;
            const int ends = n > 1 && (i == 0 || i + 1 == n);
            of->factors[a][i] = (float)((ends ? 0.5 : 1) / cvol_fourier_kernel_gain(x));
        }
    }
    size_t floats = 0;
    of->sums = cvol_allocate(of->n[2], sizeof *of->sums);
    if (cvol_size_multiply(&floats, plane_floats(of), of->n[2]))
        of->planes = cvol_fft_allocate(floats);
    return of->planes && of->sums
               ? CVOL_OK
               : cvol_fail_memory(context, floats * sizeof(float), "slices' transforms");
}

static void build_end(build *of)
{
    for (int a = 0; a < 3; a++)
        free(of->factors[a]);
    free(of->planes);
    free(of->sums);
}

static int spectrum_make(cvol_context *context, cvol_fourier_spectrum *out, double *base,
                         const cvol_fourier_source *source, const size_t n[3], int of_cover)
{
    build of = {.out = out, .of_cover = of_cover, .n = {n[0], n[1], n[2]}};
    cvol_fourier_slab samples = {0};
    int code = spectrum_start(context, out, n);
    if (!code)
        code = build_start(context, &of);
    if (!code)
        code = cvol_fourier_slab_make(context, &samples, source, n);
    while (!code && samples.first + samples.count < n[2]) {
        code = cvol_fourier_slab_next(context, &samples, source, n);
        if (!code && samples.first == 0 && !of_cover)
            *base = cvol_fourier_slab_base(&samples, n, source->min);
        of.base = *base;
        if (!code)
            code = transform_slab(context, &of, &samples);
        if (!code)
            code = cvol_report_progress(context, "transforming",
                                        0.7 * (double)(samples.first + samples.count) /
                                            (double)n[2]);
    }
    cvol_fourier_slab_free(&samples);
    double largest = 0;
    for (size_t z = 0; z < n[2] && !code; z++)
        largest += of.sums[z];
    const double scale = largest > 0 && isfinite(largest) ? HALF_LARGEST / largest : 1;
    out->unit = (float)(1 / scale);
    if (!code)
        code = transform_along_z(context, &of, (float)scale);
    if (!code) {
        fill_around(out);
        code = cvol_report_progress(context, "transforming", 1);
    }
    build_end(&of);
    return code;
}

uint64_t cvol_fourier_spectrum_places(const cvol_fourier_spectrum *spectrum)
{
    const cvol_fourier_bricks *bricks = &spectrum->bricks;
    return bricks->all ? bricks->first[bricks->all] : spectrum->places;
}

uint64_t cvol_fourier_spectrum_bytes(const cvol_fourier_spectrum *spectrum)
{
    return 4 * cvol_fourier_spectrum_places(spectrum) +
           (sizeof(size_t) + CVOL_FOURIER_BRICK * sizeof(uint64_t)) * spectrum->bricks.all;
}

/* Keeps the strongest places of both spectra. */
static int keep(cvol_context *context, cvol_fourier_volume *volume, double most)
{
    int code = cvol_fourier_keep_strongest(context, &volume->samples, most);
    if (!code && volume->masked)
        code = cvol_fourier_keep_strongest(context, &volume->cover, most);
    return code;
}

int cvol_fourier_volume_make(cvol_context *context, cvol_fourier_volume *out,
                             const cvol_fourier_source *source, double rho)
{
    const size_t *n =
        (source->array ? cvol_array_grid(source->array) : &source->volume->grid)->dims;
    *out = (cvol_fourier_volume){.masked = source->array && cvol_mask_is_void(source->array->mask)};
    int code = spectrum_make(context, &out->samples, &out->base, source, n, 0);
    if (!code && out->masked)
        code = spectrum_make(context, &out->cover, &out->base, source, n, 1);
    if (!code && rho > 0)
        code = keep(context, out, rho / 2 * (double)n[0] * (double)n[1] * (double)n[2]);
    if (code)
        cvol_fourier_volume_free(out);
    return code;
}

void cvol_fourier_volume_free(cvol_fourier_volume *volume)
{
    free(volume->samples.values);
    free(volume->cover.values);
    cvol_fourier_bricks_free(&volume->samples.bricks);
    cvol_fourier_bricks_free(&volume->cover.bricks);
    *volume = (cvol_fourier_volume){0};
}
