/* Times one operation on whole arrays, compressed and the classical way, alternately on the same
 * terms.
 *
 * usage: algebra_whole OPERATION TRANSFORM DIMS SUPPORT COUNT [PLAN [ROUNDS [PLANNER]]]
 *   OPERATION add, convolve, multiply   TRANSFORM dft, dht, dct   DIMS 4194304, 1024x1024, ...
 *   SUPPORT   low (COUNT: k), bands, harmonics, progression (COUNT: s)     PLAN auto, grid, sparse,
 * ... PLANNER   estimate, measure: FFTW's, for the classical way
 *
 * Prints one JSON object. A time of cvol is the mean of a batch of calls of 2 ms or more over three
 * alternating pairs of operands, including allocation and release of the result. A time of the
 * classical way is that of one call. The two alternate, so each finds the caches as the other left
 * them. `agree` is the relative L2 difference of the two results' samples.
 */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "cvol/algebra.h"
#include "operands.h"
#include "timing.h"

enum { PAIRS = 3 };

typedef struct bench {
    cvol_context *context;
    operand_shape shape;
    dense_operation operation;
    cvol_plan plan;
    int rounds;
    dense dense;
    operand a[PAIRS], b[PAIRS];
    dense_terms out;
    uint32_t *places;
    cvol_array *result; /* the last one */
    cvol_multiply_report report;
} bench;

/* ---- measured functions ---------------------------------------------------------------------- */

static void call_cvol(void *user, int turn)
{
    bench *b = user;
    const cvol_array *p = b->a[turn % PAIRS].array, *q = b->b[turn % PAIRS].array;
    cvol_array_free(b->result);
    b->result = NULL;
    int status;
    if (b->operation == DENSE_ADD)
        status = cvol_array_add(b->context, &b->result, 1, p, 1, q, NULL);
    else if (b->operation == DENSE_CONVOLVE)
        status = cvol_array_convolve(b->context, &b->result, p, q, NULL);
    else
        status = cvol_array_multiply(b->context, &b->result, p, q, NULL, b->plan, &b->report);
    bench_check(b->context, status, "cvol");
}

static void call_dense(void *user, int turn)
{
    bench *b = user;
    const size_t largest = b->places ? b->out.value_count : 0;
    dense_operate(&b->dense, &b->out, b->operation, &b->a[turn % PAIRS].terms,
                  &b->b[turn % PAIRS].terms, largest, b->places);
}

/* ---- arguments ------------------------------------------------------------------------------- */

static size_t name_index(const char *text, const char *const *names, const char *what)
{
    for (size_t i = 0; names[i]; i++)
        if (!strcmp(text, names[i]))
            return i;
    bench_fail("no such %s: %s", what, text);
}

static cvol_plan plan_from_name(const char *text)
{
    for (int plan = CVOL_PLAN_AUTO; plan <= CVOL_PLAN_BLOCKS; plan++)
        if (!strcmp(text, cvol_plan_name((cvol_plan)plan)))
            return (cvol_plan)plan;
    bench_fail("no such plan: %s", text);
}

static void read_dims(operand_shape *shape, const char *text)
{
    shape->rank = 0;
    for (int a = 0; a < 3; a++)
        shape->dims[a] = 1;
    for (char *end = (char *)(uintptr_t)text; shape->rank < 3; end++) {
        shape->dims[shape->rank] = strtoul(end, &end, 10);
        if (!shape->dims[shape->rank++])
            break;
        if (*end != 'x')
            return;
    }
    bench_fail("no dims: %s", text);
}

static unsigned read_arguments(bench *b, int count, char **texts)
{
    static const char *const operations[] = {"add", "multiply", "convolve", NULL};
    static const char *const supports[] = {"low", "bands", "harmonics", "progression", NULL};
    static const char *const planners[] = {"estimate", "measure", NULL};
    if (count < 6 || count > 9)
        bench_fail("usage: algebra_whole OPERATION TRANSFORM DIMS SUPPORT COUNT [PLAN [ROUNDS "
                   "[PLANNER]]]");
    b->operation = (dense_operation)name_index(texts[1], operations, "operation");
    b->shape.transform = cvol_transform_from_name(texts[2]);
    if (!b->shape.transform)
        bench_fail("no such transform: %s", texts[2]);
    read_dims(&b->shape, texts[3]);
    b->shape.kind = (operand_kind)name_index(texts[4], supports, "support");
    b->shape.count = strtoul(texts[5], NULL, 10);
    b->plan = count > 6 ? plan_from_name(texts[6]) : CVOL_PLAN_AUTO;
    b->rounds = count > 7 ? atoi(texts[7]) : 9;
    if (b->rounds < 1 || b->rounds > BENCH_ROUNDS)
        bench_fail("rounds: 1 to %d", BENCH_ROUNDS);
    if (b->shape.kind != OPERAND_LOW_BOX &&
        (b->shape.rank != 1 || b->shape.transform == CVOL_DCT || b->operation != DENSE_MULTIPLY))
        bench_fail("scattered terms: only products of rank 1 under DFT and DHT");
    return count > 8 && name_index(texts[8], planners, "planner") ? FFTW_MEASURE : FFTW_ESTIMATE;
}

/* ---- the run --------------------------------------------------------------------------------- */

static void make_operands(bench *b)
{
    uint64_t seed = 20240607;
    for (int i = 0; i < PAIRS; i++) {
        const double draw = bench_random(&seed);
        const double n = (double)b->shape.dims[0];
        b->shape.step = b->shape.kind == OPERAND_HARMONICS
                            ? (size_t)(n / (18.5 + draw))
                            : 2 * (size_t)((1 + draw) / 4 * n / 2) + 1;
        operand_make(b->context, &b->a[i], &b->shape, &b->dense, &seed);
        operand_make(b->context, &b->b[i], &b->shape, &b->dense, &seed);
    }
    const dense_terms *like = &b->a[0].terms;
    if (b->shape.kind == OPERAND_LOW_BOX) {
        size_t low[3];
        operand_low(low, &b->shape);
        dense_low_box(&b->out, &b->dense, low);
    } else { /* one run per coefficient: they may be anywhere */
        const size_t most = like->value_count / 2;
        dense_terms_make(&b->out, &b->dense, bench_allocate(most * sizeof(dense_run)), 0);
        b->out.value_count = like->value_count;
        free(b->out.values);
        b->out.values = bench_allocate(4 * like->value_count);
        b->places = bench_allocate(4 * most);
    }
}

/* Relative L2 difference of the two ways' results for the first pair. */
static double difference(bench *b)
{
    const size_t begin[3] = {0, 0, 0}, n = b->dense.samples;
    float *samples = bench_allocate(4 * n);
    call_cvol(b, 0);
    call_dense(b, 0);
    bench_check(b->context,
                cvol_array_evaluate_real(b->context, samples, b->result, begin, b->shape.dims),
                "evaluating the result");
    dense_synthesise(&b->dense, &b->out);
    double apart = 0, size = 0;
    for (size_t i = 0; i < n; i++) {
        const double x = samples[i], y = b->dense.a[i];
        apart += (x - y) * (x - y);
        size += y * y;
    }
    free(samples);
    return sqrt(apart / size);
}

static void print(const bench *b, const bench_times *cvol, const bench_times *classical,
                  double apart)
{
    cvol_array_info in, out;
    cvol_array_get_info(&in, b->a[0].array);
    cvol_array_get_info(&out, b->result);
    printf("{\"fft\":\"" BENCH_FFT
           "\",\"samples\":%zu,\"terms\":%llu,\"terms_out\":%llu,\"rho\":%.5g",
           b->dense.samples, (unsigned long long)in.coefficients,
           (unsigned long long)out.coefficients, in.rho);
    printf(",\"resident_bytes\":%llu,\"agree\":%.3g,\"batch\":%d",
           (unsigned long long)in.resident_bytes, apart, cvol->batch);
    if (b->operation == DENSE_MULTIPLY)
        printf(",\"plan\":\"%s\",\"sparse_failed\":%d,\"points\":[%zu,%zu,%zu]",
               cvol_plan_name(b->report.plan), b->report.sparse_failed, b->report.points[0],
               b->report.points[1], b->report.points[2]);
    bench_print_times("cvol_ms", cvol);
    bench_print_times("dense_ms", classical);
    printf("}\n");
}

int main(int count, char **texts)
{
    bench b = {.context = cvol_context_create()};
    if (!b.context)
        bench_fail("no memory for a context");
    cvol_context_set_threads(b.context, 1);
    const unsigned planner = read_arguments(&b, count, texts);
    dense_start(&b.dense, b.shape.transform, b.shape.dims, planner);
    make_operands(&b);
    const double apart = difference(&b);
    bench_times cvol = {.batch = 0}, classical = {.batch = 1};
    bench_time(&cvol, call_cvol, &b);
    for (int i = 0; i <= b.rounds; i++) { /* the first round warms up */
        bench_time(&cvol, call_cvol, &b);
        bench_time(&classical, call_dense, &b);
        if (!i)
            cvol.count = classical.count = 0;
    }
    print(&b, &cvol, &classical, apart);
    for (int i = 0; i < PAIRS; i++) {
        operand_free(&b.a[i]);
        operand_free(&b.b[i]);
    }
    dense_terms_free(&b.out);
    free(b.places);
    cvol_array_free(b.result);
    dense_stop(&b.dense);
    cvol_context_free(b.context);
    return 0;
}
