/* Makes and measures the residual of all bricks. */
#include "codec/residual/make_residual.h"

#include <limits.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "array/block/exact.h"
#include "base/context.h"
#include "base/elementary.h"
#include "base/for_type.h"
#include "base/memory.h"

enum { BRICK_SAMPLES = CVOL_BRICK_SIDE * CVOL_BRICK_SIDE * CVOL_BRICK_SIDE, CHUNK = 64 };

/* ---- start ------------------------------------------------------------------------------ */

int cvol_residual_job_start(cvol_residual_job *out, const cvol_array *array, const void *samples,
                            double bound)
{
    int grain = INT_MAX;
    double largest = 0;
    const size_t *dims = array->grid.dims, slice = dims[0] * dims[1];
    const size_t size = cvol_type_size(array->grid.type);
    *out = (cvol_residual_job){.array = array, .samples = samples, .bound = bound};
    out->fraction = cvol_exact_fraction(cvol_exact_largest_sum(array));
    if (out->fraction < 0)
        return CVOL_ERROR_TARGET;
    uint8_t *which = array->mask ? cvol_allocate(slice, 1) : NULL;
    if (array->mask && !which)
        return CVOL_ERROR_MEMORY;
    for (size_t z = 0; z < dims[2]; z++) {
        const size_t begin[3] = {0, 0, z}, end[3] = {dims[0], dims[1], z + 1};
        if (which)
            cvol_mask_get(which, array->mask, begin, end);
        cvol_residual_scan(&grain, &largest, array->grid.type,
                           (const uint8_t *)samples + size * slice * z, which, slice);
    }
    free(which);
    out->rule = cvol_residual_rule_for(array->grid.type, bound, array->step,
                                       array->error_bound.value_min, array->error_bound.value_max,
                                       grain, largest);
    return CVOL_OK;
}

/* ---- bricks ----------------------------------------------------------------------------- */

/* One thread's memory. */
typedef struct work {
    cvol_residual_coder *coder;
    cvol_token_counts *counts;
    double *base, *scratch;
    size_t scratch_count;
    uint8_t *samples, *which;
} work;

static void work_free(work *w)
{
    cvol_residual_coder_free(w->coder);
    free(w->counts);
    free(w->base);
    free(w->scratch);
    free(w->samples);
    free(w->which);
}

static int work_make(work *w)
{
    *w = (work){.coder = cvol_residual_coder_create()};
    w->counts = cvol_allocate_zero(1, sizeof *w->counts);
    w->base = cvol_allocate(BRICK_SAMPLES, sizeof *w->base);
    w->samples = cvol_allocate(BRICK_SAMPLES, sizeof(double));
    w->which = cvol_allocate(BRICK_SAMPLES, 1);
    return w->coder && w->counts && w->base && w->samples && w->which;
}

static void gather(uint8_t *to, const cvol_residual_job *job, const cvol_box *box)
{
    const size_t *dims = job->array->grid.dims, size = cvol_type_size(job->array->grid.type);
    const size_t line = size * (box->end[0] - box->begin[0]);
    for (size_t z = box->begin[2]; z < box->end[2]; z++)
        for (size_t y = box->begin[1]; y < box->end[1]; y++, to += line)
            memcpy(to,
                   (const uint8_t *)job->samples +
                       size * (box->begin[0] + dims[0] * (y + dims[1] * z)),
                   line);
}

static int do_brick(work *w, const cvol_residual_job *job, size_t index, cvol_bytes *out)
{
    const cvol_array *array = job->array;
    const cvol_box box = cvol_brick_samples_of(array, index);
    const size_t scratch = cvol_exact_scratch(array, box.begin, box.end);
    cvol_residual_brick brick = {.base = w->base};
    for (int a = 0; a < 3; a++)
        brick.size[a] = box.end[a] - box.begin[a];
    if (scratch > w->scratch_count || !w->scratch) {
        free(w->scratch);
        w->scratch = cvol_allocate(scratch, sizeof *w->scratch);
        w->scratch_count = w->scratch ? scratch : 0;
    }
    if (!scratch || !w->scratch)
        return CVOL_ERROR_MEMORY;
    if (array->mask && cvol_mask_get(w->which, array->mask, box.begin, box.end))
        brick.which = w->which;
    gather(w->samples, job, &box);
    cvol_exact_box(w->base, w->scratch, array, job->fraction, box.begin, box.end);
    return cvol_residual_encode(w->coder, out, &job->rule, job->bound, job->tables, w->samples,
                                &brick, w->counts);
}

static void do_chunk(work *works, int threads, const cvol_residual_job *job, size_t first,
                     size_t count, cvol_bytes *out, int *codes)
{
#pragma omp parallel num_threads(threads)
    {
        work *own = NULL;
#pragma omp for schedule(static, 1)
        for (int i = 0; i < threads; i++)
            own = &works[i];
#pragma omp for schedule(dynamic)
        for (size_t i = 0; i < count; i++)
            codes[i] = do_brick(own, job, first + i, &out[i]);
    }
}

int cvol_residual_job_run(cvol_context *context, const cvol_residual_job *job,
                          cvol_token_counts *counts, uint64_t *bytes, cvol_residual_data *kept)
{
    const int threads = cvol_context_threads(context);
    const size_t bricks = cvol_brick_count(job->array);
    work *works = calloc((size_t)threads, sizeof *works);
    cvol_bytes out[CHUNK] = {{0}};
    int code = CVOL_OK, made = works != NULL;
    for (int i = 0; i < threads && made; i++)
        made = work_make(&works[i]);
    if (!made)
        code = cvol_fail_memory(context, (size_t)threads << 22, "the residual");
    if (bytes)
        *bytes = 0;
    for (size_t first = 0; first < bricks && !code; first += CHUNK) {
        const size_t count = bricks - first < CHUNK ? bricks - first : CHUNK;
        int codes[CHUNK] = {0};
        do_chunk(works, threads, job, first, count, out, codes);
        for (size_t i = 0; i < count && !code; i++) {
            code = codes[i];
            if (bytes)
                *bytes += out[i].size;
            if (!code && kept)
                code = cvol_residual_append(context, kept, (cvol_span){out[i].data, out[i].size});
            else if (code == CVOL_ERROR_MEMORY)
                cvol_fail_memory(context, BRICK_SAMPLES, "a brick");
        }
        if (!code)
            code = cvol_report_progress(context, "coding the residual",
                                        (double)(first + count) / (double)bricks);
    }
    for (int i = 0; works && i < threads; i++) {
        for (int r = 0; counts && works[i].counts && r < CVOL_ROWS; r++)
            for (int t = 0; t < CVOL_TOKENS; t++)
                counts->of[r][t] += works[i].counts->of[r][t];
        work_free(&works[i]);
    }
    free(works);
    for (int i = 0; i < CHUNK; i++)
        cvol_bytes_free(&out[i]);
    return code;
}

/* ---- measuring -------------------------------------------------------------------------- */

/* The errors of one slice. */
typedef struct slice_sum {
    double squares, most;
    double real_squares, real_most; /* of samples as floats (cvol_array_evaluate_real) */
    size_t counted;
    int same;
} slice_sum;

static slice_sum compare_slice(cvol_type type, const void *exact, const void *decoded,
                               const uint8_t *which, size_t at, size_t count)
{
    const size_t size = cvol_type_size(type);
    slice_sum sum = {.same = !memcmp((const uint8_t *)exact + size * at,
                                     (const uint8_t *)decoded + size * at, size * count)};
#define COMPARE(t)                                                   \
    for (size_t i = 0; i < count; i++) {                             \
        const double before = (double)((const t *)exact)[at + i];    \
        const t after = ((const t *)decoded)[at + i];                \
        const double error = fabs((double)after - before);           \
        const double real = fabs((double)(float)after - before);     \
        if (which && which[at + i])                                  \
            continue;                                                \
        sum.squares += error * error;                                \
        sum.real_squares += real * real;                             \
        sum.real_most = real > sum.real_most ? real : sum.real_most; \
        sum.most = error > sum.most ? error : sum.most;              \
        sum.counted++;                                               \
    }
    CVOL_FOR_TYPE(type, COMPARE);
#undef COMPARE
    return sum;
}

/* The bounds hold for the terms and for the samples as they are stored. */
static void include_error(cvol_error_bound *error_bound, double l2, double most)
{
    error_bound->point_error = fmax(cvol_error_bound_point(error_bound),
                                    most * (1 + CVOL_ROUNDING));
    error_bound->l2_error = fmax(error_bound->l2_error, l2 * (1 + CVOL_ROUNDING));
}

int cvol_measure_stored(cvol_context *context, cvol_array *array, const void *samples, int *same)
{
    const size_t *dims = array->grid.dims, slice = dims[0] * dims[1];
    const size_t size = cvol_type_size(array->grid.type);
    const size_t slab = dims[2] < CVOL_BRICK_SIDE ? dims[2] : CVOL_BRICK_SIDE;
    uint8_t *decoded = cvol_allocate(slice * slab, size), *which = cvol_allocate(slice * slab, 1);
    double squares = 0, real_squares = 0, real_most = 0, most = 0, counted = 0;
    int code = decoded && which ? CVOL_OK
                                : cvol_fail_memory(context, slice * slab * size, "decoded samples");
    *same = 1;
    for (size_t z = 0; z < dims[2] && !code; z += slab) {
        const size_t begin[3] = {0, 0, z};
        const size_t end[3] = {dims[0], dims[1], dims[2] - z < slab ? dims[2] : z + slab};
        slice_sum sums[CVOL_BRICK_SIDE];
        code = cvol_array_evaluate_box(context, decoded, array, begin, end);
        if (code)
            break;
        if (array->mask)
            cvol_mask_get(which, array->mask, begin, end);
        const uint8_t *exact = (const uint8_t *)samples + size * slice * z;
#pragma omp parallel for schedule(static) num_threads(cvol_context_threads(context))
        for (size_t i = 0; i < end[2] - z; i++)
            sums[i] = compare_slice(array->grid.type, exact, decoded, array->mask ? which : NULL,
                                    slice * i, slice);
        for (size_t i = 0; i < end[2] - z; i++) {
            squares += sums[i].squares;
            real_squares += sums[i].real_squares;
            real_most = fmax(real_most, sums[i].real_most);
            most = fmax(most, sums[i].most);
            counted += (double)sums[i].counted;
            *same &= sums[i].same;
        }
    }
    free(decoded);
    free(which);
    if (code)
        return code;
    const double span = array->error_bound.value_max - array->error_bound.value_min;
    array->measured = 1;
    array->max_error = most;
    const double norm = cvol_norm_of_squares(squares, most, counted);
    array->psnr_db = norm > 0 ? 20 * cvol_log10(span * sqrt(counted) / norm) : (double)INFINITY;
    if (isfinite(real_most)) /* floats of samples beyond their range are infinite */
        include_error(&array->error_bound, cvol_norm_of_squares(real_squares, real_most, counted),
                      real_most);
    return CVOL_OK;
}
