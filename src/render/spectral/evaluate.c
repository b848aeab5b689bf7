/* Planes on the lattice: spread by the footprint and shifted to the position of their slice.
 *
 * The lattice's places lie at a fraction of a sample of a slice. Footprints are sampled at these
 * places, so the remaining shift is by whole samples: nothing is interpolated, and values within 0
 * .. 1 stay there. Under DFT and DHT that is a kernel with 4 parts (its lines are the sum of a
 * symmetric and an antisymmetric one) and a phase ramp; otherwise a sum over samples. */
#include "render/spectral/evaluate.h"

#include <math.h>
#include <string.h>

#include "base/context.h"
#include "base/memory.h"

/* ---- under DFT and DHT ----------------------------------------------------------------------- */

/* Lines of a kernel: half the sum and half the difference of the weights at q and -q. */
static void split_line(cvol_kernel_line *even, cvol_kernel_line *odd,
                       const cvol_intermediate_line *line)
{
    const int radius = line->high > -line->low ? line->high : -line->low;
    *even = (cvol_kernel_line){.radius = radius};
    *odd = (cvol_kernel_line){.radius = radius, .antisymmetric = 1};
    for (int q = 0; q <= radius; q++) {
        const double right = q <= line->high ? line->weights[q - line->low] : 0;
        const double left = -q >= line->low ? line->weights[-q - line->low] : 0;
        even->taps[q] = (right + left) / 2;
        odd->taps[q] = (right - left) / 2;
    }
    odd->taps[0] = 0;
}

int cvol_plane_reconstruct(cvol_context *context, cvol_array **out, const cvol_compose_job *job,
                           size_t k, int c)
{
    const cvol_keep all = cvol_keep_all();
    const double margin = (double)job->baked->margin;
    cvol_kernel kernel = {.parts = 4, .weight = {1, 1, 1, 1}};
    cvol_kernel_line lines[2][2];
    double shift[3] = {0, 0, 0};
    for (int a = 0; a < 2; a++) {
        const cvol_intermediate_line line = cvol_intermediate_line_make(job->image_grid, job->shape,
                                                                        a, k);
        split_line(&lines[a][0], &lines[a][1], &line);
        shift[a] = (double)line.place - margin;
    }
    for (int part = 0; part < 4; part++) {
        kernel.line[part][0] = lines[0][part & 1];
        kernel.line[part][1] = lines[1][part >> 1];
        kernel.line[part][2] = (cvol_kernel_line){.taps = {1}};
    }
    cvol_array *spread;
    *out = NULL;
    int code = cvol_array_convolve_kernel(context, &spread, job->baked->planes[k][c], &kernel,
                                          &all);
    if (!code)
        code = cvol_array_shift(context, out, spread, shift);
    cvol_array_free(spread);
    return code;
}

/* ---- by samples ------------------------------------------------------------------------------ */

/* The first of `count` samples that reach place p. */
static ptrdiff_t first_sample(const cvol_intermediate_line *line, double step, size_t p)
{
    return (ptrdiff_t)((double)p * step) - line->place - line->high;
}

/* out[p] = sum of the samples n (stride floats apart), each with `width` adjacent floats. */
static void spread_line(float *out, size_t out_stride, const float *in, size_t in_stride,
                        size_t samples, size_t places, size_t width,
                        const cvol_intermediate_line *line, double step)
{
    const int taps = line->high - line->low + 1;
    for (size_t p = 0; p < places; p++) {
        float *to = out + p * out_stride;
        const ptrdiff_t first = first_sample(line, step, p);
        for (size_t x = 0; x < width; x++)
            to[x] = 0;
        for (ptrdiff_t t = 0; t < taps; t++) {
            if (first + t < 0 || first + t >= (ptrdiff_t)samples)
                continue;
            const float weight = (float)line->weights[taps - 1 - t];
            const float *from = in + (size_t)(first + t) * in_stride;
            for (size_t x = 0; x < width; x++)
                to[x] += weight * from[x];
        }
    }
}

static void transpose(float *out, const float *in, size_t rows, size_t columns)
{
    for (size_t y = 0; y < rows; y++)
        for (size_t x = 0; x < columns; x++)
            out[x * rows + y] = in[y * columns + x];
}

/* From samples[0] x samples[1] to dims[0] x dims[1]. work, turned: dims[1] lines of the longer of
 * both. */
static void spread(float *out, float *work, float *turned, const float *in,
                   const cvol_compose_job *job, size_t k)
{
    const cvol_intermediate_grid *image_grid = job->image_grid;
    const size_t *samples = job->baked->samples, *dims = image_grid->dims;
    const cvol_intermediate_line x = cvol_intermediate_line_make(image_grid, job->shape, 0, k);
    const cvol_intermediate_line y = cvol_intermediate_line_make(image_grid, job->shape, 1, k);
    spread_line(work, samples[0], in, samples[0], samples[1], dims[1], samples[0], &y,
                image_grid->step);
    transpose(turned, work, dims[1], samples[0]);
    spread_line(work, dims[1], turned, dims[1], samples[0], dims[0], dims[1], &x, image_grid->step);
    transpose(out, work, dims[0], dims[1]);
}

static int evaluate_samples(cvol_context *context, float *out, const cvol_compose_job *job,
                            const cvol_array *plane, size_t k)
{
    const size_t *samples = job->baked->samples, *dims = job->image_grid->dims;
    const size_t wide = samples[0] > dims[0] ? samples[0] : dims[0];
    const size_t begin[3] = {0, 0, 0}, end[3] = {samples[0], samples[1], 1};
    float *in = cvol_allocate(samples[0] * samples[1], sizeof *in);
    float *work = cvol_allocate(2 * dims[1] * wide, sizeof *work);
    int code = in && work ? cvol_array_evaluate_real(context, in, plane, begin, end)
                          : cvol_fail_memory(context, 2 * dims[1] * wide * sizeof *work, "a slice");
    if (!code)
        spread(out, work, work + dims[1] * wide, in, job, k);
    free(in);
    free(work);
    return code;
}

int cvol_plane_evaluate(cvol_context *context, float *out, const cvol_compose_job *job, size_t k,
                        int c)
{
    const cvol_array *plane = job->baked->planes[k][c];
    const size_t points[3] = {job->image_grid->dims[0], job->image_grid->dims[1], 1};
    if (!job->baked->margin)
        return evaluate_samples(context, out, job, plane, k);
    cvol_array *moved;
    int code = cvol_plane_reconstruct(context, &moved, job, k, c);
    if (!code)
        code = cvol_array_evaluate_grid(context, out, moved, points);
    cvol_array_free(moved);
    return code;
}

void cvol_planes_correct_opacity(float *const planes[CVOL_PLANES], int channels, size_t places,
                                 double power)
{
    float *D = planes[CVOL_PLANE_OPACITY];
    for (size_t i = 0; i < places; i++) {
        if (!(D[i] > 1e-6f))
            continue;
        const float corrected = 1 - powf(1 - fminf(D[i], 1), (float)power);
        const float gain = corrected / D[i];
        for (int c = 0; c < channels; c++)
            planes[c][i] *= gain;
        D[i] = corrected;
    }
}
