/* Times operations on volumes of N^3 samples in blocks of 16^3 under DCT at 1/30 of the terms, and
 * compares with the classical way with FFTW and, if built with it, zfp's compressed arrays.
 *
 * usage: algebra_blocks SIDE ROUNDS PLANNER KEEP [A.raw B.raw]
 *   PLANNER  estimate, measure: FFTW's, for the classical way
 *   KEEP     rho: 1/30 of the terms; ratio: resident bytes 1/30 of the samples'; codec: a file of
 * 1/30
 *   *.raw    SIDE^3 float32, x fastest; without them two smooth synthetic fields
 *
 * One thread. All programs alternate within each round, with the same inputs in all rounds and
 * caches as the previous one left them. Times of cvol include allocating and freeing the result.
 * Prints one JSON object. PSNR is of the product against that of the samples, over its range.
 */
#define _DEFAULT_SOURCE /* M_PI */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "cvol/algebra.h"
#include "cvol/codec.h"
#include "dense.h"
#include "timing.h"
#ifdef BENCH_ZFP
#include "zfp_multiply.h"
#endif

enum { BLOBS = 48, RATIO = 30 };

typedef struct bench {
    cvol_context *context;
    size_t side, samples;
    float *sample_a, *sample_b, *truth, *work;
    cvol_array *a, *b, *product, *sum;
    dense dense;
    dense_terms dense_a, dense_b, dense_out;
    double truth_range;
} bench;

/* ---- samples --------------------------------------------------------------------------------- */

/* Gaussian blobs of many sizes on a slope: separable, so each blob takes one row per axis. */
static void smooth_field(float *out, size_t side, uint64_t seed)
{
    float *rows = bench_allocate(3 * side * sizeof *rows);
    for (size_t i = 0; i < side * side * side; i++)
        out[i] = 0.5f + 0.5f * (float)(i % side) / (float)side;
    for (int blob = 0; blob < BLOBS; blob++) {
        const double sigma = (double)side * (0.02 + 0.06 * (1 + bench_random(&seed)));
        const float height = (float)bench_random(&seed);
        for (int a = 0; a < 3; a++) {
            const double centre = (double)side * (1 + bench_random(&seed)) / 2;
            for (size_t i = 0; i < side; i++) {
                const double d = ((double)i - centre) / sigma;
                rows[(size_t)a * side + i] = (float)exp(-d * d / 2);
            }
        }
        float *at = out;
        for (size_t z = 0; z < side; z++)
            for (size_t y = 0; y < side; y++, at += side) {
                const float weight = height * rows[side + y] * rows[2 * side + z];
                for (size_t x = 0; x < side; x++)
                    at[x] += weight * rows[x];
            }
    }
    free(rows);
}

static void read_samples(float *out, size_t count, const char *path)
{
    FILE *file = fopen(path, "rb");
    if (!file || fread(out, sizeof *out, count, file) != count)
        bench_fail("%s: not %zu floats", path, count);
    fclose(file);
}

static double psnr(const bench *b, const float *result)
{
    double squares = 0;
    for (size_t i = 0; i < b->samples; i++)
        squares += ((double)result[i] - b->truth[i]) * ((double)result[i] - b->truth[i]);
    return 10 * log10(b->truth_range * b->truth_range * (double)b->samples / squares);
}

/* ---- cvol ------------------------------------------------------------------------------------ */

static cvol_array *compress(bench *b, const float *samples, const char *keep)
{
    const cvol_grid grid = cvol_grid_make(b->side, b->side, b->side, CVOL_FLOAT32);
    cvol_array *array;
    int status;
    if (!strcmp(keep, "codec")) {
        cvol_compress_options options = cvol_compress_options_defaults();
        options.target_value = RATIO;
        status = cvol_compress(b->context, &array, NULL, samples, &grid, &options);
    } else {
        const cvol_keep rule = !strcmp(keep, "ratio") ? cvol_keep_ratio(RATIO)
                                                      : cvol_keep_rho(1.0 / RATIO);
        status = cvol_array_compress(b->context, &array, samples, &grid, 3, CVOL_DCT, 16, &rule);
    }
    bench_check(b->context, status, "compressing");
    return array;
}

static void call_multiply(void *user, int turn)
{
    bench *b = user;
    (void)turn;
    cvol_array_free(b->product);
    b->product = NULL;
    bench_check(
        b->context,
        cvol_array_multiply(b->context, &b->product, b->a, b->b, NULL, CVOL_PLAN_AUTO, NULL),
        "multiplying");
}

static void call_add(void *user, int turn)
{
    bench *b = user;
    (void)turn;
    cvol_array_free(b->sum);
    b->sum = NULL;
    bench_check(b->context, cvol_array_add(b->context, &b->sum, 1, b->a, 1, b->b, NULL), "adding");
}

static void call_statistics(void *user, int turn)
{
    bench *b = user;
    cvol_array_statistics found;
    bench_check(b->context,
                cvol_array_compute_statistics(b->context, &found, turn & 1 ? b->a : b->b),
                "statistics");
}

static void call_inner(void *user, int turn)
{
    bench *b = user;
    double found;
    (void)turn;
    bench_check(b->context, cvol_array_compute_inner_product(b->context, &found, b->a, b->b),
                "inner product");
}

static void call_compare(void *user, int turn)
{
    bench *b = user;
    cvol_array_comparison found;
    (void)turn;
    bench_check(b->context, cvol_array_compare(b->context, &found, b->a, b->b), "comparing");
}

static double cvol_psnr(bench *b, const cvol_array *array)
{
    const size_t begin[3] = {0, 0, 0}, end[3] = {b->side, b->side, b->side};
    bench_check(b->context, cvol_array_evaluate_real(b->context, b->work, array, begin, end),
                "evaluating");
    return psnr(b, b->work);
}

/* ---- the classical way ----------------------------------------------------------------------- */

static void start_dense(bench *b, unsigned planner)
{
    const size_t dims[3] = {b->side, b->side, b->side};
    const size_t k = (size_t)((cbrt((double)b->samples / RATIO) + 1) / 2);
    const size_t low[3] = {k, k, k};
    dense_start(&b->dense, CVOL_DFT, dims, planner);
    dense_low_box(&b->dense_a, &b->dense, low);
    dense_low_box(&b->dense_b, &b->dense, low);
    dense_low_box(&b->dense_out, &b->dense, low);
    memcpy(b->dense.a, b->sample_a, 4 * b->samples);
    dense_analyse(&b->dense, &b->dense_a);
    memcpy(b->dense.a, b->sample_b, 4 * b->samples);
    dense_analyse(&b->dense, &b->dense_b);
}

static void call_dense(void *user, int turn)
{
    bench *b = user;
    (void)turn;
    dense_operate(&b->dense, &b->dense_out, DENSE_MULTIPLY, &b->dense_a, &b->dense_b, 0, NULL);
}

/* ---- zfp ------------------------------------------------------------------------------------- */

#ifdef BENCH_ZFP
static const double zfp_rates[] = {1, 2, 4, 8};
static const char *const zfp_names[ZFP_WAYS] = {"iterators_ms", "indices_ms", "whole_ms"};
enum { ZFP_RATES = sizeof zfp_rates / sizeof *zfp_rates, ZFP_ROUNDS = 2 };

typedef struct zfp_bench {
    zfp_pair *pair;
    int way;
} zfp_bench;

static void call_zfp(void *user, int turn)
{
    const zfp_bench *z = user;
    (void)turn;
    zfp_pair_multiply(z->pair, z->way);
}

/* Element by element, a product takes seconds: fewer rounds. */
static void measure_zfp(bench *b, int rounds)
{
    const size_t dims[3] = {b->side, b->side, b->side};
    printf(",\"zfp\":[");
    for (int r = 0; r < ZFP_RATES; r++) {
        zfp_bench z = {.pair = zfp_pair_make(b->sample_a, b->sample_b, dims, zfp_rates[r])};
        printf("%s{\"rate\":%g", r ? "," : "", zfp_pair_rate(z.pair));
        for (z.way = 0; z.way < ZFP_WAYS; z.way++) {
            bench_times times = {.batch = 1};
            for (int i = 0; i < (rounds < ZFP_ROUNDS ? rounds : ZFP_ROUNDS); i++)
                bench_time(&times, call_zfp, &z);
            bench_print_times(zfp_names[z.way], &times);
        }
        zfp_pair_result(z.pair, b->work);
        printf(",\"psnr_db\":%.2f}", psnr(b, b->work));
        zfp_pair_free(z.pair);
    }
    printf("]");
}
#endif

/* ---- the run --------------------------------------------------------------------------------- */

static void make_samples(bench *b, const char *path_a, const char *path_b)
{
    b->samples = b->side * b->side * b->side;
    b->sample_a = bench_allocate(4 * b->samples);
    b->sample_b = bench_allocate(4 * b->samples);
    b->truth = bench_allocate(4 * b->samples);
    b->work = bench_allocate(4 * b->samples);
    if (path_a) {
        read_samples(b->sample_a, b->samples, path_a);
        read_samples(b->sample_b, b->samples, path_b);
    } else {
        smooth_field(b->sample_a, b->side, 1);
        smooth_field(b->sample_b, b->side, 2);
    }
    float low = INFINITY, high = -INFINITY;
    for (size_t i = 0; i < b->samples; i++) {
        b->truth[i] = b->sample_a[i] * b->sample_b[i];
        low = fminf(low, b->truth[i]);
        high = fmaxf(high, b->truth[i]);
    }
    b->truth_range = (double)high - low;
}

static void print_array(const char *name, const cvol_array *array)
{
    cvol_array_info info;
    cvol_array_get_info(&info, array);
    printf("\"%s\":{\"terms\":%llu,\"resident_bytes\":%llu,\"l2_error\":%.6g},", name,
           (unsigned long long)info.coefficients, (unsigned long long)info.resident_bytes,
           info.l2_error);
}

int main(int count, char **texts)
{
    if (count != 5 && count != 7)
        bench_fail("usage: algebra_blocks SIDE ROUNDS PLANNER KEEP [A.raw B.raw]");
    bench b = {.context = cvol_context_create(), .side = strtoul(texts[1], NULL, 10)};
    const int rounds = atoi(texts[2]);
    if (!b.context || b.side < 16 || b.side > 1024 || rounds < 1 || rounds > BENCH_ROUNDS)
        bench_fail("algebra_blocks: a side of 16 to 1024, 1 to %d rounds", BENCH_ROUNDS);
    cvol_context_set_threads(b.context, 1);
    make_samples(&b, count > 5 ? texts[5] : NULL, count > 5 ? texts[6] : NULL);
    b.a = compress(&b, b.sample_a, texts[4]);
    b.b = compress(&b, b.sample_b, texts[4]);
    start_dense(&b, strcmp(texts[3], "measure") ? FFTW_ESTIMATE : FFTW_MEASURE);

    static const struct {
        const char *name;
        void (*call)(void *, int);
    } measured[] = {{"multiply_ms", call_multiply},     {"add_ms", call_add},
                    {"statistics_ms", call_statistics}, {"inner_ms", call_inner},
                    {"compare_ms", call_compare},       {"dense_ms", call_dense}};
    enum { MEASURED = sizeof measured / sizeof *measured };
    bench_times times[MEASURED] = {{.batch = 0}};
    for (int i = 0; i < MEASURED; i++)
        bench_time(&times[i], measured[i].call, &b);
    for (int round = 0; round < rounds; round++)
        for (int i = 0; i < MEASURED; i++)
            bench_time(&times[i], measured[i].call, &b);

    printf("{");
    print_array("a", b.a);
    print_array("b", b.b);
    print_array("product", b.product);
    dense_synthesise(&b.dense, &b.dense_out);
    printf("\"psnr_db\":%.2f,\"dense_psnr_db\":%.2f", cvol_psnr(&b, b.product),
           psnr(&b, b.dense.a));
    for (int i = 0; i < MEASURED; i++)
        bench_print_times(measured[i].name, &times[i]);
#ifdef BENCH_ZFP
    measure_zfp(&b, rounds);
#endif
    printf("}\n");

    cvol_array_free(b.a);
    cvol_array_free(b.b);
    cvol_array_free(b.product);
    cvol_array_free(b.sum);
    dense_terms_free(&b.dense_a);
    dense_terms_free(&b.dense_b);
    dense_terms_free(&b.dense_out);
    dense_stop(&b.dense);
    free(b.sample_a);
    free(b.sample_b);
    free(b.truth);
    free(b.work);
    cvol_context_free(b.context);
    return 0;
}
