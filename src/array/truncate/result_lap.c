/* The choice between lapped and plain blocks of a result: result_lap.h. */
#include "array/truncate/result_lap.h"

#include <stdlib.h>

#include "array/block/cell_weight.h"
#include "array/truncate/result_block.h"
#include "array/truncate/visible.h"
#include "base/context.h"
#include "base/memory.h"
#include "transform/cell.h"

/* About this many blocks are compared. */
enum { BLOCKS = 128 };

/* One thread's memory. */
typedef struct workplace {
    float *coefficients, *values;
    uint32_t *places;
    uint8_t *visible;
    void *scratch;
} workplace;

static int make(workplace *w, const cvol_producer *producer)
{
    w->coefficients = cvol_allocate_zero(CVOL_CELL_SAMPLES, sizeof(float));
    w->values = cvol_allocate(CVOL_CELL_SAMPLES, sizeof(float));
    w->places = cvol_allocate(CVOL_CELL_SAMPLES, sizeof(uint32_t));
    w->visible = cvol_allocate(CVOL_CELL_SAMPLES, 1);
    w->scratch = cvol_allocate_zero(producer->scratch_bytes, 1);
    return w->coefficients && w->values && w->places && w->visible && w->scratch;
}

static void release(workplace *w)
{
    free(w->coefficients);
    free(w->values);
    free(w->places);
    free(w->visible);
    free(w->scratch);
}

int cvol_result_may_lap(const cvol_array *shape)
{
    return cvol_array_is_volume(shape) && shape->block == CVOL_CELL;
}

/* The weight of a block, as the producer makes it. */
static int weigh(double *weight, const workplace *w, const cvol_array *shape,
                 const cvol_producer *producer, size_t index, float step)
{
    float weights[8];
    cvol_dense_block block = {.coefficients = w->coefficients,
                              .box = {CVOL_CELL, CVOL_CELL, CVOL_CELL},
                              .energy = -1,
                              .max_abs = -1,
                              .places = w->places,
                              .values = w->values,
                              .count = -1,
                              .expected_step = step};
    *weight = 0;
    if (!cvol_visible_find(w->visible, shape, index))
        return CVOL_OK;
    const int code = producer->produce(producer->user, &block, index, w->scratch);
    if (code)
        return code;
    const int dcs = block.split == CVOL_CELL_WHOLE ? 1 : block.split == CVOL_CELL_FOURS ? 4 : 2;
    cvol_cell_weigh(weights, w->coefficients, 1 / step, dcs);
    for (int i = 0; i < 8; i++)
        *weight += (double)weights[i];
    return CVOL_OK;
}

/* One of `stride` blocks from i stride on, an irregular one: rows and slices of blocks are regular.
 */
static size_t block_of(size_t i, size_t stride)
{
    const uint32_t mixed = (uint32_t)i * UINT32_C(2654435761);
    return i * stride + (mixed >> 16) % stride;
}

/* The sum of the weights of one block in `stride`. */
static int weigh_all(cvol_context *context, double *sum, const cvol_array *shape,
                     const cvol_producer *producer, float step, size_t stride)
{
    const size_t count = shape->block_count / stride;
    double *of = cvol_allocate_zero(count, sizeof *of);
    int failed = of ? CVOL_OK : CVOL_ERROR_MEMORY;
#pragma omp parallel num_threads(cvol_context_threads(context)) if (of)
    {
        workplace w;
        const int ready = make(&w, producer);
#pragma omp for schedule(dynamic)
        for (size_t i = 0; i < count; i++) {
            const int code = !of || !ready
                                 ? CVOL_ERROR_MEMORY
                                 : weigh(&of[i], &w, shape, producer, block_of(i, stride), step);
            if (code) {
#pragma omp atomic write
                failed = code;
            }
        }
        release(&w);
    }
    *sum = 0;
    for (size_t i = 0; i < count && !failed; i++)
        *sum += of[i];
    free(of);
    if (failed == CVOL_ERROR_MEMORY)
        return cvol_fail_memory(context, producer->scratch_bytes, producer->what);
    return failed ? cvol_fail(context, failed, "%s: a block could not be computed", producer->what)
                  : CVOL_OK;
}

int cvol_result_choose_lap(cvol_context *context, cvol_array *shape, const cvol_producer *producer,
                           const cvol_keep *keep, int otherwise)
{
    double plain = 0, lapped = 0;
    const size_t stride = shape->block_count > BLOCKS ? shape->block_count / BLOCKS : 1;
    shape->lapped = otherwise;
    if (keep->rule != CVOL_KEEP_LOSS || !cvol_result_may_lap(shape))
        return CVOL_OK;
    const float step = (float)cvol_result_expected_step(shape, keep->value);
    shape->lapped = 0;
    int code = weigh_all(context, &plain, shape, producer, step, stride);
    shape->lapped = 1;
    if (!code)
        code = weigh_all(context, &lapped, shape, producer, step, stride);
    shape->lapped = lapped < plain;
    return code;
}
