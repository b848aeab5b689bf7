/* Times transforms of whole arrays, cvol's (src/transform/fft.h) and FFTW's, alternately.
 *
 * usage: algebra_transforms [ROUNDS [DIMS...]]     DIMS 1048576, 256x256, 64x64x64, ...
 *
 * Prints one line for each shape and kind: the least processor time of a call in milliseconds.
 * FFTW's plans are made by estimate, beforehand. DCT, IDCT and the complex kinds work in place.
 */
#include <fftw3.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "timing.h"
#include "transform/fft.h"

typedef struct bench {
    cvol_context *context;
    cvol_fft_kind kind;
    size_t dims[3], floats;
    float *samples, *in, *out;
    fftwf_plan plan;
} bench;

static const struct {
    const char *name;
    cvol_fft_kind kind;
} kinds[] = {{"forward", CVOL_FFT_FORWARD},
             {"inverse", CVOL_FFT_INVERSE},
             {"dct", CVOL_FFT_DCT},
             {"idct", CVOL_FFT_IDCT},
             {"complex", CVOL_FFT_COMPLEX_FORWARD}};

/* Unnormalised transforms of their own results would overflow. */
static void refill(bench *b, int turn)
{
    if (turn % 4 == 0)
        memcpy(b->in, b->samples, b->floats * sizeof *b->in);
}

static void call_cvol(void *user, int turn)
{
    bench *b = user;
    refill(b, turn);
    bench_check(b->context, cvol_fft(b->context, b->kind, b->dims, b->out, b->in), "cvol");
}

static void call_fftw(void *user, int turn)
{
    bench *b = user;
    refill(b, turn);
    fftwf_execute(b->plan);
}

static void make_plan(bench *b)
{
    int rank = 0, n[3] = {1, 1, 1};
    for (int a = 2; a >= 0; a--)
        if (b->dims[a] > 1)
            n[rank++] = (int)b->dims[a];
    fftwf_complex *in = (fftwf_complex *)b->in, *out = (fftwf_complex *)b->out;
    const fftwf_r2r_kind kind = b->kind == CVOL_FFT_DCT ? FFTW_REDFT10 : FFTW_REDFT01;
    const fftwf_r2r_kind real[3] = {kind, kind, kind};
    switch (b->kind) {
    case CVOL_FFT_FORWARD:
        b->plan = fftwf_plan_dft_r2c(rank, n, b->in, out, FFTW_ESTIMATE);
        break;
    case CVOL_FFT_INVERSE:
        b->plan = fftwf_plan_dft_c2r(rank, n, in, b->out, FFTW_ESTIMATE | FFTW_DESTROY_INPUT);
        break;
    case CVOL_FFT_COMPLEX_FORWARD:
        b->plan = fftwf_plan_dft(rank, n, in, out, FFTW_FORWARD, FFTW_ESTIMATE);
        break;
    default:
        b->plan = fftwf_plan_r2r(rank, n, b->in, b->out, real, FFTW_ESTIMATE);
    }
    if (!b->plan)
        bench_fail("FFTW has no plan");
}

static double least(const bench_times *times)
{
    double least = times->ms[0];
    for (int i = 1; i < times->count; i++)
        least = times->ms[i] < least ? times->ms[i] : least;
    return least;
}

static void measure(cvol_context *context, const size_t dims[3], size_t k, int rounds)
{
    bench b = {.context = context,
               .kind = kinds[k].kind,
               .dims = {dims[0], dims[1], dims[2]},
               .floats = 2 * (dims[0] + 2) * dims[1] * dims[2]};
    uint64_t seed = 1;
    b.samples = bench_allocate(b.floats * sizeof(float));
    b.in = bench_allocate(b.floats * sizeof(float));
    b.out = b.kind == CVOL_FFT_FORWARD || b.kind == CVOL_FFT_INVERSE
                ? bench_allocate(b.floats * sizeof(float))
                : b.in;
    for (size_t i = 0; i < b.floats; i++)
        b.samples[i] = (float)bench_random(&seed);
    make_plan(&b);
    bench_times cvol = {.batch = 0}, fftw = {.batch = 0};
    for (int round = 0; round <= rounds; round++) {
        bench_time(&cvol, call_cvol, &b);
        bench_time(&fftw, call_fftw, &b);
    }
    printf("%zux%zux%zu %s: cvol (%s) %.4g ms, FFTW %.4g ms, ratio %.2f\n", dims[0], dims[1],
           dims[2], kinds[k].name, BENCH_FFT, least(&cvol), least(&fftw),
           least(&cvol) / least(&fftw));
    fflush(stdout);
    fftwf_destroy_plan(b.plan);
    if (b.out != b.in)
        free(b.out);
    free(b.in);
    free(b.samples);
}

int main(int count, char **texts)
{
    static char *usual[] = {"64",        "1024",     "10007",       "1048576",    "256x256",
                            "1024x1024", "64x64x64", "256x256x256", "301x370x316"};
    const int rounds = count > 1 ? atoi(texts[1]) : 9;
    if (rounds < 1 || rounds > BENCH_ROUNDS)
        bench_fail("rounds: 1 to %d", BENCH_ROUNDS);
    char **shapes = count > 2 ? texts + 2 : usual;
    const int shape_count = count > 2 ? count - 2 : (int)(sizeof usual / sizeof *usual);
    cvol_context *context = cvol_context_create();
    if (!context)
        bench_fail("no memory for a context");
    cvol_context_set_threads(context, 1);
    for (int s = 0; s < shape_count; s++) {
        size_t dims[3] = {0, 1, 1};
        if (sscanf(shapes[s], "%zux%zux%zu", &dims[0], &dims[1], &dims[2]) < 1 || !dims[0] ||
            !dims[1] || !dims[2] || dims[0] * dims[1] * dims[2] == 1)
            bench_fail("no dims: %s", shapes[s]);
        for (size_t k = 0; k < sizeof kinds / sizeof *kinds; k++)
            measure(context, dims, k, rounds);
    }
    cvol_context_free(context);
    return 0;
}
