/* The default backend of fft.h: its plans and the kernels that execute them.
 *
 * A length n is factorized into radices. A transform runs one pass for each radix over a buffer of
 * vectors, in which every lane holds one line (Stockham's order, decimation in time): a pass over
 * sub-transforms of length m = before turns r of them into one of length m r,
 *     X[k + m u] = sum_j exp(-2 pi i j u / r) exp(-2 pi i j k / (m r)) Y_j[k],
 * with `after` adjacent sub-transforms. Real lines need only k <= m / 2, as the rest of their
 * spectra is mirrored. The inverse transform of half a spectrum runs the passes in reverse. The
 * backward complex transform is the forward one with real and imaginary parts exchanged.
 *
 * A single long line is split into n1 n2 points (fft_own_line.c), whose lines fill the lanes.
 *
 * Every lane computes the same operations in the same order on every processor, so that the results
 * have the same bits.
 */
#ifndef CVOL_TRANSFORM_FFT_OWN_H
#define CVOL_TRANSFORM_FFT_OWN_H

#include "base/cpu.h"
#include "transform/fft.h"

/* The number of lines of a batch, the same on every processor. */
#define CVOL_FFT_LINES 16
/* The largest number of passes of a length: all radices are >= 2, and two 2s are a 4. */
#define CVOL_FFT_MAX_PASSES 41
/* The largest prime whose sums are computed term by term. */
#define CVOL_FFT_MAX_RADIX 61

/* ---- a length's passes (fft_own_passes.c) --------------------------------------------------- */

typedef struct cvol_fft_passes cvol_fft_passes;

/* A sum of p terms, p a large prime, as a convolution of length M >= 2 p - 1 (Bluestein 1970):
 *     X[u] = c[u] sum_j (x[j] c[j]) conj(c[u - j]),   c[j] = exp(-pi i j^2 / p). */
typedef struct cvol_fft_chirp {
    cvol_fft_passes *convolution; /* of length M */
    float *chirp;                 /* c: p pairs */
    float *spectrum;              /* of conj(c), over M: M pairs */
} cvol_fft_chirp;

typedef struct cvol_fft_pass {
    size_t radix, before, after;
    const float *twiddles; /* of (k, j), j = 1 .. radix - 1: pairs */
    const float *waves;    /* radix > 8: cos and sin of 2 pi u j / radix, u and j = 1 .. radix/2 */
    cvol_fft_chirp *chirp; /* radix > CVOL_FFT_MAX_RADIX, else NULL */
} cvol_fft_pass;

struct cvol_fft_passes {
    size_t n;
    size_t chirp_points; /* the largest convolution's length */
    int count;
    cvol_fft_pass pass[CVOL_FFT_MAX_PASSES];
    float *tables; /* memory of twiddles and waves */
};

/* NULL without memory. */
cvol_fft_passes *cvol_fft_passes_create(size_t n);
void cvol_fft_passes_free(cvol_fft_passes *passes);
size_t cvol_fft_passes_bytes(const cvol_fft_passes *passes);
/* The number of floats of scratch of a batch. */
size_t cvol_fft_passes_scratch(const cvol_fft_passes *passes);
/* exp(-2 pi i k / n), rounded from double precision. */
void cvol_fft_root(float out[2], size_t k, size_t n);

/* ---- batches of lines (fft_own_batch_simd.c) ------------------------------------------------ */

typedef enum cvol_fft_access {
    CVOL_FFT_COLUMNS,   /* lines begin at adjacent elements */
    CVOL_FFT_ROWS,      /* a line's elements are adjacent */
    CVOL_FFT_SCATTERED, /* neither */
    CVOL_FFT_MIRRORED   /* columns of half a spectrum of `length` points, see fft_own_line.c */
} cvol_fft_access;

/* The places of a batch's lines, in floats. */
typedef struct cvol_fft_side {
    cvol_fft_access access;
    size_t stride, length;
    size_t at[CVOL_FFT_LINES];
} cvol_fft_side;

typedef struct cvol_fft_batch {
    const cvol_fft_passes *passes;
    const float *cosines; /* DCT, IDCT, IDST: exp(-pi i k / 2n), k = 0 .. n / 2 */
    cvol_fft_kind kind;
    int lines; /* at most CVOL_FFT_LINES */
    const float *in;
    float *out;
    cvol_fft_side from, to;
    /* The factors between the two steps of a split line, or NULL. FORWARD and COMPLEX_FORWARD
     * multiply result k of line l by lane_twiddles[k][l] batch_twiddles[k]. COMPLEX_BACKWARD
     * multiplies result k by the conjugate, and INVERSE multiplies input k by it. */
    const float *lane_twiddles;  /* CVOL_FFT_LINES real, then as many imaginary parts */
    const float *batch_twiddles; /* pairs */
} cvol_fft_batch;

/* scratch: cvol_fft_passes_scratch floats, aligned. */
typedef void cvol_fft_batch_run(const cvol_fft_batch *batch, float *scratch);
CVOL_SIMD_DECLARE(void, cvol_fft_run_batch, (const cvol_fft_batch *batch, float *scratch));

/* All passes over one group of lines, one line per lane of a vector (fft_own_passes_simd.c). `data`
 * holds n points, each a vector of real and one of imaginary parts; n / 2 + 1 points for INVERSE;
 * for FORWARD one vector each. Results are in `data` or in `spare`, which is returned. swap:
 * exchanges the parts. */
CVOL_SIMD_DECLARE(float *, cvol_fft_complex_passes,
                  (const cvol_fft_passes *passes, float *data, float *spare, float *chirp,
                   int swap));
CVOL_SIMD_DECLARE(float *, cvol_fft_forward_passes,
                  (const cvol_fft_passes *passes, float *data, float *spare, float *chirp));
CVOL_SIMD_DECLARE(float *, cvol_fft_inverse_passes,
                  (const cvol_fft_passes *passes, float *data, float *spare, float *chirp));

/* ---- one long line (fft_own_line.c) --------------------------------------------------------- */

typedef struct cvol_fft_line cvol_fft_line;

/* The shortest line that is split. */
#define CVOL_FFT_MIN_LINE 128

/* n >= CVOL_FFT_MIN_LINE; real: for FORWARD and INVERSE. NULL without memory. */
cvol_fft_line *cvol_fft_line_create(size_t n, int real);
void cvol_fft_line_free(cvol_fft_line *line);
size_t cvol_fft_line_bytes(const cvol_fft_line *line);
/* A line of adjacent elements, of a complex kind, FORWARD or INVERSE; `out` may be `in` for the
 * complex kinds. scratch: cvol_fft_line_scratch floats, aligned. */
size_t cvol_fft_line_scratch(const cvol_fft_line *line);
void cvol_fft_line_run(const cvol_fft_line *line, cvol_fft_kind kind, float *out, const float *in,
                       float *scratch);

/* The same for DCT, IDCT and IDST with a real line's plan (fft_own_cosine.c). cosines: those of a
 * batch. `out` may be `in`. */
size_t cvol_fft_cosine_line_scratch(const cvol_fft_line *line, size_t n);
void cvol_fft_cosine_line_run(const cvol_fft_line *line, const float *cosines, cvol_fft_kind kind,
                              size_t n, float *out, const float *in, float *scratch);

#endif
