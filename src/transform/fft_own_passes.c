/* The passes of a length: its radices, the twiddle factors between them, and the tables of prime
 * radices (fft_own.h). */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/elementary.h"
#include "base/memory.h"
#include "transform/fft_own.h"

#define PI 3.14159265358979323846

/* exp(-2 pi i k / n) from an angle of at most 1/8 turn, where cos and sin are the most accurate. */
void cvol_fft_root(float out[2], size_t k, size_t n)
{
    k %= n;
    const size_t eighth = (size_t)((double)k * 8 / (double)n); /* a rounded value is sufficient */
    const size_t quarter = (eighth + 1) / 2;                   /* the nearest, 0 .. 4 */
    const double angle = 2 * PI * ((double)k - (double)quarter * (double)n / 4) / (double)n;
    double at[2];
    cvol_sincos(at, angle);
    const float c = (float)at[0], s = (float)at[1];
    const float re[4] = {c, -s, -c, s}, im[4] = {-s, -c, s, c};
    out[0] = re[quarter % 4];
    out[1] = im[quarter % 4];
}

/* ---- radices -------------------------------------------------------------------------------- */

static void add_pass(cvol_fft_passes *passes, size_t radix)
{
    passes->pass[passes->count++].radix = radix;
}

/* Powers of two: as many 8s as possible without a single 2 left. */
static void add_powers_of_two(cvol_fft_passes *passes, int twos)
{
    if (twos == 1)
        add_pass(passes, 2);
    int fours = twos % 3 == 1 ? 2 : twos % 3 == 2 ? 1 : 0;
    for (int i = 0; twos > 1 && i < (twos - 2 * fours) / 3; i++)
        add_pass(passes, 8);
    for (int i = 0; twos > 1 && i < fours; i++)
        add_pass(passes, 4);
}

static int descending(const void *a, const void *b)
{
    const size_t x = ((const cvol_fft_pass *)a)->radix, y = ((const cvol_fft_pass *)b)->radix;
    return (x < y) - (x > y);
}

/* The largest prime first, where there are no twiddle factors; powers of two last. */
static void factorize(cvol_fft_passes *passes)
{
    size_t n = passes->n;
    int twos = 0;
    for (; n % 2 == 0; n /= 2)
        twos++;
    for (size_t p = 3; n > 1; p += 2) {
        p = p * p > n ? n : p;
        for (; n % p == 0; n /= p)
            add_pass(passes, p);
    }
    qsort(passes->pass, (size_t)passes->count, sizeof *passes->pass, descending);
    add_powers_of_two(passes, twos);
    size_t before = 1;
    for (int i = 0; i < passes->count; i++) {
        cvol_fft_pass *pass = &passes->pass[i];
        pass->before = before;
        before *= pass->radix;
        pass->after = passes->n / before;
    }
}

/* ---- tables --------------------------------------------------------------------------------- */

static int is_summed(const cvol_fft_pass *pass)
{
    return pass->radix > 8 && pass->radix <= CVOL_FFT_MAX_RADIX;
}

static size_t twiddle_floats(const cvol_fft_pass *pass)
{
    return 2 * pass->before * (pass->radix - 1);
}

static size_t wave_floats(const cvol_fft_pass *pass)
{
    return is_summed(pass) ? 2 * (pass->radix / 2) * (pass->radix / 2) : 0;
}

static size_t table_floats(const cvol_fft_passes *passes)
{
    size_t floats = 0;
    for (int i = 0; i < passes->count; i++)
        floats += twiddle_floats(&passes->pass[i]) + wave_floats(&passes->pass[i]);
    return floats;
}

static void fill_tables(cvol_fft_pass *pass, float *at)
{
    const size_t radix = pass->radix, n = radix * pass->before;
    pass->twiddles = at;
    for (size_t k = 0; k < pass->before; k++)
        for (size_t j = 1; j < radix; j++, at += 2)
            cvol_fft_root(at, j * k, n);
    pass->waves = at;
    for (size_t u = 1; is_summed(pass) && u <= radix / 2; u++)
        for (size_t j = 1; j <= radix / 2; j++, at += 2) {
            cvol_fft_root(at, u * j, radix);
            at[1] = -at[1];
        }
}

/* ---- large primes --------------------------------------------------------------------------- */

static void free_chirp(cvol_fft_chirp *chirp)
{
    if (!chirp)
        return;
    cvol_fft_passes_free(chirp->convolution);
    free(chirp->chirp);
    free(chirp->spectrum);
    free(chirp);
}

/* The spectrum of the chirp's conjugate, which is its own mirror, in one lane of a batch. */
static int fill_spectrum(cvol_fft_chirp *chirp, size_t p)
{
    const size_t M = chirp->convolution->n;
    float *scratch = cvol_fft_allocate(cvol_fft_passes_scratch(chirp->convolution));
    if (!scratch)
        return 0;
    memset(chirp->spectrum, 0, 2 * M * sizeof *chirp->spectrum);
    for (size_t j = 0; j < p; j++) {
        const float re = chirp->chirp[2 * j] / (float)M, im = -chirp->chirp[2 * j + 1] / (float)M;
        float *at = chirp->spectrum + 2 * j, *mirror = chirp->spectrum + 2 * ((M - j) % M);
        at[0] = mirror[0] = re;
        at[1] = mirror[1] = im;
    }
    const cvol_fft_batch batch = {.passes = chirp->convolution,
                                  .kind = CVOL_FFT_COMPLEX_FORWARD,
                                  .lines = 1,
                                  .in = chirp->spectrum,
                                  .out = chirp->spectrum,
                                  .from = {.access = CVOL_FFT_ROWS, .stride = 2},
                                  .to = {.access = CVOL_FFT_ROWS, .stride = 2}};
    CVOL_SIMD_CHOOSE(cvol_fft_run_batch)(&batch, scratch);
    free(scratch);
    return 1;
}

static cvol_fft_chirp *make_chirp(size_t p)
{
    cvol_fft_chirp *chirp = calloc(1, sizeof *chirp);
    if (!chirp)
        return NULL;
    const size_t M = cvol_fft_good_length(2 * p - 1, 0);
    chirp->convolution = cvol_fft_passes_create(M);
    chirp->chirp = cvol_fft_allocate(2 * p);
    chirp->spectrum = cvol_fft_allocate(2 * M);
    int made = chirp->convolution && chirp->chirp && chirp->spectrum;
    for (size_t j = 0; made && j < p; j++)
        cvol_fft_root(chirp->chirp + 2 * j, j * j % (2 * p), 2 * p);
    if (made && fill_spectrum(chirp, p))
        return chirp;
    free_chirp(chirp);
    return NULL;
}

static int make_chirps(cvol_fft_passes *passes)
{
    for (int i = 0; i < passes->count; i++) {
        cvol_fft_pass *pass = &passes->pass[i];
        if (pass->radix <= CVOL_FFT_MAX_RADIX)
            continue;
        pass->chirp = make_chirp(pass->radix);
        if (!pass->chirp)
            return 0;
        if (pass->chirp->convolution->n > passes->chirp_points)
            passes->chirp_points = pass->chirp->convolution->n;
    }
    return 1;
}

/* ---- plans ---------------------------------------------------------------------------------- */

cvol_fft_passes *cvol_fft_passes_create(size_t n)
{
    cvol_fft_passes *passes = calloc(1, sizeof *passes);
    if (!passes)
        return NULL;
    passes->n = n;
    factorize(passes);
    passes->tables = cvol_fft_allocate(table_floats(passes));
    float *at = passes->tables;
    for (int i = 0; at && i < passes->count; i++) {
        fill_tables(&passes->pass[i], at);
        at += twiddle_floats(&passes->pass[i]) + wave_floats(&passes->pass[i]);
    }
    if (at && make_chirps(passes))
        return passes;
    cvol_fft_passes_free(passes);
    return NULL;
}

void cvol_fft_passes_free(cvol_fft_passes *passes)
{
    if (!passes)
        return;
    for (int i = 0; i < passes->count; i++)
        free_chirp(passes->pass[i].chirp);
    free(passes->tables);
    free(passes);
}

size_t cvol_fft_passes_bytes(const cvol_fft_passes *passes)
{
    size_t bytes = sizeof *passes + table_floats(passes) * sizeof(float);
    for (int i = 0; i < passes->count; i++)
        if (passes->pass[i].chirp)
            bytes += cvol_fft_passes_bytes(passes->pass[i].chirp->convolution) +
                     2 * (passes->pass[i].radix + passes->chirp_points) * sizeof(float);
    return bytes;
}

/* Data and spare memory of all lines, one group's convolution with its spare memory. */
size_t cvol_fft_passes_scratch(const cvol_fft_passes *passes)
{
    return CVOL_FFT_LINES * (4 * passes->n + 4 * passes->chirp_points + 8);
}
