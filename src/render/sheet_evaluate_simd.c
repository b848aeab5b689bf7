/* Evaluation of blocks onto a layer's samples; pictures may use fused multiply-add. */
#include "base/vector.h"
#include "render/sheet.h"

void CVOL_SIMD(cvol_sheet_evaluate)(float *out, long row_stride, long sheet_stride,
                                    const cvol_block *block, const cvol_block_axes *axes,
                                    int block_log2, float step, cvol_block_work *work)
{
    cvol_block_inverse(out, row_stride, sheet_stride, block, axes, block_log2, step, work);
}
