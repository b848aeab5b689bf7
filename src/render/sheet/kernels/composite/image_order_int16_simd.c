/* Mode composite in image order, for int16 samples: for the widest vectors only
 * (render/sheet/frame/policy.c). */
#define SHEET_IMAGE_ORDER 1
#define SHEET_INT16 1
#include "render/sheet/kernels/composite/line.h"
#if defined(__AVX512F__)
#include "render/sheet/kernels/composite/composite.h"

#include "render/sheet/kernels/composite/int16.h"
#endif

void CVOL_SIMD(cvol_sheet_image_order_int16)(const cvol_layer *layer, const cvol_sheet_table *table,
                                             const cvol_line *line)
{
#if defined(__AVX512F__)
    line_job job;
    begin_line(&job, layer, table, line);
    if (table->int16.usable)
        draw_int16_line(&job, 0, CVOL_SEGMENTS);
    else
        draw_line(&job, 0, 0, 0, HAVE_SEGMENTS ? CVOL_SEGMENTS : 0);
#endif
    (void)layer;
    (void)table;
    (void)line;
}
