/* Mode composite in image order (line_slanted.h). */
#define SHEET_IMAGE_ORDER 1
#include "render/sheet/kernels/composite/composite.h"

void CVOL_SIMD(cvol_sheet_image_order)(const cvol_layer *layer, const cvol_sheet_table *table,
                                       const cvol_line *line)
{
    line_job job;
    begin_line(&job, layer, table, line);
    draw_line(&job, 0, 0, 0, HAVE_SEGMENTS && table->segments ? CVOL_SEGMENTS : 0);
}
