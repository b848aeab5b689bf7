/* The slices of a layer under a line of the intermediate image: the slices that each group of its
 * pixels meets, those in which it can see something, and the conversion of samples to the pixels'
 * values.
 *
 * Only kernel files include this file: each compiles it for its instruction set. */
#ifndef CVOL_RENDER_SHEET_KERNELS_COMPOSITE_LINE_H
#define CVOL_RENDER_SHEET_KERNELS_COMPOSITE_LINE_H

#include "render/sheet/kernels/footprint.h"
#if SHEET_EXTRAS
#include "render/sheet/kernels/footprint_wide.h"
#endif

/* Vectors of a group. */
#define PARTS (CVOL_GROUP / CVOL_LANES)
/* The most groups of a line whose slices are examined together. */
#define RUN 128
/* Separate from the code that runs most of the time. */
#define CVOL_COLD static __attribute__((noinline))

/* One slice, as seen by a line. */
typedef struct sheet_line {
    const sheet_sample *near,
        *far;         /* rows of samples; for unit footprints, at the line's first pixel */
    float weights[4]; /* of near, its next sample, far, its next, for table coordinates */
    double lane_at, lane_step;
    line_view view;
    unit_footprint footprint;
#if SHEET_EXTRAS
    wide_view wide; /* if the layer has a reconstruction filter */
#endif
#if SHEET_IMAGE_ORDER
    const sheet_sample *origin; /* sample 0 of row 0 */
    const cvol_windows *windows;
    double row_at, row_right; /* row of pixel i: row_at + i row_right */
    int number;               /* in the layer; -1: between two slices, */
    int mixed;                /* and 1 if they may be invisible */
#endif
    int begin, end;               /* groups in which the line meets the slice, and those */
    int inside_begin, inside_end; /* inside, from two slices before on */
    int clip_begin, clip_end;     /* the same but for faces of a part */
} sheet_line;

/* A line through a layer. A bit of a number is a slice. */
typedef struct line_job {
    const cvol_layer *layer;
    const cvol_sheet_table *table;
    const cvol_line *line;
    sheet_line sheets[CVOL_BLOCK_MAX];
    sheet_line before,
        after; /* for lit frames: see render/sheet/kernels/lit_object_order/shade.h */
    struct between_views *between;     /* an extra: see between.h */
    float table_offset;                /* table coordinate = value * table->scale + table_offset, */
    float sample_scale, sample_offset; /* of samples in stored form */
#if SHEET_IMAGE_ORDER
    float lane_at[CVOL_BLOCK_MAX],
        row_at[CVOL_BLOCK_MAX]; /* of slices, at the line's first pixel */
    uint32_t
        mixed[RUN + 1]; /* slices in which a group sees something, but not all of its pixels do */
    uint32_t ways[RUN + 1]; /* slices with all samples in the interval from the one before */
    /* For lit plans, along lanes and rows in 2^-16: the reach of a group before its first pixel,
     * its extent from there, and the positions of its pixels. */
    int begins[2], reaches[2];
    cvol_vi ramp[2];
    int rows, samples; /* the most rows of samples, and the number of samples loaded per row */
#endif
    int first_group; /* the run's */
    uint32_t intersected[RUN],
        seen[RUN];        /* slices that each group crosses, and sees something in, */
    uint32_t inside[RUN]; /* and those whose intervals lie inside, away from faces */
} line_job;

/* ---- a line on the slices -------------------------------------------------------------------- */

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

CVOL_INLINE void set_groups(sheet_line *out, const cvol_layer *layer, const group_range *range)
{
    out->begin = range->begin;
    out->end = range->end;
    out->inside_begin = range->inside_begin;
    out->inside_end = range->inside_end;
    out->clip_begin = layer->part_cuts ? range->clip_begin : range->inside_begin;
    out->clip_end = layer->part_cuts ? range->clip_end : range->inside_end;
}

/* 1 if the group's interval up to a slice is whole, though parts may share it. */
CVOL_INLINE int is_inside(const sheet_line *sheet, int group)
{
    return group >= sheet->clip_begin && group < sheet->clip_end;
}

/* The weight of the intervals up to slice s, of the pixels from i on: negative where they belong to
 * another part. */
CVOL_INLINE cvol_vf own_weight(cvol_vf weight, const line_job *job, int s, int i)
{
    const cvol_layer *layer = job->layer;
    if (!layer->part_cuts)
        return weight;
    const cvol_vi own = find_owned(layer, &layer->sheets[s], i, job->line->number);
    return cvol_select(own, weight, cvol_min(weight, -weight));
}

CVOL_INLINE void view_sheet(sheet_line *out, const line_job *job, const cvol_sheet_view *sheet,
                            int unit)
{
    const cvol_layer *layer = job->layer;
    line_view *view = &out->view;
    view_line(view, layer, sheet, job->line->number);
    out->footprint = make_unit_footprint(view, sheet);
    out->lane_at = sheet->lane_at;
    out->lane_step = sheet->lane_step;
    const float right = unit ? (float)(sheet->lane_at - floor(sheet->lane_at)) : 0,
                left = 1 - right, scale = job->sample_scale;
    out->near = view->near + (unit ? out->footprint.x : 0);
    out->far = view->far + (unit ? out->footprint.x : 0);
    out->weights[0] = view->near_weight * left * scale;
    out->weights[1] = view->near_weight * right * scale;
    out->weights[2] = view->far_weight * left * scale;
    out->weights[3] = view->far_weight * right * scale;
#if SHEET_EXTRAS
    if (layer->wide)
        make_wide_view(&out->wide, layer, view, sheet);
#endif
    /* A slice before the rays enter is empty, but its values may be needed. */
    const float begin = layer->only ? -0.5f : -1, end = layer->only ? 0.5f : 1;
    const int intersected = view->enter < end && view->leave > begin + MIN_WEIGHT &&
                            view->leave - view->enter > MIN_WEIGHT;
    const int whole = !layer->only && view->enter < MIN_WEIGHT - 2 && view->leave > -MIN_WEIGHT;
    group_range range = {sheet->begin,
                         intersected ? sheet->end : sheet->begin,
                         whole ? sheet->inside_begin : 0,
                         whole ? sheet->inside_end : 0,
                         0,
                         0};
    if (layer->cuts && intersected)
        cut_groups(&range, layer, sheet, job->line->number, job->line->width / CVOL_GROUP);
    set_groups(out, layer, &range);
}

CVOL_INLINE ptrdiff_t lane_sample(const sheet_line *sheet, int group, int unit)
{
    return unit ? sheet->footprint.x + group * CVOL_GROUP
                : (ptrdiff_t)floor(sheet->lane_at + group * CVOL_GROUP * sheet->lane_step);
}

/* Finds the state of groups begin .. end - 1 of a run on one slice. */
CVOL_INLINE void find_sheet(line_job *job, int s, int begin, int end, int unit)
{
    const sheet_line *sheet = &job->sheets[s];
    const int first = job->first_group;
    const uint32_t bit = UINT32_C(1) << s;
    int group = begin;
    for (; group < end; group++) { /* until windows are consecutive */
        const ptrdiff_t x = lane_sample(sheet, group, unit);
        if (unit && x >= -CVOL_GROUP)
            break;
        const uint32_t seen = sheet->view.windows[window_of(x)] & CVOL_WINDOW_SEEN;
        job->intersected[group - first] |= bit;
        job->seen[group - first] |= seen << s;
    }
    if (group < end) {
        const uint8_t *windows = sheet->view.windows + window_of(lane_sample(sheet, group, 1));
        uint32_t *intersected = job->intersected + (group - first),
                 *all = job->seen + (group - first);
        for (int i = 0; i < end - group; i++) {
            intersected[i] |= bit;
            all[i] |= (uint32_t)(windows[i] & CVOL_WINDOW_SEEN) << s;
        }
    }
    begin = begin > sheet->inside_begin ? begin : sheet->inside_begin;
    end = end < sheet->inside_end ? end : sheet->inside_end;
    for (group = begin; group < end; group++)
        job->inside[group - first] |= bit;
}

/* Finds the slices that the groups of a run meet. */
CVOL_INLINE void find_intersected(line_job *job, int first, int count, int unit)
{
    memset(job->intersected, 0, sizeof *job->intersected * (size_t)count);
    memset(job->seen, 0, sizeof *job->seen * (size_t)count);
    memset(job->inside, 0, sizeof *job->inside * (size_t)count);
    job->first_group = first;
    for (int s = 0; s < job->layer->sheet_count; s++) {
        const sheet_line *sheet = &job->sheets[s];
        find_sheet(job, s, sheet->begin > first ? sheet->begin : first,
                   sheet->end < first + count ? sheet->end : first + count, unit);
    }
}

/* ---- values ---------------------------------------------------------------------------------- */

CVOL_INLINE cvol_vf to_table(const line_job *job, cvol_vf value)
{
    return value * job->table->scale + job->table_offset;
}

CVOL_INLINE cvol_vf sample_to_table(const line_job *job, cvol_vf sample)
{
    return sample * job->sample_scale + job->sample_offset;
}

#if SHEET_IMAGE_ORDER
#include "render/sheet/kernels/image_order/line_slanted.h"
#endif

/* The value at which the group met the slice before slice `s` of the layer, which was skipped:
 * about the level of its window, within `spread` of it. Returns 0 if it is unknown. */
CVOL_INLINE int find_level_before(float *level, float *spread, const line_job *job, int s,
                                  int group)
{
    const cvol_layer *layer = job->layer;
    const cvol_sheet_view *sheet = &layer->sheets[s];
    const int i = group * CVOL_GROUP, j = job->line->number;
    const double position = sheet->lane_at + i * sheet->lane_step;
    const ptrdiff_t x = (ptrdiff_t)floor(position -
                                         (sheet->lane_rate[0] + i * sheet->lane_rate[1]));
    const cvol_windows *windows = sheet->is_first || sheet->is_of_previous_layer
                                      ? &layer->windows_before
                                      : &layer->windows;
    if (!windows->count || (sheet->is_first && sheet->is_of_previous_layer))
        return 0;
    const float *levels;
    ptrdiff_t y;
    const uint8_t *bits = find_windows(&levels, &y, layer, windows,
                                       sheet->row_at + j * sheet->row_step -
                                           (sheet->row_rate[0] + j * sheet->row_rate[1]));
    *level = levels[window_of(x)] * job->table->scale + job->table_offset;
    *spread = levels[window_of(x) + windows->spread_at] * job->table->scale;
    return !bits[window_of(x)];
}

#if SHEET_EXTRAS
/* Part k of a group by a reconstruction filter; `near`: sample 0 of the row before the line. */
CVOL_INLINE cvol_vf reconstruct_widely(const line_job *job, const sheet_line *sheet,
                                       const float *near, int group, int k)
{
    const double i = group * CVOL_GROUP + k * CVOL_LANES;
    const wide_place place = find_wide_place(
        job->layer, near, sheet->lane_at + i * sheet->lane_step, sheet->lane_step);
    return reconstruct_wide(job->layer->wide, &sheet->wide, &place);
}

/* The same if samples may have no value, `offset` before or behind the slice's in memory. */
CVOL_INLINE cvol_vf reconstruct_widely_masked(cvol_vf *cover, const line_job *job,
                                              const sheet_line *sheet, ptrdiff_t offset, int group,
                                              int k, int unit)
{
    const cvol_layer *layer = job->layer;
    const ptrdiff_t i = group * CVOL_GROUP + k * CVOL_LANES;
    const double step = sheet->lane_step, position = sheet->lane_at + (double)i * step;
    line_view view = sheet->view;
    view.near += offset;
    view.far += offset;
    const cvol_vf mean = unit ? reconstruct_unit_masked(cover, &view, &sheet->footprint,
                                                        sheet->footprint.x + i, layer->cover_at)
                              : reconstruct_finer_masked(cover, &view, position, step,
                                                         layer->cover_at);
    const wide_place place = find_wide_place(layer, view.near, position, step);
    return reconstruct_wide_masked(cover, layer->wide, &sheet->wide, &place, mean);
}
#endif

/* Table coordinates of part k of a group. */
CVOL_INLINE cvol_vf reconstruct(const line_job *job, const sheet_line *sheet, int group, int k,
                                int unit)
{
    const ptrdiff_t i = group * CVOL_GROUP + k * CVOL_LANES;
    const float *w = sheet->weights;
#if SHEET_IMAGE_ORDER
    return sample_to_table(job, reconstruct_image_order(job, sheet, (int)i));
#endif
#if SHEET_EXTRAS
    if (job->layer->wide)
        return to_table(job, reconstruct_widely(job, sheet,
                                                sheet->near - (unit ? sheet->footprint.x : 0),
                                                group, k));
#endif
    if (unit)
        return job->sample_offset + w[0] * load_samples(sheet->near + i) +
               w[1] * load_samples(sheet->near + i + 1) + w[2] * load_samples(sheet->far + i) +
               w[3] * load_samples(sheet->far + i + 1);
    const double step = sheet->lane_step, position = sheet->lane_at + (double)i * step;
    const double whole = floor(position);
    const sheet_sample *near = sheet->near + (ptrdiff_t)whole, *far = sheet->far + (ptrdiff_t)whole;
    const cvol_vf low = w[0] * load_samples(near) + w[2] * load_samples(far);
    const cvol_vf high = w[0] * load_samples(near + CVOL_LANES) +
                         w[2] * load_samples(far + CVOL_LANES);
    const cvol_vf at = (float)(position - whole) + cvol_iota() * (float)step;
    const cvol_vi index = cvol_to_int(at);
    const cvol_vf left = cvol_shuffle(low, high, index) + job->sample_offset;
    return left + (at - cvol_to_float(index)) *
                      (cvol_shuffle(low, high, index + 1) + job->sample_offset - left);
}

/* The lengths of the intervals of pixels i .., see cvol_layer: in perspective only. */
CVOL_INLINE cvol_vf find_lengths(const line_job *job, int i)
{
    const cvol_layer *layer = job->layer;
    const double row = layer->length_row[0] + job->line->number * layer->length_row[1];
    const cvol_vf lane = (float)(layer->length_lane[0] + i * layer->length_lane[1]) +
                         cvol_iota() * (float)layer->length_lane[1];
    return cvol_sqrt((float)(layer->length + row * row) + lane * lane);
}

/* All bits from the lowest of `bits` on; 0 if it has none. */
CVOL_INLINE uint32_t from_lowest(uint32_t bits)
{
    return bits | -bits;
}

#endif
