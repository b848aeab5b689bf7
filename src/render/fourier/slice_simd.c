/* The kernels of a slice: frequencies between places, and their factors.
 *
 * A line's points are processed in runs of sixteen: places and weights for all of them in parallel,
 * then for each point 6 x 6 rows of 6 neighbours, as half floats, one vector of 16 floats per row.
 * Two of a row's eight places have weight 0. */
#include "base/vector_half.h"
#include "render/fourier/spectrum.h"

#define RUN CVOL_FOURIER_RUN
#define TAPS CVOL_FOURIER_TAPS
#define DEGREE CVOL_FOURIER_DEGREE

typedef cvol_floats16 row_floats;

void CVOL_SIMD(cvol_fourier_pack)(uint16_t *out, const float *in, size_t count, float scale)
{
    cvol_store_half(out, in, count, scale);
}

/* ---- places and weights ---------------------------------------------------------------------- */

/* For sixteen points. */
typedef struct run {
    int32_t cell[3][RUN];
    float weight[3][TAPS][RUN], slope[3][TAPS][RUN]; /* slopes by g */
    float flip[RUN];                                 /* -1 if the mirror place is used */
} run;

CVOL_INLINE cvol_vf floor_of(cvol_vf v)
{
    const cvol_vf cut = cvol_to_float(cvol_to_int(v));
    return cut - cvol_select(cut > v, cvol_splat(1), cvol_splat(0));
}

/* Weights of one axis, and their derivatives. */
CVOL_INLINE void weigh(float weight[TAPS][RUN], float slope[TAPS][RUN], int lane, cvol_vf z,
                       const cvol_fourier_kernel *kernel, int cued)
{
    for (int j = 0; j < TAPS; j++) {
        cvol_vf sum = cvol_splat(kernel->taps[DEGREE][j]), rise = cvol_splat(0);
        for (int d = DEGREE - 1; d >= 0; d--) {
            if (cued)
                rise = rise * z + sum;
            sum = sum * z + kernel->taps[d][j];
        }
        cvol_store(weight[j] + lane, sum);
        if (cued)
            cvol_store(slope[j] + lane, rise * 2);
    }
}

CVOL_INLINE void find_places(run *out, const cvol_fourier_line *line, size_t first, int cued)
{
    const cvol_fourier_spectrum *of = line->spectrum;
    float start[3], step[3], period[3];
    for (int a = 0; a < 3; a++) {
        period[a] = (float)of->dims[a];
        start[a] = (float)(line->start[a] + (double)first * line->step[a]);
        step[a] = (float)line->step[a];
    }
    for (int lane = 0; lane < RUN; lane += CVOL_LANES) {
        const cvol_vf k = cvol_iota() + (float)lane;
        cvol_vf g[3], flip = cvol_splat(1);
        for (int a = 0; a < 3; a++) {
            g[a] = k * step[a] + start[a];
            g[a] -= floor_of(g[a] * (1 / period[a]) + 0.5f) * period[a];
        }
        flip = cvol_select(g[0] < 0, cvol_splat(-1), flip);
        cvol_store(out->flip + lane, flip);
        for (int a = 0; a < 3; a++) {
            g[a] *= flip;
            if (a)
                g[a] += cvol_select(g[a] < 0, cvol_splat(period[a]), cvol_splat(0));
            const cvol_vf cell = floor_of(g[a]);
            const cvol_vi index = cvol_to_int(cell);
            memcpy(out->cell[a] + lane, &index, sizeof index);
            weigh(out->weight[a], out->slope[a], lane, (g[a] - cell) * 2 - 1, line->kernel, cued);
        }
    }
}

/* ---- one point ------------------------------------------------------------------------------- */

CVOL_INLINE row_floats twice(const float weight[TAPS][RUN], int k)
{
    return (row_floats){weight[0][k], weight[0][k], weight[1][k], weight[1][k],
                        weight[2][k], weight[2][k], weight[3][k], weight[3][k],
                        weight[4][k], weight[4][k], weight[5][k], weight[5][k]};
}

CVOL_INLINE void add_up(float *re, float *im, row_floats v)
{
    *re = (v[0] + v[2]) + (v[4] + v[6]) + (v[8] + v[10]);
    *im = (v[1] + v[3]) + (v[5] + v[7]) + (v[9] + v[11]);
}

/* For the 36 rows around a point, first value of the first. */
CVOL_INLINE const uint16_t *rows_of(const cvol_fourier_spectrum *of, const run *at, int k)
{
    return of->values + 2 * ((size_t)at->cell[0][k] + of->stride_v * (size_t)at->cell[1][k] +
                             of->stride_w * (size_t)at->cell[2][k]);
}

/* The start of the rows of neighbours around a point. */
typedef struct rows {
    const uint16_t *first; /* for a spectrum with contiguous places: steps from here */
    size_t row, sheet;
    size_t v[TAPS], w[TAPS]; /* for one in bricks: the brick, and within a page */
    size_t in_v[TAPS], in_w[TAPS];
} rows;

CVOL_INLINE void find_rows(rows *out, const cvol_fourier_line *line, const run *at, int k,
                           int paged)
{
    const cvol_fourier_spectrum *of = line->spectrum;
    if (!paged) {
        out->row = 2 * of->stride_v;
        out->sheet = 2 * of->stride_w;
        out->first = rows_of(of, at, k);
        return;
    }
    const size_t u = (size_t)at->cell[0][k], *count = of->bricks.count;
    for (int j = 0; j < TAPS; j++) {
        size_t v = (size_t)(at->cell[1][k] + j) + of->dims[1] - CVOL_FOURIER_BEFORE;
        size_t w = (size_t)(at->cell[2][k] + j) + of->dims[2] - CVOL_FOURIER_BEFORE;
        for (int turn = 0; turn < 2; turn++) {
            v -= v >= of->dims[1] ? of->dims[1] : 0;
            w -= w >= of->dims[2] ? of->dims[2] : 0;
        }
        out->v[j] = count[0] * (v / CVOL_FOURIER_BRICK) + u / CVOL_FOURIER_BRICK;
        out->w[j] = count[0] * count[1] * (w / CVOL_FOURIER_BRICK);
        out->in_v[j] = 2 * CVOL_FOURIER_PAGE_ROW * (v % CVOL_FOURIER_BRICK) +
                       2 * (u % CVOL_FOURIER_BRICK);
        out->in_w[j] = (size_t)2 * CVOL_FOURIER_PAGE_ROW * CVOL_FOURIER_BRICK *
                       (w % CVOL_FOURIER_BRICK);
    }
}

CVOL_INLINE row_floats load_row(const rows *of, const cvol_fourier_line *line, int v, int w,
                                int paged)
{
    if (!paged)
        return cvol_load_half(of->first + (size_t)w * of->sheet + (size_t)v * of->row);
    const size_t page = line->pages->table[of->w[w] + of->v[v]];
    return cvol_load_half(
        line->pages->values +
        page * (2 * CVOL_FOURIER_PAGE_ROW * CVOL_FOURIER_BRICK * CVOL_FOURIER_BRICK) + of->in_w[w] +
        of->in_v[v]);
}

CVOL_INLINE void gather_plain(float *re, float *im, const cvol_fourier_line *line, const run *at,
                              int k, int paged)
{
    rows of;
    find_rows(&of, line, at, k, paged);
    row_floats sum = {0};
    for (int w = 0; w < TAPS; w++) {
        row_floats part = load_row(&of, line, 0, w, paged) * at->weight[1][0][k];
        for (int v = 1; v < TAPS; v++)
            part += load_row(&of, line, v, w, paged) * at->weight[1][v][k];
        sum += part * at->weight[2][w][k];
    }
    add_up(re, im, sum * twice(at->weight[0], k));
}

CVOL_INLINE void gather_cued(float *re, float *im, const cvol_fourier_line *line, const run *at,
                             int k, int paged)
{
    rows of;
    find_rows(&of, line, at, k, paged);
    row_floats sum = {0}, rise = {0};
    for (int w = 0; w < TAPS; w++)
        for (int v = 0; v < TAPS; v++) {
            const row_floats in = load_row(&of, line, v, w, paged);
            sum += in * (at->weight[2][w][k] * at->weight[1][v][k]);
            rise += in * (line->slope[1] * at->weight[2][w][k] * at->slope[1][v][k] +
                          line->slope[2] * at->slope[2][w][k] * at->weight[1][v][k]);
        }
    const row_floats weight = twice(at->weight[0], k);
    float of_re, of_im, rise_re, rise_im;
    add_up(&of_re, &of_im, sum * weight);
    add_up(&rise_re, &rise_im, rise * weight + sum * twice(at->slope[0], k) * line->slope[0]);
    *re = line->near * of_re - rise_im;
    *im = line->near * of_im + rise_re;
}

CVOL_INLINE void gather(float *re, float *im, const cvol_fourier_line *line, int cued, int paged)
{
    const float unit = line->spectrum->unit;
    run at;
    for (size_t first = 0; first < line->count; first += RUN) {
        find_places(&at, line, first, cued);
        const size_t left = line->count - first;
        const int count = left < RUN ? (int)left : RUN;
        for (int k = 0; k < count; k++)
            (cued ? gather_cued : gather_plain)(re + first + k, im + first + k, line, &at, k,
                                                paged);
        for (int lane = 0; lane < RUN; lane += CVOL_LANES) {
            cvol_store(re + first + lane, cvol_load(re + first + lane) * unit);
            cvol_store(im + first + lane,
                       cvol_load(im + first + lane) * cvol_load(at.flip + lane) * unit);
        }
    }
}

void CVOL_SIMD(cvol_fourier_gather)(float *re, float *im, const cvol_fourier_line *line)
{
    if (line->cued && line->pages)
        gather(re, im, line, 1, 1);
    else if (line->cued)
        gather(re, im, line, 1, 0);
    else if (line->pages)
        gather(re, im, line, 0, 1);
    else
        gather(re, im, line, 0, 0);
}

/* ---- factors --------------------------------------------------------------------------------- */

/* sin(pi t) / (pi t) to about 1e-6 of 1 / t, |t| below some thousands. */
CVOL_INLINE cvol_vf sinc(cvol_vf t)
{
    const cvol_vf whole = floor_of(t + 0.5f), r = t - whole, square = r * r;
    /* sin(pi r), |r| <= 1/2, by Taylor's series */
    cvol_vf sine = cvol_splat(-0.0073704309f);
    sine = sine * square + 0.0821458866f;
    sine = sine * square - 0.5992645293f;
    sine = sine * square + 2.5501640399f;
    sine = sine * square - 5.1677127800f;
    sine = sine * square + 3.1415926536f;
    sine *= r;
    const cvol_vf half = whole * 0.5f;
    sine = cvol_select(half == floor_of(half), sine, -sine);
    const cvol_vi small = (t < 1e-3f) & (t > -1e-3f);
    const cvol_vf below = cvol_select(small, cvol_splat(1), t * 3.1415926536f);
    return cvol_select(small, 1 - t * t * 1.6449340668f, sine / below);
}

void CVOL_SIMD(cvol_fourier_weigh)(float *sum, float *box, const cvol_fourier_filter *filter)
{
    for (size_t first = 0; first < filter->count; first += CVOL_LANES) {
        cvol_vf of_sum = cvol_splat(1), of_box = cvol_splat(1);
        for (int a = 0; a < 3; a++) {
            const cvol_vf t = cvol_iota() * (float)filter->step[a] +
                              (float)(filter->start[a] + (double)first * filter->step[a]);
            const cvol_vf factor = sinc(t);
            of_sum *= filter->power[a] == 1 ? factor : factor * factor;
            of_box *= (float)filter->length[a];
            of_box *= filter->power[a] == 1 ? factor
                                            : sinc(t * (float)filter->intervals[a]) * sinc(t * 2);
        }
        cvol_store(sum + first, of_sum);
        cvol_store(box + first, of_box);
    }
}
