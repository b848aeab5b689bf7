/* Mode composite with light along the rays of the picture's pixels, from samples of 16 bits: of the
 * widest vectors alone (render/sheet/engine.c). */
#define SHEET_PIXELS 1
#define SHEET_COMPACT 1
#include "render/sheet/kernels/composite/line.h"
#if defined(__AVX512F__)
#include "render/sheet/kernels/lit_image_order/shade.h"
#endif

void CVOL_SIMD(cvol_sheet_pixels_shade)(const cvol_layer *layer, const cvol_sheet_table *table,
                                        const cvol_line *line)
{
#if defined(__AVX512F__)
    const float scale = table->scale / layer->compact.scale, offset = -table->from * table->scale;
    line_job job = {.layer = layer,
                    .table = table,
                    .line = line,
                    .table_offset = offset,
                    .sample_scale = scale,
                    .sample_offset = offset - layer->compact.offset * scale};
    const int pieces = table->pieces ? CVOL_PIECES : 0;
    if (layer->sheet_count)
        draw_lit_line(&job, pieces);
    else
        end_lit_line(&job, pieces);
#endif
    (void)layer;
    (void)table;
    (void)line;
}
