/* Multiplies matrices along the axes of a cell, from rows that are not zero. */
#include <stddef.h>
#include <string.h>

#include "base/cpu.h"
#include "base/vector_double.h"
#include "codec/quantize/quantize.h"
#include "codec/quantize/true_length_kernel.h"

enum { N = CVOL_CELL };

void CVOL_SIMD(cvol_true_length_axes)(double *cell, uint16_t rows[N], const int inside[3],
                                      uint16_t split, const cvol_true_length_matrix *matrices);
int CVOL_SIMD(cvol_true_length_round)(int32_t *values, uint64_t *found, const double *cell,
                                      const uint16_t rows[N]);

/* SUMS rows of CHUNK registers are summed at once: as many as there are registers for. */
#if defined(__AVX512F__)
enum { CHUNK = 2, SUMS = 4 };
#else
enum { CHUNK = 4, SUMS = 2 };
#endif
enum { LANES = CVOL_VD_LANES };

/* a in even lanes, b in odd ones. */
CVOL_INLINE cvol_vd alternate(double a, double b)
{
#if defined(__AVX512F__)
    return (cvol_vd){a, b, a, b, a, b, a, b};
#elif defined(__AVX2__)
    return (cvol_vd){a, b, a, b};
#else
    return (cvol_vd){a, b};
#endif
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
    cvol_vd sums[N / LANES];
#pragma GCC unroll 8
    for (int c = 0; c < N / LANES; c++)
        sums[c] = (cvol_vd){0};
    for (int k = 0; k < N; k++) {
        if (row[k] == 0)
            continue;
#pragma GCC unroll 8
        for (int c = 0; c < N / LANES; c++)
            sums[c] += row[k] * cvol_vd_load(by->of[k] + c * LANES);
    }
#pragma GCC unroll 8
    for (int c = 0; c < N / LANES; c++)
        cvol_vd_store(row + c * LANES, sums[c]);
}

/* Writes rows u .. u + SUMS - 1: sums of the `count` rows of `from`, whose places are k[]. Even and
 * odd columns have separate matrices if `two`. */
CVOL_INLINE void sum_rows(double *first, ptrdiff_t stride, int u, const double (*from)[N],
                          const int *k, int count, const cvol_true_length_matrix *even,
                          const cvol_true_length_matrix *odd, int two)
{
    for (int at = 0; at < N; at += CHUNK * LANES) {
        cvol_vd sums[SUMS][CHUNK];
#pragma GCC unroll 4
        for (int s = 0; s < SUMS; s++)
#pragma GCC unroll 4
            for (int c = 0; c < CHUNK; c++)
                sums[s][c] = (cvol_vd){0};
        for (int i = 0; i < count; i++) {
            cvol_vd row[CHUNK];
#pragma GCC unroll 4
            for (int c = 0; c < CHUNK; c++)
                row[c] = cvol_vd_load(from[i] + at + c * LANES);
#pragma GCC unroll 4
            for (int s = 0; s < SUMS; s++) {
                const double a = even->of[k[i]][u + s];
                const cvol_vd by = two ? alternate(a, odd->of[k[i]][u + s]) : cvol_vd_splat(a);
#pragma GCC unroll 4
                for (int c = 0; c < CHUNK; c++)
                    sums[s][c] += by * row[c];
            }
        }
#pragma GCC unroll 4
        for (int s = 0; s < SUMS; s++)
#pragma GCC unroll 4
            for (int c = 0; c < CHUNK; c++)
                cvol_vd_store(first + (u + s) * stride + at + c * LANES, sums[s][c]);
    }
}

/* Transforms the rows first + k stride across another axis, for the bits k of `which`. Returns a
 * bit for each row that the result may have. */
CVOL_INLINE unsigned transform_rows(double *first, ptrdiff_t stride, unsigned which,
                                    const cvol_true_length_matrix *even,
                                    const cvol_true_length_matrix *odd)
{
    double from[N][N];
    int k[N], count = 0;
    for (; which; which &= which - 1) {
        k[count] = __builtin_ctz(which);
        memcpy(from[count], first + k[count] * stride, sizeof from[count]);
        count++;
    }
    const unsigned reached = even->reached | odd->reached;
    for (int u = 0; u < N; u += SUMS)
        if (!(reached >> u & ((1u << SUMS) - 1)))
            for (int s = 0; s < SUMS; s++)
                memset(first + (u + s) * stride, 0, sizeof *from);
        else if (even == odd)
            sum_rows(first, stride, u, (const double(*)[N])from, k, count, even, odd, 0);
        else
            sum_rows(first, stride, u, (const double(*)[N])from, k, count, even, odd, 1);
    return reached;
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
        rows[w] = (uint16_t)transform_rows(cell + N * N * w, N, rows[w],
                                           &matrices[place_of(inside, split, 1, 0, w)],
                                           &matrices[place_of(inside, split, 1, 1, w)]);
    }
    uint16_t after[N] = {0};
    for (int v = 0; v < N && inside[2] < N; v++) {
        unsigned which = 0;
        for (int w = 0; w < N; w++)
            which |= (unsigned)(rows[w] >> v & 1) << w;
        if (!which)
            continue;
        const unsigned reached = transform_rows(cell + N * v, N * N, which,
                                                &matrices[place_of(inside, split, 2, 0, v)],
                                                &matrices[place_of(inside, split, 2, 1, v)]);
        for (int w = 0; w < N; w++)
            after[w] |= (uint16_t)((reached >> w & 1) << v);
    }
    if (inside[2] < N)
        memcpy(rows, after, sizeof after);
}

/* Returns a bit for each nonzero number. */
CVOL_INLINE unsigned bits_of(cvol_vd v)
{
#if defined(__AVX512F__)
    return _mm512_cmp_pd_mask((__m512d)v, _mm512_setzero_pd(), _CMP_NEQ_UQ);
#elif defined(__AVX2__)
    return (unsigned)_mm256_movemask_pd((__m256d)(v != 0));
#else
    unsigned bits = 0;
    for (int k = 0; k < LANES; k++)
        bits |= (unsigned)(v[k] != 0) << k;
    return bits;
#endif
}

/* Rounds a register; clears lanes of *fits where a number is too large. Cosines of some lengths
 * give exact halves up to the rounding of sums. All such halves round towards 0, and no such number
 * lies where the rounding differs. */
CVOL_INLINE unsigned round_lanes(int32_t *values, const double *from, cvol_vl *fits)
{
    const double shift = 0x1.8p52, most = CVOL_VALUE_LIMIT; /* numbers beyond `shift` are
                                                               integers */
    const cvol_vd v = cvol_vd_load(from);
    const cvol_vl small = (v <= most) & (v >= -most);
    const cvol_vl sign = (cvol_vl)v & INT64_MIN;
    const cvol_vd nearer = v -
                           (cvol_vd)((cvol_vl)cvol_vd_splat(CVOL_TRUE_LENGTH_TIE_MARGIN) | sign);
    const cvol_vd whole = (cvol_vd)((cvol_vl)((nearer + shift) - shift) & small);
    const cvol_vd_ints integers = __builtin_convertvector(whole, cvol_vd_ints);
    *fits &= small;
    memcpy(values, &integers, sizeof integers);
    return bits_of(whole);
}

int CVOL_SIMD(cvol_true_length_round)(int32_t *values, uint64_t *found, const double *cell,
                                      const uint16_t rows[N])
{
    cvol_vl fits = ~(cvol_vl){0};
    for (int w = 0; w < N; w++)
        for (unsigned left = rows[w]; left; left &= left - 1) {
            const int row = __builtin_ctz(left) + N * w, at = 16 * (row % 4);
            uint64_t bits = 0;
#pragma GCC unroll 8
            for (int x = 0; x < N; x += LANES)
                bits |= (uint64_t)round_lanes(values + N * row + x, cell + N * row + x, &fits) << x;
            found[row / 4] = (found[row / 4] & ~(UINT64_C(0xffff) << at)) | bits << at;
        }
    int all = 1;
    for (int k = 0; k < LANES; k++)
        all &= fits[k] != 0;
    return all;
}
