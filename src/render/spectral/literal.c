/* Chen & Reif, section 4: the literal schedule. Every result is an array again, truncated, as
 * published. */
#include <math.h>

#include "base/context.h"
#include "base/memory.h"
#include "render/spectral/evaluate.h"

/* The truncation of a result: rho of a slice's samples, for any margin around it. */
static cvol_keep keep_of(const cvol_compose_job *job, const cvol_transform_options *options)
{
    const size_t *dims = job->image_grid->dims, *samples = job->baked->samples;
    const double share = (double)(samples[0] * samples[1]) / (double)(dims[0] * dims[1]);
    return options->rho >= 1 || options->rho * share >= 1 ? cvol_keep_all()
                                                          : cvol_keep_rho(options->rho * share);
}

/* Removes an array's bound, which is tracked separately: the loop's bounds are closer than the
 * bounds of its single operations, since exact intensities and opacities stay within 0 .. 1. */
static double take_bound(cvol_array *array)
{
    const double bound = array->error_bound.l2_error;
    array->error_bound.l2_error = array->error_bound.support_error = 0;
    array->error_bound.point_error = 0;
    array->error_bound.value_min = 0;
    array->error_bound.value_max = 1;
    return bound;
}

/* The multiply-adds of a slice, by formula: planes on the lattice and, unless they are coefficients
 * there, their transforms; a product evaluates two arrays, multiplies and transforms back. */
static uint64_t count_slice(const cvol_compose_job *job, int first)
{
    const cvol_baked *baked = job->baked;
    const size_t places = job->image_grid->dims[0] * job->image_grid->dims[1];
    const uint64_t transform = cvol_transform_multiply_adds(places, baked->tile);
    const uint64_t plane = cvol_plane_multiply_adds(job) + (baked->margin ? 0 : 2 * transform);
    const uint64_t product = 3 * transform + (uint64_t)places;
    return (uint64_t)(baked->channels + 1) * (plane + (first ? 0 : product));
}

/* The planes of slice k on the lattice, as arrays. scratch: samples on it. */
static int make_planes(cvol_context *context, cvol_array *planes[CVOL_PLANES],
                       cvol_slice_bounds *bounds, float *const scratch[CVOL_PLANES],
                       const cvol_compose_job *job, const cvol_keep *keep, size_t k)
{
    const cvol_baked *baked = job->baked;
    const size_t *dims = job->image_grid->dims, places = dims[0] * dims[1];
    const size_t points[3] = {dims[0], dims[1], 1};
    const cvol_grid grid = cvol_grid_make(dims[0], dims[1], 1, CVOL_FLOAT32);
    int code = CVOL_OK;
    *bounds = cvol_slice_bounds_of(job, k);
    for (int c = 0; c < CVOL_PLANES && !code; c++) {
        if (!baked->planes[k][c])
            continue;
        if (!baked->margin) {
            code = cvol_plane_evaluate(context, scratch[c], job, k, c);
            continue;
        }
        code = cvol_plane_reconstruct(context, &planes[c], job, k, c);
        if (!code)
            code = cvol_array_evaluate_grid(context, scratch[c], planes[c], points);
        if (!code)
            bounds->errors[c] = take_bound(planes[c]);
    }
    if (!code && !baked->margin && job->power != 1)
        cvol_planes_correct_opacity(scratch, baked->channels, places, job->power);
    for (int c = 0; c < CVOL_PLANES && !code; c++) {
        if (!baked->planes[k][c])
            continue;
        if (!baked->margin) {
            code = cvol_array_compress(context, &planes[c], scratch[c], &grid, 2, baked->transform,
                                       baked->tile, keep);
            if (!code)
                bounds->errors[c] += take_bound(planes[c]);
            if (!code)
                code = cvol_array_evaluate_real(context, scratch[c], planes[c],
                                                (size_t[3]){0, 0, 0}, points);
        }
        const float from = c == CVOL_PLANE_OPACITY;
        float most = 0;
        for (size_t i = 0; i < places && !code; i++)
            most = fmaxf(most, fabsf(from - scratch[c][i]));
        bounds->most[c] = (double)most;
    }
    return code;
}

static void replace(cvol_array **old, cvol_array *with)
{
    cvol_array_free(*old);
    *old = with;
}

/* *sum = a + through * b; *dropped counts the terms that truncation drops. */
static int add_product(cvol_context *context, cvol_array **sum, double *dropped,
                       const cvol_array *a, const cvol_array *transmittance, const cvol_array *b,
                       const cvol_keep *keep)
{
    cvol_array *product = NULL, *result = NULL;
    int code = cvol_array_multiply(context, &product, transmittance, b, keep, CVOL_PLAN_AUTO, NULL);
    if (!code) {
        *dropped += take_bound(product);
        code = cvol_array_add(context, &result, 1, a, 1, product, keep);
    }
    cvol_array_free(product);
    if (!code) {
        *dropped += take_bound(result);
        replace(sum, result);
    }
    return code;
}

/* Composites one slice in front of or behind the picture. */
static int take_slice(cvol_context *context, cvol_array *picture[CVOL_PLANES],
                      double errors[CVOL_PLANES], cvol_array *const planes[CVOL_PLANES],
                      const cvol_slice_bounds *bounds, int front, const cvol_keep *keep)
{
    double dropped[CVOL_PLANES] = {0};
    cvol_array *transmittance = NULL;
    int code = cvol_array_one_minus(
        context, &transmittance, front ? picture[CVOL_PLANE_OPACITY] : planes[CVOL_PLANE_OPACITY]);
    if (!code)
        take_bound(transmittance);
    for (int c = 0; c < CVOL_PLANES && !code; c++) {
        if (!planes[c])
            continue;
        code = front ? add_product(context, &picture[c], &dropped[c], picture[c], transmittance,
                                   planes[c], keep)
                     : add_product(context, &picture[c], &dropped[c], planes[c], transmittance,
                                   picture[c], keep);
    }
    cvol_array_free(transmittance);
    cvol_compose_errors(errors, bounds, front);
    for (int c = 0; c < CVOL_PLANES; c++)
        errors[c] += dropped[c];
    return code;
}

/* Slice k in front of or behind the picture; the first one is the picture. */
static int compose_slice(cvol_context *context, cvol_array *picture[CVOL_PLANES],
                         double errors[CVOL_PLANES], float *const scratch[CVOL_PLANES],
                         const cvol_compose_job *job, const cvol_keep *keep, size_t k)
{
    cvol_array *planes[CVOL_PLANES] = {0};
    cvol_slice_bounds bounds;
    int code = make_planes(context, planes, &bounds, scratch, job, keep, k);
    const int first = !picture[CVOL_PLANE_OPACITY];
    if (!code && !first)
        code = take_slice(context, picture, errors, planes, &bounds, job->front, keep);
    for (int c = 0; c < CVOL_PLANES; c++)
        if (!code && first) {
            picture[c] = planes[c];
            errors[c] = bounds.errors[c];
        } else {
            cvol_array_free(planes[c]);
        }
    return code;
}

static int compose_all(cvol_context *context, cvol_composed *out, const cvol_compose_job *job,
                       float *const scratch[CVOL_PLANES], const cvol_keep *keep)
{
    const cvol_baked *baked = job->baked;
    const size_t begin[3] = {0, 0, 0},
                 end[3] = {job->image_grid->dims[0], job->image_grid->dims[1], 1};
    double errors[CVOL_PLANES] = {0};
    int code = CVOL_OK;
    for (size_t n = 0; n < baked->slices && !code; n++) {
        const size_t k = cvol_compose_slice(job, n);
        if (!cvol_compose_has(job, k))
            continue;
        out->multiply_adds += count_slice(job, !out->arrays[CVOL_PLANE_OPACITY]);
        code = compose_slice(context, out->arrays, errors, scratch, job, keep, k);
        if (!code)
            code = cvol_report_progress(context, "compositing", (double)n / (double)baked->slices);
    }
    out->bound = cvol_error_norm(errors, baked->channels);
    for (int c = 0; c < CVOL_PLANES && !code; c++) {
        cvol_array_info info;
        if (!out->arrays[c])
            continue;
        cvol_array_get_info(&info, out->arrays[c]);
        out->terms += info.coefficients;
        code = cvol_array_evaluate_real(context, out->planes[c], out->arrays[c], begin, end);
    }
    return code;
}

int cvol_compose_literal(cvol_context *context, cvol_composed *out, const cvol_compose_job *job,
                         const cvol_transform_options *options)
{
    const size_t places = job->image_grid->dims[0] * job->image_grid->dims[1];
    const cvol_keep keep = keep_of(job, options);
    float *memory = cvol_allocate(CVOL_PLANES * places, sizeof *memory);
    if (!memory)
        return cvol_fail_memory(context, CVOL_PLANES * places * sizeof *memory, "a slice");
    float *scratch[CVOL_PLANES];
    for (size_t c = 0; c < CVOL_PLANES; c++)
        scratch[c] = memory + c * places;
    const int code = compose_all(context, out, job, scratch, &keep);
    free(memory);
    return code;
}
