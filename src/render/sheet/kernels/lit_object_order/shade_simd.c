/* Mode composite with light, and surfaces (shade.h). */
#include "render/sheet/kernels/lit_object_order/shade.h"

void CVOL_SIMD(cvol_sheet_shade)(const cvol_layer *layer, const cvol_sheet_table *table,
                                 const cvol_line *line)
{
    line_job job;
    begin_line(&job, layer, table, line);
    if (layer->sheet_count)
        draw_lit_line(&job);
    else
        end_line(&job, layer->cover_at != 0);
}
