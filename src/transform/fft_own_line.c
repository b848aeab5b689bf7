/* One long line of fft_own.h.
 *
 * A line of n = n1 n2 points is transformed in two steps (Bailey 1990, without his transposes): the
 * n2 columns of n1 points at distance n2, 16 columns per batch; factors exp(-2 pi i j2 k1 / n);
 * then the n1 lines of n2 points,     X[k1 + n1 k2] = sum_j2 exp(-2 pi i j2 k2 / n2) exp(-2 pi i j2
 * k1 / n) Y_j2[k1]. A real line needs only k1 <= n1 / 2: with its mirror images this is the whole
 * spectrum. A length with a large prime factor is computed as a convolution of a smooth length
 * (fft_own.h). */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/elementary.h"
#include "base/memory.h"
#include "transform/fft_own.h"

struct cvol_fft_line {
    size_t n;
    int real;
    /* split if first is not NULL */
    cvol_fft_passes *first, *second; /* of n1 and n2 points */
    float *lane_twiddles,
        *batch_twiddles; /* for lines 0 .. 15 of a batch, and for the batches' beginnings */
    /* or convolved, if first is NULL */
    cvol_fft_line *convolution;
    float *chirp, *spectrum; /* as in cvol_fft_chirp */
};

static size_t padded(size_t lines)
{
    return (lines + CVOL_FFT_LINES - 1) / CVOL_FFT_LINES * CVOL_FFT_LINES;
}

/* Multiples of 16 floats, so that all parts are aligned. */
static size_t aligned(size_t floats)
{
    return (floats + 15) / 16 * 16;
}

static size_t batches(size_t lines)
{
    return padded(lines) / CVOL_FFT_LINES;
}

/* Lines of the second step. */
static size_t half_of(size_t n1, int real)
{
    return real ? n1 / 2 + 1 : n1;
}

/* ---- choice of n1 --------------------------------------------------------------------------- */

static size_t largest_prime(size_t n)
{
    size_t largest = 1;
    for (size_t p = 2; n > 1; p++) {
        p = p * p > n ? n : p;
        for (; n % p == 0; n /= p)
            largest = p;
    }
    return largest;
}

/* The estimated time of both steps, in arbitrary units: whole batches are computed. */
static double split_cost(size_t n1, size_t n2, int real)
{
    const double first = (double)(n1 * padded(n2)) * cvol_log2((double)n1);
    const double second = (double)(n2 * padded(half_of(n1, real))) * cvol_log2((double)n2);
    return (real ? 1 : 2) * first + 2 * second;
}

/* n1, or 0 if no split is faster. */
static size_t choose_split(size_t n, int real)
{
    size_t best = 0;
    double least = 0;
    if (largest_prime(n) > CVOL_FFT_MAX_RADIX)
        return 0;
    for (size_t d = 2; d * d <= n; d++)
        for (int i = 0; i < 2 && n % d == 0; i++) {
            const size_t n1 = i ? d : n / d;
            const double cost = split_cost(n1, n / n1, real);
            if (!best || cost <= least) { /* later divisors are closer to each other */
                best = n1;
                least = cost;
            }
        }
    return best;
}

/* ---- plans ---------------------------------------------------------------------------------- */

static int make_split(cvol_fft_line *line, size_t n1)
{
    const size_t n = line->n, n2 = n / n1, half = half_of(n1, line->real);
    line->first = cvol_fft_passes_create(n1);
    line->second = cvol_fft_passes_create(n2);
    line->lane_twiddles = cvol_fft_allocate(2 * CVOL_FFT_LINES * half);
    line->batch_twiddles = cvol_fft_allocate(2 * half * batches(n2));
    if (!line->first || !line->second || !line->lane_twiddles || !line->batch_twiddles)
        return 0;
    for (size_t k = 0; k < half; k++)
        for (size_t l = 0; l < CVOL_FFT_LINES; l++) {
            float root[2];
            cvol_fft_root(root, k * l, n);
            line->lane_twiddles[2 * CVOL_FFT_LINES * k + l] = root[0];
            line->lane_twiddles[2 * CVOL_FFT_LINES * k + CVOL_FFT_LINES + l] = root[1];
        }
    for (size_t b = 0; b < batches(n2); b++)
        for (size_t k = 0; k < half; k++)
            cvol_fft_root(line->batch_twiddles + 2 * (b * half + k), k * b * CVOL_FFT_LINES, n);
    return 1;
}

static int make_convolution(cvol_fft_line *line)
{
    const size_t n = line->n, M = cvol_fft_good_length(2 * n - 1, 1);
    line->convolution = cvol_fft_line_create(M, 0);
    line->chirp = cvol_fft_allocate(2 * n);
    line->spectrum = cvol_fft_allocate(2 * M);
    if (!line->convolution || !line->chirp || !line->spectrum)
        return 0;
    memset(line->spectrum, 0, 2 * M * sizeof *line->spectrum);
    for (size_t j = 0, square = 0; j < n; square = (square + 2 * j + 1) % (2 * n), j++) {
        float *c = line->chirp + 2 * j;
        float *at = line->spectrum + 2 * j, *mirror = line->spectrum + 2 * ((M - j) % M);
        cvol_fft_root(c, square, 2 * n);
        at[0] = mirror[0] = c[0] / (float)M;
        at[1] = mirror[1] = -c[1] / (float)M;
    }
    float *scratch = cvol_fft_allocate(cvol_fft_line_scratch(line->convolution));
    if (!scratch)
        return 0;
    cvol_fft_line_run(line->convolution, CVOL_FFT_COMPLEX_FORWARD, line->spectrum, line->spectrum,
                      scratch);
    free(scratch);
    return 1;
}

cvol_fft_line *cvol_fft_line_create(size_t n, int real)
{
    cvol_fft_line *line = calloc(1, sizeof *line);
    if (!line)
        return NULL;
    line->n = n;
    line->real = real;
    const size_t n1 = choose_split(n, real);
    if (n1 ? make_split(line, n1) : make_convolution(line))
        return line;
    cvol_fft_line_free(line);
    return NULL;
}

void cvol_fft_line_free(cvol_fft_line *line)
{
    if (!line)
        return;
    cvol_fft_passes_free(line->first);
    cvol_fft_passes_free(line->second);
    free(line->lane_twiddles);
    free(line->batch_twiddles);
    cvol_fft_line_free(line->convolution);
    free(line->chirp);
    free(line->spectrum);
    free(line);
}

size_t cvol_fft_line_bytes(const cvol_fft_line *line)
{
    if (!line->first)
        return sizeof *line + 2 * (line->n + line->convolution->n) * sizeof(float) +
               cvol_fft_line_bytes(line->convolution);
    const size_t half = half_of(line->first->n, line->real);
    return sizeof *line + cvol_fft_passes_bytes(line->first) + cvol_fft_passes_bytes(line->second) +
           2 * half * (CVOL_FFT_LINES + batches(line->second->n)) * sizeof(float);
}

/* ---- split lines ---------------------------------------------------------------------------- */

/* Columns that begin at adjacent elements, `parts` floats wide. */
static cvol_fft_side columns(size_t first, size_t stride, size_t parts)
{
    return (cvol_fft_side){
        .access = CVOL_FFT_COLUMNS, .stride = parts * stride, .at = {parts * first}};
}

/* Complex rows of `length` points, one behind the other. */
static cvol_fft_side rows(size_t first, size_t length)
{
    cvol_fft_side side = {.access = CVOL_FFT_ROWS, .stride = 2};
    for (size_t l = 0; l < CVOL_FFT_LINES; l++)
        side.at[l] = 2 * length * (first + l);
    return side;
}

static cvol_fft_side mirrored(size_t first, size_t n1, size_t n)
{
    return (cvol_fft_side){
        .access = CVOL_FFT_MIRRORED, .stride = 2 * n1, .length = n, .at = {2 * first}};
}

static int lines_from(size_t first, size_t lines)
{
    return (int)(lines - first < CVOL_FFT_LINES ? lines - first : CVOL_FFT_LINES);
}

/* Imaginary parts of frequencies 0 and n / 2 of a real line. */
static void clear_ends(float *half, size_t n)
{
    half[1] = 0;
    if (n % 2 == 0)
        half[n + 1] = 0;
}

static size_t batch_scratch(const cvol_fft_line *line)
{
    const size_t one = cvol_fft_passes_scratch(line->first);
    const size_t two = cvol_fft_passes_scratch(line->second);
    return one > two ? one : two;
}

/* The columns of n1 points, from samples to the results of the first step, or back. */
static void run_columns(const cvol_fft_line *line, cvol_fft_kind kind, float *out, const float *in,
                        float *scratch)
{
    const size_t n1 = line->first->n, n2 = line->second->n, half = half_of(n1, line->real);
    const size_t parts = line->real ? 1 : 2;
    for (size_t first = 0; first < n2; first += CVOL_FFT_LINES) {
        const cvol_fft_side samples = columns(first, n2, parts), results = rows(first, half);
        const int back = kind == CVOL_FFT_INVERSE;
        const cvol_fft_batch batch = {.passes = line->first,
                                      .kind = kind,
                                      .lines = lines_from(first, n2),
                                      .in = in,
                                      .out = out,
                                      .from = back ? results : samples,
                                      .to = back ? samples : results,
                                      .lane_twiddles = line->lane_twiddles,
                                      .batch_twiddles = line->batch_twiddles +
                                                        2 * half * (first / CVOL_FFT_LINES)};
        CVOL_SIMD_CHOOSE(cvol_fft_run_batch)(&batch, scratch);
    }
}

/* The lines of n2 points, from these results to the spectrum, or back. */
static void run_lines(const cvol_fft_line *line, cvol_fft_kind kind, float *out, const float *in,
                      float *scratch)
{
    const size_t n1 = line->first->n, half = half_of(n1, line->real);
    for (size_t first = 0; first < half; first += CVOL_FFT_LINES) {
        const cvol_fft_side results = columns(first, half, 2);
        const cvol_fft_side spectrum = line->real ? mirrored(first, n1, line->n) : results;
        const int back = kind == CVOL_FFT_INVERSE;
        const cvol_fft_batch batch = {.passes = line->second,
                                      .kind = back || kind == CVOL_FFT_COMPLEX_BACKWARD
                                                  ? CVOL_FFT_COMPLEX_BACKWARD
                                                  : CVOL_FFT_COMPLEX_FORWARD,
                                      .lines = lines_from(first, half),
                                      .in = in,
                                      .out = out,
                                      .from = back ? spectrum : results,
                                      .to = back ? results : spectrum};
        CVOL_SIMD_CHOOSE(cvol_fft_run_batch)(&batch, scratch);
    }
}

/* The place of the first step's results, behind the scratch of batches. */
static float *between(const cvol_fft_line *line, float *scratch)
{
    return scratch + batch_scratch(line);
}

static void run_split(const cvol_fft_line *line, cvol_fft_kind kind, float *out, const float *in,
                      float *scratch)
{
    const size_t n = line->n;
    float *results = line->real || out == in ? between(line, scratch) : out;
    if (kind == CVOL_FFT_INVERSE) {
        run_lines(line, kind, results, in, scratch);
        run_columns(line, kind, out, results, scratch);
    } else {
        run_columns(line, kind, results, in, scratch);
        run_lines(line, kind, out, results, scratch);
    }
    if (kind == CVOL_FFT_FORWARD)
        clear_ends(out, n);
}

/* ---- convolved lines ------------------------------------------------------------------------ */

static void multiply(float *out, const float *a, const float *b, size_t count)
{
    for (size_t i = 0; i < count; i++) {
        const float re = a[2 * i] * b[2 * i] - a[2 * i + 1] * b[2 * i + 1];
        out[2 * i + 1] = a[2 * i] * b[2 * i + 1] + a[2 * i + 1] * b[2 * i];
        out[2 * i] = re;
    }
}

/* The n complex numbers to sum; conjugates if the exponent is positive. */
static void expand(float *work, cvol_fft_kind kind, const float *in, size_t n)
{
    for (size_t i = 0; i < n; i++) {
        const size_t from = kind == CVOL_FFT_INVERSE && i > n / 2 ? n - i : i;
        float re = in[kind == CVOL_FFT_FORWARD ? i : 2 * from];
        float im = kind == CVOL_FFT_FORWARD ? 0 : in[2 * from + 1];
        if (kind == CVOL_FFT_COMPLEX_BACKWARD || from == i)
            im = kind == CVOL_FFT_COMPLEX_BACKWARD || kind == CVOL_FFT_INVERSE ? -im : im;
        if (kind == CVOL_FFT_INVERSE && (i == 0 || 2 * i == n))
            im = 0;
        work[2 * i] = re;
        work[2 * i + 1] = im;
    }
}

static void deliver(float *out, cvol_fft_kind kind, const float *work, size_t n)
{
    if (kind == CVOL_FFT_INVERSE)
        for (size_t i = 0; i < n; i++)
            out[i] = work[2 * i];
    else
        memcpy(out, work, 2 * (kind == CVOL_FFT_FORWARD ? n / 2 + 1 : n) * sizeof *out);
    if (kind == CVOL_FFT_COMPLEX_BACKWARD)
        for (size_t i = 0; i < n; i++)
            out[2 * i + 1] = -out[2 * i + 1];
    if (kind == CVOL_FFT_FORWARD)
        clear_ends(out, n);
}

static void run_convolved(const cvol_fft_line *line, cvol_fft_kind kind, float *out,
                          const float *in, float *scratch)
{
    const size_t n = line->n, M = line->convolution->n;
    float *work = scratch, *spectrum = work + 2 * M, *rest = scratch + aligned(4 * M);
    expand(work, kind, in, n);
    multiply(work, work, line->chirp, n);
    memset(work + 2 * n, 0, 2 * (M - n) * sizeof *work);
    cvol_fft_line_run(line->convolution, CVOL_FFT_COMPLEX_FORWARD, spectrum, work, rest);
    multiply(spectrum, spectrum, line->spectrum, M);
    cvol_fft_line_run(line->convolution, CVOL_FFT_COMPLEX_BACKWARD, work, spectrum, rest);
    multiply(work, work, line->chirp, n);
    deliver(out, kind, work, n);
}

size_t cvol_fft_line_scratch(const cvol_fft_line *line)
{
    if (!line->first)
        return aligned(4 * line->convolution->n) + cvol_fft_line_scratch(line->convolution);
    return batch_scratch(line) + aligned(2 * half_of(line->first->n, line->real) * line->second->n);
}

void cvol_fft_line_run(const cvol_fft_line *line, cvol_fft_kind kind, float *out, const float *in,
                       float *scratch)
{
    if (line->first)
        run_split(line, kind, out, in, scratch);
    else
        run_convolved(line, kind, out, in, scratch);
}
