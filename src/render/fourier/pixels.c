/* Pixels from sums along rays: the intervals of rays in the volume, and the divisors of the
 * sums. */
#include "render/fourier/pixels.h"

#include <math.h>
#include <string.h>

#include "base/context.h"
#include "base/memory.h"

/* The number of neighbours below a place. */
#define BELOW (CVOL_FOURIER_TAPS / 2 - 1)

/* ---- intervals of rays in the volume --------------------------------------------------------- */

cvol_fourier_rays cvol_fourier_rays_make(const cvol_grid *grid, const cvol_view *view)
{
    cvol_fourier_rays rays = {0};
    for (int a = 0; a < 3; a++) {
        const double thick = grid->dims[a] > 1 ? view->extent[a] : grid->spacing[a];
        const double eye = view->eye[a];
        rays.moves[a] = fabs(eye) > 1e-9;
        const double over = rays.moves[a] ? -1 / eye : 1;
        rays.mid_x[a] = view->right[a] * over;
        rays.mid_y[a] = view->up[a] * over;
        /* rays along a face are inside */
        rays.half[a] = thick / 2 * (rays.moves[a] ? fabs(over) : 1 + 1e-9);
    }
    return rays;
}

/* The interval of t (towards the eye, from the plane through the middle) in which the rays of a row
 * of pixels are within the volume; near < far if it is not empty. */
static void meet(float *far, float *near, const cvol_fourier_rays *rays, double x0, double step,
                 double y, int count)
{
    for (int i = 0; i < count; i++) {
        far[i] = -INFINITY;
        near[i] = INFINITY;
    }
    for (int a = 0; a < 3; a++) {
        const float start = (float)(rays->mid_x[a] * x0 + rays->mid_y[a] * y);
        const float rise = (float)(rays->mid_x[a] * step), half = (float)rays->half[a];
        if (rays->moves[a])
            for (int i = 0; i < count; i++) {
                const float middle = start + (float)i * rise;
                far[i] = far[i] > middle - half ? far[i] : middle - half;
                near[i] = near[i] < middle + half ? near[i] : middle + half;
            }
        else
            for (int i = 0; i < count; i++)
                near[i] = fabsf(start + (float)i * rise) <= half ? near[i] : -INFINITY;
    }
}

/* ---- pixels ---------------------------------------------------------------------------------- */

/* The position of pixel x on the lattice. */
static double column_at(const cvol_fourier_pixels *job, int i)
{
    const cvol_fourier_slice_grid *slice_grid = &job->planes->slice_grid;
    return ((i + 0.5 - job->view->width / 2.0) * job->view->pixel + slice_grid->middle[0]) /
               slice_grid->space +
           slice_grid->shift[0];
}

int cvol_fourier_pixels_prepare(cvol_context *context, cvol_fourier_pixels *job)
{
    const cvol_fourier_slice_grid *slice_grid = &job->planes->slice_grid;
    const size_t width = (size_t)job->view->width;
    if (slice_grid->aligned)
        return CVOL_OK;
    job->cell = cvol_allocate(width, sizeof *job->cell);
    job->weights = cvol_allocate(width, sizeof *job->weights);
    if (!job->cell || !job->weights)
        return cvol_fail_memory(context, width * 24, "weights of pixels");
    for (int i = 0; i < job->view->width; i++) {
        const double at = column_at(job, i), cell = floor(at);
        /* far outside, any position will do */
        job->cell[i] = cell > -1e9 && cell < 1e9 ? (ptrdiff_t)cell - BELOW : -1000000000;
        cvol_fourier_kernel_weigh(job->weights[i], job->kernel, at - cell);
    }
    return CVOL_OK;
}

static int within(ptrdiff_t at, size_t count)
{
    return at >= 0 && (size_t)at < count;
}

/* A row of pixels of a plane; 0 beyond it. `line` has room for a row of the plane. */
static void sample_row(float *out, float *line, const float *plane, const cvol_fourier_pixels *job,
                       int j)
{
    const cvol_fourier_slice_grid *slice_grid = &job->planes->slice_grid;
    const size_t *n = slice_grid->dims;
    const int width = job->view->width;
    memset(out, 0, (size_t)width * sizeof *out);
    if (slice_grid->aligned) {
        const ptrdiff_t row = slice_grid->first[1] + job->view->height - 1 - j;
        ptrdiff_t from = slice_grid->first[0] < 0 ? -slice_grid->first[0] : 0;
        ptrdiff_t end = (ptrdiff_t)n[0] - slice_grid->first[0] < width
                            ? (ptrdiff_t)n[0] - slice_grid->first[0]
                            : width;
        if (within(row, n[1]) && from < end)
            memcpy(out + from, plane + (size_t)row * n[0] + slice_grid->first[0] + from,
                   (size_t)(end - from) * sizeof *out);
        return;
    }
    const double above = (job->view->height / 2.0 - j - 0.5) * job->view->pixel;
    const double y = (above + slice_grid->middle[1]) / slice_grid->space + slice_grid->shift[1];
    if (!(y > -CVOL_FOURIER_TAPS && y < (double)n[1] + CVOL_FOURIER_TAPS))
        return;
    const ptrdiff_t cell = (ptrdiff_t)floor(y) - BELOW;
    float weights[CVOL_FOURIER_TAPS];
    cvol_fourier_kernel_weigh(weights, job->kernel, y - floor(y));
    memset(line, 0, n[0] * sizeof *line);
    for (int k = 0; k < CVOL_FOURIER_TAPS; k++)
        if (within(cell + k, n[1])) {
            const float *from = plane + (size_t)(cell + k) * n[0];
            for (size_t i = 0; i < n[0]; i++)
                line[i] += weights[k] * from[i];
        }
    for (int i = 0; i < width; i++)
        for (int k = 0; k < CVOL_FOURIER_TAPS; k++)
            if (within(job->cell[i] + k, n[0]))
                out[i] += job->weights[i][k] * line[job->cell[i] + k];
}

void cvol_fourier_pixels_row(float *out, float *scratch, const cvol_fourier_pixels *job, int j)
{
    const cvol_view *view = job->view;
    const int width = view->width;
    const size_t w = (size_t)width;
    float *sum = scratch, *weight = scratch + w, *far = weight + w, *near = far + w;
    float *line = near + w;
    sample_row(sum, line, job->planes->sums, job, j);
    sample_row(weight, line, job->planes->weights, job, j);
    const double *middle = job->planes->slice_grid.middle;
    const double x = (0.5 - width / 2.0) * view->pixel + middle[0];
    const double y = (view->height / 2.0 - j - 0.5) * view->pixel + middle[1];
    meet(far, near, &job->rays, x, view->pixel, y, width);
    const float base = (float)(job->volume->base + (job->integrals ? job->source.offset : 0)),
                above = (float)(job->volume->base - job->source.min);
    const float min = (float)job->source.min, max = (float)job->source.max;
    const float least = (float)job->floor;
    const float cue_near = (float)job->cue.near, slope = (float)job->cue.slope;
    const int cued = slope > 0, masked = job->volume->masked;
    for (int i = 0; i < width; i++) {
        const float length = near[i] - far[i];
        const int there = length > 0 && (!masked || weight[i] > least);
        const float mean = sum[i] * weight[i] / (weight[i] * weight[i] + least * least);
        const float share = cue_near + (there ? slope * 0.5f * (near[i] + far[i]) : 0);
        if (job->integrals) {
            /* linear in the samples, so that nothing is lost at the outline */
            out[i] = sum[i] + base * weight[i] * share;
            continue;
        }
        const float value = cued ? min + mean + above * share : base + mean;
        /* a mean lies within the range of the samples */
        out[i] = !there ? NAN : value > min ? (value < max ? value : max) : min;
    }
}

size_t cvol_fourier_pixels_scratch(const cvol_fourier_pixels *job)
{
    return 5 * (size_t)job->view->width + job->planes->slice_grid.dims[0] + 16;
}

void cvol_fourier_pixels_free(cvol_fourier_pixels *job)
{
    free(job->cell);
    free(job->weights);
}
