/* Mode composite with light in image order, from int16 samples: for the widest vectors only
 * (render/sheet/engine.c). */
#define SHEET_IMAGE_ORDER 1
#define SHEET_INT16 1
#include "render/sheet/kernels/composite/line.h"
#if defined(__AVX512F__)
#include "render/sheet/kernels/lit_image_order/shade.h"
#endif

void CVOL_SIMD(cvol_sheet_image_order_shade)(const cvol_layer *layer, const cvol_sheet_table *table,
                                             const cvol_line *line)
{
#if defined(__AVX512F__)
    const float scale = table->scale / layer->int16.scale, offset = -table->from * table->scale;
    line_job job = {.layer = layer,
                    .table = table,
                    .line = line,
                    .table_offset = offset,
                    .sample_scale = scale,
                    .sample_offset = offset - layer->int16.offset * scale};
    const int segments = table->segments ? CVOL_SEGMENTS : 0;
    if (layer->sheet_count)
        draw_lit_line(&job, segments);
    else
        end_lit_line(&job, segments);
#endif
    (void)layer;
    (void)table;
    (void)line;
}
