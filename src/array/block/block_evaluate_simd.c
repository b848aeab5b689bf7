/* The block evaluation of files and figures: without fused multiply-add, so that every processor
 * decodes exactly the samples that the encoder verified. */
#include "array/block/block_inverse.h"
#include "base/cpu.h"

void CVOL_SIMD(cvol_block_decode)(float *out, const cvol_block *block, const cvol_block_axes *axes,
                                  int block_log2, float step, cvol_block_work *work);

void CVOL_SIMD(cvol_block_decode)(float *out, const cvol_block *block, const cvol_block_axes *axes,
                                  int block_log2, float step, cvol_block_work *work)
{
    const ptrdiff_t B = (ptrdiff_t)1 << block_log2;
    cvol_block_inverse(out, B, B * B, block, axes, block_log2, step, work);
}
