/* Multiplies matrices along the axes of a cell, from rows that are not zero. */
#include <string.h>

#include "base/cpu.h"
#include "base/vector.h"
#include "codec/quantize/quantize.h"
#include "codec/quantize/true_length_kernel.h"

enum { N = CVOL_CELL };

void CVOL_SIMD(cvol_true_length_axes)(double *cell, uint16_t rows[N], const int inside[3],
                                      uint16_t split, const cvol_true_length_matrix *matrices);
int CVOL_SIMD(cvol_true_length_round)(int32_t *values, uint64_t *found, const double *cell,
                                      const uint16_t rows[N]);

/* Half a row. */
typedef double eight __attribute__((vector_size(64)));

CVOL_INLINE eight load(const double *from)
{
    eight v;
    memcpy(&v, from, sizeof v);
    return v;
}

CVOL_INLINE void store(double *to, eight v)
{
    memcpy(to, &v, sizeof v);
}

/* The index of the matrix for lines along `axis` at places v, w of the other two. */
CVOL_INLINE int place_of(const int inside[3], uint16_t split, int axis, int v, int w)
{
    const int of = inside[axis] * CVOL_TRUE_LENGTH_WAYS;
    if (!(split & 1))
        return of + CVOL_TRUE_LENGTH_WHOLE;
    const int first = axis == 0 ? 1 : 0, second = axis == 2 ? 1 : 2;
    const int octant = (v & 1) << first | (w & 1) << second;
    return of + CVOL_TRUE_LENGTH_HALVES + (split >> (1 + octant) & 1) +
           2 * (split >> (1 + (octant | 1 << axis)) & 1);
}

/* Transforms a row along x. */
CVOL_INLINE void transform_row(double *row, const cvol_true_length_matrix *by)
{
    eight low = {0}, high = {0};
    for (int k = 0; k < N; k++) {
        if (row[k] == 0)
            continue;
        low += row[k] * load(by->of[k]);
        high += row[k] * load(by->of[k] + 8);
    }
    store(row, low);
    store(row + 8, high);
}

/* Transforms the rows first + k stride across another axis, for the bits k of `which`; even and odd
 * places have separate matrices. */
CVOL_INLINE void transform_rows(double *first, long stride, unsigned which,
                                const cvol_true_length_matrix *even,
                                const cvol_true_length_matrix *odd)
{
    eight sums[N][2];
    memset(sums, 0, sizeof sums);
    for (; which; which &= which - 1) {
        const int k = __builtin_ctz(which);
        const eight low = load(first + k * stride), high = load(first + k * stride + 8);
        for (int u = 0; u < N; u++) {
            const double a = even->of[k][u], b = odd->of[k][u];
            const eight by = {a, b, a, b, a, b, a, b};
            sums[u][0] += by * low;
            sums[u][1] += by * high;
        }
    }
    for (int u = 0; u < N; u++) {
        store(first + u * stride, sums[u][0]);
        store(first + u * stride + 8, sums[u][1]);
    }
}

void CVOL_SIMD(cvol_true_length_axes)(double *cell, uint16_t rows[N], const int inside[3],
                                      uint16_t split, const cvol_true_length_matrix *matrices)
{
    for (int w = 0; w < N && inside[0] < N; w++)
        for (unsigned left = rows[w]; left; left &= left - 1) {
            const int v = __builtin_ctz(left);
            transform_row(cell + N * (v + N * w), &matrices[place_of(inside, split, 0, v, w)]);
        }
    for (int w = 0; w < N && inside[1] < N; w++) {
        if (!rows[w])
            continue;
        transform_rows(cell + N * N * w, N, rows[w], &matrices[place_of(inside, split, 1, 0, w)],
                       &matrices[place_of(inside, split, 1, 1, w)]);
        rows[w] = UINT16_MAX;
    }
    unsigned any = 0;
    for (int v = 0; v < N && inside[2] < N; v++) {
        unsigned which = 0;
        for (int w = 0; w < N; w++)
            which |= (unsigned)(rows[w] >> v & 1) << w;
        if (!which)
            continue;
        transform_rows(cell + N * v, N * N, which, &matrices[place_of(inside, split, 2, 0, v)],
                       &matrices[place_of(inside, split, 2, 1, v)]);
        any |= 1u << v;
    }
    for (int w = 0; w < N && inside[2] < N; w++)
        rows[w] = (uint16_t)any;
}

typedef int64_t eight_long __attribute__((vector_size(64)));
typedef int32_t eight_int __attribute__((vector_size(32)));

/* Returns a bit for each nonzero number. */
CVOL_INLINE unsigned bits_of(eight v)
{
#if defined(__AVX512F__)
    return _mm512_cmp_pd_mask((__m512d)v, _mm512_setzero_pd(), _CMP_NEQ_UQ);
#else
    unsigned bits = 0;
    for (int k = 0; k < 8; k++)
        bits |= (unsigned)(v[k] != 0) << k;
    return bits;
#endif
}

/* Rounds half a row; clears lanes of *fits where a number is too large. Cosines of some lengths
 * give exact halves up to the rounding of sums. All such halves round towards 0, and no such number
 * lies where the rounding differs. */
CVOL_INLINE unsigned round_half(int32_t *values, const double *from, eight_long *fits)
{
    const double shift = 0x1.8p52, most = CVOL_VALUE_LIMIT; /* numbers beyond `shift` are
                                                               integers */
    const eight v = load(from);
    const eight_long small = (v <= most) & (v >= -most);
    const eight_long sign = (eight_long)v & INT64_MIN;
    const eight nearer = v - (eight)((eight_long)(CVOL_TRUE_LENGTH_TIE_MARGIN + (eight){0}) | sign);
    const eight whole = (eight)((eight_long)((nearer + shift) - shift) & small);
    const eight_int integers = __builtin_convertvector(whole, eight_int);
    *fits &= small;
    memcpy(values, &integers, sizeof integers);
    return bits_of(whole);
}

int CVOL_SIMD(cvol_true_length_round)(int32_t *values, uint64_t *found, const double *cell,
                                      const uint16_t rows[N])
{
    eight_long fits = ~(eight_long){0};
    for (int w = 0; w < N; w++)
        for (unsigned left = rows[w]; left; left &= left - 1) {
            const int row = __builtin_ctz(left) + N * w, at = 16 * (row % 4);
            const uint64_t low = round_half(values + N * row, cell + N * row, &fits);
            const uint64_t high = round_half(values + N * row + 8, cell + N * row + 8, &fits);
            found[row / 4] = (found[row / 4] & ~(UINT64_C(0xffff) << at)) | (low | high << 8) << at;
        }
    int all = 1;
    for (int k = 0; k < 8; k++)
        all &= fits[k] != 0;
    return all;
}
