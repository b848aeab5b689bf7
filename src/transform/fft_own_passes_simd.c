/* The passes of fft_own.h over one group of lines, a line in each lane of its vectors. */
#include "base/vector.h"
#include "transform/fft_own.h"

/* A complex number for each line. */
typedef struct point {
    cvol_vf re, im;
} point;

CVOL_INLINE point add(point a, point b)
{
    return (point){a.re + b.re, a.im + b.im};
}

CVOL_INLINE point subtract(point a, point b)
{
    return (point){a.re - b.re, a.im - b.im};
}

/* a + i b, a - i b */
CVOL_INLINE point add_turned(point a, point b)
{
    return (point){a.re - b.im, a.im + b.re};
}

CVOL_INLINE point subtract_turned(point a, point b)
{
    return (point){a.re + b.im, a.im - b.re};
}

CVOL_INLINE point scale(point a, float factor)
{
    return (point){a.re * factor, a.im * factor};
}

/* a w, and a conj(w) */
CVOL_INLINE point times(point a, const float w[2])
{
    return (point){a.re * w[0] - a.im * w[1], a.re * w[1] + a.im * w[0]};
}

CVOL_INLINE point times_conjugate(point a, const float w[2])
{
    return (point){a.re * w[0] + a.im * w[1], a.im * w[0] - a.re * w[1]};
}

/* swap: the parts exchanged in memory. */
CVOL_INLINE point load(const float *from, int swap)
{
    return (point){cvol_load(from + swap * CVOL_LANES), cvol_load(from + (1 - swap) * CVOL_LANES)};
}

CVOL_INLINE void store(float *to, point a, int swap)
{
    cvol_store(to + swap * CVOL_LANES, a.re);
    cvol_store(to + (1 - swap) * CVOL_LANES, a.im);
}

/* The place of point i of a buffer. */
CVOL_INLINE size_t place(size_t i)
{
    return 2 * CVOL_LANES * i;
}

/* ---- sums of a few points: X[u] = sum_j x[j] exp(-2 pi i u j / radix) ----------------------- */

CVOL_INLINE void sums_of_2(point *a, point *b)
{
    const point sum = add(*a, *b);
    *b = subtract(*a, *b);
    *a = sum;
}

CVOL_INLINE void sums_of_3(point *x)
{
    const point sum = add(x[1], x[2]), difference = subtract(x[1], x[2]);
    const point middle = subtract(x[0], scale(sum, 0.5F)),
                side = scale(difference, 0.866025403784438647F);
    x[0] = add(x[0], sum);
    x[1] = subtract_turned(middle, side);
    x[2] = add_turned(middle, side);
}

CVOL_INLINE void sums_of_4(point *a, point *b, point *c, point *d)
{
    const point even = add(*a, *c), even_difference = subtract(*a, *c);
    const point odd = add(*b, *d), odd_difference = subtract(*b, *d);
    *a = add(even, odd);
    *b = subtract_turned(even_difference, odd_difference);
    *c = subtract(even, odd);
    *d = add_turned(even_difference, odd_difference);
}

CVOL_INLINE void sums_of_5(point *x)
{
    const float c1 = 0.309016994374947424F, c2 = -0.809016994374947424F;
    const float s1 = 0.951056516295153572F, s2 = 0.587785252292473129F;
    const point a1 = add(x[1], x[4]), b1 = subtract(x[1], x[4]);
    const point a2 = add(x[2], x[3]), b2 = subtract(x[2], x[3]);
    const point p1 = add(add(x[0], scale(a1, c1)), scale(a2, c2));
    const point p2 = add(add(x[0], scale(a1, c2)), scale(a2, c1));
    const point q1 = add(scale(b1, s1), scale(b2, s2)), q2 = subtract(scale(b1, s2), scale(b2, s1));
    x[0] = add(add(x[0], a1), a2);
    x[1] = subtract_turned(p1, q1);
    x[2] = subtract_turned(p2, q2);
    x[3] = add_turned(p2, q2);
    x[4] = add_turned(p1, q1);
}

CVOL_INLINE point weighted(point a1, point a2, point a3, float w1, float w2, float w3)
{
    return add(add(scale(a1, w1), scale(a2, w2)), scale(a3, w3));
}

CVOL_INLINE void sums_of_7(point *x)
{
    const float c1 = 0.623489801858733531F, c2 = -0.222520933956314404F,
                c3 = -0.900968867902419126F;
    const float s1 = 0.781831482468029809F, s2 = 0.974927912181823607F, s3 = 0.433883739117558120F;
    const point a1 = add(x[1], x[6]), b1 = subtract(x[1], x[6]);
    const point a2 = add(x[2], x[5]), b2 = subtract(x[2], x[5]);
    const point a3 = add(x[3], x[4]), b3 = subtract(x[3], x[4]);
    const point p1 = add(x[0], weighted(a1, a2, a3, c1, c2, c3));
    const point p2 = add(x[0], weighted(a1, a2, a3, c2, c3, c1));
    const point p3 = add(x[0], weighted(a1, a2, a3, c3, c1, c2));
    const point q1 = weighted(b1, b2, b3, s1, s2, s3);
    const point q2 = weighted(b1, b2, b3, s2, -s3, -s1);
    const point q3 = weighted(b1, b2, b3, s3, -s1, s2);
    x[0] = add(add(x[0], a1), add(a2, a3));
    x[1] = subtract_turned(p1, q1);
    x[2] = subtract_turned(p2, q2);
    x[3] = subtract_turned(p3, q3);
    x[4] = add_turned(p3, q3);
    x[5] = add_turned(p2, q2);
    x[6] = add_turned(p1, q1);
}

CVOL_INLINE void sums_of_8(point *x)
{
    const float half = 0.707106781186547524F;
    sums_of_4(&x[0], &x[2], &x[4], &x[6]);
    sums_of_4(&x[1], &x[3], &x[5], &x[7]);
    const point e1 = x[2], e2 = x[4], e3 = x[6], o2 = x[5];
    const point o1 = {(x[3].re + x[3].im) * half, (x[3].im - x[3].re) * half};
    const point o3 = {(x[7].im - x[7].re) * half, (x[7].re + x[7].im) * half}; /* times -1 */
    const point e0 = x[0], o0 = x[1];
    x[0] = add(e0, o0);
    x[4] = subtract(e0, o0);
    x[1] = add(e1, o1);
    x[5] = subtract(e1, o1);
    x[2] = subtract_turned(e2, o2);
    x[6] = add_turned(e2, o2);
    x[3] = (point){e3.re + o3.re, e3.im - o3.im};
    x[7] = (point){e3.re - o3.re, e3.im + o3.im};
}

CVOL_INLINE void sums_of(point *x, int radix)
{
    switch (radix) {
    case 2:
        sums_of_2(&x[0], &x[1]);
        break;
    case 3:
        sums_of_3(x);
        break;
    case 4:
        sums_of_4(&x[0], &x[1], &x[2], &x[3]);
        break;
    case 5:
        sums_of_5(x);
        break;
    case 7:
        sums_of_7(x);
        break;
    default:
        sums_of_8(x);
    }
}

/* ---- sums of prime length, in memory -------------------------------------------------------- */

/* Two frequencies of a sum at once: cosines of sums and sines of differences of mirrored points. */
CVOL_INLINE void add_waves(point *out, const point *x, size_t p, const float *waves, size_t u,
                           int frequencies)
{
    const size_t half = p / 2;
    const point zero = {(cvol_vf){0}, (cvol_vf){0}};
    point even[2] = {x[0], x[0]}, odd[2] = {zero, zero};
    for (size_t j = 1; j <= half; j++)
        for (int f = 0; f < frequencies; f++) {
            const float *wave = waves + 2 * ((u - 1 + (size_t)f) * half + j - 1);
            even[f] = add(even[f], scale(x[j], wave[0]));
            odd[f] = add(odd[f], scale(x[p - j], wave[1]));
        }
    for (int f = 0; f < frequencies; f++) {
        out[u + (size_t)f] = subtract_turned(even[f], odd[f]);
        out[p - u - (size_t)f] = add_turned(even[f], odd[f]);
    }
}

/* Overwrites x. */
static void prime_sums(point *out, point *x, size_t p, const float *waves)
{
    out[0] = x[0];
    for (size_t j = 1; j <= p / 2; j++) {
        sums_of_2(&x[j], &x[p - j]);
        out[0] = add(out[0], x[j]);
    }
    size_t u = 1;
    for (; u + 1 <= p / 2; u += 2)
        add_waves(out, x, p, waves, u, 2);
    if (u <= p / 2)
        add_waves(out, x, p, waves, u, 1);
}

float *CVOL_SIMD(cvol_fft_complex_passes)(const cvol_fft_passes *passes, float *data, float *spare,
                                          float *chirp, int swap);

/* Works in `work`, which has room for two convolutions; returns the place of the p sums. */
static float *chirp_sums(const cvol_fft_chirp *chirp, size_t p, float *work)
{
    const size_t M = chirp->convolution->n;
    for (size_t j = 0; j < M; j++) {
        const point zero = {(cvol_vf){0}, (cvol_vf){0}};
        store(work + place(j), j < p ? times(load(work + place(j), 0), chirp->chirp + 2 * j) : zero,
              0);
    }
    float *spectrum = CVOL_SIMD(cvol_fft_complex_passes)(chirp->convolution, work, work + place(M),
                                                         NULL, 0);
    for (size_t u = 0; u < M; u++)
        store(spectrum + place(u), times(load(spectrum + place(u), 0), chirp->spectrum + 2 * u), 0);
    float *sums = CVOL_SIMD(cvol_fft_complex_passes)(
        chirp->convolution, spectrum, spectrum == work ? work + place(M) : work, NULL, 1);
    for (size_t u = 0; u < p; u++)
        store(sums + place(u), times(load(sums + place(u), 0), chirp->chirp + 2 * u), 0);
    return sums;
}

/* ---- where a pass reads and writes -------------------------------------------------------------
 *
 * Passes are of complex lines, of real lines to half spectra, and back. FIRST and LAST are those
 * that begin and end with real numbers, before = 1. */
typedef enum direction { COMPLEX, FORWARD, FORWARD_FIRST, INVERSE, INVERSE_LAST } direction;

/* Row k of a pass: `radix` sub-transforms at frequency k, and the sums, of frequencies k + before
 * u, each of `after` adjacent points. */
typedef struct row {
    const cvol_fft_pass *pass;
    direction way;
    size_t radix;
    int swap;             /* complex lines: the parts exchanged */
    size_t sub, sub_step; /* floats to sub-transform 0, and from one to the next */
    size_t sum, sum_step; /* the same for sums */
    size_t mirror;        /* to the mirror image of sum 0, if there is one */
    int is_turned;        /* row 0 has no twiddle factors */
    const float *twiddles;
} row;

CVOL_INLINE row row_of(const cvol_fft_pass *pass, direction way, size_t k, size_t radix, int swap)
{
    const int real = way == FORWARD_FIRST || way == INVERSE_LAST;
    return (row){.pass = pass,
                 .way = way,
                 .radix = radix,
                 .swap = swap,
                 .sub = k * radix * place(pass->after),
                 .sub_step = place(pass->after) / (real ? 2 : 1),
                 .sum = k * place(pass->after),
                 .sum_step = pass->before * place(pass->after),
                 .mirror = (pass->before * radix - k) * place(pass->after),
                 .is_turned = k > 0,
                 .twiddles = pass->twiddles + 2 * k * (radix - 1)};
}

CVOL_INLINE point conjugate(point a)
{
    return (point){a.re, -a.im};
}

/* Tests if sum u of a real line is in the lower half of its spectrum. The others are the conjugates
 * of their mirror images, which are stored. */
CVOL_INLINE int is_lower(size_t u, size_t radix)
{
    return u < (radix + 1) / 2;
}

/* Point j of the summed points, for the q-th sum. A sum with exp(+...) is one with exchanged
 * parts. */
CVOL_INLINE point fetch(const float *in, const row *of, size_t j, size_t q)
{
    if (of->way == FORWARD_FIRST)
        return (point){cvol_load(in + j * of->sub_step + q * CVOL_LANES), (cvol_vf){0}};
    if (of->way == INVERSE || of->way == INVERSE_LAST) {
        const point a = is_lower(j, of->radix)
                            ? load(in + of->sum + j * of->sum_step + place(q), 0)
                            : conjugate(load(in + of->mirror - j * of->sum_step + place(q), 0));
        return (point){a.im, a.re};
    }
    const point a = load(in + of->sub + j * of->sub_step + place(q), of->swap);
    return of->is_turned && j ? times(a, of->twiddles + 2 * (j - 1)) : a;
}

CVOL_INLINE void deliver(float *out, const row *of, size_t u, size_t q, point a)
{
    if (of->way == COMPLEX) {
        store(out + of->sum + u * of->sum_step + place(q), a, of->swap);
    } else if (of->way == INVERSE_LAST) {
        cvol_store(out + u * of->sub_step + q * CVOL_LANES, a.im);
    } else if (of->way == INVERSE) {
        const point b = {a.im, a.re};
        store(out + of->sub + u * of->sub_step + place(q),
              of->is_turned && u ? times_conjugate(b, of->twiddles + 2 * (u - 1)) : b, 0);
    } else if (is_lower(u, of->radix)) {
        store(out + of->sum + u * of->sum_step + place(q), a, 0);
    } else {
        store(out + of->mirror - u * of->sum_step + place(q), conjugate(a), 0);
    }
}

/* ---- passes --------------------------------------------------------------------------------- */

CVOL_INLINE void pass_row(float *restrict out, const float *restrict in, const row *of, int radix)
{
    const size_t after = of->pass->after;
    for (size_t q = 0; q < after; q++) {
        point x[8];
#pragma GCC unroll 8
        for (int j = 0; j < radix; j++)
            x[j] = fetch(in, of, (size_t)j, q);
        sums_of(x, radix);
#pragma GCC unroll 8
        for (int u = 0; u < radix; u++)
            deliver(out, of, (size_t)u, q, x[u]);
    }
}

/* Rows k of a pass. */
CVOL_INLINE size_t row_count(const cvol_fft_pass *pass, direction way)
{
    return way == COMPLEX ? pass->before : pass->before / 2 + 1;
}

CVOL_INLINE void pass_of(float *out, const float *in, const cvol_fft_pass *pass, direction way,
                         int radix, int swap)
{
    const size_t rows = row_count(pass, way);
    row of = row_of(pass, way, 0, (size_t)radix, swap);
    of.is_turned = 0;
    pass_row(out, in, &of, radix);
    for (size_t k = 1; k < rows; k++) {
        of = row_of(pass, way, k, (size_t)radix, swap);
        of.is_turned = 1;
        pass_row(out, in, &of, radix);
    }
}

CVOL_INLINE void prime_pass(float *out, const float *in, const cvol_fft_pass *pass, direction way,
                            float *work, int swap)
{
    const size_t rows = row_count(pass, way), p = pass->radix;
    point x[CVOL_FFT_MAX_RADIX], sums[CVOL_FFT_MAX_RADIX];
    for (size_t k = 0; k < rows; k++) {
        const row of = row_of(pass, way, k, p, swap);
        for (size_t q = 0; q < pass->after; q++) {
            if (!pass->chirp) {
                for (size_t j = 0; j < p; j++)
                    x[j] = fetch(in, &of, j, q);
                prime_sums(sums, x, p, pass->waves);
                for (size_t u = 0; u < p; u++)
                    deliver(out, &of, u, q, sums[u]);
                continue;
            }
            for (size_t j = 0; j < p; j++)
                store(work + place(j), fetch(in, &of, j, q), 0);
            const float *found = chirp_sums(pass->chirp, p, work);
            for (size_t u = 0; u < p; u++)
                deliver(out, &of, u, q, load(found + place(u), 0));
        }
    }
}

CVOL_INLINE void any_pass(float *out, const float *in, const cvol_fft_pass *pass, direction way,
                          float *work, int swap)
{
    switch (pass->radix) {
    case 2:
        pass_of(out, in, pass, way, 2, swap);
        break;
    case 3:
        pass_of(out, in, pass, way, 3, swap);
        break;
    case 4:
        pass_of(out, in, pass, way, 4, swap);
        break;
    case 5:
        pass_of(out, in, pass, way, 5, swap);
        break;
    case 7:
        pass_of(out, in, pass, way, 7, swap);
        break;
    case 8:
        pass_of(out, in, pass, way, 8, swap);
        break;
    default:
        prime_pass(out, in, pass, way, work, swap);
    }
}

float *CVOL_SIMD(cvol_fft_complex_passes)(const cvol_fft_passes *passes, float *data, float *spare,
                                          float *chirp, int swap)
{
    for (int i = 0; i < passes->count; i++) {
        any_pass(spare, data, &passes->pass[i], COMPLEX, chirp, swap);
        float *const other = data;
        data = spare;
        spare = other;
    }
    return data;
}

float *CVOL_SIMD(cvol_fft_forward_passes)(const cvol_fft_passes *passes, float *data, float *spare,
                                          float *chirp)
{
    if (!passes->count)
        cvol_store(data + CVOL_LANES, (cvol_vf){0});
    for (int i = 0; i < passes->count; i++) {
        if (i)
            any_pass(spare, data, &passes->pass[i], FORWARD, chirp, 0);
        else
            any_pass(spare, data, &passes->pass[i], FORWARD_FIRST, chirp, 0);
        float *const other = data;
        data = spare;
        spare = other;
    }
    return data;
}

float *CVOL_SIMD(cvol_fft_inverse_passes)(const cvol_fft_passes *passes, float *data, float *spare,
                                          float *chirp)
{
    for (int i = passes->count - 1; i >= 0; i--) {
        if (i)
            any_pass(spare, data, &passes->pass[i], INVERSE, chirp, 0);
        else
            any_pass(spare, data, &passes->pass[i], INVERSE_LAST, chirp, 0);
        float *const other = data;
        data = spare;
        spare = other;
    }
    return data;
}
