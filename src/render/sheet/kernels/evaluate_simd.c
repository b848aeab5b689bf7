/* Evaluation of blocks onto a layer's samples; pictures may use fused multiply-add. */
#include "base/vector.h"
#include "render/sheet/frame/frame.h"

void CVOL_SIMD(cvol_sheet_evaluate)(float *out, ptrdiff_t row_stride, ptrdiff_t sheet_stride,
                                    const cvol_block *block, const cvol_block_axes *axes,
                                    int block_log2, float step, cvol_block_work *work)
{
    cvol_block_inverse(out, row_stride, sheet_stride, block, axes, block_log2, step, work);
}

void CVOL_SIMD(cvol_sheet_evaluate_int16)(int16_t *out, ptrdiff_t row_stride,
                                          ptrdiff_t sheet_stride, const cvol_block *block,
                                          const cvol_block_axes *axes, int block_log2, float step,
                                          const cvol_int16_scale *int16, cvol_block_work *work)
{
    const cvol_block_out to = {out, row_stride, sheet_stride, 1, int16->offset};
    cvol_block_inverse_to(&to, block, axes, block_log2, step * int16->scale, work);
}

void CVOL_SIMD(cvol_sheet_copy_int16)(int16_t *out, ptrdiff_t row_stride, ptrdiff_t sheet_stride,
                                      const float *in, ptrdiff_t in_row_stride,
                                      ptrdiff_t in_sheet_stride, const cvol_int16_scale *int16)
{
    for (int z = 0; z < 16; z++)
        for (int y = 0; y < 16; y++)
            for (int x = 0; x < 16; x += CVOL_LANES) {
                const cvol_vf v = cvol_load(in + z * in_sheet_stride + y * in_row_stride + x);
                cvol_store_int16(out + z * sheet_stride + y * row_stride + x,
                                 v * int16->scale + int16->offset, CVOL_LANES);
            }
}
