/* Kernels of the splat and of the spectral engine: each against its formula in double precision on
 * random data, by every instruction set.
 *
 * u = 2^-24 is the unit of rounding. A sum of n products of floats is off by at most n u times the
 * sum of the products' magnitudes, in any order, with fused multiply-add or without. Samples lie
 * where rounding cannot move them to another part of a pixel.
 */
#include "test.h"

#include <limits.h>

#include "array/core/array.h"
#include "base/cpu.h"
#include "render/spectral/tile.h"
#include "render/splat/frame.h"
#include "support_context.h"
#include "support_kernels.h"

enum { CASES = 40 };

#define UNIT 0x1p-24

static double clamp(double value, double lo, double hi)
{
    return value < lo ? lo : value > hi ? hi : value;
}

/* ---- visible samples ------------------------------------------------------------------------- */

typedef void list_function(cvol_splat_list *, const cvol_splat_row *, int, int,
                           const cvol_splat_table *, const cvol_light *);

enum { SAMPLES = 120, ROWS = 5, ROOM = SAMPLES + 2 * CVOL_SPLAT_MARGIN };
static float rows[ROWS][ROOM];
static cvol_splat_table table;
static cvol_light light;

static void make_table(random_state *r)
{
    table.from = (float)(100 * random_signed(r));
    table.scale = 10 + (float)random_below(r, 20);
    table.visible_from = table.from + CVOL_SPLAT_ENTRIES / table.scale / 4;
    table.visible_to = table.from + CVOL_SPLAT_ENTRIES / table.scale / 2;
    for (int t = 0; t < CVOL_SPLAT_ENTRIES; t++) {
        table.entries[t][3] = (float)random_below(r, 1000) / 1000;
        for (int c = 0; c < 3; c++)
            table.entries[t][c] = table.entries[t][3] * (float)random_below(r, 1000) / 1000;
    }
}

static void make_unit(float v[3], random_state *r)
{
    double norm = 0;
    for (int k = 0; k < 3; k++) {
        v[k] = (float)random_signed(r);
        norm += (double)v[k] * (double)v[k];
    }
    for (int k = 0; k < 3; k++)
        v[k] = (float)((double)v[k] / sqrt(norm));
}

static double dot(const double a[3], const float b[3])
{
    return a[0] * (double)b[0] + a[1] * (double)b[1] + a[2] * (double)b[2];
}

static void make_light(random_state *r, int on, int thins)
{
    light = (cvol_light){.on = on,
                         .ambient = 0.2f,
                         .diffuse = 0.7f,
                         .specular = 0.4f,
                         .shininess = 1 + (int)random_below(r, 60),
                         .flat = random_below(r, 2) ? 400 : 0,
                         .thinning = thins ? 0.02f : 0};
    make_unit(light.eye, r);
    make_unit(light.light, r);
    for (int k = 0; k < 3; k++)
        light.rise[k] = 0.3f + (float)random_below(r, 10) / 10;
    light.facing_light = 0;
    for (int k = 0; k < 3; k++)
        light.facing_light += light.eye[k] * light.light[k];
}

/* Phong's model for sample i; 0 if a deciding sign is too close to 0 to be known. */
static int light_reference(double out[4], const float *from, int i)
{
    const int m = CVOL_SPLAT_MARGIN + i;
    const double gradient[3] = {((double)rows[0][m + 1] - (double)rows[0][m - 1]) *
                                    (double)light.rise[0],
                                ((double)rows[2][m] - (double)rows[1][m]) * (double)light.rise[1],
                                ((double)rows[4][m] - (double)rows[3][m]) * (double)light.rise[2]};
    const double length = sqrt(gradient[0] * gradient[0] + gradient[1] * gradient[1] +
                               gradient[2] * gradient[2]);
    double seen = 1, lit = (double)light.facing_light;
    if (length > 1e-15) {
        seen = dot(gradient, light.eye) / length;
        lit = dot(gradient, light.light) / length;
        if (fabs(seen) < 1e-4 || fabs(lit) < 1e-4)
            return 0;
        const double flatness = (double)light.flat / (length * length + (double)light.flat);
        const double both = fabs(seen) * (double)light.facing_light,
                     share = fmin(16 * fabs(seen), 1);
        lit = both + share * ((seen < 0 ? -lit : lit) - both);
        lit = lit * (1 - flatness) + (double)light.facing_light * flatness;
        seen = fabs(seen) * (1 - flatness) + flatness;
        if (fabs(lit) < 1e-4)
            return 0;
    }
    const double along = fmax(2 * fmax(lit, 0) * seen - (double)light.facing_light, 0);
    const double gloss = lit <= 0 ? 0 : (double)light.specular * pow(along, light.shininess);
    const double factor = (double)light.ambient + (double)light.diffuse * fmax(lit, 0);
    const double opacity = (double)from[3];
    double share = 1;
    if (light.thinning > 0 && length * (double)light.thinning < 1 && opacity > 0)
        share = (1 - pow(1 - opacity, length * (double)light.thinning)) / opacity;
    for (int c = 0; c < 3; c++)
        out[c] = share * fmin((double)from[c] * factor + opacity * gloss,
                              (double)CVOL_SPLAT_BRIGHTEST * opacity);
    out[3] = share * opacity;
    return 1;
}

/* Channels of one sample against those of its entry, or of the next one if rounding decides. The
 * inverse root is exact to 3e-7, so the error of cosines is 1e-6, and that of their powers
 * shininess times as large. */
static void check_channels(const float *found, int i, int set)
{
    const double place = ((double)rows[0][CVOL_SPLAT_MARGIN + i] - (double)table.from) *
                             (double)table.scale +
                         0.5;
    const double error = light.on ? 3e-6 * (1 + light.shininess) : 0;
    int fits = 0;
    for (int by = -1; by <= 1; by++) {
        const int entry = (int)clamp(floor(place + 0.01 * by), 0, CVOL_SPLAT_ENTRIES - 1);
        double expected[4];
        int same = 1;
        for (int c = 0; c < 4; c++)
            expected[c] = (double)table.entries[entry][c];
        if (light.on && !light_reference(expected, table.entries[entry], i))
            return;
        for (int c = 0; c < 4; c++)
            same &= fabs((double)found[c] - expected[c]) <= error;
        fits |= same;
    }
    if (!fits)
        fail_msg("list, %s: other channels of sample %d", cvol_cpu_name((cvol_cpu)set), i);
}

static void samples_are_listed(void **state)
{
    (void)state;
    list_function *const sets[] = CVOL_SIMD_SETS(cvol_splat_list_make);
    const size_t room = SAMPLES + CVOL_SPLAT_MARGIN;
    cvol_splat_list list;
    list.numbers = kernels_memory(sizeof *list.numbers * room);
    list.entries = kernels_memory(sizeof *list.entries * room);
    list.channels = kernels_memory(sizeof *list.channels * 4 * room);
    for (uint64_t number = 0; number < CASES; number++) {
        random_state r = kernels_random(number);
        make_table(&r);
        make_light(&r, number % 3 != 0, number % 3 == 2);
        for (int k = 0; k < ROWS; k++)
            for (int i = 0; i < ROOM; i++)
                rows[k][i] = table.from + CVOL_SPLAT_ENTRIES / table.scale *
                                              (float)(0.4 + 0.6 * random_signed(&r));
        const float *const first = rows[0] + CVOL_SPLAT_MARGIN;
        const cvol_splat_row row = {first, first + ROOM, first + 2 * ROOM, first + 3 * ROOM,
                                    first + 4 * ROOM};
        const int begin = (int)random_below(&r, 20);
        const int end = begin + (int)random_below(&r, SAMPLES - 20);
        for (int set = 0; set < KERNELS_SETS(sets); set++) {
            kernels_refill(list.numbers);
            kernels_refill(list.entries);
            kernels_refill(list.channels);
            sets[set](&list, &row, begin, end, &table, &light);
            int n = 0;
            for (int i = begin; i < end; i++)
                if (first[i] >= table.visible_from && first[i] <= table.visible_to) {
                    assert_true(n < list.count);
                    assert_int_equal(list.numbers[n], i);
                    check_channels(list.from + 4 * (size_t)list.entries[n++], i, set);
                }
            assert_int_equal(list.count, n);
            kernels_check_guards(list.numbers, "list", set);
            kernels_check_guards(list.entries, "list", set);
            kernels_check_guards(list.channels, "list", set);
        }
    }
    kernels_free(list.numbers);
    kernels_free(list.entries);
    kernels_free(list.channels);
}

/* ---- footprints onto a slice ----------------------------------------------------------------- */

typedef uint64_t add_function(const cvol_splat_band *, const cvol_footprint_table *,
                              const cvol_splat_list *, const double[2], const double[2]);
typedef void composite_function(const cvol_splat_band *, const cvol_splat_gain *, int);

enum { LISTED = 90, BAND_ROWS = 12, MAX_ROW = 4 * 512 };
static double expected_sheet[BAND_ROWS * MAX_ROW], sheet_sizes[BAND_ROWS * MAX_ROW];

static int is_near_whole(double value)
{
    return fabs(value - rint(value)) < 0.02;
}

/* Adds a sample at (x, y), or, with `only_look`, returns 1 if rounding decides its place. Otherwise
 * it returns the number of rows of pixels that it reaches. */
static int add_reference(const cvol_splat_band *band, const cvol_footprint_table *of,
                         const float *channels, double x, double y, int only_look)
{
    const int is_straight = of->columns && of->shape.s == 0;
    const double slant = is_straight ? 0 : of->shape.s / of->shape.uy;
    const int whole_y = (int)floor(y * of->phases_y), py = whole_y & (of->phases_y - 1);
    const int row = (whole_y >> of->log2_y) + of->first_y[py];
    int unsure = is_near_whole(y * of->phases_y), reached = 0;
    const int first = row > band->begin ? row : band->begin;
    const int end = row + of->height < band->end ? row + of->height : band->end;
    for (int j = first; j < end; j++) {
        const double at = (x + slant * (j - y)) * of->phases_x;
        const int whole = (int)floor(at), px = whole & (of->phases_x - 1);
        const int column = (whole >> of->log2_x) + of->first_x[px] + band->margin;
        const float *weights = cvol_footprint_row(of, px, py, j - row);
        const double factor = of->columns ? (double)of->columns[py * of->height + j - row] : 1;
        unsure |= is_near_whole(at);
        if (column + of->width <= band->margin || column >= band->margin + band->width)
            continue;
        reached = 1;
        for (int i = 0; i < of->width && !only_look; i++)
            for (int c = 0; c < 4; c++) {
                const size_t to = (size_t)(j - band->begin) * band->row_stride +
                                  4 * (size_t)(column + i) + (size_t)c;
                const double part = factor * (double)weights[i] * (double)channels[c];
                expected_sheet[to] += part;
                sheet_sizes[to] += fabs(part);
            }
    }
    if (only_look)
        return unsure;
    return reached ? end - first : 0;
}

/* Pixels with added samples lie within the spans. */
static void check_spans(const cvol_splat_band *band, int set)
{
    for (int y = 0; y < band->end - band->begin; y++)
        for (int x = 0; x < (int)band->row_stride / 4; x++) {
            const int *span = band->spans[y];
            const size_t at = (size_t)y * band->row_stride + 4 * (size_t)x;
            const double size = sheet_sizes[at] + sheet_sizes[at + 1] + sheet_sizes[at + 3];
            if (size > 0 && (x < span[0] || x >= span[1]))
                fail_msg("footprints, %s: pixel (%d, %d) is beyond the span",
                         cvol_cpu_name((cvol_cpu)set), x, y);
        }
}

static void check_add(const cvol_footprint_table *of, random_state *r)
{
    add_function *const sets[] = CVOL_SIMD_SETS(cvol_splat_add);
    static float channels[4 * LISTED];
    static int numbers[LISTED + CVOL_SPLAT_MARGIN], entries[LISTED + CVOL_SPLAT_MARGIN];
    int spans[BAND_ROWS][2];
    const int slant = (int)cvol_footprint_slant(of) + 1;
    cvol_splat_band band = {.begin = 3, .end = 3 + 1 + (int)random_below(r, BAND_ROWS)};
    band.width = 20 + (int)random_below(r, 40);
    band.margin = (of->width + 2 * slant + 2 * CVOL_FOOTPRINT_PAD + 3) / 4 * 4;
    band.row_stride = 4 * (((size_t)band.width + 2 * (size_t)band.margin + 7) / 4 * 4);
    assert_true(band.row_stride <= MAX_ROW);
    band.spans = spans;
    /* Lines through the band's middle, many of them along a row, some with close samples. */
    const double step[2] = {floor((random_below(r, 2) ? 64 : 9) * random_signed(r)) / 64,
                            random_below(r, 2) ? 0 : floor(12 * random_signed(r)) / 64};
    const double start[2] = {floor(band.width / 2.0) - LISTED / 2 * step[0],
                             (band.begin + band.end) / 2 - LISTED / 2 * step[1]};
    /* The exact place differs by 1 / (8 phases), which is no part of a pixel. */
    const double from[2] = {start[0] + 0.375 / of->phases_x, start[1] + 0.375 / of->phases_y};
    cvol_splat_list list = {0, numbers, entries, channels, NULL};
    const size_t floats = band.row_stride * (size_t)(band.end - band.begin);
    band.sheet = kernels_memory(sizeof *band.sheet * floats);
    float *before = malloc(sizeof *before * floats);
    assert_non_null(before);
    for (size_t i = 0; i < floats; i++) {
        before[i] = (float)random_signed(r);
        expected_sheet[i] = (double)before[i];
        sheet_sizes[i] = 0;
    }
    uint64_t reached = 0;
    for (int i = 0; i < LISTED; i++) {
        const double x = from[0] + i * step[0], y = from[1] + i * step[1];
        if (random_below(r, 3) == 0 || add_reference(&band, of, channels, x, y, 1))
            continue;
        const int entry = (int)random_below(r, LISTED);
        for (int c = 0; c < 4; c++)
            channels[4 * entry + c] = channels[4 * entry + c] != 0 ? channels[4 * entry + c]
                                                                   : (float)random_signed(r);
        numbers[list.count] = i;
        entries[list.count++] = entry;
        reached += (uint64_t)add_reference(&band, of, channels + 4 * (size_t)entry, x, y, 0);
    }
    for (size_t i = 0; i < floats; i++)
        sheet_sizes[i] += sheet_sizes[i] > 0 ? fabs((double)before[i]) : 0;
    for (int set = 0; set < KERNELS_SETS(sets); set++) {
        memcpy(band.sheet, before, sizeof *before * floats);
        for (int y = 0; y < BAND_ROWS; y++) {
            spans[y][0] = INT_MAX;
            spans[y][1] = 0;
        }
        const uint64_t rows_reached = sets[set](&band, of, &list, from, step);
        assert_true(rows_reached == reached);
        static double error[BAND_ROWS * MAX_ROW];
        for (size_t i = 0; i < floats; i++) /* two products each, and sums of all of them */
            error[i] = (list.count + 3) * UNIT * sheet_sizes[i];
        kernels_expect_near(band.sheet, expected_sheet, error, floats, "footprints", set);
        kernels_check_guards(band.sheet, "footprints", set);
        check_spans(&band, set);
    }
    memset(channels, 0, sizeof channels);
    kernels_free(band.sheet);
    free(before);
}

static void footprints_are_added(void **state)
{
    (void)state;
    static const cvol_footprint kinds[4] = {CVOL_FOOTPRINT_GAUSSIAN, CVOL_FOOTPRINT_CONE,
                                            CVOL_FOOTPRINT_SINC, CVOL_FOOTPRINT_BOX};
    cvol_footprint_table of = {0};
    for (uint64_t number = 0; number < CASES; number++) {
        random_state r = kernels_random(100 + number);
        const cvol_footprint_shape shape = {.kind = kinds[number % 4],
                                            .size = kinds[number % 4] == CVOL_FOOTPRINT_BOX ? 1 : 4,
                                            .sigma = 0.7,
                                            .ux = 0.6 + random_below(&r, 9) / 3.0,
                                            .uy = 0.6 + random_below(&r, 9) / 3.0,
                                            .s = number % 8 < 4 ? 0 : random_signed(&r)};
        assert_int_equal(cvol_footprint_table_make(context, &of, &shape), CVOL_OK);
        check_add(&of, &r);
    }
    cvol_footprint_table_free(&of);
}

/* Two products and three sums per pixel. */
static void slices_are_composited(void **state)
{
    (void)state;
    composite_function *const sets[] = CVOL_SIMD_SETS(cvol_splat_composite);
    static cvol_footprint_gain factors;
    enum { STRIDE = 4 * 64, FLOATS = STRIDE * BAND_ROWS };
    static float sheet[FLOATS], image[FLOATS];
    static double expected[FLOATS], error[FLOATS];
    int first[BAND_ROWS][2], spans[BAND_ROWS][2];
    float *found_sheet = kernels_memory(sizeof sheet), *found = kernels_memory(sizeof image);
    for (uint64_t number = 0; number < CASES; number++) {
        random_state r = kernels_random(200 + number);
        const int front = (int)number % 2, has_gain = number % 4 > 1;
        cvol_splat_gain gain = {.gain = &factors};
        factors.size = 8;
        for (int i = 0; i < 64; i++)
            factors.gain[i] = (float)(1 + 0.2 * random_signed(&r));
        for (int k = 0; k < 2; k++) { /* never between two parts */
            gain.at[k] = (2 * floor(64 * random_signed(&r)) + 1) / 128;
            gain.step_x[k] = floor(90 * random_signed(&r)) / 64;
            gain.step_y[k] = floor(90 * random_signed(&r)) / 64;
        }
        const cvol_splat_band band = {.begin = 5,
                                      .end = 5 + BAND_ROWS,
                                      .width = 40,
                                      .margin = 12,
                                      .row_stride = STRIDE,
                                      .sheet = found_sheet,
                                      .image = found,
                                      .spans = spans};
        for (int y = 0; y < BAND_ROWS; y++) {
            first[y][0] = (int)random_below(&r, 60);
            first[y][1] = random_below(&r, 4) ? first[y][0] + (int)random_below(&r, 5) * 9 : 0;
            first[y][1] = first[y][1] > 64 ? 64 : first[y][1];
        }
        for (int i = 0; i < FLOATS; i++) {
            const int x = i % STRIDE / 4, y = i / STRIDE;
            const int inside = x >= first[y][0] && x < first[y][1];
            sheet[i] = inside ? (float)(0.3 + random_signed(&r)) : 0;
            image[i] = (float)(i % 4 == 3 ? fabs(random_signed(&r)) : random_signed(&r));
        }
        for (int i = 0; i < FLOATS; i++) {
            const int x = i % STRIDE / 4, y = i / STRIDE + 5, alpha = i / 4 * 4 + 3;
            double factor = 1;
            if (has_gain) {
                int part[2];
                for (int k = 0; k < 2; k++) {
                    const double at = gain.at[k] + y * gain.step_y[k] + (x - 12) * gain.step_x[k];
                    part[k] = (int)floor(8 * (at - floor(at)));
                }
                factor = (double)factors.gain[8 * part[1] + part[0]];
            }
            const double A = clamp(factor * (double)sheet[alpha], 0, 1);
            const double C = i == alpha ? A : factor * (double)sheet[i], I = (double)image[i];
            if (i == alpha)
                expected[i] = I - A * I;
            else
                expected[i] = front ? I + (double)image[alpha] * C : (1 - A) * I + C;
            error[i] = C == 0 && A == 0 ? 0 : 5 * UNIT * (fabs(I) + fabs(C) + fabs(A * I));
        }
        for (int set = 0; set < KERNELS_SETS(sets); set++) {
            memcpy(found_sheet, sheet, sizeof sheet);
            memcpy(found, image, sizeof image);
            memcpy(spans, first, sizeof spans);
            sets[set](&band, has_gain ? &gain : NULL, front);
            kernels_expect_near(found, expected, error, FLOATS, "composited sheet", set);
            kernels_check_guards(found, "composited sheet", set);
            kernels_check_guards(found_sheet, "composited sheet", set);
            for (int i = 0; i < FLOATS; i++)
                assert_true(found_sheet[i] == 0);
            for (int y = 0; y < BAND_ROWS; y++)
                assert_true(spans[y][0] >= spans[y][1]);
        }
    }
    kernels_free(found_sheet);
    kernels_free(found);
}

/* ---- tiles ----------------------------------------------------------------------------------- */

typedef void tile_function(const cvol_tile_task *);
typedef void row_function(const cvol_tile_row *);

/* A path has at most 32 products along each axis, the step's product and the sum with the previous
 * value. */
static void tiles_are_added(void **state)
{
    (void)state;
    tile_function *const sets[] = CVOL_SIMD_SETS(cvol_tile_add);
    enum { STRIDE = CVOL_TILE_PLACES + 7, FLOATS = STRIDE * CVOL_TILE_PLACES };
    static uint32_t terms[2 * 1024];
    static float across[32 * CVOL_TILE_PLACES] __attribute__((aligned(64)));
    static float down[32 * CVOL_TILE_PLACES + CVOL_TILE_SPARE] __attribute__((aligned(64)));
    static float before[FLOATS];
    static double values[1024], expected[FLOATS], error[FLOATS];
    float *out = kernels_memory(sizeof before);
    for (uint64_t number = 0; number < CASES; number++) {
        random_state r = kernels_random(300 + number);
        const int log2 = 3 + (int)number % 3, B = 1 << log2, bits = cvol_place_bits(log2);
        cvol_tile_task task = {.terms = terms,
                               .end = terms,
                               .step = 0.3f,
                               .block_log2 = log2,
                               .across = across,
                               .down = down,
                               .out = out,
                               .stride = STRIDE};
        task.width = 16 * (1 + (int)random_below(&r, CVOL_TILE_PLACES / 16));
        task.from = (int)random_below(&r, (uint32_t)task.width);
        task.to = task.from + (int)random_below(&r, (uint32_t)(task.width - task.from) + 1);
        const int low[2] = {1 + (int)random_below(&r, (uint32_t)B),
                            1 + (int)random_below(&r, (uint32_t)B)};
        const uint32_t one_of = 1 + random_below(&r, 6); /* sparse and dense ones */
        memset(values, 0, sizeof values);
        uint32_t *at = terms;
        for (int i = 0; i < B * B; i++) {
            const int u = i % B, v = i / B;
            int32_t value = (int32_t)(40 * random_signed(&r));
            if (u >= low[0] || v >= low[1] || random_below(&r, one_of) || !value)
                continue;
            value *= random_below(&r, 60) ? 1 : 1000000; /* an escape */
            at += cvol_term_pack(at, (uint32_t)i, value, bits);
            values[i] = value;
            task.columns = u + 1 > task.columns ? u + 1 : task.columns;
            task.rows = v + 1;
        }
        task.end = at;
        for (int i = 0; i < 32 * CVOL_TILE_PLACES; i++) {
            across[i] = (float)random_signed(&r);
            down[i] = (float)random_signed(&r);
        }
        for (int i = 0; i < FLOATS; i++) {
            before[i] = (float)(100 * random_signed(&r));
            expected[i] = (double)before[i];
            error[i] = 0;
        }
        for (int y = task.from; y < task.to; y++)
            for (int x = 0; x < task.width; x++) {
                double sum = 0, size = 0;
                for (int v = 0; v < task.rows; v++)
                    for (int u = 0; u < task.columns; u++) {
                        const double part = (double)task.step * values[B * v + u] *
                                            (double)across[u * task.width + x] *
                                            (double)down[v * task.width + y];
                        sum += part;
                        size += fabs(part);
                    }
                expected[STRIDE * y + x] += sum;
                error[STRIDE * y + x] = (2 * 32 + 3) * UNIT *
                                        (size + fabs((double)before[STRIDE * y + x]));
            }
        for (int set = 0; set < KERNELS_SETS(sets); set++) {
            memcpy(out, before, sizeof before);
            sets[set](&task);
            kernels_expect_near(out, expected, error, FLOATS, "tile", set);
            kernels_check_guards(out, "tile", set);
        }
    }
    kernels_free(out);
}

static void rows_of_tiles_are_composited(void **state)
{
    (void)state;
    row_function *const sets[] = CVOL_SIMD_SETS(cvol_tile_composite);
    enum { ROW = 96, LINES = 2 * CVOL_PLANES };
    static float first[LINES][ROW];
    float *lines[LINES];
    for (int k = 0; k < LINES; k++)
        lines[k] = kernels_memory(sizeof *first);
    for (uint64_t number = 0; number < CASES; number++) {
        random_state r = kernels_random(400 + number);
        cvol_tile_row row = {.transmittance = lines[0],
                             .sheet_opacity = lines[1],
                             .channels = number % 2 ? 3 : 1,
                             .count = 1 + (int)random_below(&r, ROW),
                             .front = number / 2 % 2 == 1,
                             .cut = number / 4 % 2 == 1};
        for (int k = 0; k < LINES; k++)
            for (int i = 0; i < ROW; i++)
                first[k][i] = (float)(0.4 + random_signed(&r));
        for (int c = 0; c < row.channels; c++) {
            row.colours[c] = lines[2 + 2 * c];
            row.sheet[c] = lines[3 + 2 * c];
        }
        for (int set = 0; set < KERNELS_SETS(sets); set++) {
            for (int k = 0; k < LINES; k++)
                memcpy(lines[k], first[k], sizeof *first);
            sets[set](&row);
            for (int i = 0; i < row.count; i++) {
                const double D = clamp((double)first[1][i], 0, 1), T = (double)first[0][i];
                const double through = T - T * D, of_through = 3 * UNIT * fabs(T);
                kernels_expect_near(&row.transmittance[i], &through, &of_through, 1, "1 - A", set);
                assert_true(row.sheet_opacity[i] == 0);
                for (int c = 0; c < row.channels; c++) {
                    const double I = (double)first[2 + 2 * c][i];
                    double C = (double)first[3 + 2 * c][i];
                    if (row.cut)
                        C = clamp(C, 0, (double)CVOL_BRIGHTEST * D);
                    const double expected = row.front ? I + T * C : (1 - D) * I + C;
                    const double error = 5 * UNIT * (fabs(I) + fabs(C) + fabs(T * C));
                    kernels_expect_near(&row.colours[c][i], &expected, &error, 1, "tiles' colours",
                                        set);
                    assert_true(row.sheet[c][i] == 0);
                }
            }
            for (int k = 0; k < LINES; k++)
                kernels_check_guards(lines[k], "composited tiles", set);
        }
    }
    for (int k = 0; k < LINES; k++)
        kernels_free(lines[k]);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(samples_are_listed),           cmocka_unit_test(footprints_are_added),
        cmocka_unit_test(slices_are_composited),        cmocka_unit_test(tiles_are_added),
        cmocka_unit_test(rows_of_tiles_are_composited),
    };
    kernels_begin();
    return cmocka_run_group_tests(tests, context_setup, context_teardown);
}
