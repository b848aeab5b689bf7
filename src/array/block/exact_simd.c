/* Exact evaluation on vectors of doubles: one block of 16^3, and the filter across faces.
 *
 * For multiples a of 2^-20, round(a) = floor(a + 1/2) is the nearest integer to a + 2^-21, which is
 * never halfway between two integers. Adding and subtracting 1.5 * 2^52 rounds a number below 2^51
 * to the nearest integer. */
#include "array/block/exact_kernel.h"
#include "base/cpu.h"
#include "base/vector_double.h"
#include "transform/cell.h"
#include "transform/cell_bases.h"

enum { LANES = CVOL_VD_LANES, CELL = CVOL_CELL };

typedef cvol_vd vd;

#define BIAS 0x1p-21
#define MAGIC 0x1.8p52

void CVOL_SIMD(cvol_exact_cell)(double *out, const cvol_block *block, double unit,
                                const size_t first[3], const size_t last[3],
                                const cvol_exact_bases *bases);
void CVOL_SIMD(cvol_exact_lap)(double *samples, const cvol_exact_faces *faces, const double h[4]);
void CVOL_SIMD(cvol_exact_finish)(double *out, const double *in, size_t count, double offset,
                                  double step, double lo, double hi, int is_integer);

/* sum + a b: exact, so that fusing changes nothing. */
CVOL_INLINE vd add_product(vd sum, vd a, vd b)
{
#if defined(__AVX512F__)
    return (vd)_mm512_fmadd_pd((__m512d)a, (__m512d)b, (__m512d)sum);
#elif defined(__FMA__)
    return (vd)_mm256_fmadd_pd((__m256d)a, (__m256d)b, (__m256d)sum);
#else
    return sum + a * b;
#endif
}

/* For a sum to which BIAS has been added. */
CVOL_INLINE vd rounded(vd sum)
{
    return (sum + MAGIC) - MAGIC;
}

/* ---- along x: term by term ------------------------------------------------------------------- */

enum { SUMS = 16 / LANES };

CVOL_INLINE void finish_line(double *line, vd sums[SUMS], int is_split)
{
    double two[16] __attribute__((aligned(64)));
    for (int i = 0; i < SUMS; i++)
        cvol_vd_store(two + i * LANES, sums[i]);
    if (is_split) {
        for (int x = 0; x < 16; x++)
            line[x] = (two[x] + BIAS + MAGIC) - MAGIC;
        return;
    }
    for (int x = 0; x < 8; x++) {
        line[x] = (two[x] + two[8 + x] + BIAS + MAGIC) - MAGIC;
        line[15 - x] = (two[x] - two[8 + x] + BIAS + MAGIC) - MAGIC;
    }
}

/* Lines (v, w) of the low box, at 16 (v + 16 w). */
static void along_x(double *lines, const cvol_block *block, double unit,
                    const cvol_exact_bases *bases)
{
    const uint32_t *words = block->terms, *end = cvol_block_end(block);
    for (int w = 0; w < block->low[2]; w++)
        memset(lines + 256 * w, 0, sizeof *lines * 16 * block->low[1]);
    uint32_t place = 0;
    int32_t value = words < end ? cvol_term_unpack(&words, &place, 12) : 0;
    int more = block->words > 0;
    while (more) {
        const uint32_t line = place >> 4;
        const int cy = (int)line & 1, cz = (int)(line >> 4) & 1;
        const double(*rows[2])[16] = {
            bases->rows[cvol_cell_octant_transform(block->split, 0, cy, cz)],
            bases->rows[cvol_cell_octant_transform(block->split, 1, cy, cz)]};
        vd sums[SUMS] = {{0}};
        do {
            const double *row = rows[place & 1][place & 15];
            const vd q = cvol_vd_splat(unit * (double)value);
            for (int i = 0; i < SUMS; i++)
                sums[i] = add_product(sums[i], q, cvol_vd_load(row + i * LANES));
            more = words < end;
            if (!more)
                break;
            value = cvol_term_unpack(&words, &place, 12);
        } while (place >> 4 == line);
        finish_line(lines + 16 * line, sums, block->split & 1);
    }
}

/* ---- along y and z: vectors of lines ---------------------------------------------------------
 *
 * In place: at[i stride], of which the first `count` are not zero, become M samples; from and to:
 * strides in and out. The symmetry of the matrices, D[f][M - 1 - x] = (-1)^f D[f][x], halves the
 * sums, and again the sums of even frequencies, which have half the points. */

CVOL_INLINE void column_of_4(double *to, int64_t to_stride, const double *at, int64_t stride,
                             int count, const double (*D)[2])
{
    vd even[2], odd[2];
    for (int x = 0; x < 2; x++) {
        even[x] = cvol_vd_splat(BIAS);
        odd[x] = cvol_vd_splat(0);
    }
    for (int f = 0; f < 4; f++) {
        if (f >= count)
            break;
        const vd v = cvol_vd_load(at + f * stride);
        for (int x = 0; x < 2; x++)
            if (f & 1)
                odd[x] = add_product(odd[x], v, cvol_vd_splat(D[f][x]));
            else
                even[x] = add_product(even[x], v, cvol_vd_splat(D[f][x]));
    }
    for (int x = 0; x < 2; x++) {
        cvol_vd_store(to + x * to_stride, rounded(even[x] + odd[x]));
        cvol_vd_store(to + (3 - x) * to_stride, rounded(even[x] - odd[x]));
    }
}

CVOL_INLINE void column_of_8(double *to, int64_t to_stride, const double *at, int64_t stride,
                             int count, const double (*D)[4])
{
    vd even[4], odd[4];
    for (int x = 0; x < 4; x++) {
        even[x] = cvol_vd_splat(BIAS);
        odd[x] = cvol_vd_splat(0);
    }
    for (int f = 0; f < 8; f++) {
        if (f >= count)
            break;
        const vd v = cvol_vd_load(at + f * stride);
        for (int x = 0; x < 4; x++)
            if (f & 1)
                odd[x] = add_product(odd[x], v, cvol_vd_splat(D[f][x]));
            else
                even[x] = add_product(even[x], v, cvol_vd_splat(D[f][x]));
    }
    for (int x = 0; x < 4; x++) {
        cvol_vd_store(to + x * to_stride, rounded(even[x] + odd[x]));
        cvol_vd_store(to + (7 - x) * to_stride, rounded(even[x] - odd[x]));
    }
}

CVOL_INLINE void column_of_16(double *at, int64_t stride, int count, const double (*D)[8])
{
    vd odd[8], fours[4], twos[4];
    for (int x = 0; x < 8; x++)
        odd[x] = cvol_vd_splat(0);
    for (int f = 1; f < count; f += 2) {
        const vd v = cvol_vd_load(at + f * stride);
        for (int x = 0; x < 8; x++)
            odd[x] = add_product(odd[x], v, cvol_vd_splat(D[f][x]));
    }
    for (int x = 0; x < 4; x++) {
        fours[x] = cvol_vd_splat(BIAS);
        twos[x] = cvol_vd_splat(0);
    }
    for (int f = 0; f < count; f += 4) {
        const vd v = cvol_vd_load(at + f * stride);
        for (int x = 0; x < 4; x++)
            fours[x] = add_product(fours[x], v, cvol_vd_splat(D[f][x]));
    }
    for (int f = 2; f < count; f += 4) {
        const vd v = cvol_vd_load(at + f * stride);
        for (int x = 0; x < 4; x++)
            twos[x] = add_product(twos[x], v, cvol_vd_splat(D[f][x]));
    }
    for (int x = 0; x < 4; x++) {
        const vd outer = fours[x] + twos[x], inner = fours[x] - twos[x];
        cvol_vd_store(at + x * stride, rounded(outer + odd[x]));
        cvol_vd_store(at + (15 - x) * stride, rounded(outer - odd[x]));
        cvol_vd_store(at + (7 - x) * stride, rounded(inner + odd[7 - x]));
        cvol_vd_store(at + (8 + x) * stride, rounded(inner - odd[7 - x]));
    }
}

/* One half, of parity c and frequencies at 2 g + c; frequencies from `count` on are zero. */
CVOL_INLINE void column_of_half(double *to, const double *at, int64_t stride, int c, int count,
                                int way, const cvol_exact_bases *bases)
{
    const int left = (count - c + 1) / 2; /* places of this parity */
    if (way == CVOL_CELL_BY_8) {
        column_of_8(to + 8 * c * LANES, LANES, at + c * stride, 2 * stride, left, bases->of_8);
        return;
    }
    for (int quarter = 0; quarter < 2; quarter++)
        column_of_4(to + (8 * c + 4 * quarter) * LANES, LANES, at + (c + 2 * quarter) * stride,
                    4 * stride, (left - quarter + 1) / 2, bases->of_4);
}

/* A vector of lines whose octants are transformed by way[c]. */
CVOL_INLINE void column(double *at, int64_t stride, int count, const int way[2],
                        const cvol_exact_bases *bases)
{
    if (way[0] == CVOL_CELL_BY_16) {
        column_of_16(at, stride, count, bases->of_16);
        return;
    }
    double both[16 * LANES] __attribute__((aligned(64)));
    for (int c = 0; c < 2; c++)
        column_of_half(both, at, stride, c, count, way[c], bases);
    for (int x = 0; x < 16; x++)
        cvol_vd_store(at + x * stride, cvol_vd_load(both + x * LANES));
}

void CVOL_SIMD(cvol_exact_cell)(double *out, const cvol_block *block, double unit,
                                const size_t first[3], const size_t last[3],
                                const cvol_exact_bases *bases)
{
    const uint16_t split = block->split;
    const int from = (int)first[0] / LANES * LANES;
    along_x(out, block, unit, bases);
    for (int w = 0; w < block->low[2]; w++)
        for (int x = from; x < (int)last[0]; x += LANES) {
            const int way[2] = {cvol_cell_octant_transform(split, x / 8, 0, w & 1),
                                cvol_cell_octant_transform(split, x / 8, 1, w & 1)};
            column(out + 256 * w + x, CELL, block->low[1], way, bases);
        }
    for (int y = (int)first[1]; y < (int)last[1]; y++)
        for (int x = from; x < (int)last[0]; x += LANES) {
            const int way[2] = {cvol_cell_octant_transform(split, x / 8, y / 8, 0),
                                cvol_cell_octant_transform(split, x / 8, y / 8, 1)};
            column(out + CELL * y + x, 256, block->low[2], way, bases);
        }
}

/* ---- the filter ------------------------------------------------------------------------------ */

CVOL_INLINE double round_one(double sum)
{
    return (sum + BIAS + MAGIC) - MAGIC;
}

CVOL_INLINE void lap_one(double *a, int64_t stride, const double h[4])
{
    const double w0 = a[stride] - a[2 * stride], w1 = a[0] - a[3 * stride];
    const double d0 = round_one(h[0] * w0 + h[1] * w1), d1 = round_one(h[2] * w0 + h[3] * w1);
    a[0] += d1;
    a[stride] += d0;
    a[2 * stride] -= d0;
    a[3 * stride] -= d1;
}

CVOL_INLINE void lap_lanes(double *at, int64_t stride, const double h[4])
{
    const vd a0 = cvol_vd_load(at), a1 = cvol_vd_load(at + stride),
             a2 = cvol_vd_load(at + 2 * stride), a3 = cvol_vd_load(at + 3 * stride);
    const vd w0 = a1 - a2, w1 = a0 - a3;
    const vd d0 = rounded(h[0] * w0 + h[1] * w1 + BIAS), d1 = rounded(h[2] * w0 + h[3] * w1 + BIAS);
    cvol_vd_store(at, a0 + d1);
    cvol_vd_store(at + stride, a1 + d0);
    cvol_vd_store(at + 2 * stride, a2 - d0);
    cvol_vd_store(at + 3 * stride, a3 - d1);
}

void CVOL_SIMD(cvol_exact_lap)(double *samples, const cvol_exact_faces *faces, const double h[4])
{
    for (int64_t j = 0; j < faces->lines[1]; j++)
        for (int64_t f = 0; f < faces->count; f++) {
            double *face = samples + j * faces->line_stride[1] + f * faces->face_stride;
            int64_t i = 0;
            if (faces->line_stride[0] == 1)
                for (; i + LANES <= faces->lines[0]; i += LANES)
                    lap_lanes(face + i, faces->stride, h);
            for (; i < faces->lines[0]; i++)
                lap_one(face + i * faces->line_stride[0], faces->stride, h);
        }
}

/* ---- from integers to samples ---------------------------------------------------------------- */

void CVOL_SIMD(cvol_exact_finish)(double *out, const double *in, size_t count, double offset,
                                  double step, double lo, double hi, int is_integer)
{
    for (size_t i = 0; i < count; i++) {
        const double value = offset + step * in[i];
        const double inside = value < lo ? lo : value > hi ? hi : value;
        out[i] = inside;
    }
    if (is_integer)
        for (size_t i = 0; i < count; i++) {
            const double above = out[i] + 0.5, near = (above + MAGIC) - MAGIC;
            out[i] = near > above ? near - 1 : near;
        }
}
