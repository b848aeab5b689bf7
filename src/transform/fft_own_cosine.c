/* DCT, IDCT and IDST of one long line, by the real transform of the same length: see
 * fft_own_batch_simd.c for the mathematics. */
#include <stddef.h>

#include "transform/fft_own.h"

/* Copies the even elements, then the odd ones in reverse; and back, with the signs of odd ones
 * changed. */
static void order(float *out, const float *in, size_t n)
{
    for (size_t i = 0; 2 * i < n; i++)
        out[i] = in[2 * i];
    for (size_t i = 0; 2 * i + 1 < n; i++)
        out[n - 1 - i] = in[2 * i + 1];
}

static void restore(float *out, const float *in, size_t n, float odd_sign)
{
    for (size_t i = 0; 2 * i < n; i++)
        out[2 * i] = in[i];
    for (size_t i = 0; 2 * i + 1 < n; i++)
        out[2 * i + 1] = odd_sign * in[n - 1 - i];
}

static void cosines_from_half(float *out, const float *half, const float *cosines, size_t n)
{
    out[0] = 2 * half[0];
    for (size_t k = 1; 2 * k < n; k++) {
        const float re = half[2 * k], im = half[2 * k + 1];
        const float c = 2 * cosines[2 * k], s = 2 * cosines[2 * k + 1];
        out[k] = re * c - im * s;
        out[n - k] = -(re * s + im * c);
    }
    if (n % 2 == 0)
        out[n / 2] = 2 * cosines[n] * half[n];
}

static void half_from_cosines(float *half, const float *in, const float *cosines, size_t n,
                              int reversed)
{
    const float *first = reversed ? in + n - 1 : in;
    const ptrdiff_t step = reversed ? -1 : 1;
    half[0] = first[0];
    half[1] = 0;
    for (size_t k = 1; 2 * k <= n; k++) {
        const float a = first[step * (ptrdiff_t)k], b = first[step * (ptrdiff_t)(n - k)];
        const float c = cosines[2 * k], s = cosines[2 * k + 1];
        half[2 * k] = a * c - b * s;
        half[2 * k + 1] = -(a * s) - b * c;
    }
    if (n % 2 == 0)
        half[n + 1] = 0;
}

size_t cvol_fft_cosine_line_scratch(const cvol_fft_line *line, size_t n)
{
    return 2 * (n / 2 + 1) + n + cvol_fft_line_scratch(line);
}

void cvol_fft_cosine_line_run(const cvol_fft_line *line, const float *cosines, cvol_fft_kind kind,
                              size_t n, float *out, const float *in, float *scratch)
{
    float *half = scratch + cvol_fft_line_scratch(line), *ordered = half + 2 * (n / 2 + 1);
    if (kind == CVOL_FFT_DCT) {
        order(ordered, in, n);
        cvol_fft_line_run(line, CVOL_FFT_FORWARD, half, ordered, scratch);
        cosines_from_half(out, half, cosines, n);
    } else {
        half_from_cosines(half, in, cosines, n, kind == CVOL_FFT_IDST);
        cvol_fft_line_run(line, CVOL_FFT_INVERSE, ordered, half, scratch);
        restore(out, ordered, n, kind == CVOL_FFT_IDST ? -1.0F : 1.0F);
    }
}
