/* The last step: from the intermediate image, which lies in the plane of slice 0 or, in
 * perspective, in one before the eye, to the picture, by Catmull-Rom interpolation
 * (warp_simd.c). */
#include <math.h>
#include <string.h>

#include "base/thread.h"
#include "render/sheet/frame/frame.h"
#include "render/sheet/warp/outline.h"
#include "render/sheet/warp/row.h"

/* One pixel's four values. */
typedef float pixel_values __attribute__((vector_size(16)));

/* Line 0 becomes the mean along the rays, and line 1 becomes 1 if there is one: with sums, the
 * pixels with the longest way through the volume would be brighter than their neighbours. */
static void find_means(float *lines, int width)
{
    for (int i = 0; i < width; i++)
        if (lines[width + i] > 0) {
            lines[i] /= lines[width + i];
            lines[width + i] = 1;
        }
}

/* The span begin .. end - 1 of the pixels, of four values each, that are not empty. */
static void find_filled(int *begin, int *end, const float *pixels, int width, pixel_values empty)
{
    int lo = 0, hi = width;
    while (lo < hi && !memcmp(pixels + 4 * lo, &empty, sizeof empty))
        lo++;
    while (hi > lo && !memcmp(pixels + 4 * (hi - 1), &empty, sizeof empty))
        hi--;
    *begin = lo;
    *end = hi;
}

/* Converts four lines of floats to lines of pixels of four values, in place, for the lines
 * interleaved from line j on; `scratch` has the length of the four. Finds the spans of the pixels
 * that are not empty. */
static void interleave(const cvol_intermediate *image, float *restrict scratch, int j,
                       pixel_values empty)
{
    const ptrdiff_t width = image->width, down = image->down;
    float *restrict lines = image->lines + CVOL_LINES * j * width;
    memcpy(scratch, lines, 4 * sizeof *lines * (size_t)(width * down));
    for (ptrdiff_t row = 0; row < down; row++) {
        float *out = lines + CVOL_LINES * row * width;
        const float *from = scratch + row * down;
        for (ptrdiff_t i = 0; i < width; i++) {
            const ptrdiff_t at = down == 1 ? i : i / CVOL_SQUARE * CVOL_GROUP + i % CVOL_SQUARE;
            for (int k = 0; k < 4; k++)
                out[4 * i + k] = from[k * down * width + at];
        }
        int *span = image->spans + 2 * (j + row);
        find_filled(&span[0], &span[1], out, image->width, empty);
    }
}

/* The union of the spans of lines j - 1 .. j + 2. */
static void find_reach(int reach[2], const cvol_intermediate *image, int j)
{
    reach[0] = image->width;
    reach[1] = 0;
    for (int i = j < 1 ? 0 : j - 1; i <= j + 2 && i < image->height; i++) {
        const int *span = image->spans + 2 * i;
        if (span[0] >= span[1])
            continue;
        reach[0] = span[0] < reach[0] ? span[0] : reach[0];
        reach[1] = span[1] > reach[1] ? span[1] : reach[1];
    }
}

static uint8_t to_byte(float value)
{
    return (uint8_t)(value <= 0 ? 0 : value >= 1 ? 255 : 255 * value + 0.5f);
}

void cvol_warp_locate(cvol_warp_places *places, const cvol_sheet_plan *plan, int y, int first)
{
    double start[3];
    for (int k = 0; k < 3; k++)
        start[k] = plan->warp[k][0] + y * plan->warp[k][2];
    if (plan->perspective) {
        const double u0 = plan->eye_lane - plan->u0, v0 = plan->eye_row - plan->v0;
        for (int i = 0; i < places->count; i++) {
            const double ahead = 1 / (start[2] + (first + i) * plan->warp[2][1]);
            places->u[i] = (u0 + (start[0] + (first + i) * plan->warp[0][1]) * ahead) / plan->du;
            places->v[i] = (v0 + (start[1] + (first + i) * plan->warp[1][1]) * ahead) / plan->dv;
        }
        return;
    }
    const double u = (start[0] - plan->u0) / plan->du, v = (start[1] - plan->v0) / plan->dv;
    const double step_u = plan->warp[0][1] / plan->du, step_v = plan->warp[1][1] / plan->dv;
    for (int i = 0; i < CVOL_WARP_CHUNK; i++) {
        places->u[i] = u + (first + i) * step_u;
        places->v[i] = v + (first + i) * step_v;
    }
}

/* Writes the picture's pixels from the interpolated values: composite or grey. */
typedef struct pixel_writer {
    pixel_values empty;
    float background[3];
    int grey;
    int by_outline; /* the faces decide which pixels see the volume, not the rays around a pixel */
    float lo, scale;
} pixel_writer;

/* The share of the rays around a pixel that must have met the volume. */
#define INTERSECTED_MIN 0.5f

/* If fewer did, but the pixel's own ray does: the mean of the nearest rays that did, since
 * extrapolation could give any value. *intersected: 1 if there are any. */
static float mean_of_near(int *intersected, const cvol_warp_source *source, double u, double v)
{
    const int left = (int)floor(u), top = (int)floor(v);
    float sum = 0, weight = 0;
    for (int k = 0; k < 16; k++) {
        const int x = left - 1 + k % 4, y = top - 1 + k / 4;
        if (x < 0 || x >= source->width || y < 0 || y >= source->height)
            continue;
        const float *pixel = source->pixels + y * source->stride + 4 * (ptrdiff_t)x;
        const double across = u - x, down = v - y, away = across * across + down * down;
        const float share = pixel[1] > 0 ? (float)exp(-4 * away) : 0;
        sum += share * pixel[0];
        weight += share;
    }
    *intersected = weight > 0;
    return weight > 0 ? sum / weight : 0;
}

/* Sets values[1] of grey pixels to 1 if their rays meet the volume, with their grey in values[0];
 * else to 0. */
static void find_greys(float *values, const pixel_writer *writer, const cvol_sheet_plan *plan,
                       const cvol_warp_source *source, const cvol_warp_places *places)
{
    uint8_t within[CVOL_WARP_CHUNK];
    if (writer->by_outline)
        cvol_warp_outline(within, plan, places);
    for (int i = 0; i < places->count; i++) {
        float *v = values + 4 * i;
        int hit = v[1] > INTERSECTED_MIN;
        float mean = hit ? v[0] / v[1] : 0;
        if (writer->by_outline && within[i] && !hit)
            mean = mean_of_near(&hit, source, places->u[i], places->v[i]);
        if (writer->by_outline)
            hit = hit && within[i];
        v[0] = hit ? (mean - writer->lo) * writer->scale : 0;
        v[1] = (float)hit;
    }
}

/* Grey as bytes; a kernel writes the others. */
static void write_grey(uint8_t *pixel, const pixel_writer *writer, pixel_values v)
{
    for (int k = 0; k < 3; k++)
        pixel[k] = to_byte(v[1] > 0 ? v[0] : writer->background[k]);
    pixel[3] = 255;
}

/* As floats, without background: colour times opacity, and opacity. */
static void write_values(float *pixel, const pixel_writer *writer, pixel_values v)
{
    for (int k = 0; k < 3; k++)
        pixel[k] = writer->grey ? v[0] : v[k];
    pixel[3] = writer->grey ? v[1] : 1 - v[3];
}

static void write_bytes(uint8_t *rgba, const pixel_writer *writer, const float *values, int count)
{
    if (!writer->grey) {
        CVOL_SIMD_CHOOSE(cvol_warp_bytes)(rgba, values, count, writer->background);
        return;
    }
    for (int i = 0; i < count; i++) {
        pixel_values value;
        memcpy(&value, values + 4 * i, sizeof value);
        write_grey(rgba + 4 * i, writer, value);
    }
}

static void write_chunk(cvol_image *image, size_t at, const pixel_writer *writer,
                        const float *values, int count)
{
    if (!image->values) {
        write_bytes(image->rgba + 4 * at, writer, values, count);
        return;
    }
    for (int i = 0; i < count; i++) {
        pixel_values value;
        memcpy(&value, values + 4 * i, sizeof value);
        write_values(image->values + 4 * (at + (size_t)i), writer, value);
    }
}

static void fill_empty(float values[4 * CVOL_WARP_CHUNK], const cvol_warp_source *source)
{
    for (int i = 0; i < CVOL_WARP_CHUNK; i++)
        memcpy(values + 4 * i, source->empty, sizeof source->empty);
}

/* V of pixel (x, y). */
static double find_place(const cvol_sheet_plan *plan, int x, int y)
{
    double d[3];
    for (int k = 1; k < 3; k++)
        d[k] = plan->warp[k][0] + x * plan->warp[k][1] + y * plan->warp[k][2];
    return plan->perspective ? plan->eye_row + d[1] / d[2] : d[1];
}

/* The first of pixels begin .. end - 1 of a line whose V is at least `bound`, if V rises along the
 * line, or less than that, if it falls. */
static int find_first(const cvol_sheet_plan *plan, int y, int begin, int end, double bound,
                      int rising)
{
    while (begin < end) {
        const int middle = begin + (end - begin) / 2;
        if ((find_place(plan, middle, y) >= bound) == rising)
            end = middle;
        else
            begin = middle + 1;
    }
    return begin;
}

/* For a tile: limits the pixels to its own. */
static void clip_to_tile(int *begin, int *end, const cvol_sheet_plan *plan, int y)
{
    const int from = *begin, to = *end;
    if ((isinf(plan->own[0]) && isinf(plan->own[1])) || from >= to)
        return;
    const int rising = find_place(plan, from, y) <= find_place(plan, to - 1, y);
    *begin = find_first(plan, y, from, to, plan->own[!rising], rising);
    *end = find_first(plan, y, from, to, plan->own[rising], rising);
}

/* The pixels are the inside of a polygon. */
void cvol_warp_pixels(int *begin, int *end, const cvol_sheet_plan *plan, int y, int width)
{
    *begin = 0;
    *end = width;
    if (!plan->perspective) {
        clip_to_tile(begin, end, plan, y);
        return;
    }
    while (*begin < width && !cvol_sheet_plan_has(plan, *begin, y))
        ++*begin;
    while (*end > *begin && !cvol_sheet_plan_has(plan, *end - 1, y))
        --*end;
    clip_to_tile(begin, end, plan, y);
}

/* `blank`: a chunk of the picture without content, as bytes. */
static void write_line(cvol_image *image, int y, const cvol_warp_source *source,
                       const cvol_sheet_plan *plan, const pixel_writer *writer,
                       const uint8_t blank[4 * CVOL_WARP_CHUNK])
{
    cvol_warp_places places;
    float values[4 * CVOL_WARP_CHUNK] __attribute__((aligned(64)));
    int begin, end;
    cvol_warp_pixels(&begin, &end, plan, y, image->width);
    for (int first = begin; first < end; first += CVOL_WARP_CHUNK) {
        const size_t at = (size_t)y * (size_t)image->width + (size_t)first;
        places.count = end - first < CVOL_WARP_CHUNK ? end - first : CVOL_WARP_CHUNK;
        cvol_warp_locate(&places, plan, y, first);
        if (CVOL_SIMD_CHOOSE(cvol_warp_sample)(values, source, &places)) {
            if (writer->grey)
                find_greys(values, writer, plan, source, &places);
            write_chunk(image, at, writer, values, places.count);
        } else if (image->values) {
            fill_empty(values, source);
            write_chunk(image, at, writer, values, places.count);
        } else {
            memcpy(image->rgba + 4 * at, blank, 4 * (size_t)places.count);
        }
    }
}

/* Returns 1 if lines of the intermediate image are lines or columns of the picture. */
static int are_lines(const cvol_sheet_plan *plan, const pixel_writer *writer)
{
    return plan->image_order && plan->warp[0][1] != 0 && !writer->grey;
}

/* For such a plan: a line is only written. */
static void copy_line(cvol_image *image, int y, const cvol_intermediate *intermediate,
                      const cvol_sheet_plan *plan, const pixel_writer *writer)
{
    float values[4 * CVOL_WARP_CHUNK] __attribute__((aligned(64)));
    const ptrdiff_t stride = (ptrdiff_t)intermediate->width * intermediate->down;
    const int way = plan->warp[0][1] < 0 ? -1 : 1;
    const ptrdiff_t line =
        (ptrdiff_t)((plan->warp[1][0] + y * plan->warp[1][2] - plan->v0) / plan->dv + 0.5);
    int begin, end;
    cvol_warp_pixels(&begin, &end, plan, y, image->width);
    if (begin >= end)
        return;
    const float *row = intermediate->lines + cvol_pixel_place(intermediate, CVOL_LINES, 0, 0, line);
    for (int first = begin; first < end; first += CVOL_WARP_CHUNK) {
        const int count = end - first < CVOL_WARP_CHUNK ? end - first : CVOL_WARP_CHUNK;
        const ptrdiff_t start = (ptrdiff_t)((plan->warp[0][0] - plan->u0) / plan->du) + way * first;
        for (int i = 0; i < count; i++) {
            const size_t at = (size_t)(start + way * i);
            const float *from = row + at / CVOL_SQUARE * CVOL_GROUP + at % CVOL_SQUARE;
            for (int k = 0; k < 4; k++)
                values[4 * i + k] = from[k * stride];
        }
        write_chunk(image, (size_t)y * (size_t)image->width + (size_t)first, writer, values, count);
    }
}

static void warp(cvol_image *image, cvol_intermediate *intermediate, const cvol_sheet_plan *plan,
                 const pixel_writer *writer, int threads)
{
    const int width = intermediate->width, height = intermediate->height;
    if (are_lines(plan, writer)) {
#pragma omp parallel for num_threads(threads) schedule(static)
        for (int y = 0; y < image->height; y++)
            copy_line(image, y, intermediate, plan, writer);
        return;
    }
    float *scratch = intermediate->scratch;
    int *reach = intermediate->spans + 2 * height;
    cvol_warp_source source = {.pixels = intermediate->lines,
                               .stride = CVOL_LINES * (ptrdiff_t)width,
                               .width = width,
                               .height = height,
                               .reach = reach};
    float values[4 * CVOL_WARP_CHUNK];
    uint8_t blank[4 * CVOL_WARP_CHUNK];
    memcpy(source.empty, &writer->empty, sizeof source.empty);
    fill_empty(values, &source);
    write_bytes(blank, writer, values, CVOL_WARP_CHUNK);
#pragma omp parallel num_threads(threads)
    {
        const size_t own = 4 * (size_t)width * (size_t)intermediate->down;
        float *line = scratch + own * (size_t)cvol_thread_index();
#pragma omp for schedule(static)
        for (int j = 0; j < height; j += intermediate->down) {
            if (writer->grey)
                find_means(intermediate->lines + CVOL_LINES * (size_t)j * (size_t)width, width);
            interleave(intermediate, line, j, writer->empty);
        }
#pragma omp for schedule(static)
        for (int j = 0; j < height; j++)
            find_reach(reach + 2 * j, intermediate, j);
#pragma omp for schedule(static)
        for (int y = 0; y < image->height; y++)
            write_line(image, y, &source, plan, writer, blank);
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
        .by_outline = !plan->perspective && !plan->planes && plan->masked != CVOL_SHEET_SOME_VOID,
        .lo = (float)lo,
        .scale = (float)(hi > lo ? 1 / (hi - lo) : 0)};
    warp(image, intermediate, plan, &writer, threads);
}

void cvol_warp_nothing(cvol_image *image, int grey, const double background[3])
{
    const size_t count = (size_t)image->width * (size_t)image->height;
    const pixel_writer writer = {
        .empty = {0, 0, 0, grey ? 0 : 1},
        .background = {(float)background[0], (float)background[1], (float)background[2]},
        .grey = grey};
    float values[4 * CVOL_WARP_CHUNK] __attribute__((aligned(64)));
    for (int i = 0; i < CVOL_WARP_CHUNK; i++)
        memcpy(values + 4 * i, &writer.empty, sizeof writer.empty);
    for (size_t at = 0; at < count; at += CVOL_WARP_CHUNK)
        write_chunk(image, at, &writer, values,
                    count - at < CVOL_WARP_CHUNK ? (int)(count - at) : CVOL_WARP_CHUNK);
}
