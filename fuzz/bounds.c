/* Random arrays and chains of all operations of the algebra, compared with the same operations on
 * dense samples in double precision: an array's error never exceeds its certified bounds, neither
 * its L2 norm nor at any sample, and values lie within their bounds. Magnitudes from 1e-38 to 1e38,
 * lengths from 1 to 4,000, most of them with large primes. A result that is refused with a message
 * ends its chain.
 *
 * usage: bounds [FIRST_SEED [CHAINS [SECONDS]]]   one chain a seed; every array is counted
 *
 * A violation is printed with its seed and its operations; the program then exits with 1. At the
 * end it prints, for each operation, the median and the least of the bounds over the errors: L2
 * norms, and largest errors of a sample. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "cvol/cvol.h"
#include "fuzz/seeds.h"
#include "random.h"
#include "support.h"
#include "support_exact.h"

enum { LENGTH_MAX = 4, SAMPLES_MAX = 12000, STORY = 800 };

/* The last operation of an array. */
typedef enum operation {
    ADD,
    SCALE,
    NEGATE,
    ONE_MINUS,
    TRUNCATE,
    MULTIPLY,
    FILTER,
    GRADIENT,
    RESAMPLE,
    CONVOLVE,
    SHIFT,
    OPERATIONS, /* the next ones begin a chain */
    COMPRESS = OPERATIONS,
    MEASURE,
    CODE,
    TRANSCODE,
    ORIGINS
} operation;

typedef struct operand {
    cvol_array *array;
    double *exact;
    support_shape shape;
    size_t count;
    double rounding; /* the rounding error of `exact` in double precision */
    operation origin;
} operand;

typedef struct chain {
    cvol_context *context;
    random_state random;
    uint64_t seed;
    double magnitude; /* 10^x of the chain's samples */
    char story[STORY];
    int refused;
} chain;

static const char *const names[ORIGINS] = {
    "add",      "scale",    "negate", "one_minus", "truncate", "multiply", "filter",   "gradient",
    "resample", "convolve", "shift",  "compress",  "measure",  "code",     "transcode"};

/* Ratios of bounds to errors. */
typedef struct ratio_list {
    double *of;
    size_t count, capacity;
} ratio_list;

static ratio_list l2_ratios[ORIGINS], point_ratios[ORIGINS];

static unsigned long long arrays, violations, refusals, worst_seed, worst_point_seed;
static double worst, worst_point; /* error / bound */
static int verbose;               /* CVOL_TEST_VERBOSE: every array is printed */

static double uniform(chain *c, double lo, double hi)
{
    return lo + (hi - lo) * ((double)(random_u64(&c->random) >> 11) * 0x1p-53);
}

static int below(chain *c, int count)
{
    return (int)random_below(&c->random, (uint32_t)(count > 0 ? count : 1));
}

static void *need(void *memory)
{
    if (!memory)
        abort();
    return memory;
}

#define LOG(c, ...)                                                              \
    do {                                                                         \
        const size_t length_ = strlen((c)->story);                               \
        snprintf((c)->story + length_, sizeof(c)->story - length_, __VA_ARGS__); \
    } while (0)

/* ---- shapes and samples -------------------------------------------------------------------- */

static size_t choose_length(chain *c, int most)
{
    static const int primes[] = {17,  31,  61,  89,  97,  101, 103, 107, 109,  113,  127,  131,
                                 137, 139, 149, 151, 157, 163, 167, 173, 179,  191,  211,  257,
                                 347, 359, 383, 479, 503, 719, 839, 983, 1019, 1367, 1997, 3989};
    if (below(c, 3) == 0)
        return 1 + (size_t)below(c, most < 40 ? most : 40);
    if (below(c, 3) == 0)
        return 1 + (size_t)below(c, most);
    const int prime = primes[below(c, 36)];
    return prime > most ? 1 + (size_t)below(c, most)
                        : (size_t)(prime * (1 + below(c, most / prime)));
}

static support_shape choose_shape(chain *c)
{
    static const int blocks[] = {0, 0, 0, 8, 16, 32};
    support_shape s = {.dims = {1, 1, 1}};
    const int is_for_codec = below(c, 12) == 0;
    s.rank = is_for_codec ? 3 : below(c, 2) ? 1 : 1 + below(c, 3);
    s.block = blocks[is_for_codec ? 3 + below(c, 3) : below(c, 6)];
    s.transform = is_for_codec ? CVOL_DCT : (cvol_transform)(CVOL_DCT + below(c, 3));
    int left = s.rank == 1 ? 4000 : SAMPLES_MAX / 4;
    for (int a = 0; a < s.rank; a++) {
        s.dims[a] = choose_length(c, left < 4000 ? left : 4000);
        left = left / (int)s.dims[a] + 1;
    }
    return s;
}

static void fill(chain *c, double *samples, size_t count)
{
    const int kind = below(c, 8);
    const size_t edge = (size_t)below(c, (int)count);
    const double size = c->magnitude * pow(10, uniform(c, -1, 1)), mean = uniform(c, -3, 3);
    const double wave = uniform(c, 0, 1);
    for (size_t i = 0; i < count; i++) {
        const double noise = uniform(c, -1, 1);
        double value = kind == 0   ? noise
                       : kind == 1 ? mean
                       : kind == 2 ? (below(c, 50) == 0)
                       : kind == 3 ? (i < edge ? -2 : -0.49)
                       : kind == 4 ? sin(wave * (double)i)
                       : kind == 5 ? (i == edge)
                       : kind == 6 ? mean + 1e-3 * noise
                                   : noise * pow(10, uniform(c, -6, 0));
        samples[i] = size * value;
    }
}

static cvol_keep choose_keep(chain *c, const support_shape *s, size_t count)
{
    cvol_keep keep = cvol_keep_all();
    switch (below(c, 10)) {
    case 0:
        return cvol_keep_terms(0, 0);
    case 1:
        return cvol_keep_rho(uniform(c, 0.02, 0.9));
    case 2:
        return cvol_keep_psnr(uniform(c, 10, 90));
    case 3:
        return cvol_keep_ratio(uniform(c, 1.5, 40));
    case 4:
        return cvol_keep_l2(c->magnitude * pow(10, uniform(c, -6, 1)));
    case 5:
        return cvol_keep_threshold(c->magnitude * pow(10, uniform(c, -6, 1)));
    case 6:
        keep = cvol_keep_terms(0, (uint64_t)below(c, (int)(count / 2 + 1)));
        for (int a = 0; a < s->rank; a++) {
            const size_t k = 1 + (size_t)below(c, 4);
            keep.low[a] = k < s->dims[a] / 2 + 1 ? k : 1;
        }
        return keep;
    default:
        return keep;
    }
}

static double peak_of(const operand *s)
{
    double most = 0;
    for (size_t i = 0; i < s->count; i++)
        most = fmax(most, fabs(s->exact[i]));
    return most;
}

static void drop(operand *s)
{
    cvol_array_free(s->array);
    free(s->exact);
    *s = (operand){0};
}

/* An array by the codec, with a random target; some are transcoded then. NULL: it was refused. */
static cvol_array *code_samples(chain *c, operation *origin, const void *stored,
                                const cvol_grid *grid, const support_shape *shape, double peak)
{
    cvol_compress_options o = cvol_compress_options_defaults();
    cvol_array *array, *coarser;
    o.block = shape->block;
    o.target = (cvol_target)(CVOL_TARGET_RATIO + below(c, 3));
    o.target_value = o.target == CVOL_TARGET_RATIO  ? uniform(c, 1.2, 40)
                     : o.target == CVOL_TARGET_PSNR ? uniform(c, 5, 90)
                                                    : peak * pow(10, uniform(c, -4, 0));
    o.lossless = below(c, 6) == 0;
    o.lapped = below(c, 2);
    if (below(c, 2) && !o.lossless && o.target != CVOL_TARGET_MAX_ERROR)
        o.background = CVOL_BACKGROUND_FIND;
    LOG(c, " [target %d %g lossless %d lapped %d background %d]", (int)o.target, o.target_value,
        o.lossless, o.lapped, (int)o.background);
    *origin = CODE;
    if (cvol_compress(c->context, &array, NULL, stored, grid, &o))
        return NULL;
    if (below(c, 2))
        return array;
    o = cvol_compress_options_defaults();
    o.target = below(c, 2) ? CVOL_TARGET_RATIO : CVOL_TARGET_PSNR;
    o.target_value = o.target == CVOL_TARGET_RATIO ? uniform(c, 1.2, 40) : uniform(c, 1, 60);
    if (cvol_array_transcode(c->context, &coarser, NULL, array, &o))
        return array;
    LOG(c, " transcode %d %g", (int)o.target, o.target_value);
    cvol_array_free(array);
    *origin = TRANSCODE;
    return coarser;
}

/* Samples of this shape, stored as some type; the stored ones are the exact ones. */
static operand make_operand(chain *c, const support_shape *shape)
{
    static const cvol_type types[] = {CVOL_FLOAT32, CVOL_FLOAT64, CVOL_INT16};
    const cvol_type type = types[below(c, 3)];
    const cvol_grid grid = cvol_grid_make(shape->dims[0], shape->dims[1], shape->dims[2], type);
    operand out = {.shape = *shape, .count = cvol_grid_samples(&grid)};
    void *stored = need(malloc(out.count * sizeof(double)));
    out.exact = need(malloc(out.count * sizeof *out.exact));
    fill(c, out.exact, out.count);
    for (size_t i = 0; i < out.count; i++)
        if (type == CVOL_FLOAT32) {
            ((float *)stored)[i] = (float)out.exact[i];
            out.exact[i] = (double)((float *)stored)[i];
        } else if (type == CVOL_FLOAT64) {
            ((double *)stored)[i] = out.exact[i];
        } else {
            ((int16_t *)stored)[i] = (int16_t)fmax(
                -32768, fmin(32767, rint(out.exact[i] / c->magnitude * 100)));
            out.exact[i] = ((int16_t *)stored)[i];
        }
    out.origin = COMPRESS;
    if (shape->rank == 3 && shape->block && shape->transform == CVOL_DCT && below(c, 4))
        out.array = code_samples(c, &out.origin, stored, &grid, shape, peak_of(&out));
    if (!out.array)
        out.origin = COMPRESS;
    for (int attempt = 0; attempt < 2 && !out.array; attempt++) {
        const cvol_keep keep = attempt ? cvol_keep_all() : choose_keep(c, shape, out.count);
        const int code = cvol_array_compress(c->context, &out.array, stored, &grid, shape->rank,
                                             shape->transform, shape->block, &keep);
        if (!attempt)
            LOG(c, " [%s keep %d %g]", cvol_type_name(type), (int)keep.rule, keep.value);
        c->refused = code != CVOL_OK;
    }
    if (out.array && out.origin == COMPRESS && below(c, 2) &&
        !cvol_array_measure(c->context, out.array, stored))
        out.origin = MEASURE;
    LOG(c, "%s", out.origin == MEASURE ? " measured" : "");
    free(stored);
    if (!out.array)
        drop(&out);
    return out;
}

/* ---- measuring ----------------------------------------------------------------------------- */

static void keep_ratio(ratio_list *list, double ratio)
{
    if (list->count == list->capacity) {
        list->capacity = 2 * list->capacity + 64;
        list->of = need(realloc(list->of, list->capacity * sizeof *list->of));
    }
    list->of[list->count++] = ratio;
}

static int compare(const void *a, const void *b)
{
    const double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

static void sort(ratio_list *list)
{
    qsort(list->of, list->count, sizeof *list->of, compare);
}

static void print_ratios(void)
{
    for (int i = 0; i < ORIGINS; i++) {
        ratio_list *l2 = &l2_ratios[i], *point = &point_ratios[i];
        const size_t count = l2->count;
        if (count) {
            sort(l2);
            sort(point);
            printf(
                "  %-9s %6zu arrays: l2_error / L2 error: median %.2f, least %.3f; point_error / "
                "largest error: median %.2f, least %.3f\n",
                names[i], count, l2->of[count / 2], l2->of[0], point->of[count / 2], point->of[0]);
        }
        free(l2->of);
        free(point->of);
    }
}

static void measure(chain *c, const operand *s, operation last)
{
    const size_t begin[3] = {0, 0, 0};
    float *samples = need(malloc(s->count * sizeof *samples));
    cvol_array_info info;
    arrays++;
    cvol_array_get_info(&info, s->array);
    if (cvol_array_evaluate_real(c->context, samples, s->array, begin, s->shape.dims)) {
        printf("seed %llu:%s: %s\n", (unsigned long long)c->seed, c->story,
               cvol_context_message(c->context));
        violations++;
    }
    double error = 0, point = 0, largest = 0, lo = s->exact[0], hi = s->exact[0];
    for (size_t i = 0; i < s->count; i++) {
        error = hypot(error, (double)samples[i] - s->exact[i]);
        point = fmax(point, fabs((double)samples[i] - s->exact[i]));
        largest = isnan(samples[i]) ? (double)NAN : fmax(largest, fabs((double)samples[i]));
        lo = fmin(lo, s->exact[i]);
        hi = fmax(hi, s->exact[i]);
    }
    free(samples);
    /* Samples' bounds are for exact arithmetic: the test allows for the rounding of evaluation. */
    const double slack = 1e-5 * fmax(fabs(lo), fabs(hi)) + 1e-40 + s->rounding;
    if (verbose)
        printf("%s: error %.9g, bound %.9g; of a sample %.9g, bound %.9g; largest %.9g, bound "
               "%.9g; values %.9g .. %.9g, bounds %.9g .. %.9g\n",
               c->story, error, info.l2_error, point, info.point_error, largest, info.max_abs, lo,
               hi, info.value_min, info.value_max);
    if (point > 1e-4 * largest) { /* more than rounding */
        keep_ratio(&l2_ratios[last], info.l2_error / error);
        keep_ratio(&point_ratios[last], info.point_error / point);
    }
    if (info.l2_error > 0 && error / info.l2_error > worst) {
        worst = error / info.l2_error;
        worst_seed = c->seed;
    }
    if (info.point_error > 0 && point / info.point_error > worst_point) {
        worst_point = point / info.point_error;
        worst_point_seed = c->seed;
    }
    if (error <= info.l2_error && point <= info.point_error && info.point_error <= info.l2_error &&
        largest <= info.max_abs && lo >= info.value_min - slack && hi <= info.value_max + slack)
        return;
    violations++;
    printf("seed %llu:%s: error %g, bound %g; of a sample %g, bound %g; largest %g, bound %g; "
           "values %g .. %g, bounds %g .. %g\n",
           (unsigned long long)c->seed, c->story, error, info.l2_error, point, info.point_error,
           largest, info.max_abs, lo, hi, info.value_min, info.value_max);
}

/* ---- operations ---------------------------------------------------------------------------- */

static int applies(const operand *s, operation op)
{
    const int periodic = s->shape.block == 0 && s->shape.transform != CVOL_DCT;
    if (op == CONVOLVE)
        return periodic && s->count <= 800;
    if (op == SHIFT)
        return periodic;
    return op != RESAMPLE || (s->shape.block && s->count < SAMPLES_MAX);
}

static int choose_kernel(chain *c, cvol_kernel *kernel, int rank)
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
        snprintf(text, sizeof text, "derivative:%c", "xyz"[below(c, rank)]);
    }
    LOG(c, " %s", text);
    return cvol_kernel_parse(c->context, kernel, rank, text);
}

static double *shifted(const operand *s, const double offset[3])
{
    const size_t *n = s->shape.dims;
    double *moved = need(malloc(s->count * sizeof *moved));
    for (size_t i = 0; i < s->count; i++)
        moved[i] =
            s->exact[support_extended(&s->shape, (long)(i % n[0]) - (long)offset[0], n[0]) +
                     n[0] * (support_extended(&s->shape, (long)(i / n[0] % n[1]) - (long)offset[1],
                                              n[1]) +
                             n[1] * support_extended(&s->shape,
                                                     (long)(i / n[0] / n[1]) - (long)offset[2],
                                                     n[2]))];
    return moved;
}

/* A factor: ordinary, or one that moves values to another magnitude between 1e-38 and 1e38. */
static double choose_factor(chain *c)
{
    return below(c, 3) ? uniform(c, -2, 2) : uniform(c, -2, 2) * pow(10, uniform(c, -38, 38));
}

/* Replaces *s by the operation's result; 0 if that was refused. */
static int apply(chain *c, operand *s, operation op)
{
    cvol_array *out = NULL;
    operand other = {0};
    const cvol_keep chosen = choose_keep(c, &s->shape, s->count);
    const cvol_keep *keep = below(c, 3) ? NULL : &chosen;
    const double alpha = choose_factor(c), beta = below(c, 2) ? 0 : choose_factor(c);
    double offset[3] = {0, 0, 0}, *moved;
    cvol_kernel kernel;
    int code = CVOL_OK;
    LOG(c, " %s", names[op]);
    if (keep)
        LOG(c, " (keep %d %g)", (int)keep->rule, keep->value);
    if (op == ADD || op == MULTIPLY || op == CONVOLVE) {
        if (op == MULTIPLY)
            c->magnitude = pow(10, uniform(c, -38, 19));
        other = make_operand(c, &s->shape);
        if (!other.array)
            return 0;
        measure(c, &other, other.origin);
    }
    /* Gains of errors, of the largest intermediate number, and of the other operand's error. */
    const double peak = peak_of(s), most = other.array ? peak_of(&other) : 0;
    const double bins = op == CONVOLVE ? (double)s->count : 1;
    double gain = op == FILTER     ? 20
                  : op == GRADIENT ? 3
                                   : 1,
           reach = gain * peak + (op == ONE_MINUS);
    if (op == ADD || op == SCALE) {
        gain = fabs(alpha);
        reach = gain * peak + fabs(beta) * (op == ADD ? most : 1);
    } else if (op == MULTIPLY || op == CONVOLVE) {
        gain = bins * most;
        reach = gain * peak;
    }
    s->rounding = gain * s->rounding + bins * 1e-15 * reach;
    for (int a = 0; a < s->shape.rank; a++)
        offset[a] = below(c, 9) - 4;
    switch (op) {
    case ADD:
        LOG(c, " %g %g", alpha, beta);
        code = cvol_array_add(c->context, &out, alpha, s->array, beta, other.array, keep);
        for (size_t i = 0; i < s->count; i++)
            s->exact[i] = alpha * s->exact[i] + beta * other.exact[i];
        break;
    case SCALE:
        LOG(c, " %g %g", alpha, beta);
        code = cvol_array_scale(c->context, &out, alpha, s->array, beta);
        for (size_t i = 0; i < s->count; i++)
            s->exact[i] = alpha * s->exact[i] + beta;
        break;
    case NEGATE:
        code = cvol_array_negate(c->context, &out, s->array);
        for (size_t i = 0; i < s->count; i++)
            s->exact[i] = -s->exact[i];
        break;
    case ONE_MINUS:
        code = cvol_array_one_minus(c->context, &out, s->array);
        for (size_t i = 0; i < s->count; i++)
            s->exact[i] = 1 - s->exact[i];
        break;
    case TRUNCATE:
        code = cvol_array_truncate(c->context, &out, s->array, &chosen);
        break;
    case MULTIPLY:
        code = cvol_array_multiply(c->context, &out, s->array, other.array, keep,
                                   s->shape.block || below(c, 2)
                                       ? CVOL_PLAN_AUTO
                                       : (cvol_plan)(CVOL_PLAN_DIRECT + below(c, 4)),
                                   NULL);
        for (size_t i = 0; i < s->count; i++)
            s->exact[i] *= other.exact[i];
        break;
    case FILTER:
        code = choose_kernel(c, &kernel, s->shape.rank);
        if (!code)
            code = cvol_array_convolve_kernel(c->context, &out, s->array, &kernel, keep);
        if (!code)
            support_filter(s->exact, &s->shape, &kernel);
        break;
    case GRADIENT:
        code = cvol_array_gradient(c->context, &out, s->array, keep);
        if (!code)
            support_gradient(s->exact, &s->shape, cvol_array_grid(s->array)->spacing);
        break;
    case RESAMPLE: {
        const int factor = below(c, 2) ? 2 : -2;
        LOG(c, " %d", factor);
        code = cvol_array_resample(c->context, &out, s->array, factor, keep);
        if (code)
            break;
        moved = support_resample(s->exact, &s->shape, factor);
        free(s->exact);
        s->exact = moved;
        s->count = s->shape.dims[0] * s->shape.dims[1] * s->shape.dims[2];
        break;
    }
    case CONVOLVE:
        code = cvol_array_convolve(c->context, &out, s->array, other.array, keep);
        if (!code)
            support_convolve(s->exact, other.exact, &s->shape);
        break;
    default:
        code = cvol_array_shift(c->context, &out, s->array, offset);
        moved = shifted(s, offset);
        free(s->exact);
        s->exact = moved;
    }
    drop(&other);
    if (code) {
        refusals++;
        if (!*cvol_context_message(c->context)) {
            printf("seed %llu:%s: refused (%d) without a sentence\n", (unsigned long long)c->seed,
                   c->story, code);
            violations++;
        }
        return 0;
    }
    cvol_array_free(s->array);
    s->array = out;
    return 1;
}

static void run_chain(uint64_t seed, cvol_context *context)
{
    chain c = {.context = context, .random = {seed}, .seed = seed};
    c.magnitude = pow(10, below(&c, 2) ? uniform(&c, -38, 18) : uniform(&c, -3, 3));
    const support_shape shape = choose_shape(&c);
    LOG(&c, " %s block %d %zux%zux%zu, %.1g:", cvol_transform_name(shape.transform), shape.block,
        shape.dims[0], shape.dims[1], shape.dims[2], c.magnitude);
    operand s = make_operand(&c, &shape);
    if (!s.array) {
        refusals++;
        return;
    }
    measure(&c, &s, s.origin);
    const int length = below(&c, LENGTH_MAX + 1);
    for (int link = 0; link < length; link++) {
        operation op;
        do
            op = (operation)below(&c, OPERATIONS);
        while (!applies(&s, op));
        if (!apply(&c, &s, op))
            break;
        measure(&c, &s, op);
    }
    drop(&s);
}

static void try_chain(uint64_t seed, cvol_context *context)
{
    cvol_context_set_threads(context, 1);
    run_chain(seed, context);
}

int main(int argc, char **argv)
{
    verbose = test_verbose();
    const uint64_t last = try_seeds(argc, argv, 2000, try_chain);
    printf("bounds: up to seed %llu: %llu arrays, %llu violations, %llu refused; largest error / "
           "bound %.3f (seed %llu), of a sample %.3f (seed %llu)\n",
           (unsigned long long)last, arrays, violations, refusals, worst, worst_seed, worst_point,
           worst_point_seed);
    print_ratios();
    return violations != 0;
}
