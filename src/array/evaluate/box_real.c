/* Boxes of samples as floats, and boxes of whole arrays in the grid's own type. */
#include <stdlib.h>
#include <string.h>

#include "array/evaluate/box.h"
#include "array/evaluate/decoded_terms.h"
#include "base/context.h"
#include "base/doubles.h"
#include "base/memory.h"

int cvol_array_check_box(cvol_context *context, const cvol_array *array, const size_t begin[3],
                         const size_t end[3])
{
    for (int a = 0; a < 3; a++)
        if (begin[a] >= end[a] || end[a] > array->grid.dims[a])
            return cvol_fail(context, CVOL_ERROR_ARGUMENT,
                             "box %zu .. %zu on axis %c does not lie within 0 .. %zu", begin[a],
                             end[a], "xyz"[a], array -> grid.dims[a]);
    return CVOL_OK;
}

/* Sets masked samples to their fills less `offset`, as floats. */
static void apply_fills(cvol_context *context, float *out, const cvol_array *array,
                        const size_t begin[3], const size_t end[3], double offset)
{
    const size_t sheet = (end[0] - begin[0]) * (end[1] - begin[1]);
    const cvol_fills *fills = cvol_mask_fills(array->mask);
    uint64_t patterns[CVOL_FILLS_MAX] = {0};
    for (int i = 0; i < fills->count; i++) {
        const float value = (float)(cvol_fills_value(fills, i, array->grid.type) - offset);
        uint32_t bits;
        memcpy(&bits, &value, sizeof bits);
        patterns[i] = bits;
    }
#pragma omp parallel for schedule(static) num_threads(cvol_context_threads(context))
    for (size_t z = begin[2]; z < end[2]; z++) {
        const size_t first[3] = {begin[0], begin[1], z}, last[3] = {end[0], end[1], z + 1};
        cvol_mask_write(out + sheet * (z - begin[2]), sizeof *out, patterns, array->mask, first,
                        last);
    }
}

static int evaluate_decoded(cvol_context *context, float *out, const cvol_array *array,
                            const size_t begin[3], const size_t end[3], double offset)
{
    const size_t count = (end[0] - begin[0]) * (end[1] - begin[1]) * (end[2] - begin[2]);
    void *samples = cvol_allocate(count, cvol_type_size(array->grid.type));
    if (!samples)
        return cvol_fail_memory(context, count * cvol_type_size(array->grid.type),
                                "a box of samples");
    const int code = cvol_array_decoded_samples(context, samples, array, begin, end);
    if (!code)
        cvol_samples_load(out, samples, array->grid.type, 0, count, offset);
    free(samples);
    return code;
}

/* The samples less `offset`, which is 0 or the array's; finite ones where they have no value. */
static int evaluate(cvol_context *context, float *out, const cvol_array *array,
                    const size_t begin[3], const size_t end[3], double offset)
{
    cvol_array moved = *array; /* shallow */
    int code = cvol_array_check_box(context, array, begin, end);
    if (code)
        return code;
    if (array->residual)
        return evaluate_decoded(context, out, array, begin, end, offset);
    moved.offset -= offset;
    code = array->block ? cvol_blocks_evaluate(context, out, &moved, begin, end)
                        : cvol_whole_evaluate(context, out, &moved, begin, end);
    if (!code && cvol_mask_is_background(array->mask))
        apply_fills(context, out, array, begin, end, offset);
    return code;
}

int cvol_array_evaluate_unmasked(cvol_context *context, float *out, const cvol_array *array,
                                 const size_t begin[3], const size_t end[3])
{
    return evaluate(context, out, array, begin, end, 0);
}

/* The offset is added in double precision, so that small differences between samples far from 0
 * are not lost. */
static int evaluate_offset(cvol_context *context, double *out, float *terms,
                           const cvol_array *array, const size_t begin[3], const size_t end[3],
                           size_t count)
{
    const int code = cvol_array_evaluate_less_offset(context, terms, array, begin, end);
    if (code)
        return code;
    for (size_t i = 0; i < count; i++)
        out[i] = (double)terms[i] + array->offset;
    if (cvol_mask_is_background(array->mask)) {
        const double background = cvol_array_background(array);
        uint64_t patterns[CVOL_FILLS_MAX] = {0};
        memcpy(patterns, &background, sizeof background);
        cvol_mask_write(out, sizeof *out, patterns, array->mask, begin, end);
    }
    return CVOL_OK;
}

int cvol_array_evaluate_doubles(cvol_context *context, double *out, const cvol_array *array,
                                const size_t begin[3], const size_t end[3])
{
    const cvol_type type = array->residual ? array->grid.type : CVOL_FLOAT32;
    int code = cvol_array_check_box(context, array, begin, end);
    if (code)
        return code;
    const size_t count = (end[0] - begin[0]) * (end[1] - begin[1]) * (end[2] - begin[2]);
    void *samples = cvol_allocate(count, cvol_type_size(type));
    if (!samples)
        return cvol_fail_memory(context, count * cvol_type_size(type), "a box of samples");
    if (array->residual) {
        code = cvol_array_decoded_samples(context, samples, array, begin, end);
        if (!code)
            cvol_doubles_load(out, type, samples, 0, count);
    } else {
        code = evaluate_offset(context, out, samples, array, begin, end, count);
    }
    free(samples);
    return code;
}

int cvol_array_evaluate_real(cvol_context *context, float *out, const cvol_array *array,
                             const size_t begin[3], const size_t end[3])
{
    const int code = evaluate(context, out, array, begin, end, 0);
    if (!code && cvol_mask_is_void(array->mask))
        apply_fills(context, out, array, begin, end, 0);
    return code;
}

int cvol_array_evaluate_less_offset(cvol_context *context, float *out, const cvol_array *array,
                                    const size_t begin[3], const size_t end[3])
{
    return evaluate(context, out, array, begin, end, array->offset);
}

int cvol_whole_evaluate_stored(cvol_context *context, void *out, const cvol_array *array,
                               const size_t begin[3], const size_t end[3])
{
    const size_t count = (end[0] - begin[0]) * (end[1] - begin[1]) * (end[2] - begin[2]);
    float *samples = cvol_allocate(count, sizeof *samples);
    if (!samples)
        return cvol_fail_memory(context, count * sizeof *samples, "a box of samples");
    int code = cvol_whole_evaluate(context, samples, array, begin, end);
    if (!code)
        cvol_samples_store(out, samples, count, array);
    free(samples);
    return code;
}
