/* Samples of every type from floats, floats from them, and their distances: against plain loops, to
 * the bit, by every instruction set. */
#include "test.h"

#include "array/core/samples.h"
#include "base/cpu.h"
#include "base/for_type.h"
#include "codec/rate/compare_rows.h"
#include "random.h"
#include "support_kernels.h"

enum { MOST = 131, PARTS = 8, ATTEMPTS = 400 };

typedef void load_function(float *, const void *, cvol_type, size_t, size_t, double);
typedef void convert_function(void *, const float *, size_t, const cvol_sample_format *);
typedef void samples_function(cvol_row_distance *, const void *, size_t, const void *, cvol_type,
                              size_t);
typedef void reals_function(cvol_row_distance *, const void *, size_t, const float *, double,
                            cvol_type, size_t);
typedef void stored_function(cvol_row_distance *, const void *, size_t, const float *, size_t,
                             const cvol_sample_format *);

CVOL_SIMD_DECLARE(void, cvol_samples_load,
                  (float *, const void *, cvol_type, size_t, size_t, double));
CVOL_SIMD_DECLARE(void, cvol_samples_convert,
                  (void *, const float *, size_t, const cvol_sample_format *));
CVOL_SIMD_DECLARE(void, cvol_compare_samples,
                  (cvol_row_distance *, const void *, size_t, const void *, cvol_type, size_t));
CVOL_SIMD_DECLARE(void, cvol_compare_reals,
                  (cvol_row_distance *, const void *, size_t, const float *, double, cvol_type,
                   size_t));
CVOL_SIMD_DECLARE(void, cvol_compare_stored,
                  (cvol_row_distance *, const void *, size_t, const float *, size_t,
                   const cvol_sample_format *));

static load_function *const load[] = CVOL_SIMD_SETS(cvol_samples_load);
static convert_function *const convert[] = CVOL_SIMD_SETS(cvol_samples_convert);
static samples_function *const compare_samples[] = CVOL_SIMD_SETS(cvol_compare_samples);
static reals_function *const compare_reals[] = CVOL_SIMD_SETS(cvol_compare_reals);
static stored_function *const compare_stored[] = CVOL_SIMD_SETS(cvol_compare_stored);

/* Random samples of a type, and a range that some of the floats exceed. */
typedef struct row {
    cvol_sample_format as;
    size_t first, count;
    double storage[2 * MOST]; /* of any type */
    float reals[MOST];
} row;

static double type_most(cvol_type type)
{
    const int bits = 8 * (int)cvol_type_size(type);
    const int is_signed = type == CVOL_INT8 || type == CVOL_INT16 || type == CVOL_INT32;
    return is_signed ? ldexp(1, bits - 1) - 1 : ldexp(1, bits) - 1;
}

#define FILL(type)                                                                       \
    do {                                                                                 \
        type *to = (type *)r->storage;                                                   \
        for (size_t i = 0; i < r->first + r->count; i++)                                 \
            to[i] = (type)(r->as.lo +                                                    \
                           (r->as.hi - r->as.lo) * (0.5 + 0.5 * random_signed(random))); \
    } while (0)

static void make_row(row *r, cvol_type type, random_state *random)
{
    static const float special[] = {INFINITY, -INFINITY, NAN, 3e38f, -3e38f, 0.5f, -0.5f, -0.0f};
    const int is_integer = cvol_type_is_integer(type);
    const double most = is_integer ? type_most(type) : 1e6, spread = random_below(random, 3);
    memset(r, 0, sizeof *r);
    r->first = random_below(random, 9);
    r->count = random_below(random, MOST - 8);
    r->as.type = type;
    r->as.lo = most * 0.25 * (0.5 + 0.5 * random_signed(random));
    r->as.hi = r->as.lo + most * 0.7 * (0.5 + 0.5 * random_signed(random));
    r->as.offset = random_below(random, 2) ? r->as.lo : most * 0.1 * random_signed(random);
    if (is_integer) {
        r->as.lo = floor(r->as.lo);
        r->as.hi = floor(r->as.hi);
        if (random_below(random, 2))
            r->as.offset = floor(r->as.offset);
    }
    CVOL_FOR_TYPE(type, FILL);
    for (size_t i = 0; i < r->count; i++) {
        const double share = 0.5 + (0.5 + 0.2 * spread) * random_signed(random);
        double real = (r->as.hi - r->as.lo) * share;
        if (random_below(random, 4) == 0)
            real = floor(real) + 0.5;
        r->reals[i] = (float)real;
        if (spread > 1 && random_below(random, 9) == 0)
            r->reals[i] = special[random_below(random, sizeof special / sizeof *special)];
    }
}

/* ---- by definition ---------------------------------------------------------------------- */

static double as_integer(double real, const cvol_sample_format *as)
{
    const double whole = floor(real + as->offset + 0.5);
    return whole >= as->hi ? as->hi : whole > as->lo ? whole : as->lo;
}

static double as_real(double real, const cvol_sample_format *as)
{
    const double value = real + as->offset;
    return value < as->lo ? as->lo : value > as->hi ? as->hi : value;
}

#define CONVERT(kind)                                                                         \
    do {                                                                                      \
        kind *to = (kind *)out;                                                               \
        for (size_t i = 0; i < r->count; i++)                                                 \
            to[i] = (kind)(cvol_type_is_integer(r->as.type) ? as_integer(r->reals[i], &r->as) \
                                                            : as_real(r->reals[i], &r->as));  \
    } while (0)

static void convert_reference(double *out, const row *r)
{
    CVOL_FOR_TYPE(r->as.type, CONVERT);
}

#define LOAD(type)                                              \
    do {                                                        \
        const type *from = (const type *)r->storage + r->first; \
        for (size_t i = 0; i < r->count; i++)                   \
            out[i] = (float)((double)from[i] - r->as.offset);   \
    } while (0)

static void load_reference(float *out, const row *r)
{
    CVOL_FOR_TYPE(r->as.type, LOAD);
}

static double sum_of(const double parts[PARTS])
{
    return ((parts[0] + parts[1]) + (parts[2] + parts[3])) +
           ((parts[4] + parts[5]) + (parts[6] + parts[7]));
}

#define COMPARE(type)                                                                     \
    do {                                                                                  \
        const type *a = (const type *)r->storage + r->first;                              \
        const type *b = (const type *)decoded;                                            \
        for (size_t i = 0; i < r->count; i++) {                                           \
            const size_t k = i < r->count / PARTS * PARTS ? i % PARTS : 0;                \
            const double value = (float)((double)r->reals[i] + r->as.offset);             \
            const double error = (double)a[i] - (double)b[i];                             \
            const double real_error = (double)a[i] - value;                               \
            squares[k] += error * error;                                                  \
            real_squares[k] += real_error * real_error;                                   \
            norms[k] += value * value;                                                    \
            out->most = fabs(error) > out->most ? fabs(error) : out->most;                \
            out->real_most = fabs(value) > out->real_most ? fabs(value) : out->real_most; \
        }                                                                                 \
    } while (0)

static void compare_reference(cvol_row_distance *out, const row *r)
{
    double squares[PARTS] = {0}, real_squares[PARTS] = {0}, norms[PARTS] = {0}, decoded[MOST];
    convert_reference(decoded, r);
    *out = (cvol_row_distance){0};
    CVOL_FOR_TYPE(r->as.type, COMPARE);
    out->squares = sum_of(squares);
    out->real_squares = sum_of(real_squares);
    out->real_norms = sum_of(norms);
}

/* ---- tests ------------------------------------------------------------------------------ */

/* NaN equals NaN with any sign. */
static int same(double a, double b)
{
    return memcmp(&a, &b, sizeof a) == 0 || (isnan(a) && isnan(b));
}

static int same_distance(const cvol_row_distance *a, const cvol_row_distance *b)
{
    return same(a->most, b->most) && same(a->squares, b->squares) &&
           same(a->real_squares, b->real_squares) && same(a->real_norms, b->real_norms) &&
           same(a->real_most, b->real_most);
}

static int same_floats(const float *a, const float *b, size_t count)
{
    for (size_t i = 0; i < count; i++)
        if (!same((double)a[i], (double)b[i]))
            return 0;
    return 1;
}

static int same_samples(const void *a, const void *b, const cvol_sample_format *as, size_t count)
{
    if (as->type == CVOL_FLOAT32)
        return same_floats(a, b, count);
    if (as->type == CVOL_FLOAT64) {
        for (size_t i = 0; i < count; i++)
            if (!same(((const double *)a)[i], ((const double *)b)[i]))
                return 0;
        return 1;
    }
    return !memcmp(a, b, count * cvol_type_size(as->type));
}

static int check_row(const row *r, int set)
{
    float loaded[MOST], expected_loaded[MOST];
    double stored[MOST + 1] = {0}, expected_stored[MOST] = {0};
    cvol_row_distance apart = {0}, together, expected;
    load[set](loaded, r->storage, r->as.type, r->first, r->count, r->as.offset);
    load_reference(expected_loaded, r);
    convert[set](stored, r->reals, r->count, &r->as);
    convert_reference(expected_stored, r);
    compare_reference(&expected, r);
    compare_samples[set](&apart, r->storage, r->first, stored, r->as.type, r->count);
    compare_reals[set](&apart, r->storage, r->first, r->reals, r->as.offset, r->as.type, r->count);
    compare_stored[set](&together, r->storage, r->first, r->reals, r->count, &r->as);
    return same_floats(loaded, expected_loaded, r->count) &&
           same_samples(stored, expected_stored, &r->as, r->count) &&
           same_distance(&apart, &expected) && same_distance(&together, &expected);
}

static void rows_equal_reference_loops(void **state)
{
    static const cvol_type types[] = {CVOL_UINT8,  CVOL_INT8,  CVOL_UINT16,  CVOL_INT16,
                                      CVOL_UINT32, CVOL_INT32, CVOL_FLOAT32, CVOL_FLOAT64};
    (void)state;
    for (uint64_t seed = 1; seed <= ATTEMPTS; seed++)
        for (size_t t = 0; t < sizeof types / sizeof *types; t++) {
            random_state random = {seed};
            row r;
            make_row(&r, types[t], &random);
            for (int set = 0; set <= (int)cvol_cpu_best(); set++)
                if (!check_row(&r, set))
                    fail_msg("seed %d, %s, instruction set %s", (int)seed, cvol_type_name(types[t]),
                             cvol_cpu_name((cvol_cpu)set));
        }
}

static void bounds_fit_the_type(void **state)
{
    cvol_array array = {.grid = cvol_grid_make(1, 1, 1, CVOL_UINT8)};
    uint8_t out[3];
    const float in[3] = {-1e9f, 100.25f, 1e9f};
    (void)state;
    array.error_bound.value_min = -3.5;
    array.error_bound.value_max = 300.5;
    cvol_samples_store(out, in, 3, &array);
    assert_int_equal(out[0], 0);
    assert_int_equal(out[1], 100);
    assert_int_equal(out[2], 255);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(rows_equal_reference_loops),
        cmocka_unit_test(bounds_fit_the_type),
    };
    kernels_print_sets();
    return cmocka_run_group_tests(tests, NULL, NULL);
}
