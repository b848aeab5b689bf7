/* Cells that cross the volume's end: the two bases, and conversion between them. */
#include "codec/quantize/true_length.h"

#include <math.h>
#include <pthread.h>
#include <stdlib.h>
#include <string.h>

#include "base/cpu.h"
#include "base/elementary.h"
#include "codec/quantize/quantize.h"
#include "codec/quantize/true_length_kernel.h"

#define PI 3.14159265358979323846

/* By number of samples inside; filled once, then read-only. */
static cvol_true_length_matrix to_terms[CVOL_CELL][CVOL_TRUE_LENGTH_WAYS],
    from_terms[CVOL_CELL][CVOL_TRUE_LENGTH_WAYS];
static pthread_once_t filled = PTHREAD_ONCE_INIT;

/* The DCT-II of a length, continued beyond it. */
static double basis[CVOL_CELL + 1][CVOL_CELL][CVOL_CELL]; /* [length][k][x] */

static void fill_basis(void)
{
    for (int length = 1; length <= CVOL_CELL; length++)
        for (int k = 0; k < length; k++)
            for (int x = 0; x < CVOL_CELL; x++)
                basis[length][k][x] = sqrt((k ? 2.0 : 1.0) / length) *
                                      cvol_cos(PI * k * (x + 0.5) / length);
}

/* Fills in a sub-block of side M with n samples inside, at places first, first + apart, ... */
static void fill_part(cvol_true_length_matrix *to, cvol_true_length_matrix *from, int M, int n,
                      int first)
{
    const int apart = CVOL_CELL / M;
    for (int k = 0; k < M; k++)
        for (int u = 0; u < M; u++) {
            double all = k == u, seen = k == u;
            if (n > 0 && n < M) {
                all = seen = 0;
                for (int x = 0; x < M && k < n; x++) {
                    const double one = basis[M][u][x] * basis[n][k][x];
                    all += one;
                    seen += x < n ? one : 0;
                }
            }
            to->of[first + apart * k][first + apart * u] = all;
            from->of[first + apart * u][first + apart * k] = seen;
        }
}

static void mark_reached(cvol_true_length_matrix *matrix)
{
    for (int k = 0; k < CVOL_CELL; k++)
        for (int u = 0; u < CVOL_CELL; u++)
            if (matrix->of[k][u] != 0)
                matrix->reached |= (uint16_t)(1 << u);
}

static void fill(void)
{
    fill_basis();
    for (int n = 1; n < CVOL_CELL; n++) {
        fill_part(&to_terms[n][CVOL_TRUE_LENGTH_WHOLE], &from_terms[n][CVOL_TRUE_LENGTH_WHOLE],
                  CVOL_CELL, n, 0);
        for (int fours = 0; fours < 4; fours++) {
            cvol_true_length_matrix *to = &to_terms[n][CVOL_TRUE_LENGTH_HALVES + fours],
                                    *from = &from_terms[n][CVOL_TRUE_LENGTH_HALVES + fours];
            for (int half = 0; half < 2; half++)
                if (fours >> half & 1) {
                    fill_part(to, from, 4, n - 8 * half, half);
                    fill_part(to, from, 4, n - 8 * half - 4, half + 2);
                } else {
                    fill_part(to, from, 8, n - 8 * half, half);
                }
        }
        for (int way = 0; way < CVOL_TRUE_LENGTH_WAYS; way++) {
            mark_reached(&to_terms[n][way]);
            mark_reached(&from_terms[n][way]);
        }
    }
}

CVOL_SIMD_DECLARE(void, cvol_true_length_axes,
                  (double *, uint16_t *, const int *, uint16_t, const cvol_true_length_matrix *));
CVOL_SIMD_DECLARE(int, cvol_true_length_round,
                  (int32_t *, uint64_t *, const double *, const uint16_t *));

static void transform(double *cell, uint16_t rows[CVOL_CELL], const int inside[3], uint16_t split,
                      const cvol_true_length_matrix *matrices)
{
    pthread_once(&filled, fill);
    CVOL_SIMD_CHOOSE(cvol_true_length_axes)(cell, rows, inside, split, matrices);
}

static void transform_all(double *cell, const int inside[3], uint16_t split,
                          const cvol_true_length_matrix *matrices)
{
    uint16_t rows[CVOL_CELL];
    memset(rows, 0xff, sizeof rows);
    transform(cell, rows, inside, split, matrices);
}

void cvol_true_length_to_terms(double cell[CVOL_CELL_SAMPLES], const int inside[3], uint16_t split)
{
    transform_all(cell, inside, split, to_terms[0]);
}

void cvol_true_length_from_terms(double cell[CVOL_CELL_SAMPLES], const int inside[3],
                                 uint16_t split)
{
    transform_all(cell, inside, split, from_terms[0]);
}

void cvol_true_length_forward(float *coefficients, const float *samples, const int inside[3],
                              uint16_t split)
{
    double cell[CVOL_CELL_SAMPLES];
    cvol_cell_forward(coefficients, samples, split);
    for (int i = 0; i < CVOL_CELL_SAMPLES; i++)
        cell[i] = (double)coefficients[i];
    cvol_true_length_from_terms(cell, inside, split);
    for (int i = 0; i < CVOL_CELL_SAMPLES; i++)
        coefficients[i] = (float)cell[i];
}

/* Multiplies by 2^bits; returns 0 if a value would exceed the limit. */
static int shift_up(int32_t *values, const uint64_t *found, int bits)
{
    const int32_t most = CVOL_VALUE_LIMIT >> bits;
    for (int i = 0; i < CVOL_CELL_SAMPLES / 64; i++)
        for (uint64_t left = found[i]; left; left &= left - 1) {
            int32_t *value = &values[64 * i + __builtin_ctzll(left)];
            if (*value > most || *value < -most)
                return 0;
            *value *= 1 << bits;
        }
    return 1;
}

int cvol_true_length_take(int32_t values[CVOL_CELL_SAMPLES], uint64_t found[CVOL_CELL_SAMPLES / 64],
                          const int *inside, uint16_t split, int bits)
{
    double cell[CVOL_CELL_SAMPLES];
    uint16_t rows[CVOL_CELL] = {0};
    const double scale = 1 << bits;
    if (!inside)
        return shift_up(values, found, bits);
    for (int row = 0; row < CVOL_CELL * CVOL_CELL; row++) {
        const int first = CVOL_CELL * row;
        if (!(found[row / 4] >> 16 * (row % 4) & 0xffff))
            continue;
        rows[row >> 4] |= (uint16_t)(1u << (row & 15));
        for (int k = first; k < first + CVOL_CELL; k++)
            cell[k] = values[k] * scale;
    }
    transform(cell, rows, inside, split, to_terms[0]);
    return CVOL_SIMD_CHOOSE(cvol_true_length_round)(values, found, cell, rows);
}

static int round_all(int32_t *values, const double *cell)
{
    uint64_t found[CVOL_CELL_SAMPLES / 64] = {0};
    uint16_t rows[CVOL_CELL];
    memset(rows, 0xff, sizeof rows);
    return CVOL_SIMD_CHOOSE(cvol_true_length_round)(values, found, cell, rows);
}

static int shift_down(int32_t *values, int bits)
{
    const int32_t rest = (1 << bits) - 1;
    for (int i = 0; i < CVOL_CELL_SAMPLES; i++) {
        if (values[i] & rest)
            return 0;
        values[i] /= 1 << bits;
    }
    return 1;
}

/* True if a place belongs to a sub-block in padding. */
static int is_unseen(int place, const int inside[3], uint16_t split)
{
    const int x[3] = {place & 15, place >> 4 & 15, place >> 8};
    const int octant = (x[0] & 1) | (x[1] & 1) << 1 | (x[2] & 1) << 2;
    if (!(split & 1))
        return 0;
    for (int a = 0; a < 3; a++) {
        const int quarter = split >> (1 + octant) & 1 ? x[a] >> 1 & 1 : 0;
        if (8 * (x[a] & 1) + 4 * quarter >= inside[a])
            return 1;
    }
    return 0;
}

int cvol_true_length_put(int32_t values[CVOL_CELL_SAMPLES], const int *inside, uint16_t split,
                         int bits)
{
    double cell[CVOL_CELL_SAMPLES];
    int32_t coded[CVOL_CELL_SAMPLES], terms[CVOL_CELL_SAMPLES];
    if (!inside)
        return shift_down(values, bits);
    for (int i = 0; i < CVOL_CELL_SAMPLES; i++)
        cell[i] = (double)values[i] / (1 << bits);
    cvol_true_length_from_terms(cell, inside, split);
    if (!round_all(coded, cell))
        return 0;
    for (int i = 0; i < CVOL_CELL_SAMPLES; i++)
        cell[i] = (double)coded[i] * (1 << bits);
    cvol_true_length_to_terms(cell, inside, split);
    if (!round_all(terms, cell))
        return 0;
    for (int i = 0; i < CVOL_CELL_SAMPLES; i++)
        if (terms[i] != values[i] && !is_unseen(i, inside, split))
            return 0;
    memcpy(values, coded, sizeof coded);
    return 1;
}

/* ---- scans ------------------------------------------------------------------------------ */

void cvol_true_length_scans_clear(cvol_true_length_scans *ends)
{
    for (int c = 0; c < 3; c++)
        for (int axes = 0; axes < 8; axes++)
            free(ends->scans[c][axes]);
    memset(ends, 0, sizeof *ends);
}

/* Makes the scans of a size class; returns 0 when memory is short. */
static int make_class(cvol_scan *scans[8], int size_class, const int left[3])
{
    const int side = 4 << size_class;
    for (int axes = 1; axes < 8; axes++) {
        int n[3], exists = 1;
        for (int a = 0; a < 3; a++) {
            n[a] = axes >> a & 1 ? left[a] % side : side;
            exists = exists && n[a] > 0;
        }
        if (exists && !(scans[axes] = cvol_sub_block_scan_ended(size_class, n)))
            return 0;
    }
    return 1;
}

int cvol_true_length_scans_make(cvol_true_length_scans *ends, const size_t dims[3])
{
    int left[3];
    for (int a = 0; a < 3; a++)
        left[a] = (int)((dims[a] - 1) % CVOL_CELL) + 1;
    if (!memcmp(left, ends->left, sizeof left))
        return 1;
    cvol_true_length_scans_clear(ends);
    for (int c = 0; c < 3; c++)
        if (!make_class(ends->scans[c], c, left)) {
            cvol_true_length_scans_clear(ends);
            return 0;
        }
    memcpy(ends->left, left, sizeof left);
    return 1;
}
