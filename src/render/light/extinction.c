/* Extinction of cells (extinction.h). */
#include "render/light/extinction.h"

#include <math.h>
#include <stdlib.h>

#include "base/context.h"
#include "base/memory.h"
#include "render/view/camera.h"

#define BINS 2048
/* The extinction of matter that hides everything behind one mean spacing. */
#define OPAQUE 6.0
/* In grey modes: the extinction of white. */
#define WHITE 0.05

/* The integral of the extinction over values, from `from` to the start of each bin. */
typedef struct absorption {
    double from, width;
    double *integral; /* BINS + 1 */
} absorption;

static double extinction_at(const cvol_transfer *transfer, const cvol_render_options *options,
                            const double range[2], double value)
{
    if (options->mode == CVOL_MODE_ISO)
        return value >= options->surface.value ? OPAQUE : 0;
    if (options->mode == CVOL_MODE_COMPOSITE) {
        const double opacity = cvol_transfer_at(transfer, value).opacity;
        return opacity < 1 ? fmin(-log1p(-opacity), OPAQUE) : OPAQUE;
    }
    const int has_window = options->window[1] > options->window[0];
    const double black = has_window ? options->window[0] : range[0],
                 white = has_window ? options->window[1] : range[1];
    const double level = white > black ? fmin(fmax((value - black) / (white - black), 0), 1) : 0;
    return WHITE * (options->mode == CVOL_MODE_MIN ? 1 - level : level);
}

static void find_range(double range[2], const cvol_coarse *coarse)
{
    const size_t count = cvol_coarse_count(coarse);
    range[0] = range[1] = cvol_coarse_value(coarse, 0);
    for (size_t i = 1; i < count; i++) {
        const double v = cvol_coarse_value(coarse, i);
        range[0] = v < range[0] ? v : range[0];
        range[1] = v > range[1] ? v : range[1];
    }
}

/* Four points per bin, so that jumps are near their places. */
static void integrate(absorption *a, const double range[2], const cvol_transfer *transfer,
                      const cvol_render_options *options)
{
    enum { POINTS = 4 };
    a->from = range[0];
    a->width = (range[1] - range[0]) / BINS;
    a->integral[0] = 0;
    for (int i = 0; i < BINS; i++) {
        double sum = 0;
        for (int k = 0; k < POINTS; k++)
            sum += extinction_at(transfer, options, range,
                                 a->from + (i + (k + 0.5) / POINTS) * a->width);
        a->integral[i + 1] = a->integral[i] + sum / POINTS * a->width;
    }
}

static double integral_to(const absorption *a, double value)
{
    const double at = fmin(fmax((value - a->from) / a->width, 0), BINS);
    const int bin = at < BINS ? (int)at : BINS - 1;
    return a->integral[bin] + (at - bin) * (a->integral[bin + 1] - a->integral[bin]);
}

/* The mean over values a .. b. */
static double mean_between(const absorption *of, double a, double b)
{
    const double least = fmax(b - a, of->width), middle = (a + b) / 2;
    const double from = fmax(middle - least / 2, of->from),
                 to = fmin(middle + least / 2, of->from + BINS * of->width);
    return to > from ? (integral_to(of, to) - integral_to(of, from)) / (to - from) : 0;
}

/* 1 if the middle of a cell is in the drawn part. */
static int is_drawn(const cvol_coarse *coarse, const cvol_grid *grid, const cvol_clip *clip,
                    const size_t cell[3])
{
    double place[3];
    for (int a = 0; a < 3; a++)
        place[a] = coarse->first[a] + (double)cell[a] * coarse->pitch[a];
    return cvol_clip_shows(clip, grid, place);
}

/* The cells of a row along x. */
static void find_row(float *out, const absorption *of, const cvol_coarse *coarse,
                     const cvol_grid *grid, const cvol_clip *clip, size_t y, size_t z)
{
    const size_t *n = coarse->dims, first = n[0] * (y + n[1] * z);
    const size_t apart[3] = {1, n[0], n[0] * n[1]};
    const int is_clipped = clip->axes || clip->planes;
    for (size_t x = 0; x < n[0]; x++) {
        const size_t cell[3] = {x, y, z}, i = first + x;
        const double v = cvol_coarse_value(coarse, i);
        double least = v, most = v;
        for (int a = 0; a < 3; a++)
            for (int side = 0; side < 2; side++) {
                if (side ? cell[a] + 1 >= n[a] : cell[a] == 0)
                    continue;
                const size_t j = side ? i + apart[a] : i - apart[a];
                if (coarse->cover && !(coarse->cover[j] > 0))
                    continue;
                const double between = (v + cvol_coarse_value(coarse, j)) / 2;
                least = between < least ? between : least;
                most = between > most ? between : most;
            }
        const double cover = coarse->cover ? (double)coarse->cover[i] : 1;
        out[i] = is_clipped && !is_drawn(coarse, grid, clip, cell)
                     ? 0
                     : (float)(cover * mean_between(of, least, most));
    }
}

int cvol_extinction_find(cvol_context *context, float *out, const cvol_coarse *coarse,
                         const cvol_grid *grid, const cvol_transfer *transfer,
                         const cvol_render_options *options)
{
    const size_t rows = coarse->dims[1] * coarse->dims[2];
    absorption a = {.integral = cvol_allocate(BINS + 1, sizeof(double))};
    double range[2];
    if (!a.integral)
        return cvol_fail_memory(context, (BINS + 1) * sizeof(double), "a table of extinction");
    find_range(range, coarse);
    if (!(range[1] > range[0])) { /* one value */
        const double margin = fmax(fabs(range[0]), 1) * 1e-6;
        range[0] -= margin;
        range[1] += margin;
    }
    integrate(&a, range, transfer, options);
#pragma omp parallel for num_threads(cvol_context_threads(context))
    for (size_t i = 0; i < rows; i++)
        find_row(out, &a, coarse, grid, &options->clip, i % coarse->dims[1], i / coarse->dims[1]);
    free(a.integral);
    return CVOL_OK;
}
