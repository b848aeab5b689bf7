/* The product of two blocks: see block_product.h. */
#include "array/multiply/block_product.h"

#include "array/block/block_forward.h"
#include "array/block/block_inverse.h"
#include "base/cpu.h"

void CVOL_SIMD(cvol_block_product)(float *out, int box[3], const cvol_product_factor *a,
                                   const cvol_product_factor *b, int block_log2,
                                   cvol_product_work *work);

/* Only the terms, times `factor`, as dense coefficients. */
CVOL_INLINE void scatter_scaled(float *out, int box[3], const cvol_block *block, float factor,
                                int block_log2)
{
    const int B = 1 << block_log2;
    for (int axis = 0; axis < 3; axis++)
        box[axis] = block->low[axis];
    for (int w = 0; w < box[2]; w++)
        memset(out + w * B * B, 0, sizeof(float) * (size_t)(box[1] * B));
    const uint32_t *words = block->terms, *end = cvol_block_end(block);
    while (words < end) {
        uint32_t place;
        int32_t value = cvol_term_unpack(&words, &place, cvol_place_bits(block_log2));
        out[place] = factor * (float)value;
    }
}

/* a's samples: oa fb + ob fa + fa fb, times scale; rows of `width` lanes. */
CVOL_INLINE void multiply_samples(float *a, const float *b, ptrdiff_t count, float offset_a,
                                  float offset_b, float scale)
{
    for (ptrdiff_t i = 0; i < count; i += CVOL_LANES) {
        cvol_vf fa = cvol_load(a + i), fb = cvol_load(b + i);
        cvol_store(a + i, scale * (fa * (fb + offset_b) + offset_a * fb));
    }
}

/* One copy of the inverse for both operands, since it is long. */
static __attribute__((noinline)) void inverse_of(float *out, ptrdiff_t row_stride,
                                                 ptrdiff_t sheet_stride, const cvol_block *block,
                                                 const cvol_block_axes *axes, int block_log2,
                                                 float step, cvol_block_work *work)
{
    cvol_block_inverse(out, row_stride, sheet_stride, block, axes, block_log2, step, work);
}

CVOL_INLINE void product(float *out, int box[3], const cvol_product_factor *a,
                         const cvol_product_factor *b, int block_log2, cvol_product_work *work)
{
    const int B = 1 << block_log2, width = B < 16 ? 16 : B;
    int points[3];
    for (int axis = 0; axis < 3; axis++) {
        int degree = a->block->low[axis] + b->block->low[axis] - 1;
        box[axis] = degree < B ? degree : B;
        points[axis] = (box[axis] + 1) & ~1;
    }
    float *samples_a = work->memory[0], *samples_b = work->memory[1];
    cvol_block_work *inverse = (cvol_block_work *)(void *)work->memory[2];
    const float *row_basis = cvol_block_points_basis(B, points[1]);
    const float *sheet_basis = cvol_block_points_basis(B, points[2]);
    cvol_block_axes axes = {.lane = 0,
                            .row = 1,
                            .sheet = 2,
                            .lane_points = width,
                            .row_points = points[1],
                            .sheet_points = points[2],
                            .lane_basis = cvol_block_lane_basis(B),
                            .row_basis = row_basis,
                            .sheet_basis = sheet_basis};
    const ptrdiff_t sheet = (ptrdiff_t)points[1] * width;
    inverse_of(samples_a, width, sheet, a->block, &axes, block_log2, a->step, inverse);
    inverse_of(samples_b, width, sheet, b->block, &axes, block_log2, b->step, inverse);
    multiply_samples(samples_a, samples_b, sheet * points[2], a->offset, b->offset,
                     (float)(B * B) / (float)(points[1] * points[2]));
    cvol_forward_axes forward = {.row_points = points[1],
                                 .sheet_points = points[2],
                                 .row_basis = row_basis,
                                 .sheet_basis = sheet_basis,
                                 .columns = cvol_block_columns(B),
                                 .box = {box[0], box[1], box[2]}};
    cvol_block_forward_box(out, samples_a, samples_b, &forward, B);
}

void CVOL_SIMD(cvol_block_product)(float *out, int box[3], const cvol_product_factor *a,
                                   const cvol_product_factor *b, int block_log2,
                                   cvol_product_work *work)
{
    if (a->block->words == 0)
        scatter_scaled(out, box, b->block, a->offset * b->step, block_log2);
    else if (b->block->words == 0)
        scatter_scaled(out, box, a->block, b->offset * a->step, block_log2);
    else if (block_log2 == 4)
        product(out, box, a, b, 4, work);
    else if (block_log2 == 3)
        product(out, box, a, b, 3, work);
    else
        product(out, box, a, b, 5, work);
}
