/* Mode composite (composite.h). */
#include "render/sheet/kernels/composite/composite.h"

#include "render/sheet/kernels/composite/entry.h"

void CVOL_SIMD(cvol_sheet_composite)(const cvol_layer *layer, const cvol_sheet_table *table,
                                     const cvol_line *line)
{
    line_job job;
    begin_line(&job, layer, table, line);
    draw_line_of_kind(&job);
}
