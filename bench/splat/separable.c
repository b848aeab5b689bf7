/* The time of a separable splatter on samples: what engine transform does, without transforms.
 *
 * A slice's classified samples (colour times opacity, opacity) are kept as dense planes. The
 * footprint is a product of two lines of weights, the same for all samples of a slice, so a picture
 * needs one pass along y and one along x for each slice, on the same lattice as engine transform,
 * front to back. Rows without visible samples and rows that are hidden are skipped.
 *
 * usage: separable VOLUME.raw NXxNYxNZ TRANSFER.json SIZE FOOTPRINT REPEAT OUT.png
 *
 * Samples are uint8; azimuth 15, elevation 20, unlit, one thread. Prints {"cpu_ms": ...}: the least
 * processor time of a picture, without classification. Exit status 1: an error. */
#define _POSIX_C_SOURCE 200809L /* clock_gettime */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

#include "base/memory.h"
#include "cvol/cvol.h"
#include "render/spectral/frame.h"
#include "render/splat/setup.h"

/* Places behind which nothing is seen, as in engine transform. */
#define MIN_LIGHT 0x1p-10F
enum { PAD = 64 };

/* A slice's dense planes, and the visible samples of each row: from, up to. */
typedef struct slice {
    float *planes[CVOL_PLANES]; /* NULL: the slice is transparent */
    size_t (*spans)[2];
} slice;

typedef struct scene {
    cvol_splat_setup setup;
    cvol_intermediate_grid lattice;
    cvol_footprint_shape shape;
    size_t samples[2];
    int channels;
    slice *slices;
    float *picture[CVOL_PLANES]; /* of the lattice; the last: transmittance */
    float *row[CVOL_PLANES];     /* a row of samples, spread along y */
    float *phases;               /* every step-th of its samples, for each first one */
    float *sheet[CVOL_PLANES];   /* a row of the lattice */
} scene;

static void stop(cvol_context *context, const char *what)
{
    fprintf(stderr, "separable: %s: %s\n", what,
            context ? cvol_context_message(context) : "failed");
    exit(1);
}

static void *need(size_t count, size_t size)
{
    void *memory = cvol_allocate_zero(count, size);
    if (!memory)
        stop(NULL, "not enough memory");
    return memory;
}

static int has_plane(const scene *s, int c)
{
    return c < s->channels || c == CVOL_PLANE_OPACITY;
}

/* ---- samples --------------------------------------------------------------------------------- */

static void find_spans(slice *of, const size_t samples[2])
{
    of->spans = need(samples[1], sizeof *of->spans);
    for (size_t y = 0; y < samples[1]; y++) {
        const float *row = of->planes[CVOL_PLANE_OPACITY] + y * samples[0];
        size_t from = 0, to = samples[0];
        while (from < to && !(fabsf(row[from]) > 1e-6F))
            from++;
        while (to > from && !(fabsf(row[to - 1]) > 1e-6F))
            to--;
        of->spans[y][0] = from;
        of->spans[y][1] = to;
    }
}

/* Classifies all samples, by the function of engine transform: with all terms of whole planes. */
static void classify(cvol_context *context, scene *s, const cvol_volume *volume,
                     const cvol_transfer *transfer, const cvol_render_options *options)
{
    const cvol_transform_options all = {.transform = CVOL_DCT, .rho = 1};
    const size_t begin[3] = {0};
    cvol_splat_input input;
    cvol_view view;
    cvol_baked baked;
    if (cvol_splat_input_make(context, &input, NULL, volume) ||
        cvol_splat_input_set_transfer(context, &input, transfer) ||
        cvol_view_make(context, &view, &volume->grid, options) ||
        cvol_splat_setup_picture(context, &s->setup, &input, &view, options, "transform"))
        stop(context, "scene");
    s->shape = cvol_intermediate_grid_shape(&options->splat);
    s->lattice = cvol_intermediate_grid_make(&s->setup.plan, &s->shape,
                                             cvol_intermediate_grid_step(&s->shape));
    cvol_splat_input_tabulate(&input, s->setup.plan.distance, 1);
    const cvol_bake_source source = {&input.source, &s->setup.plan, input.table, &s->setup.light,
                                     s->setup.ascending};
    if (cvol_bake(context, &baked, &source, &s->lattice, &s->shape, &all))
        stop(context, "classification");
    s->channels = baked.channels;
    memcpy(s->samples, baked.samples, sizeof s->samples);
    s->slices = need(baked.slices, sizeof *s->slices);
    const size_t end[3] = {s->samples[0], s->samples[1], 1};
    for (size_t k = 0; k < baked.slices; k++) {
        if (!baked.planes[k][CVOL_PLANE_OPACITY])
            continue;
        for (int c = 0; c < CVOL_PLANES; c++)
            if (has_plane(s, c)) {
                s->slices[k].planes[c] = need(end[0] * end[1], sizeof(float));
                if (cvol_array_evaluate_real(context, s->slices[k].planes[c], baked.planes[k][c],
                                             begin, end))
                    stop(context, "classification");
            }
        find_spans(&s->slices[k], s->samples);
    }
    cvol_baked_free(&baked);
    cvol_splat_input_free(&input);
}

/* ---- a picture ------------------------------------------------------------------------------- */

/* Sums the sample rows that reach row p of the lattice. Sets *from and *to to the samples that may
 * be visible; 0 if there are none. */
static int spread_rows(scene *s, const slice *of, const cvol_intermediate_line *line, long p,
                       size_t *from, size_t *to)
{
    const long first = p * (long)s->lattice.step - line->place;
    *from = s->samples[0];
    *to = 0;
    for (int q = line->low; q <= line->high; q++) {
        const long y = first - q;
        if (y < 0 || y >= (long)s->samples[1])
            continue;
        *from = of->spans[y][0] < of->spans[y][1] && of->spans[y][0] < *from ? of->spans[y][0]
                                                                             : *from;
        *to = of->spans[y][1] > *to ? of->spans[y][1] : *to;
    }
    if (*from >= *to)
        return 0;
    for (int c = 0; c < CVOL_PLANES; c++) {
        if (!has_plane(s, c))
            continue;
        float *restrict row = s->row[c];
        memset(row + *from, 0, (*to - *from) * sizeof *row);
        for (int q = line->low; q <= line->high; q++) {
            const long y = first - q;
            if (y < 0 || y >= (long)s->samples[1])
                continue;
            const float weight = (float)line->weights[q - line->low];
            const float *restrict in = of->planes[c] + (size_t)y * s->samples[0];
            for (size_t x = *from; x < *to; x++)
                row[x] += weight * in[x];
        }
    }
    return 1;
}

static long floor_divide(long a, long b)
{
    return a >= 0 ? a / b : -((b - 1 - a) / b);
}

/* Spreads a row along x to places begin .. end - 1 of the sheet. */
static void spread_row(scene *s, int c, const cvol_intermediate_line *line, size_t from, size_t to,
                       long begin, long end)
{
    const long step = (long)s->lattice.step;
    const size_t room = s->samples[0] / (size_t)step + 2 * PAD + 2;
    float *restrict out = s->sheet[c];
    /* phase r: samples i = r + n step, at [PAD + n]; zeros around them */
    for (long r = 0; r < step; r++) {
        float *phase = s->phases + (size_t)r * room;
        const long first = floor_divide((long)from - r + step - 1, step),
                   last = floor_divide((long)to - 1 - r, step);
        memset(phase + PAD + first - PAD, 0, PAD * sizeof *phase);
        for (long n = first; n <= last; n++)
            phase[PAD + n] = s->row[c][r + n * step];
        memset(phase + PAD + last + 1, 0, PAD * sizeof *phase);
    }
    memset(out + begin, 0, (size_t)(end - begin) * sizeof *out);
    for (int q = line->low; q <= line->high; q++) {
        const float weight = (float)line->weights[q - line->low];
        const long shift = -line->place - q, n = floor_divide(shift, step), r = shift - n * step;
        const float *restrict in = s->phases + (size_t)r * room + PAD + n;
        for (long p = begin; p < end; p++)
            out[p] += weight * in[p];
    }
}

static void composite(scene *s, size_t row, long begin, long end)
{
    const size_t at = row * s->lattice.dims[0];
    float *restrict light = s->picture[CVOL_PLANE_OPACITY] + at;
    for (int c = 0; c < s->channels; c++) {
        float *restrict colour = s->picture[c] + at;
        const float *restrict added = s->sheet[c];
        for (long p = begin; p < end; p++)
            colour[p] += light[p] * added[p];
    }
    const float *restrict opacity = s->sheet[CVOL_PLANE_OPACITY];
    for (long p = begin; p < end; p++)
        light[p] *= 1 - opacity[p];
}

static void add_slice(scene *s, size_t k)
{
    const slice *of = &s->slices[k];
    const cvol_intermediate_line x = cvol_intermediate_line_make(&s->lattice, &s->shape, 0, k),
                                 y = cvol_intermediate_line_make(&s->lattice, &s->shape, 1, k);
    const long step = (long)s->lattice.step, width = (long)s->lattice.dims[0];
    if (!of->planes[CVOL_PLANE_OPACITY])
        return;
    for (size_t row = 0; row < s->lattice.dims[1]; row++) {
        size_t from, to;
        if (!spread_rows(s, of, &y, (long)row, &from, &to))
            continue;
        long begin = floor_divide((long)from + x.place + x.low + step - 1, step),
             end = floor_divide((long)to - 1 + x.place + x.high, step) + 1;
        const float *light = s->picture[CVOL_PLANE_OPACITY] + row * (size_t)width;
        while (begin < end && light[begin] < MIN_LIGHT)
            begin++;
        while (begin < end && light[end - 1] < MIN_LIGHT)
            end--;
        if (begin >= end)
            continue;
        for (int c = 0; c < CVOL_PLANES; c++)
            if (has_plane(s, c))
                spread_row(s, c, &x, from, to, begin, end);
        composite(s, row, begin, end);
    }
}

static void draw(cvol_context *context, scene *s, cvol_image *image)
{
    const size_t places = s->lattice.dims[0] * s->lattice.dims[1];
    const double background[3] = {0};
    const cvol_splat_plan *plan = &s->setup.plan;
    for (int c = 0; c < s->channels; c++)
        memset(s->picture[c], 0, places * sizeof(float));
    for (size_t i = 0; i < places; i++)
        s->picture[CVOL_PLANE_OPACITY][i] = 1;
    for (size_t n = 0; n < plan->slices; n++)
        add_slice(s, plan->rising ? n : plan->slices - 1 - n);
    float *pixels = need(CVOL_PLANES * places, sizeof *pixels);
    for (size_t i = 0; i < places; i++) {
        for (int c = 0; c < CVOL_PLANE_OPACITY; c++)
            pixels[CVOL_PLANES * i + (size_t)c] = s->picture[c < s->channels ? c : 0][i];
        pixels[CVOL_PLANES * i + CVOL_PLANE_OPACITY] = 1 - s->picture[CVOL_PLANE_OPACITY][i];
    }
    if (cvol_intermediate_grid_warp(context, image, pixels, &s->lattice, plan, background))
        stop(context, "the picture");
    free(pixels);
}

/* ---- the program ----------------------------------------------------------------------------- */

static void allocate(scene *s)
{
    const size_t *dims = s->lattice.dims, step = (size_t)s->lattice.step;
    for (int c = 0; c < CVOL_PLANES; c++)
        if (has_plane(s, c)) {
            s->picture[c] = need(dims[0] * dims[1], sizeof(float));
            s->row[c] = need(s->samples[0], sizeof(float));
            s->sheet[c] = need(dims[0], sizeof(float));
        }
    s->phases = need(step * (s->samples[0] / step + 2 * PAD + 2), sizeof *s->phases);
}

static double cpu_ms(void)
{
    struct timespec t;
    clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &t);
    return 1e3 * (double)t.tv_sec + 1e-6 * (double)t.tv_nsec;
}

int main(int argc, char **argv)
{
    cvol_read_options read = cvol_read_options_defaults();
    cvol_render_options options = cvol_render_options_defaults();
    cvol_context *context = cvol_context_create();
    cvol_volume *volume;
    cvol_transfer *transfer;
    cvol_image *image;
    scene s = {.channels = 0};
    if (argc != 8 ||
        sscanf(argv[2], "%zux%zux%zu", &read.dims[0], &read.dims[1], &read.dims[2]) != 3) {
        fprintf(
            stderr,
            "usage: separable VOLUME.raw NXxNYxNZ TRANSFER.json SIZE FOOTPRINT REPEAT OUT.png\n");
        return 1;
    }
    read.type = CVOL_UINT8;
    if (!context)
        stop(NULL, "context");
    cvol_context_set_threads(context, 1);
    if (cvol_volume_read(context, &volume, argv[1], &read) ||
        cvol_transfer_read(context, &transfer, argv[3]))
        stop(context, argv[1]);
    options.width = options.height = atoi(argv[4]);
    options.splat.size = atoi(argv[5]);
    options.camera.azimuth_deg = 15;
    options.camera.elevation_deg = 20;
    if (cvol_image_create(context, &image, options.width, options.height))
        stop(context, argv[7]);
    classify(context, &s, volume, transfer, &options);
    allocate(&s);
    double least = INFINITY;
    for (int i = 0; i <= atoi(argv[6]); i++) {
        const double start = cpu_ms();
        draw(context, &s, image);
        if (i)
            least = fmin(least, cpu_ms() - start);
    }
    if (cvol_image_write_png(context, image, argv[7]))
        stop(context, argv[7]);
    printf("{\"cpu_ms\": %.3f}\n", least);
    return 0;
}
