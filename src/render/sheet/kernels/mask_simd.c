/* Writes a background to its samples (mask.h). */
#include "render/sheet/frame/mask.h"

#include "base/vector_int16.h"

/* 1 << lane, for the lanes from `first` on. */
CVOL_INLINE cvol_vi lane_bits(int first)
{
    cvol_vi bits;
    for (int i = 0; i < CVOL_LANES; i++)
        bits[i] = 1 << (first + i);
    return bits;
}

void CVOL_SIMD(cvol_sheet_fill_masked)(float *samples, ptrdiff_t row_stride, ptrdiff_t sheet_stride,
                                       int rows, int sheets, int lanes, const uint16_t *bits,
                                       int row_step, int sheet_step, float background)
{
    for (int z = 0; z < sheets; z++)
        for (int y = 0; y < rows; y++)
            for (int x = 0; x < lanes; x += 16) {
                const int row = bits[z * sheet_step + y * row_step + x / 16];
                float *at = samples + z * sheet_stride + y * row_stride + x;
                if (!row)
                    continue;
                /* Blocks of 8: the bits of the other eight are 0, and nothing is stored there. */
                for (int i = 0; i < 16 && x + i < lanes; i += CVOL_LANES) {
                    const cvol_vi here = lane_bits(i), masked = (row & here) == here;
                    const cvol_vf v = cvol_select(masked, cvol_splat(background),
                                                  cvol_load(at + i));
                    if (lanes - x - i >= CVOL_LANES)
                        cvol_store(at + i, v);
                    else
                        cvol_store_first(at + i, v, lanes - x - i);
                }
            }
}

void CVOL_SIMD(cvol_sheet_fill_masked_int16)(int16_t *samples, ptrdiff_t row_stride,
                                             ptrdiff_t sheet_stride, int rows, int sheets,
                                             int lanes, const uint16_t *bits, int row_step,
                                             int sheet_step, int16_t background)
{
    for (int z = 0; z < sheets; z++)
        for (int y = 0; y < rows; y++)
            for (int x = 0; x < lanes; x += 16) {
                const int row = bits[z * sheet_step + y * row_step + x / 16];
                int16_t *at = samples + z * sheet_stride + y * row_stride + x;
#if CVOL_LANES == 16
                /* Blended and stored whole: masked stores of int16 take twice the time. */
                const __m256i before = _mm256_loadu_si256((const __m256i *)at);
                if (row)
                    _mm256_storeu_si256((__m256i *)at,
                                        _mm256_mask_mov_epi16(before, (__mmask16)row,
                                                              _mm256_set1_epi16(background)));
#else
                for (int i = 0; i < 16 && row; i++)
                    if (row >> i & 1)
                        at[i] = background;
#endif
            }
}

/* ---- points that are not samples ------------------------------------------------------------- */

/* The rows of bits around a row of points: of the near slice the near row and the far one, then of
 * the far slice; and their weights. */
typedef struct rows_around {
    const uint16_t *bits[4];
    float weight[4];
} rows_around;

CVOL_INLINE void find_rows(rows_around *out, const cvol_mask_grid *g, int z, int y)
{
    const cvol_mask_points *sheet = g->sheet, *row = g->row;
    const uint16_t *near = g->bits + sheet->near[z] * g->sheet_step,
                   *far = g->bits + sheet->far[z] * g->sheet_step;
    const float of_sheet = sheet->weight[z], of_row = row->weight[y];
    out->bits[0] = near + row->near[y] * g->row_step;
    out->bits[1] = near + row->far[y] * g->row_step;
    out->bits[2] = far + row->near[y] * g->row_step;
    out->bits[3] = far + row->far[y] * g->row_step;
    out->weight[0] = (1 - of_sheet) * (1 - of_row);
    out->weight[1] = (1 - of_sheet) * of_row;
    out->weight[2] = of_sheet * (1 - of_row);
    out->weight[3] = of_sheet * of_row;
}

/* Returns 1 if no sample around the row is masked. */
CVOL_INLINE int is_covered(const rows_around *around, int words)
{
    int any = 0;
    for (int w = 0; w < words; w++)
        any |= around->bits[0][w] | around->bits[1][w] | around->bits[2][w] | around->bits[3][w];
    return !any;
}

/* The cover of samples x .. x + CVOL_LANES - 1. */
CVOL_INLINE cvol_vf cover_samples(const rows_around *around, int x)
{
    const cvol_vi here = lane_bits(x % 16);
    cvol_vf cover = cvol_splat(1);
    for (int k = 0; k < 4; k++) {
        const cvol_vi masked = (around->bits[k][x / 16] & here) == here;
        cover -= cvol_select(masked, cvol_splat(around->weight[k]), cvol_splat(0));
    }
    return cover;
}

CVOL_INLINE void cover_row(float cover[CVOL_BLOCK_MAX], const rows_around *around,
                           const cvol_mask_grid *g)
{
    const cvol_mask_points *lane = g->lane;
#if CVOL_LANES == 16
    if (g->block <= 16 && !lane->are_samples) {
        const __m512 samples = (__m512)cover_samples(around, 0);
        const cvol_vf near = (cvol_vf)_mm512_permutexvar_ps(_mm512_loadu_si512(lane->near),
                                                            samples),
                      far = (cvol_vf)_mm512_permutexvar_ps(_mm512_loadu_si512(lane->far), samples);
        cvol_store(cover, near + cvol_load(lane->weight) * (far - near));
        return;
    }
#endif
    float samples[CVOL_BLOCK_MAX];
    float *to = lane->are_samples ? cover : samples;
    for (int x = 0; x < g->block; x += CVOL_LANES)
        cvol_store(to + x, cover_samples(around, x));
    for (int x = 0; x < lane->count && !lane->are_samples; x++)
        cover[x] = samples[lane->near[x]] +
                   lane->weight[x] * (samples[lane->far[x]] - samples[lane->near[x]]);
}

void CVOL_SIMD(cvol_sheet_cover)(const cvol_sheet_piece *p, const cvol_mask_grid *g)
{
    float cover[CVOL_BLOCK_MAX];
    rows_around around;
    for (int z = 0; z < p->sheets; z++)
        for (int y = 0; y < p->rows; y++) {
            find_rows(&around, g, p->sheet + z, p->row + y);
            cover_row(cover, &around, g);
            memcpy((float *)p->at + z * p->sheet_stride + y * p->row_stride, cover,
                   sizeof *cover * (size_t)g->lane->count);
        }
}

void CVOL_SIMD(cvol_sheet_fill_masked_points)(const cvol_sheet_piece *p, const cvol_mask_grid *g,
                                              float background)
{
    const int words = (g->block + 15) / 16, count = g->lane->count;
    float cover[CVOL_BLOCK_MAX];
    rows_around around;
    for (int z = 0; z < p->sheets; z++)
        for (int y = 0; y < p->rows; y++) {
            find_rows(&around, g, p->sheet + z, p->row + y);
            if (is_covered(&around, words))
                continue;
            cover_row(cover, &around, g);
            float *at = (float *)p->at + z * p->sheet_stride + y * p->row_stride;
            for (int x = 0; x < count; x += CVOL_LANES) {
                const cvol_vf v = background +
                                  cvol_load(cover + x) * (cvol_load(at + x) - background);
                if (count - x >= CVOL_LANES)
                    cvol_store(at + x, v);
                else
                    cvol_store_first(at + x, v, count - x);
            }
        }
}

void CVOL_SIMD(cvol_sheet_fill_masked_points_int16)(const cvol_sheet_piece *p,
                                                    const cvol_mask_grid *g, int16_t background)
{
    const int words = (g->block + 15) / 16, count = g->lane->count;
    float cover[CVOL_BLOCK_MAX];
    rows_around around;
    for (int z = 0; z < p->sheets; z++)
        for (int y = 0; y < p->rows; y++) {
            find_rows(&around, g, p->sheet + z, p->row + y);
            if (is_covered(&around, words))
                continue;
            cover_row(cover, &around, g);
            int16_t *at = (int16_t *)p->at + z * p->sheet_stride + y * p->row_stride;
            for (int x = 0; x < count; x += CVOL_LANES) {
                const cvol_vf v = background +
                                  cvol_load(cover + x) * (cvol_load_int16(at + x) - background);
                cvol_store_int16(at + x, v, count - x);
            }
        }
}
