/* Puts a background where its samples are (sheet_mask.h). */
#include "render/sheet.h"

/* 1 << lane, of the lanes from `first` on. */
CVOL_INLINE cvol_vi lane_bits(int first)
{
    cvol_vi bits;
    for (int i = 0; i < CVOL_LANES; i++)
        bits[i] = 1 << (first + i);
    return bits;
}

void CVOL_SIMD(cvol_sheet_lay)(float *samples, long row_stride, long sheet_stride, int rows,
                               int sheets, int lanes, const uint16_t *bits, int row_step,
                               int sheet_step, float background)
{
    for (int z = 0; z < sheets; z++)
        for (int y = 0; y < rows; y++)
            for (int x = 0; x < lanes; x += 16) {
                const int row = bits[z * sheet_step + y * row_step + x / 16];
                float *at = samples + z * sheet_stride + y * row_stride + x;
                if (!row)
                    continue;
                /* Blocks of 8: the bits of the other eight are 0, and nothing is stored there. */
                for (int i = 0; i < 16 && x + i < lanes; i += CVOL_LANES) {
                    const cvol_vi here = lane_bits(i), masked = (row & here) == here;
                    const cvol_vf v = cvol_select(masked, cvol_splat(background),
                                                  cvol_load(at + i));
                    if (lanes - x - i >= CVOL_LANES)
                        cvol_store(at + i, v);
                    else
                        cvol_store_first(at + i, v, lanes - x - i);
                }
            }
}
