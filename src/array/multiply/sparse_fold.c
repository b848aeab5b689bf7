/* Sampling the product on shifted sub-grids.
 *
 * At the places X = shift + (length / fold) j of the working group, j = 0 .. fold - 1, a polynomial
 * with terms F[u] has the values of a transform of length fold:
 *
 *     a(X_j) = sum_r e(r j / fold) sum_{u = r mod fold} F[u] e(u shift / length)
 *
 * So each operand is folded with a phase ramp and transformed, and the two are multiplied sample by
 * sample. The inverse gives, for each bin, the sum over the product's terms in it of C[w] e(w shift
 * / length). Real arrays: half complex throughout. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "array/multiply/sparse.h"
#include "base/context.h"
#include "base/elementary.h"
#include "base/memory.h"
#include "base/thread.h"
#include "transform/fft.h"

#define PI 3.14159265358979323846

/* ---- roots of unity -------------------------------------------------------------------------- */

int cvol_sparse_roots_make(cvol_context *context, cvol_sparse_roots roots[3],
                           const cvol_sparse_shape *shape)
{
    memset(roots, 0, 3 * sizeof *roots);
    for (int a = 0; a < 3; a++) {
        cvol_sparse_roots *r = &roots[a];
        r->n = shape->length[a];
        while ((size_t)1 << 2 * r->low_bits < r->n)
            r->low_bits++;
        const size_t low = (size_t)1 << r->low_bits, high = (r->n >> r->low_bits) + 1;
        r->low_mask = low - 1;
        r->low = cvol_allocate(2 * low, sizeof *r->low);
        r->high = cvol_allocate(2 * high, sizeof *r->high);
        if (!r->low || !r->high) {
            cvol_sparse_roots_free(roots);
            return cvol_fail_memory(context, 8 * (low + high), "roots of unity");
        }
        const double angle = 2 * PI / (double)r->n;
        for (size_t j = 0; j < low; j++) {
            double root[2];
            cvol_sincos(root, angle * (double)j);
            r->low[2 * j] = (float)root[0];
            r->low[2 * j + 1] = (float)root[1];
        }
        for (size_t j = 0; j < high; j++) {
            double root[2];
            cvol_sincos(root, angle * (double)(j << r->low_bits));
            r->high[2 * j] = (float)root[0];
            r->high[2 * j + 1] = (float)root[1];
        }
    }
    return CVOL_OK;
}

void cvol_sparse_roots_free(cvol_sparse_roots roots[3])
{
    for (int a = 0; a < 3; a++) {
        free(roots[a].low);
        free(roots[a].high);
    }
    memset(roots, 0, 3 * sizeof *roots);
}

/* ---- folding --------------------------------------------------------------------------------- */

size_t cvol_sparse_half(const cvol_sparse_shape *shape)
{
    return 2 * (shape->fold[0] / 2 + 1) * shape->fold[1] * shape->fold[2];
}

/* Adds re + i im to a bin, if the half complex array stores it. */
static inline void add_to_bin(float *half, const size_t bin[3], const size_t fold[3], float re,
                              float im)
{
    if (2 * bin[0] > fold[0])
        return;
    float *at = half + 2 * (bin[0] + (fold[0] / 2 + 1) * (bin[1] + fold[1] * bin[2]));
    at[0] += re;
    at[1] += im;
}

static void fold_terms(float *half, const cvol_sparse_shape *shape,
                       const cvol_sparse_roots roots[3], const cvol_sparse_terms *terms,
                       const size_t shift[3])
{
    const size_t *fold = shape->fold;
    memset(half, 0, cvol_sparse_half(shape) * sizeof *half);
    for (size_t i = 0; i < terms->count; i++) {
        const cvol_sparse_term *term = &terms->terms[i];
        const size_t at[3] = {term->at[0], term->at[1], term->at[2]};
        float x, y;
        cvol_sparse_phase(roots, at, shift, &x, &y);
        const float re = term->re * x - term->im * y, im = term->re * y + term->im * x;
        size_t bin[3], mirror[3];
        for (int a = 0; a < 3; a++) {
            bin[a] = fold[a] == 1 ? 0 : at[a] % fold[a];
            mirror[a] = bin[a] ? fold[a] - bin[a] : 0;
        }
        add_to_bin(half, bin, fold, re, im);
        if (!term->alone)
            add_to_bin(half, mirror, fold, re, -im);
    }
}

/* The effect of rounding on the product of two samplings, as an L2 norm, from their norms and their
 * largest samples. */
typedef struct sampling {
    double norm_a, norm_b, norm, largest_a, largest_b;
} sampling;

/* a times b into a. Sums in double over short runs: fast, and the same on every processor. */
static sampling multiply_samples(float *a, const float *b, size_t count)
{
    double sums[3] = {0, 0, 0};
    float largest[2] = {0, 0};
    for (size_t begin = 0; begin < count; begin += 256) {
        const size_t end = begin + 256 < count ? begin + 256 : count;
        float run[3][16] = {{0}}, top[2][16] = {{0}};
        for (size_t i = begin; i < end; i++) {
            const float x = a[i], y = b[i], z = x * y;
            const size_t lane = i & 15;
            run[0][lane] += x * x;
            run[1][lane] += y * y;
            run[2][lane] += z * z;
            top[0][lane] = fabsf(x) > top[0][lane] ? fabsf(x) : top[0][lane];
            top[1][lane] = fabsf(y) > top[1][lane] ? fabsf(y) : top[1][lane];
            a[i] = z;
        }
        for (int lane = 0; lane < 16; lane++) {
            for (int k = 0; k < 3; k++)
                sums[k] += (double)run[k][lane];
            for (int k = 0; k < 2; k++)
                largest[k] = top[k][lane] > largest[k] ? top[k][lane] : largest[k];
        }
    }
    return (sampling){.norm_a = sqrt(sums[0]),
                      .norm_b = sqrt(sums[1]),
                      .norm = sqrt(sums[2]),
                      .largest_a = (double)largest[0],
                      .largest_b = (double)largest[1]};
}

/* One shift; work[2]: samples of the operands. */
static int fold_one(cvol_context *context, float *values, double *noise,
                    const cvol_sparse_shape *shape, const cvol_sparse_roots roots[3],
                    const cvol_sparse_terms *a, const cvol_sparse_terms *b, size_t s,
                    float *const work[2])
{
    int rc = CVOL_OK;
    const cvol_sparse_terms *operands[2] = {a, b};
    const int square = a == b;
    for (int k = 0; k < 2 - square && !rc; k++) {
        fold_terms(values, shape, roots, operands[k], shape->shifts[s]);
        rc = cvol_fft(context, CVOL_FFT_INVERSE, shape->fold, work[k], values);
    }
    if (rc)
        return rc;
    const sampling of = multiply_samples(work[0], work[!square], shape->bins);
    rc = cvol_fft(context, CVOL_FFT_FORWARD, shape->fold, values, work[0]);
    /* C = P / sqrt N, and the inverse transform multiplies by the number of bins. */
    const double N = (double)shape->dims[0] * (double)shape->dims[1] * (double)shape->dims[2];
    const double scale = 1 / (sqrt(N) * (double)shape->bins);
    const float factor = (float)scale;
    const size_t count = cvol_sparse_half(shape);
    for (size_t i = 0; i < count; i++)
        values[i] *= factor;
    *noise = CVOL_ROUNDING * scale * sqrt((double)shape->bins) *
             (of.norm + of.largest_a * of.norm_b + of.largest_b * of.norm_a);
    return rc;
}

int cvol_sparse_fold(cvol_context *context, float *const *values, double *noise,
                     const cvol_sparse_shape *shape, const cvol_sparse_roots roots[3],
                     const cvol_sparse_terms *a, const cvol_sparse_terms *b)
{
    int rc = CVOL_OK, threads = cvol_context_threads(context);
    double each[CVOL_SPARSE_SHIFTS] = {0};
    threads = threads < (int)shape->shift_count ? threads : (int)shape->shift_count;
    float **work = cvol_allocate_zero(2 * (size_t)threads, sizeof *work);
    for (int k = 0; work && k < 2 * threads; k++) {
        work[k] = cvol_fft_allocate(shape->bins);
        if (!work[k])
            rc = CVOL_ERROR_MEMORY;
    }
    if (!work || rc) {
        rc = cvol_fail_memory(context, 2 * (size_t)threads * shape->bins * sizeof(float),
                              "samples of the operands");
        goto done;
    }
    /* The first shift runs alone: it makes the transforms' plans and reports their errors. */
    rc = fold_one(context, values[0], &each[0], shape, roots, a, b, 0, work);
    if (rc)
        goto done;
    rc = cvol_report_progress(context, "multiplying", 1.0 / (double)(shape->shift_count + 1));
    if (rc)
        goto done;
    int failed = 0;
#pragma omp parallel for num_threads(threads) schedule(dynamic) reduction(| : failed)
    for (size_t s = 1; s < shape->shift_count; s++) {
        cvol_context own = *context; /* two threads may fail at once */
        failed |= fold_one(&own, values[s], &each[s], shape, roots, a, b, s,
                           work + 2 * cvol_thread_index()) != CVOL_OK;
    }
    if (failed)
        rc = cvol_fail_memory(context, shape->bins * sizeof(float), "transforms of the folds");
    double sum = 0;
    for (size_t s = 0; s < shape->shift_count; s++)
        sum += each[s] * each[s];
    *noise = sqrt(sum);
done:
    for (int k = 0; work && k < 2 * threads; k++)
        free(work[k]);
    free(work);
    return rc;
}
