/* The residual: exact samples round trip to the bit, bounded ones stay within their bound, for any
 * type, base and mask; damage does not crash. */
#include "test.h"

#include <limits.h>

#include "base/for_type.h"
#include "codec/residual/residual_code.h"
#include "random.h"

enum { MOST = 64 * 64 * 64 };

/* A brick: samples of a type, also as doubles; a base with errors of size `noise`. */
typedef struct subject {
    cvol_type type;
    size_t size[3], count;
    double step, min, max;
    uint64_t samples[MOST], decoded[MOST]; /* of any type */
    double values[MOST], base[MOST];
    uint8_t which[MOST];
} subject;

static double in_type(cvol_type type, double value)
{
    if (cvol_type_is_integer(type))
        return floor(value + 0.5);
    return type == CVOL_FLOAT32 ? (double)(float)value : value;
}

static void limits_of(double *lo, double *hi, cvol_type type)
{
    const double bits = 8 * (double)cvol_type_size(type);
    const int is_signed = type == CVOL_INT8 || type == CVOL_INT16 || type == CVOL_INT32;
    *lo = is_signed ? -ldexp(1, (int)bits - 1) : 0;
    *hi = *lo + ldexp(1, (int)bits) - 1;
    if (!cvol_type_is_integer(type)) {
        *lo = (double)-1e30f;
        *hi = (double)1e30f;
    }
}

static void make(subject *s, random_state *r, cvol_type type, double scale, double noise)
{
    double lo, hi;
    limits_of(&lo, &hi, type);
    s->type = type;
    s->step = noise;
    for (int a = 0; a < 3; a++)
        s->size[a] = 1 + random_below(r, random_below(r, 2) ? 12 : 40);
    s->count = s->size[0] * s->size[1] * s->size[2];
    s->min = INFINITY;
    s->max = -INFINITY;
    const int masked = random_below(r, 3) == 0;
    for (size_t i = 0; i < s->count; i++) {
        const double x = (double)(i % s->size[0]), y = (double)(i / s->size[0] % s->size[1]);
        const double value = scale * (sin(0.1 * x) + cos(0.13 * y) + 0.1 * random_signed(r));
        s->values[i] = in_type(type, fmin(hi, fmax(lo, value)));
        if (random_below(r, 300) == 0)
            s->values[i] = 0;
        if (random_below(r, 300) == 0)
            s->values[i] = in_type(type, s->values[i] * pow(10, -30 * random_signed(r)));
        s->values[i] = fmin(hi, fmax(lo, s->values[i]));
        s->which[i] = masked && random_below(r, 4) == 0;
        s->min = fmin(s->min, s->values[i]);
        s->max = fmax(s->max, s->values[i]);
    }
    for (size_t i = 0; i < s->count; i++) {
        const double base = s->values[i] + noise * random_signed(r);
        s->base[i] = fmin(s->max, fmax(s->min, in_type(type, base)));
    }
    memset(s->decoded, 0xa5, sizeof s->decoded);
#define STORE(t)                          \
    for (size_t i = 0; i < s->count; i++) \
    ((t *)(void *)s->samples)[i] = (t)s->values[i]
    CVOL_FOR_TYPE(type, STORE);
#undef STORE
}

static double decoded_at(const subject *s, size_t i)
{
    double value = 0;
#define LOAD(t) value = (double)((const t *)(const void *)s->decoded)[i]
    CVOL_FOR_TYPE(s->type, LOAD);
#undef LOAD
    return value;
}

typedef struct bench {
    cvol_token_tables *tables;
    cvol_residual_coder *coder;
    cvol_bytes bytes;
    subject s;
} bench;

static bench *bench_make(void)
{
    bench *b = calloc(1, sizeof *b);
    assert_non_null(b);
    b->tables = cvol_token_tables_create();
    b->coder = cvol_residual_coder_create();
    assert_true(b->tables && b->coder);
    return b;
}

static void bench_free(bench *b)
{
    free(b->tables);
    cvol_residual_coder_free(b->coder);
    cvol_bytes_free(&b->bytes);
    free(b);
}

static cvol_residual_rule rule_of(const subject *s, double bound)
{
    int grain = INT_MAX;
    double largest = 0;
    cvol_residual_scan(&grain, &largest, s->type, s->samples, s->which, s->count);
    return cvol_residual_rule_for(s->type, bound, s->step, s->min, s->max, grain, largest);
}

static void check(bench *b, double bound, uint64_t seed)
{
    subject *s = &b->s;
    const cvol_residual_rule rule = rule_of(s, bound);
    const cvol_residual_brick brick = {{s->size[0], s->size[1], s->size[2]}, s->base, s->which};
    const size_t size = cvol_type_size(s->type);
    assert_true(cvol_residual_rule_valid(&rule));
    if (cvol_residual_encode(b->coder, &b->bytes, &rule, bound, b->tables, s->samples, &brick,
                             NULL))
        fail_msg("seed %llu, type %d, bound %g: not held", (unsigned long long)seed, (int)s->type,
                 bound);
    const cvol_span span = {b->bytes.data, b->bytes.size};
    if (cvol_residual_decode(b->coder, s->decoded, &rule, b->tables, &brick, span))
        fail_msg("seed %llu, type %d, bound %g: does not decode", (unsigned long long)seed,
                 (int)s->type, bound);
    for (size_t i = 0; i < s->count; i++) {
        const uint8_t *was = (const uint8_t *)s->samples + size * i;
        const uint8_t *is = (const uint8_t *)s->decoded + size * i;
        int good;
        if (s->which[i])
            good = is[0] == 0xa5 && is[size - 1] == 0xa5;
        else if (bound > 0)
            good = fabs(decoded_at(s, i) - s->values[i]) <= bound;
        else
            good = memcmp(was, is, size) == 0;
        if (!good)
            fail_msg("seed %llu, type %d, bound %g, sample %zu: %.17g for %.17g (base %.17g)",
                     (unsigned long long)seed, (int)s->type, bound, i, decoded_at(s, i),
                     s->values[i], s->base[i]);
    }
}

static void test_exact_round_trip(void **state)
{
    (void)state;
    bench *b = bench_make();
    for (uint64_t seed = 1; seed <= 120; seed++) {
        random_state r = {seed};
        const cvol_type type = (cvol_type)(1 + seed % 8);
        const double scale = pow(10, 5 * random_signed(&r)) * (type > 6 ? 1 : 50);
        make(&b->s, &r, type, scale, scale * pow(10, -4 + 4 * random_signed(&r)));
        check(b, 0, seed);
    }
    bench_free(b);
}

static void test_bounds_hold(void **state)
{
    (void)state;
    bench *b = bench_make();
    for (uint64_t seed = 1; seed <= 160; seed++) {
        random_state r = {seed};
        const cvol_type type = (cvol_type)(1 + seed % 8);
        const double scale = pow(10, 3 * random_signed(&r)) * (type > 6 ? 1 : 50);
        make(&b->s, &r, type, scale, scale * pow(10, -4 + 3 * random_signed(&r)));
        check(b, (b->s.max - b->s.min) * pow(10, -0.5 - random_below(&r, 10)), seed);
    }
    bench_free(b);
}

/* Zeros of either sign, denormals, the largest numbers; a base far from the samples. */
static void test_all_reals(void **state)
{
    (void)state;
    bench *b = bench_make();
    subject *s = &b->s;
    for (uint64_t seed = 1; seed <= 40; seed++) {
        random_state r = {seed};
        const int is_double = seed & 1;
        make(s, &r, is_double ? CVOL_FLOAT64 : CVOL_FLOAT32, 1, seed % 3 ? 1e-3 : 1e-40);
        s->min = INFINITY;
        s->max = -INFINITY;
        for (size_t i = 0; i < s->count; i++) {
            const uint64_t word = random_u64(&r);
            if (is_double) {
                const uint64_t bits = word & 1 ? word & ~(UINT64_C(0x400) << 52)
                                               : word >> 12 | word << 63;
                memcpy(&s->values[i], &bits, sizeof bits);
                memcpy(&s->samples[i], &bits, sizeof bits);
            } else {
                const uint32_t bits = word & 1 ? (uint32_t)word & ~(UINT32_C(0x80) << 23)
                                               : (uint32_t)(word >> 41 | (word & 2) << 30);
                float value;
                memcpy(&value, &bits, sizeof bits);
                memcpy((uint8_t *)s->samples + 4 * i, &bits, sizeof bits);
                s->values[i] = (double)value;
            }
            s->min = fmin(s->min, s->values[i]);
            s->max = fmax(s->max, s->values[i]);
        }
        for (size_t i = 0; i < s->count; i++)
            s->base[i] = i % 3 ? s->values[s->count - 1 - i] : in_type(s->type, s->max / 3);
        check(b, 0, seed);
    }
    bench_free(b);
}

/* Integers in float samples cost as much as integers. */
static void test_coarse_floats_are_cheap(void **state)
{
    (void)state;
    bench *b = bench_make();
    subject *s = &b->s;
    random_state r = {7};
    size_t bytes[2];
    for (int i = 0; i < 2; i++) {
        r.state = 7;
        make(s, &r, CVOL_INT16, 400, 3);
        memset(s->which, 0, sizeof s->which);
        if (i) {
            s->type = CVOL_FLOAT32;
            for (size_t k = 0; k < s->count; k++)
                ((float *)(void *)s->samples)[k] = (float)s->values[k];
        }
        check(b, 0, 7);
        bytes[i] = b->bytes.size;
    }
    assert_true(bytes[1] <= bytes[0] + bytes[0] / 20 + 64);
    bench_free(b);
}

static void test_zero_residual_takes_no_bytes(void **state)
{
    (void)state;
    bench *b = bench_make();
    subject *s = &b->s;
    for (uint64_t seed = 1; seed <= 8; seed++) {
        random_state r = {seed};
        make(s, &r, CVOL_UINT8, 30, 1);
        memcpy(s->base, s->values, sizeof s->base);
        check(b, 0, seed);
        assert_int_equal(b->bytes.size, 0);
    }
    bench_free(b);
}

static void test_damage_is_detected(void **state)
{
    (void)state;
    bench *b = bench_make();
    subject *s = &b->s;
    for (uint64_t seed = 1; seed <= 300; seed++) {
        random_state r = {seed};
        const cvol_type type = (cvol_type)(1 + seed % 8);
        make(s, &r, type, type > 6 ? 1 : 100, type > 6 ? 0.01 : 5);
        const double bound = seed % 16 < 8 ? 0 : (s->max - s->min) * 1e-3;
        const cvol_residual_rule rule = rule_of(s, bound);
        const cvol_residual_brick brick = {{s->size[0], s->size[1], s->size[2]}, s->base, s->which};
        assert_int_equal(cvol_residual_encode(b->coder, &b->bytes, &rule, bound, b->tables,
                                              s->samples, &brick, NULL),
                         CVOL_OK);
        if (!b->bytes.size)
            continue;
        /* In separate memory, so that reads beyond it are detected. */
        const size_t size = seed % 5 ? b->bytes.size : random_below(&r, (uint32_t)b->bytes.size);
        uint8_t *copy = malloc(size ? size : 1);
        assert_non_null(copy);
        memcpy(copy, b->bytes.data, size);
        for (int i = 0; size && i < 3; i++)
            copy[random_below(&r, (uint32_t)size)] ^= (uint8_t)(1 << random_below(&r, 8));
        const cvol_span span = {copy, size};
        memset(s->decoded, 0, sizeof s->decoded);
        if (!cvol_residual_decode(b->coder, s->decoded, &rule, b->tables, &brick, span))
            for (size_t i = 0; i < s->count; i++)
                assert_true(s->which[i] ||
                            (decoded_at(s, i) >= s->min && decoded_at(s, i) <= s->max));
        free(copy);
    }
    bench_free(b);
}

static void test_invalid_rules(void **state)
{
    (void)state;
    const cvol_residual_rule good = {CVOL_FLOAT32, 1, 0, -10, -20, -1, 1};
    assert_true(cvol_residual_rule_valid(&good));
    cvol_residual_rule rule = good;
    rule.unit = -140;
    assert_false(cvol_residual_rule_valid(&rule));
    rule = good;
    rule.grain = -9;
    assert_false(cvol_residual_rule_valid(&rule));
    rule = good;
    rule.value_max = 1e30;
    assert_false(cvol_residual_rule_valid(&rule));
    rule = (cvol_residual_rule){CVOL_UINT8, 1, 1, 0, 0, 0, 255};
    assert_true(cvol_residual_rule_valid(&rule));
    rule.quantum = 2;
    assert_false(cvol_residual_rule_valid(&rule));
    rule = (cvol_residual_rule){CVOL_FLOAT64, 0, 0, 0, 0, 0, 255};
    assert_false(cvol_residual_rule_valid(&rule));
    rule.quantum = (double)NAN;
    assert_false(cvol_residual_rule_valid(&rule));
}

/* NaN and infinities have no last place: the scan skips them. */
static void test_scan_of_finite_samples(void **state)
{
    (void)state;
    const float samples[] = {1, NAN, INFINITY, -2.5f, -INFINITY, 0};
    const double doubles[] = {NAN, 0.25, INFINITY, 3};
    int grain = INT_MAX;
    double largest = 0;
    cvol_residual_scan(&grain, &largest, CVOL_FLOAT32, samples, NULL, 6);
    assert_int_equal(grain, -1);
    assert_float_equal(largest, 2.5, 0);
    cvol_residual_scan(&grain, &largest, CVOL_FLOAT64, doubles, NULL, 4);
    assert_int_equal(grain, -2);
    assert_float_equal(largest, 3, 0);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_exact_round_trip),
        cmocka_unit_test(test_bounds_hold),
        cmocka_unit_test(test_all_reals),
        cmocka_unit_test(test_coarse_floats_are_cheap),
        cmocka_unit_test(test_zero_residual_takes_no_bytes),
        cmocka_unit_test(test_damage_is_detected),
        cmocka_unit_test(test_scan_of_finite_samples),
        cmocka_unit_test(test_invalid_rules),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
