/* Mode composite in image order, with samples between slices. */
#define SHEET_IMAGE_ORDER 1
#define SHEET_EXTRAS 1
#include "render/sheet/kernels/composite/composite.h"

void CVOL_SIMD(cvol_sheet_image_order_extra)(const cvol_layer *layer, const cvol_sheet_table *table,
                                             const cvol_line *line)
{
    line_job job;
    begin_line(&job, layer, table, line);
    draw_line(&job, 0, 0, 0, table->segments ? CVOL_SEGMENTS : 0);
}
