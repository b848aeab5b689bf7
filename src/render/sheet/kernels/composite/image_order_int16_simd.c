/* Mode composite along the rays of the picture's pixels, where samples are kept in 16 bits. */
#define SHEET_PIXELS 1
#define SHEET_COMPACT 1
#include "render/sheet/kernels/composite/composite.h"

#include "render/sheet/kernels/composite/entry.h"
#include "render/sheet/kernels/composite/int16.h"

void CVOL_SIMD(cvol_sheet_pixels_compact)(const cvol_layer *layer, const cvol_sheet_table *table,
                                          const cvol_line *line)
{
    line_job job;
    begin_line(&job, layer, table, line);
#if defined(__AVX512F__)
    if (table->words.usable)
        draw_compact_line(&job, 0, CVOL_PIECES);
    else
#endif
        draw_line(&job, 0, 0, 0, HAVE_PIECES ? CVOL_PIECES : 0);
}
