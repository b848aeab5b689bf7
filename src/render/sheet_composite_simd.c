/* Mode composite: one line of the intermediate image through all sheets of a layer.
 *
 * A ray's value is known where it crosses the sheets; between two of them it is taken to be linear.
 * Each interval between sheets is classified at the ends of 1, 2 or 4 parts of it, so many as
 * the transfer function needs over the values that the interval spans (cvol_sheet_table.flat), and
 * composited front to back:
 *     I += (1 - A) F D,  A += (1 - A) D
 *
 * What each sheet is to the line is found first. Then each group of pixels goes through all sheets
 * of the layer, those alone in which it meets something to be seen, while its colour stays in
 * registers. Values are kept as table coordinates.
 */
#include "render/sheet_classify.h"
#include "render/sheet_footprint.h"

/* Vectors of a group. */
#define PARTS (CVOL_GROUP / CVOL_LANES)
/* The most groups of a line whose sheets are looked at together. */
#define RUN 128
/* Kept apart from the code that runs most of the time. */
#define CVOL_COLD static __attribute__((noinline))

/* One sheet as a line sees it. */
typedef struct sheet_line {
    const float *near, *far; /* rows of samples; of unit footprints, at the line's first pixel */
    float weights[4];        /* of near, its next sample, far, its next, for table coordinates */
    double lane_at;
    line_view view;
    unit_footprint footprint;
    int whole;                    /* rays that enter by no side are within all of the interval */
    int begin, end;               /* groups that the line has something of, those that lie within */
    int inside_begin, inside_end; /* and those that do by lanes as well */
} sheet_line;

/* A line through a layer. A bit of a number is a sheet. */
typedef struct line_job {
    const cvol_layer *layer;
    const cvol_sheet_table *table;
    const cvol_line *line;
    sheet_line sheets[CVOL_BLOCK_MAX];
    float table_offset;           /* table coordinate = value * table->scale + table_offset */
    int first_group;              /* the run's */
    uint32_t met[RUN], seen[RUN]; /* sheets that each group crosses, and sees something in, */
    uint32_t inside[RUN];         /* and those whose intervals all lie within the volume */
} line_job;

/* A group while it is drawn. */
typedef struct group_state {
    pixels p[PARTS];
    cvol_vf value[PARTS], cover[PARTS]; /* at the sheet before; cover only where samples are void */
} group_state;

/* ---- what a line is to the sheets ---------------------------------------------------------------
 */

CVOL_INLINE void view_sheet(sheet_line *out, const line_job *job, const cvol_sheet_view *sheet,
                            int unit)
{
    const int only = sheet->front == -0.5f;
    line_view *view = &out->view;
    view_line(view, job->layer, sheet, job->line->number, only ? -0.5f : -1, only ? 0.5f : 0);
    out->footprint = make_unit_footprint(view, sheet);
    out->lane_at = sheet->lane_at;
    const float right = unit ? (float)(sheet->lane_at - floor(sheet->lane_at)) : 0,
                left = 1 - right, scale = job->table->scale;
    out->near = view->near + (unit ? out->footprint.x : 0);
    out->far = view->far + (unit ? out->footprint.x : 0);
    out->weights[0] = view->near_weight * left * scale;
    out->weights[1] = view->near_weight * right * scale;
    out->weights[2] = view->far_weight * left * scale;
    out->weights[3] = view->far_weight * right * scale;
    const float length = view->slab_end - view->slab_begin;
    out->whole = length > 1 - LEAST_WEIGHT;
    out->begin = sheet->begin;
    /* The first sheet has nothing before it, but its values are needed. */
    out->end = length < LEAST_WEIGHT && sheet->ordinal > 0 ? sheet->begin : sheet->end;
    out->inside_begin = out->whole ? sheet->inside_begin : 0;
    out->inside_end = out->whole ? sheet->inside_end : 0;
}

CVOL_INLINE long lane_sample(const sheet_line *sheet, double step, int group, int unit)
{
    return unit ? sheet->footprint.x + group * CVOL_GROUP
                : (long)floor(sheet->lane_at + group * CVOL_GROUP * step);
}

/* What the groups begin .. end - 1 of a run are to one sheet. */
CVOL_INLINE void find_sheet(line_job *job, int s, int begin, int end, int unit)
{
    const sheet_line *sheet = &job->sheets[s];
    const int first = job->first_group;
    const uint32_t bit = UINT32_C(1) << s;
    int group = begin;
    for (; group < end; group++) { /* until windows follow one another */
        const long x = lane_sample(sheet, job->layer->lane_step, group, unit);
        if (unit && x >= -CVOL_GROUP)
            break;
        const uint32_t seen = sheet->view.windows[window_of(x)] & CVOL_WINDOW_SEEN;
        job->met[group - first] |= bit;
        job->seen[group - first] |= seen << s;
    }
    if (group < end) {
        const uint8_t *windows = sheet->view.windows + window_of(lane_sample(sheet, 1, group, 1));
        uint32_t *met = job->met + (group - first), *all = job->seen + (group - first);
        for (int i = 0; i < end - group; i++) {
            met[i] |= bit;
            all[i] |= (uint32_t)(windows[i] & CVOL_WINDOW_SEEN) << s;
        }
    }
    begin = begin > sheet->inside_begin ? begin : sheet->inside_begin;
    end = end < sheet->inside_end ? end : sheet->inside_end;
    for (group = begin; group < end; group++)
        job->inside[group - first] |= bit;
}

/* Which sheets the groups of a run meet. */
CVOL_INLINE void find_met(line_job *job, int first, int count, int unit)
{
    memset(job->met, 0, sizeof *job->met * (size_t)count);
    memset(job->seen, 0, sizeof *job->seen * (size_t)count);
    memset(job->inside, 0, sizeof *job->inside * (size_t)count);
    job->first_group = first;
    for (int s = 0; s < job->layer->sheet_count; s++) {
        const sheet_line *sheet = &job->sheets[s];
        find_sheet(job, s, sheet->begin > first ? sheet->begin : first,
                   sheet->end < first + count ? sheet->end : first + count, unit);
    }
}

/* ---- one group --------------------------------------------------------------------------------
 */

CVOL_INLINE void load_group(group_state *g, const cvol_line *line, int group, int has_void)
{
    const float *r = line->values + group * CVOL_GROUP;
    const int width = line->width;
    for (int k = 0; k < PARTS; k++, r += CVOL_LANES) {
        g->p[k] = (pixels){cvol_load(r), cvol_load(r + width), cvol_load(r + 2 * width),
                           cvol_load(r + 3 * width)};
        g->value[k] = cvol_load(r + 4 * width);
        g->cover[k] = has_void ? cvol_load(r + 5 * width) : cvol_splat(1);
    }
}

CVOL_INLINE void store_group(const group_state *g, const cvol_line *line, int group, int has_void)
{
    float *r = line->values + group * CVOL_GROUP;
    const int width = line->width;
    for (int k = 0; k < PARTS; k++, r += CVOL_LANES) {
        cvol_store(r, g->p[k].r);
        cvol_store(r + width, g->p[k].g);
        cvol_store(r + 2 * width, g->p[k].b);
        cvol_store(r + 3 * width, g->p[k].through);
        cvol_store(r + 4 * width, g->value[k]);
        if (has_void)
            cvol_store(r + 5 * width, g->cover[k]);
    }
}

CVOL_INLINE int is_closed(const group_state *g)
{
    cvol_vf most = g->p[0].through;
    for (int k = 1; k < PARTS; k++)
        most = cvol_max(most, g->p[k].through);
    return !any_above(most, OPAQUE_BELOW);
}

CVOL_INLINE cvol_vf to_table(const line_job *job, cvol_vf value)
{
    return value * job->table->scale + job->table_offset;
}

/* The value at which the group met the sheet before sheet `s` of the layer, which was skipped:
 * about the level of the window there. 0 if it is not known. */
CVOL_INLINE int find_level_before(float *level, const line_job *job, int s, int group)
{
    const cvol_layer *layer = job->layer;
    const cvol_sheet_view *sheet = &layer->sheets[s];
    const double position = sheet->lane_at + group * CVOL_GROUP * layer->lane_step;
    const long window = window_of((long)floor(position - layer->lane_drift));
    const cvol_windows *windows = sheet->is_first ? &layer->windows_before : &layer->windows;
    if (!windows->count)
        return 0;
    const float *levels;
    long y;
    const uint8_t *bits = find_windows(&levels, &y, layer, windows,
                                       sheet->row_at + job->line->number * layer->row_step -
                                           layer->row_drift);
    *level = levels[window] * job->table->scale + job->table_offset;
    return !bits[window];
}

/* A group that was drawn up to the sheet before meets a window that cannot be seen: what of the
 * interval between the two can be, is drawn. If samples there may have no value, then what half of
 * it has by the sheet before. */
CVOL_INLINE void draw_end(group_state *g, const line_job *job, int s, int group, int unit,
                          int has_void, int pieces)
{
    const cvol_layer *layer = job->layer;
    const sheet_line *sheet = &job->sheets[s];
    const long window = window_of(lane_sample(sheet, layer->lane_step, group, unit));
    const int masked = has_void && sheet->view.windows[window] & CVOL_WINDOW_MASKED;
    const cvol_vf level = to_table(job, cvol_splat(sheet->view.levels[window]));
    for (int k = 0; k < PARTS; k++) {
        const int i = group * CVOL_GROUP + k * CVOL_LANES;
        cvol_vf weight = weigh(layer, &sheet->view, sheet->lane_at + i * layer->lane_step);
        if (masked)
            weight *= 0.5f * g->cover[k];
        composite_interval(&g->p[k], job->table, g->value[k], masked ? g->value[k] : level, weight,
                           1, pieces);
    }
}

/* The interval that ends at a sheet. known: its beginning is g->value; else only its latter half,
 * or, of the first sheet, none is within the volume, and it has one value. */
CVOL_INLINE void draw_interval(group_state *g, const line_job *job, int s, int group, int known,
                               int unit, int has_void, int pieces)
{
    const cvol_layer *layer = job->layer;
    const sheet_line *sheet = &job->sheets[s];
    const double step = layer->lane_step;
    const long x = lane_sample(sheet, step, group, unit);
    const int masked = has_void && sheet->view.windows[window_of(x)] & CVOL_WINDOW_MASKED;
    const int inside = group >= sheet->inside_begin && group < sheet->inside_end;
    for (int k = 0; k < PARTS; k++) {
        const double position = sheet->lane_at + (group * CVOL_GROUP + k * CVOL_LANES) * step;
        cvol_vf cover = cvol_splat(1), value;
        if (masked)
            value = unit ? reconstruct_unit_masked(&cover, &sheet->view, &sheet->footprint,
                                                   x + k * CVOL_LANES, layer->cover_at)
                         : reconstruct_finer_masked(&cover, &sheet->view, position, step,
                                                    layer->cover_at);
        else
            value = unit ? reconstruct_unit(&sheet->view, &sheet->footprint, x + k * CVOL_LANES)
                         : reconstruct_finer(&sheet->view, position, step);
        value = to_table(job, value);
        cvol_vf from = known ? g->value[k] : value, to = value, weight = value;
        if (!inside)
            weight = weigh(layer, &sheet->view, position);
        else if (has_void)
            weight = cvol_splat(known ? 1 : 0.5f);
        else if (!known)
            weight = cvol_splat(0.5f);
        if (has_void) { /* where an end has no value, the other's holds */
            const cvol_vf before = known ? g->cover[k] : cover;
            to = cvol_select(cover < LEAST_WEIGHT, from, value);
            from = cvol_select(before < LEAST_WEIGHT, value, from);
            weight *= 0.5f * (before + cover);
            g->cover[k] = cover;
        }
        if (inside && known && !has_void)
            composite_interval(&g->p[k], job->table, from, to, weight, 0, pieces);
        else
            composite_interval(&g->p[k], job->table, from, to, weight, 1, pieces);
        g->value[k] = value;
    }
}

/* Table coordinates of part k of a group. */
CVOL_INLINE cvol_vf reconstruct(const line_job *job, const sheet_line *sheet, int group, int k,
                                int unit)
{
    const long i = group * CVOL_GROUP + k * CVOL_LANES;
    const float *w = sheet->weights;
    if (unit)
        return job->table_offset + w[0] * cvol_load(sheet->near + i) +
               w[1] * cvol_load(sheet->near + i + 1) + w[2] * cvol_load(sheet->far + i) +
               w[3] * cvol_load(sheet->far + i + 1);
    const double step = job->layer->lane_step, position = sheet->lane_at + (double)i * step;
    const double whole = floor(position);
    const float *near = sheet->near + (long)whole, *far = sheet->far + (long)whole;
    const cvol_vf low = w[0] * cvol_load(near) + w[2] * cvol_load(far);
    const cvol_vf high = w[0] * cvol_load(near + CVOL_LANES) + w[2] * cvol_load(far + CVOL_LANES);
    const cvol_vf at = (float)(position - whole) + cvol_iota() * (float)step;
    const cvol_vi index = cvol_to_int(at);
    const cvol_vf left = cvol_shuffle(low, high, index) + job->table_offset;
    return left + (at - cvol_to_float(index)) *
                      (cvol_shuffle(low, high, index + 1) + job->table_offset - left);
}

/* Sheets from s on, as long as `go` has them: known intervals, whole, of samples that all have a
 * value. Returns the sheet after the last that was drawn. */
CVOL_INLINE int draw_run(group_state *state, int *closed, const line_job *job, uint64_t go, int s,
                         int group, int unit, int pieces)
{
    group_state g = *state;
    do {
        for (int k = 0; k < PARTS; k++) {
            const cvol_vf value = reconstruct(job, &job->sheets[s], group, k, unit);
            composite_interval(&g.p[k], job->table, g.value[k], value, value, 0, pieces);
            g.value[k] = value;
        }
        *closed = is_closed(&g);
        s++;
    } while (!*closed && go >> s & 1);
    *state = g;
    return s;
}

/* One sheet of any other kind; *known: whether its value was found. */
CVOL_COLD int draw_sheet(group_state *g, const line_job *job, int s, int group, int known, int unit,
                         int has_void, int pieces)
{
    float level = 0;
    if (!(job->seen[group - job->first_group] >> s & 1)) {
        if (known)
            draw_end(g, job, s, group, unit, has_void, pieces);
        return 0;
    }
    if (!known && find_level_before(&level, job, s, group)) {
        known = 1;
        for (int k = 0; k < PARTS; k++) {
            g->value[k] = cvol_splat(level);
            g->cover[k] = cvol_splat(1);
        }
    }
    draw_interval(g, job, s, group, known, unit, has_void, pieces);
    return 1;
}

/* All bits from the lowest of `bits` on; 0 if it has none. */
CVOL_INLINE uint32_t from_lowest(uint32_t bits)
{
    return bits | -bits;
}

/* A group through the sheets that it meets. */
CVOL_INLINE void draw_group(const line_job *job, int group, int unit, int has_void, int pieces)
{
    const cvol_line *line = job->line;
    const int at = group - job->first_group, first_ordinal = job->layer->sheets[0].ordinal;
    const uint32_t seen = job->seen[at];
    const uint64_t go = has_void ? 0 : seen & job->inside[at];
    uint32_t met = job->met[at];
    int known = line->met[group] == first_ordinal - 1;
    if (!seen && !(known && met & 1))
        return;
    group_state g;
    load_group(&g, line, group, has_void);
    int last = line->met[group], closed = 0;
    while (met && !closed) {
        int s = __builtin_ctz(met);
        known = last == first_ordinal + s - 1;
        if (known && go >> s & 1) {
            s = draw_run(&g, &closed, job, go, s, group, unit, pieces);
            last = first_ordinal + s - 1;
            met &= ~UINT32_C(0) << (s - 1) << 1;
            continue;
        }
        met &= met - 1;
        if (draw_sheet(&g, job, s, group, known, unit, has_void, pieces))
            last = first_ordinal + s;
        else
            met &= from_lowest(met & seen); /* nothing to be seen until then */
        closed = is_closed(&g);
    }
    store_group(&g, line, group, has_void);
    line->met[group] = last;
    line->opaque[group] = (uint8_t)closed;
}

CVOL_INLINE void draw_line(line_job *job, int unit, int has_void, int pieces)
{
    const cvol_layer *layer = job->layer;
    int begin = job->line->width / CVOL_GROUP, end = 0;
    for (int s = 0; s < layer->sheet_count; s++) {
        view_sheet(&job->sheets[s], job, &layer->sheets[s], unit);
        begin = job->sheets[s].begin < begin ? job->sheets[s].begin : begin;
        end = job->sheets[s].end > end ? job->sheets[s].end : end;
    }
    for (int first = begin; first < end; first += RUN) {
        const int count = end - first < RUN ? end - first : RUN;
        find_met(job, first, count, unit);
        for (int group = first; group < first + count; group++)
            if (!job->line->opaque[group])
                draw_group(job, group, unit, has_void, pieces);
    }
}

void CVOL_SIMD(cvol_sheet_composite)(const cvol_layer *layer, const cvol_sheet_table *table,
                                     const cvol_line *line)
{
    const int unit = layer->lane_step == 1, has_void = layer->cover_at != 0;
    line_job job;
    job.layer = layer;
    job.table = table;
    job.line = line;
    job.table_offset = -table->from * table->scale;
    if (has_void)
        unit ? draw_line(&job, 1, 1, 0) : draw_line(&job, 0, 1, 0);
    else if (HAVE_PIECES && table->pieces)
        unit ? draw_line(&job, 1, 0, 1) : draw_line(&job, 0, 0, 1);
    else
        unit ? draw_line(&job, 1, 0, 0) : draw_line(&job, 0, 0, 0);
}
