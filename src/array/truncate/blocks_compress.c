/* Samples to blocks: gather, transform, truncate. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "array/block/block_transform.h"
#include "array/truncate/account.h"
#include "array/truncate/build.h"
#include "array/truncate/compress_array.h"
#include "array/truncate/producer.h"
#include "base/context.h"
#include "base/memory.h"

typedef struct source {
    const cvol_array *shape;
    const void *samples;
} source;

static int produce(const void *user, cvol_dense_block *block, size_t index, void *scratch)
{
    const source *s = user;
    const size_t count = cvol_array_block_terms(s->shape);
    float *samples = scratch, most = 0;
    cvol_array_gather(samples, s->samples, s->shape, index);
    for (size_t i = 0; i < count; i++)
        most = fabsf(samples[i]) > most ? fabsf(samples[i]) : most;
    cvol_block_to_slots(block->coefficients, samples, s->shape);
    block->max_abs = most;
    return CVOL_OK;
}

int cvol_blocks_compress(cvol_context *context, cvol_array *out, cvol_build_result *result,
                         const void *samples, const cvol_keep *keep)
{
    source s = {.shape = out, .samples = samples};
    cvol_producer producer = {.produce = produce,
                              .user = &s,
                              .scratch_bytes = cvol_array_block_terms(out) * sizeof(float),
                              .what = "compressing"};
    return cvol_build_blocks(context, out, result, &producer, keep);
}
