/* Mode composite with light in image order, from float samples. */
#define SHEET_IMAGE_ORDER 1
#include "render/sheet/kernels/composite/line.h"

#include "render/sheet/kernels/lit_image_order/shade.h"

void CVOL_SIMD(cvol_sheet_image_order_shade)(const cvol_layer *layer, const cvol_sheet_table *table,
                                             const cvol_line *line)
{
    draw_lit(layer, table, line);
}
