/* Sampled cells. */
#include "codec/quantize/split_sample.h"

#include <math.h>
#include <stdlib.h>

#include "base/context.h"
#include "base/memory.h"
#include "codec/quantize/split_extension.h"
#include "codec/quantize/split_fast.h"
#include "transform/cell.h"

struct cvol_cell_sample {
    size_t count;
    float *cells;
    int (*inside)[3]; /* samples within the volume */
};

/* Point k of the sequence, on the grid of cells. */
static void place_at(size_t place[3], size_t k, const size_t grid[3])
{
    static const double steps[3] = {0.8191725133961645, 0.6710436067037893, 0.5497004779019703};
    for (int a = 0; a < 3; a++) {
        const double turns = ((double)k + 0.5) * steps[a];
        place[a] = (size_t)((turns - floor(turns)) * (double)grid[a]);
    }
}

static void read_cells(const cvol_cell_sample *sample, const cvol_array *shape,
                       const cvol_slab *slab, float *scratch, size_t begin, size_t end)
{
    static const size_t one[3] = {1, 1, 1};
    const size_t *blocks = shape->blocks;
    for (size_t k = begin; k < end; k++) {
        size_t place[3] = {k % blocks[0], k / blocks[0] % blocks[1], k / blocks[0] / blocks[1]};
        if (sample->count < shape->block_count)
            place_at(place, k, blocks);
        cvol_cell_find_inside(sample->inside[k], shape->grid.dims, place);
        cvol_brick_gather(sample->cells + k * CVOL_CELL_SAMPLES, scratch, slab, shape, place, one);
    }
}

int cvol_cell_sample_make(cvol_context *context, cvol_cell_sample **out, const cvol_array *shape,
                          const cvol_slab *slab, size_t most)
{
    enum { AT_ONCE = 16 };
    static const size_t one[3] = {1, 1, 1};
    cvol_cell_sample *sample = cvol_allocate_zero(1, sizeof *sample);
    *out = sample;
    if (!sample)
        return cvol_fail_memory(context, sizeof *sample, "the sampled cells");
    sample->count = shape->block_count < most ? shape->block_count : most;
    sample->cells = cvol_allocate(sample->count * CVOL_CELL_SAMPLES, sizeof *sample->cells);
    sample->inside = cvol_allocate(sample->count, sizeof *sample->inside);
    int failed = !sample->cells || !sample->inside;
#pragma omp parallel num_threads(cvol_context_threads(context))
    {
        float *scratch = cvol_allocate(cvol_brick_scratch(shape, one), sizeof *scratch);
        if (!scratch) {
#pragma omp atomic write
            failed = 1;
        }
#pragma omp for schedule(dynamic)
        for (size_t k = 0; k < sample->count; k += AT_ONCE) {
            const size_t end = k + AT_ONCE < sample->count ? k + AT_ONCE : sample->count;
            if (scratch && sample->cells && sample->inside)
                read_cells(sample, shape, slab, scratch, k, end);
        }
        free(scratch);
    }
    if (!failed)
        return CVOL_OK;
    const size_t bytes = sample->count * CVOL_CELL_SAMPLES * sizeof *sample->cells;
    cvol_cell_sample_free(sample);
    *out = NULL;
    return cvol_fail_memory(context, bytes, "the sampled cells");
}

void cvol_cell_sample_free(cvol_cell_sample *sample)
{
    if (!sample)
        return;
    free(sample->cells);
    free(sample->inside);
    free(sample);
}

int cvol_cell_sample_error(cvol_context *context, double *error, const cvol_cell_sample *sample,
                           double step, int plain, size_t every)
{
    const size_t count = (sample->count + every - 1) / every;
    double *errors = cvol_allocate(count, sizeof *errors), sum = 0;
    int failed = !errors;
#pragma omp parallel num_threads(cvol_context_threads(context))
    {
        cvol_split_fast *fast = cvol_split_fast_create();
        if (!fast) {
#pragma omp atomic write
            failed = 1;
        }
#pragma omp for schedule(dynamic, 8)
        for (size_t i = 0; i < count; i++)
            if (fast && errors)
                errors[i] = cvol_split_fast_error(fast,
                                                  sample->cells + i * every * CVOL_CELL_SAMPLES,
                                                  sample->inside[i * every], step, plain);
        cvol_split_fast_free(fast);
    }
    for (size_t i = 0; i < count && !failed; i++)
        sum += errors[i];
    free(errors);
    *error = sum / (double)count * step * step;
    return failed ? cvol_fail_memory(context, count * sizeof *errors, "the sampled cells")
                  : CVOL_OK;
}
