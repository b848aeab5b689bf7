/* The terms of the decoded samples of an array with a residual: see decoded_terms.h. */
#include "array/evaluate/decoded_terms.h"

#include <math.h>
#include <pthread.h>
#include <stdlib.h>
#include <string.h>

#include "array/core/summary.h"
#include "array/truncate/account.h"
#include "array/truncate/compress_array.h"
#include "array/truncate/producer.h"
#include "base/context.h"
#include "base/for_type.h"
#include "base/memory.h"

/* The step: an eighth of the range's 8-bit unit, and at least half a unit of integers. Its error is
 * 1 / (2^10 sqrt(12)) of the range, 71 dB; the 8 bits of a picture round with 59 dB. */
#define STEPS_OF_RANGE 1024
#define STEP_OF_INTEGERS 0.5
/* Integers of a small range, as a mask of 0 and 1, have at least this number of steps. */
#define STEPS_OF_INTEGERS 512
/* Terms whose step is at most twice as wide stay. */
#define FINE_ENOUGH 2

static double step_of_integers(double span)
{
    return fmin(STEP_OF_INTEGERS, span / STEPS_OF_INTEGERS);
}

static double wanted_step(const cvol_array *array)
{
    const double span = array->error_bound.value_max - array->error_bound.value_min;
    double step = span / STEPS_OF_RANGE;
    if (array->step < step * FINE_ENOUGH) /* a few outliers define the range */
        step = array->step / 2;
    return cvol_type_is_integer(array->grid.type) ? fmax(step, step_of_integers(span)) : step;
}

static int is_fine_enough(const cvol_array *array)
{
    const double span = array->error_bound.value_max - array->error_bound.value_min;
    return !(span > CVOL_RANGE_LEAST && span < CVOL_RANGE_MOST) ||
           array->step <=
               FINE_ENOUGH * fmax(span / STEPS_OF_RANGE, cvol_type_is_integer(array->grid.type)
                                                             ? step_of_integers(span)
                                                             : 0);
}

/* Sets masked samples to a value within the range: the residual leaves them undefined. */
static void fill_masked(void *samples, const cvol_array *array, const size_t begin[3],
                        const size_t end[3])
{
    const double value = fmin(fmax(0, array->error_bound.value_min), array->error_bound.value_max);
    uint64_t bits = 0;
    if (!array->mask || !cvol_fills_of_value(&bits, array->grid.type, value))
        return;
    uint64_t patterns[CVOL_FILLS_MAX];
    for (int i = 0; i < CVOL_FILLS_MAX; i++)
        patterns[i] = bits;
    cvol_mask_write(samples, cvol_type_size(array->grid.type), patterns, array->mask, begin, end);
}

int cvol_array_decoded_samples(cvol_context *context, void *out, const cvol_array *array,
                               const size_t begin[3], const size_t end[3])
{
    const int code = array->residual->evaluate(context, out, array, begin, end);
    if (!code)
        fill_masked(out, array, begin, end);
    return code;
}

/* The L2 distance that the decoded samples may have from the original ones. */
static double samples_error(const cvol_array *array)
{
    const double each = array->max_error;
    return each > 0 ? each * sqrt((double)cvol_grid_samples(&array->grid)) : 0;
}

static int transform_samples(cvol_context *context, cvol_array *terms, const cvol_array *array,
                             void *samples)
{
    const size_t zero[3] = {0, 0, 0};
    const cvol_keep keep = cvol_keep_step(wanted_step(array));
    cvol_build_result result;
    int code = cvol_array_decoded_samples(context, samples, array, zero, array->grid.dims);
    if (code)
        return code;
    code = cvol_blocks_compress(context, terms, &result, samples, &keep);
    if (code)
        return code;
    cvol_array_account(terms, &result, 0);
    cvol_error_bound_widen(&terms->error_bound, samples_error(array), fmax(array->max_error, 0));
    return CVOL_OK;
}

/* An array of this shape, without terms. */
static int make_shape(cvol_context *context, cvol_array **out, const cvol_array *array)
{
    int code = cvol_array_create(context, out, &array->grid, array->block);
    if (code)
        return code;
    cvol_array *terms = *out;
    terms->offset = array->offset;
    terms->is_of_exact = !(array->max_error > 0);
    terms->error_bound = array->error_bound;
    terms->error_bound.l2_error = terms->error_bound.point_error = 0;
    terms->error_bound.max_abs = cvol_error_bound_largest(&array->error_bound);
    code = cvol_array_set_coding(context, terms, array, NULL);
    return code ? code : cvol_array_set_summary(context, terms, cvol_array_summary(array));
}

static int make(cvol_context *context, cvol_array **out, const cvol_array *array)
{
    *out = NULL;
    void *samples = cvol_allocate(cvol_grid_samples(&array->grid),
                                  cvol_type_size(array->grid.type));
    if (!samples)
        return cvol_fail_memory(context, cvol_grid_bytes(&array->grid), "the decoded samples");
    cvol_array *terms = NULL;
    int code = make_shape(context, &terms, array);
    if (!code)
        code = transform_samples(context, terms, array, samples);
    free(samples);
    if (!code) {
        terms->mask = array->mask; /* borrowed */
        cvol_array_derive_figures(terms);
        code = cvol_array_ensure_ranges(context, terms);
    }
    if (code) {
        if (terms)
            terms->mask = NULL;
        cvol_array_free(terms);
        return code;
    }
    *out = terms;
    return CVOL_OK;
}

int cvol_array_decoded_terms(cvol_context *context, const cvol_array **out, const cvol_array *array)
{
    static pthread_mutex_t refine_lock = PTHREAD_MUTEX_INITIALIZER;
    cvol_residual *residual = array->residual;
    *out = array;
    if (!residual || is_fine_enough(array))
        return CVOL_OK;
    pthread_mutex_lock(&refine_lock);
    cvol_team *team = context->team; /* each process needs all terms */
    context->team = NULL;
    const int code = residual->decoded ? CVOL_OK : make(context, &residual->decoded, array);
    context->team = team;
    if (!code)
        *out = residual->decoded;
    pthread_mutex_unlock(&refine_lock);
    return code;
}
