/* Transforms of whole arrays: every kind against the sums of fft.h in double precision, by length,
 * by layout of the lines and by shape; how rounding grows; and the same bits from every instruction
 * set. The seed of random numbers is printed; CVOL_FFT_SEED sets it. */
#include "test.h"

#include <time.h>

#include "base/cpu.h"
#include "random.h"
#include "support_context.h"
#include "transform/fft.h"

#define PI 3.14159265358979323846

enum { KINDS = 7 };
static const cvol_fft_kind kinds[KINDS] = {
    CVOL_FFT_FORWARD,         CVOL_FFT_INVERSE,         CVOL_FFT_DCT, CVOL_FFT_IDCT, CVOL_FFT_IDST,
    CVOL_FFT_COMPLEX_FORWARD, CVOL_FFT_COMPLEX_BACKWARD};
static const char *const names[KINDS] = {
    "FORWARD", "INVERSE", "DCT", "IDCT", "IDST", "COMPLEX_FORWARD", "COMPLEX_BACKWARD"};

static random_state numbers;

/* ---- elements ------------------------------------------------------------------------------- */

static size_t in_width(int k)
{
    return kinds[k] == CVOL_FFT_INVERSE || kinds[k] >= CVOL_FFT_COMPLEX_FORWARD ? 2 : 1;
}

static size_t out_width(int k)
{
    return kinds[k] == CVOL_FFT_FORWARD || kinds[k] >= CVOL_FFT_COMPLEX_FORWARD ? 2 : 1;
}

static size_t in_count(int k, size_t n)
{
    return kinds[k] == CVOL_FFT_INVERSE ? n / 2 + 1 : n;
}

static size_t out_count(int k, size_t n)
{
    return kinds[k] == CVOL_FFT_FORWARD ? n / 2 + 1 : n;
}

static void fill(float *values, size_t count)
{
    for (size_t i = 0; i < count; i++)
        values[i] = (float)random_signed(&numbers);
}

/* ---- the definition, of one line in double precision ----------------------------------------- */

/* cos(2 pi i / 4n), i = 0 .. 4n - 1: cached until another n is requested. */
static double *table_kept;

static const double *cosine_table(size_t n)
{
    static size_t kept;
    if (kept == n)
        return table_kept;
    free(table_kept);
    table_kept = malloc(4 * n * sizeof *table_kept);
    for (size_t i = 0; i < 4 * n; i++)
        table_kept[i] = cos(2 * PI * (double)i / (double)(4 * n));
    kept = n;
    return table_kept;
}

/* An angle in units of 1 / 4n turns that grows by a step. */
typedef struct angle {
    const double *table;
    size_t n, at, step;
} angle;

static angle angle_of(const double *table, size_t n, size_t first, size_t step)
{
    return (angle){table, n, first % (4 * n), step % (4 * n)};
}

static double cosine(const angle *of)
{
    return of->table[of->at];
}

static double sine(const angle *of)
{
    return of->table[of->at >= of->n ? of->at - of->n : of->at + 3 * of->n];
}

static void advance(angle *of)
{
    of->at += of->step;
    of->at -= of->at >= 4 * of->n ? 4 * of->n : 0;
}

static void complex_sum(double out[2], const double *in, size_t n, size_t u, double sign, int half,
                        const double *table)
{
    angle t = angle_of(table, n, 0, 4 * u);
    for (size_t x = 0; x < n; x++, advance(&t)) {
        const int mirrored = half && x > n / 2;
        const double *value = in + 2 * (mirrored ? n - x : x);
        const double im = half && (x == 0 || 2 * x == n) ? 0 : mirrored ? -value[1] : value[1];
        out[0] += value[0] * cosine(&t) - im * sign * sine(&t);
        out[1] += value[0] * sign * sine(&t) + im * cosine(&t);
    }
}

/* Element u of a line's transform; in: as many numbers as the kind reads. */
static void direct(double out[2], int k, const double *in, size_t n, size_t u, const double *table)
{
    angle forward = angle_of(table, n, 0, 4 * u), cosines = angle_of(table, n, u, 2 * u);
    angle inverse = angle_of(table, n, 2 * u + 1, 2 * u + 1);
    out[0] = out[1] = 0;
    switch (kinds[k]) {
    case CVOL_FFT_FORWARD:
        for (size_t x = 0; x < n; x++, advance(&forward)) {
            out[0] += in[x] * cosine(&forward);
            out[1] -= in[x] * sine(&forward);
        }
        break;
    case CVOL_FFT_INVERSE:
        complex_sum(out, in, n, u, 1, 1, table);
        break;
    case CVOL_FFT_DCT:
        for (size_t x = 0; x < n; x++, advance(&cosines))
            out[0] += 2 * in[x] * cosine(&cosines);
        break;
    case CVOL_FFT_IDCT:
        out[0] = in[0];
        for (size_t x = 1; x < n; x++, advance(&inverse))
            out[0] += 2 * in[x] * cosine(&inverse);
        break;
    case CVOL_FFT_IDST:
        out[0] = u % 2 ? -in[n - 1] : in[n - 1];
        for (size_t x = 0; x + 1 < n; x++, advance(&inverse))
            out[0] += 2 * in[x] * sine(&inverse);
        break;
    case CVOL_FFT_COMPLEX_FORWARD:
        complex_sum(out, in, n, u, -1, 0, table);
        break;
    default:
        complex_sum(out, in, n, u, 1, 0, table);
    }
}

static int has_prime_above(size_t n, size_t most)
{
    for (size_t p = 2; p <= most; p++)
        while (n % p == 0)
            n /= p;
    return n > 1;
}

/* Bound of the root mean square error of a line of n elements in single precision, relative to the
 * root mean square of the line. Every halving of the line and every product adds a rounding of
 * 2^-24, and errors of different steps add as squares. A factor above 61 is a convolution: two
 * transforms of at most four times the length, and three products. */
static double tolerance(size_t n)
{
    const double halvings = log2((double)n);
    return 1.5e-7 * sqrt(has_prime_above(n, 61) ? 2 * (halvings + 2) + 3 : halvings + 1);
}

static void check(double difference, double size, size_t n, const char *what, int k)
{
    const double error = size > 0 ? sqrt(difference / size) : sqrt(difference);
    if (!(error <= tolerance(n)))
        fail_msg("%s of %zu, %s: error %.3g, at most %.3g", names[k], n, what, error, tolerance(n));
}

/* ---- lines ----------------------------------------------------------------------------------- */

typedef enum layout { ROWS, COLUMNS, SCATTERED, LAYOUTS } layout;
static const char *const layouts[LAYOUTS] = {"rows", "columns", "scattered"};

/* The index of element i of line l, in elements. */
static void set_layout(layout of, size_t elements, size_t count, size_t *stride, size_t *distance)
{
    *stride = of == ROWS ? 1 : of == COLUMNS ? count + 1 : 2 * count;
    *distance = of == ROWS ? elements + 3 : of == COLUMNS ? 1 : 2;
}

/* Elements of line l against direct sums, every one or `some` random ones. */
static void check_line(int k, const cvol_fft_lines *lines, size_t l, const float *out,
                       const float *in, size_t some, const char *what)
{
    const size_t n = lines->n, wi = in_width(k), wo = out_width(k), elements = out_count(k, n);
    const size_t tried = some ? some : elements;
    const double *table = cosine_table(n);
    double *line = malloc(2 * n * sizeof *line + 2 * sizeof *line);
    for (size_t i = 0; i < in_count(k, n); i++)
        for (size_t p = 0; p < wi; p++)
            line[wi * i + p] = (double)in[wi * (i * lines->in_stride + l * lines->in_distance) + p];
    double difference = 0, size = 0;
    for (size_t u = 0; u < elements; u++)
        for (size_t p = 0; p < wo; p++) {
            const double found = (double)
                out[wo * (u * lines->out_stride + l * lines->out_distance) + p];
            size += found * found;
        }
    for (size_t t = 0; t < tried; t++) {
        const size_t u = some ? random_below(&numbers, (uint32_t)elements) : t;
        double sum[2];
        direct(sum, k, line, n, u, table);
        for (size_t p = 0; p < wo; p++) {
            const double found = (double)
                out[wo * (u * lines->out_stride + l * lines->out_distance) + p];
            difference += (found - sum[p]) * (found - sum[p]);
        }
    }
    free(line);
    check(difference / (double)tried, size / (double)elements, n, what, k);
}

/* `count` lines of n points. Input beyond the lines has no effect, and output beyond them stays
 * unchanged. */
static void try_lines(int k, size_t n, size_t count, layout of, int in_place, size_t some)
{
    cvol_fft_lines lines = {.n = n, .count = count};
    set_layout(of, in_count(k, n), count, &lines.in_stride, &lines.in_distance);
    set_layout(of, out_count(k, n), count, &lines.out_stride, &lines.out_distance);
    const size_t in_floats = in_width(k) * (n * lines.in_stride + count * lines.in_distance + 8);
    const size_t out_floats = out_width(k) *
                              (n * lines.out_stride + count * lines.out_distance + 8);
    float *in = cvol_fft_allocate(in_floats), *kept = cvol_fft_allocate(in_floats);
    float *out = in_place ? in : cvol_fft_allocate(out_floats);
    fill(in, in_floats);
    memcpy(kept, in, in_floats * sizeof *in);
    for (size_t i = 0; i < out_floats && !in_place; i++)
        out[i] = 777;
    assert_int_equal(cvol_fft_along(context, kinds[k], &lines, out, in), CVOL_OK);
    check_line(k, &lines, 0, out, kept, some, layouts[of]);
    if (count > 1) {
        check_line(k, &lines, count - 1, out, kept, some, layouts[of]);
        check_line(k, &lines, random_below(&numbers, (uint32_t)count), out, kept, some,
                   layouts[of]);
    }
    const float *outside = in_place ? kept : NULL;
    for (size_t i = 0; i < n && of == COLUMNS; i++)
        for (size_t p = 0; p < out_width(k) && i < out_count(k, n); p++) {
            const size_t at = out_width(k) * (i * lines.out_stride + count) + p;
            assert_true(out[at] == (outside ? outside[at] : 777));
        }
    if (!in_place && kinds[k] != CVOL_FFT_INVERSE)
        assert_memory_equal(in, kept, in_floats * sizeof *in);
    if (!in_place)
        free(out);
    free(in);
    free(kept);
}

static int needs_two_buffers(int k)
{
    return kinds[k] == CVOL_FFT_FORWARD || kinds[k] == CVOL_FFT_INVERSE;
}

static void test_every_length_to_200(void **state)
{
    (void)state;
    for (size_t n = 1; n <= 200; n++)
        for (int k = 0; k < KINDS; k++)
            for (layout of = ROWS; of < LAYOUTS; of++) {
                const size_t count = of == ROWS ? 5 + n % 17 : 19;
                try_lines(k, n, count, of, 0, 0);
                try_lines(k, n, 1, of, 0, 0);
                if (!needs_two_buffers(k))
                    try_lines(k, n, count, of, (int)(n % 2), 0);
            }
}

/* Long lines, single and in batches: any lengths, primes, and lengths with a large prime factor. */
static void test_long_lines(void **state)
{
    (void)state;
    size_t lengths[40] = {211,   251,  509,   512,    1021,  2048,      4096,
                          4099,  4100, 5000,  10007,  20014, 3 * 10007, 60 * 1009,
                          65536, 9973, 65537, 360360, 6561,  16807};
    const size_t known = 20;
    for (size_t i = known; i < 40; i++)
        lengths[i] = 201 + random_below(&numbers, i % 2 ? 2000 : 30000);
    for (size_t i = 0; i < 40; i++)
        for (int k = 0; k < KINDS; k++) {
            const size_t n = lengths[i];
            try_lines(k, n, 1, ROWS, 0, n < 20000 ? 64 : 16);
            if (n <= 10007)
                try_lines(k, n, 6, ROWS, !needs_two_buffers(k), 64);
            if (n <= 4100)
                try_lines(k, n, 21, COLUMNS, !needs_two_buffers(k), 64);
            if (i % 4 == 0 && n < 10007)
                try_lines(k, n, 2, SCATTERED, 0, 64);
        }
}

/* ---- shapes ---------------------------------------------------------------------------------- */

/* A transform along one axis of a whole array of doubles, `in` and `out` with different widths. */
static void direct_axis(double *out, const double *in, int k, size_t before, size_t n, size_t after)
{
    const size_t wi = in_width(k), wo = out_width(k), ni = in_count(k, n), no = out_count(k, n);
    const double *table = cosine_table(n);
    double *line = malloc((2 * n + 2) * sizeof *line);
    for (size_t a = 0; a < after; a++)
        for (size_t b = 0; b < before; b++) {
            for (size_t i = 0; i < ni; i++)
                memcpy(line + wi * i, in + wi * (b + before * (i + ni * a)), wi * sizeof *line);
            for (size_t u = 0; u < no; u++) {
                double sum[2];
                direct(sum, k, line, n, u, table);
                memcpy(out + wo * (b + before * (u + no * a)), sum, wo * sizeof *sum);
            }
        }
    free(line);
}

static int index_of(cvol_fft_kind kind)
{
    int k = 0;
    while (kinds[k] != kind)
        k++;
    return k;
}

/* All axes longer than 1; the half complex axis first in FORWARD, last in INVERSE. */
static double *direct_shape(int k, const size_t dims[3], const double *in, size_t room)
{
    double *from = malloc(room * sizeof *from), *to = malloc(room * sizeof *to);
    memcpy(from, in, room * sizeof *from);
    const int backward = kinds[k] == CVOL_FFT_INVERSE;
    const size_t half = dims[0] / 2 + 1, row = needs_two_buffers(k) ? half : dims[0];
    for (int i = 0; i < 3; i++) {
        const int axis = backward ? 2 - i : i;
        int of = k;
        if (axis && needs_two_buffers(k))
            of = index_of(backward ? CVOL_FFT_COMPLEX_BACKWARD : CVOL_FFT_COMPLEX_FORWARD);
        if (dims[axis] == 1 && (axis || !needs_two_buffers(k)))
            continue;
        const size_t before = axis == 0 ? 1 : axis == 1 ? row : row * dims[1];
        const size_t after = axis == 0 ? dims[1] * dims[2] : axis == 1 ? dims[2] : 1;
        direct_axis(to, from, of, before, dims[axis], after);
        double *const other = from;
        from = to;
        to = other;
    }
    free(to);
    return from;
}

static void try_shape(int k, const size_t dims[3], int in_place)
{
    const size_t count = dims[0] * dims[1] * dims[2];
    const size_t half = 2 * (dims[0] / 2 + 1) * dims[1] * dims[2];
    const size_t floats[3] = {count, half, 2 * count};
    const size_t reads = floats[kinds[k] == CVOL_FFT_INVERSE ? 1 : in_width(k) == 2 ? 2 : 0];
    const size_t writes = floats[kinds[k] == CVOL_FFT_FORWARD ? 1 : out_width(k) == 2 ? 2 : 0];
    const size_t room = half + 2 * count;
    float *in = cvol_fft_allocate(room), *out = in_place ? in : cvol_fft_allocate(room);
    double *exact = calloc(room, sizeof *exact);
    fill(in, reads);
    if (kinds[k] == CVOL_FFT_INVERSE) { /* spectra of real samples */
        float *samples = cvol_fft_allocate(count);
        fill(samples, count);
        assert_int_equal(cvol_fft(context, CVOL_FFT_FORWARD, dims, in, samples), CVOL_OK);
        free(samples);
    }
    for (size_t i = 0; i < reads; i++)
        exact[i] = (double)in[i];
    double *sums = direct_shape(k, dims, exact, room), difference = 0, size = 0;
    assert_int_equal(cvol_fft(context, kinds[k], dims, out, in), CVOL_OK);
    for (size_t i = 0; i < writes; i++) {
        difference += ((double)out[i] - sums[i]) * ((double)out[i] - sums[i]);
        size += sums[i] * sums[i];
    }
    char what[80];
    snprintf(what, sizeof what, "%zu x %zu x %zu", dims[0], dims[1], dims[2]);
    check(difference, size, count, what, k);
    if (!in_place)
        free(out);
    free(in);
    free(exact);
    free(sums);
}

static void test_shapes(void **state)
{
    (void)state;
    size_t shapes[24][3] = {{1, 1, 1},   {2, 1, 1},   {1, 2, 1},   {1, 1, 7},   {16, 16, 1},
                            {33, 17, 1}, {5, 6, 7},   {32, 8, 20}, {1, 40, 30}, {40, 1, 30},
                            {3, 100, 5}, {17, 31, 2}, {67, 3, 4},  {4, 4, 71},  {150, 2, 2}};
    for (size_t s = 15; s < 24; s++)
        for (int a = 0; a < 3; a++)
            shapes[s][a] = 1 + random_below(&numbers, 40);
    for (size_t s = 0; s < 24; s++)
        for (int k = 0; k < KINDS; k++) {
            try_shape(k, shapes[s], 0);
            if (!needs_two_buffers(k))
                try_shape(k, shapes[s], 1);
        }
}

/* ---- other properties ------------------------------------------------------------------------ */

/* A line of zeros next to other lines stays zero; ends of spectra of real lines are real. */
static void test_exact_numbers(void **state)
{
    (void)state;
    static const size_t lengths[] = {2, 7, 8, 15, 60, 64, 67, 100, 134, 1009};
    for (size_t i = 0; i < sizeof lengths / sizeof *lengths; i++)
        for (int k = 0; k < KINDS; k++) {
            const size_t n = lengths[i], ni = in_width(k) * in_count(k, n);
            const size_t no = out_width(k) * out_count(k, n);
            const cvol_fft_lines lines = {n, 20, 1, in_count(k, n), 1, out_count(k, n)};
            float *in = cvol_fft_allocate(20 * ni), *out = cvol_fft_allocate(20 * no);
            fill(in, 20 * ni);
            memset(in + 3 * ni, 0, ni * sizeof *in);
            assert_int_equal(cvol_fft_along(context, kinds[k], &lines, out, in), CVOL_OK);
            for (size_t x = 0; x < no; x++)
                assert_true(out[3 * no + x] == 0);
            for (size_t l = 0; l < 20 && kinds[k] == CVOL_FFT_FORWARD; l++) {
                assert_true(out[l * no + 1] == 0);
                assert_true(n % 2 || out[l * no + n + 1] == 0);
            }
            free(in);
            free(out);
        }
}

/* FNV-1a over the results of many transforms of numbers that do not depend on the seed. */
static uint64_t digest(void)
{
    uint64_t hash = UINT64_C(0xCBF29CE484222325);
    numbers.state = 31;
    for (size_t n = 1; n < 1300; n += 1 + n / 16)
        for (int k = 0; k < KINDS; k++)
            for (size_t i = 0; i < 3; i++) {
                const size_t count = (const size_t[]){1, 7, 37}[i], row = out_count(k, n);
                const cvol_fft_lines lines = {
                    n, count, i == 2 ? count : 1, i == 2 ? 1 : in_count(k, n), 1, row};
                const size_t reads = in_width(k) * in_count(k, n) * count;
                const size_t writes = out_width(k) * row * count;
                float *in = cvol_fft_allocate(reads), *out = cvol_fft_allocate(writes);
                fill(in, reads);
                if (cvol_fft_along(context, kinds[k], &lines, out, in))
                    return 0;
                for (size_t b = 0; b < writes * sizeof *out; b++)
                    hash = (hash ^ ((const unsigned char *)out)[b]) * UINT64_C(0x100000001B3);
                free(in);
                free(out);
            }
    return hash;
}

static const char *program;

/* The digest of a process that uses an instruction set. */
static void test_same_bits_from_every_set(void **state)
{
    (void)state;
    if (cvol_cpu_best() == CVOL_CPU_BASE)
        skip(); /* there is no other set */
    const uint64_t own = digest();
    assert_true(own != 0);
    for (int cpu = CVOL_CPU_BASE; cpu <= (int)cvol_cpu_best(); cpu++) {
        char *command;
        assert_true(asprintf(&command, "CVOL_CPU=%s '%s' digest", cvol_cpu_name((cvol_cpu)cpu),
                             program) > 0);
        FILE *process = popen(command, "r");
        char set[16] = "";
        unsigned long long other = 0;
        assert_non_null(process);
        assert_int_equal(fscanf(process, "%15s %llx", set, &other), 2);
        assert_int_equal(pclose(process), 0);
        assert_string_equal(set, cvol_cpu_name((cvol_cpu)cpu));
        if (own != other)
            fail_msg("%s computes other bits than %s", set, cvol_cpu_name(cvol_cpu_best()));
        free(command);
    }
    for (int cpu = (int)cvol_cpu_best() + 1; cpu <= CVOL_CPU_AVX512; cpu++)
        print_message("skipped: %s, which this processor does not have\n",
                      cvol_cpu_name((cvol_cpu)cpu));
}

int main(int count, char **texts)
{
    program = texts[0];
    if (count > 1 && !strcmp(texts[1], "digest")) {
        context_setup(NULL);
        printf("%s %llx\n", cvol_cpu_name(cvol_cpu_best()), (unsigned long long)digest());
        context_teardown(NULL);
        return 0;
    }
    const char *seed = getenv("CVOL_FFT_SEED");
    numbers.state = seed ? strtoull(seed, NULL, 10) : (uint64_t)time(NULL);
    print_message("seed %llu\n", (unsigned long long)numbers.state);
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_every_length_to_200),
        cmocka_unit_test(test_long_lines),
        cmocka_unit_test(test_shapes),
        cmocka_unit_test(test_exact_numbers),
        cmocka_unit_test(test_same_bits_from_every_set),
    };
    const int failed = cmocka_run_group_tests(tests, context_setup, context_teardown);
    free(table_kept);
    return failed;
}
