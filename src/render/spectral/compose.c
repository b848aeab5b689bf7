/* From slices to a picture on the lattice: the choice of the loop, and the sum of its errors. */
#include "render/spectral/compose.h"

#include <math.h>

#include "base/context.h"
#include "base/memory.h"

/* ---- errors ---------------------------------------------------------------------------------- */

double cvol_error_norm(const double errors[CVOL_PLANES], int channels)
{
    if (channels == 1)
        return sqrt(3) * errors[0];
    return sqrt(errors[0] * errors[0] + errors[1] * errors[1] + errors[2] * errors[2]);
}

cvol_slice_bounds cvol_slice_bounds_of(const cvol_compose_job *job, size_t k)
{
    cvol_slice_bounds out;
    for (int c = 0; c < CVOL_PLANES; c++) {
        cvol_array_info info = {0};
        if (job->baked->planes[k][c])
            cvol_array_get_info(&info, job->baked->planes[k][c]);
        out.errors[c] = job->norm * info.l2_error;
        out.most[c] = 1;
    }
    return out;
}

/* The exact opacities are within 0 .. 1, the exact intensities within 0 .. L = CVOL_BRIGHTEST, and
 *
 *     |T C - T~ C~| <= |C - C~| + max|C~| |T - T~|          front to back, T = 1 - A
 *     |(1 - D) I - (1 - D~) I~| <= max|1 - D~| |I - I~| + L |D - D~|
 *
 * and opacity is 1 - (1 - A)(1 - D) in both. */
void cvol_compose_errors(double errors[CVOL_PLANES], const cvol_slice_bounds *slice, int front)
{
    const double A = errors[CVOL_PLANE_OPACITY], D = slice->errors[CVOL_PLANE_OPACITY];
    const double transmittance = slice->most[CVOL_PLANE_OPACITY];
    for (int c = 0; c < CVOL_PLANE_OPACITY; c++)
        errors[c] = slice->errors[c] +
                    (front ? errors[c] + slice->most[c] * A
                           : transmittance * errors[c] + (double)CVOL_BRIGHTEST * D);
    errors[CVOL_PLANE_OPACITY] = transmittance * A + D;
}

/* The second line above, for all slices: |I - I~| <= sum T~ (|C - C~| + L |D - D~|). Without
 * truncation in between, both orders compute the same. */
void cvol_compose_visible_errors(double errors[CVOL_PLANES], const cvol_slice_bounds *slice,
                                 double transmittance)
{
    const double D = slice->errors[CVOL_PLANE_OPACITY];
    for (int c = 0; c < CVOL_PLANE_OPACITY; c++)
        errors[c] += transmittance * (slice->errors[c] + (double)CVOL_BRIGHTEST * D);
    errors[CVOL_PLANE_OPACITY] += transmittance * D;
}

/* The largest possible error of the picture: the exact intensities are within 0 .. L. */
static double most_error(const cvol_composed *out, int channels, size_t places)
{
    const double L = (double)CVOL_BRIGHTEST;
    double errors[CVOL_PLANES] = {0};
    for (int c = 0; c < channels; c++) {
        double sum = 0;
        for (size_t i = 0; i < places; i++) {
            const double value = (double)out->planes[c][i], far = fmax(value, L - value);
            sum += far * far;
        }
        errors[c] = sqrt(sum);
    }
    return cvol_error_norm(errors, channels);
}

/* ---- counts ---------------------------------------------------------------------------------- */

uint64_t cvol_transform_multiply_adds(size_t n, int tile)
{
    return (uint64_t)((double)n * (tile ? 2.0 * tile : log2(fmax((double)n, 2))));
}

uint64_t cvol_plane_multiply_adds(const cvol_compose_job *job)
{
    const size_t *samples = job->baked->samples, *dims = job->image_grid->dims;
    const uint64_t taps = (uint64_t)(job->shape->ux * job->shape->size);
    if (job->baked->margin) /* four parts of the kernel, and the phase ramp, on complex numbers */
        return 5 * 4 * (uint64_t)(dims[0] * dims[1]) +
               cvol_transform_multiply_adds(dims[0] * dims[1], 0);
    return cvol_transform_multiply_adds(samples[0] * samples[1], job->baked->tile) +
           taps * (uint64_t)(dims[1] * (samples[0] + dims[0]));
}

/* ---- both ----------------------------------------------------------------------------------- */

int cvol_compose(cvol_context *context, cvol_composed *out, const cvol_baked *baked,
                 const cvol_intermediate_grid *image_grid, const cvol_footprint_shape *shape,
                 double distance, int rising, int front, const cvol_transform_options *options)
{
    const size_t places = image_grid->dims[0] * image_grid->dims[1];
    *out = (cvol_composed){0};
    if (baked->margin && !cvol_intermediate_grid_same(&baked->image_grid, image_grid))
        return cvol_fail(context, CVOL_ERROR_ARGUMENT,
                         "whole slices under %s serve the direction they were made for only",
                         cvol_transform_name(baked->transform));
    const double power = distance / baked->distance;
    const cvol_compose_job job = {.baked = baked,
                                  .image_grid = image_grid,
                                  .shape = shape,
                                  .power = fabs(power - 1) < 1e-6 ? 1 : power,
                                  .norm = cvol_intermediate_grid_norm(image_grid, shape),
                                  .rising = rising,
                                  .front = front};
    for (int c = 0; c < CVOL_PLANES; c++)
        if ((c < baked->channels || c == CVOL_PLANE_OPACITY) &&
            !(out->planes[c] = cvol_allocate_zero(places, sizeof(float)))) {
            cvol_composed_free(out);
            return cvol_fail_memory(context, places * sizeof(float), "a picture");
        }
    const int code = options->schedule == CVOL_SCHEDULE_LITERAL
                         ? cvol_compose_literal(context, out, &job, options)
                     : baked->tile ? cvol_compose_tiles(context, out, &job)
                                   : cvol_compose_whole(context, out, &job);
    /* the exact values of a sinc leave 0 .. 1 */
    out->certified = shape->kind != CVOL_FOOTPRINT_SINC && job.power == 1;
    if (!code && out->certified) {
        const double most = most_error(out, baked->channels, places);
        out->is_useful = out->bound < most;
        out->bound = fmin(out->bound, most);
    }
    if (code)
        cvol_composed_free(out);
    return code;
}

void cvol_composed_free(cvol_composed *composed)
{
    for (int c = 0; c < CVOL_PLANES; c++) {
        free(composed->planes[c]);
        cvol_array_free(composed->arrays[c]);
    }
    *composed = (cvol_composed){0};
}
