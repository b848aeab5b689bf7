/* Half or twice the samples along each axis, block by block of the result.
 *
 *     half   b[x] = (a[2 x] + a[2 x + 1]) / 2, mirrored at the end: a last odd sample stays
 *     twice  b[2 x] = (3 a[x] + a[x - 1]) / 4,   b[2 x + 1] = (3 a[x] + a[x + 1]) / 4 */
#include <string.h>

#include "array/algebra/operations.h"
#include "array/block/block_transform.h"
#include "array/block/halo.h"
#include "array/truncate/account.h"
#include "array/truncate/blocks_keep.h"
#include "array/truncate/build.h"
#include "array/truncate/producer.h"

typedef struct resampling {
    const cvol_array *a, *shape;
    int twice;
} resampling;

/* Resamples an axis whose neighbours lie `stride` apart: `count` results for each line. The lines
 * form `outer` groups of `stride`. */
static void along(float *out, const float *in, size_t outer, size_t stride, size_t count,
                  size_t in_count, int twice)
{
    for (size_t o = 0; o < outer; o++)
        for (size_t x = 0; x < count; x++) {
            const float *from = in + o * in_count * stride;
            float *to = out + (o * count + x) * stride;
            /* twice: in[0] lies one before the first result's own sample */
            const float *near = from + stride * (twice ? x / 2 + 1 : 2 * x);
            const float *far = !twice || x % 2 ? near + stride : near - stride;
            const float w = twice ? 0.75f : 0.5f;
            for (size_t i = 0; i < stride; i++)
                to[i] = w * near[i] + (1 - w) * far[i];
        }
}

static size_t input_side(const resampling *r)
{
    const size_t B = (size_t)r->a->block;
    return r->twice ? B / 2 + 2 : 2 * B;
}

/* Floats for a block at any time between its axes, a multiple of 16. */
static size_t room_of(const resampling *r)
{
    const size_t B = (size_t)r->a->block, need = input_side(r), side = need > B ? need : B;
    size_t room = 1;
    for (int a = 0; a < r->a->rank; a++)
        room *= side;
    return (room + 15) & ~(size_t)15;
}

static int produce(const void *user, cvol_dense_block *block, size_t index, void *scratch)
{
    const resampling *r = user;
    const int rank = r->a->rank;
    const size_t need = input_side(r);
    size_t at[3], size[3];
    ptrdiff_t begin[3];
    cvol_block_origin(at, r->shape, index);
    for (int a = 0; a < 3; a++) {
        size[a] = a < rank ? need : 1;
        begin[a] = a >= rank ? 0 : r->twice ? (ptrdiff_t)(at[a] / 2) - 1 : (ptrdiff_t)(2 * at[a]);
    }
    float *one = (float *)((char *)scratch + cvol_halo_bytes(r->a));
    float *other = one + room_of(r);
    cvol_halo_read(one, scratch, r->a, begin, size);
    for (int a = 0; a < rank; a++) {
        const size_t stride = a == 0 ? 1 : a == 1 ? size[0] : size[0] * size[1];
        const size_t outer = size[0] * size[1] * size[2] / (stride * size[a]);
        along(other, one, outer, stride, (size_t)r->a->block, size[a], r->twice);
        size[a] = (size_t)r->a->block;
        float *swap = one;
        one = other;
        other = swap;
    }
    block->max_abs = cvol_halo_finish(block->coefficients, one, r->shape, index);
    return CVOL_OK;
}

int cvol_blocks_resample(cvol_context *context, cvol_array *out, cvol_build_result *result,
                         const cvol_array *a, const cvol_keep *keep)
{
    resampling r = {.a = a, .shape = out};
    for (int i = 0; i < a->rank; i++)
        r.twice = r.twice || out->grid.dims[i] > a->grid.dims[i];
    cvol_blocks_set_expected_bound(out, a->error_bound);
    const cvol_keep resolved = cvol_blocks_keep_for_filter(out, keep, 1, a);
    const cvol_producer producer = {.produce = produce,
                                    .user = &r,
                                    .scratch_bytes = cvol_halo_bytes(a) +
                                                     2 * room_of(&r) * sizeof(float),
                                    .what = "resampling"};
    return cvol_build_blocks(context, out, result, &producer, &resolved);
}
