/* The transforms of whole arrays in slots: the sums of fft.h, scaled to be orthonormal, and the
 * conversion between a half complex spectrum and slots (whole.h).
 *
 * A half complex row (v, w) holds F[u, v, w] for u <= nx/2. For 0 < u < nx/2 the place is the first
 * of its pair for all v and w, and its mirror lies in the row (-v, -w), in reverse order. Only the
 * columns u = 0 and u = nx/2 mirror onto themselves; for these the order of the rows decides. */
#include "transform/whole.h"

#include <math.h>
#include <stdlib.h>

#include "base/context.h"
#include "transform/fft.h"

#define SQRT_2 1.41421356237309504880F
#define SQRT_HALF 0.70710678118654752440F

/* ---- DCT ----------------------------------------------------------------------------------- */

/* Factors from a DCT of fft.h along one axis to the orthonormal one, and back before IDCT. Axes of
 * length 1 are not transformed. */
static double dct_scale(size_t u, size_t n, int inverse)
{
    if (n == 1)
        return 1;
    if (inverse)
        return u ? sqrt(0.5 / (double)n) : sqrt(1 / (double)n);
    return u ? sqrt(0.5 / (double)n) : 0.5 * sqrt(1 / (double)n);
}

/* out may be in. */
static void scale_dct(float *out, const float *in, const size_t dims[3], int inverse)
{
    const size_t n = dims[0];
    for (size_t w = 0; w < dims[2]; w++)
        for (size_t v = 0; v < dims[1]; v++, out += n, in += n) {
            double row = dct_scale(v, dims[1], inverse) * dct_scale(w, dims[2], inverse);
            const float first = (float)(row * dct_scale(0, n, inverse));
            const float rest = (float)(row * dct_scale(1, n, inverse));
            out[0] = first * in[0];
            for (size_t u = 1; u < n; u++)
                out[u] = rest * in[u];
        }
}

/* ---- slots of a half complex spectrum ------------------------------------------------------- */

/* +1, -1, 0: the order of a row (v, w) for columns that are their own mirrors. */
static int row_order(size_t v, size_t w, const size_t dims[3])
{
    const size_t place[3] = {0, v, w};
    return cvol_place_order(place, dims);
}

/* Columns that are their own mirrors: u = 0, and n / 2 where n is even. */
static size_t own_mirrors(size_t n)
{
    return 2 - n % 2;
}

/* One row; slots of the mirror row go to `mirror` (which may be the same row). */
static void dft_row(float *slots, float *mirror, const float *half, size_t n, float scale,
                    int order)
{
    const float pair = scale * SQRT_2;
    const size_t pairs = (n - 1) / 2;
    for (size_t u = 1; u <= pairs; u++)
        slots[u] = pair * half[2 * u];
    for (size_t u = 1; u <= pairs; u++)
        mirror[n - u] = pair * half[2 * u + 1];
    for (size_t i = 0; i < own_mirrors(n); i++) {
        const size_t u = i * (n / 2);
        if (order > 0) {
            slots[u] = pair * half[2 * u];
            mirror[u] = pair * half[2 * u + 1];
        } else if (order == 0) {
            slots[u] = scale * half[2 * u];
        }
    }
}

static void dht_row(float *slots, float *mirror, const float *half, size_t n, float scale)
{
    const size_t pairs = (n - 1) / 2;
    for (size_t u = 0; 2 * u <= n; u++)
        slots[u] = scale * (half[2 * u] - half[2 * u + 1]);
    for (size_t u = 1; u <= pairs; u++)
        mirror[n - u] = scale * (half[2 * u] + half[2 * u + 1]);
}

void cvol_slots_from_half(cvol_transform transform, float *slots, const float *half,
                          const size_t dims[3], float scale)
{
    const size_t n = dims[0];
    for (size_t w = 0; w < dims[2]; w++)
        for (size_t v = 0; v < dims[1]; v++, half += 2 * (n / 2 + 1)) {
            float *row = slots + n * (v + dims[1] * w);
            float *mirror = slots + n * (cvol_mirror_index(v, dims[1]) +
                                         dims[1] * cvol_mirror_index(w, dims[2]));
            if (transform == CVOL_DFT)
                dft_row(row, mirror, half, n, scale, row_order(v, w, dims));
            else
                dht_row(row, mirror, half, n, scale);
        }
}

/* One half complex row from its row of slots and the mirror row. */
static void row_from_dft(float *half, const float *slots, const float *mirror, size_t n,
                         float scale, int order)
{
    const float pair = scale * SQRT_HALF;
    const size_t pairs = (n - 1) / 2;
    for (size_t u = 1; u <= pairs; u++) {
        half[2 * u] = pair * slots[u];
        half[2 * u + 1] = pair * mirror[n - u];
    }
    for (size_t i = 0; i < own_mirrors(n); i++) {
        const size_t u = i * (n / 2);
        half[2 * u] = order > 0 ? pair * slots[u] : order ? pair * mirror[u] : scale * slots[u];
        half[2 * u + 1] = order > 0 ? pair * mirror[u] : order ? -pair * slots[u] : 0;
    }
}

static void row_from_dht(float *half, const float *slots, const float *mirror, size_t n,
                         float scale)
{
    const float share = scale * 0.5F;
    const size_t pairs = (n - 1) / 2;
    for (size_t u = 1; u <= pairs; u++) {
        half[2 * u] = share * (mirror[n - u] + slots[u]);
        half[2 * u + 1] = share * (mirror[n - u] - slots[u]);
    }
    for (size_t i = 0; i < own_mirrors(n); i++) {
        const size_t u = i * (n / 2);
        half[2 * u] = share * (mirror[u] + slots[u]);
        half[2 * u + 1] = share * (mirror[u] - slots[u]);
    }
}

void cvol_half_from_slots(cvol_transform transform, float *half, const float *slots,
                          const size_t dims[3], float scale)
{
    const size_t n = dims[0];
    for (size_t w = 0; w < dims[2]; w++)
        for (size_t v = 0; v < dims[1]; v++, half += 2 * (n / 2 + 1)) {
            const float *row = slots + n * (v + dims[1] * w);
            const float *mirror = slots + n * (cvol_mirror_index(v, dims[1]) +
                                               dims[1] * cvol_mirror_index(w, dims[2]));
            if (transform == CVOL_DFT)
                row_from_dft(half, row, mirror, n, scale, row_order(v, w, dims));
            else
                row_from_dht(half, row, mirror, n, scale);
        }
}

/* ---- whole arrays --------------------------------------------------------------------------- */

static float *allocate_half(cvol_context *context, const size_t dims[3])
{
    const size_t count = 2 * (dims[0] / 2 + 1) * dims[1] * dims[2];
    float *half = cvol_fft_allocate(count);
    if (!half)
        cvol_fail_memory(context, count * sizeof *half, "a spectrum");
    return half;
}

static float orthonormal_scale(const size_t dims[3])
{
    return (float)(1 / sqrt((double)dims[0] * (double)dims[1] * (double)dims[2]));
}

int cvol_whole_forward(cvol_context *context, cvol_transform transform, float *slots,
                       float *samples, const size_t dims[3])
{
    if (transform == CVOL_DCT) {
        int code = cvol_fft(context, CVOL_FFT_DCT, dims, slots, samples);
        if (!code)
            scale_dct(slots, slots, dims, 0);
        return code;
    }
    float *half = allocate_half(context, dims);
    if (!half)
        return CVOL_ERROR_MEMORY;
    int code = cvol_fft(context, CVOL_FFT_FORWARD, dims, half, samples);
    if (!code)
        cvol_slots_from_half(transform, slots, half, dims, orthonormal_scale(dims));
    free(half);
    return code;
}

int cvol_whole_inverse(cvol_context *context, cvol_transform transform, float *samples,
                       float *slots, const size_t dims[3])
{
    if (transform == CVOL_DCT) {
        scale_dct(samples, slots, dims, 1);
        return cvol_fft(context, CVOL_FFT_IDCT, dims, samples, samples);
    }
    float *half = allocate_half(context, dims);
    if (!half)
        return CVOL_ERROR_MEMORY;
    cvol_half_from_slots(transform, half, slots, dims, orthonormal_scale(dims));
    int code = cvol_fft(context, CVOL_FFT_INVERSE, dims, samples, half);
    free(half);
    return code;
}
