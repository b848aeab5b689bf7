/* Maxima and minima along rays if all samples have a value and the footprint is linear: group by
 * group through all slices of a layer, except windows whose values do not exceed those that all
 * pixels of the group already have. The pictures equal the ones by project_sheet (project_simd.c).
 *
 * Only kernel files include this file: each compiles it for its instruction set. */
#ifndef CVOL_RENDER_SHEET_KERNELS_PROJECT_EXTREME_H
#define CVOL_RENDER_SHEET_KERNELS_PROJECT_EXTREME_H

#include "render/sheet/kernels/footprint.h"

/* Vectors of a group. */
#define EXTREME_PARTS (CVOL_GROUP / CVOL_LANES)

/* A slice as seen by a line: groups begin .. end - 1 meet it; inside_begin .. inside_end - 1 lie
 * within the drawn part. */
typedef struct extreme_sheet {
    const cvol_sheet_view *sheet;
    line_view view;
    unit_footprint footprint;
    group_range groups;
} extreme_sheet;

/* A line through a layer. */
typedef struct extreme_job {
    const cvol_layer *layer;
    const cvol_line *line;
    extreme_sheet sheets[CVOL_BLOCK_MAX]; /* that the line meets */
    int count;
    int begin, end;               /* groups that some of them meet, and those */
    int inside_begin, inside_end; /* inside on all of them */
} extreme_job;

/* The values of a group's pixels; an empty pixel has a value that any other exceeds. */
typedef struct extreme_group {
    cvol_vf value[EXTREME_PARTS], count[EXTREME_PARTS];
} extreme_group;

/* 0: the line does not meet the slice. */
CVOL_INLINE int view_extreme_sheet(extreme_sheet *out, const cvol_layer *layer,
                                   const cvol_sheet_view *sheet, const cvol_line *line)
{
    line_view *view = &out->view;
    out->sheet = sheet;
    view_line(view, layer, sheet, line->number);
    if (view->enter > 0.5f - MIN_WEIGHT || view->leave < MIN_WEIGHT - 0.5f ||
        view->leave - view->enter < MIN_WEIGHT)
        return 0;
    out->footprint = make_unit_footprint(view, sheet);
    const int whole = !layer->only &&
                      fminf(view->leave, 0.5f) - fmaxf(view->enter, -0.5f) >= MIN_WEIGHT;
    out->groups = (group_range){sheet->begin,
                                sheet->end,
                                whole ? sheet->inside_begin : 0,
                                whole ? sheet->inside_end : 0,
                                0,
                                0};
    if (layer->cuts)
        cut_groups(&out->groups, layer, sheet, line->number, line->width / CVOL_GROUP);
    return out->groups.begin < out->groups.end;
}

CVOL_INLINE cvol_vi is_beyond(cvol_vf value, cvol_vf than, int largest)
{
    return largest ? value > than : value < than;
}

/* Returns 1 if a window may exceed the value of some pixel of the group. */
CVOL_INLINE int is_window_beyond(const cvol_layer *layer, const line_view *view, ptrdiff_t window,
                                 const extreme_group *group, int largest)
{
    if (!(view->windows[window] & CVOL_WINDOW_SEEN))
        return 0;
    const cvol_vf most = cvol_splat(view->levels[window]);
    int any = !layer->bounded;
    for (int k = 0; k < EXTREME_PARTS; k++)
        any |= cvol_any(is_beyond(most, group->value[k], largest));
    return any;
}

/* int16 values are rounded to about 2^-8, so that equal integers, which float weights change in the
 * last bit, stay equal. */
CVOL_INLINE cvol_vf round_to_int16(cvol_vf value)
{
#ifdef SHEET_INT16
    const cvol_vf large = cvol_splat(49152);
    return (value + large) - large;
#else
    return value;
#endif
}

/* For part k of a group. */
CVOL_INLINE void widen_extremes(extreme_group *group, int k, const cvol_layer *layer,
                                const extreme_sheet *of, const cvol_line *line, int i, int unit,
                                int inside, int largest)
{
    const cvol_sheet_view *sheet = of->sheet;
    const double step = sheet->lane_step, position = sheet->lane_at + i * step;
    const cvol_vf value = round_to_int16(
        unit ? reconstruct_unit(&of->view, &of->footprint, of->footprint.x + i)
             : reconstruct_finer(&of->view, position, step));
    cvol_vi better = is_beyond(value, group->value[k], largest);
    if (inside) {
        group->count[k] = cvol_splat(1);
    } else {
        const cvol_vi within = weigh(layer, sheet, &of->view, position, i, line->number, -0.5f,
                                     0.5f) >= MIN_WEIGHT;
        better &= within;
        group->count[k] = cvol_select(within, cvol_splat(1), group->count[k]);
    }
    group->value[k] = cvol_select(better, value, group->value[k]);
}

CVOL_INLINE extreme_group load_extremes(const cvol_line *line, int group, int largest)
{
    extreme_group out;
    const cvol_vf identity = cvol_splat(largest ? -INFINITY : INFINITY);
    for (int k = 0; k < EXTREME_PARTS; k++) {
        const float *at = line->values + group * CVOL_GROUP + k * CVOL_LANES;
        out.count[k] = cvol_load(at + line->width);
        out.value[k] = cvol_select(out.count[k] > 0, cvol_load(at), identity);
    }
    return out;
}

CVOL_INLINE void store_extremes(const cvol_line *line, int group, const extreme_group *from)
{
    for (int k = 0; k < EXTREME_PARTS; k++) {
        float *at = line->values + group * CVOL_GROUP + k * CVOL_LANES;
        cvol_store(at, cvol_select(from->count[k] > 0, from->value[k], cvol_splat(0)));
        cvol_store(at + line->width, from->count[k]);
    }
}

CVOL_INLINE int most_of(int a, int b)
{
    return a > b ? a : b;
}

CVOL_INLINE int least_of(int a, int b)
{
    return a < b ? a : b;
}

CVOL_INLINE void begin_extremes(extreme_job *job, const cvol_layer *layer, const cvol_line *line)
{
    job->layer = layer;
    job->line = line;
    job->count = job->end = job->inside_begin = 0;
    job->begin = job->inside_end = line->width / CVOL_GROUP;
    for (int s = 0; s < layer->sheet_count; s++) {
        extreme_sheet *of = &job->sheets[job->count];
        if (!view_extreme_sheet(of, layer, &layer->sheets[s], line))
            continue;
        job->begin = least_of(job->begin, of->groups.begin);
        job->end = most_of(job->end, of->groups.end);
        job->inside_begin = most_of(job->inside_begin, of->groups.inside_begin);
        job->inside_end = least_of(job->inside_end, of->groups.inside_end);
        job->count++;
    }
}

CVOL_INLINE void draw_extreme_group(const extreme_job *job, int g, int unit, int largest)
{
    const cvol_layer *layer = job->layer;
    const cvol_line *line = job->line;
    const int i = g * CVOL_GROUP;
    extreme_group group = load_extremes(line, g, largest);
    int changed = 0;
    for (int s = 0; s < job->count; s++) {
        const extreme_sheet *of = &job->sheets[s];
        if (g < of->groups.begin || g >= of->groups.end)
            continue;
        const ptrdiff_t x = unit ? of->footprint.x + i
                                 : (ptrdiff_t)floor(of->sheet->lane_at + i * of->sheet->lane_step);
        if (!is_window_beyond(layer, &of->view, window_of(x), &group, largest))
            continue;
        const int inside = g >= of->groups.inside_begin && g < of->groups.inside_end;
        for (int k = 0; k < EXTREME_PARTS; k++)
            widen_extremes(&group, k, layer, of, line, i + k * CVOL_LANES, unit, inside, largest);
        changed = 1;
    }
    if (changed)
        store_extremes(line, g, &group);
}

CVOL_INLINE void draw_extremes(const cvol_layer *layer, const cvol_line *line, int unit,
                               int largest)
{
    extreme_job job;
    begin_extremes(&job, layer, line);
    for (int g = job.begin; g < job.end; g++)
        draw_extreme_group(&job, g, unit, largest);
}

#endif
