/* The entry of line kernels without light in object order.
 *
 * Only kernel files include this file, behind composite.h. */
#ifndef CVOL_RENDER_SHEET_KERNELS_COMPOSITE_ENTRY_H
#define CVOL_RENDER_SHEET_KERNELS_COMPOSITE_ENTRY_H

#include "render/sheet/kernels/classify.h"
#include "render/sheet/kernels/composite/line.h"

CVOL_INLINE void draw_line_of_kind(line_job *job)
{
    const int has_void = job->layer->cover_at != 0;
    draw_line(job, job->layer->unit, has_void, job->layer->perspective,
              HAVE_SEGMENTS && !has_void ? job->table->segments : 0);
}

#endif
