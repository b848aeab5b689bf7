/* Modes mip and min for int16 samples (int16.h). */
#define SHEET_INT16 1
#include "render/sheet/kernels/project/int16.h"

void CVOL_SIMD(cvol_sheet_max_int16)(const cvol_layer *layer, const cvol_sheet_table *table,
                                     const cvol_line *line)
{
    (void)table;
    draw_int16_extremes(layer, line, 1);
}

void CVOL_SIMD(cvol_sheet_min_int16)(const cvol_layer *layer, const cvol_sheet_table *table,
                                     const cvol_line *line)
{
    (void)table;
    draw_int16_extremes(layer, line, 0);
}
