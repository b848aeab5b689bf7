/* The transforms of split cells on vectors, separable: x, then y, then z, in both directions, so
 * that the inverse runs from the sparse end to the dense one. Along x the lanes are half a row
 * (eight, or twice four), and there are two sums. With octants there is one for each octant of the
 * row. A whole cell has one for its even and one for its odd frequencies, from the sums and the
 * differences of mirrored samples. Both are the same loop. Along y and z lanes are x (or u), and
 * the basis' symmetry halves the work: transform/lines.h. */
#include "base/cpu.h"
#include "base/vector.h"
#include "transform/cell.h"
#include "transform/cell_bases.h"
#include "transform/lines.h"

#define N CVOL_CELL

/* Vectors along x: as long as half a row, or as the set's own if these are shorter. */
#define LANES (CVOL_LANES < 8 ? CVOL_LANES : 8)
#define PARTS (8 / LANES)
typedef float lanes __attribute__((vector_size(4 * LANES)));

void CVOL_SIMD(cvol_cell_forward_by)(float *out, const float *in, int way,
                                     const cvol_cell_bases *with);
void CVOL_SIMD(cvol_cell_inverse_box)(float *out, const float *in, uint16_t split, const int box[3],
                                      const cvol_cell_bases *with);

CVOL_INLINE lanes load_lanes(const float *from)
{
    lanes v;
    memcpy(&v, from, sizeof v);
    return v;
}

CVOL_INLINE void store_lanes(float *to, lanes v)
{
    memcpy(to, &v, sizeof v);
}

CVOL_INLINE lanes reverse(lanes v)
{
#if CVOL_LANES == 4
    return (lanes){v[3], v[2], v[1], v[0]};
#else
    return (lanes){v[7], v[6], v[5], v[4], v[3], v[2], v[1], v[0]};
#endif
}

/* Stores a0 b0 a1 b1 ... */
CVOL_INLINE void store_in_turn(float *to, lanes a, lanes b)
{
#if CVOL_LANES == 4
    store_lanes(to, (lanes){a[0], b[0], a[1], b[1]});
    store_lanes(to + 4, (lanes){a[2], b[2], a[3], b[3]});
#else
    store_lanes(to, (lanes){a[0], b[0], a[1], b[1], a[2], b[2], a[3], b[3]});
    store_lanes(to + 8, (lanes){a[4], b[4], a[5], b[5], a[6], b[6], a[7], b[7]});
#endif
}

/* The matrix D of one kind of split along an axis, and the side of its DCTs. */
CVOL_INLINE const float *square(const cvol_cell_bases *with, int way)
{
    return way == CVOL_CELL_BY_16 ? with->of_16 : way == CVOL_CELL_BY_8 ? with->of_8 : with->of_4;
}

/* Rows folded about the cell's centre: sums of mirrored samples, then their differences. */
CVOL_INLINE void fold_x(float *out, const float *in)
{
    for (int row = 0; row < N * N; row++, in += N, out += N)
        for (int part = 0; part < 8; part += LANES) {
            lanes low = load_lanes(in + part), high = reverse(load_lanes(in + N - LANES - part));
            store_lanes(out + part, low + high);
            store_lanes(out + 8 + part, low - high);
        }
}

/* From rows of samples (folded, for a whole cell) to rows of places. */
CVOL_INLINE void forward_x(float *out, const float *in, int way, const cvol_cell_bases *with)
{
    for (int row = 0; row < N * N; row++, in += N, out += N)
        for (int part = 0; part < 8; part += LANES) {
            lanes even = {0}, odd = {0};
            for (int x = 0; x < 8; x++) {
                even += in[x] * load_lanes(with->columns[way][0][x] + part);
                odd += in[8 + x] * load_lanes(with->columns[way][1][x] + part);
            }
            store_in_turn(out + 2 * part, even, odd);
        }
}

/* One DCT of side M for CVOL_LANES lines: out[f out_stride] = sum_x D[f][x] in[x in_stride]. */
CVOL_INLINE void forward_line(float *out, ptrdiff_t out_stride, const float *in,
                              ptrdiff_t in_stride, const float *basis, int M)
{
    cvol_vf sum[N / 2], difference[N / 2];
    for (int i = 0; i < M / 2; i++) {
        cvol_vf a = cvol_load(in + i * in_stride), b = cvol_load(in + (M - 1 - i) * in_stride);
        sum[i] = a + b;
        difference[i] = a - b;
    }
    for (int f = 0; f < M; f += 2) {
        cvol_vf even = {0}, odd = {0};
        for (int i = 0; i < M / 2; i++) {
            even += basis[f * M + i] * sum[i];
            odd += basis[(f + 1) * M + i] * difference[i];
        }
        cvol_store(out + f * out_stride, even);
        cvol_store(out + (f + 1) * out_stride, odd);
    }
}

/* The place of frequency 0 of the DCT that begins at sample `begin` of an axis. */
CVOL_INLINE int first_place(int begin)
{
    return (begin >> 3) + 2 * (begin >> 2 & 1);
}

/* Along the axis whose neighbours lie `stride` floats apart, all lines of N. */
CVOL_INLINE void forward_axis(float *out, const float *in, ptrdiff_t stride, int way,
                              const cvol_cell_bases *with)
{
    const int M = N >> way;
    const ptrdiff_t other = stride == N ? (ptrdiff_t)N * N : N;
    for (int line = 0; line < N; line++)
        for (int part = 0; part < N; part += CVOL_LANES)
            for (int begin = 0; begin < N; begin += M)
                forward_line(out + line * other + first_place(begin) * stride + part,
                             (N / M) * stride, in + line * other + begin * stride + part, stride,
                             square(with, way), M);
}

CVOL_INLINE void forward(float *out, const float *in, int way, const cvol_cell_bases *with)
{
    float first[CVOL_CELL_SAMPLES] __attribute__((aligned(64)));
    float second[CVOL_CELL_SAMPLES] __attribute__((aligned(64)));
    if (way == CVOL_CELL_BY_16)
        fold_x(second, in);
    forward_x(first, way == CVOL_CELL_BY_16 ? second : in, way, with);
    forward_axis(second, first, N, way, with);
    forward_axis(out, second, (ptrdiff_t)N * N, way, with);
}

void CVOL_SIMD(cvol_cell_forward_by)(float *out, const float *in, int way,
                                     const cvol_cell_bases *with)
{
    if (way == CVOL_CELL_BY_16)
        forward(out, in, CVOL_CELL_BY_16, with);
    else if (way == CVOL_CELL_BY_8)
        forward(out, in, CVOL_CELL_BY_8, with);
    else
        forward(out, in, CVOL_CELL_BY_4, with);
}

/* From a row of places, of which only the first K are not zero, to a row of samples. */
CVOL_INLINE void inverse_row(float *out, const float *in, int K, int whole,
                             const float even_basis[8][8], const float odd_basis[8][8])
{
    lanes even[PARTS], odd[PARTS];
    for (int p = 0; p < PARTS; p++)
        even[p] = odd[p] = (lanes){0};
    int g = 0;
    for (; 2 * g + 1 < K; g++)
        for (int p = 0; p < PARTS; p++) {
            even[p] += in[2 * g] * load_lanes(even_basis[g] + p * LANES);
            odd[p] += in[2 * g + 1] * load_lanes(odd_basis[g] + p * LANES);
        }
    for (int p = 0; p < PARTS; p++) {
        if (2 * g < K)
            even[p] += in[2 * g] * load_lanes(even_basis[g] + p * LANES);
        store_lanes(out + p * LANES, whole ? even[p] + odd[p] : even[p]);
        if (whole)
            store_lanes(out + N - LANES - p * LANES, reverse(even[p] - odd[p]));
        else
            store_lanes(out + 8 + p * LANES, odd[p]);
    }
}

CVOL_INLINE void inverse_x(float *out, const float *in, uint16_t split, const int box[3],
                           const cvol_cell_bases *with)
{
    const int whole = !(split & 1);
    for (int w = 0; w < box[2]; w++)
        for (int v = 0; v < box[1]; v++) {
            const int left = cvol_cell_octant_transform(split, 0, v & 1, w & 1),
                      right = cvol_cell_octant_transform(split, 1, v & 1, w & 1);
            inverse_row(out + (w * N + v) * N, in + (w * N + v) * N, box[0], whole,
                        with->lanes[left][0], with->lanes[right][1]);
        }
}

/* The number of the places first, first + step, ... below K. */
CVOL_INLINE int count_places(int K, int first, int step)
{
    return K > first ? (K - first + step - 1) / step : 0;
}

/* `count` neighbouring lines along an axis, from places of half c below K to its 8 samples, or
 * (BY_16) from all places to all samples. */
CVOL_INLINE void inverse_lines(float *out, const float *in, ptrdiff_t stride, int K, int c, int way,
                               const cvol_cell_bases *with, int count)
{
    const int M = N >> way, step = N / M, end = way == CVOL_CELL_BY_16 ? N : 8;
    for (int part = 0; part < count; part += CVOL_LANES)
        for (int begin = 0; begin < end; begin += M) {
            const int first = first_place(8 * c + begin);
            cvol_lines_inverse(out + (8 * c + begin) * stride + part, stride,
                               in + first * stride + part, step * stride,
                               count_places(K, first, step), square(with, way), M,
                               count < CVOL_LANES ? count : CVOL_LANES);
        }
}

/* Half c of the axis, for the two octants of a row: together if they have the same split. */
CVOL_INLINE void inverse_pair(float *out, const float *in, ptrdiff_t stride, int K, int c, int left,
                              int right, const cvol_cell_bases *with)
{
    if (left == right && left == CVOL_CELL_BY_8)
        inverse_lines(out, in, stride, K, c, CVOL_CELL_BY_8, with, N);
    else if (left == right)
        inverse_lines(out, in, stride, K, c, CVOL_CELL_BY_4, with, N);
    else {
        const int eights = left == CVOL_CELL_BY_8 ? 0 : 8;
        inverse_lines(out + eights, in + eights, stride, K, c, CVOL_CELL_BY_8, with, 8);
        inverse_lines(out + 8 - eights, in + 8 - eights, stride, K, c, CVOL_CELL_BY_4, with, 8);
    }
}

void CVOL_SIMD(cvol_cell_inverse_box)(float *out, const float *in, uint16_t split, const int box[3],
                                      const cvol_cell_bases *with)
{
    /* Half a row is loaded as a whole vector: eight floats beyond the cell. */
    float first[CVOL_CELL_SAMPLES + 8] __attribute__((aligned(64)));
    float second[CVOL_CELL_SAMPLES + 8] __attribute__((aligned(64)));
    memset(first + CVOL_CELL_SAMPLES, 0, 8 * sizeof *first);
    memset(second + CVOL_CELL_SAMPLES, 0, 8 * sizeof *second);
    const ptrdiff_t sheet = (ptrdiff_t)N * N;
    inverse_x(first, in, split, box, with);
    if (!(split & 1)) {
        for (int w = 0; w < box[2]; w++)
            inverse_lines(second + w * sheet, first + w * sheet, N, box[1], 0, CVOL_CELL_BY_16,
                          with, N);
        for (int y = 0; y < N; y++)
            inverse_lines(out + y * N, second + y * N, sheet, box[2], 0, CVOL_CELL_BY_16, with, N);
        return;
    }
    for (int w = 0; w < box[2]; w++)
        for (int c = 0; c < 2; c++)
            inverse_pair(second + w * sheet, first + w * sheet, N, box[1], c,
                         cvol_cell_octant_transform(split, 0, c, w & 1),
                         cvol_cell_octant_transform(split, 1, c, w & 1), with);
    for (int y = 0; y < N; y++)
        for (int c = 0; c < 2; c++)
            inverse_pair(out + y * N, second + y * N, sheet, box[2], c,
                         cvol_cell_octant_transform(split, 0, y >> 3, c),
                         cvol_cell_octant_transform(split, 1, y >> 3, c), with);
}
