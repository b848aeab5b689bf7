/* The samplewise product of two arrays in blocks: block by block, within the cache.
 *
 * Volumes (rank 3 under DCT) use block_product.h. All others evaluate both blocks, multiply, and
 * transform back. For lapped volumes the samples are read through halo.h; the product of two lapped
 * volumes is lapped. */
#include "array/algebra/result_mask.h"
#include "array/block/halo.h"
#include "array/multiply/block_product.h"
#include "array/multiply/multiply.h"
#include "array/truncate/account.h"
#include "array/truncate/blocks_keep.h"
#include "array/truncate/build.h"
#include "array/truncate/producer.h"
#include "array/truncate/result_block.h"
#include "base/cpu.h"

/* Samples of a neighbour that the filter of a lapped result reads. */
enum { REACH = 2 };

CVOL_SIMD_DECLARE(void, cvol_block_product,
                  (float *out, int box[3], const cvol_product_factor *a,
                   const cvol_product_factor *b, int block_log2, cvol_product_work *work));

void cvol_block_product(float *out, int box[3], const cvol_product_factor *a,
                        const cvol_product_factor *b, int block_log2, cvol_product_work *work)
{
    CVOL_SIMD_CHOOSE(cvol_block_product)(out, box, a, b, block_log2, work);
}

typedef struct factors {
    const cvol_array *a, *b, *shape;
    cvol_masked_operands *operands; /* a and b, where their background differs; or NULL */
} factors;

static cvol_product_factor factor_of(const cvol_array *array, size_t index)
{
    return (cvol_product_factor){.block = &array->block_table[index],
                                 .step = (float)array->step,
                                 .offset = (float)array->offset};
}

/* a becomes the product minus the product of the offsets. */
static void multiply_samples(float *a, const float *b, const factors *f, size_t count)
{
    const float offset_a = (float)f->a->offset, offset_b = (float)f->b->offset;
    for (size_t i = 0; i < count; i++)
        a[i] = a[i] * (b[i] + offset_b) + offset_a * b[i];
}

/* A block in which an operand's background ends, while the result's does not: from samples. */
static int produce_masked(const factors *f, cvol_dense_block *block, size_t index, void *scratch)
{
    const cvol_array *a = &f->operands->a, *b = &f->operands->b;
    const size_t halo_a = cvol_halo_bytes(a), room = cvol_result_box_room(f->shape);
    const float offset = (float)(a->offset * b->offset);
    float *x = (float *)((char *)scratch + halo_a + cvol_halo_bytes(b)), *y = x + room;
    size_t size[3];
    ptrdiff_t begin[3];
    const size_t count = cvol_result_box(begin, size, f->shape, index);
    cvol_halo_read(x, scratch, a, begin, size);
    cvol_halo_read(y, (char *)scratch + halo_a, b, begin, size);
    for (size_t i = 0; i < count; i++)
        x[i] = x[i] * y[i] - offset;
    cvol_result_put(block, x, y + room, f->shape, index);
    block->max_abs = -1;
    return CVOL_OK;
}

/* 1 if the block must be multiplied from samples, in which the background is replaced. The boxes of
 * lapped results overlap, and there all must have the same samples. */
static int differs(const factors *f, size_t index)
{
    return f->operands &&
           cvol_masked_operands_differ(f->operands, index, f->shape->lapped ? REACH : 0);
}

static int produce_mixed_product(const void *user, cvol_dense_block *block, size_t index,
                                 void *scratch)
{
    const factors *f = user;
    const size_t count = cvol_array_block_terms(f->a);
    float *a = scratch, *b = a + count;
    cvol_block_evaluate(a, f->a, index);
    cvol_block_evaluate(b, f->b, index);
    multiply_samples(a, b, f, count);
    block->max_abs = -1;
    for (int axis = 0; axis < 3; axis++)
        block->box[axis] = axis < f->a->rank ? f->a->block : 1;
    cvol_result_transform(block, a, b, f->shape);
    return CVOL_OK;
}

static int produce_lapped(const void *user, cvol_dense_block *block, size_t index, void *scratch)
{
    const factors *f = user;
    if (differs(f, index))
        return produce_masked(f, block, index, scratch);
    const size_t halo_a = cvol_halo_bytes(f->a), room = cvol_result_box_room(f->shape);
    float *a = (float *)((char *)scratch + halo_a + cvol_halo_bytes(f->b)), *b = a + room;
    if (f->shape->lapped) {
        size_t size[3];
        ptrdiff_t begin[3];
        const size_t count = cvol_result_box(begin, size, f->shape, index);
        cvol_halo_read_terms(a, scratch, f->a, begin, size);
        cvol_halo_read_terms(b, (char *)scratch + halo_a, f->b, begin, size);
        multiply_samples(a, b, f, count);
    } else {
        cvol_halo_evaluate(a, scratch, f->a, index);
        cvol_halo_evaluate(b, (char *)scratch + halo_a, f->b, index);
        multiply_samples(a, b, f, cvol_array_block_terms(f->a));
    }
    cvol_result_put(block, a, b, f->shape, index);
    block->max_abs = -1;
    return CVOL_OK;
}

static int produce_volume(const void *user, cvol_dense_block *block, size_t index, void *scratch)
{
    const factors *f = user;
    if (differs(f, index))
        return produce_masked(f, block, index, scratch);
    const cvol_product_factor a = factor_of(f->a, index), b = factor_of(f->b, index);
    if (a.block->split || b.block->split)
        return produce_mixed_product(user, block, index, scratch);
    block->max_abs = -1;
    cvol_block_product(block->coefficients, block->box, &a, &b, f->a->block_log2, scratch);
    return CVOL_OK;
}

int cvol_blocks_multiply(cvol_context *context, cvol_array *out, cvol_build_result *result,
                         const cvol_array *a, const cvol_array *b, const cvol_keep *keep)
{
    const int volume = a->rank == 3 && a->transform == CVOL_DCT;
    cvol_masked_operands operands;
    factors f = {a, b, out, NULL};
    out->lapped = a->lapped && b->lapped;
    const size_t samples = (2 * cvol_result_box_room(out) + cvol_result_scratch(out)) *
                           sizeof(float);
    cvol_producer producer = {.produce = volume ? produce_volume : produce_mixed_product,
                              .user = &f,
                              .scratch_bytes = volume && sizeof(cvol_product_work) > samples
                                                   ? sizeof(cvol_product_work)
                                                   : samples,
                              .what = "multiplying"};
    int code = cvol_result_mask_combine(context, out, &operands, a, b, 1,
                                        cvol_array_background(a) * cvol_array_background(b));
    if (operands.masks[0] || operands.masks[1])
        f.operands = &operands;
    if (a->lapped || b->lapped)
        producer.produce = produce_lapped;
    if (a->lapped || b->lapped || f.operands) {
        const size_t bytes = cvol_halo_bytes(a) + cvol_halo_bytes(b) + samples;
        producer.scratch_bytes = bytes > producer.scratch_bytes ? bytes : producer.scratch_bytes;
    }
    out->offset = a->offset * b->offset;
    cvol_blocks_set_expected_bound(out,
                                   cvol_error_bound_multiply(&a->error_bound, &b->error_bound));
    cvol_keep resolved;
    if (!code)
        code = cvol_blocks_keep_for_multiply(context, &resolved, out, keep, a, b);
    if (!code)
        code = cvol_build_blocks(context, out, result, &producer, &resolved);
    cvol_masked_operands_free(&operands);
    return code;
}
