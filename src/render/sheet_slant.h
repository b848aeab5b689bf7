/* What a line of the picture itself is to the sheets of a layer (plans of pixels, sheet_pixels.c):
 * sheet_line.h's part, where lines run across rows of samples, so that every pixel has rows and
 * weights of its own.
 *
 * A group meets several windows of a sheet then; it sees something if one of them has something.
 *
 * To be included by kernel files only, by sheet_line.h.
 */
#ifndef CVOL_RENDER_SHEET_SLANT_H
#define CVOL_RENDER_SHEET_SLANT_H

/* Whole numbers of places keep 16 bits behind the point. */
#define PLACE_ONE 65536.0

/* ---- how far lines reach ------------------------------------------------------------------------
 */

/* Sheets of a layer, and two before and one behind. */
#define SHEETS_AROUND (CVOL_BLOCK_MAX + 3)

/* The pixels between which a line's rays are within what is drawn, of one axis, sheet by sheet. */
typedef struct pixels_within {
    double begin[SHEETS_AROUND], end[SHEETS_AROUND];
} pixels_within;

/* Of `count` sheets, which are crossed at `at`, and `rate` further on each next one. */
CVOL_INLINE void find_pixels_within(pixels_within *out, int count, double at, double rate,
                                    double step, double lo, double hi)
{
    const double least = 1e-9; /* lines along rows reach far, one way or the other */
    const double inverse = 1 / (fabs(step) > least ? step : step < 0 ? -least : least);
    const double from = inverse < 0 ? hi : lo, to = inverse < 0 ? lo : hi;
    for (int s = 0; s < count; s++) {
        out->begin[s] = (from - (at + s * rate)) * inverse;
        out->end[s] = (to - (at + s * rate)) * inverse;
    }
}

/* Groups as cvol_sheet_view has them, of what is within on the sheets from two before, which is
 * number s, to one behind: what may be within somewhere from one before on, and what is on all. */
CVOL_INLINE group_range find_groups_of_pixels(const pixels_within within[2], int s, int groups)
{
    double most[2] = {-INFINITY, INFINITY}, least[2] = {-INFINITY, INFINITY};
    for (int axis = 0; axis < 2; axis++) {
        /* Straight from sheet to sheet. */
        const double *begin = within[axis].begin + s, *end = within[axis].end + s;
        const double first = begin[1] < begin[3] ? begin[1] : begin[3],
                     last = end[1] > end[3] ? end[1] : end[3],
                     inside = begin[0] > begin[3] ? begin[0] : begin[3],
                     until = end[0] < end[3] ? end[0] : end[3];
        most[0] = most[0] > first ? most[0] : first;
        most[1] = most[1] < last ? most[1] : last;
        least[0] = least[0] > inside ? least[0] : inside;
        least[1] = least[1] < until ? least[1] : until;
    }
    if (!(most[0] <= most[1]))
        return (group_range){0, 0, 0, 0};
    const double inverse = 1.0 / CVOL_GROUP;
    return (group_range){clamp_to_groups(floor(ceil(most[0]) * inverse), groups),
                         clamp_to_groups(floor(floor(most[1]) * inverse) + 1, groups),
                         clamp_to_groups(ceil(least[0] * inverse), groups),
                         clamp_to_groups(floor((floor(least[1]) + 1) * inverse), groups)};
}

/* All sheets of the layer as the line sees them. */
CVOL_INLINE void view_slanted(line_job *job)
{
    const cvol_layer *layer = job->layer;
    const int j = job->line->number, groups = job->line->width / CVOL_GROUP;
    const int count = layer->sheet_count;
    if (!count)
        return;
    const cvol_sheet_view *near = &layer->sheets[0];
    pixels_within within[2];
    find_pixels_within(&within[0], count + 3,
                       near->lane_at + j * near->lane_down - 2 * near->lane_rate[0],
                       near->lane_rate[0], near->lane_step, layer->lane_lo, layer->lane_hi);
    find_pixels_within(&within[1], count + 3,
                       near->row_at + j * near->row_step - 2 * near->row_rate[0], near->row_rate[0],
                       near->row_right, layer->row_lo, layer->row_hi);
    for (int s = 0; s < count; s++) {
        const cvol_sheet_view *sheet = &layer->sheets[s];
        sheet_line *out = &job->sheets[s];
        out->view.enter = sheet->front;
        out->view.leave = sheet->back;
        out->lane_at = sheet->lane_at + j * sheet->lane_down;
        out->lane_step = sheet->lane_step;
        out->row_at = sheet->row_at + j * sheet->row_step;
        out->row_right = sheet->row_right;
        job->lane_at[s] = (float)out->lane_at;
        job->row_at[s] = (float)out->row_at;
        out->origin = samples_of(sheet) + sheet->first;
        out->number = s;
        out->windows = sheet->is_of_before ? &layer->windows_before : &layer->windows;
        const float begin = layer->only ? -0.5f : -1, end = layer->only ? 0.5f : 1;
        const int met = out->view.enter < end && out->view.leave > begin + LEAST_WEIGHT;
        const int whole = !layer->only && out->view.enter < LEAST_WEIGHT - 2 &&
                          out->view.leave > -LEAST_WEIGHT;
        group_range range = find_groups_of_pixels(within, s, groups);
        if (!met)
            range.end = range.begin;
        if (!whole)
            range.inside_begin = range.inside_end = 0;
        if (layer->cuts && met)
            cut_groups(&range, layer, sheet, j, groups);
        out->begin = range.begin;
        out->end = range.end;
        out->inside_begin = range.inside_begin;
        out->inside_end = range.inside_end;
    }
}

/* ---- what groups meet --------------------------------------------------------------------------
 */

/* Where a group lies in each sheet of the layer: windows c0 .. c1 of rows r0 .. r1 of blocks. */
typedef struct group_windows {
    int c0[CVOL_BLOCK_MAX], c1[CVOL_BLOCK_MAX], r0[CVOL_BLOCK_MAX], r1[CVOL_BLOCK_MAX];
} group_windows;

/* A row of blocks of which there are windows: groups may reach beyond what their lines meet, with
 * pixels that are not drawn. */
CVOL_INLINE int clamp_row(const cvol_windows *windows, int row)
{
    row = row > windows->last_row ? windows->last_row : row;
    return row < windows->first_row ? windows->first_row : row;
}

/* Eight windows' flags, and those of the first `count` in which something is to be seen. Behind the
 * last row's there are as many bytes. */
#define FLAGS_AT_ONCE 8

CVOL_INLINE uint64_t load_flags(const uint8_t *bits)
{
    uint64_t flags;
    memcpy(&flags, bits, sizeof flags);
    return flags;
}

CVOL_INLINE uint64_t seen_flags(int count)
{
    const uint64_t seen = UINT64_C(0x0101010101010101) * CVOL_WINDOW_SEEN;
    return seen >> 8 * (FLAGS_AT_ONCE - count);
}

/* Whether there is something to be seen in windows c0 .. c1 of rows r0 .. r1 of blocks. */
CVOL_INLINE int find_seen(const cvol_windows *windows, int c0, int c1, int r0, int r1)
{
    r0 = clamp_row(windows, r0);
    r1 = clamp_row(windows, r1);
    const uint8_t *bits = (r1 > r0 ? windows->across : windows->within) + (long)r0 * windows->count;
    const int last = r1 > r0 ? r1 - 1 : r1;
    uint64_t seen = 0;
    for (int r = r0; r <= last; r++, bits += windows->count)
        for (int c = c0; c <= c1; c += FLAGS_AT_ONCE)
            seen |= load_flags(bits + c) &
                    seen_flags(c1 - c < FLAGS_AT_ONCE ? c1 - c + 1 : FLAGS_AT_ONCE);
    return seen != 0;
}

/* Whether there is in all of them, and one more behind, which the last pixels may have. */
CVOL_INLINE int find_all_seen(const cvol_windows *windows, int c0, int c1, int r0, int r1)
{
    r0 = clamp_row(windows, r0);
    r1 = clamp_row(windows, r1);
    const uint8_t *bits = windows->within + (long)r0 * windows->count;
    uint64_t unseen = 0;
    c1 = c1 + 1 < windows->count ? c1 + 1 : c1;
    for (int r = r0; r <= r1; r++, bits += windows->count)
        for (int c = c0; c <= c1; c += FLAGS_AT_ONCE)
            unseen |= ~load_flags(bits + c) &
                      seen_flags(c1 - c < FLAGS_AT_ONCE ? c1 - c + 1 : FLAGS_AT_ONCE);
    return !unseen;
}

CVOL_INLINE int clamp_to(int value, int last)
{
    value = value > last ? last : value;
    return value < 0 ? 0 : value;
}

/* The windows of a group of a line that begins at lane_at and row_at of sheet s. */
CVOL_INLINE void place_windows(group_windows *out, int s, const line_job *job, float lane_at,
                               float row_at, int group)
{
    const cvol_layer *layer = job->layer;
    const int last = layer->block_rows - 1, last_window = layer->windows.count - 1;
    const float i = (float)(group * CVOL_GROUP), across = CVOL_GROUP - 1;
    const float step = (float)layer->sheets[0].lane_step, right = (float)layer->sheets[0].row_right;
    const float above = right < 0 ? across * right : 0, below = right < 0 ? 0 : across * right;
    const float inverse = 1 / (float)layer->row_points, half = 0.5f * inverse;
    const float x = lane_at + i * step, y = row_at + i * right;
    const int x0 = (int)floorf(x), x1 = (int)floorf(x + across * step) + 1;
    const float y0 = floorf(y + above), y1 = floorf(y + below) + 1;
    const int c0 = clamp_to((x0 + CVOL_GROUP) >> 4, last_window),
              c1 = clamp_to(x1 >> 4, last_window);
    out->c0[s] = c0;
    out->c1[s] = c1 > c0 ? c1 : c0;
    out->r0[s] = clamp_to((int)floorf(y0 * inverse + half), last);
    out->r1[s] = clamp_to((int)floorf(y1 * inverse + half), last);
}

/* Sixteen places: of lanes and rows, from .. to; and the last lane at which a group begins. */
typedef struct sixteen_places {
    float lane[2][CVOL_GROUP], row[2][CVOL_GROUP], begin[CVOL_GROUP];
} sixteen_places;

#if defined(__AVX512F__)

CVOL_INLINE __m512i floor_words(__m512 value)
{
    return _mm512_cvt_roundps_epi32(value, _MM_FROUND_TO_NEG_INF | _MM_FROUND_NO_EXC);
}

CVOL_INLINE __m512i clamp_words(__m512i value, int last)
{
    return _mm512_max_epi32(_mm512_min_epi32(value, _mm512_set1_epi32(last)),
                            _mm512_setzero_si512());
}

/* The rows of blocks of 16 samples, and `next` behind these. */
CVOL_INLINE __m512i find_block_rows(const float row[CVOL_GROUP], float next, float inverse,
                                    int last)
{
    const __m512 middle = _mm512_add_ps(
        _mm512_roundscale_ps(_mm512_loadu_ps(row), _MM_FROUND_TO_NEG_INF),
        _mm512_set1_ps(0.5f + next));
    return clamp_words(floor_words(_mm512_mul_ps(middle, _mm512_set1_ps(inverse))), last);
}

#endif

/* Their windows, as out's s .. s + 15. */
CVOL_INLINE void find_sixteen_windows(group_windows *out, int s, const cvol_layer *layer,
                                      const sixteen_places *at)
{
    const int last = layer->block_rows - 1, last_window = layer->windows.count - 1;
    const float inverse = 1 / (float)layer->row_points;
#if defined(__AVX512F__)
    const __m512i group = _mm512_set1_epi32(CVOL_GROUP), one = _mm512_set1_epi32(1);
    const __m512i from = _mm512_add_epi32(floor_words(_mm512_loadu_ps(at->lane[0])), group),
                  begin = _mm512_add_epi32(floor_words(_mm512_loadu_ps(at->begin)), group),
                  to = _mm512_add_epi32(floor_words(_mm512_loadu_ps(at->lane[1])), one);
    const __m512i c0 = _mm512_srai_epi32(from, 4),
                  c1 = _mm512_srai_epi32(_mm512_max_epi32(begin, to), 4);
    _mm512_storeu_si512(out->c0 + s, clamp_words(c0, last_window));
    _mm512_storeu_si512(out->c1 + s, clamp_words(c1, last_window));
    _mm512_storeu_si512(out->r0 + s, find_block_rows(at->row[0], 0, inverse, last));
    _mm512_storeu_si512(out->r1 + s, find_block_rows(at->row[1], 1, inverse, last));
#else
    for (int k = 0; k < CVOL_GROUP; k++) {
        const int from = (int)floorf(at->lane[0][k]) + CVOL_GROUP,
                  begin = (int)floorf(at->begin[k]) + CVOL_GROUP,
                  to = (int)floorf(at->lane[1][k]) + 1;
        const float y0 = floorf(at->row[0][k]) + 0.5f, y1 = floorf(at->row[1][k]) + 1.5f;
        out->c0[s + k] = clamp_to(from >> 4, last_window);
        out->c1[s + k] = clamp_to((begin > to ? begin : to) >> 4, last_window);
        out->r0[s + k] = clamp_to((int)floorf(y0 * inverse), last);
        out->r1[s + k] = clamp_to((int)floorf(y1 * inverse), last);
    }
#endif
}

/* How far a group reaches from its first pixel on: along lanes, and rows before and behind. */
typedef struct group_reach {
    float lane, above, below;
} group_reach;

CVOL_INLINE group_reach find_reach(const cvol_layer *layer)
{
    const float across = CVOL_GROUP - 1, right = across * (float)layer->sheets[0].row_right;
    return (group_reach){across * (float)layer->sheets[0].lane_step, right < 0 ? right : 0,
                         right < 0 ? 0 : right};
}

/* Windows of a group on all sheets. */
CVOL_INLINE void find_group_windows(group_windows *out, const line_job *job, int group)
{
    const cvol_layer *layer = job->layer;
    const group_reach reach = find_reach(layer);
    const float i = (float)(group * CVOL_GROUP), lane = i * (float)layer->sheets[0].lane_step,
                row = i * (float)layer->sheets[0].row_right;
    for (int s = 0; s < layer->sheet_count; s += CVOL_GROUP) {
        sixteen_places at;
        for (int k = 0; k < CVOL_GROUP; k++) {
            at.lane[0][k] = at.begin[k] = job->lane_at[s + k] + lane;
            at.lane[1][k] = at.lane[0][k] + reach.lane;
            at.row[0][k] = job->row_at[s + k] + row + reach.above;
            at.row[1][k] = job->row_at[s + k] + row + reach.below;
        }
        find_sixteen_windows(out, s, layer, &at);
    }
}

/* Those that groups group .. + 15 meet on any of the sheets from s to end. */
CVOL_INLINE void find_boxes(group_windows *out, const line_job *job, int group, int s, int end)
{
    const cvol_layer *layer = job->layer;
    const group_reach reach = find_reach(layer);
    const float *lane = job->lane_at, *row = job->row_at;
    const int k = end - 1; /* straight between */
    const float lanes[2] = {lane[s] < lane[k] ? lane[s] : lane[k],
                            (lane[s] < lane[k] ? lane[k] : lane[s]) + reach.lane},
                rows[2] = {(row[s] < row[k] ? row[s] : row[k]) + reach.above,
                           (row[s] < row[k] ? row[k] : row[s]) + reach.below};
    const float step = (float)layer->sheets[0].lane_step, right = (float)layer->sheets[0].row_right;
    sixteen_places at;
    for (int g = 0; g < CVOL_GROUP; g++) {
        const float i = (float)((group + g) * CVOL_GROUP);
        for (int end_of = 0; end_of < 2; end_of++) {
            at.lane[end_of][g] = lanes[end_of] + i * step;
            at.row[end_of][g] = rows[end_of] + i * right;
        }
        at.begin[g] = at.lane[1][g] - reach.lane;
    }
    find_sixteen_windows(out, 0, layer, &at);
}

/* In which of the layer's sheets from s to `end`, which have the same windows, a group sees
 * anything; *mixed: in which of these some pixels may not. */
CVOL_INLINE uint32_t find_seen_sheets(uint32_t *mixed, const group_windows *at,
                                      const cvol_windows *windows, int s, int end)
{
    uint32_t seen = 0, any = 0, some = 0;
    for (int k = s; k < end; k++) {
        const int b = k - 1; /* mostly they are those of the sheet before */
        if (k == s || at->c0[k] != at->c0[b] || at->c1[k] != at->c1[b] || at->r0[k] != at->r0[b] ||
            at->r1[k] != at->r1[b]) {
            const int box[4] = {at->c0[k], at->c1[k], at->r0[k], at->r1[k]};
            any = (uint32_t)find_seen(windows, box[0], box[1], box[2], box[3]);
            some = any && !find_all_seen(windows, box[0], box[1], box[2], box[3]);
        }
        seen |= any << k;
        *mixed |= some << k;
    }
    return seen;
}

/* Sets `bit` for groups begin .. end - 1 of sixteen. */
CVOL_INLINE void add_groups(uint32_t to[CVOL_GROUP], int begin, int end, uint32_t bit)
{
#if defined(__AVX512F__)
    begin = clamp_to(begin, CVOL_GROUP);
    end = clamp_to(end, CVOL_GROUP);
    const __mmask16 groups = (__mmask16)(((1u << end) - 1) & ~((1u << begin) - 1));
    const __m512i bits = _mm512_loadu_si512(to);
    _mm512_storeu_si512(to, _mm512_mask_or_epi32(bits, groups, bits, _mm512_set1_epi32((int)bit)));
    return;
#endif
    for (int g = 0; g < CVOL_GROUP; g++)
        to[g] |= g >= begin && g < end ? bit : 0;
}

/* What sixteen groups see of the layer's sheets from s to `end`, which have the same windows. */
CVOL_INLINE void find_seen_groups(line_job *job, int first, int count, const cvol_windows *windows,
                                  int s, int end)
{
    const uint32_t sheets = (uint32_t)((UINT64_C(1) << end) - (UINT64_C(1) << s));
    const int from = first - job->first_group;
    group_windows boxes;
    find_boxes(&boxes, job, first, s, end);
    for (int g = 0; g < count; g++) {
        const int at = from + g, box[4] = {boxes.c0[g], boxes.c1[g], boxes.r0[g], boxes.r1[g]};
        if (!(job->met[at] & sheets) || job->line->opaque[first + g] ||
            !find_seen(windows, box[0], box[1], box[2], box[3]))
            continue;
        if (find_all_seen(windows, box[0], box[1], box[2], box[3])) {
            job->seen[at] |= job->met[at] & sheets;
            continue;
        }
        group_windows places;
        find_group_windows(&places, job, first + g);
        job->seen[at] |= job->met[at] & find_seen_sheets(&job->mixed[at], &places, windows, s, end);
    }
}

/* What find_met finds. */
CVOL_INLINE void find_met_slanted(line_job *job, int first, int count)
{
    const cvol_layer *layer = job->layer;
    const int sheets = layer->sheet_count,
              whole = (count + CVOL_GROUP - 1) / CVOL_GROUP * CVOL_GROUP;
    int held = 0; /* these come first */
    while (held < sheets && layer->sheets[held].is_of_before)
        held++;
    memset(job->met, 0, sizeof *job->met * (size_t)whole);
    memset(job->seen, 0, sizeof *job->seen * (size_t)whole);
    memset(job->inside, 0, sizeof *job->inside * (size_t)whole);
    memset(job->mixed, 0, sizeof *job->mixed * (size_t)whole);
    job->first_group = first;
    for (int g = 0; g < count; g += CVOL_GROUP) {
        for (int s = 0; s < sheets; s++) {
            const sheet_line *sheet = &job->sheets[s];
            const int begin = sheet->begin - first - g, end = sheet->end - first - g,
                      inside_begin = sheet->inside_begin - first - g,
                      inside_end = sheet->inside_end - first - g;
            add_groups(job->met + g, begin, end, UINT32_C(1) << s);
            add_groups(job->inside + g, inside_begin > begin ? inside_begin : begin,
                       inside_end < end ? inside_end : end, UINT32_C(1) << s);
        }
        const int groups = count - g < CVOL_GROUP ? count - g : CVOL_GROUP;
        if (held)
            find_seen_groups(job, first + g, groups, &layer->windows_before, 0, held);
        if (sheets > held)
            find_seen_groups(job, first + g, groups, &layer->windows, held, sheets);
    }
}

/* Whether the samples that a group sees of a sheet are all there. */
CVOL_INLINE int is_there_slanted(const line_job *job, const sheet_line *sheet, int group)
{
    group_windows at;
    place_windows(&at, 0, job, (float)sheet->lane_at, (float)sheet->row_at, group);
    return find_all_seen(sheet->windows, at.c0[0], at.c1[0], at.r0[0], at.r1[0]);
}

/* Values amidst what a group's windows hold, part by part, pixel by pixel, as table coordinates:
 * where it was `by` sheets from sheet s. Returns whether there is something to be seen in one of
 * these. */
CVOL_INLINE int find_levels(cvol_vf *levels, const line_job *job, int s,
                            const cvol_windows *windows, int group, double by)
{
    const cvol_layer *layer = job->layer;
    const cvol_sheet_view *sheet = &layer->sheets[s];
    const int last = layer->block_rows * layer->row_points - 1;
    const double lane_at = job->sheets[s].lane_at + by * sheet->lane_rate[0],
                 row_at = job->sheets[s].row_at + by * sheet->row_rate[0];
    group_windows at;
    place_windows(&at, 0, job, (float)lane_at, (float)row_at, group);
    for (int k = 0; k < CVOL_GROUP; k++) {
        const int i = group * CVOL_GROUP + k;
        const double x = lane_at + i * sheet->lane_step, y = row_at + i * sheet->row_right;
        const uint64_t row = (uint64_t)(y < 0 ? 0 : y > last ? last : floor(y));
        const long block_row = clamp_row(windows, (int)(row * layer->row_points_inverse >> 32));
        long c = window_of((long)floor(x));
        c = c < at.c0[0] ? at.c0[0] : c > at.c1[0] ? at.c1[0] : c;
        levels[k / CVOL_LANES][k % CVOL_LANES] =
            windows->within_level[c + block_row * windows->count];
    }
    for (int k = 0; k < PARTS; k++)
        levels[k] = to_table(job, levels[k]);
    return find_seen(windows, at.c0[0], at.c1[0], at.r0[0], at.r1[0]);
}

/* The values at which a group met the sheet before sheet `s`, which was skipped. 0 if they are not
 * known. */
CVOL_INLINE int find_levels_before(cvol_vf *levels, const line_job *job, int s, int group)
{
    const cvol_layer *layer = job->layer;
    const cvol_sheet_view *sheet = &layer->sheets[s];
    const cvol_windows *windows = sheet->is_first || sheet->is_of_before ? &layer->windows_before
                                                                         : &layer->windows;
    if (!windows->count || (sheet->is_first && sheet->is_of_before))
        return 0;
    return !find_levels(levels, job, s, windows, group, -1);
}

/* ---- values -----------------------------------------------------------------------------------
 */

/* The window of a pixel at (x, y), counted as they lie in memory; *level: of it, if there is
 * nothing to be seen in it, and its samples are not there. */
CVOL_INLINE int is_window_seen(float *level, const cvol_layer *layer, const cvol_windows *windows,
                               long x, long y)
{
    const int last = layer->block_rows * layer->row_points - 1;
    const uint64_t low = (uint64_t)clamp_to((int)y, last),
                   high = (uint64_t)clamp_to((int)y + 1, last);
    const long row = clamp_row(windows, (int)(low * layer->row_points_inverse >> 32)),
               next = clamp_row(windows, (int)(high * layer->row_points_inverse >> 32));
    const long at = row * windows->count +
                    clamp_to((int)((x + CVOL_GROUP) >> 4), windows->count - 1);
    *level = (next > row ? windows->across_level : windows->within_level)[at];
    return (next > row ? windows->across : windows->within)[at] & CVOL_WINDOW_SEEN;
}

/* A value as samples are kept. */
CVOL_INLINE float kept_value(const cvol_layer *layer, float value)
{
#ifdef SHEET_COMPACT
    return cvol_sheet_compact_of(&layer->compact, value);
#endif
    (void)layer;
    return value;
}

#if defined(__AVX512F__)

/* The same of 16 pixels at (x, y); which see nothing. */
CVOL_INLINE __mmask16 find_unseen(__m512 *levels, const cvol_layer *layer,
                                  const cvol_windows *windows, __m512i x, __m512i y)
{
    const __m512i zero = _mm512_setzero_si512(),
                  last = _mm512_set1_epi32(layer->block_rows * layer->row_points - 1);
    const __m512i column = _mm512_srai_epi32(_mm512_add_epi32(x, _mm512_set1_epi32(CVOL_GROUP)), 4),
                  window = _mm512_max_epi32(
                      _mm512_min_epi32(column, _mm512_set1_epi32(windows->count - 1)), zero);
    const float inverse = 1 / (float)layer->row_points;
    __m512i rows[2];
    for (int k = 0; k < 2; k++) {
        const __m512i row = _mm512_max_epi32(
            _mm512_min_epi32(_mm512_add_epi32(y, _mm512_set1_epi32(k)), last), zero);
        const __m512i block = _mm512_cvttps_epi32(_mm512_mul_ps(
            _mm512_add_ps(_mm512_cvtepi32_ps(row), _mm512_set1_ps(0.5f)), _mm512_set1_ps(inverse)));
        rows[k] = _mm512_max_epi32(_mm512_min_epi32(block, _mm512_set1_epi32(windows->last_row)),
                                   _mm512_set1_epi32(windows->first_row));
    }
    const __mmask16 crosses = _mm512_cmpgt_epi32_mask(rows[1], rows[0]);
    const __m512i first = _mm512_add_epi32(
        _mm512_mullo_epi32(rows[0], _mm512_set1_epi32(windows->count)), window);
    /* What is across lies behind what is within. */
    const __m512i at = _mm512_mask_add_epi32(
        first, crosses, first, _mm512_set1_epi32((int)(windows->across - windows->within)));
    const __m512i bits = _mm512_i32gather_epi32(at, windows->within, 1);
    const __mmask16 unseen = _mm512_testn_epi32_mask(bits, _mm512_set1_epi32(CVOL_WINDOW_SEEN));
    *levels = _mm512_mask_i32gather_ps(_mm512_setzero_ps(), unseen, at, windows->within_level, 4);
    return unseen;
}

/* What a level is among samples as they are kept. */
CVOL_INLINE __m512 kept_levels(const cvol_layer *layer, __m512 level)
{
#ifdef SHEET_COMPACT
    const __m512i word = _mm512_cvtps_epi32(
        _mm512_add_ps(_mm512_mul_ps(level, _mm512_set1_ps(layer->compact.scale)),
                      _mm512_set1_ps(layer->compact.offset)));
    return _mm512_cvtepi32_ps(_mm512_max_epi32(_mm512_min_epi32(word, _mm512_set1_epi32(INT16_MAX)),
                                               _mm512_setzero_si512()));
#endif
    (void)layer;
    return level;
}

#endif

/* Puts levels where the CVOL_LANES pixels from pixel i on see nothing. */
CVOL_COLD cvol_vf put_levels(cvol_vf value, const line_job *job, const sheet_line *sheet, int i)
{
#if defined(__AVX512F__)
    const double x = sheet->lane_at + (double)i * sheet->lane_step,
                 y = sheet->row_at + (double)i * sheet->row_right;
    const double x0 = floor(x), y0 = floor(y);
    const __m512 iota = (__m512)cvol_iota();
    const __m512 u = _mm512_fmadd_ps(iota, _mm512_set1_ps((float)sheet->lane_step),
                                     _mm512_set1_ps((float)(x - x0))),
                 v = _mm512_fmadd_ps(iota, _mm512_set1_ps((float)sheet->row_right),
                                     _mm512_set1_ps((float)(y - y0)));
    const int down = _MM_FROUND_TO_NEG_INF | _MM_FROUND_NO_EXC;
    __m512 levels;
    const __mmask16 unseen = find_unseen(
        &levels, job->layer, sheet->windows,
        _mm512_add_epi32(_mm512_cvt_roundps_epi32(u, down), _mm512_set1_epi32((int)x0)),
        _mm512_add_epi32(_mm512_cvt_roundps_epi32(v, down), _mm512_set1_epi32((int)y0)));
    return (cvol_vf)_mm512_mask_mov_ps((__m512)value, unseen, kept_levels(job->layer, levels));
#else
    for (int k = 0; k < CVOL_LANES; k++) {
        const double x = sheet->lane_at + (i + k) * sheet->lane_step,
                     y = sheet->row_at + (i + k) * sheet->row_right;
        float level;
        if (!is_window_seen(&level, job->layer, sheet->windows, (long)floor(x), (long)floor(y)))
            value[k] = kept_value(job->layer, level);
    }
    return value;
#endif
}

/* Samples, as they are kept, at CVOL_LANES pixels from pixel i on. What lies beyond those that are
 * there is as good as any: such pixels are not drawn. */
CVOL_INLINE cvol_vf reconstruct_slanted(const line_job *job, const sheet_line *sheet, int i)
{
    const cvol_layer *layer = job->layer;
    const double x = sheet->lane_at + (double)i * sheet->lane_step,
                 y = sheet->row_at + (double)i * sheet->row_right;
    const double x0 = floor(x), y0 = floor(y);
    const cvol_vf u = (float)(x - x0) + cvol_iota() * (float)sheet->lane_step,
                  v = (float)(y - y0) + cvol_iota() * (float)sheet->row_right;
    const float bias = 1024; /* rows may lie before the first pixel's */
    const cvol_vi column = cvol_to_int(u), row = cvol_to_int(v + bias) - (int)bias;
    const cvol_vf right = u - cvol_to_float(column), below = v - cvol_to_float(row);
    const long stride = layer->row_stride;
    cvol_vf a = {0}, b = {0}, c = {0}, d = {0};
#if defined(__AVX512F__)
    const __m512i lane = _mm512_max_epi32(
                      _mm512_min_epi32(
                          _mm512_add_epi32((__m512i)column, _mm512_set1_epi32((int)x0)),
                          _mm512_set1_epi32(layer->to_lane - 1)),
                      _mm512_set1_epi32(layer->from_lane)),
                  line = _mm512_max_epi32(
                      _mm512_min_epi32(_mm512_add_epi32((__m512i)row, _mm512_set1_epi32((int)y0)),
                                       _mm512_set1_epi32(layer->to_row - 1)),
                      _mm512_set1_epi32(layer->from_row));
    /* From the first row that is there on, so that 32 bits do. */
    const sheet_sample *from_row = sheet->origin + layer->from_row * stride;
    const __m512i at = _mm512_add_epi32(
        _mm512_mullo_epi32(_mm512_sub_epi32(line, _mm512_set1_epi32(layer->from_row)),
                           _mm512_set1_epi32((int)stride)),
        lane);
#ifdef SHEET_COMPACT
    const __m512i pairs[2] = {_mm512_i32gather_epi32(at, from_row, 2),
                              _mm512_i32gather_epi32(at, from_row + stride, 2)};
    a = (cvol_vf)_mm512_cvtepi32_ps(_mm512_srai_epi32(_mm512_slli_epi32(pairs[0], 16), 16));
    b = (cvol_vf)_mm512_cvtepi32_ps(_mm512_srai_epi32(pairs[0], 16));
    c = (cvol_vf)_mm512_cvtepi32_ps(_mm512_srai_epi32(_mm512_slli_epi32(pairs[1], 16), 16));
    d = (cvol_vf)_mm512_cvtepi32_ps(_mm512_srai_epi32(pairs[1], 16));
#else
    a = (cvol_vf)_mm512_i32gather_ps(at, from_row, 4);
    b = (cvol_vf)_mm512_i32gather_ps(at, from_row + 1, 4);
    c = (cvol_vf)_mm512_i32gather_ps(at, from_row + stride, 4);
    d = (cvol_vf)_mm512_i32gather_ps(at, from_row + stride + 1, 4);
#endif
#else
    for (int k = 0; k < CVOL_LANES; k++) {
        long at = (long)x0 + column[k], line = (long)y0 + row[k];
        at = at < layer->from_lane ? layer->from_lane : at;
        at = at > layer->to_lane - 1 ? layer->to_lane - 1 : at;
        line = line < layer->from_row ? layer->from_row : line;
        line = line > layer->to_row - 1 ? layer->to_row - 1 : line;
        const sheet_sample *from = sheet->origin + line * stride + at;
        a[k] = from[0];
        b[k] = from[1];
        c[k] = from[stride];
        d[k] = from[stride + 1];
    }
#endif
    const cvol_vf near = a + right * (b - a), far = c + right * (d - c);
    const cvol_vf value = near + below * (far - near);
    /* Between sheets all is seen, or nothing looked at. */
    if (sheet->number >= 0 && job->mixed[i / CVOL_GROUP - job->first_group] >> sheet->number & 1)
        return put_levels(value, job, sheet, i);
    return value;
}

#endif
