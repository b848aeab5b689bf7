/* Mode composite with light in image order, from int16 samples: for the widest vectors only
 * (render/sheet/frame/policy.c). */
#define SHEET_IMAGE_ORDER 1
#define SHEET_INT16 1
#include "render/sheet/kernels/composite/line.h"
#if defined(__AVX512F__)
#include "render/sheet/kernels/lit_image_order/shade.h"
#endif

void CVOL_SIMD(cvol_sheet_image_order_shade_int16)(const cvol_layer *layer,
                                                   const cvol_sheet_table *table,
                                                   const cvol_line *line)
{
#if defined(__AVX512F__)
    draw_lit(layer, table, line);
#endif
    (void)layer;
    (void)table;
    (void)line;
}
