/* The gradient's length of a whole array, from all samples: one inverse transform, central
 * differences, one forward transform.
 *
 * The constant term is left out first. It has no gradient, and without it rounding depends on the
 * variation of the samples, not on their size. Beyond its ends the array continues as its transform
 * does: periodic, or (DCT) mirrored, which repeats the last sample. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "array/algebra/operations.h"
#include "array/truncate/account.h"
#include "array/truncate/candidates.h"
#include "array/truncate/producer.h"
#include "array/truncate/truncate.h"
#include "base/context.h"
#include "base/memory.h"
#include "base/thread.h"
#include "transform/fft.h"
#include "transform/whole.h"

/* Adds the squares of the differences along one axis, for the row at `row`, to out[0 .. nx). */
static void add_squares(double *out, const float *samples, const size_t dims[3], size_t row,
                        int axis, int mirrored, double weight)
{
    const size_t n = dims[axis], nx = dims[0];
    const double factor = weight / 2;
    const float *at = samples + row * nx;
    if (axis == 0) {
        for (size_t x = 0; x < nx; x++) {
            const float before = x ? at[x - 1] : mirrored ? at[0] : at[n - 1];
            const float after = x + 1 < n ? at[x + 1] : mirrored ? at[n - 1] : at[0];
            const double d = factor * ((double)after - (double)before);
            out[x] += d * d;
        }
        return;
    }
    const size_t stride = axis == 1 ? 1 : dims[1]; /* in rows */
    const size_t i = row / stride % n, first = row - i * stride;
    const size_t below = i ? i - 1 : mirrored ? 0 : n - 1;
    const size_t above = i + 1 < n ? i + 1 : mirrored ? n - 1 : 0;
    const float *before = samples + (first + below * stride) * nx;
    const float *after = samples + (first + above * stride) * nx;
    for (size_t x = 0; x < nx; x++) {
        const double d = factor * ((double)after[x] - (double)before[x]);
        out[x] += d * d;
    }
}

int cvol_whole_gradient(cvol_context *context, cvol_array *out, cvol_build_result *result,
                        const cvol_array *a, const double weight[3], const cvol_keep *keep)
{
    const size_t *dims = a->grid.dims, N = cvol_grid_samples(&a->grid), nx = dims[0];
    const ptrdiff_t rows = (ptrdiff_t)(dims[1] * dims[2]);
    const int mirrored = a->transform == CVOL_DCT;
    const int threads = cvol_context_threads(context);
    float *samples = cvol_fft_allocate(N), *length = cvol_fft_allocate(N);
    double *lines = cvol_allocate((size_t)threads * nx, sizeof *lines);
    int code = CVOL_OK;
    if (!samples || !length || !lines) {
        code = cvol_fail_memory(context, 2 * N * sizeof *samples, "all samples of a gradient");
        goto done;
    }
    cvol_spectrum_scatter(samples, &a->whole, dims);
    samples[0] = 0;
    double energy = 0, squares = 0;
    for (size_t i = 0; i < N; i++)
        energy += (double)samples[i] * (double)samples[i];
    code = cvol_report_progress(context, "differentiating", 0);
    if (!code)
        code = cvol_whole_inverse(context, a->transform, samples, samples, dims);
    if (code)
        goto done;
#pragma omp parallel for num_threads(threads) schedule(static)
    for (ptrdiff_t row = 0; row < rows; row++) {
        /* Squares leave the float range for values below 1e-19 or above 1e19. */
        double *to = lines + (size_t)cvol_thread_index() * nx;
        memset(to, 0, nx * sizeof *to);
        for (int axis = 0; axis < a->rank; axis++)
            add_squares(to, samples, dims, (size_t)row, axis, mirrored, weight[axis]);
        for (size_t x = 0; x < nx; x++)
            length[(size_t)row * nx + x] = (float)sqrt(to[x]);
    }
    code = cvol_report_progress(context, "differentiating", 0.5);
    if (!code)
        code = cvol_whole_forward(context, a->transform, length, length, dims);
    if (code)
        goto done;
    for (int axis = 0; axis < a->rank; axis++)
        squares += weight[axis] * weight[axis];
    cvol_keep rule = *keep;
    if (rule.rule == CVOL_KEEP_LIKE_INPUTS) {
        rule = cvol_keep_terms(0, a->whole.sparse_count);
        memcpy(rule.low, a->whole.low, sizeof rule.low);
    }
    cvol_candidates candidates = {.slots = length};
    for (int axis = 0; axis < 3; axis++) {
        candidates.low[axis] = mirrored ? dims[axis] : dims[axis] / 2 + 1;
        candidates.box[axis] = dims[axis];
    }
    /* rounding: of the samples, through the differences, and of the lengths, whose norm is no
     * larger */
    *result = (cvol_build_result){.norm = 2 * sqrt(squares * energy), .max_abs = -1};
    code = cvol_truncate(context, out, &result->dropped, &candidates, &rule);
done:
    free(samples);
    free(length);
    free(lines);
    return code;
}
