/* The deferred schedule with whole planes: slices are evaluated, and composited as samples. */
#include <math.h>
#include <string.h>

#include "base/context.h"
#include "base/memory.h"
#include "render/spectral/evaluate.h"

/* Slices that are evaluated together. */
typedef struct evaluated {
    float *planes[CVOL_PLANES];
    cvol_slice_bounds bounds;
    int code, empty;
    cvol_context context;
} evaluated;

/* The largest |from - sample|. Samples above 1 cannot be exact, and are clamped. Samples below 0
 * cannot be exact either, but stay: in the sum over slices they compensate for truncation errors of
 * the other sign next to them. (Clamped at 0, truncation's noise would have a mean, and the picture
 * a haze.) */
static double cut(float *plane, size_t places, float from)
{
    float most = 0;
    for (size_t i = 0; i < places; i++) {
        plane[i] = plane[i] < 1 ? plane[i] : 1;
        most = fmaxf(most, fabsf(from - plane[i]));
    }
    return (double)most;
}

static void evaluate_slice(evaluated *to, const cvol_compose_job *job, size_t k)
{
    const size_t places = job->image_grid->dims[0] * job->image_grid->dims[1];
    to->empty = !cvol_compose_has(job, k);
    to->code = CVOL_OK;
    to->bounds = cvol_slice_bounds_of(job, k);
    for (int c = 0; c < CVOL_PLANES && !to->empty && !to->code; c++)
        if (to->planes[c])
            to->code = cvol_plane_evaluate(&to->context, to->planes[c], job, k, c);
    if (to->empty || to->code)
        return;
    if (job->power != 1)
        cvol_planes_correct_opacity(to->planes, job->baked->channels, places, job->power);
    for (int c = 0; c < CVOL_PLANES; c++)
        if (to->planes[c])
            to->bounds.most[c] = cut(to->planes[c], places, c == CVOL_PLANE_OPACITY);
}

/* The picture's places begin .. end - 1. */
static void take_samples(float *const picture[CVOL_PLANES], const evaluated *slice, int channels,
                         int front, size_t begin, size_t end)
{
    float *A = picture[CVOL_PLANE_OPACITY];
    const float *D = slice->planes[CVOL_PLANE_OPACITY];
    for (int c = 0; c < channels; c++) {
        float *I = picture[c];
        const float *C = slice->planes[c];
        if (front)
            for (size_t i = begin; i < end; i++)
                I[i] += (1 - A[i]) * C[i];
        else
            for (size_t i = begin; i < end; i++)
                I[i] = (1 - D[i]) * I[i] + C[i];
    }
    for (size_t i = begin; i < end; i++)
        A[i] += (1 - A[i]) * D[i];
}

/* The largest transmittance, in magnitude. */
static double max_transmittance(const float *A, size_t places)
{
    float most = 0;
    for (size_t i = 0; i < places; i++) {
        const float transmittance = fabsf(1 - A[i]);
        most = transmittance > most ? transmittance : most;
    }
    return (double)most;
}

static int compose_all(cvol_context *context, cvol_composed *out, const cvol_compose_job *job,
                       evaluated *side, size_t count)
{
    const size_t slices = job->baked->slices;
    const size_t places = job->image_grid->dims[0] * job->image_grid->dims[1];
    const int threads = cvol_context_threads(context), channels = job->baked->channels;
    const size_t bands = (size_t)threads * 4, band = places / bands + 1;
    double errors[CVOL_PLANES] = {0}, transmittance = 1;
    int code = CVOL_OK;
    for (size_t n = 0; n < slices && !code; n += count) {
        const size_t left = slices - n, taken = left < count ? left : count;
#pragma omp parallel for schedule(dynamic) num_threads(threads)
        for (size_t i = 0; i < taken; i++)
            evaluate_slice(&side[i], job, cvol_compose_slice(job, n + i));
        for (size_t i = 0; i < taken && !code; i++)
            if (side[i].code)
                code = cvol_fail(context, side[i].code, "%s", side[i].context.message);
        if (code)
            break;
#pragma omp parallel for schedule(static) num_threads(threads)
        for (size_t b = 0; b < bands; b++) {
            const size_t begin = b * band < places ? b * band : places;
            const size_t end = begin + band < places ? begin + band : places;
            for (size_t i = 0; i < taken; i++)
                if (!side[i].empty)
                    take_samples(out->planes, &side[i], channels, job->front, begin, end);
        }
        for (size_t i = 0; i < taken; i++)
            if (!side[i].empty)
                out->multiply_adds += (uint64_t)(channels + 1) *
                                      (cvol_plane_multiply_adds(job) + (uint64_t)places);
        for (size_t i = 0; i < taken; i++)
            if (!side[i].empty && job->front) {
                cvol_compose_visible_errors(errors, &side[i].bounds, transmittance);
                transmittance *= fmax(1, side[i].bounds.most[CVOL_PLANE_OPACITY]);
            } else if (!side[i].empty) {
                cvol_compose_errors(errors, &side[i].bounds, 0);
            }
        if (job->front)
            transmittance = max_transmittance(out->planes[CVOL_PLANE_OPACITY], places);
        code = cvol_report_progress(context, "compositing", (double)n / (double)slices);
    }
    /* and rounding of single precision */
    out->bound = cvol_error_norm(errors, channels) + 1e-7 * (double)slices * sqrt((double)places);
    return code;
}

int cvol_compose_whole(cvol_context *context, cvol_composed *out, const cvol_compose_job *job)
{
    const size_t places = job->image_grid->dims[0] * job->image_grid->dims[1];
    const size_t count = (size_t)cvol_context_threads(context);
    evaluated *side = calloc(count, sizeof *side);
    int made = side != NULL;
    for (size_t i = 0; made && i < count; i++) {
        side[i].context = *context;
        side[i].context.progress = NULL;
        side[i].context.threads = 1;
        for (int c = 0; c < CVOL_PLANES; c++)
            if (out->planes[c])
                made = made && (side[i].planes[c] = cvol_allocate(places, sizeof(float)));
    }
    const int code = made ? compose_all(context, out, job, side, count)
                          : cvol_fail_memory(context, places * sizeof(float), "a slice");
    for (size_t i = 0; side && i < count; i++)
        for (int c = 0; c < CVOL_PLANES; c++)
            free(side[i].planes[c]);
    free(side);
    return code;
}
