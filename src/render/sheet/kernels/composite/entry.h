/* The common entry of line kernels, for their draw_line(job, unit, has_void, lengths, segments): it
 * is compiled separately for each kind of footprint, samples, projection and table. With extras
 * (classify.h) it is compiled once, with arguments at run time. Lit lines take long to compile:
 * those in perspective and with samples without a value are compiled once, too.
 *
 * Only kernel files include this file, behind composite.h or
 * render/sheet/kernels/lit_object_order/shade.h, which define if they are lit (SHEET_LIT). */
#ifndef CVOL_RENDER_SHEET_KERNELS_COMPOSITE_ENTRY_H
#define CVOL_RENDER_SHEET_KERNELS_COMPOSITE_ENTRY_H

#include "render/sheet/kernels/classify.h"
#include "render/sheet/kernels/composite/line.h"

CVOL_INLINE void begin_line(line_job *job, const cvol_layer *layer, const cvol_sheet_table *table,
                            const cvol_line *line)
{
    job->layer = layer;
    job->table = table;
    job->line = line;
    job->table_offset = -table->from * table->scale;
#ifdef SHEET_INT16
    job->sample_scale = table->scale / layer->int16.scale;
    job->sample_offset = job->table_offset - layer->int16.offset * job->sample_scale;
#else
    job->sample_scale = table->scale;
    job->sample_offset = job->table_offset;
#endif
}

CVOL_INLINE void draw_line_of_kind(line_job *job)
{
    const int unit = job->layer->unit, has_void = job->layer->cover_at != 0,
              lengths = job->layer->perspective,
              segments = HAVE_SEGMENTS && !has_void ? job->table->segments : 0;
    const int few = segments == CVOL_SEGMENTS_FEW;
    const int is_rare = lengths || has_void || (HAVE_SEGMENTS && !segments);
    if (SHEET_EXTRAS || (SHEET_LIT && is_rare))
        draw_line(job, unit, has_void, lengths, segments ? CVOL_SEGMENTS : 0);
    else if (SHEET_LIT && segments)
        unit ? draw_line(job, 1, 0, 0, CVOL_SEGMENTS) : draw_line(job, 0, 0, 0, CVOL_SEGMENTS);
    else if (SHEET_LIT)
        unit ? draw_line(job, 1, 0, 0, 0) : draw_line(job, 0, 0, 0, 0);
    else if (lengths)
        has_void   ? draw_line(job, 0, 1, 1, 0)
        : few      ? draw_line(job, 0, 0, 1, CVOL_SEGMENTS_FEW)
        : segments ? draw_line(job, 0, 0, 1, CVOL_SEGMENTS)
                   : draw_line(job, 0, 0, 1, 0);
    else if (has_void)
        unit ? draw_line(job, 1, 1, 0, 0) : draw_line(job, 0, 1, 0, 0);
    else if (few)
        unit ? draw_line(job, 1, 0, 0, CVOL_SEGMENTS_FEW)
             : draw_line(job, 0, 0, 0, CVOL_SEGMENTS_FEW);
    else if (segments)
        unit ? draw_line(job, 1, 0, 0, CVOL_SEGMENTS) : draw_line(job, 0, 0, 0, CVOL_SEGMENTS);
    else
        unit ? draw_line(job, 1, 0, 0, 0) : draw_line(job, 0, 0, 0, 0);
}

#endif
