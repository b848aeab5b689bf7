/* The last step: from the intermediate image, which lies in the plane of sheet 0, to the picture,
 * by Catmull-Rom interpolation (Catmull and Rom 1974), 4 x 4 taps a pixel. */
#include <string.h>

#include "base/thread.h"
#include "render/sheet.h"

/* Weights of the samples at -1, 0, 1, 2 for a point at t in 0..1. */
static void catmull_rom(float weights[4], float t)
{
    weights[0] = ((-0.5f * t + 1) * t - 0.5f) * t;
    weights[1] = (1.5f * t - 2.5f) * t * t + 1;
    weights[2] = ((-1.5f * t + 2) * t + 0.5f) * t;
    weights[3] = (0.5f * t - 0.5f) * t * t;
}

/* One pixel's four values. */
typedef float pixel_values __attribute__((vector_size(16)));

static pixel_values load_pixel(const float *from)
{
    pixel_values v;
    memcpy(&v, from, sizeof v);
    return v;
}

/* Makes line 0 the mean along the rays, and line 1 whether there is one: sums would let the pixels
 * with the longest way through the volume outshine their neighbours. */
static void find_means(float *lines, int width)
{
    for (int i = 0; i < width; i++)
        if (lines[width + i] > 0) {
            lines[i] /= lines[width + i];
            lines[width + i] = 1;
        }
}

/* Four lines of `width` floats into `width` pixels of four, in place; `line` is scratch. Finds the
 * span of the pixels that are not empty: begin .. end - 1. */
static void interleave(float *lines, float *line, int width, pixel_values empty, int *begin,
                       int *end)
{
    memcpy(line, lines, 4 * sizeof *line * (size_t)width);
    for (int i = 0; i < width; i++)
        for (int k = 0; k < 4; k++)
            lines[4 * i + k] = line[k * width + i];
    int lo = 0, hi = width;
    while (lo < hi && !memcmp(lines + 4 * lo, &empty, sizeof empty))
        lo++;
    while (hi > lo && !memcmp(lines + 4 * (hi - 1), &empty, sizeof empty))
        hi--;
    *begin = lo;
    *end = hi;
}

/* floor() of what fits into an int; the library's is a call on processors without rounding. */
static int floor_to_int(double value)
{
    int whole = (int)value;
    return whole - (value < whole);
}

/* Whether one of the taps i0 .. i0 + 3, j0 .. j0 + 3 is not empty. */
static int reaches_span(const cvol_intermediate *image, int i0, int j0)
{
    for (int j = j0 < 0 ? 0 : j0; j <= j0 + 3 && j < image->height; j++)
        if (i0 < image->spans[2 * j + 1] && i0 + 3 >= image->spans[2 * j])
            return 1;
    return 0;
}

/* The values at pixel coordinates (u, v) of the interleaved intermediate image; `empty` is what
 * lies around it. */
static pixel_values sample_image(const cvol_intermediate *image, pixel_values empty, double u,
                                 double v)
{
    const int i0 = floor_to_int(u) - 1, j0 = floor_to_int(v) - 1;
    if (!reaches_span(image, i0, j0))
        return empty;
    float across[4], down[4];
    catmull_rom(across, (float)(u - (i0 + 1)));
    catmull_rom(down, (float)(v - (j0 + 1)));
    pixel_values out = {0};
    const int inside = i0 >= 0 && j0 >= 0 && i0 + 3 < image->width && j0 + 3 < image->height;
    for (int dj = 0; dj < 4; dj++) {
        const int j = j0 + dj;
        const float *line = image->lines + ((long)j * CVOL_LINES * image->width + 4L * i0);
        pixel_values sum = {0};
        for (int di = 0; di < 4; di++) {
            const int i = i0 + di;
            const int there = inside || (j >= 0 && j < image->height && i >= 0 && i < image->width);
            sum += across[di] * (there ? load_pixel(line + 4 * di) : empty);
        }
        out += down[dj] * sum;
    }
    return out;
}

static uint8_t to_byte(float value)
{
    return (uint8_t)(value <= 0 ? 0 : value >= 1 ? 255 : 255 * value + 0.5f);
}

/* Intermediate pixel coordinates along line y of the picture: at[k] + x step[k]. */
static void locate(double at[2], double step[2], const cvol_sheet_plan *plan, int y)
{
    at[0] = (plan->warp[0][0] + y * plan->warp[0][2] - plan->u0) / plan->du;
    at[1] = (plan->warp[1][0] + y * plan->warp[1][2] - plan->v0) / plan->dv;
    step[0] = plan->warp[0][1] / plan->du;
    step[1] = plan->warp[1][1] / plan->dv;
}

/* Writes the picture's pixels from the values at their places: composite or grey. */
typedef struct pixel_writer {
    pixel_values empty;
    float background[3];
    int grey;
    float lo, scale;
} pixel_writer;

static void write_pixel(uint8_t *pixel, const pixel_writer *writer, pixel_values v)
{
    const int hit = v[1] > 0.5f; /* for grey: the ray met the volume */
    const float grey = hit ? (v[0] / v[1] - writer->lo) * writer->scale : 0;
    const float through = v[3] < 0 ? 0 : v[3] > 1 ? 1 : v[3];
    for (int k = 0; k < 3; k++)
        pixel[k] = to_byte(!writer->grey ? v[k] + through * writer->background[k]
                           : hit         ? grey
                                         : writer->background[k]);
    pixel[3] = 255;
}

/* The same as floats, over no background: colour times opacity, and opacity. */
static void write_values(float *pixel, const pixel_writer *writer, pixel_values v)
{
    const int hit = v[1] > 0.5f;
    const float grey = hit ? (v[0] / v[1] - writer->lo) * writer->scale : 0;
    for (int k = 0; k < 3; k++)
        pixel[k] = writer->grey ? grey : v[k];
    pixel[3] = writer->grey ? (float)hit : 1 - v[3];
}

static void write_line(cvol_image *image, int y, const cvol_intermediate *intermediate,
                       const cvol_sheet_plan *plan, const pixel_writer *writer)
{
    const size_t first = 4 * (size_t)y * (size_t)image->width;
    const double right = intermediate->width + 1, below = intermediate->height + 1;
    double at[2], step[2];
    locate(at, step, plan, y);
    for (int x = 0; x < image->width; x++) {
        const size_t pixel = first + 4 * (size_t)x;
        const double u = at[0] + x * step[0], v = at[1] + x * step[1];
        pixel_values values = writer->empty;
        if (u > -2 && u < right && v > -2 && v < below)
            values = sample_image(intermediate, writer->empty, u, v);
        if (image->values)
            write_values(image->values + pixel, writer, values);
        else
            write_pixel(image->rgba + pixel, writer, values);
    }
}

static void warp(cvol_image *image, cvol_intermediate *intermediate, const cvol_sheet_plan *plan,
                 const pixel_writer *writer, int threads)
{
    const int width = intermediate->width;
    float *scratch = intermediate->scratch;
#pragma omp parallel num_threads(threads)
    {
        float *line = scratch + 4 * (size_t)cvol_thread_index() * (size_t)width;
#pragma omp for schedule(static)
        for (int j = 0; j < intermediate->height; j++) {
            float *lines = intermediate->lines + CVOL_LINES * (size_t)j * (size_t)width;
            if (writer->grey)
                find_means(lines, width);
            interleave(lines, line, width, writer->empty, &intermediate->spans[2 * j],
                       &intermediate->spans[2 * j + 1]);
        }
#pragma omp for schedule(static)
        for (int y = 0; y < image->height; y++)
            write_line(image, y, intermediate, plan, writer);
    }
}

void cvol_warp_composite(cvol_image *image, cvol_intermediate *intermediate,
                         const cvol_sheet_plan *plan, const double background[3], int threads)
{
    const pixel_writer writer = {
        .empty = {0, 0, 0, 1},
        .background = {(float)background[0], (float)background[1], (float)background[2]}};
    warp(image, intermediate, plan, &writer, threads);
}

void cvol_warp_grey(cvol_image *image, cvol_intermediate *intermediate, const cvol_sheet_plan *plan,
                    double lo, double hi, const double background[3], int threads)
{
    const pixel_writer writer = {
        .background = {(float)background[0], (float)background[1], (float)background[2]},
        .grey = 1,
        .lo = (float)lo,
        .scale = (float)(hi > lo ? 1 / (hi - lo) : 0)};
    warp(image, intermediate, plan, &writer, threads);
}
