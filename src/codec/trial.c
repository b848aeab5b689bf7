/* Trials: the steps from coefficients to a measured array. */
#include "codec/trial.h"

#include <math.h>
#include <string.h>

#include "base/context.h"
#include "base/memory.h"
#include "codec/array_file.h"
#include "codec/quantise.h"
#include "codec/ranges.h"
#include "codec/rate_distortion.h"
#include "codec/survey.h"

/* Of more, sums of squares and transforms would leave the range of float. */
#define SPAN_MOST 2e35

int cvol_trial_start(cvol_context *context, cvol_trial *trial, const void *samples,
                     const cvol_grid *grid, int block)
{
    memset(trial, 0, sizeof *trial);
    trial->samples = samples;
    int code = cvol_array_create(context, &trial->shape, grid, block);
    if (code)
        return code;
    cvol_array *shape = trial->shape;
    code = cvol_survey_samples(context, &shape->ledger.value_min, &shape->ledger.value_max, samples,
                               grid);
    if (code)
        return code;
    if (!(shape->ledger.value_max - shape->ledger.value_min <= SPAN_MOST))
        return cvol_fail(context, CVOL_ERROR_DATA,
                         "samples reach from %g to %g, a range beyond %g cannot be compressed",
                         shape->ledger.value_min, shape->ledger.value_max, SPAN_MOST);
    shape->offset = shape->ledger.value_min;
    const size_t cells = shape->block_count / (block == 8 ? 8 : 1); /* of ranges.h */
    trial->begin_bytes = 400 + cells / 2 + 12 * (uint64_t)cvol_group_count(shape);
    return cvol_coefficients_make(context, &trial->coefficients, shape, samples);
}

void cvol_trial_free(cvol_trial *trial)
{
    cvol_array_free(trial->shape);
    cvol_array_free(trial->array);
    cvol_coefficients_free(&trial->coefficients);
    cvol_groups_free(&trial->groups);
}

static int fetch_quantised(const void *user, int32_t *values, cvol_block_coder *coder, size_t place,
                           size_t index)
{
    const cvol_trial *trial = user;
    const int count = coder->scan->count;
    const float *coefficients = trial->coefficients.data + index * (size_t)count;
    if (trial->plain)
        return cvol_quantise(values, coefficients, count, trial->step);
    return cvol_quantise_optimally(values, coefficients, coder, place, trial->step);
}

int cvol_trial_encode(cvol_context *context, cvol_trial *trial, double step, size_t stride)
{
    const cvol_block_source source = {fetch_quantised, trial};
    trial->step = step;
    trial->count++;
    return cvol_groups_encode(context, &trial->groups, trial->shape, &source, stride / 2, stride,
                              1 - 0.9 * pow(0.8, trial->count));
}

static int decode_groups(cvol_context *context, cvol_trial *trial)
{
    cvol_span *spans = cvol_allocate(trial->groups.count, sizeof *spans);
    if (!spans)
        return cvol_fail_memory(context, trial->groups.count * sizeof *spans, "the groups");
    for (size_t g = 0; g < trial->groups.count; g++)
        spans[g] = (cvol_span){trial->groups.bytes[g].data, trial->groups.bytes[g].size};
    int code = cvol_array_decode(context, trial->array, spans, NULL, "the encoded volume");
    free(spans);
    return code;
}

int cvol_trial_decode(cvol_context *context, cvol_trial *trial)
{
    cvol_array_free(trial->array);
    trial->array = NULL;
    int code = cvol_array_create(context, &trial->array, &trial->shape->grid, trial->shape->block);
    if (code)
        return code;
    cvol_array *array = trial->array;
    array->ledger.max_abs = (double)INFINITY; /* until the ranges are known */
    array->step = trial->step;
    array->offset = trial->shape->offset;
    array->ledger.value_min = trial->shape->ledger.value_min;
    array->ledger.value_max = trial->shape->ledger.value_max;
    code = decode_groups(context, trial);
    if (code)
        return code;
    cvol_distance distance;
    code = cvol_measure_distance(context, &distance, array, trial->samples);
    if (code)
        return code;
    cvol_array_set_measured(array, &distance);
    array->ledger.l2_error = distance.real_l2_error + CVOL_ROUNDING * distance.real_norm;
    return CVOL_OK;
}

int cvol_trial_finish(cvol_context *context, cvol_trial *trial, uint64_t *file_bytes)
{
    int code = cvol_ranges_find(context, trial->array);
    if (!code)
        code = cvol_array_file_bytes(context, trial->array, file_bytes);
    if (code)
        return code;
    /* What the file has beyond the groups, which are of another coder. */
    const uint64_t groups = cvol_groups_size(&trial->groups);
    trial->begin_bytes = *file_bytes > groups ? *file_bytes - groups : 0;
    return CVOL_OK;
}
