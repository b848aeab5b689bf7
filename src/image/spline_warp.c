/* The warp: a filter to and fro turns values into coefficients of splines, places take 4 x 4. */
#include "image/spline_warp.h"

#include <math.h>
#include <string.h>

#include "base/context.h"

typedef float pixel __attribute__((vector_size(16)));

static pixel load(const float *from)
{
    pixel v;
    memcpy(&v, from, sizeof v);
    return v;
}

static void store(float *to, pixel v)
{
    memcpy(to, &v, sizeof v);
}

/* ---- from samples to coefficients of splines: a filter to and fro -----------------------------
 */

#define POLE -0.26794919f

/* One line of n places, `stride` floats apart; zeros lie around it. */
static void filter_line(float *line, size_t n, size_t stride)
{
    pixel carry = {0};
    for (size_t i = 0; i < n; i++)
        store(line + i * stride, carry = 6 * load(line + i * stride) + POLE * carry);
    /* what the forward pass leaves beyond the end comes back */
    carry *= POLE * POLE / (POLE * POLE - 1);
    for (size_t i = n; i-- > 0;)
        store(line + i * stride, carry = POLE * (carry - load(line + i * stride)));
}

static void filter(float *places, const size_t dims[2], int threads)
{
#pragma omp parallel num_threads(threads)
    {
#pragma omp for schedule(static)
        for (size_t y = 0; y < dims[1]; y++)
            filter_line(places + 4 * dims[0] * y, dims[0], 4);
#pragma omp for schedule(static)
        for (size_t x = 0; x < dims[0]; x++)
            filter_line(places + 4 * x, dims[1], 4 * dims[0]);
    }
}

/* ---- splines at the places --------------------------------------------------------------------
 */

static void weigh(float w[4], float f)
{
    const float g = 1 - f;
    w[0] = g * g * g / 6;
    w[1] = (4 - 3 * f * f * (2 - f)) / 6;
    w[2] = (4 - 3 * g * g * (2 - g)) / 6;
    w[3] = f * f * f / 6;
}

/* The spline at (u, v) in places; zeros lie around the lattice. */
static pixel sample(const float *places, const size_t dims[2], double u, double v)
{
    const long x0 = (long)floor(u), y0 = (long)floor(v);
    float wx[4], wy[4];
    weigh(wx, (float)(u - (double)x0));
    weigh(wy, (float)(v - (double)y0));
    pixel sum = {0};
    const int inside = x0 >= 1 && y0 >= 1 && x0 + 2 < (long)dims[0] && y0 + 2 < (long)dims[1];
    for (long j = 0; j < 4; j++) {
        const long y = y0 + j - 1;
        if (!inside && (y < 0 || y >= (long)dims[1]))
            continue;
        const float *row = places + 4 * ((long)dims[0] * y + x0 - 1);
        pixel line = {0};
        for (long i = 0; i < 4; i++)
            if (inside || (x0 + i - 1 >= 0 && x0 + i - 1 < (long)dims[0]))
                line += wx[i] * load(row + 4 * i);
        sum += wy[j] * line;
    }
    return sum;
}

static uint8_t to_byte(float level)
{
    if (!(level > 0))
        return 0;
    return level < 1 ? (uint8_t)(level * 255 + 0.5f) : 255;
}

void cvol_spline_warp(cvol_context *context, cvol_image *image, float *places, const size_t dims[2],
                      const double to_lattice[2][3], const double background[3])
{
    const double(*m)[3] = to_lattice;
    const float ground[3] = {(float)background[0], (float)background[1], (float)background[2]};
    const double right = (double)dims[0] + 1, below = (double)dims[1] + 1;
    const int threads = cvol_context_threads(context);
    filter(places, dims, threads);
#pragma omp parallel for schedule(static) num_threads(threads)
    for (int y = 0; y < image->height; y++) {
        uint8_t *out = image->rgba + 4 * (size_t)y * (size_t)image->width;
        for (int x = 0; x < image->width; x++, out += 4) {
            const double u = m[0][0] * x + m[0][1] * y + m[0][2];
            const double v = m[1][0] * x + m[1][1] * y + m[1][2];
            pixel value = {0};
            if (u > -2 && u < right && v > -2 && v < below)
                value = sample(places, dims, u, v);
            const float through = 1 - fminf(fmaxf(value[3], 0), 1);
            for (int c = 0; c < 3; c++)
                out[c] = to_byte(fmaxf(value[c], 0) + through * ground[c]);
            out[3] = 255;
        }
    }
}
