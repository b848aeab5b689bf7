/* The loops: slices become a picture on the lattice. */
#include <math.h>
#include <string.h>

#include "base/context.h"
#include "base/memory.h"
#include "render/transform.h"

/* How far slice k is moved on the lattice. */
static void shift_of(double out[3], const cvol_lattice *lattice, size_t k)
{
    for (int a = 0; a < 2; a++)
        out[a] = lattice->base[a] - (double)lattice->reach + (double)k * lattice->shear[a];
    out[2] = 0;
}

/* The slice that is met as number n. */
static size_t slice_at(const cvol_baked *baked, int rising, int front, size_t n)
{
    return rising == front ? n : baked->slices - 1 - n;
}

static double norm_of(const double errors[3])
{
    return sqrt(errors[0] * errors[0] + errors[1] * errors[1] + errors[2] * errors[2]);
}

/* What a slice's planes may differ from the truth by, and what their samples reach. */
typedef struct slice_bounds {
    double errors[CVOL_PLANES], most[CVOL_PLANES]; /* most: |C~|, and |1 - D~| */
} slice_bounds;

/* Errors of intensities and opacity after a slice in front of or behind what is there. The truth's
 * values are within 0 .. 1, and
 *
 *     |T C - T~ C~| <= |C - C~| + max|C~| |T - T~|          front to back, T = 1 - A
 *     |(1 - D) I - (1 - D~) I~| <= max|1 - D~| |I - I~| + |D - D~|
 *
 * and opacity is 1 - (1 - A)(1 - D) in both. */
static void carry_errors(double errors[CVOL_PLANES], const slice_bounds *slice, int front)
{
    const double A = errors[CVOL_PLANE_OPACITY], D = slice->errors[CVOL_PLANE_OPACITY];
    const double through = slice->most[CVOL_PLANE_OPACITY];
    for (int c = 0; c < CVOL_PLANE_OPACITY; c++)
        errors[c] = slice->errors[c] +
                    (front ? errors[c] + slice->most[c] * A : through * errors[c] + D);
    errors[CVOL_PLANE_OPACITY] = through * A + D;
}

/* ---- literal: every result is an array again ------------------------------------------------ */

/* A plane through the footprint and moved. */
static int reconstruct(cvol_context *context, cvol_array **out, const cvol_array *plane,
                       const cvol_kernel *footprint, const double shift[3])
{
    const cvol_keep all = cvol_keep_all();
    cvol_array *spread;
    *out = NULL;
    int code = cvol_array_convolve_kernel(context, &spread, plane, footprint, &all);
    if (!code)
        code = cvol_array_shift(context, out, spread, shift);
    cvol_array_free(spread);
    return code;
}

/* Takes an array's bound away, which is kept apart: those of the loop are closer than those of its
 * single operations, as exact intensities and opacities stay within 0 .. 1. */
static double take_bound(cvol_array *array)
{
    const double bound = array->ledger.l2_error;
    array->ledger.l2_error = array->ledger.support_error = 0;
    array->ledger.value_min = 0;
    array->ledger.value_max = 1;
    return bound;
}

static int bound_planes(cvol_context *context, slice_bounds *out, float *scratch,
                        cvol_array *const planes[CVOL_PLANES], const cvol_lattice *lattice)
{
    const size_t points[3] = {lattice->dims[0], lattice->dims[1], 1};
    for (int c = 0; c < CVOL_PLANES; c++) {
        const int code = cvol_array_evaluate_grid(context, scratch, planes[c], points);
        if (code)
            return code;
        const float from = c == CVOL_PLANE_OPACITY;
        float most = 0;
        for (size_t i = 0; i < points[0] * points[1]; i++)
            most = fmaxf(most, fabsf(from - scratch[i]));
        out->most[c] = (double)most;
        out->errors[c] = take_bound(planes[c]);
    }
    return CVOL_OK;
}

static void replace(cvol_array **old, cvol_array *with)
{
    cvol_array_free(*old);
    *old = with;
}

/* *sum = a + through * b; *dropped counts what truncation takes. */
static int add_product(cvol_context *context, cvol_array **sum, double *dropped,
                       const cvol_array *a, const cvol_array *through, const cvol_array *b,
                       const cvol_keep *keep)
{
    cvol_array *product = NULL, *result = NULL;
    int code = cvol_array_multiply(context, &product, through, b, keep, CVOL_PLAN_AUTO, NULL);
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

/* One slice in front of or behind what is there. */
static int take_slice(cvol_context *context, cvol_array *picture[CVOL_PLANES],
                      double errors[CVOL_PLANES], cvol_array *const planes[CVOL_PLANES],
                      const slice_bounds *bounds, int front, const cvol_keep *keep)
{
    double dropped[CVOL_PLANES] = {0};
    cvol_array *through = NULL;
    int code = cvol_array_one_minus(
        context, &through, front ? picture[CVOL_PLANE_OPACITY] : planes[CVOL_PLANE_OPACITY]);
    if (!code)
        take_bound(through);
    for (int c = 0; c < CVOL_PLANES && !code; c++)
        code = front ? add_product(context, &picture[c], &dropped[c], picture[c], through,
                                   planes[c], keep)
                     : add_product(context, &picture[c], &dropped[c], planes[c], through,
                                   picture[c], keep);
    cvol_array_free(through);
    carry_errors(errors, bounds, front);
    for (int c = 0; c < CVOL_PLANES; c++)
        errors[c] += dropped[c];
    return code;
}

static int compose_literally(cvol_context *context, cvol_array *picture[CVOL_PLANES],
                             double errors[CVOL_PLANES], float *scratch, const cvol_baked *baked,
                             const cvol_kernel *footprint, int rising, int front,
                             const cvol_keep *keep)
{
    int code = CVOL_OK;
    for (size_t n = 0; n < baked->slices && !code; n++) {
        const size_t k = slice_at(baked, rising, front, n);
        cvol_array *planes[CVOL_PLANES] = {0};
        slice_bounds bounds;
        double shift[3];
        if (!baked->planes[k][0])
            continue;
        shift_of(shift, &baked->lattice, k);
        for (int c = 0; c < CVOL_PLANES && !code; c++)
            code = reconstruct(context, &planes[c], baked->planes[k][c], footprint, shift);
        if (!code)
            code = bound_planes(context, &bounds, scratch, planes, &baked->lattice);
        if (!code && picture[0])
            code = take_slice(context, picture, errors, planes, &bounds, front, keep);
        for (int c = 0; c < CVOL_PLANES; c++)
            if (!code && !picture[c]) {
                picture[c] = planes[c];
                errors[c] = bounds.errors[c];
            } else {
                cvol_array_free(planes[c]);
            }
        if (!code)
            code = cvol_report_progress(context, "compositing", (double)n / (double)baked->slices);
    }
    return code;
}

static int evaluate_picture(cvol_context *context, cvol_composed *out, const cvol_baked *baked,
                            cvol_array *const picture[CVOL_PLANES])
{
    const size_t points[3] = {baked->lattice.dims[0], baked->lattice.dims[1], 1};
    int code = CVOL_OK;
    for (int c = 0; c < CVOL_PLANES && picture[c] && !code; c++) {
        cvol_array_info info;
        cvol_array_get_info(picture[c], &info);
        out->terms += info.coefficients;
        code = cvol_array_evaluate_grid(context, out->planes[c], picture[c], points);
    }
    return code;
}

/* ---- deferred: samples until the end -------------------------------------------------------- */

/* Slices that are evaluated side by side. */
typedef struct evaluated {
    float *planes[CVOL_PLANES];
    slice_bounds bounds;
    int code, empty;
    cvol_context context;
} evaluated;

/* A DCT's samples, moved, by the chirp transform. Beyond its ends it is mirrored; there is nothing
 * of the slice there. */
static int evaluate_moved(cvol_context *context, float *out, const cvol_array *plane,
                          const size_t dims[3], const double shift[3])
{
    double start[3] = {0, 0, 0};
    const double step[3] = {1, 1, 1};
    size_t first[2], count[3] = {1, 1, 1};
    for (int a = 0; a < 2; a++) {
        first[a] = (size_t)fmax(ceil(shift[a]), 0);
        start[a] = (double)first[a] - shift[a];
        if (first[a] < dims[a])
            count[a] = dims[a] - first[a];
    }
    float *box = cvol_allocate(count[0] * count[1], sizeof *box);
    int code = box ? cvol_array_evaluate_chirp(context, box, plane, start, step, count)
                   : cvol_fail_memory(context, count[0] * count[1] * sizeof *box, "a slice");
    memset(out, 0, dims[0] * dims[1] * sizeof *out);
    for (size_t y = 0; y < count[1] && !code; y++)
        memcpy(out + first[0] + dims[0] * (first[1] + y), box + count[0] * y,
               count[0] * sizeof *box);
    free(box);
    return code;
}

/* A plane through the footprint, moved, as samples. */
static int evaluate_plane(cvol_context *context, float *out, double *error, const cvol_array *plane,
                          const cvol_lattice *lattice, const cvol_kernel *footprint,
                          const double shift[3])
{
    const size_t points[3] = {lattice->dims[0], lattice->dims[1], 1};
    const cvol_keep all = cvol_keep_all();
    cvol_array *spread, *moved = NULL;
    cvol_array_info info;
    int code = cvol_array_convolve_kernel(context, &spread, plane, footprint, &all);
    if (code)
        return code;
    cvol_array_get_info(spread, &info);
    *error = info.l2_error;
    if (info.transform == CVOL_DCT) {
        code = evaluate_moved(context, out, spread, points, shift);
    } else {
        code = cvol_array_shift(context, &moved, spread, shift);
        if (!code)
            code = cvol_array_evaluate_grid(context, out, moved, points);
    }
    cvol_array_free(moved);
    cvol_array_free(spread);
    return code;
}

/* The largest |from - sample|; samples above 1 are none of the truth's, and cut. Those below 0 are
 * not either, but stay: they make good, in the sum over slices, for what truncation left too large
 * beside them. (Cut at 0, truncation's noise would have a mean, and the picture a haze.) */
static double cut(float *plane, size_t places, float from)
{
    float most = 0;
    for (size_t i = 0; i < places; i++) {
        plane[i] = plane[i] < 1 ? plane[i] : 1;
        most = fmaxf(most, fabsf(from - plane[i]));
    }
    return (double)most;
}

static void evaluate_slice(evaluated *to, const cvol_baked *baked, const cvol_kernel *footprint,
                           size_t k)
{
    const size_t places = baked->lattice.dims[0] * baked->lattice.dims[1];
    double shift[3];
    to->empty = !baked->planes[k][0];
    to->code = CVOL_OK;
    shift_of(shift, &baked->lattice, k);
    for (int c = 0; c < CVOL_PLANES && !to->empty && !to->code; c++) {
        to->code = evaluate_plane(&to->context, to->planes[c], &to->bounds.errors[c],
                                  baked->planes[k][c], &baked->lattice, footprint, shift);
        if (!to->code)
            to->bounds.most[c] = cut(to->planes[c], places, c == CVOL_PLANE_OPACITY);
    }
}

/* The picture's pixels begin .. end - 1. */
static void take_samples(float *const picture[CVOL_PLANES], const evaluated *slice, int front,
                         size_t begin, size_t end)
{
    float *A = picture[CVOL_PLANE_OPACITY];
    const float *D = slice->planes[CVOL_PLANE_OPACITY];
    for (int c = 0; c < CVOL_PLANES - 1; c++) {
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

static int compose_evaluated(cvol_context *context, cvol_composed *out, const cvol_baked *baked,
                             const cvol_kernel *footprint, int rising, int front, evaluated *side,
                             size_t count)
{
    const size_t places = baked->lattice.dims[0] * baked->lattice.dims[1];
    const int threads = cvol_context_threads(context);
    const size_t bands = (size_t)threads * 4, band = places / bands + 1;
    double errors[CVOL_PLANES] = {0};
    int code = CVOL_OK;
    for (size_t n = 0; n < baked->slices && !code; n += count) {
        const size_t left = baked->slices - n, taken = left < count ? left : count;
#pragma omp parallel for schedule(dynamic) num_threads(threads)
        for (size_t i = 0; i < taken; i++)
            evaluate_slice(&side[i], baked, footprint, slice_at(baked, rising, front, n + i));
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
                    take_samples(out->planes, &side[i], front, begin, end);
        }
        for (size_t i = 0; i < taken; i++)
            if (!side[i].empty)
                carry_errors(errors, &side[i].bounds, front);
        code = cvol_report_progress(context, "compositing", (double)n / (double)baked->slices);
    }
    /* and rounding, of single precision */
    out->bound = norm_of(errors) + 1e-7 * (double)baked->slices * sqrt((double)places);
    return code;
}

static int compose_deferred(cvol_context *context, cvol_composed *out, const cvol_baked *baked,
                            const cvol_kernel *footprint, int rising, int front)
{
    const size_t places = baked->lattice.dims[0] * baked->lattice.dims[1];
    const size_t count = (size_t)cvol_context_threads(context);
    evaluated *side = calloc(count, sizeof *side);
    int made = side != NULL;
    for (size_t i = 0; made && i < count; i++) {
        side[i].context = *context;
        side[i].context.progress = NULL;
        side[i].context.threads = 1;
        for (int c = 0; c < CVOL_PLANES; c++)
            made = made && (side[i].planes[c] = cvol_allocate(places, sizeof(float)));
    }
    const int code = made ? compose_evaluated(context, out, baked, footprint, rising, front, side,
                                              count)
                          : cvol_fail_memory(context, places * sizeof(float), "a slice");
    for (size_t i = 0; side && i < count; i++)
        for (int c = 0; c < CVOL_PLANES; c++)
            free(side[i].planes[c]);
    free(side);
    return code;
}

/* ---- both ----------------------------------------------------------------------------------- */

int cvol_compose(cvol_context *context, cvol_composed *out, const cvol_baked *baked,
                 const cvol_kernel *footprint, int rising, int front,
                 const cvol_transform_options *options)
{
    const size_t places = baked->lattice.dims[0] * baked->lattice.dims[1];
    const cvol_keep keep = cvol_transform_keep(options, &baked->lattice);
    cvol_array *picture[CVOL_PLANES] = {0};
    *out = (cvol_composed){0};
    for (int c = 0; c < CVOL_PLANES; c++)
        if (!(out->planes[c] = cvol_allocate_zero(places, sizeof(float))))
            return cvol_fail_memory(context, places * sizeof(float), "a picture");
    if (options->schedule != CVOL_SCHEDULE_LITERAL)
        return compose_deferred(context, out, baked, footprint, rising, front);
    double errors[CVOL_PLANES] = {0};
    int code = compose_literally(context, picture, errors, out->planes[0], baked, footprint, rising,
                                 front, &keep);
    out->bound = norm_of(errors);
    if (!code)
        code = evaluate_picture(context, out, baked, picture);
    for (int c = 0; c < CVOL_PLANES; c++)
        cvol_array_free(picture[c]);
    return code;
}

void cvol_composed_free(cvol_composed *composed)
{
    for (int c = 0; c < CVOL_PLANES; c++)
        free(composed->planes[c]);
    *composed = (cvol_composed){0};
}
