/* Random small volumes, compressed with random values of all options, valid and invalid ones: a
 * refusal has a sentence; a result keeps what was asked, its figures are those of its decoded
 * samples, its bound holds, and its file decodes to the same bits.
 *
 * usage: compression [FIRST_SEED [COUNT [SECONDS]]]   one volume a seed
 *
 * A violation is printed with its seed and its options; the program then exits with 1. */
#include <float.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "cvol/cvol.h"
#include "fuzz/seeds.h"
#include "random.h"
#include "support.h"
#include "support_samples.h"

typedef struct trial {
    cvol_context *context;
    random_state random;
    uint64_t seed;
    cvol_grid grid;
    size_t count;
    void *samples;
    cvol_compress_options options;
} trial;

static unsigned long long files, refusals, violations;

static size_t below(trial *t, size_t count)
{
    return random_below(&t->random, (uint32_t)count);
}

static double uniform(trial *t, double lo, double hi)
{
    return lo + (hi - lo) * ((double)(random_u64(&t->random) >> 11) * 0x1p-53);
}

static void *need(void *memory)
{
    if (!memory)
        abort();
    return memory;
}

static void violate(const trial *t, const char *what, double found, double wanted)
{
    const cvol_compress_options *o = &t->options;
    violations++;
    printf("seed %llu: %s: %.17g, %.17g wanted; %zux%zux%zu %s, transform %d block %d target %d %g "
           "least_psnr %g max_error %g lossless %d fill %d %g background %d %g lapped %d effort %d "
           "no_histogram %d brick %d,%d,%d range %d %g %g\n",
           (unsigned long long)t->seed, what, found, wanted, t->grid.dims[0], t->grid.dims[1],
           t->grid.dims[2], cvol_type_name(t->grid.type), (int)o->transform, o->block,
           (int)o->target, o->target_value, o->least_psnr, o->max_error, o->lossless, o->has_fill,
           o->fill, (int)o->background, o->background_value, o->lapped, (int)o->effort,
           o->no_histogram, o->brick[0], o->brick[1], o->brick[2], o->has_value_range, o->value_min,
           o->value_max);
}

/* ---- volumes ------------------------------------------------------------------------------- */

static void choose_grid(trial *t)
{
    static const size_t usual[] = {1, 2, 3, 8, 15, 16, 17, 31, 32, 33, 48, 63, 64, 65};
    size_t dims[3], left = 40000;
    for (int a = 0; a < 3; a++) {
        dims[a] = below(t, 2) ? usual[below(t, sizeof usual / sizeof *usual)] : 1 + below(t, 40);
        dims[a] = dims[a] <= left ? dims[a] : left;
        left /= dims[a];
    }
    t->grid = cvol_grid_make(dims[0], dims[1], dims[2], (cvol_type)(CVOL_UINT8 + (int)below(t, 8)));
    t->count = cvol_grid_samples(&t->grid);
}

/* support_store maps -1 .. 1 to the range of an integer type. */
static void fill_samples(trial *t)
{
    const cvol_type type = t->grid.type;
    const size_t kind = below(t, 9), edge = below(t, t->count), *n = t->grid.dims;
    const int is_float = type == CVOL_FLOAT32 || type == CVOL_FLOAT64;
    const double size = is_float ? pow(10, uniform(t, -30, 30)) : pow(10, uniform(t, -2.4, 0)),
                 mean = is_float ? uniform(t, -2, 2) * size : uniform(t, size - 1, 1 - size),
                 wave = uniform(t, 0, 1);
    t->samples = need(malloc(t->count * cvol_type_size(type)));
    for (size_t i = 0; i < t->count; i++) {
        const double x = (double)(i % n[0]), y = (double)(i / n[0] % n[1]),
                     z = (double)(i / n[0] / n[1]), noise = random_signed(&t->random);
        const double value = kind == 0   ? 0
                             : kind == 1 ? noise
                             : kind == 2 ? sin(wave * x) * cos(0.4 * wave * (y + z))
                             : kind == 3 ? (below(t, 40) == 0)
                             : kind == 4 ? (i < edge ? -1 : 1)
                             : kind == 5 ? (hypot(x - 9, y - 7) < 6) - 0.05 * noise
                             : kind == 6 ? (hypot(x - 9, y - 7) < 6 ? 0.5 + 0.3 * noise : 0)
                             : kind == 7 ? sin(wave * x) + 0.01 * noise
                                         : noise * noise * noise;
        support_store(t->samples, type, i, fmax(-1, fmin(1, value)) * size + mean);
    }
    if (is_float && below(t, 6) == 0)
        for (size_t k = 1 + below(t, 4); k > 0; k--) {
            static const double odd[] = {NAN, INFINITY, -INFINITY, -0.0, 1e-42, 1e35};
            support_store(t->samples, type, below(t, t->count), odd[below(t, 6)]);
        }
}

/* ---- options ------------------------------------------------------------------------------- */

static double sample_at(trial *t)
{
    return support_load(t->samples, t->grid.type, below(t, t->count));
}

static void choose_target(trial *t)
{
    cvol_compress_options *o = &t->options;
    o->target = (cvol_target)(1 + (int)below(t, 4));
    switch (o->target) {
    case CVOL_TARGET_RATIO:
        o->target_value = pow(10, uniform(t, 0, 2.5));
        break;
    case CVOL_TARGET_PSNR:
        o->target_value = uniform(t, 5, 110);
        break;
    case CVOL_TARGET_BITS:
        o->target_value = pow(10, uniform(t, -1.5, 1.2));
        break;
    default:
        o->target_value = fabs(sample_at(t) - sample_at(t)) * pow(10, uniform(t, -3, 0));
    }
}

/* Now and then a value that no option has. */
static void spoil(trial *t)
{
    static const double numbers[] = {NAN, INFINITY, -INFINITY, -1, 0, 1e300, 1e-300};
    static const int integers[] = {-1, 0, 1, 2, 3, 7, 12, 17, 64, 128, INT32_MAX, INT32_MIN};
    cvol_compress_options *o = &t->options;
    double *const reals[] = {&o->target_value, &o->least_psnr, &o->max_error, &o->fill,
                             &o->background_value};
    int *const whole[] = {&o->block,        &o->lossless, &o->has_fill, &o->lapped,
                          &o->no_histogram, &o->brick[0], &o->brick[1], &o->brick[2]};
    switch (below(t, 6)) {
    case 0:
        *reals[below(t, 5)] = numbers[below(t, 7)];
        break;
    case 1:
        *whole[below(t, 8)] = integers[below(t, 12)];
        break;
    case 2:
        o->transform = (cvol_transform)(int)below(t, 6);
        break;
    case 3:
        o->background = (cvol_background)(int)below(t, 5);
        break;
    case 4:
        o->effort = (cvol_effort)(int)below(t, 5);
        break;
    default:
        o->target = (cvol_target)(int)below(t, 7);
    }
}

static void choose_options(trial *t)
{
    static const int blocks[] = {16, 16, 16, 8, 32}, sides[] = {16, 32, 48, 64};
    cvol_compress_options *o = &t->options;
    *o = cvol_compress_options_defaults();
    choose_target(t);
    o->block = blocks[below(t, 5)];
    o->lapped = (int)below(t, 2);
    o->no_histogram = (int)below(t, 2);
    o->effort = below(t, 16) ? (cvol_effort)(int)below(t, 2) : CVOL_EFFORT_MAX;
    o->lossless = below(t, 4) == 0;
    o->background = (cvol_background)(int)(below(t, 6) ? below(t, 2) : 2);
    o->background_value = sample_at(t);
    if (below(t, 4) == 0) {
        o->has_fill = 1;
        o->fill = below(t, 2) ? sample_at(t) : (double)NAN;
    }
    if (o->target == CVOL_TARGET_PSNR && below(t, 3) == 0)
        o->max_error = fabs(sample_at(t) - sample_at(t)) * uniform(t, 0, 1);
    if (below(t, 4) == 0)
        o->least_psnr = uniform(t, 0, 60);
    const int has_bricks = below(t, 3) == 0;
    for (int a = 0; a < 3 && has_bricks; a++)
        o->brick[a] = sides[below(t, 4)];
    if (below(t, 4) == 0)
        spoil(t);
    /* Apart, so that seeds of findings keep their meaning. */
    random_state random = {~t->seed};
    if (random_below(&random, 6) == 0) {
        o->has_value_range = 1;
        o->value_min = sample_at(t) - (double)random_below(&random, 3) * fabs(sample_at(t));
        o->value_max = sample_at(t) + (double)random_below(&random, 3) * fabs(sample_at(t));
    }
}

/* ---- checks -------------------------------------------------------------------------------- */

/* The decoded samples, in their type and as floats. */
typedef struct decoded {
    void *samples;
    float *real;
    uint8_t *mask; /* 0: has a value */
} decoded;

static void drop(decoded *d)
{
    free(d->samples);
    free(d->real);
    free(d->mask);
}

static int decode(trial *t, decoded *out, const cvol_array *array)
{
    static const size_t zero[3] = {0, 0, 0};
    const size_t *dims = t->grid.dims;
    out->samples = need(malloc(t->count * cvol_type_size(t->grid.type)));
    out->real = need(malloc(t->count * sizeof *out->real));
    out->mask = need(calloc(t->count, 1));
    cvol_array_evaluate_mask(out->mask, array, zero, dims);
    const int code = cvol_array_evaluate_box(t->context, out->samples, array, zero, dims);
    return code ? code : cvol_array_evaluate_real(t->context, out->real, array, zero, dims);
}

/* The figures in the report are those of the decoded samples, and what was asked holds. */
static void check_samples(trial *t, const decoded *d, const cvol_compress_report *report,
                          const cvol_array *array)
{
    const cvol_compress_options *o = &t->options;
    const size_t bytes = cvol_type_size(t->grid.type);
    cvol_array_info info;
    double most = 0, squares = 0, real = 0, point = 0, least = INFINITY, largest = -INFINITY,
           peak = 0;
    size_t exact = 0, with_value = 0;
    cvol_array_get_info(&info, array);
    for (size_t i = 0; i < t->count; i++) {
        const double before = support_load(t->samples, t->grid.type, i),
                     after = support_load(d->samples, t->grid.type, i);
        exact += !memcmp((const char *)t->samples + i * bytes, (const char *)d->samples + i * bytes,
                         bytes);
        if (d->mask[i])
            continue;
        with_value++;
        least = fmin(least, before);
        largest = fmax(largest, before);
        most = fmax(most, fabs(before - after));
        squares += (before - after) * (before - after);
        real = hypot(real, before - (double)d->real[i]);
        point = fmax(point, fabs(before - (double)d->real[i]));
        peak = fmax(peak, fabs((double)d->real[i]));
    }
    const double span = o->has_value_range ? info.value_max - info.value_min : largest - least,
                 psnr = 10 * log10(span * span * (double)with_value / squares);
    /* Effort fast measures on terms; the sums of others are in another order. */
    const double slack = o->effort == CVOL_EFFORT_FAST ? 0.02 : 1e-6;
    if (report->lossless && exact != t->count)
        violate(t, "samples of a lossless file that are exact", (double)exact, (double)t->count);
    if (o->lossless && !report->lossless)
        violate(t, "lossless", 0, 1);
    if (o->max_error > 0 && most > o->max_error)
        violate(t, "the largest error", most, o->max_error);
    if (o->target == CVOL_TARGET_MAX_ERROR && !o->lossless && most > o->target_value)
        violate(t, "the largest error", most, o->target_value);
    if (most > report->max_error * (1 + slack) + 4 * DBL_EPSILON * fmax(fabs(least), fabs(largest)))
        violate(t, "the largest error, and the report's", most, report->max_error);
    if (squares > 0 && span > 0 && psnr < report->psnr_db - fmax(slack * 8, 1e-6))
        violate(t, "the PSNR, and the report's", psnr, report->psnr_db);
    if (!report->lossless && report->target_met && o->target == CVOL_TARGET_PSNR && squares > 0 &&
        psnr < o->target_value - 8 * slack)
        violate(t, "the PSNR", psnr, o->target_value);
    if (report->target_met && o->target == CVOL_TARGET_RATIO && !o->lossless &&
        report->ratio < o->target_value)
        violate(t, "the ratio", report->ratio, o->target_value);
    if (real > info.l2_error * (1 + 1e-9))
        violate(t, "the L2 error, and its bound", real, info.l2_error);
    if (point > info.point_error || info.point_error > info.l2_error)
        violate(t, "the largest error before rounding, and its bound", point, info.point_error);
    if (peak > info.max_abs * (1 + 1e-7))
        violate(t, "the largest magnitude, and its bound", peak, info.max_abs);
    if (with_value && least < info.value_min)
        violate(t, "the least value, and its bound", least, info.value_min);
    if (with_value && largest > info.value_max)
        violate(t, "the largest value, and its bound", largest, info.value_max);
    double lowest, highest;
    cvol_type_get_range(&lowest, &highest, t->grid.type);
    if (o->has_value_range && with_value &&
        (info.value_min > fmax(o->value_min, lowest) ||
         info.value_max < fmin(o->value_max, highest)))
        violate(t, "the range of the original samples", info.value_min, o->value_min);
}

/* A file has the announced size, and its samples the same bits. */
static void check_file(trial *t, const decoded *d, const cvol_compress_report *report,
                       const cvol_array *array)
{
    void *bytes;
    size_t size;
    cvol_array *again;
    decoded second = {0};
    if (cvol_array_write_memory(t->context, array, &bytes, &size)) {
        violate(t, cvol_context_message(t->context), 0, 0);
        return;
    }
    if (size != report->file_bytes)
        violate(t, "bytes of the file", (double)size, (double)report->file_bytes);
    if (cvol_array_read_memory(t->context, &again, bytes, size, "file") ||
        decode(t, &second, again)) {
        violate(t, cvol_context_message(t->context), 0, 0);
    } else {
        if (memcmp(second.samples, d->samples, t->count * cvol_type_size(t->grid.type)) != 0)
            violate(t, "samples of the file differ", 0, 0);
        if (memcmp(second.mask, d->mask, t->count) != 0)
            violate(t, "missing samples of the file differ", 0, 0);
    }
    drop(&second);
    cvol_array_free(again);
    free(bytes);
}

static void run_trial(uint64_t seed, cvol_context *context)
{
    trial t = {.context = context, .random = {seed}, .seed = seed};
    cvol_array *array = NULL;
    cvol_compress_report report;
    decoded d = {0};
    choose_grid(&t);
    fill_samples(&t);
    choose_options(&t);
    cvol_context_set_threads(context, 1 + (int)below(&t, 2));
    if (cvol_compress(context, &array, &report, t.samples, &t.grid, &t.options)) {
        refusals++;
        if (!*cvol_context_message(context) || array)
            violate(&t, "refused without a sentence, or with an array", 0, 0);
        else if (test_verbose())
            printf("seed %llu: refused: %s\n", (unsigned long long)seed,
                   cvol_context_message(context));
    } else {
        files++;
        if (decode(&t, &d, array)) {
            violate(&t, cvol_context_message(context), 0, 0);
        } else {
            check_samples(&t, &d, &report, array);
            check_file(&t, &d, &report, array);
        }
    }
    drop(&d);
    cvol_array_free(array);
    free(t.samples);
}

int main(int argc, char **argv)
{
    const uint64_t last = try_seeds(argc, argv, 2000, run_trial);
    printf("compression: up to seed %llu: %llu files, %llu refused, %llu violations\n",
           (unsigned long long)last, files, refusals, violations);
    return violations != 0;
}
