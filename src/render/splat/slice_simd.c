/* Sheets: adds the footprints of a slice's samples, then composites the sheet.
 *
 * With C and A the sums of a sheet's samples, colour times opacity and opacity, pixel by pixel:
 *
 *     front to back   I += T C,             T *= 1 - A
 *     back to front   I = (1 - A) I + C,    T *= 1 - A
 *
 * Every pixel is the sum of the same samples in the same order, for any division of the picture. */
#include "base/vector.h"
#include "render/splat/frame.h"

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

/* ---- samples onto a slice ------------------------------------------------------------- */

/* Vectors of weights that stay in registers for all rows. */
#define HELD 6

/* Samples whose columns differ by at most this are added in pairs. */
#define NEAR (CVOL_FOOTPRINT_PAD - PIXELS)
/* Samples whose places are computed together. */
#define RUN 64

/* The places of a list's samples: in x and y the pixel, and the part of it. */
typedef struct places {
    int32_t column[RUN], px[RUN], row[RUN], py[RUN];
    float x[RUN], y[RUN];
} places;

/* A sample's place: its channels, the rows of pixels that it reaches within the band, and its part
 * of the table. */
typedef struct placed {
    const float *channels;
    float x, y;
    int column, px, py, row, first, end;
} placed;

/* Pixel and part of coordinates, of 2^log2 parts. */
CVOL_INLINE void split(int32_t *pixels, int32_t *parts, float *at, cvol_vf place, int log2)
{
    const cvol_vf scaled = place * (float)(1 << log2);
    cvol_vi whole = cvol_to_int(scaled);
    whole += cvol_to_float(whole) > scaled;
    const cvol_vi pixel = whole >> log2, part = whole - (pixel << log2);
    memcpy(pixels, &pixel, sizeof pixel);
    memcpy(parts, &part, sizeof part);
    cvol_store(at, place);
}

/* Computes the places of samples n .. n + RUN - 1 of a list, which has room for them. */
CVOL_INLINE void find_places(places *out, const cvol_footprint_table *table,
                             const cvol_splat_list *list, int n, const double start[2],
                             const double step[2])
{
    for (int i = 0; i < RUN && n + i < list->count; i += CVOL_LANES) {
        cvol_vi number;
        memcpy(&number, list->numbers + n + i, sizeof number);
        const cvol_vf at = cvol_to_float(number);
        split(out->column + i, out->px + i, out->x + i, (float)start[0] + at * (float)step[0],
              table->log2_x);
        split(out->row + i, out->py + i, out->y + i, (float)start[1] + at * (float)step[1],
              table->log2_y);
    }
}

/* A footprint whose rows all have the same weights, up to a factor. */
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

/* The same for footprints wider than HELD vectors. */
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

/* Two footprints with the same rows, together: half the loads and stores. */
CVOL_INLINE void add_pair(float *sheet, size_t stride, const float *const weights[2],
                          const float *const factors[2], int rows, int vectors,
                          const cvol_vf channels[2])
{
    cvol_vf held[2][HELD];
    for (int v = 0; v < vectors; v++)
        for (int k = 0; k < 2; k++)
            held[k][v] = spread(weights[k] + v * PIXELS);
    for (int r = 0; r < rows; r++, sheet += stride) {
        const cvol_vf one = channels[0] * factors[0][r], two = channels[1] * factors[1][r];
        for (int v = 0; v < vectors; v++) {
            float *at = sheet + v * CVOL_LANES;
            cvol_store(at, cvol_load(at) + held[0][v] * one + held[1][v] * two);
        }
    }
}

/* Returns 1 if a footprint reaches into the picture. */
CVOL_INLINE int is_across(const cvol_splat_band *band, const cvol_footprint_table *table,
                          int column)
{
    return column + table->width > band->margin && column < band->margin + band->width;
}

/* One or two product footprints on ellipses without slant; the pixels from *from up to *to are not
 * empty. Two are added in the order of one after the other. */
CVOL_INLINE void add_straight(int *from, int *to, const cvol_splat_band *band,
                              const cvol_footprint_table *table, const placed *at, int count)
{
    const int other = count > 1 ? at[1].column : at[0].column;
    const int left = at[0].column < other ? at[0].column : other;
    const int right = (at[0].column < other ? other : at[0].column) + table->width;
    /* From a whole vector on: the weights before are zeros. */
    const int begin = left & ~(PIXELS - 1), vectors = (right - begin + PIXELS - 1) / PIXELS;
    const int rows = at->end - at->first;
    const float *weights[2], *factors[2];
    cvol_vf channels[2];
    for (int k = 0; k < count; k++) {
        weights[k] = cvol_footprint_row(table, at[k].px, at[k].py, 0) - (at[k].column - begin);
        factors[k] = table->columns + at[k].py * table->height + (at->first - at->row);
        channels[k] = repeat(at[k].channels);
    }
    float *sheet = band->sheet + (size_t)(at->first - band->begin) * band->row_stride +
                   CVOL_SPLAT_CHANNELS * (size_t)begin;
    const size_t stride = band->row_stride;
#define ADD(n)                                                                  \
    case n:                                                                     \
        if (count > 1)                                                          \
            add_pair(sheet, stride, weights, factors, rows, n, channels);       \
        else                                                                    \
            add_product(sheet, stride, *weights, *factors, rows, n, *channels); \
        break
    switch (vectors) {
        ADD(1);
        ADD(2);
        ADD(3);
        ADD(4);
        ADD(5);
        ADD(6);
    default:
        for (int k = 0; k < count; k++)
            add_wide(sheet, stride, weights[k], factors[k], rows, vectors, channels[k]);
    }
#undef ADD
    *from = begin;
    *to = right;
}

/* Any footprint, row by row. */
CVOL_INLINE int add_slanting(int *from, int *to, const cvol_splat_band *band,
                             const cvol_footprint_table *table, const placed *at)
{
    const float slant = (float)(table->shape.s / table->shape.uy);
    const int parts = table->phases_x;
    const cvol_vf channels = repeat(at->channels);
    *from = INT_MAX;
    *to = 0;
    for (int row = at->first; row < at->end; row++) {
        const float scaled = (at->x + slant * ((float)row - at->y)) * (float)parts;
        const int whole = (int)floorf(scaled), px = whole & (parts - 1);
        int column = (whole >> table->log2_x) + table->first_x[px] + band->margin;
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

/* Sample n of a list, for which the places from n - n % RUN on are known; 0 if it reaches no row of
 * the band. */
CVOL_INLINE int place_one(placed *at, const cvol_splat_band *band,
                          const cvol_footprint_table *table, const cvol_splat_list *list,
                          const places *all, int n)
{
    const int k = n % RUN;
    at->channels = list->from + CVOL_SPLAT_CHANNELS * (size_t)list->entries[n];
    at->x = all->x[k];
    at->y = all->y[k];
    at->px = all->px[k];
    at->py = all->py[k];
    at->column = all->column[k] + table->first_x[at->px] + band->margin;
    at->row = all->row[k] + table->first_y[at->py];
    at->first = at->row > band->begin ? at->row : band->begin;
    at->end = at->row + table->height < band->end ? at->row + table->height : band->end;
    return at->first < at->end;
}

CVOL_INLINE uint64_t add_list(const cvol_splat_band *band, const cvol_footprint_table *table,
                              const cvol_splat_list *list, const double start[2],
                              const double step[2], int straight)
{
    uint64_t added = 0;
    touched run = {INT_MIN / 2, INT_MAX, 0};
    places all;
    for (int n = 0; n < list->count; n++) {
        if (n % RUN == 0)
            find_places(&all, table, list, n, start, step);
        placed at[2];
        int from, to;
        if (!place_one(at, band, table, list, &all, n))
            continue;
        if (straight) {
            if (!is_across(band, table, at->column))
                continue;
            int count = 1;
            if (n + 1 < list->count && (n + 1) % RUN != 0 &&
                place_one(at + 1, band, table, list, &all, n + 1) && at[1].row == at->row &&
                is_across(band, table, at[1].column) && at[1].column - at->column <= NEAR &&
                at->column - at[1].column <= NEAR) {
                count = 2;
                n++;
            }
            add_straight(&from, &to, band, table, at, count);
            added += (uint64_t)(count * (at->end - at->first));
        } else if (!add_slanting(&from, &to, band, table, at)) {
            continue;
        } else {
            added += (uint64_t)(at->end - at->first);
        }
        if (at->row != run.row) {
            widen_spans(band, &run, table->height);
            run = (touched){at->row, from, to};
        } else {
            run.from = run.from < from ? run.from : from;
            run.to = run.to > to ? run.to : to;
        }
    }
    widen_spans(band, &run, table->height);
    return added;
}

uint64_t CVOL_SIMD(cvol_splat_add)(const cvol_splat_band *band, const cvol_footprint_table *table,
                                   const cvol_splat_list *list, const double start[2],
                                   const double step[2])
{
    return table->columns && table->shape.s == 0 ? add_list(band, table, list, start, step, 1)
                                                 : add_list(band, table, list, start, step, 0);
}

/* ---- slices onto the picture ------------------------------------------------------------- */

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
