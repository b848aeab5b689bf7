/* Mode composite in image order (line_slanted.h). */
#define SHEET_IMAGE_ORDER 1
#include "render/sheet/kernels/composite/composite.h"

#include "render/sheet/kernels/composite/entry.h"

void CVOL_SIMD(cvol_sheet_image_order)(const cvol_layer *layer, const cvol_sheet_table *table,
                                       const cvol_line *line)
{
    line_job job;
    begin_line(&job, layer, table, line);
    HAVE_SEGMENTS && table->segments ? draw_line(&job, 0, 0, 0, CVOL_SEGMENTS)
                                     : draw_line(&job, 0, 0, 0, 0);
}
