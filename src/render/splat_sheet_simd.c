/* Sheets: the footprints of a slice's samples are added up, then the sheet is composited.
 *
 * With C and A what a sheet's samples add up to, colour times opacity and opacity, pixel by pixel:
 *
 *     front to back   I += T C,             T *= 1 - A
 *     back to front   I = (1 - A) I + C,    T *= 1 - A
 *
 * Every pixel is the sum of the same samples in the same order however the picture is divided.
 */
#include "base/vector.h"
#include "render/splat.h"

#include <limits.h>
#include <math.h>

/* Pixels of a vector. */
#define PIXELS (CVOL_LANES / CVOL_SPLAT_CHANNELS)

/* Each of PIXELS weights for all channels of its pixel. */
CVOL_INLINE cvol_vf spread(const float *weights)
{
#if defined(__AVX512F__)
    const __m512i index = _mm512_set_epi32(3, 3, 3, 3, 2, 2, 2, 2, 1, 1, 1, 1, 0, 0, 0, 0);
    return (cvol_vf)_mm512_permutevar_ps(_mm512_broadcast_f32x4(_mm_loadu_ps(weights)), index);
#elif defined(__AVX2__)
    const __m256i index = _mm256_set_epi32(1, 1, 1, 1, 0, 0, 0, 0);
    double both;
    memcpy(&both, weights, sizeof both);
    return (cvol_vf)_mm256_permutevar_ps((__m256)_mm256_set1_pd(both), index);
#else
    return cvol_splat(*weights);
#endif
}

/* Four channels for all pixels. */
CVOL_INLINE cvol_vf repeat(const float *channels)
{
#if defined(__AVX512F__)
    return (cvol_vf)_mm512_broadcast_f32x4(_mm_loadu_ps(channels));
#elif defined(__AVX2__)
    return (cvol_vf)_mm256_broadcast_ps((const __m128 *)(const void *)channels);
#else
    return cvol_load(channels);
#endif
}

/* The fourth channel of each pixel for all of its channels. */
CVOL_INLINE cvol_vf spread_fourth(cvol_vf pixels)
{
#if defined(__AVX512F__)
    return (cvol_vf)_mm512_permute_ps((__m512)pixels, 0xff);
#elif defined(__AVX2__)
    return (cvol_vf)_mm256_permute_ps((__m256)pixels, 0xff);
#else
    return cvol_splat(pixels[3]);
#endif
}

/* ---- samples onto a sheet ------------------------------------------------------------- */

/* Vectors of weights that are kept in registers for all rows. */
#define HELD 6

/* A sample's place: its channels, the rows of pixels that it reaches within the band, and what of
 * the table is for them. */
typedef struct placed {
    const float *channels;
    double x, y;
    int py, row, first, end;
} placed;

/* A footprint whose rows all have the same weights, but for a factor. */
CVOL_INLINE void add_product(float *sheet, size_t stride, const float *weights,
                             const float *factors, int rows, int vectors, cvol_vf channels)
{
    cvol_vf held[HELD];
    for (int v = 0; v < vectors; v++)
        held[v] = spread(weights + v * PIXELS);
    for (int r = 0; r < rows; r++, sheet += stride) {
        const cvol_vf scaled = channels * factors[r];
        for (int v = 0; v < vectors; v++) {
            float *at = sheet + v * CVOL_LANES;
            cvol_store(at, cvol_load(at) + held[v] * scaled);
        }
    }
}

/* The same for footprints wider than what is held. */
CVOL_INLINE void add_wide(float *sheet, size_t stride, const float *weights, const float *factors,
                          int rows, int vectors, cvol_vf channels)
{
    for (int r = 0; r < rows; r++, sheet += stride) {
        const cvol_vf scaled = channels * factors[r];
        for (int v = 0; v < vectors; v++) {
            float *at = sheet + v * CVOL_LANES;
            cvol_store(at, cvol_load(at) + spread(weights + v * PIXELS) * scaled);
        }
    }
}

/* Column of the sheet in which the weights of a sample at x begin, and which weights: px. */
CVOL_INLINE int find_column(int *px, const cvol_splat_band *band, const cvol_footprint_table *table,
                            double x)
{
    const double whole = floor(x);
    *px = cvol_footprint_part(x - whole, table->phases_x);
    return (int)whole + table->first_x[*px] + band->margin;
}

/* Product footprints on ellipses that do not slant. 0 if nothing of it lies in the picture. */
CVOL_INLINE int add_straight(int *from, int *to, const cvol_splat_band *band,
                             const cvol_footprint_table *table, const placed *at)
{
    int px, column = find_column(&px, band, table, at->x);
    if (column + table->width <= band->margin || column >= band->margin + band->width)
        return 0;
    /* From a whole vector on: the weights before are zeros. */
    const int before = column & (PIXELS - 1);
    const int vectors = (before + table->width + PIXELS - 1) / PIXELS, rows = at->end - at->first;
    const float *weights = cvol_footprint_row(table, px, at->py, 0) - before;
    const float *factors = table->columns + at->py * table->height + (at->first - at->row);
    column -= before;
    float *sheet = band->sheet + (size_t)(at->first - band->begin) * band->row_stride +
                   CVOL_SPLAT_CHANNELS * (size_t)column;
    const cvol_vf channels = repeat(at->channels);
#define ADD(count)                                                                     \
    case count:                                                                        \
        add_product(sheet, band->row_stride, weights, factors, rows, count, channels); \
        break
    switch (vectors) {
        ADD(1);
        ADD(2);
        ADD(3);
        ADD(4);
        ADD(5);
        ADD(6);
    default:
        add_wide(sheet, band->row_stride, weights, factors, rows, vectors, channels);
    }
#undef ADD
    *from = column;
    *to = column + before + table->width;
    return 1;
}

/* Any footprint, row by row. */
CVOL_INLINE int add_slanting(int *from, int *to, const cvol_splat_band *band,
                             const cvol_footprint_table *table, const placed *at)
{
    const double slant = table->shape.s / table->shape.uy;
    const cvol_vf channels = repeat(at->channels);
    *from = INT_MAX;
    *to = 0;
    for (int row = at->first; row < at->end; row++) {
        int px, column = find_column(&px, band, table, at->x + slant * (row - at->y));
        if (column + table->width <= band->margin || column >= band->margin + band->width)
            continue;
        const int before = column & (PIXELS - 1);
        const float *weights = cvol_footprint_row(table, px, at->py, row - at->row) - before;
        const float factor = table->columns ? table->columns[at->py * table->height + row - at->row]
                                            : 1;
        column -= before;
        add_wide(band->sheet + (size_t)(row - band->begin) * band->row_stride +
                     CVOL_SPLAT_CHANNELS * (size_t)column,
                 0, weights, &factor, 1, (before + table->width + PIXELS - 1) / PIXELS, channels);
        *from = column < *from ? column : *from;
        *to = column + before + table->width > *to ? column + before + table->width : *to;
    }
    return *from < *to;
}

/* The samples of a line that touch the same rows. */
typedef struct touched {
    int row, from, to;
} touched;

CVOL_INLINE void widen_spans(const cvol_splat_band *band, const touched *run, int height)
{
    int first = run->row > band->begin ? run->row : band->begin;
    int end = run->row + height < band->end ? run->row + height : band->end;
    for (int y = first; y < end; y++) {
        int *span = band->spans[y - band->begin];
        span[0] = span[0] < run->from ? span[0] : run->from;
        span[1] = span[1] > run->to ? span[1] : run->to;
    }
}

CVOL_INLINE void add_list(const cvol_splat_band *band, const cvol_footprint_table *table,
                          const cvol_splat_list *list, const double start[2], const double step[2],
                          int straight)
{
    const int height = table->height;
    touched run = {INT_MIN / 2, INT_MAX, 0};
    for (int n = 0; n < list->count; n++) {
        placed at = {.channels = list->channels + CVOL_SPLAT_CHANNELS * n,
                     .x = start[0] + list->numbers[n] * step[0],
                     .y = start[1] + list->numbers[n] * step[1]};
        const double whole = floor(at.y);
        at.py = cvol_footprint_part(at.y - whole, table->phases_y);
        at.row = (int)whole + table->first_y[at.py];
        at.first = at.row > band->begin ? at.row : band->begin;
        at.end = at.row + height < band->end ? at.row + height : band->end;
        int from, to;
        if (at.first >= at.end || !(straight ? add_straight(&from, &to, band, table, &at)
                                             : add_slanting(&from, &to, band, table, &at)))
            continue;
        if (at.row != run.row) {
            widen_spans(band, &run, height);
            run = (touched){at.row, from, to};
        } else {
            run.from = run.from < from ? run.from : from;
            run.to = run.to > to ? run.to : to;
        }
    }
    widen_spans(band, &run, height);
}

void CVOL_SIMD(cvol_splat_add)(const cvol_splat_band *band, const cvol_footprint_table *table,
                               const cvol_splat_list *list, const double start[2],
                               const double step[2])
{
    if (table->columns && table->shape.s == 0)
        add_list(band, table, list, start, step, 1);
    else
        add_list(band, table, list, start, step, 0);
}

/* ---- sheets onto the picture ------------------------------------------------------------- */

/* Multiplies pixels from .. to - 1 of a row by their gain. */
static void apply_gain(float *sheet, const cvol_splat_gain *gain, int margin, int y, int from,
                       int to)
{
    const int size = gain->gain->size;
    double at[2];
    for (int k = 0; k < 2; k++) {
        at[k] = gain->at[k] + y * gain->step_y[k] + (from - margin) * gain->step_x[k];
        at[k] -= floor(at[k]);
    }
    for (int x = from; x < to; x++) {
        float *pixel = sheet + CVOL_SPLAT_CHANNELS * x;
        double u = at[0] + (x - from) * gain->step_x[0], v = at[1] + (x - from) * gain->step_x[1];
        int cell_u = cvol_footprint_part(u - floor(u), size);
        int cell_v = cvol_footprint_part(v - floor(v), size);
        float factor = gain->gain->gain[cell_v * size + cell_u];
        for (int c = 0; c < CVOL_SPLAT_CHANNELS; c++)
            pixel[c] *= factor;
    }
}

CVOL_INLINE void composite_row(float *image, float *sheet, size_t begin, size_t end, int front)
{
    const float least[4] = {-INFINITY, -INFINITY, -INFINITY, 0};
    const float most[4] = {INFINITY, INFINITY, INFINITY, 1};
    const float signs[4] = {1, 1, 1, -1}, keep[4] = {1, 1, 1, 0};
    const cvol_vf low = repeat(least), high = repeat(most), turn = repeat(signs);
    const cvol_vf colour = repeat(keep);
    for (size_t at = begin; at < end; at += CVOL_LANES) {
        const cvol_vf behind = cvol_load(image + at);
        const cvol_vf added = cvol_max(cvol_min(cvol_load(sheet + at), high), low);
        cvol_store(image + at, front ? behind + spread_fourth(behind) * (added * turn)
                                     : behind - spread_fourth(added) * behind + added * colour);
        cvol_store(sheet + at, cvol_splat(0));
    }
}

void CVOL_SIMD(cvol_splat_composite)(const cvol_splat_band *band, const cvol_splat_gain *gain,
                                     int front)
{
    for (int y = band->begin; y < band->end; y++) {
        int *span = band->spans[y - band->begin];
        if (span[0] >= span[1])
            continue;
        const size_t row = (size_t)(y - band->begin) * band->row_stride;
        if (gain)
            apply_gain(band->sheet + row, gain, band->margin, y, span[0], span[1]);
        const size_t begin = CVOL_SPLAT_CHANNELS * (size_t)span[0] / CVOL_LANES * CVOL_LANES;
        const size_t end = CVOL_SPLAT_CHANNELS * (size_t)span[1];
        if (front)
            composite_row(band->image + row, band->sheet + row, begin, end, 1);
        else
            composite_row(band->image + row, band->sheet + row, begin, end, 0);
        span[0] = INT_MAX;
        span[1] = 0;
    }
}
