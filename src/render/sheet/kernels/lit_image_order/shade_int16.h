/* int16 samples, and their rises, at a group's pixels along lines that cross rows obliquely
 * (line_slanted.h), with AVX-512. It loads the rows of the pixels one after the other, and each
 * pixel takes its samples, or differences of these, from its own rows. In groups of eight int16,
 * the lower four are four pixels' near rows, the upper four the same pixels' far rows.
 *
 * Only kernel files include this file, behind line.h. */
#ifndef CVOL_RENDER_SHEET_KERNELS_LIT_IMAGE_ORDER_SHADE_INT16_H
#define CVOL_RENDER_SHEET_KERNELS_LIT_IMAGE_ORDER_SHADE_INT16_H

/* The most samples of a row that are loaded at once. */
#define ROW_SAMPLES 32
/* Not inlined, since it is long and used in several places. */
#define OUT_OF_LINE static __attribute__((noinline))

/* The positions of a group's pixels. */
typedef struct group_place {
    const int16_t *from; /* the first sample that any pixel takes, in the first row */
    ptrdiff_t stride;
    int least, most;    /* existing rows from there on */
    int x, y;           /* that sample */
    __m512i lane;       /* in int16: distance from there to a pixel's sample */
    __m512i row;        /* the row before it, and the one behind */
    __m512i left_right; /* pairs of int16: weights of left and right */
    __m512 below;
} group_place;

/* Steps from pixel to pixel are the same on all slices. */
CVOL_INLINE void begin_places(line_job *job)
{
    const cvol_sheet_view *sheet = &job->layer->sheets[0];
    const double steps[2] = {sheet->lane_step, sheet->row_right},
                 downs[2] = {sheet->lane_down, sheet->row_step};
    const cvol_vi number = cvol_to_int(cvol_iota());
    for (int axis = 0; axis < 2; axis++) {
        const int step = (int)lrint(steps[axis] * PLACE_ONE),
                  down = (int)lrint(downs[axis] * PLACE_ONE);
        job->begins[axis] = (int)(least_reach(step, GROUP_ACROSS) + least_reach(down, GROUP_DOWN));
        job->reaches[axis] = (int)(most_reach(step, GROUP_ACROSS) + most_reach(down, GROUP_DOWN)) -
                             job->begins[axis];
        job->ramp[axis] = (number & (CVOL_SQUARE - 1)) * step + number / CVOL_SQUARE * down -
                          job->begins[axis];
    }
    const int reach = (job->reaches[0] >> 16) + 5;
    job->samples = reach < 16 ? 16 : reach < 32 ? 32 : 64;
    /* One more if they begin late in a row. */
    job->rows = (job->reaches[1] >> 16) + 3;
}

/* The sum of the weights of left and right. */
#define WEIGHTS_ONE 16384

/* 16 int16, each four of them twice. */
CVOL_INLINE __m512i spread_int16(__m512i numbers)
{
    const __m512i twice = _mm512_set_epi64(3, 3, 2, 2, 1, 1, 0, 0);
    return _mm512_permutexvar_epi64(twice, _mm512_castsi256_si512(_mm512_cvtepi32_epi16(numbers)));
}

/* The inverse: the first of both, as numbers. */
CVOL_INLINE __m512i gather_int16(__m512i head)
{
    const __m512i first = _mm512_set_epi64(6, 4, 2, 0, 6, 4, 2, 0);
    return _mm512_cvtepi16_epi32(_mm512_castsi512_si256(_mm512_permutexvar_epi64(first, head)));
}

/* Field by field: a copy of the whole struct would wait for its parts. */
CVOL_INLINE void place_group(group_place *out, const line_job *job, const sheet_line *sheet,
                             int group, int part)
{
    (void)part; /* there is one */
    const cvol_layer *layer = job->layer;
    const double i = (double)group * GROUP_ACROSS;
    const double x = sheet->lane_at + i * sheet->lane_step + job->begins[0] * (1 / PLACE_ONE),
                 y = sheet->row_at + i * sheet->row_right + job->begins[1] * (1 / PLACE_ONE);
    const double x0 = floor(x), y0 = floor(y);
    const int u0 = (int)((x - x0) * PLACE_ONE), v0 = (int)((y - y0) * PLACE_ONE);
    const __m512i u = _mm512_add_epi32((__m512i)job->ramp[0], _mm512_set1_epi32(u0)),
                  v = _mm512_add_epi32((__m512i)job->ramp[1], _mm512_set1_epi32(v0));
    const __m512i fraction = _mm512_set1_epi32(0xffff);
    const __m512i behind = _mm512_broadcast_i32x4(_mm_set_epi16(1, 1, 1, 1, 0, 0, 0, 0));
    const __m512i right = _mm512_srli_epi32(_mm512_and_si512(u, fraction), 2);
    out->x = (int)x0;
    out->y = (int)y0;
    out->from = sheet->origin + (ptrdiff_t)out->y * layer->row_stride + (ptrdiff_t)out->x;
    out->stride = layer->row_stride;
    out->least = layer->from_row - out->y;
    out->most = layer->to_row - out->y;
    out->lane = spread_int16(_mm512_srli_epi32(u, 16));
    out->row = _mm512_add_epi16(spread_int16(_mm512_srai_epi32(v, 16)), behind);
    out->left_right = _mm512_or_si512(_mm512_sub_epi32(_mm512_set1_epi32(WEIGHTS_ONE), right),
                                      _mm512_slli_epi32(right, 16));
    out->below = _mm512_mul_ps(_mm512_cvtepi32_ps(_mm512_and_si512(v, fraction)),
                               _mm512_set1_ps((float)(1 / PLACE_ONE)));
}

/* ---- rows ------------------------------------------------------------------------------------ */

/* int16 samples of a row: `samples` of them, for the reach of the pixels: 64, of which 32 are
 * `more`, 32 or 16; these mostly lie in one cache line. */
typedef struct row_int16 {
    __m512i head, more;
} row_int16;

CVOL_INLINE row_int16 load_row(const int16_t *from, int samples)
{
    if (samples == 16) {
        const __m512i twice = _mm512_broadcast_i64x4(_mm256_loadu_si256((const __m256i *)from));
        return (row_int16){twice, twice};
    }
    const __m512i head = cvol_load_32_int16(from);
    return (row_int16){head, samples == 64 ? cvol_load_32_int16(from + ROW_SAMPLES) : head};
}

CVOL_INLINE row_int16 mean_of_rows(row_int16 a, row_int16 b, int samples)
{
    const __m512i head = _mm512_avg_epu16(a.head, b.head);
    return (row_int16){head, samples == 64 ? _mm512_avg_epu16(a.more, b.more) : head};
}

CVOL_INLINE row_int16 subtract_row(row_int16 a, row_int16 b, int samples)
{
    const __m512i head = _mm512_sub_epi16(a.head, b.head);
    return (row_int16){head, samples == 64 ? _mm512_sub_epi16(a.more, b.more) : head};
}

/* The row moved by two samples, except the last two. */
CVOL_INLINE row_int16 shift_row(row_int16 row, int samples)
{
    const __m512i on = _mm512_set_epi16(33, 32, 31, 30, 29, 28, 27, 26, 25, 24, 23, 22, 21, 20, 19,
                                        18, 17, 16, 15, 14, 13, 12, 11, 10, 9, 8, 7, 6, 5, 4, 3, 2);
    if (samples < 64) {
        const __m512i head = _mm512_permutexvar_epi16(on, row.head);
        return (row_int16){head, head};
    }
    return (row_int16){_mm512_permutex2var_epi16(row.head, on, row.more),
                       _mm512_permutexvar_epi16(on, row.more)};
}

/* The samples left and right of pixels. */
typedef struct int16_pair {
    __m512i left, right;
} int16_pair;

/* Takes samples of a row for the pixels of a mask. */
CVOL_INLINE void take_int16(int16_pair *out, __mmask32 own, __m512i left, __m512i right,
                            row_int16 row, int samples)
{
    if (samples == 64) {
        out->left = _mm512_mask_mov_epi16(out->left, own,
                                          _mm512_permutex2var_epi16(row.head, left, row.more));
        out->right = _mm512_mask_mov_epi16(out->right, own,
                                           _mm512_permutex2var_epi16(row.head, right, row.more));
        return;
    }
    out->left = _mm512_mask_permutexvar_epi16(out->left, own, left, row.head);
    out->right = _mm512_mask_permutexvar_epi16(out->right, own, right, row.head);
}

CVOL_INLINE __mmask32 pixels_of_row(const group_place *at, int row)
{
    return _mm512_cmpeq_epi16_mask(at->row, _mm512_set1_epi16((int16_t)row));
}

CVOL_INLINE int first_row(const group_place *at)
{
    const int first = at->least > 0 ? at->least : 0;
    return first < at->most ? first : at->most;
}

/* The distance to the next row; behind the last existing one it is 0. */
CVOL_INLINE ptrdiff_t stride_to_next(const group_place *at, int row)
{
    return row <= at->most ? at->stride : 0;
}

/* Calls a function for the largest number of rows that the groups of a frame need, so that the
 * number of iterations is predictable. */
#define CVOL_OF_ROWS(job, call)              \
    do {                                     \
        if ((job)->samples == 64)            \
            call((job)->rows, 64);           \
        else if ((job)->samples == 32)       \
            CVOL_OF_FEW_ROWS(job, call, 32); \
        else                                 \
            CVOL_OF_FEW_ROWS(job, call, 16); \
    } while (0)
#define CVOL_OF_FEW_ROWS(job, call, samples) \
    do {                                     \
        if ((job)->rows == 3)                \
            call(3, samples);                \
        else if ((job)->rows == 4)           \
            call(4, samples);                \
        else if ((job)->rows == 5)           \
            call(5, samples);                \
        else if ((job)->rows == 6)           \
            call(6, samples);                \
        else if ((job)->rows == 7)           \
            call(7, samples);                \
        else if ((job)->rows == 8)           \
            call(8, samples);                \
        else                                 \
            call((job)->rows, samples);      \
    } while (0)

/* ---- values ---------------------------------------------------------------------------------- */

/* In integers until they are weighted by rows: precise where samples hardly differ. */
CVOL_INLINE cvol_vf weigh_int16(const group_place *at, const int16_pair *of)
{
    const __m512i near_pairs = _mm512_unpacklo_epi16(of->left, of->right),
                  far_pairs = _mm512_unpackhi_epi16(of->left, of->right);
    const __m512 near = _mm512_cvtepi32_ps(_mm512_madd_epi16(near_pairs, at->left_right)),
                 far = _mm512_cvtepi32_ps(_mm512_madd_epi16(far_pairs, at->left_right));
    return (cvol_vf)_mm512_mul_ps(_mm512_fmadd_ps(at->below, _mm512_sub_ps(far, near), near),
                                  _mm512_set1_ps(1.0f / WEIGHTS_ONE));
}

CVOL_INLINE void take_values(int16_pair *out, const group_place *at, ptrdiff_t offset, int rows,
                             int samples)
{
    const __m512i lane = at->lane, next = _mm512_add_epi16(lane, _mm512_set1_epi16(1));
    const int first = first_row(at);
    const int16_t *line = at->from + offset + first * at->stride;
    *out = (int16_pair){_mm512_setzero_si512(), _mm512_setzero_si512()};
    for (int row = first; row < first + rows; row++) {
        take_int16(out, pixels_of_row(at, row), lane, next, load_row(line, samples), samples);
        line += stride_to_next(at, row);
    }
}

/* The same if the samples of a row lie within 16, and rows are at most `fours` times four: loads
 * four together, and one permutation finds a place. */
CVOL_INLINE void take_fours(int16_pair *out, const group_place *at, ptrdiff_t offset, int rows,
                            int fours)
{
    const int first = first_row(at);
    const __m512i left = _mm512_add_epi16(
                      _mm512_slli_epi16(
                          _mm512_sub_epi16(at->row, _mm512_set1_epi16((int16_t)first)), 4),
                      at->lane),
                  right = _mm512_add_epi16(left, _mm512_set1_epi16(1));
    const int16_t *line = at->from + offset + first * at->stride;
    int row = first;
    for (int four = 0; four < fours; four++) {
        __m512i pairs[2];
        for (int k = 0; k < 2; k++) {
            const int16_t *const low = line;
            line += row < first + rows - 1 ? stride_to_next(at, row++) : 0;
            pairs[k] = cvol_load_two_int16(low, line);
            line += row < first + rows - 1 ? stride_to_next(at, row++) : 0;
        }
        const __m512i a = _mm512_permutex2var_epi16(pairs[0], left, pairs[1]),
                      b = _mm512_permutex2var_epi16(pairs[0], right, pairs[1]);
        const __mmask32 own = _mm512_cmpge_epi16_mask(left,
                                                      _mm512_set1_epi16((int16_t)(64 * four)));
        out->left = four ? _mm512_mask_mov_epi16(out->left, own, a) : a;
        out->right = four ? _mm512_mask_mov_epi16(out->right, own, b) : b;
    }
}

/* Samples, `offset` behind the slice's. */
OUT_OF_LINE cvol_vf value_of_group(const line_job *job, const group_place *at, ptrdiff_t offset)
{
    int16_pair values;
    if (job->samples == 16 && job->rows <= 8) {
        if (job->rows <= 4)
            take_fours(&values, at, offset, job->rows, 1);
        else
            take_fours(&values, at, offset, job->rows, 2);
        return weigh_int16(at, &values);
    }
#define TAKE_VALUES(rows, samples) take_values(&values, at, offset, rows, samples)
    CVOL_OF_ROWS(job, TAKE_VALUES);
#undef TAKE_VALUES
    return weigh_int16(at, &values);
}

/* ---- rises ----------------------------------------------------------------------------------- */

/* Along lanes, rows, and slices: from one before to one behind. */
CVOL_INLINE void take_rises(int16_pair out[3], const group_place *at, ptrdiff_t before,
                            ptrdiff_t behind, int rows, int samples)
{
    const __m512i one = _mm512_set1_epi16(1), left = at->lane, here = _mm512_add_epi16(left, one),
                  right = _mm512_add_epi16(here, one);
    const int first = first_row(at);
    const int16_t *line = at->from - 1 + first * at->stride;
    row_int16 above = load_row(line - at->stride, samples), own = load_row(line, samples);
    for (int k = 0; k < 3; k++)
        out[k] = (int16_pair){_mm512_setzero_si512(), _mm512_setzero_si512()};
    for (int row = first; row < first + rows; row++) {
        const ptrdiff_t stride = stride_to_next(at, row);
        const __mmask32 which = pixels_of_row(at, row);
        const row_int16 below = load_row(line + stride, samples);
        take_int16(&out[0], which, left, here, subtract_row(shift_row(own, samples), own, samples),
                   samples);
        take_int16(&out[1], which, here, right, subtract_row(below, above, samples), samples);
        take_int16(&out[2], which, here, right,
                   subtract_row(load_row(line + behind, samples), load_row(line + before, samples),
                                samples),
                   samples);
        above = own;
        own = below;
        line += stride;
    }
}

OUT_OF_LINE void rise_of_group(cvol_vf out[3], const line_job *job, const group_place *at,
                               ptrdiff_t before, ptrdiff_t behind)
{
    int16_pair rises[3];
#define TAKE_RISES(rows, samples) take_rises(rises, at, before, behind, rows, samples)
    CVOL_OF_ROWS(job, TAKE_RISES);
#undef TAKE_RISES
    for (int k = 0; k < 3; k++)
        out[k] = weigh_int16(at, &rises[k]);
}

/* The midpoint between a slice and the one before: four consecutive slices. */
typedef struct four_sheets {
    ptrdiff_t first, before, behind; /* the slice itself is the third */
} four_sheets;

/* The value there, and its rises: of the mean of the two slices. */
CVOL_INLINE void take_midpoint_value(int16_pair out[4], const group_place *at,
                                     const four_sheets *of, int rows, int samples)
{
    const __m512i one = _mm512_set1_epi16(1), left = at->lane, here = _mm512_add_epi16(left, one),
                  right = _mm512_add_epi16(here, one);
    const int first = first_row(at);
    const int16_t *line = at->from - 1 + first * at->stride;
    row_int16 second = load_row(line + of->before, samples), third = load_row(line, samples);
    row_int16 own = mean_of_rows(second, third, samples),
              above = mean_of_rows(load_row(line + of->before - at->stride, samples),
                                   load_row(line - at->stride, samples), samples);
    for (int k = 0; k < 4; k++)
        out[k] = (int16_pair){_mm512_setzero_si512(), _mm512_setzero_si512()};
    for (int row = first; row < first + rows; row++) {
        const ptrdiff_t stride = stride_to_next(at, row);
        const __mmask32 which = pixels_of_row(at, row);
        const row_int16 from = mean_of_rows(load_row(line + of->first, samples), second, samples),
                        to = mean_of_rows(third, load_row(line + of->behind, samples), samples);
        second = load_row(line + of->before + stride, samples);
        third = load_row(line + stride, samples);
        const row_int16 below = mean_of_rows(second, third, samples);
        take_int16(&out[0], which, left, here, subtract_row(shift_row(own, samples), own, samples),
                   samples);
        take_int16(&out[1], which, here, right, subtract_row(below, above, samples), samples);
        take_int16(&out[2], which, here, right, subtract_row(to, from, samples), samples);
        take_int16(&out[3], which, here, right, own, samples);
        above = own;
        own = below;
        line += stride;
    }
}

OUT_OF_LINE cvol_vf midpoint_of_group(cvol_vf rise[3], const line_job *job, const group_place *at,
                                      const four_sheets *of)
{
    int16_pair head[4];
#define TAKE_MIDPOINT(rows, samples) take_midpoint_value(head, at, of, rows, samples)
    CVOL_OF_ROWS(job, TAKE_MIDPOINT);
#undef TAKE_MIDPOINT
    for (int k = 0; k < 3; k++)
        rise[k] = weigh_int16(at, &head[k]);
    return weigh_int16(at, &head[3]);
}

/* ---- windows --------------------------------------------------------------------------------- */

/* Finds the pixels with an invisible window, and its levels. */
CVOL_INLINE cvol_vi find_unseen_of_group(cvol_vf *levels, const cvol_layer *layer,
                                         const cvol_windows *windows, const group_place *at)
{
    const __m512i lane = gather_int16(at->lane), row = gather_int16(at->row);
    __m512 found;
    const __mmask16 unseen = find_unseen(&found, layer, windows,
                                         _mm512_add_epi32(lane, _mm512_set1_epi32(at->x)),
                                         _mm512_add_epi32(row, _mm512_set1_epi32(at->y)));
    *levels = (cvol_vf)kept_levels(layer, found);
    return (cvol_vi)_mm512_movm_epi32(unseen);
}

#endif
