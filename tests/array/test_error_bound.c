/* The certified bound: thousands of random chains of operations, compared with the same operations
 * on exact samples in double precision. The measured error never exceeds the certified one; the
 * test prints their ratio. Some chains use volumes whose operands are lapped, or have split cells,
 * or neither. CVOL_ERROR_BOUND_CHAINS sets the number of chains, CVOL_ERROR_BOUND_SEED the first
 * seed. */
#include "test.h"

#include "array/truncate/account.h"
#include "cvol/cvol.h"
#include "random.h"
#include "support.h"
#include "support_exact.h"
#include "support_lapped.h"
#include "support_split.h"

enum { CHAINS = 2500, CELL_CHAINS = 500, LENGTH_MAX = 4, SAMPLES_MAX = 40000 };

/* ---- the tested case ----------------------------------------------------------------------- */

/* An array and its exact samples. */
typedef struct operand {
    cvol_array *array;
    double *exact;
    size_t count;
} operand;

typedef support_shape shape;

typedef struct chain {
    cvol_context *context;
    random_state random;
    uint64_t seed;
    shape shape;
    int cells;       /* volumes in cells of 16: some lapped, some split */
    char story[512]; /* the operations of the chain, for messages */
} chain;

static double uniform(chain *c, double lo, double hi)
{
    return lo + (hi - lo) * ((double)(random_u64(&c->random) >> 11) * 0x1p-53);
}

static int below(chain *c, int count)
{
    return (int)random_below(&c->random, (uint32_t)(count > 0 ? count : 1));
}

static void describe_failure(chain *c, const char *what)
{
    size_t length = strlen(c->story);
    snprintf(c->story + length, sizeof c->story - length, " %s", what);
}

static void must(chain *c, int code)
{
    if (!code)
        return;
    print_message("seed %llu:%s: %s\n", (unsigned long long)c->seed, c->story,
                  cvol_context_message(c->context));
    fail();
}

static void drop(operand *s)
{
    cvol_array_free(s->array);
    free(s->exact);
    *s = (operand){0};
}

/* ---- random shapes and samples --------------------------------------------------------------- */

static void choose_shape(chain *c)
{
    static const int lengths[] = {1, 2, 3, 4, 5, 7, 8, 9, 11, 13, 16, 17, 24, 31, 32, 33, 37};
    static const int blocks[] = {0, 0, 8, 16, 32};
    shape *s = &c->shape;
    s->rank = 1 + below(c, 3);
    s->block = blocks[below(c, 5)];
    s->transform = (cvol_transform)(CVOL_DCT + below(c, 3));
    if (c->cells) {
        s->rank = 3;
        s->block = 16;
        s->transform = CVOL_DCT;
    }
    for (int a = 0; a < 3; a++)
        s->dims[a] = a < s->rank ? (size_t)lengths[below(c, 17)] : 1;
    if (s->rank == 1 && below(c, 2))
        s->dims[0] = 1 + (size_t)below(c, 1500);
    if (s->rank == 2 && below(c, 3) == 0)
        s->dims[0] = 1 + (size_t)below(c, 100);
    snprintf(c->story, sizeof c->story,
             " %s block %d %zux%zux%zu:", cvol_transform_name(s->transform), s->block, s->dims[0],
             s->dims[1], s->dims[2]);
}

/* A part of the brain scan; the scan is read once. */
static cvol_volume *brain;

static void fill_real(chain *c, float *samples)
{
    const size_t *n = c->shape.dims, *m = brain->grid.dims;
    const uint8_t *from = brain->data;
    size_t at[3];
    for (int a = 0; a < 3; a++)
        at[a] = m[a] / 4 + (size_t)below(c, (int)(m[a] / 2));
    for (size_t i = 0; i < n[0] * n[1] * n[2]; i++) {
        size_t x = (at[0] + i % n[0]) % m[0], y = (at[1] + i / n[0] % n[1]) % m[1];
        size_t z = (at[2] + i / n[0] / n[1]) % m[2];
        samples[i] = from[x + m[0] * (y + m[1] * z)];
    }
}

static void fill_smooth(chain *c, float *samples)
{
    const size_t *n = c->shape.dims;
    double wave[4][5];
    for (int k = 0; k < 4; k++)
        for (int i = 0; i < 5; i++)
            wave[k][i] = uniform(c, -0.5, 0.5);
    for (size_t i = 0; i < n[0] * n[1] * n[2]; i++) {
        double sum = 0;
        for (int k = 0; k < 4; k++)
            sum += wave[k][0] *
                   sin(wave[k][1] * (double)(i % n[0]) + wave[k][2] * (double)(i / n[0] % n[1]) +
                       wave[k][3] * (double)(i / n[0] / n[1]) + 9 * wave[k][4]);
        samples[i] = (float)sum;
    }
}

static void fill_samples(chain *c, float *samples, size_t count)
{
    const int kind = below(c, 7);
    const double size = kind == 6 ? 1e6 : kind == 5 ? 1e-3 : 1;
    for (size_t i = 0; i < count; i++)
        samples[i] = kind == 0   ? 0
                     : kind == 1 ? 3.5f
                     : kind == 2 ? (float)(below(c, 50) == 0)
                                 : (float)(size * uniform(c, -1, 2));
    if (kind == 3)
        fill_smooth(c, samples);
    if (kind == 4)
        fill_real(c, samples);
}

static cvol_keep choose_keep(chain *c, size_t count)
{
    const size_t k = 1 + (size_t)below(c, 4);
    cvol_keep keep = cvol_keep_all();
    switch (below(c, 8)) {
    case 0:
        return keep;
    case 1:
        keep = cvol_keep_terms(0, 0); /* nothing at all */
        return keep;
    case 2:
        return cvol_keep_rho(uniform(c, 0.02, 0.9));
    case 3:
        return cvol_keep_psnr(uniform(c, 10, 60));
    case 4:
        return cvol_keep_ratio(uniform(c, 1.5, 40));
    default:
        keep = cvol_keep_terms(0, (uint64_t)below(c, (int)(count / 2 + 1)));
        for (int a = 0; a < c->shape.rank; a++)
            keep.low[a] = k < c->shape.dims[a] / 2 + 1 ? k : 1;
        return keep;
    }
}

/* A lapped volume, quantized coarsely or finely. */
static cvol_array *make_lapped(chain *c, const float *samples, size_t count)
{
    double largest = 0;
    for (size_t i = 0; i < count; i++)
        largest = fmax(largest, fabs((double)samples[i]));
    const double step = largest > 0 ? ldexp(largest, -below(c, 12)) : 1;
    const int is_split = below(c, 2);
    describe_failure(c, is_split ? "lapped and split" : "lapped");
    return support_lapped(c->context, samples, c->shape.dims,
                          below(c, 2) ? (double)samples[count / 2] : 0, step, is_split,
                          random_u64(&c->random));
}

/* Splits the cells of an array, and measures the loss. */
static void split_cells(chain *c, cvol_array *array, const double *exact, size_t count)
{
    float *samples = malloc(count * sizeof *samples);
    double squares = 0, energy = 0, most = 0;
    assert_non_null(samples);
    describe_failure(c, "split");
    support_split_cells(c->context, array, random_u64(&c->random));
    support_lapped_samples(samples, array);
    array->error_bound.max_abs = 0;
    for (size_t i = 0; i < count; i++) {
        const double value = (double)samples[i] + array->offset;
        squares += (value - exact[i]) * (value - exact[i]);
        energy += value * value;
        most = fmax(most, fabs(value - exact[i]));
        array->error_bound.max_abs = fmax(array->error_bound.max_abs, fabs(value) * (1 + 1e-6));
    }
    array->error_bound.l2_error = sqrt(squares) + CVOL_ROUNDING * sqrt(squares + energy);
    array->error_bound.point_error = most + cvol_array_sample_rounding(array);
    free(samples);
}

static operand make_operand(chain *c)
{
    const shape *s = &c->shape;
    const cvol_grid grid = cvol_grid_make(s->dims[0], s->dims[1], s->dims[2], CVOL_FLOAT32);
    operand out = {.count = cvol_grid_samples(&grid)};
    float *samples = malloc(out.count * sizeof *samples);
    out.exact = malloc(out.count * sizeof *out.exact);
    assert_true(samples && out.exact);
    fill_samples(c, samples, out.count);
    for (size_t i = 0; i < out.count; i++)
        out.exact[i] = (double)samples[i];
    if (c->cells && below(c, 5) > 1) {
        out.array = make_lapped(c, samples, out.count);
        free(samples);
        return out;
    }
    const cvol_keep keep = choose_keep(c, out.count);
    int code = cvol_array_compress(c->context, &out.array, samples, &grid, s->rank, s->transform,
                                   s->block, &keep);
    if (code == CVOL_ERROR_TARGET) { /* for example a PSNR of noise around a large mean */
        const cvol_keep all = cvol_keep_all();
        code = cvol_array_compress(c->context, &out.array, samples, &grid, s->rank, s->transform,
                                   s->block, &all);
    }
    free(samples);
    must(c, code);
    if (c->cells && below(c, 2))
        split_cells(c, out.array, out.exact, out.count);
    return out;
}

/* ---- one operation, both ways ---------------------------------------------------------------- */

typedef enum operation {
    ADD,
    SCALE,
    ONE_MINUS,
    TRUNCATE,
    MULTIPLY,
    FILTER,
    GRADIENT,
    CONVOLVE,
    SHIFT,
    COMPRESS, /* the first link */
    OPERATIONS
} operation;

static const char *const names[OPERATIONS] = {"add",      "scale",   "one_minus", "truncate",
                                              "multiply", "filter",  "gradient",  "convolve",
                                              "shift",    "compress"};

static int choose_kernel(chain *c, cvol_kernel *kernel)
{
    char text[40];
    switch (below(c, 5)) {
    case 0:
        snprintf(text, sizeof text, "gaussian:%.3f", uniform(c, 0.3, 0.75));
        break;
    case 1:
        snprintf(text, sizeof text, "box:3");
        break;
    case 2:
        snprintf(text, sizeof text, "laplacian");
        break;
    case 3:
        snprintf(text, sizeof text, "unsharp:0.7,%.3f", uniform(c, 0.1, 3));
        break;
    default:
        snprintf(text, sizeof text, "derivative:%c", "xyz"[below(c, c->shape.rank)]);
    }
    describe_failure(c, text);
    return cvol_kernel_parse(c->context, kernel, c->shape.rank, text);
}

/* Replaces *s by the operation's result. */
static void apply(chain *c, operand *s, operation op)
{
    cvol_array *out = NULL;
    operand other = {0};
    const cvol_keep chosen = choose_keep(c, s->count);
    const cvol_keep *keep = below(c, 3) ? NULL : &chosen;
    describe_failure(c, names[op]);
    if (op == ADD || op == MULTIPLY || op == CONVOLVE)
        other = make_operand(c);
    int code = CVOL_OK;
    for (int attempt = 0; attempt < 2; attempt++) {
        const uint64_t before = c->random.state;
        const double alpha = uniform(c, -2, 2), beta = uniform(c, -2, 2);
        cvol_kernel kernel;
        double offset[3] = {0, 0, 0};
        for (int a = 0; a < c->shape.rank; a++)
            offset[a] = below(c, 9) - 4;
        switch (op) {
        case ADD:
            code = cvol_array_add(c->context, &out, alpha, s->array, beta, other.array, keep);
            for (size_t i = 0; i < s->count && !code; i++)
                s->exact[i] = alpha * s->exact[i] + beta * other.exact[i];
            break;
        case SCALE:
            code = cvol_array_scale(c->context, &out, alpha, s->array, beta);
            for (size_t i = 0; i < s->count && !code; i++)
                s->exact[i] = alpha * s->exact[i] + beta;
            break;
        case ONE_MINUS:
            code = cvol_array_one_minus(c->context, &out, s->array);
            for (size_t i = 0; i < s->count && !code; i++)
                s->exact[i] = 1 - s->exact[i];
            break;
        case TRUNCATE:
            code = cvol_array_truncate(c->context, &out, s->array, keep ? keep : &chosen);
            break;
        case MULTIPLY:
            code = cvol_array_multiply(c->context, &out, s->array, other.array, keep,
                                       CVOL_PLAN_AUTO, NULL);
            for (size_t i = 0; i < s->count && !code; i++)
                s->exact[i] *= other.exact[i];
            break;
        case FILTER:
            must(c, choose_kernel(c, &kernel));
            code = cvol_array_convolve_kernel(c->context, &out, s->array, &kernel, keep);
            if (!code)
                support_filter(s->exact, &c->shape, &kernel);
            break;
        case GRADIENT:
            code = cvol_array_gradient(c->context, &out, s->array, keep);
            if (!code)
                support_gradient(s->exact, &c->shape, cvol_array_grid(s->array)->spacing);
            break;
        case CONVOLVE:
            code = cvol_array_convolve(c->context, &out, s->array, other.array, keep);
            if (!code)
                support_convolve(s->exact, other.exact, &c->shape);
            break;
        case SHIFT:
            code = cvol_array_shift(c->context, &out, s->array, offset);
            if (!code) {
                double *moved = malloc(s->count * sizeof *moved);
                assert_non_null(moved);
                const size_t *n = c->shape.dims;
                for (size_t i = 0; i < s->count; i++)
                    moved[i] =
                        s->exact[support_extended(&c->shape, (long)(i % n[0]) - (long)offset[0],
                                                  n[0]) +
                                 n[0] *
                                     (support_extended(&c->shape,
                                                       (long)(i / n[0] % n[1]) - (long)offset[1],
                                                       n[1]) +
                                      n[1] * support_extended(
                                                 &c->shape,
                                                 (long)(i / n[0] / n[1]) - (long)offset[2], n[2]))];
                free(s->exact);
                s->exact = moved;
            }
            break;
        default:
            fail();
        }
        if (code != CVOL_ERROR_TARGET || !keep)
            break;
        keep = NULL; /* the target was beyond float32: again, without one */
        c->random.state = before;
        describe_failure(c, "(again)");
        if (op == TRUNCATE)
            break;
    }
    drop(&other);
    if (op == TRUNCATE && code == CVOL_ERROR_TARGET)
        return;
    must(c, code);
    cvol_array_free(s->array);
    s->array = out;
}

/* ---- measuring ------------------------------------------------------------------------------- */

enum { BINS = 9 };
static size_t histogram[OPERATIONS]
                       [BINS]; /* bound / measured below 1.1, 1.5, 2, 3, 5, 10, 30, 100 */
static const double edges[BINS - 1] = {1.1, 1.5, 2, 3, 5, 10, 30, 100};

static void measure(chain *c, const operand *s, operation op)
{
    const size_t begin[3] = {0, 0, 0};
    float *samples = malloc(s->count * sizeof *samples);
    assert_non_null(samples);
    must(c, cvol_array_evaluate_real(c->context, samples, s->array, begin, c->shape.dims));
    cvol_array_info info;
    cvol_array_get_info(&info, s->array);
    double squares = 0, energy = 0, most = 0, largest = 0, lo = s->exact[0], hi = s->exact[0];
    for (size_t i = 0; i < s->count; i++) {
        double difference = (double)samples[i] - s->exact[i];
        squares += difference * difference;
        most = fmax(most, fabs(difference));
        energy += s->exact[i] * s->exact[i];
        largest = fmax(largest, fabs((double)samples[i]));
        lo = fmin(lo, s->exact[i]);
        hi = fmax(hi, s->exact[i]);
    }
    free(samples);
    const double error = sqrt(squares), slack = 1e-5 * fmax(fabs(lo), fabs(hi)) + 1e-30;
    if (!(error <= info.l2_error) || !(most <= info.point_error) ||
        !(info.point_error <= info.l2_error) || !(largest <= info.max_abs + slack) ||
        !(lo >= info.value_min - slack) || !(hi <= info.value_max + slack)) {
        print_message(
            "seed %llu:%s: error %g, bound %g; of a sample %g, bound %g; largest %g, bound "
            "%g; values %g .. %g, bounds %g .. %g\n",
            (unsigned long long)c->seed, c->story, error, info.l2_error, most, info.point_error,
            largest, info.max_abs, lo, hi, info.value_min, info.value_max);
        fail();
    }
    /* If only rounding is lost, the bound is that of rounding, and its ratio means nothing. */
    if (info.l2_error < 1e-4 * sqrt(energy) || error <= 0)
        return;
    int bin = 0;
    while (bin < BINS - 1 && info.l2_error / error >= edges[bin])
        bin++;
    histogram[op][bin]++;
}

static int applies(const shape *s, operation op, size_t count)
{
    const int periodic = s->block == 0 && s->transform != CVOL_DCT;
    if (op == CONVOLVE)
        return periodic && count <= 1200;
    return op != SHIFT || periodic;
}

static long environment(const char *name, long otherwise)
{
    const char *text = getenv(name);
    return text ? atol(text) : otherwise;
}

static void run_chain(uint64_t seed, int cells, cvol_context *context)
{
    chain c = {.context = context, .random = {seed}, .seed = seed, .cells = cells};
    choose_shape(&c);
    if (c.shape.dims[0] * c.shape.dims[1] * c.shape.dims[2] > SAMPLES_MAX)
        return;
    operand s = make_operand(&c);
    measure(&c, &s, COMPRESS);
    const int length = 1 + below(&c, LENGTH_MAX);
    for (int link = 0; link < length; link++) {
        operation op;
        do
            op = (operation)below(&c, COMPRESS);
        while (!applies(&c.shape, op, s.count));
        apply(&c, &s, op);
        measure(&c, &s, op);
    }
    drop(&s);
}

static void measured_error_never_exceeds_the_bound(void **state)
{
    (void)state;
    cvol_context *context = cvol_context_create();
    assert_non_null(context);
    assert_int_equal(cvol_volume_read(context, &brain, CVOL_TEST_SAMPLES "/ch2better.nii.gz", NULL),
                     0);
    const uint64_t first = (uint64_t)environment("CVOL_ERROR_BOUND_SEED", 1);
    const uint64_t chains = (uint64_t)environment("CVOL_ERROR_BOUND_CHAINS", CHAINS);
    for (uint64_t seed = first; seed < first + chains; seed += SUPPORT_STRIDE)
        run_chain(seed, 0, context);
    const uint64_t cell_chains = chains == CHAINS ? CELL_CHAINS : chains;
    for (uint64_t seed = first; seed < first + cell_chains; seed += SUPPORT_STRIDE)
        run_chain(seed, 1, context);
    print_message("bound / measured, chains %llu .. %llu: how many below\n%-10s",
                  (unsigned long long)first, (unsigned long long)(first + chains - 1), "");
    for (int bin = 0; bin < BINS - 1; bin++)
        print_message("%8g", edges[bin]);
    print_message("    more\n");
    for (int op = 0; op < OPERATIONS; op++) {
        print_message("%-10s", names[op]);
        for (int bin = 0; bin < BINS; bin++)
            print_message("%8zu", histogram[op][bin]);
        print_message("\n");
    }
    cvol_volume_free(brain);
    cvol_context_free(context);
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(measured_error_never_exceeds_the_bound)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
