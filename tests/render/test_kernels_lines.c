/* Line kernels of the sheet engine: each row of their table (render/sheet/frame/kernel_table.h), by
 * every instruction set, against one ray after the other in double precision (support_rays.h),
 * which also bounds rounding. A line goes through one layer of random samples in the middle of a
 * volume, all of which may be visible.
 *
 * Composites: samples by the linear footprint, classified by the table's entries, or by its
 * segments if a set uses these; intervals in 1, 2 or 4 parts; in perspective; with samples without
 * a value; along image-order rays; in int16, by AVX-512 only; with light. With extras also depth.
 * Projections: sums, and largest and smallest samples.
 *
 * Other tests compare pictures instead: faces and planes that cut intervals, skipped blocks
 * (test_sheet.c, test_sheet_beyond.c), samples between slices (test_sheet_between.c), midpoint
 * samples (test_sheet_image_order.c), surfaces and light at midpoints (test_shade.c). Lit lines in
 * image order are compared between instruction sets here, and with the ray caster there. */
#include "test.h"

#include "base/cpu.h"
#include "render/sheet/frame/kernel_table.h"
#include "support.h"
#include "support_kernels.h"
#include "support_rays.h"

enum { CASES = 24, LINE = RAYS_WIDTH };

/* A line, and its initial state. */
typedef struct line_memory {
    cvol_line line;
    float *values, *depth, *pending, *between;
    uint8_t *opaque, *edges;
    int32_t *intersected;
} line_memory;

static float first_values[CVOL_LINES * LINE];

static void make_memory(line_memory *m)
{
    m->values = kernels_memory(sizeof first_values);
    m->depth = kernels_memory(sizeof *m->depth * LINE);
    m->pending = kernels_memory(sizeof *m->pending * CVOL_PENDING_LINES * LINE);
    m->between = kernels_memory(sizeof *m->between * 2 * (CVOL_PARTS - 1) * LINE);
    m->opaque = kernels_memory(RAYS_GROUPS);
    m->edges = kernels_memory(RAYS_GROUPS);
    m->intersected = kernels_memory(sizeof *m->intersected * RAYS_GROUPS);
}

static void free_memory(line_memory *m)
{
    kernels_free(m->values);
    kernels_free(m->depth);
    kernels_free(m->pending);
    kernels_free(m->between);
    kernels_free(m->opaque);
    kernels_free(m->edges);
    kernels_free(m->intersected);
}

static void begin_line(line_memory *m, int width, int met, int has_depth)
{
    memcpy(m->values, first_values, sizeof first_values);
    memset(m->opaque, 0, RAYS_GROUPS);
    for (int i = 0; i < LINE; i++)
        m->depth[i] = INFINITY;
    for (int g = 0; g < RAYS_GROUPS; g++)
        m->intersected[g] = met;
    m->line = (cvol_line){.values = m->values,
                          .opaque = m->opaque,
                          .intersected = m->intersected,
                          .pending = m->pending,
                          .edges = m->edges,
                          .depth = has_depth ? m->depth : NULL,
                          .between = m->between,
                          .width = width};
}

static void check_guards(const line_memory *m, const char *name, int set)
{
    kernels_check_guards(m->values, name, set);
    kernels_check_guards(m->depth, name, set);
    kernels_check_guards(m->pending, name, set);
    kernels_check_guards(m->between, name, set);
    kernels_check_guards(m->opaque, name, set);
    kernels_check_guards(m->edges, name, set);
    kernels_check_guards(m->intersected, name, set);
}

/* ---- composites ------------------------------------------------------------------------------ */

/* The initial state of lines: premultiplied colours, transmittances, and the table coordinates and
 * covers at the slice before. */
static void make_first(const rays_scene *s, random_state *r)
{
    for (int i = 0; i < s->width; i++) {
        first_values[3 * s->width + i] = s->kind.is_lit ? 1 : (float)(0.7 + 0.3 * random_signed(r));
        for (int k = 0; k < 3; k++)
            first_values[k * s->width + i] = (1 - first_values[3 * s->width + i]) *
                                             (float)fabs(random_signed(r));
        first_values[4 * s->width + i] = (float)(1024 + 900 * random_signed(r));
        first_values[5 * s->width + i] = (float)random_below(r, 3) / 2;
    }
}

/* The largest ratio of an error to its bound. */
static double worst;

static void expect_near(double found, double expected, double error, const char *name, int set,
                        int number, int i, const char *what)
{
    const double off = fabs(found - expected);
    if (!(off <= error))
        fail_msg("%s, %s, case %d: %s of pixel %d is %.9g, not %.9g, at most %.3g off", name,
                 cvol_cpu_name((cvol_cpu)set), number, what, i, found, expected, error);
    worst = error > 0 && off / error > worst ? off / error : worst;
}

static void check_composite(const rays_scene *s, const line_memory *m, const char *name, int set,
                            int number)
{
    static const char *const channels[3] = {"red", "green", "blue"};
    const int width = s->width, is_widest = set == CVOL_CPU_AVX512;
    for (int i = 0; i < width; i++) {
        rays_pixel start = {.half = (double)INFINITY};
        for (int k = 0; k < 3; k++)
            start.colour[k] = (double)first_values[k * width + i];
        start.transmittance = (double)first_values[3 * width + i];
        double value = (double)first_values[4 * width + i], cover = 1;
        double value_error = s->kind.is_int16 && is_widest
                                 ? (double)s->table.scale / (double)s->layer.int16.scale
                                 : 0;
        cover = (double)first_values[5 * width + i];
        const rays_pixel p = s->kind.is_lit ? rays_shade(s, &start, i, is_widest)
                                            : rays_composite(s, &start, i, is_widest, &value,
                                                             &value_error, &cover);
        assert_true(p.transmittance > 1.0 / 256); /* otherwise a group might have ended before */
        for (int k = 0; k < 3; k++)
            expect_near((double)m->values[k * width + i], p.colour[k], p.colour_error, name, set,
                        number, i, channels[k]);
        expect_near((double)m->values[3 * width + i], p.transmittance, p.transmittance_error, name,
                    set, number, i, "transmittance");
        if (m->line.depth && p.half_error < INFINITY && p.half < INFINITY)
            expect_near((double)m->depth[i], p.half, p.half_error, name, set, number, i, "depth");
        if (s->kind.is_lit)
            continue;
        expect_near((double)m->values[4 * width + i], value, value_error, name, set, number, i,
                    "table coordinate");
        if (s->kind.is_void)
            expect_near((double)m->values[5 * width + i], cover, 1e-6, name, set, number, i,
                        "cover");
    }
    for (int i = CVOL_LINES * width; i < CVOL_LINES * LINE; i++) /* and nothing behind the line */
        assert_true(m->values[i] == first_values[i]);
}

static void draw_composite(const cvol_kernel_row *row, int set, const rays_scene *s, line_memory *m,
                           int number)
{
    const int last = RAYS_ORDINAL + s->layer.sheet_count - 1, lit = row->key.is_lit;
    begin_line(m, s->width, lit ? INT32_MIN : RAYS_ORDINAL - 1,
               row->key.has_extras == 1 || strstr(row->name, "extra"));
    row->sets[set](&s->layer, &s->table, &m->line);
    for (int g = 0; g < s->width / CVOL_GROUP; g++)
        assert_int_equal(m->intersected[g], last);
    if (lit) { /* rays end with the last slice */
        cvol_layer end = {.parts = 1};
        end.sheets[0].ordinal = last + 1;
        row->sets[set](&end, &s->table, &m->line);
    }
    check_guards(m, row->name, set);
    check_composite(s, m, row->name, set, number);
}

/* The kinds of layers that a row draws, alternately. */
static rays_kind composite_kind(const cvol_kernel_row *row, int number)
{
    rays_kind kind = {.is_image_order = row->key.is_image_order,
                      .is_int16 = row->key.is_int16 == 1,
                      .is_lit = row->key.is_lit,
                      .is_unit = !row->key.is_image_order && number % 2};
    if (!kind.is_image_order && !kind.is_int16 && !kind.is_lit) {
        kind.is_perspective = number % 8 == 2;
        kind.is_void = number % 8 > 4;
    }
    return kind;
}

static void check_row(const cvol_kernel_row *row)
{
    line_memory m;
    make_memory(&m);
    memset(first_values, 0, sizeof first_values);
    worst = 0;
    for (int number = 0; number < CASES; number += SUPPORT_STRIDE) {
        random_state r = kernels_random((uint64_t)number);
        const rays_kind kind = composite_kind(row, number);
        rays_scene s;
        rays_make(&s, &kind, &r);
        make_first(&s, &r);
        for (int set = kind.is_int16 ? CVOL_CPU_AVX512 : 0; set < KERNELS_SETS(row->sets); set++)
            draw_composite(row, set, &s, &m, number);
        rays_free(&s);
    }
    if (test_verbose())
        print_message("%s: errors up to %.3f of their bounds\n", row->name, worst);
    free_memory(&m);
}

static int is_composite(const cvol_kernel_row *row)
{
    const int mode = (int)row->key.mode;
    return mode == CVOL_ANY || mode == CVOL_MODE_COMPOSITE;
}

static void lines_are_composited(void **state)
{
    (void)state;
    size_t count;
    const cvol_kernel_row *rows = cvol_sheet_kernels(&count);
    int checked = 0;
    for (size_t i = 0; i < count; i++) {
        if (!is_composite(&rows[i]) || (rows[i].key.is_lit && rows[i].key.is_image_order))
            continue;
        check_row(&rows[i]);
        checked++;
    }
    assert_true(checked >= 6);
}

/* ---- lit lines in image order ---------------------------------------------------------------- */

/* Draws a line with the row's kernel for a set; the results are in m->values. */
static void draw_lit_image_order(const cvol_kernel_row *row, int set, const rays_scene *s,
                                 line_memory *m)
{
    begin_line(m, s->width, INT32_MIN, 0);
    row->sets[set](&s->layer, &s->table, &m->line);
    cvol_layer end = {.parts = 1};
    end.sheets[0].ordinal = RAYS_ORDINAL + s->layer.sheet_count;
    row->sets[set](&end, &s->table, &m->line);
    check_guards(m, row->name, set);
}

static const cvol_kernel_row *find_row(const char *name)
{
    size_t count;
    const cvol_kernel_row *rows = cvol_sheet_kernels(&count);
    for (size_t i = 0; i < count; i++)
        if (!strcmp(rows[i].name, name))
            return &rows[i];
    fail_msg("there is no kernel %s", name);
    return NULL;
}

static double largest_difference(const float *a, const float *b, int width)
{
    double most = 0;
    for (int i = 0; i < 4 * width; i++)
        most = fmax(most, fabs((double)(a[i] - b[i])));
    return most;
}

/* Every set draws float samples as the set with the shortest vectors does. Only the widest draws
 * int16 samples: about as it draws the floats that these were rounded from. */
static void lit_image_order_agrees(void **state)
{
    (void)state;
    const cvol_kernel_row *floats = find_row("cvol_sheet_image_order_shade"),
                          *int16 = find_row("cvol_sheet_image_order_shade_int16");
    const int sets = KERNELS_SETS(floats->sets);
    static float expected[LINE * CVOL_LINES];
    line_memory m;
    make_memory(&m);
    double most = 0, most_int16 = 0;
    int lit = 0;
    for (int number = 0; number < CASES; number += SUPPORT_STRIDE) {
        const rays_kind kind = {.is_image_order = 1, .is_lit = 1, .is_int16 = 1};
        random_state r = kernels_random(3000 + (uint64_t)number);
        rays_scene s;
        rays_make(&s, &kind, &r);
        make_first(&s, &r);
        if (sets > CVOL_CPU_AVX512) {
            draw_lit_image_order(int16, CVOL_CPU_AVX512, &s, &m);
            memcpy(expected, m.values, sizeof expected);
        }
        s.layer.int16.scale = 0;
        for (int k = 0; k < s.layer.sheet_count; k++) {
            s.layer.sheets[k].samples = s.floats;
            s.layer.sheets[k].int16 = NULL;
        }
        draw_lit_image_order(floats, 0, &s, &m);
        if (sets > CVOL_CPU_AVX512)
            most_int16 = fmax(most_int16, largest_difference(m.values, expected, s.width));
        memcpy(expected, m.values, sizeof expected);
        for (int set = 1; set < sets; set++) {
            draw_lit_image_order(floats, set, &s, &m);
            most = fmax(most, largest_difference(m.values, expected, s.width));
        }
        for (int i = 0; i < s.width; i++)
            lit += expected[i] > 0.02f;
        rays_free(&s);
    }
    if (test_verbose())
        print_message("sets differ by %.3g, int16 samples from floats by %.3g\n", most, most_int16);
    assert_true(lit > 100);
    assert_true(most < 1.0 / 255);
    assert_true(most_int16 < 2e-2);
    free_memory(&m);
}

/* ---- projections ----------------------------------------------------------------------------- */

/* Two layers, one after the other: the second continues with the result of the first. */
static void check_projection(const cvol_kernel_row *row, const rays_scene scenes[2],
                             const line_memory *m, int set, int number)
{
    const int width = scenes[0].width, mode = (int)row->key.mode;
    const int is_words = row->key.is_int16 == 1, is_widest = set == CVOL_CPU_AVX512;
    for (int i = 0; i < width; i++) {
        const rays_projection a = rays_project(&scenes[0], i, 0),
                              b = rays_project(&scenes[1], i, 0);
        const double found = (double)m->values[i], weight = (double)m->values[width + i];
        double error = a.error + b.error;
        if (is_words) /* weights of 2^-14: the error of three is half of that, of one three halves
                       */
            error += is_widest ? 3 * 0x1p-14 * 32767 : 0x1p-8;
        if (mode == CVOL_MODE_XRAY) {
            expect_near(found, a.sum + b.sum, error, row->name, set, number, i, "sum");
            expect_near(weight, a.weight + b.weight, 1e-5 * (1 + weight), row->name, set, number, i,
                        "weight");
            continue;
        }
        const double expected = mode == CVOL_MODE_MIP ? fmax(a.largest, b.largest)
                                                      : fmin(a.smallest, b.smallest);
        const int any = isfinite(expected);
        expect_near(found, any ? expected : 0, any ? error : 0, row->name, set, number, i,
                    "extreme");
        assert_true(weight == any);
    }
}

static void cut_sheets(rays_scene *s, random_state *r)
{
    /* The drawn part ends within the layer, near a slice. */
    const double end = s->layer.sheet_count - 1 - (double)random_below(r, 2) +
                       (random_below(r, 2) ? 0.25 : -0.125);
    for (int k = 0; k < s->layer.sheet_count; k++)
        s->layer.sheets[k].back = (float)(end - k);
}

static void check_projections_of(const cvol_kernel_row *row)
{
    line_memory m;
    make_memory(&m);
    memset(first_values, 0, sizeof first_values);
    worst = 0;
    for (int number = 0; number < CASES; number += SUPPORT_STRIDE) {
        random_state r = kernels_random(1000 + (uint64_t)number);
        const int is_int16 = row->key.is_int16 == 1;
        const rays_kind kind = {.is_int16 = is_int16,
                                .is_unit = is_int16 || number % 2,
                                .is_void = !is_int16 && number % 4 > 1};
        rays_scene s[2];
        for (int k = 0; k < 2; k++)
            rays_make(&s[k], &kind, &r);
        for (int k = 0; k < 2; k++)
            s[k].width = s[1].width;
        for (int k = 0; k < s[0].layer.sheet_count; k++)
            s[0].layer.sheets[k].end = s[0].layer.sheets[k].inside_end = s[1].width / CVOL_GROUP;
        cut_sheets(&s[1], &r);
        for (int set = 0; set < KERNELS_SETS(row->sets); set++) {
            begin_line(&m, s[0].width, INT32_MIN, 0);
            for (int k = 0; k < 2; k++)
                row->sets[set](&s[k].layer, NULL, &m.line);
            check_guards(&m, row->name, set);
            check_projection(row, s, &m, set, number);
        }
        for (int k = 0; k < 2; k++)
            rays_free(&s[k]);
    }
    if (test_verbose())
        print_message("%s: errors up to %.3f of their bounds\n", row->name, worst);
    free_memory(&m);
}

static void lines_are_projected(void **state)
{
    (void)state;
    size_t count;
    const cvol_kernel_row *rows = cvol_sheet_kernels(&count);
    int checked = 0;
    for (size_t i = 0; i < count; i++) {
        if (is_composite(&rows[i]))
            continue;
        check_projections_of(&rows[i]);
        checked++;
    }
    assert_int_equal(checked, 5);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(lines_are_composited),
        cmocka_unit_test(lit_image_order_agrees),
        cmocka_unit_test(lines_are_projected),
    };
    kernels_begin();
    return cmocka_run_group_tests(tests, NULL, NULL);
}
