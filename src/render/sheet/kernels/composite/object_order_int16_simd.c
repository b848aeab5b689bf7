/* Mode composite for int16 samples (render/sheet/kernels/composite/int16.h): for the widest vectors
 * only (render/sheet/frame/policy.c). */
#define SHEET_INT16 1
#include "render/sheet/kernels/composite/line.h"
#if defined(__AVX512F__)
#include "render/sheet/kernels/composite/composite.h"

#include "render/sheet/kernels/composite/entry.h"
#include "render/sheet/kernels/composite/int16.h"
#endif

void CVOL_SIMD(cvol_sheet_composite_int16)(const cvol_layer *layer, const cvol_sheet_table *table,
                                           const cvol_line *line)
{
#if defined(__AVX512F__)
    line_job job;
    begin_line(&job, layer, table, line);
    if (table->int16.usable)
        layer->unit ? draw_int16_line(&job, 1, CVOL_SEGMENTS)
                    : draw_int16_line(&job, 0, CVOL_SEGMENTS);
    else
        draw_line_of_kind(&job);
#endif
    (void)layer;
    (void)table;
    (void)line;
}
