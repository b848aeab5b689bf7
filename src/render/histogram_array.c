/* The histogram of a compressed array, from a regular subset of its blocks. */
#include <stdlib.h>
#include <string.h>

#include "array/array.h"
#include "array/block_inverse.h"
#include "base/context.h"
#include "base/memory.h"
#include "cvol/render.h"

#define BLOCKS_MAX 1024

/* Samples of a block along one axis that lie within the volume. */
static size_t inside(const cvol_array *array, size_t place, int axis)
{
    size_t begin = place * (size_t)array->block;
    size_t left = array->grid.dims[axis] - begin;
    return left < (size_t)array->block ? left : (size_t)array->block;
}

static void count_block(cvol_histogram *out, const cvol_array *array, const float *samples,
                        size_t index)
{
    const size_t B = (size_t)array->block;
    size_t place[3] = {index % array->blocks[0], index / array->blocks[0] % array->blocks[1],
                       index / array->blocks[0] / array->blocks[1]};
    uint8_t which[CVOL_BLOCK_MAX * CVOL_BLOCK_MAX * CVOL_BLOCK_MAX] = {0};
    const size_t size[3] = {inside(array, place[0], 0), inside(array, place[1], 1),
                            inside(array, place[2], 2)};
    if (array->mask) {
        size_t begin[3], end[3];
        cvol_block_origin(begin, array, index);
        for (int a = 0; a < 3; a++)
            end[a] = begin[a] + size[a];
        cvol_mask_get(which, array->mask, begin, end);
    }
    const int apart = cvol_mask_is_background(array->mask);
    const double background = apart ? cvol_fills_value(cvol_mask_fills(array->mask), 0,
                                                       array->grid.type)
                                    : 0;
    double span = out->max - out->min, scale = span > 0 ? CVOL_HISTOGRAM_BINS / span : 0;
    for (size_t z = 0; z < size[2]; z++)
        for (size_t y = 0; y < size[1]; y++)
            for (size_t x = 0; x < size[0]; x++) {
                const int masked = which[x + size[0] * (y + size[1] * z)];
                if (masked && !apart)
                    continue;
                double value = masked ? background
                                      : (double)samples[x + B * (y + B * z)] + array->offset;
                double bin = (value - out->min) * scale;
                size_t i = bin <= 0                     ? 0
                           : bin >= CVOL_HISTOGRAM_BINS ? CVOL_HISTOGRAM_BINS - 1
                                                        : (size_t)bin;
                out->bins[i]++;
            }
}

int cvol_array_histogram(cvol_context *context, cvol_histogram *out, const cvol_array *array)
{
    const size_t B = (size_t)array->block;
    int code = cvol_array_need_volume(context, array, "a histogram");
    if (code)
        return code;
    memset(out, 0, sizeof *out);
    out->min = array->ledger.value_min;
    out->max = array->ledger.value_max;
    if (!array->measured && array->has_ranges) { /* bounds of results may be wide */
        out->min = array->range_min > out->min ? array->range_min : out->min;
        out->max = array->range_max < out->max ? array->range_max : out->max;
    }
    size_t count = array->block_count < BLOCKS_MAX ? array->block_count : BLOCKS_MAX;
    float *samples = cvol_allocate(B * B * B, sizeof *samples);
    if (!samples)
        return cvol_fail_memory(context, B * B * B * sizeof *samples, "a block");
    for (size_t i = 0; i < count; i++) {
        size_t index = (size_t)((double)i * (double)array->block_count / (double)count);
        cvol_block_evaluate(samples, array, index);
        count_block(out, array, samples, index);
    }
    free(samples);
    return CVOL_OK;
}
