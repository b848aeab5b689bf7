/* A batch of lines of fft_own.h: from memory into the lanes of vectors, its passes, and back.
 *
 * A DCT is the forward transform V of the line's even elements followed by its odd ones in reverse
 * (Makhoul 1980), with phase factors: A[k] - i A[n - k] = 2 exp(-pi i k / 2n) V[k] and an inverse
 * DCT does the same in reverse. An inverse DST is the inverse DCT of the reversed coefficients,
 * with the signs of odd samples changed.
 */
#include <string.h>

#include "base/vector.h"
#include "transform/fft_own.h"

enum { GROUPS = CVOL_FFT_LINES / CVOL_LANES };

/* The batch's groups, one line per lane, and the places of their elements. */
typedef struct groups {
    int count;
    float *data[GROUPS];
} groups;

static int is_complex(cvol_fft_kind kind)
{
    return kind == CVOL_FFT_COMPLEX_FORWARD || kind == CVOL_FFT_COMPLEX_BACKWARD;
}

static int is_inverse_cosine(cvol_fft_kind kind)
{
    return kind == CVOL_FFT_IDCT || kind == CVOL_FFT_IDST;
}

/* ---- shuffles ------------------------------------------------------------------------------- */

#if defined(__has_builtin)
#if __has_builtin(__builtin_shufflevector)
#define PICK(a, b, ...) __builtin_shufflevector(a, b, __VA_ARGS__)
#endif
#endif
#ifndef PICK
#define PICK(a, b, ...) cvol_shuffle(a, b, (cvol_vi){__VA_ARGS__})
#endif

/* EVEN_w: alternating blocks of w lanes, the even ones of a and of b; ODD_w: the odd ones. PARTS_0,
 * PARTS_1: every other lane. JOIN_0, JOIN_1: alternating lanes of a and of b. */
#if CVOL_LANES == 16
#define EVEN_1 0, 16, 2, 18, 4, 20, 6, 22, 8, 24, 10, 26, 12, 28, 14, 30
#define ODD_1 1, 17, 3, 19, 5, 21, 7, 23, 9, 25, 11, 27, 13, 29, 15, 31
#define EVEN_2 0, 1, 16, 17, 4, 5, 20, 21, 8, 9, 24, 25, 12, 13, 28, 29
#define ODD_2 2, 3, 18, 19, 6, 7, 22, 23, 10, 11, 26, 27, 14, 15, 30, 31
#define EVEN_4 0, 1, 2, 3, 16, 17, 18, 19, 8, 9, 10, 11, 24, 25, 26, 27
#define ODD_4 4, 5, 6, 7, 20, 21, 22, 23, 12, 13, 14, 15, 28, 29, 30, 31
#define EVEN_8 0, 1, 2, 3, 4, 5, 6, 7, 16, 17, 18, 19, 20, 21, 22, 23
#define ODD_8 8, 9, 10, 11, 12, 13, 14, 15, 24, 25, 26, 27, 28, 29, 30, 31
#define PARTS_0 0, 2, 4, 6, 8, 10, 12, 14, 16, 18, 20, 22, 24, 26, 28, 30
#define JOIN_0 0, 16, 1, 17, 2, 18, 3, 19, 4, 20, 5, 21, 6, 22, 7, 23
#define PARTS_1 1, 3, 5, 7, 9, 11, 13, 15, 17, 19, 21, 23, 25, 27, 29, 31
#define JOIN_1 8, 24, 9, 25, 10, 26, 11, 27, 12, 28, 13, 29, 14, 30, 15, 31
#elif CVOL_LANES == 8
#define EVEN_1 0, 8, 2, 10, 4, 12, 6, 14
#define ODD_1 1, 9, 3, 11, 5, 13, 7, 15
#define EVEN_2 0, 1, 8, 9, 4, 5, 12, 13
#define ODD_2 2, 3, 10, 11, 6, 7, 14, 15
#define EVEN_4 0, 1, 2, 3, 8, 9, 10, 11
#define ODD_4 4, 5, 6, 7, 12, 13, 14, 15
#define PARTS_0 0, 2, 4, 6, 8, 10, 12, 14
#define JOIN_0 0, 8, 1, 9, 2, 10, 3, 11
#define PARTS_1 1, 3, 5, 7, 9, 11, 13, 15
#define JOIN_1 4, 12, 5, 13, 6, 14, 7, 15
#else
#define EVEN_1 0, 4, 2, 6
#define ODD_1 1, 5, 3, 7
#define EVEN_2 0, 1, 4, 5
#define ODD_2 2, 3, 6, 7
#define PARTS_0 0, 2, 4, 6
#define JOIN_0 0, 4, 1, 5
#define PARTS_1 1, 3, 5, 7
#define JOIN_1 2, 6, 3, 7
#endif

/* For rows r without bit w: exchanges the odd blocks of row r with the even blocks of row r + w. */
#define EXCHANGE_BLOCKS(rows, w)                              \
    for (int r = 0; r < CVOL_LANES; r++)                      \
        if (!(r & (w))) {                                     \
            const cvol_vf a = (rows)[r], b = (rows)[r + (w)]; \
            (rows)[r] = PICK(a, b, EVEN_##w);                 \
            (rows)[r + (w)] = PICK(a, b, ODD_##w);            \
        }

/* Lane l of row r becomes lane r of row l. */
CVOL_INLINE void transpose(cvol_vf *rows)
{
#pragma GCC unroll 16
    EXCHANGE_BLOCKS(rows, 1)
#pragma GCC unroll 16
    EXCHANGE_BLOCKS(rows, 2)
#if CVOL_LANES >= 8
#pragma GCC unroll 16
    EXCHANGE_BLOCKS(rows, 4)
#endif
#if CVOL_LANES >= 16
#pragma GCC unroll 16
    EXCHANGE_BLOCKS(rows, 8)
#endif
}

/* Converts pairs (re, im) of one line per lane to a vector of each, and back. */
CVOL_INLINE void part(cvol_vf *re, cvol_vf *im, cvol_vf low, cvol_vf high)
{
    *re = PICK(low, high, PARTS_0);
    *im = PICK(low, high, PARTS_1);
}

CVOL_INLINE void join(cvol_vf *low, cvol_vf *high, cvol_vf re, cvol_vf im)
{
    *low = PICK(re, im, JOIN_0);
    *high = PICK(re, im, JOIN_1);
}

/* ---- the order of real lines in buffers ----------------------------------------------------- */

typedef enum order { AS_THEY_ARE, EVEN_THEN_ODD, REVERSED } order;

CVOL_INLINE size_t place_of(order of, size_t i, size_t n)
{
    if (of == EVEN_THEN_ODD)
        return i % 2 ? n - 1 - i / 2 : i / 2;
    return of == REVERSED ? n - 1 - i : i;
}

static order order_read(cvol_fft_kind kind)
{
    return kind == CVOL_FFT_DCT ? EVEN_THEN_ODD : kind == CVOL_FFT_IDST ? REVERSED : AS_THEY_ARE;
}

static order order_written(cvol_fft_kind kind)
{
    return is_inverse_cosine(kind) ? EVEN_THEN_ODD : AS_THEY_ARE;
}

/* For elements with odd indices of a kind. */
static float odd_sign(cvol_fft_kind kind)
{
    return kind == CVOL_FFT_IDST ? -1 : 1;
}

CVOL_INLINE size_t place_read(cvol_fft_kind kind, size_t i, size_t n)
{
    return place_of(order_read(kind), i, n);
}

CVOL_INLINE size_t place_written(cvol_fft_kind kind, size_t i, size_t n)
{
    return place_of(order_written(kind), i, n);
}

/* ---- columns -------------------------------------------------------------------------------- */

/* Reads 16 lines' adjacent elements; elements beyond the batch's lines are 0. */
CVOL_INLINE const float *padded(float *padding, const float *row, int count, int all)
{
    if (count == all)
        return row;
    memset(padding, 0, (size_t)all * sizeof *padding);
    memcpy(padding, row, (size_t)count * sizeof *padding);
    return padding;
}

static void load_real_columns(const groups *to, const cvol_fft_batch *batch, size_t count)
{
    float padding[CVOL_FFT_LINES];
    for (size_t i = 0; i < count; i++) {
        const float *row = padded(padding, batch->in + batch->from.at[0] + i * batch->from.stride,
                                  batch->lines, CVOL_FFT_LINES);
        const size_t at = CVOL_LANES * place_read(batch->kind, i, count);
        for (int g = 0; g < to->count; g++)
            cvol_store(to->data[g] + at, cvol_load(row + g * CVOL_LANES));
    }
}

static void load_complex_columns(const groups *to, const cvol_fft_batch *batch, size_t count)
{
    float padding[2 * CVOL_FFT_LINES];
    for (size_t i = 0; i < count; i++) {
        const float *row = padded(padding, batch->in + batch->from.at[0] + i * batch->from.stride,
                                  2 * batch->lines, 2 * CVOL_FFT_LINES);
        for (int g = 0; g < to->count; g++) {
            cvol_vf re, im;
            part(&re, &im, cvol_load(row + 2 * g * CVOL_LANES),
                 cvol_load(row + (2 * g + 1) * CVOL_LANES));
            cvol_store(to->data[g] + 2 * CVOL_LANES * i, re);
            cvol_store(to->data[g] + 2 * CVOL_LANES * i + CVOL_LANES, im);
        }
    }
}

/* Writes 16 elements' vectors, or as many as the batch has. */
CVOL_INLINE void put_row(float *row, const float *values, int count, int all)
{
    if (values != row)
        memcpy(row, values, (size_t)(count < all ? count : all) * sizeof *row);
}

static void store_real_columns(const groups *from, const cvol_fft_batch *batch, size_t count)
{
    float padding[CVOL_FFT_LINES];
    for (size_t i = 0; i < count; i++) {
        float *row = batch->out + batch->to.at[0] + i * batch->to.stride;
        float *values = batch->lines == CVOL_FFT_LINES ? row : padding;
        const size_t at = place_written(batch->kind, i, count);
        const float sign = i % 2 ? odd_sign(batch->kind) : 1;
        for (int g = 0; g < from->count; g++)
            cvol_store(values + g * CVOL_LANES, cvol_load(from->data[g] + CVOL_LANES * at) * sign);
        put_row(row, values, batch->lines, CVOL_FFT_LINES);
    }
}

static void store_complex_columns(const groups *from, const cvol_fft_batch *batch, size_t count)
{
    float padding[2 * CVOL_FFT_LINES];
    for (size_t i = 0; i < count; i++) {
        float *row = batch->out + batch->to.at[0] + i * batch->to.stride;
        float *values = batch->lines == CVOL_FFT_LINES ? row : padding;
        for (int g = 0; g < from->count; g++) {
            const float *point = from->data[g] + 2 * CVOL_LANES * i;
            cvol_vf low, high;
            join(&low, &high, cvol_load(point), cvol_load(point + CVOL_LANES));
            cvol_store(values + 2 * g * CVOL_LANES, low);
            cvol_store(values + (2 * g + 1) * CVOL_LANES, high);
        }
        put_row(row, values, 2 * batch->lines, 2 * CVOL_FFT_LINES);
    }
}

/* ---- mirrored columns: half a spectrum of a split line -----------------------------------------
 *
 * Row i is of frequencies f = at + stride i (in floats: pairs), ascending by line; those of the
 * upper half are at their mirror images, conjugate, descending. */

CVOL_INLINE int is_upper_row(size_t i, size_t count)
{
    return i >= (count + 1) / 2;
}

CVOL_INLINE size_t mirrored_row(const cvol_fft_side *side, size_t i)
{
    return 2 * side->length - side->at[0] - i * side->stride;
}

static void load_mirrored_columns(const groups *to, const cvol_fft_batch *batch, size_t count)
{
    float row[2 * CVOL_FFT_LINES] = {0};
    for (size_t i = 0; i < count; i++) {
        const int upper = is_upper_row(i, count);
        const float *first = batch->in + (upper ? mirrored_row(&batch->from, i)
                                                : batch->from.at[0] + i * batch->from.stride);
        for (int l = 0; l < batch->lines; l++) {
            const float *pair = upper ? first - 2 * l : first + 2 * l;
            row[l] = pair[0];
            row[CVOL_FFT_LINES + l] = upper ? -pair[1] : pair[1];
        }
        for (int g = 0; g < to->count; g++) {
            cvol_store(to->data[g] + 2 * CVOL_LANES * i, cvol_load(row + g * CVOL_LANES));
            cvol_store(to->data[g] + 2 * CVOL_LANES * i + CVOL_LANES,
                       cvol_load(row + CVOL_FFT_LINES + g * CVOL_LANES));
        }
    }
}

static void store_mirrored_columns(const groups *from, const cvol_fft_batch *batch, size_t count)
{
    float row[2 * CVOL_FFT_LINES];
    for (size_t i = 0; i < count; i++) {
        const int upper = is_upper_row(i, count);
        float *first = batch->out + (upper ? mirrored_row(&batch->to, i)
                                           : batch->to.at[0] + i * batch->to.stride);
        for (int g = 0; g < from->count; g++) {
            const float *point = from->data[g] + 2 * CVOL_LANES * i;
            cvol_store(row + g * CVOL_LANES, cvol_load(point));
            cvol_store(row + CVOL_FFT_LINES + g * CVOL_LANES, cvol_load(point + CVOL_LANES));
        }
        for (int l = 0; l < batch->lines; l++) {
            float *pair = upper ? first - 2 * l : first + 2 * l;
            pair[0] = row[l];
            pair[1] = upper ? -row[CVOL_FFT_LINES + l] : row[CVOL_FFT_LINES + l];
        }
    }
}

/* ---- rows: lines of `count` floats -------------------------------------------------------------
 *
 * Squares of as many floats as lines are transposed. The last square of a row ends where the row
 * ends: what it shares with the square before it is read or written twice. */

/* The places of the square at float i and of the next one. */
CVOL_INLINE size_t square_begin(size_t i, size_t count)
{
    return i + CVOL_LANES <= count ? i : count - CVOL_LANES;
}

CVOL_INLINE int lines_of_group(const cvol_fft_batch *batch, int group)
{
    const int left = batch->lines - group * CVOL_LANES;
    return left < CVOL_LANES ? left : CVOL_LANES;
}

/* For rows shorter than a square, and single lines. */
static void load_lane_by_lane(const groups *to, const cvol_fft_batch *batch, size_t count)
{
    for (int l = 0; l < to->count * CVOL_LANES; l++) {
        float *lane = to->data[l / CVOL_LANES] + l % CVOL_LANES;
        const float *line = batch->in + batch->from.at[l];
        for (size_t i = 0; i < count; i++)
            lane[CVOL_LANES * place_read(batch->kind, i, count)] = l < batch->lines ? line[i] : 0;
    }
}

static void store_lane_by_lane(const groups *from, const cvol_fft_batch *batch, size_t count)
{
    for (int l = 0; l < batch->lines; l++) {
        const float *lane = from->data[l / CVOL_LANES] + l % CVOL_LANES;
        float *line = batch->out + batch->to.at[l];
        for (size_t i = 0; i < count; i++) {
            const float value = lane[CVOL_LANES * place_written(batch->kind, i, count)];
            line[i] = batch->kind == CVOL_FFT_IDST && i % 2 ? -value : value;
        }
    }
}

static void load_single_row(const groups *to, const cvol_fft_batch *batch, size_t count)
{
    const float *line = batch->in + batch->from.at[0];
    for (size_t i = 0; i < count; i++)
        cvol_store(to->data[0] + CVOL_LANES * place_read(batch->kind, i, count),
                   (cvol_vf){line[i]});
}

CVOL_INLINE void load_squares(const groups *to, const cvol_fft_batch *batch, size_t count, order of)
{
    for (int g = 0; g < to->count; g++) {
        const size_t *at = batch->from.at + g * CVOL_LANES;
        const int present = lines_of_group(batch, g);
        for (size_t i = 0; i < count; i += CVOL_LANES) {
            const size_t begin = square_begin(i, count);
            cvol_vf square[CVOL_LANES];
#pragma GCC unroll 16
            for (int l = 0; l < CVOL_LANES; l++)
                square[l] = l < present ? cvol_load(batch->in + at[l] + begin) : (cvol_vf){0};
            transpose(square);
#pragma GCC unroll 16
            for (size_t j = 0; j < CVOL_LANES; j++)
                cvol_store(to->data[g] + CVOL_LANES * place_of(of, begin + j, count), square[j]);
        }
    }
}

CVOL_INLINE void store_squares(const groups *from, const cvol_fft_batch *batch, size_t count,
                               order of)
{
    const float sign = odd_sign(batch->kind);
    for (int g = 0; g < from->count; g++) {
        const size_t *at = batch->to.at + g * CVOL_LANES;
        const int present = lines_of_group(batch, g);
        for (size_t i = 0; i < count; i += CVOL_LANES) {
            const size_t begin = square_begin(i, count);
            cvol_vf square[CVOL_LANES];
#pragma GCC unroll 16
            for (size_t j = 0; j < CVOL_LANES; j++) {
                square[j] = cvol_load(from->data[g] + CVOL_LANES * place_of(of, begin + j, count));
                if (of == EVEN_THEN_ODD)
                    square[j] *= (begin + j) % 2 ? sign : 1;
            }
            transpose(square);
#pragma GCC unroll 16
            for (int l = 0; l < CVOL_LANES; l++)
                if (l < present)
                    cvol_store(batch->out + at[l] + begin, square[l]);
        }
    }
}

static void load_rows(const groups *to, const cvol_fft_batch *batch, size_t count)
{
    if (batch->lines == 1)
        load_single_row(to, batch, count);
    else if (count < CVOL_LANES)
        load_lane_by_lane(to, batch, count);
    else if (order_read(batch->kind) == AS_THEY_ARE)
        load_squares(to, batch, count, AS_THEY_ARE);
    else if (order_read(batch->kind) == EVEN_THEN_ODD)
        load_squares(to, batch, count, EVEN_THEN_ODD);
    else
        load_squares(to, batch, count, REVERSED);
}

static void store_rows(const groups *from, const cvol_fft_batch *batch, size_t count)
{
    if (batch->lines == 1 || count < CVOL_LANES)
        store_lane_by_lane(from, batch, count);
    else if (order_written(batch->kind) == AS_THEY_ARE)
        store_squares(from, batch, count, AS_THEY_ARE);
    else
        store_squares(from, batch, count, EVEN_THEN_ODD);
}

/* ---- scattered elements --------------------------------------------------------------------- */

/* The place of float `part` of element i. */
static void load_scattered(const groups *to, const cvol_fft_batch *batch, size_t count,
                           size_t parts)
{
    for (int l = 0; l < to->count * CVOL_LANES; l++) {
        float *lane = to->data[l / CVOL_LANES] + l % CVOL_LANES;
        for (size_t i = 0; i < count; i++)
            for (size_t p = 0; p < parts; p++) {
                const size_t at = parts * place_read(batch->kind, i, count) + p;
                lane[CVOL_LANES * at] =
                    l < batch->lines ? batch->in[batch->from.at[l] + i * batch->from.stride + p]
                                     : 0;
            }
    }
}

static void store_scattered(const groups *from, const cvol_fft_batch *batch, size_t count,
                            size_t parts)
{
    for (int l = 0; l < batch->lines; l++) {
        const float *lane = from->data[l / CVOL_LANES] + l % CVOL_LANES;
        for (size_t i = 0; i < count; i++)
            for (size_t p = 0; p < parts; p++) {
                const float value =
                    lane[CVOL_LANES * (parts * place_written(batch->kind, i, count) + p)];
                batch->out[batch->to.at[l] + i * batch->to.stride + p] =
                    batch->kind == CVOL_FFT_IDST && i % 2 ? -value : value;
            }
    }
}

/* ---- sides ---------------------------------------------------------------------------------- */

/* Elements of a line, of this number of floats each. */
static size_t elements(const cvol_fft_batch *batch, int written, size_t *parts)
{
    const size_t n = batch->passes->n;
    const int half = batch->kind == (written ? CVOL_FFT_FORWARD : CVOL_FFT_INVERSE);
    *parts = half || is_complex(batch->kind) ? 2 : 1;
    return half ? n / 2 + 1 : n;
}

static void load_batch(const groups *to, const cvol_fft_batch *batch)
{
    size_t parts;
    const size_t count = elements(batch, 0, &parts);
    switch (batch->from.access) {
    case CVOL_FFT_COLUMNS:
        if (parts == 2)
            load_complex_columns(to, batch, count);
        else
            load_real_columns(to, batch, count);
        break;
    case CVOL_FFT_ROWS:
        load_rows(to, batch, parts * count);
        break;
    case CVOL_FFT_SCATTERED:
        load_scattered(to, batch, count, parts);
        break;
    default:
        load_mirrored_columns(to, batch, count);
    }
}

static void store_batch(const groups *from, const cvol_fft_batch *batch)
{
    size_t parts;
    const size_t count = elements(batch, 1, &parts);
    switch (batch->to.access) {
    case CVOL_FFT_COLUMNS:
        if (parts == 2)
            store_complex_columns(from, batch, count);
        else
            store_real_columns(from, batch, count);
        break;
    case CVOL_FFT_ROWS:
        store_rows(from, batch, parts * count);
        break;
    case CVOL_FFT_SCATTERED:
        store_scattered(from, batch, count, parts);
        break;
    default:
        store_mirrored_columns(from, batch, count);
    }
}

/* ---- steps before and after the passes, of one group ---------------------------------------- */

/* Imaginary parts of frequencies 0 and n / 2 of real lines. */
static void clear_ends(float *half, size_t n)
{
    cvol_store(half + CVOL_LANES, (cvol_vf){0});
    if (n % 2 == 0)
        cvol_store(half + 2 * CVOL_LANES * (n / 2) + CVOL_LANES, (cvol_vf){0});
}

/* The factors between the halves of a split line, `count` points. */
static void turn(float *data, const cvol_fft_batch *batch, size_t count, int group, int conjugate)
{
    const float sign = conjugate ? -1 : 1;
    for (size_t k = 0; k < count; k++) {
        const float *lanes = batch->lane_twiddles + 2 * CVOL_FFT_LINES * k + group * CVOL_LANES;
        const cvol_vf lane_re = cvol_load(lanes), lane_im = cvol_load(lanes + CVOL_FFT_LINES);
        const float re = batch->batch_twiddles[2 * k], im = batch->batch_twiddles[2 * k + 1];
        const cvol_vf w_re = lane_re * re - lane_im * im;
        const cvol_vf w_im = (lane_re * im + lane_im * re) * sign;
        float *at = data + 2 * CVOL_LANES * k;
        const cvol_vf a_re = cvol_load(at), a_im = cvol_load(at + CVOL_LANES);
        cvol_store(at, a_re * w_re - a_im * w_im);
        cvol_store(at + CVOL_LANES, a_re * w_im + a_im * w_re);
    }
}

/* Converts half a spectrum to the coefficients of a DCT. */
static void cosines_from_half(float *out, const float *half, const float *cosines, size_t n)
{
    for (size_t k = 0; 2 * k <= n; k++) {
        const cvol_vf re = cvol_load(half + 2 * CVOL_LANES * k);
        const cvol_vf im = cvol_load(half + 2 * CVOL_LANES * k + CVOL_LANES);
        const float c = 2 * cosines[2 * k], s = 2 * cosines[2 * k + 1];
        cvol_store(out + CVOL_LANES * k, re * c - im * s);
        if (k && 2 * k < n)
            cvol_store(out + CVOL_LANES * (n - k), -(re * s + im * c));
    }
}

/* The inverse: V[k] = exp(pi i k / 2n) (A[k] - i A[n - k]), A[n] = 0. */
static void half_from_cosines(float *half, const float *in, const float *cosines, size_t n)
{
    for (size_t k = 0; 2 * k <= n; k++) {
        const cvol_vf a = cvol_load(in + CVOL_LANES * k);
        const cvol_vf b = k ? cvol_load(in + CVOL_LANES * (n - k)) : (cvol_vf){0};
        const float c = cosines[2 * k], s = cosines[2 * k + 1];
        cvol_store(half + 2 * CVOL_LANES * k, a * c - b * s);
        cvol_store(half + 2 * CVOL_LANES * k + CVOL_LANES, -(a * s) - b * c);
    }
}

/* ---- one group ------------------------------------------------------------------------------ */

static float *run_group(const cvol_fft_batch *batch, float *data, float *spare, float *chirp,
                        int group)
{
    const cvol_fft_passes *passes = batch->passes;
    const size_t n = passes->n;
    const int backward = batch->kind == CVOL_FFT_COMPLEX_BACKWARD;
    float *found;
    switch (batch->kind) {
    case CVOL_FFT_COMPLEX_FORWARD:
    case CVOL_FFT_COMPLEX_BACKWARD:
        found = CVOL_SIMD(cvol_fft_complex_passes)(passes, data, spare, chirp, backward);
        if (batch->lane_twiddles)
            turn(found, batch, n, group, backward);
        return found;
    case CVOL_FFT_FORWARD:
        found = CVOL_SIMD(cvol_fft_forward_passes)(passes, data, spare, chirp);
        clear_ends(found, n);
        if (batch->lane_twiddles)
            turn(found, batch, n / 2 + 1, group, 0);
        return found;
    case CVOL_FFT_INVERSE:
        if (batch->lane_twiddles)
            turn(data, batch, n / 2 + 1, group, 1);
        clear_ends(data, n);
        return CVOL_SIMD(cvol_fft_inverse_passes)(passes, data, spare, chirp);
    case CVOL_FFT_DCT:
        found = CVOL_SIMD(cvol_fft_forward_passes)(passes, data, spare, chirp);
        clear_ends(found, n);
        spare = found == data ? spare : data;
        cosines_from_half(spare, found, batch->cosines, n);
        return spare;
    default:
        half_from_cosines(spare, data, batch->cosines, n);
        clear_ends(spare, n);
        return CVOL_SIMD(cvol_fft_inverse_passes)(passes, spare, data, chirp);
    }
}

void CVOL_SIMD(cvol_fft_run_batch)(const cvol_fft_batch *batch, float *scratch)
{
    const size_t room = CVOL_LANES * (2 * batch->passes->n + 2);
    float *const chirp = scratch + 2 * GROUPS * room;
    groups of = {.count = (batch->lines + CVOL_LANES - 1) / CVOL_LANES};
    for (int g = 0; g < of.count; g++)
        of.data[g] = scratch + 2 * (size_t)g * room;
    load_batch(&of, batch);
    for (int g = 0; g < of.count; g++)
        of.data[g] = run_group(batch, of.data[g], of.data[g] + room, chirp, g);
    store_batch(&of, batch);
}
