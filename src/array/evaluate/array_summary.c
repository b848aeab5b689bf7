/* The summary of an array that has none: from a regular subset of its blocks, evaluated.
 *
 * Values are not rounded to the samples' type: the summary is that of the terms. */
#include <math.h>
#include <stdlib.h>

#include "array/core/share.h"
#include "array/core/summary.h"
#include "array/evaluate/decoded_terms.h"
#include "base/context.h"
#include "base/memory.h"

enum { BLOCKS_MAX = 1024 };

const cvol_summary *cvol_array_summary(const cvol_array *array)
{
    static const cvol_summary none = {.state = CVOL_SUMMARY_NONE};
    return array->summary ? array->summary : &none;
}

int cvol_array_set_summary(cvol_context *context, cvol_array *array, const cvol_summary *summary)
{
    if (summary->state == CVOL_SUMMARY_NONE) {
        free(array->summary);
        array->summary = NULL;
        return CVOL_OK;
    }
    if (!array->summary)
        array->summary = cvol_allocate(1, sizeof *array->summary);
    if (!array->summary)
        return cvol_fail_memory(context, sizeof *summary, "the summary of the samples");
    *array->summary = *summary;
    return CVOL_OK;
}

/* Samples of a block along one axis that lie within the volume. */
static size_t inside(const cvol_array *array, size_t place, int axis)
{
    const size_t begin = place * (size_t)array->block;
    const size_t left = array->grid.dims[axis] - begin;
    return left < (size_t)array->block ? left : (size_t)array->block;
}

/* The evaluated samples of a block, and the ones that count. */
typedef struct scratch {
    float *samples;
    uint8_t *which;
    double *values;
} scratch;

/* Collects the values of block `index`; returns their number. */
static size_t gather(const scratch *s, const cvol_array *array, size_t index)
{
    const size_t B = (size_t)array->block;
    size_t begin[3], end[3], size[3], count = 0;
    cvol_block_origin(begin, array, index);
    for (int a = 0; a < 3; a++) {
        size[a] = inside(array, begin[a] / B, a);
        end[a] = begin[a] + size[a];
    }
    const int masked = array->mask && cvol_mask_get(s->which, array->mask, begin, end);
    const int apart = cvol_mask_is_background(array->mask);
    const double background = cvol_array_background(array);
    cvol_block_evaluate(s->samples, array, index);
    for (size_t z = 0; z < size[2]; z++)
        for (size_t y = 0; y < size[1]; y++)
            for (size_t x = 0; x < size[0]; x++) {
                const int is_masked = masked && s->which[x + size[0] * (y + size[1] * z)];
                if (!is_masked)
                    s->values[count++] = (double)s->samples[x + B * (y + B * z)] + array->offset;
                else if (apart)
                    s->values[count++] = background;
            }
    return count;
}

static int add_blocks(cvol_context *context, cvol_tally *tally, const scratch *s,
                      const cvol_array *array)
{
    const size_t count = array->block_count < BLOCKS_MAX ? array->block_count : BLOCKS_MAX;
    const cvol_share share = cvol_share_of(context, array);
    int code = CVOL_OK;
    for (size_t i = 0; i < count && !code; i++) {
        const size_t index = (size_t)((double)i * (double)array->block_count / (double)count);
        if (cvol_share_has(&share, index))
            code = cvol_tally_add(context, tally, s->values, gather(s, array, index));
    }
    return code ? code : cvol_tally_share(context, tally, share.team);
}

/* Finds the range of the samples from the blocks: bounds of results may be wide. */
static void find_range(double range[2], const cvol_array *array)
{
    range[0] = array->error_bound.value_min;
    range[1] = array->error_bound.value_max;
    if (!array->measured && array->has_ranges) {
        range[0] = fmax(range[0], array->range_min);
        range[1] = fmin(range[1], array->range_max);
    }
}

int cvol_summarise_array(cvol_context *context, cvol_summary *out, const cvol_array *array)
{
    const size_t terms = cvol_array_block_terms(array);
    cvol_grid grid = array->grid;
    cvol_tally *tally = NULL;
    double range[2];
    if (cvol_array_summary(array)->state == CVOL_SUMMARY_KNOWN) {
        *out = *array->summary;
        return CVOL_OK;
    }
    *out = (cvol_summary){0};
    int code = cvol_array_decoded_terms(context, &array, array);
    if (code)
        return code;
    grid.type = CVOL_FLOAT64;
    const scratch s = {cvol_allocate(terms, sizeof *s.samples), cvol_allocate(terms, 1),
                       cvol_allocate(terms, sizeof *s.values)};
    code = s.samples && s.which && s.values
               ? cvol_tally_create(context, &tally, &grid, NULL)
               : cvol_fail_memory(context, terms * sizeof *s.values, "a block");
    if (!code)
        code = add_blocks(context, tally, &s, array);
    if (!code && cvol_tally_needs_another_pass(tally)) {
        find_range(range, array);
        if (!cvol_tally_has_mark(tally))
            cvol_tally_set_range(tally, range[0], range[1]);
        code = add_blocks(context, tally, &s, array);
    }
    if (!code) {
        cvol_tally_finish(tally, out);
        out->integers = cvol_type_is_integer(array->grid.type);
        out->distinct = 0;
    }
    cvol_tally_free(tally);
    free(s.samples);
    free(s.which);
    free(s.values);
    return code;
}
