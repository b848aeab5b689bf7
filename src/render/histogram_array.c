/* The histogram of a compressed array, from a regular subset of its blocks. */
#include <stdlib.h>
#include <string.h>

#include "array/array.h"
#include "array/block_inverse.h"
#include "base/context.h"
#include "base/memory.h"
#include "render/histogram.h"

#define BLOCKS_MAX 1024

/* Samples of a block along one axis that lie within the volume. */
static size_t inside(const cvol_array *array, size_t place, int axis)
{
    size_t begin = place * (size_t)array->block;
    size_t left = array->grid.dims[axis] - begin;
    return left < (size_t)array->block ? left : (size_t)array->block;
}

typedef struct array_source {
    const cvol_array *array;
    float *samples; /* of a block */
} array_source;

static void visit_block(const array_source *of, size_t index,
                        void (*visit)(void *user, double value), void *user)
{
    const cvol_array *array = of->array;
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
    for (size_t z = 0; z < size[2]; z++)
        for (size_t y = 0; y < size[1]; y++)
            for (size_t x = 0; x < size[0]; x++) {
                const int masked = which[x + size[0] * (y + size[1] * z)];
                if (!masked)
                    visit(user, (double)of->samples[x + B * (y + B * z)] + array->offset);
                else if (apart)
                    visit(user, background);
            }
}

static void visit_blocks(const cvol_sample_source *source, void (*visit)(void *user, double value),
                         void *user)
{
    const array_source *of = source->of;
    const cvol_array *array = of->array;
    const size_t count = array->block_count < BLOCKS_MAX ? array->block_count : BLOCKS_MAX;
    for (size_t i = 0; i < count; i++) {
        size_t index = (size_t)((double)i * (double)array->block_count / (double)count);
        cvol_block_evaluate(of->samples, array, index);
        visit_block(of, index, visit, user);
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
    array_source of = {array, cvol_allocate(B * B * B, sizeof(float))};
    if (!of.samples)
        return cvol_fail_memory(context, B * B * B * sizeof(float), "a block");
    const cvol_sample_source source = {&of, visit_blocks};
    out->chord = cvol_histogram_chord(&array->grid);
    cvol_histogram_count(out, &source);
    free(of.samples);
    return CVOL_OK;
}
