/* Compressing samples as a whole array: one transform of all of them, and truncation. */
#include <float.h>
#include <math.h>
#include <stdlib.h>

#include "array/core/level.h"
#include "array/truncate/account.h"
#include "array/truncate/candidates.h"
#include "array/truncate/compress_array.h"
#include "array/truncate/producer.h"
#include "array/truncate/truncate.h"
#include "base/context.h"
#include "base/memory.h"
#include "transform/fft.h"
#include "transform/whole.h"

/* The L2 norm, the same for any number of threads. */
static double norm_of(cvol_context *context, const float *values, size_t n)
{
    const size_t parts = cvol_parts_of(n);
    double sums[16], sum = 0;
#pragma omp parallel for schedule(static, 1) num_threads(cvol_context_threads(context))
    for (size_t p = 0; p < parts; p++) {
        const size_t begin = cvol_part_begin(n, p, parts);
        sums[p] = cvol_sum_squares(values + begin, cvol_part_begin(n, p + 1, parts) - begin);
    }
    for (size_t p = 0; p < parts; p++)
        sum += sums[p];
    return sqrt(sum);
}

int cvol_whole_compress(cvol_context *context, cvol_array *out, cvol_build_result *result,
                        const void *samples, const cvol_keep *keep)
{
    const size_t *dims = out->grid.dims, n = cvol_grid_samples(&out->grid),
                 parts = cvol_parts_of(n);
    *result = (cvol_build_result){.max_abs = -1};
    float *slots = cvol_fft_allocate(n);
    if (!slots)
        return cvol_fail_memory(context, n * sizeof *slots, "the samples as floats");
    int code = cvol_report_progress(context, "transforming", 0);
    if (code)
        goto done;
#pragma omp parallel for schedule(static, 1) num_threads(cvol_context_threads(context))
    for (size_t p = 0; p < parts; p++) {
        const size_t begin = cvol_part_begin(n, p, parts);
        cvol_samples_load(slots + begin, samples, out->grid.type, begin,
                          cvol_part_begin(n, p + 1, parts) - begin, 0);
    }
    code = cvol_whole_forward(context, out->transform, slots, slots, dims);
    if (!code)
        code = cvol_report_progress(context, "keeping", 0.7);
    if (code)
        goto done;
    result->norm = norm_of(context, slots, n);
    cvol_candidates candidates = {.slots = slots};
    for (int a = 0; a < 3; a++) {
        candidates.low[a] = out->transform == CVOL_DCT ? dims[a] : dims[a] / 2 + 1;
        candidates.box[a] = dims[a];
    }
    code = cvol_truncate(context, out, &result->dropped, &candidates, keep);
    if (!code)
        code = cvol_report_progress(context, "keeping", 1);
done:
    free(slots);
    return code;
}
