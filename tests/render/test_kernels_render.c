/* Kernels that resample pictures and spectra: each against its formula in double precision on
 * random data, by every instruction set.
 *
 * u = 2^-24 is the unit of rounding. A sum of n products of floats is off by at most n u times the
 * sum of the products' magnitudes, in any order, with fused multiply-add or without. The error of
 * bytes is at most half a level of rounding plus 1/1000. Places lie where single precision has them
 * exactly, so that all sets agree about the sample before them.
 */
#include "test.h"

#include "base/cpu.h"
#include "image/spline_row.h"
#include "render/fourier/spectrum.h"
#include "render/sheet/warp/row.h"
#include "support_kernels.h"

enum { CASES = 40 };

#define UNIT 0x1p-24

static double clamp(double value, double lo, double hi)
{
    return value < lo ? lo : value > hi ? hi : value;
}

static void expect_byte(uint8_t found, double level, const char *what, int set)
{
    if (!(fabs(found - 255 * clamp(level, 0, 1)) <= 0.501))
        fail_msg("%s, %s: %d, not %g", what, cvol_cpu_name((cvol_cpu)set), found, 255 * level);
}

/* ---- cubic filters --------------------------------------------------------------------------- */

/* Weights of the neighbours -1, 0, 1, 2 at fraction t: of the B-spline, and of Catmull and Rom. */
static void weigh_spline(double w[4], double t)
{
    w[0] = (1 - t) * (1 - t) * (1 - t) / 6;
    w[1] = (3 * t * t * t - 6 * t * t + 4) / 6;
    w[2] = (-3 * t * t * t + 3 * t * t + 3 * t + 1) / 6;
    w[3] = t * t * t / 6;
}

static void weigh_catmull_rom(double w[4], double t)
{
    w[0] = (-t * t * t + 2 * t * t - t) / 2;
    w[1] = (3 * t * t * t - 5 * t * t + 2) / 2;
    w[2] = (-3 * t * t * t + 4 * t * t + t) / 2;
    w[3] = (t * t * t - t * t) / 2;
}

/* A weight is a polynomial whose coefficients' magnitudes add up to 5 at most, so the error of
 * Horner's scheme is 5 * 6 u; 4 weights along each axis, whose magnitudes add up to 1.25 at most;
 * then 16 products. Values are at most 1. */
#define FILTER_ERROR ((2 * 4 * 1.25 * 30 + 16 * 1.6) * UNIT)

/* Pixels of four floats, `empty` around them. */
typedef struct lattice {
    const float *pixels;
    long width, height, stride;
    const float *empty;
} lattice;

static void filter_at(double out[4], const lattice *of, double u, double v,
                      void (*weigh)(double[4], double))
{
    const long x = (long)floor(u), y = (long)floor(v);
    double across[4], down[4];
    weigh(across, (double)(float)(u - (double)x));
    weigh(down, (double)(float)(v - (double)y));
    for (int c = 0; c < 4; c++) {
        out[c] = 0;
        for (long j = 0; j < 4; j++)
            for (long i = 0; i < 4; i++) {
                const long at_x = x + i - 1, at_y = y + j - 1;
                const int there = at_x >= 0 && at_y >= 0 && at_x < of->width && at_y < of->height;
                out[c] += across[i] * down[j] *
                          (double)(there ? of->pixels[at_y * of->stride + 4 * at_x + c]
                                         : of->empty[c]);
            }
    }
}

/* Fills a lattice: each row has a random, non-empty range. ranges[y]: for rows y - 1 .. y + 2, from
 * the first to one past the last. */
static void fill_grid(float *pixels, int (*ranges)[2], const lattice *of, random_state *r)
{
    int rows[64][2];
    for (long y = 0; y < of->height; y++) {
        rows[y][0] = (int)random_below(r, (uint32_t)of->width);
        rows[y][1] = rows[y][0] + (int)random_below(r, (uint32_t)(of->width - rows[y][0] + 1));
        if (random_below(r, 4) == 0)
            rows[y][1] = rows[y][0];
        for (long x = 0; x < of->width; x++)
            for (int c = 0; c < 4; c++)
                pixels[y * of->stride + 4 * x + c] = x >= rows[y][0] && x < rows[y][1]
                                                         ? (float)(c == 3 ? fabs(random_signed(r))
                                                                          : random_signed(r))
                                                         : of->empty[c];
    }
    for (long y = 0; y < of->height; y++) {
        ranges[y][0] = INT32_MAX / 2;
        ranges[y][1] = INT32_MIN / 2;
        for (long j = y - 1; j <= y + 2; j++) {
            if (j < 0 || j >= of->height || rows[j][0] == rows[j][1])
                continue;
            ranges[y][0] = rows[j][0] < ranges[y][0] ? rows[j][0] : ranges[y][0];
            ranges[y][1] = rows[j][1] > ranges[y][1] ? rows[j][1] : ranges[y][1];
        }
    }
}

/* ---- the spline's pictures ------------------------------------------------------------------- */

typedef void spline_function(const cvol_spline_row *);

static void splines_are_sampled(void **state)
{
    (void)state;
    spline_function *const sets[] = CVOL_SIMD_SETS(cvol_spline_sample);
    static float places[4 * 48 * 48];
    static int spans[48][2];
    static const float nothing[4] = {0};
    for (uint64_t number = 0; number < CASES; number++) {
        random_state r = kernels_random(number);
        lattice of = {places, 5 + (long)random_below(&r, 40), 5 + (long)random_below(&r, 40), 0,
                      nothing};
        of.stride = 4 * of.width;
        cvol_spline_row row = {.places = places,
                               .spans = spans,
                               .dims = {of.width, of.height},
                               .ground = {0.2f, 0.9f, 0},
                               .count = 1 + (int)random_below(&r, 70)};
        for (int k = 0; k < 2; k++) {
            row.start[k] = floor(64 * (-6 + 20 * random_signed(&r))) / 64;
            row.step[k] = (1 + random_below(&r, 80)) / 64.0;
        }
        fill_grid(places, spans, &of, &r);
        const size_t floats = 4 * (size_t)row.count;
        uint8_t *bytes = kernels_memory(floats);
        float *values = kernels_memory(sizeof *values * floats);
        for (int set = 0; set < KERNELS_SETS(sets); set++) {
            kernels_refill(bytes);
            kernels_refill(values);
            row.values = NULL;
            row.out = bytes;
            sets[set](&row);
            row.values = values;
            row.out = NULL;
            sets[set](&row);
            kernels_check_guards(bytes, "spline bytes", set);
            kernels_check_guards(values, "spline values", set);
            for (int i = 0; i < row.count; i++) {
                double expected[4], error[4];
                filter_at(expected, &of, row.start[0] + i * row.step[0],
                          row.start[1] + i * row.step[1], weigh_spline);
                for (int c = 0; c < 4; c++)
                    error[c] = FILTER_ERROR;
                kernels_expect_near(values + 4 * i, expected, error, 4, "spline values", set);
                for (int c = 0; c < 4; c++) {
                    const double ground = c < 3 ? (double)row.ground[c] : 1;
                    expect_byte(bytes[4 * i + c],
                                fmax(expected[c], 0) + (1 - clamp(expected[3], 0, 1)) * ground,
                                "spline bytes", set);
                }
            }
        }
        kernels_free(bytes);
        kernels_free(values);
    }
}

/* ---- the warp -------------------------------------------------------------------------------- */

typedef int warp_function(float *, const cvol_warp_source *, const cvol_warp_places *);
typedef void bytes_function(uint8_t *, const float *, int, const float[3]);

static void intermediate_images_are_warped(void **state)
{
    (void)state;
    warp_function *const sets[] = CVOL_SIMD_SETS(cvol_warp_sample);
    static float pixels[4 * 60 * 48];
    static int reach[48][2];
    static const float empty[4] = {0, 0, 0, 1};
    int empty_ones = 0;
    for (uint64_t number = 0; number < 2 * CASES; number++) {
        random_state r = kernels_random(100 + number);
        const lattice of = {pixels, 5 + (long)random_below(&r, 40), 5 + (long)random_below(&r, 40),
                            4 * 53, empty};
        const cvol_warp_source source = {.pixels = pixels,
                                         .stride = of.stride,
                                         .width = (int)of.width,
                                         .height = (int)of.height,
                                         .reach = reach[0],
                                         .empty = {0, 0, 0, 1}};
        cvol_warp_places places = {.count = 1 + (int)random_below(&r, CVOL_WARP_CHUNK)};
        double at[2], step[2];
        for (int k = 0; k < 2; k++) {
            const double whole = number % 4 ? 64 : 1; /* some lie on pixels */
            at[k] = floor(whole * (10 + 25 * random_signed(&r))) / whole;
            step[k] = number % 4 ? floor(70 * random_signed(&r)) / 64 : k == 0;
        }
        for (int i = 0; i < places.count; i++) {
            places.u[i] = at[0] + i * step[0];
            places.v[i] = at[1] + i * step[1];
        }
        fill_grid(pixels, reach, &of, &r);
        const size_t floats = 4 * (size_t)places.count;
        float *values = kernels_memory(sizeof *values * floats);
        for (int set = 0; set < KERNELS_SETS(sets); set++) {
            kernels_refill(values);
            const int some = sets[set](values, &source, &places);
            kernels_check_guards(values, "warp", set);
            empty_ones += !some;
            for (int i = 0; i < places.count; i++) {
                double expected[4], error[4];
                filter_at(expected, &of, places.u[i], places.v[i], weigh_catmull_rom);
                for (int c = 0; c < 4; c++)
                    error[c] = FILTER_ERROR;
                kernels_expect_near(some ? values + 4 * i : empty, expected, error, 4, "warp", set);
            }
            if (!some) { /* and writes nothing */
                float *before = kernels_memory(sizeof *values * floats);
                kernels_expect_same(values, before, sizeof *values * floats, "empty warp", set);
                kernels_free(before);
            }
        }
        kernels_free(values);
    }
    assert_true(empty_ones > 0);
}

static void pixels_become_bytes(void **state)
{
    (void)state;
    bytes_function *const sets[] = CVOL_SIMD_SETS(cvol_warp_bytes);
    static float values[4 * CVOL_WARP_CHUNK];
    static const float background[3] = {0.3f, 1, 0};
    for (uint64_t number = 0; number < CASES; number++) {
        random_state r = kernels_random(200 + number);
        const int count = 1 + (int)random_below(&r, CVOL_WARP_CHUNK);
        for (int i = 0; i < 4 * CVOL_WARP_CHUNK; i++)
            values[i] = (float)(0.5 + 0.7 * random_signed(&r));
        uint8_t *bytes = kernels_memory(4 * (size_t)count);
        for (int set = 0; set < KERNELS_SETS(sets); set++) {
            kernels_refill(bytes);
            sets[set](bytes, values, count, background);
            kernels_check_guards(bytes, "warped bytes", set);
            for (int i = 0; i < count; i++) {
                const float *v = values + 4 * (size_t)i;
                for (int c = 0; c < 3; c++)
                    expect_byte(bytes[4 * i + c],
                                (double)v[c] + clamp((double)v[3], 0, 1) * (double)background[c],
                                "warped bytes", set);
                assert_int_equal(bytes[4 * i + 3], 255);
            }
        }
        kernels_free(bytes);
    }
}

/* ---- spectra --------------------------------------------------------------------------------- */

typedef void gather_function(float *, float *, const cvol_fourier_line *);
typedef void weigh_function(float *, float *, const cvol_fourier_filter *);
typedef void half_function(uint16_t *, const float *, size_t, float);

static double half_value(uint16_t bits)
{
    const int exponent = bits >> 10 & 31, fraction = bits & 1023;
    const double size = exponent ? ldexp(1024 + fraction, exponent - 25) : ldexp(fraction, -24);
    return bits >> 15 ? -size : size;
}

/* The nearest half float to a number of at most 65504, ties to even. */
static double nearest_half(double value)
{
    int exponent;
    frexp(value, &exponent);
    const double last = ldexp(1, (exponent < -13 ? -13 : exponent) - 11);
    return rint(value / last) * last;
}

static void halves_are_the_nearest(void **state)
{
    (void)state;
    half_function *const sets[] = CVOL_SIMD_SETS(cvol_fourier_pack);
    static float in[100];
    for (uint64_t number = 0; number < CASES; number++) {
        random_state r = kernels_random(300 + number);
        const size_t count = 1 + random_below(&r, 99);
        const float scale = (float)exp2(3 * random_signed(&r));
        for (size_t i = 0; i < count; i++) {
            in[i] = (float)(random_signed(&r) * exp2(12 - (double)random_below(&r, 40)));
            if (random_below(&r, 4) == 0) /* between two halves, and 0 */
                in[i] = (float)ldexp(floor(4096 * random_signed(&r)),
                                     (int)random_below(&r, 20) - 20);
        }
        uint16_t *out = kernels_memory(sizeof *out * count);
        for (int set = 0; set < KERNELS_SETS(sets); set++) {
            kernels_refill(out);
            sets[set](out, in, count, scale);
            kernels_check_guards(out, "half floats", set);
            for (size_t i = 0; i < count; i++) {
                const float scaled = in[i] * scale;
                if (half_value(out[i]) != nearest_half((double)scaled) ||
                    out[i] >> 15 != !!signbit(scaled))
                    fail_msg("half floats, %s: %.9g becomes %.9g", cvol_cpu_name((cvol_cpu)set),
                             (double)scaled, half_value(out[i]));
            }
        }
        kernels_free(out);
    }
}

/* A spectrum of random half floats, stored row by row and in bricks. */
typedef struct spectrum {
    cvol_fourier_spectrum of;
    cvol_fourier_pages pages;
    size_t size[3]; /* stored places along each axis */
} spectrum;

enum { EDGE = CVOL_FOURIER_BRICK, PAGE = CVOL_FOURIER_PAGE_ROW * EDGE * EDGE };

static void make_spectrum(spectrum *s, random_state *r)
{
    memset(s, 0, sizeof *s);
    for (int a = 0; a < 3; a++)
        s->of.dims[a] = 2 * (5 + random_below(r, 12));
    s->size[0] = s->of.dims[0] / 2 + 1 + 2 + EDGE;
    s->size[1] = s->of.dims[1] + CVOL_FOURIER_BEFORE + CVOL_FOURIER_BEHIND;
    s->size[2] = s->of.dims[2] + CVOL_FOURIER_BEFORE + CVOL_FOURIER_BEHIND;
    s->of.stride_v = s->size[0];
    s->of.stride_w = s->size[0] * s->size[1];
    s->of.places = s->of.stride_w * s->size[2];
    s->of.unit = 0.01f;
    s->of.values = malloc(2 * s->of.places * sizeof *s->of.values);
    assert_non_null(s->of.values);
    /* Place v of an axis is the same as v + N: those before the first and behind the last
     * repeat. */
    for (size_t w = 0; w < s->size[2]; w++)
        for (size_t v = 0; v < s->size[1]; v++)
            for (size_t u = 0; u < 2 * s->size[0]; u++) {
                const size_t from_v = v < s->of.dims[1] ? v : v - s->of.dims[1];
                const size_t from_w = w < s->of.dims[2] ? w : w - s->of.dims[2];
                const size_t at = 2 * (v * s->of.stride_v + w * s->of.stride_w) + u;
                const size_t from = 2 * (from_v * s->of.stride_v + from_w * s->of.stride_w) + u;
                const uint32_t bits = (uint32_t)random_u64(r);
                s->of.values[at] = from == at
                                       ? (uint16_t)((bits & 0x83ff) | (bits >> 16) % 20 << 10)
                                       : s->of.values[from];
            }
    const size_t *N = s->of.dims;
    size_t *count = s->of.bricks.count;
    count[0] = (s->size[0] + EDGE - 1) / EDGE;
    count[1] = (N[1] + EDGE - 1) / EDGE;
    count[2] = (N[2] + EDGE - 1) / EDGE;
    const size_t bricks = count[0] * count[1] * count[2];
    s->pages.table = malloc(bricks * sizeof *s->pages.table);
    s->pages.values = calloc(2 * PAGE * bricks, sizeof *s->pages.values);
    assert_true(s->pages.table && s->pages.values);
    for (size_t b = 0; b < bricks; b++) {
        const size_t page = bricks - 1 - b;
        s->pages.table[b] = (uint32_t)page;
        for (size_t i = 0; i < PAGE; i++) {
            const size_t u = b % count[0] * EDGE + i % CVOL_FOURIER_PAGE_ROW;
            const size_t v = b / count[0] % count[1] * EDGE + i / CVOL_FOURIER_PAGE_ROW % EDGE;
            const size_t w = b / count[0] / count[1] * EDGE + i / CVOL_FOURIER_PAGE_ROW / EDGE;
            if (u >= s->size[0] || v >= N[1] || w >= N[2])
                continue;
            const size_t from_v = v + CVOL_FOURIER_BEFORE, from_w = w + CVOL_FOURIER_BEFORE;
            memcpy(s->pages.values + 2 * (page * PAGE + i),
                   s->of.values + 2 * (u + from_v * s->of.stride_v + from_w * s->of.stride_w),
                   2 * sizeof *s->pages.values);
        }
    }
}

static void free_spectrum(spectrum *s)
{
    free(s->of.values);
    free(s->pages.table);
    free(s->pages.values);
}

/* sum_d taps[d][j] z^d, its derivative by g = z / 2, and the sums of magnitudes. */
static void weigh_tap(double w[2], double sizes[2], const cvol_fourier_kernel *kernel, int j,
                      double z)
{
    w[0] = w[1] = sizes[0] = sizes[1] = 0;
    for (int d = 0; d <= CVOL_FOURIER_DEGREE; d++) {
        const double tap = (double)kernel->taps[d][j];
        w[0] += tap * pow(z, d);
        w[1] += d ? 2 * d * tap * pow(z, d - 1) : 0;
        sizes[0] += fabs(tap);
        sizes[1] += 2 * d * fabs(tap);
    }
}

/* near F + i sum_a slope[a] dF / dg_a at g; *error: the bound of its rounding error. Each of three
 * weights of degree 8 has an error of 16 u; then come 36 + 6 sums. */
static void gather_reference(double out[2], double *error, const cvol_fourier_line *line,
                             const double at[3])
{
    const cvol_fourier_spectrum *of = line->spectrum;
    double g[3], weight[3][CVOL_FOURIER_TAPS][2], sizes[3][CVOL_FOURIER_TAPS][2];
    double value[2] = {0}, rise[2] = {0}, size = 0;
    size_t cell[3];
    for (int a = 0; a < 3; a++) {
        const double N = (double)of->dims[a];
        g[a] = at[a] - N * floor(at[a] / N + 0.5);
    }
    const double flip = g[0] < 0 ? -1 : 1;
    for (int a = 0; a < 3; a++) {
        g[a] *= flip;
        g[a] += a && g[a] < 0 ? (double)of->dims[a] : 0;
        cell[a] = (size_t)floor(g[a]);
        for (int j = 0; j < CVOL_FOURIER_TAPS; j++)
            weigh_tap(weight[a][j], sizes[a][j], line->kernel, j, 2 * (g[a] - (double)cell[a]) - 1);
    }
    for (size_t i = 0; i < 216; i++) {
        const size_t u = i % 6, v = i / 6 % 6, w = i / 36;
        const uint16_t *pair = of->values + 2 * (cell[0] + u + of->stride_v * (cell[1] + v) +
                                                 of->stride_w * (cell[2] + w));
        const double *x = weight[0][u], *y = weight[1][v], *z = weight[2][w];
        const double *a = sizes[0][u], *b = sizes[1][v], *c = sizes[2][w];
        const double slope = (double)line->slope[0] * x[1] * y[0] * z[0] +
                             (double)line->slope[1] * x[0] * y[1] * z[0] +
                             (double)line->slope[2] * x[0] * y[0] * z[1];
        double most = fabs((double)line->near) * a[0] * b[0] * c[0];
        if (line->cued)
            most += fabs((double)line->slope[0]) * a[1] * b[0] * c[0] +
                    fabs((double)line->slope[1]) * a[0] * b[1] * c[0] +
                    fabs((double)line->slope[2]) * a[0] * b[0] * c[1];
        for (int part = 0; part < 2; part++) {
            value[part] += x[0] * y[0] * z[0] * half_value(pair[part]);
            rise[part] += slope * half_value(pair[part]);
            size += most * fabs(half_value(pair[part]));
        }
    }
    const double unit = (double)of->unit, near = line->cued ? (double)line->near : 1;
    out[0] = unit * (near * value[0] - (line->cued ? rise[1] : 0));
    out[1] = unit * (near * value[1] + (line->cued ? rise[0] : 0)) * flip;
    *error = (3 * 16 + 36 + 6 + 8) * UNIT * unit * size;
}

static void slices_are_gathered(void **state)
{
    (void)state;
    gather_function *const sets[] = CVOL_SIMD_SETS(cvol_fourier_gather);
    cvol_fourier_kernel kernel;
    cvol_fourier_kernel_make(&kernel);
    for (uint64_t number = 0; number < CASES; number++) {
        random_state r = kernels_random(400 + number);
        spectrum s;
        make_spectrum(&s, &r);
        cvol_fourier_line line = {.spectrum = &s.of,
                                  .pages = number % 2 ? &s.pages : NULL,
                                  .kernel = &kernel,
                                  .near = 1,
                                  .cued = number / 2 % 2 == 1,
                                  .count = 1 + random_below(&r, 50)};
        for (int a = 0; a < 3; a++) {
            line.start[a] = (2 * floor(300 * random_signed(&r)) + 1) / 128;
            line.step[a] = floor(40 * random_signed(&r)) / 64;
            line.slope[a] = line.cued ? (float)random_signed(&r) : 0;
        }
        line.near = line.cued ? 0.7f : 1;
        const size_t bytes = sizeof(float) * (line.count + CVOL_FOURIER_RUN);
        float *re = kernels_memory(bytes), *im = kernels_memory(bytes);
        for (int set = 0; set < KERNELS_SETS(sets); set++) {
            kernels_refill(re);
            kernels_refill(im);
            sets[set](re, im, &line);
            kernels_check_guards(re, "slice", set);
            kernels_check_guards(im, "slice", set);
            for (size_t k = 0; k < line.count; k++) {
                double at[3], expected[2], error;
                for (int a = 0; a < 3; a++)
                    at[a] = line.start[a] + (double)k * line.step[a];
                gather_reference(expected, &error, &line, at);
                kernels_expect_near(re + k, &expected[0], &error, 1, "slice, real", set);
                kernels_expect_near(im + k, &expected[1], &error, 1, "slice, imaginary", set);
            }
        }
        kernels_free(re);
        kernels_free(im);
        free_spectrum(&s);
    }
}

static double sinc(double t)
{
    return t == 0 ? 1 : sin(3.14159265358979323846 * t) / (3.14159265358979323846 * t);
}

/* The kernel's sinc is exact to 1e-6 of 1 / t and rounding of t: below 2e-6. A product of six. */
static void factors_equal_the_formula(void **state)
{
    (void)state;
    weigh_function *const sets[] = CVOL_SIMD_SETS(cvol_fourier_weigh);
    for (uint64_t number = 0; number < CASES; number++) {
        random_state r = kernels_random(500 + number);
        cvol_fourier_filter filter = {.count = 1 + random_below(&r, 60)};
        double all = 1;
        for (int a = 0; a < 3; a++) {
            filter.start[a] = random_below(&r, 4) ? 0.6 * random_signed(&r) : 0;
            filter.step[a] = random_below(&r, 4) ? 0.01 * random_signed(&r) : 0;
            filter.power[a] = 1 + (int)random_below(&r, 2);
            filter.intervals[a] = 1 + random_below(&r, 30);
            filter.length[a] = 0.5 + random_below(&r, 30);
            all *= filter.length[a];
        }
        const size_t room = (filter.count + 15) / 16 * 16;
        float *sum = kernels_memory(sizeof *sum * room), *box = kernels_memory(sizeof *box * room);
        for (int set = 0; set < KERNELS_SETS(sets); set++) {
            kernels_refill(sum);
            kernels_refill(box);
            sets[set](sum, box, &filter);
            kernels_check_guards(sum, "factors", set);
            kernels_check_guards(box, "factors", set);
            for (size_t k = 0; k < filter.count; k++) {
                double of_sum = 1, of_box = 1;
                for (int a = 0; a < 3; a++) {
                    const double t = filter.start[a] + (double)k * filter.step[a];
                    of_sum *= pow(sinc(t), filter.power[a]);
                    of_box *= filter.length[a] *
                              (filter.power[a] == 1 ? sinc(t)
                                                    : sinc(filter.intervals[a] * t) * sinc(2 * t));
                }
                const double error[2] = {6 * 2e-6, 6 * 2e-6 * all};
                kernels_expect_near(sum + k, &of_sum, &error[0], 1, "factor of sums", set);
                kernels_expect_near(box + k, &of_box, &error[1], 1, "factor of boxes", set);
            }
        }
        kernels_free(sum);
        kernels_free(box);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(splines_are_sampled), cmocka_unit_test(intermediate_images_are_warped),
        cmocka_unit_test(pixels_become_bytes), cmocka_unit_test(halves_are_the_nearest),
        cmocka_unit_test(slices_are_gathered), cmocka_unit_test(factors_equal_the_formula),
    };
    kernels_begin();
    return cmocka_run_group_tests(tests, NULL, NULL);
}
