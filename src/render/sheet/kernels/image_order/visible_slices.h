/* The slices of a layer in which groups of a line that crosses rows of samples obliquely
 * (line_slanted.h) see something: sixteen groups or slices together.
 *
 * Only line_slanted.h includes this file. */
#ifndef CVOL_RENDER_SHEET_KERNELS_IMAGE_ORDER_VISIBLE_SLICES_H
#define CVOL_RENDER_SHEET_KERNELS_IMAGE_ORDER_VISIBLE_SLICES_H

/* The windows of a group in each slice of the layer: windows c0 .. c1 of rows r0 .. r1 of
 * blocks. */
typedef struct group_windows {
    int c0[CVOL_BLOCK_MAX], c1[CVOL_BLOCK_MAX], r0[CVOL_BLOCK_MAX], r1[CVOL_BLOCK_MAX];
} group_windows;

/* A row of blocks with windows: groups may reach beyond their lines, with pixels that are not
 * drawn. */
CVOL_INLINE int clamp_row(const cvol_windows *windows, int row)
{
    row = row > windows->last_row ? windows->last_row : row;
    return row < windows->first_row ? windows->first_row : row;
}

/* Eight windows' flags, and the visible ones of the first `count`. Behind the last row there are
 * eight more bytes. */
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

/* Returns 1 if any of windows c0 .. c1 of rows r0 .. r1 of blocks is visible. */
CVOL_INLINE int find_seen(const cvol_windows *windows, int c0, int c1, int r0, int r1)
{
    r0 = clamp_row(windows, r0);
    r1 = clamp_row(windows, r1);
    const uint8_t *bits = (r1 > r0 ? windows->across : windows->within) +
                          (ptrdiff_t)r0 * windows->count;
    const int last = r1 > r0 ? r1 - 1 : r1;
    uint64_t seen = 0;
    for (int r = r0; r <= last; r++, bits += windows->count)
        for (int c = c0; c <= c1; c += FLAGS_AT_ONCE)
            seen |= load_flags(bits + c) &
                    seen_flags(c1 - c < FLAGS_AT_ONCE ? c1 - c + 1 : FLAGS_AT_ONCE);
    return seen != 0;
}

/* Returns 1 if all of them are visible, and one more behind, which the last pixels may use. */
CVOL_INLINE int find_all_seen(const cvol_windows *windows, int c0, int c1, int r0, int r1)
{
    r0 = clamp_row(windows, r0);
    r1 = clamp_row(windows, r1);
    const uint8_t *bits = windows->within + (ptrdiff_t)r0 * windows->count;
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

/* The extent of a group from its first pixel: lanes, and rows. */
typedef struct group_extent {
    float left, right, above, below;
} group_extent;

CVOL_INLINE group_extent find_extent(const cvol_layer *layer)
{
    const cvol_sheet_view *of = &layer->sheets[0];
    return (group_extent){
        (float)(least_reach(of->lane_step, GROUP_ACROSS) + least_reach(of->lane_down, GROUP_DOWN)),
        (float)(most_reach(of->lane_step, GROUP_ACROSS) + most_reach(of->lane_down, GROUP_DOWN)),
        (float)(least_reach(of->row_right, GROUP_ACROSS) + least_reach(of->row_step, GROUP_DOWN)),
        (float)(most_reach(of->row_right, GROUP_ACROSS) + most_reach(of->row_step, GROUP_DOWN))};
}

/* The windows of a group of a line that begins at lane_at and row_at of slice s. */
CVOL_INLINE void place_windows(group_windows *out, int s, const line_job *job, float lane_at,
                               float row_at, int group)
{
    const cvol_layer *layer = job->layer;
    const int last = layer->block_rows - 1, last_window = layer->windows.count - 1;
    const group_extent extent = find_extent(layer);
    const float i = (float)(group * GROUP_ACROSS);
    const float step = (float)layer->sheets[0].lane_step, right = (float)layer->sheets[0].row_right;
    const float inverse = 1 / (float)layer->row_points, half = 0.5f * inverse;
    const float x = lane_at + i * step, y = row_at + i * right;
    const int x0 = (int)floorf(x + extent.left), x1 = (int)floorf(x + extent.right) + 1;
    const float y0 = floorf(y + extent.above), y1 = floorf(y + extent.below) + 1;
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

CVOL_INLINE __m512i floor_int16(__m512 value)
{
    return _mm512_cvt_roundps_epi32(value, _MM_FROUND_TO_NEG_INF | _MM_FROUND_NO_EXC);
}

CVOL_INLINE __m512i clamp_int16(__m512i value, int last)
{
    return _mm512_max_epi32(_mm512_min_epi32(value, _mm512_set1_epi32(last)),
                            _mm512_setzero_si512());
}

CVOL_INLINE __m256i half_of(__m512i numbers, int half)
{
    return half ? _mm512_extracti64x4_epi64(numbers, 1) : _mm512_castsi512_si256(numbers);
}

/* The samples before which a group's 16 pixels lie, from one at `at` on. */
CVOL_INLINE __m512i find_places(double at, double across, double down)
{
    const double whole = floor(at);
    const cvol_vf from = (float)(at - whole) + spread_pixels((float)across, (float)down);
    return _mm512_add_epi32(floor_int16((__m512)from), _mm512_set1_epi32((int)whole));
}

/* A bit for each of sixteen groups before that one. */
CVOL_INLINE uint32_t before_group(int group)
{
    return (1u << clamp_to(group, CVOL_GROUP)) - 1;
}

/* The rows of blocks of 16 samples, and `next` behind these. */
CVOL_INLINE __m512i find_block_rows(const float row[CVOL_GROUP], float next, float inverse,
                                    int last)
{
    const __m512 middle = _mm512_add_ps(
        _mm512_roundscale_ps(_mm512_loadu_ps(row), _MM_FROUND_TO_NEG_INF),
        _mm512_set1_ps(0.5f + next));
    return clamp_int16(floor_int16(_mm512_mul_ps(middle, _mm512_set1_ps(inverse))), last);
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
    const __m512i from = _mm512_add_epi32(floor_int16(_mm512_loadu_ps(at->lane[0])), group),
                  begin = _mm512_add_epi32(floor_int16(_mm512_loadu_ps(at->begin)), group),
                  to = _mm512_add_epi32(floor_int16(_mm512_loadu_ps(at->lane[1])), one);
    const __m512i c0 = _mm512_srai_epi32(from, 4),
                  c1 = _mm512_srai_epi32(_mm512_max_epi32(begin, to), 4);
    _mm512_storeu_si512(out->c0 + s, clamp_int16(c0, last_window));
    _mm512_storeu_si512(out->c1 + s, clamp_int16(c1, last_window));
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

/* The extent of a group, and its movement from the slice before, through which it may see
 * something, too: lanes and rows before its position, and behind. */
typedef struct group_reach {
    group_extent extent;
    float from_lane[2], from_row[2];
} group_reach;

CVOL_INLINE group_reach find_reach(const cvol_layer *layer)
{
    const float lane = (float)layer->sheets[0].lane_rate[0],
                row = (float)layer->sheets[0].row_rate[0];
    return (group_reach){find_extent(layer),
                         {lane > 0 ? -lane : 0, lane > 0 ? 0 : -lane},
                         {row > 0 ? -row : 0, row > 0 ? 0 : -row}};
}

/* Windows of a group on all slices. */
CVOL_INLINE void find_group_windows(group_windows *out, const line_job *job, int group)
{
    const cvol_layer *layer = job->layer;
    const group_reach reach = find_reach(layer);
    const float i = (float)(group * GROUP_ACROSS), lane = i * (float)layer->sheets[0].lane_step,
                row = i * (float)layer->sheets[0].row_right;
    for (int s = 0; s < layer->sheet_count; s += CVOL_GROUP) {
        sixteen_places at;
        for (int k = 0; k < CVOL_GROUP; k++) {
            const float x = job->lane_at[s + k] + lane, y = job->row_at[s + k] + row;
            at.lane[0][k] = x + reach.extent.left + reach.from_lane[0];
            at.begin[k] = x + reach.extent.left + reach.from_lane[1];
            at.lane[1][k] = x + reach.extent.right + reach.from_lane[1];
            at.row[0][k] = y + reach.extent.above + reach.from_row[0];
            at.row[1][k] = y + reach.extent.below + reach.from_row[1];
        }
        find_sixteen_windows(out, s, layer, &at);
    }
}

/* The windows that groups group .. + 15 meet on any of the slices from s to end. */
CVOL_INLINE void find_boxes(group_windows *out, const line_job *job, int group, int s, int end)
{
    const cvol_layer *layer = job->layer;
    const group_reach reach = find_reach(layer);
    const float *lane = job->lane_at, *row = job->row_at;
    const int k = end - 1; /* linear between */
    const group_extent extent = reach.extent;
    const float lanes[2] = {(lane[s] < lane[k] ? lane[s] : lane[k]) + reach.from_lane[0] +
                                extent.left,
                            (lane[s] < lane[k] ? lane[k] : lane[s]) + reach.from_lane[1] +
                                extent.right},
                rows[2] = {(row[s] < row[k] ? row[s] : row[k]) + reach.from_row[0] + extent.above,
                           (row[s] < row[k] ? row[k] : row[s]) + reach.from_row[1] + extent.below};
    const float step = (float)layer->sheets[0].lane_step, right = (float)layer->sheets[0].row_right;
    sixteen_places at;
    for (int g = 0; g < CVOL_GROUP; g++) {
        const float i = (float)((group + g) * GROUP_ACROSS);
        for (int end_of = 0; end_of < 2; end_of++) {
            at.lane[end_of][g] = lanes[end_of] + i * step;
            at.row[end_of][g] = rows[end_of] + i * right;
        }
        at.begin[g] = at.lane[1][g] - (extent.right - extent.left);
    }
    find_sixteen_windows(out, 0, layer, &at);
}

/* For sixteen or fewer boxes of windows from number s on: a bit for each box with a visible window;
 * *all: for each box with only visible windows. */
CVOL_INLINE uint32_t find_seen_boxes(uint32_t *all, const group_windows *at, int s, int count,
                                     const cvol_windows *windows)
{
    uint32_t left = (1u << count) - 1, seen = 0;
    *all = 0;
#if defined(__AVX512F__)
    const __mmask16 which = (__mmask16)left;
    const __m512i first_row = _mm512_set1_epi32(windows->first_row),
                  last_row = _mm512_set1_epi32(windows->last_row),
                  last = _mm512_set1_epi32(windows->count - 1), one = _mm512_set1_epi32(1);
    const __m512i c0 = _mm512_maskz_loadu_epi32(which, at->c0 + s),
                  c1 = _mm512_maskz_loadu_epi32(which, at->c1 + s),
                  r0 = _mm512_max_epi32(
                      _mm512_min_epi32(_mm512_maskz_loadu_epi32(which, at->r0 + s), last_row),
                      first_row),
                  r1 = _mm512_max_epi32(
                      _mm512_min_epi32(_mm512_maskz_loadu_epi32(which, at->r1 + s), last_row),
                      first_row);
    const __m512i across = _mm512_sub_epi32(c1, c0), /* windows minus one; and one more behind */
        behind = _mm512_sub_epi32(_mm512_min_epi32(_mm512_add_epi32(c1, one), last), c0);
    const __m512i stride = _mm512_set1_epi32(windows->count);
    const __m512i near = _mm512_add_epi32(_mm512_mullo_epi32(r0, stride), c0),
                  far = _mm512_add_epi32(_mm512_mullo_epi32(r1, stride), c0);
    const __m512i either = _mm512_mask_add_epi32(
        near, _mm512_cmpgt_epi32_mask(r1, r0), near,
        _mm512_set1_epi32((int)(windows->across - windows->within)));
    const uint32_t fit = _mm512_cmplt_epi32_mask(behind, _mm512_set1_epi32(FLAGS_AT_ONCE)) &
                         _mm512_cmple_epi32_mask(_mm512_sub_epi32(r1, r0), one) & left;
    for (int half = 0; half < 2; half++) {
        const __m512i flags = _mm512_set1_epi64((int64_t)seen_flags(FLAGS_AT_ONCE)),
                      most = _mm512_set1_epi64(FLAGS_AT_ONCE - 1);
        const __m512i any_of = _mm512_i32gather_epi64(half_of(either, half), windows->within, 1),
                      all_of = _mm512_and_si512(
                          _mm512_i32gather_epi64(half_of(near, half), windows->within, 1),
                          _mm512_i32gather_epi64(half_of(far, half), windows->within, 1));
        const __m512i beyond = _mm512_slli_epi64(
                          _mm512_sub_epi64(most, _mm512_cvtepi32_epi64(half_of(across, half))), 3),
                      further = _mm512_slli_epi64(
                          _mm512_sub_epi64(most, _mm512_cvtepi32_epi64(half_of(behind, half))), 3);
        seen |= (uint32_t)_mm512_test_epi64_mask(any_of, _mm512_srlv_epi64(flags, beyond))
                << (8 * half);
        *all |= (uint32_t)_mm512_testn_epi64_mask(
                    _mm512_andnot_si512(all_of, _mm512_srlv_epi64(flags, further)),
                    _mm512_set1_epi64(-1))
                << (8 * half);
    }
    seen &= fit;
    *all &= seen;
    left &= ~fit;
#endif
    for (; left; left &= left - 1) {
        const int k = s + __builtin_ctz(left);
        const uint32_t bit = left & -left;
        if (!find_seen(windows, at->c0[k], at->c1[k], at->r0[k], at->r1[k]))
            continue;
        seen |= bit;
        *all |= find_all_seen(windows, at->c0[k], at->c1[k], at->r0[k], at->r1[k]) ? bit : 0;
    }
    return seen;
}

/* The slices from s to `end`, which have the same windows, that are visible in a group; *mixed:
 * those in which some pixels may be invisible. */
CVOL_INLINE uint32_t find_seen_sheets(uint32_t *mixed, const group_windows *at,
                                      const cvol_windows *windows, int s, int end)
{
    uint32_t seen = 0;
    for (; s < end; s += CVOL_GROUP) {
        uint32_t all;
        const uint32_t some = find_seen_boxes(&all, at, s,
                                              end - s < CVOL_GROUP ? end - s : CVOL_GROUP, windows);
        seen |= some << s;
        *mixed |= (some & ~all) << s;
    }
    return seen;
}

/* Finds the slices that sixteen groups from `first` on meet, and those on which they lie inside. */
CVOL_INLINE void find_intersected_groups(uint32_t intersected[CVOL_GROUP],
                                         uint32_t inside[CVOL_GROUP], const line_job *job,
                                         int first)
{
    const int sheets = job->layer->sheet_count;
#if defined(__AVX512F__)
    __m512i all = _mm512_setzero_si512(), within = _mm512_setzero_si512();
    for (int s = 0; s < sheets; s++) {
        const sheet_line *sheet = &job->sheets[s];
        const __m512i bit = _mm512_set1_epi32((int)(UINT32_C(1) << s));
        const __mmask16 at = (__mmask16)(before_group(sheet->end - first) &
                                         ~before_group(sheet->begin - first)),
                        in = (__mmask16)(before_group(sheet->inside_end - first) &
                                         ~before_group(sheet->inside_begin - first));
        all = _mm512_mask_or_epi32(all, at, all, bit);
        within = _mm512_mask_or_epi32(within, at & in, within, bit);
    }
    _mm512_storeu_si512(intersected, all);
    _mm512_storeu_si512(inside, within);
#else
    memset(intersected, 0, CVOL_GROUP * sizeof *intersected);
    memset(inside, 0, CVOL_GROUP * sizeof *inside);
    for (int s = 0; s < sheets; s++) {
        const sheet_line *sheet = &job->sheets[s];
        for (int k = 0; k < CVOL_GROUP; k++) {
            const int g = first + k, is_intersected = g >= sheet->begin && g < sheet->end;
            intersected[k] |= (uint32_t)is_intersected << s;
            inside[k] |=
                (uint32_t)(is_intersected && g >= sheet->inside_begin && g < sheet->inside_end)
                << s;
        }
    }
#endif
}

/* Finds the slices from s to `end`, which have the same windows, in which sixteen groups see
 * something. */
CVOL_INLINE void find_seen_groups(line_job *job, int first, int count, const cvol_windows *windows,
                                  int s, int end)
{
    const uint32_t sheets = (uint32_t)((UINT64_C(1) << end) - (UINT64_C(1) << s));
    const int from = first - job->first_group;
    group_windows boxes;
    uint32_t all;
    find_boxes(&boxes, job, first, s, end);
    for (uint32_t seen = find_seen_boxes(&all, &boxes, 0, count, windows); seen; seen &= seen - 1) {
        const int g = __builtin_ctz(seen), at = from + g;
        if (!(job->intersected[at] & sheets) || job->line->opaque[first + g])
            continue;
        if (all >> g & 1) {
            job->seen[at] |= job->intersected[at] & sheets;
            job->ways[at] |= sheets & sheets << 1;
            continue;
        }
        group_windows places;
        find_group_windows(&places, job, first + g);
        job->seen[at] |= job->intersected[at] &
                         find_seen_sheets(&job->mixed[at], &places, windows, s, end);
    }
}

/* The result of find_intersected. */
CVOL_INLINE void find_intersected_image_order(line_job *job, int first, int count)
{
    const cvol_layer *layer = job->layer;
    const int sheets = layer->sheet_count,
              whole = (count + CVOL_GROUP - 1) / CVOL_GROUP * CVOL_GROUP;
    int held = 0; /* these come first */
    while (held < sheets && layer->sheets[held].is_of_previous_layer)
        held++;
    memset(job->seen, 0, sizeof *job->seen * (size_t)whole);
    memset(job->mixed, 0, sizeof *job->mixed * (size_t)whole);
    memset(job->ways, 0, sizeof *job->ways * (size_t)whole);
    job->first_group = first;
    for (int g = 0; g < count; g += CVOL_GROUP) {
        find_intersected_groups(job->intersected + g, job->inside + g, job, first + g);
        const int groups = count - g < CVOL_GROUP ? count - g : CVOL_GROUP;
        if (held)
            find_seen_groups(job, first + g, groups, &layer->windows_before, 0, held);
        if (sheets > held)
            find_seen_groups(job, first + g, groups, &layer->windows, held, sheets);
    }
}

#endif
