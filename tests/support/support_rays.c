/* Rays through a layer of the sheet engine (support_rays.h).
 *
 * Bounds of errors, u = 2^-24:
 * - Places. Float kernels compute a pixel's place to 2^-18 samples, int16 kernels to 2^-14; a
 *   sample's error is this share of the differences of its four neighbours.
 * - int16 samples with AVX-512: four rounded products with rounded weights: 4.5 units.
 * - Table coordinates are some thousands in single precision: 32 u times their magnitude.
 * - The error of classification is the table's variation within the coordinate's error; in int16
 *   with AVX-512 2^-13 more (its numbers have 14 bits).
 * - The share of a half of an interval is a square root and a division of 14 bits with AVX-512: for
 *   quarters 2^-11 of the share. Powers (parts of an interval) are exact to 2^-13. In int16, roots
 *   are linear between 32 values, exact to 2^-10 up to an opacity of 1/2, and each part is rounded
 *   to 2^-14.
 * - If rounding decides the number of parts of an interval: the difference between both.
 */
#include "test.h"

#include "array/core/array.h"
#include "base/memory.h"
#include "render/sheet/frame/int16_format.h"
#include "render/sheet/frame/table.h"
#include "support_rays.h"

enum {
    PAD = 96,
    LANES = RAYS_WIDTH + 40,
    STRIDE = LANES + 2 * PAD,
    COUNT = (LANES + PAD) / 16 + 4
};
enum { SHEET_STRIDE = STRIDE * (RAYS_ROWS + 2), ROWS_OF_BLOCKS = RAYS_ROWS / 16 };
enum { SAMPLES = SHEET_STRIDE * RAYS_SHEETS, FAR = 1000000 };

#define UNIT 0x1p-24

/* ---- scenes ---------------------------------------------------------------------------------- */

static double clamp(double value, double lo, double hi)
{
    return value < lo ? lo : value > hi ? hi : value;
}

/* A function of a few linear segments, transparent enough for rays to reach the layer's end. */
static void make_transfer(cvol_sheet_table *table, random_state *r)
{
    const int points = 2 + (int)random_below(r, 5);
    const cvol_array array = {.range_min = 0, .range_max = 1000};
    cvol_transfer *transfer = malloc(sizeof *transfer + (size_t)points * sizeof *transfer->points);
    assert_non_null(transfer);
    transfer->count = (size_t)points;
    for (int i = 0; i < points; i++)
        transfer->points[i] = (cvol_transfer_point){
            1000.0 * i / (points - 1), fabs(random_signed(r)), fabs(random_signed(r)),
            fabs(random_signed(r)), random_below(r, 3) ? 0.35 * fabs(random_signed(r)) : 0};
    cvol_sheet_table_fill(table, &array, transfer, 0.9, 0);
    free(transfer);
}

/* int16 kernels are used with tables whose int16 form is usable. */
static void make_table(rays_scene *s, random_state *r)
{
    const float flats[4] = {1e6f, 300, 60, 0.5f};
    cvol_sheet_table *table = &s->table;
    do {
        make_transfer(table, r);
        table->flat = flats[random_below(r, 4)];
        table->steep = 4 * table->flat;
        table->midpoint = 1e9f; /* linear between slices */
        table->midpoint_ramp = 1;
        if (s->kind.is_int16)
            cvol_int16_table_fill(&table->int16, table, s->layer.int16.scale,
                                  s->layer.int16.offset);
    } while (s->kind.is_int16 && !table->int16.usable);
    if (random_below(r, 3) == 0 && !s->kind.is_int16)
        table->segments = 0;
    if (s->kind.is_int16) /* as the int16 samples have it */
        table->flat = (float)(table->int16.flat * (double)table->scale /
                              (double)s->layer.int16.scale);
    table->steep = 4 * table->flat;
    table->light = &s->light;
}

/* Light from the eye: no sign decides. */
static void make_light(rays_scene *s, random_state *r)
{
    double norm = 0;
    s->light = (cvol_light){.on = 1,
                            .ambient = 0.2f,
                            .diffuse = 0.6f,
                            .specular = 0.3f,
                            .shininess = 1 + (int)random_below(r, 20)};
    for (int k = 0; k < 3; k++) {
        s->light.eye[k] = (float)random_signed(r);
        norm += (double)s->light.eye[k] * (double)s->light.eye[k];
        s->light.rise[k] = 0.5f;
    }
    for (int k = 0; k < 3; k++)
        s->light.light[k] = s->light.eye[k] = (float)((double)s->light.eye[k] / sqrt(norm));
    s->light.facing_light = 1;
    s->light.flat = 1e-3f;
}

/* Waves and noise, some parts of which are steep. */
static void make_samples(rays_scene *s, random_state *r)
{
    const double waves[3] = {0.3 * random_signed(r), 0.3 * random_signed(r),
                             0.9 * random_signed(r)};
    const double noise = random_below(r, 2) ? 0.02 : 0.4;
    for (int i = 0; i < SAMPLES; i++) {
        const int x = i % STRIDE, y = i % SHEET_STRIDE / STRIDE, z = i / SHEET_STRIDE;
        const double value = clamp(0.5 + 0.4 * sin(waves[0] * x + waves[1] * y + waves[2] * z) +
                                       noise * random_signed(r),
                                   0, 1);
        s->floats[i] = (float)(1000 * value);
        s->words[i] = cvol_int16_scale_of(&s->layer.int16, s->floats[i]);
        if (s->kind.is_void) /* weights that are multiples of 1/64 give exact covers */
            s->floats[SAMPLES + i] = random_below(r, 4) ? 1 : (float)random_below(r, 3) / 2;
    }
}

static void make_windows(rays_scene *s)
{
    enum { FLAGS = 2 * ROWS_OF_BLOCKS * COUNT };
    const int flag = CVOL_WINDOW_SEEN | (s->kind.is_void ? CVOL_WINDOW_MASKED : 0);
    s->flags = cvol_allocate_zero(FLAGS + 64, 1);
    s->levels = cvol_allocate_zero(2 * FLAGS + 64, sizeof *s->levels);
    assert_true(s->flags && s->levels);
    memset(s->flags, flag, FLAGS);
    s->layer.windows = (cvol_windows){.within = s->flags,
                                      .across = s->flags + FLAGS / 2,
                                      .within_level = s->levels,
                                      .across_level = s->levels + FLAGS / 2,
                                      .count = COUNT,
                                      .spread_at = FLAGS,
                                      .first_row = 0,
                                      .last_row = ROWS_OF_BLOCKS - 1};
}

static void make_sheets(rays_scene *s, random_state *r)
{
    cvol_layer *layer = &s->layer;
    const int eighths = s->kind.is_void; /* see make_samples */
    double lane_rate = 0.8 * random_signed(r), row_rate = 0.8 * random_signed(r);
    double step = s->kind.is_unit ? 1 : 0.35 + 0.6 * fabs(random_signed(r));
    double lane = 22 + 3 * random_signed(r), row = 20 + 3 * random_signed(r);
    if (eighths) {
        lane_rate = floor(8 * lane_rate) / 8;
        row_rate = floor(8 * row_rate) / 8;
        step = floor(8 * step) / 8;
        lane = floor(8 * lane) / 8;
        row = floor(8 * row) / 8;
    }
    for (int k = 0; k < layer->sheet_count; k++) {
        cvol_sheet_view *sheet = &layer->sheets[k];
        *sheet = (cvol_sheet_view){.samples = s->kind.is_int16 ? NULL : s->floats,
                                   .int16 = s->kind.is_int16 ? s->words : NULL,
                                   .first = PAD + STRIDE + (ptrdiff_t)k * SHEET_STRIDE,
                                   .ordinal = RAYS_ORDINAL + k,
                                   .front = -50,
                                   .back = 50,
                                   .lane_at = lane + k * lane_rate,
                                   .lane_step = step,
                                   .row_at = row + k * row_rate,
                                   .lane_rate = {lane_rate, 0},
                                   .row_rate = {row_rate, 0},
                                   .end = s->width / CVOL_GROUP,
                                   .inside_end = s->width / CVOL_GROUP,
                                   .is_first = k == 0};
        if (s->kind.is_image_order) {
            sheet->row_step = 0.7;
            sheet->row_right = 0.4;
            sheet->lane_down = -0.3;
        }
    }
}

void rays_make(rays_scene *s, const rays_kind *kind, random_state *r)
{
    memset(s, 0, sizeof *s);
    s->kind = *kind;
    s->width = CVOL_GROUP * (1 + (int)random_below(r, RAYS_GROUPS));
    s->floats = cvol_allocate_zero(2 * SAMPLES + 64, sizeof *s->floats);
    s->words = cvol_allocate_zero(SAMPLES + 64, sizeof *s->words);
    assert_true(s->floats && s->words);
    s->layer = (cvol_layer){.sheet_count = 2 + (int)random_below(r, RAYS_SHEETS - 1),
                            .int16 = {30, 1000},
                            .row_stride = STRIDE,
                            .cover_at = kind->is_void ? SAMPLES : 0,
                            .unit = kind->is_unit,
                            .parts = 1,
                            .perspective = kind->is_perspective,
                            .lane_lo = -FAR,
                            .lane_hi = FAR,
                            .row_lo = -FAR,
                            .row_hi = FAR,
                            .lane_enter = -FAR,
                            .lane_leave = FAR,
                            .row_enter = -FAR,
                            .row_leave = FAR,
                            .lane_slices = 1,
                            .row_slices = 1,
                            .length = 0.8,
                            .length_lane = {0.1, 0.01},
                            .length_row = {0.3, 0},
                            .row_points = 16,
                            .block_rows = ROWS_OF_BLOCKS,
                            .from_row = -1,
                            .to_row = RAYS_ROWS,
                            .from_lane = -PAD,
                            .to_lane = LANES + PAD - 1,
                            .row_points_inverse = ((UINT64_C(1) << 32) - 1) / 16 + 1};
    make_windows(s);
    make_sheets(s, r);
    make_light(s, r);
    make_table(s, r);
    make_samples(s, r);
}

void rays_free(rays_scene *s)
{
    free(s->floats);
    free(s->words);
    free(s->flags);
    free(s->levels);
}

/* ---- samples --------------------------------------------------------------------------------- */

static double sample(const rays_scene *s, int sheet, ptrdiff_t x, ptrdiff_t y)
{
    const ptrdiff_t at = s->layer.sheets[sheet].first + y * STRIDE + x;
    return s->kind.is_int16 ? (double)s->words[at] : (double)s->floats[at];
}

rays_sample rays_sample_at(const rays_scene *s, int of, int at, int i, int lane, int row,
                           int is_widest)
{
    const cvol_sheet_view *sheet = &s->layer.sheets[at];
    const int is_square = s->kind.is_image_order;
    const int column = is_square ? i / CVOL_GROUP * CVOL_SQUARE + i % CVOL_SQUARE : i;
    const int line = is_square ? i % CVOL_GROUP / CVOL_SQUARE : 0;
    const double u = sheet->lane_at + column * sheet->lane_step + line * sheet->lane_down;
    const double v = sheet->row_at + line * sheet->row_step + column * sheet->row_right;
    const ptrdiff_t x = (ptrdiff_t)floor(u) + lane, y = (ptrdiff_t)floor(v) + row;
    const double right = u - floor(u), below = v - floor(v);
    const double weight[4] = {(1 - right) * (1 - below), right * (1 - below), (1 - right) * below,
                              right * below};
    const int in_words = s->kind.is_int16 && is_widest;
    double four[4], sum = 0, least = INFINITY, most = -INFINITY;
    rays_sample out = {0, 0, 0};
    for (int k = 0; k < 4; k++) {
        const ptrdiff_t from_x = x + k % 2, from_y = y + k / 2;
        const double cover =
            s->kind.is_void
                ? (double)s->floats[SAMPLES + s->layer.sheets[of].first + from_y * STRIDE + from_x]
                : 1;
        four[k] = sample(s, of, from_x, from_y);
        sum += weight[k] * cover * four[k];
        out.cover += weight[k] * cover;
        least = fmin(least, four[k]);
        most = fmax(most, four[k]);
    }
    out.value = sum / fmax(out.cover, 1e-4);
    out.error = 2 * (most - least) * (in_words ? 0x1p-14 : 0x1p-18) + (in_words ? 4.5 : 0) +
                16 * UNIT * (fabs(most) + fabs(least));
    return out;
}

/* The same as table coordinates. */
static rays_sample coordinate_at(const rays_scene *s, int of, int at, int i, int lane, int row,
                                 int is_widest)
{
    rays_sample out = rays_sample_at(s, of, at, i, lane, row, is_widest);
    const double scale = (double)s->table.scale;
    const double unit = s->kind.is_int16 ? scale / (double)s->layer.int16.scale : scale;
    const double offset = s->kind.is_int16 ? -(double)s->layer.int16.offset * unit : 0;
    out.value = out.value * unit + offset - (double)s->table.from * scale;
    out.error = out.error * unit +
                32 * UNIT * (fabs(out.value) + fabs(offset) + fabs((double)s->table.from) * scale);
    return out;
}

/* ---- classification -------------------------------------------------------------------------- */

/* Colour times opacity, and opacity. */
typedef struct matter {
    double v[4], error;
} matter;

static void classify_at(double v[4], const cvol_sheet_table *table, double t, int by_pieces)
{
    if (by_pieces) {
        int i = 0;
        t = clamp(t, 0.5, CVOL_TABLE_SIZE - 0.5);
        while (t >= (double)table->segment_end[i])
            i++;
        for (int k = 0; k < 4; k++)
            v[k] = (double)table->segment_start[k][i] + t * (double)table->segment_rise[k][i];
        return;
    }
    const cvol_pair entry = table->entries[(int)clamp(t, 0, CVOL_TABLE_SIZE - 1)];
    v[3] = (double)entry.first;
    for (int k = 0; k < 3; k++)
        v[k] = v[3] * (entry.second >> 10 * k & 1023) / 1023;
}

/* With AVX-512 the table's segments are looked up, if it has them. */
static matter classify(const rays_scene *s, double t, double error, int is_widest)
{
    const int by_pieces = is_widest && s->table.segments && !s->kind.is_void;
    matter out;
    double sides[2][4];
    classify_at(out.v, &s->table, t, by_pieces);
    for (int side = 0; side < 2; side++)
        classify_at(sides[side], &s->table, t + (side ? error : -error), by_pieces);
    out.error = 16 * UNIT + (s->kind.is_int16 && is_widest ? 0x1p-13 : 0);
    double most = 0;
    for (int k = 0; k < 4; k++)
        most = fmax(most, fmax(fabs(sides[0][k] - out.v[k]), fabs(sides[1][k] - out.v[k])));
    out.error += most;
    return out;
}

/* ---- compositing ----------------------------------------------------------------------------- */

/* The effect of light on a classified sample: a factor and an addend, with the bound of their
 * errors. */
typedef struct lit {
    double factor, gloss, error;
} lit;

static void illuminate(matter *m, const lit *by)
{
    for (int k = 0; k < 3; k++)
        m->v[k] = m->v[k] * by->factor + m->v[3] * by->gloss;
    m->error = m->error * (1 + by->gloss) + 2 * by->error * m->v[3];
}

/* An interval between two table coordinates, which ends at the slice of an ordinal. */
typedef struct interval {
    double from, to, error, weight, begin, end;
    const lit *light[2]; /* NULL: none */
    int is_weighted, is_widest;
} interval;

/* One of n parts, classified at the mean of its ends. */
static void composite_part(rays_pixel *p, const rays_scene *s, const matter *a, const matter *b,
                           const interval *i, int n, double begin, double end)
{
    const double before = p->transmittance, opacity = 0.5 * (a->v[3] + b->v[3]);
    const double error = 0.5 * (a->error + b->error);
    const int in_words = s->kind.is_int16 && i->is_widest;
    double share = n == 1 ? 1 : 1.0 / n, relative = 16 * UNIT;
    if (n > 1 && opacity > 1e-9)
        share = (1 - pow(1 - opacity, 1.0 / n)) / opacity;
    if (n > 1)
        relative += in_words ? 0x1p-9 : 0x1p-11;
    if (i->is_weighted) {
        share *= opacity > 1e-9 ? (1 - pow(1 - opacity, i->weight)) / opacity : i->weight;
        relative += 0x1p-13;
    }
    const double rounded = in_words ? 0x1p-14 : 4 * UNIT;
    p->colour_error += rounded;
    for (int k = 0; k < 3; k++)
        p->colour[k] += before * share * 0.5 * (a->v[k] + b->v[k]);
    const double most = fmax(fmax(a->v[0] + b->v[0], a->v[1] + b->v[1]), a->v[2] + b->v[2]) / 2;
    p->colour_error += p->transmittance_error * share * most +
                       before * share * (error + most * relative);
    p->transmittance -= before * share * opacity;
    p->transmittance_error = p->transmittance_error * (1 - share * opacity) +
                             before * share * (error + opacity * relative) + rounded;
    if (before > 0.5 && p->transmittance <= 0.5) {
        const double fall = before - p->transmittance;
        p->half = begin + (before - 0.5) / fall * (end - begin);
        p->half_error = 3 * p->transmittance_error / fall * (end - begin) + 1e-5;
        /* If it may pass before or behind this part, the result is unknown. */
        if (before - 0.5 < 2 * p->transmittance_error ||
            0.5 - p->transmittance < 2 * p->transmittance_error)
            p->half_error = INFINITY;
    } else if (fabs(p->transmittance - 0.5) < 2 * p->transmittance_error) {
        p->half_error = INFINITY;
    }
}

static void composite_in(rays_pixel *p, const rays_scene *s, const interval *i, int n)
{
    matter last = {{0}, 0};
    for (int part = 0; part <= n; part++) {
        const double t = (double)part / n;
        matter now = classify(s, i->from + t * (i->to - i->from), i->error, i->is_widest);
        if (i->light[0]) {
            const lit *a = i->light[0], *b = i->light[1];
            const lit between = {a->factor + t * (b->factor - a->factor),
                                 a->gloss + t * (b->gloss - a->gloss), fmax(a->error, b->error)};
            illuminate(&now, &between);
        }
        if (part)
            composite_part(p, s, &last, &now, i, n, i->begin + (t - 1.0 / n) * (i->end - i->begin),
                           i->begin + t * (i->end - i->begin));
        last = now;
    }
}

/* In 1, 2 or 4 parts, by the interval's rise and the remaining transmittance. */
static void composite_interval(rays_pixel *p, const rays_scene *s, const interval *i)
{
    const double rise = fabs(i->to - i->from), seen = rise * p->transmittance;
    const double flat = (double)s->table.flat;
    const double unsure = 2 * i->error + rise * p->transmittance_error + 1e-4 * seen +
                          (s->kind.is_int16 && i->is_widest
                               ? 4 * flat / fmax(1, s->table.int16.flat)
                               : 0);
    const int few = seen - unsure > 4 * flat ? 4 : seen - unsure > flat ? 2 : 1;
    const int many = seen + unsure > 4 * flat ? 4 : seen + unsure > flat ? 2 : 1;
    rays_pixel other = *p;
    composite_in(p, s, i, seen > 4 * flat ? 4 : seen > flat ? 2 : 1);
    for (int n = few; n <= many; n *= 2) {
        rays_pixel way = other;
        composite_in(&way, s, i, n);
        double most = 0;
        for (int k = 0; k < 3; k++)
            most = fmax(most, fabs(way.colour[k] - p->colour[k]));
        p->colour_error = fmax(p->colour_error, way.colour_error + most);
        p->transmittance_error = fmax(p->transmittance_error,
                                      way.transmittance_error +
                                          fabs(way.transmittance - p->transmittance));
        if (few < many && way.half != p->half)
            p->half_error = INFINITY;
    }
}

rays_pixel rays_composite(const rays_scene *s, const rays_pixel *start, int i, int is_widest,
                          double *value, double *value_error, double *cover)
{
    const cvol_layer *layer = &s->layer;
    rays_pixel p = *start;
    for (int k = 0; k < layer->sheet_count; k++) {
        const rays_sample now = coordinate_at(s, k, k, i, 0, 0, is_widest);
        interval all = {.from = *value,
                        .to = now.value,
                        .error = fmax(*value_error, now.error),
                        .weight = 1,
                        .begin = RAYS_ORDINAL + k - 1,
                        .end = RAYS_ORDINAL + k,
                        .is_weighted = s->kind.is_perspective || s->kind.is_void,
                        .is_widest = is_widest};
        if (s->kind.is_perspective) {
            const double lane = layer->length_lane[0] + i * layer->length_lane[1];
            all.weight = sqrt(layer->length + layer->length_row[0] * layer->length_row[0] +
                              lane * lane);
        }
        if (s->kind.is_void) { /* an end without a value takes the other's */
            all.to = now.cover < 1e-4 ? *value : now.value;
            all.from = *cover < 1e-4 ? now.value : *value;
            all.weight *= 0.5 * (*cover + now.cover);
            *cover = now.cover;
        }
        if (all.weight >= 1e-4)
            composite_interval(&p, s, &all);
        *value = now.value;
        *value_error = now.error;
    }
    return p;
}

/* Light from the eye at slice k, by differences of points two apart: beyond the layer a ray
 * continues in the same direction, but not at the volume's end. */
static lit light_at(const rays_scene *s, int k, int i, int is_widest)
{
    const cvol_light *light = &s->light;
    const int last = s->layer.sheet_count - 1;
    const rays_sample here = coordinate_at(s, k, k, i, 0, 0, is_widest);
    const double lane = coordinate_at(s, k, k, i, 1, 0, is_widest).value -
                        coordinate_at(s, k, k, i, -1, 0, is_widest).value;
    const double row = coordinate_at(s, k, k, i, 0, 1, is_widest).value -
                       coordinate_at(s, k, k, i, 0, -1, is_widest).value;
    double rise = k < last ? coordinate_at(s, k + 1, k, i, 0, 0, is_widest).value - here.value : 0;
    double fall = k > 0 ? here.value - coordinate_at(s, k - 1, k, i, 0, 0, is_widest).value : rise;
    const double gradient[3] = {lane * (double)light->rise[0], row * (double)light->rise[1],
                                (rise + fall) * (double)light->rise[2]};
    double square = 0, along = 0;
    for (int a = 0; a < 3; a++) {
        square += gradient[a] * gradient[a];
        along += gradient[a] * (double)light->eye[a];
    }
    const double flat = (double)light->flat + 1e-30, flatness = flat / (square + flat);
    const double facing = fabs(along) / sqrt(fmax(square, 1e-30)) * (1 - flatness) + flatness;
    const double gloss = pow(fmax(2 * facing * facing - 1, 0), light->shininess);
    /* Cosines are exact to 1e-6, plus the error of the differences over their length. */
    const double off = 1e-6 + 4 * here.error / fmax(sqrt(square), 1e-9);
    return (lit){(double)light->ambient + (double)light->diffuse * facing,
                 (double)light->specular * gloss, fmin(1, (1 + 4 * light->shininess) * off)};
}

rays_pixel rays_shade(const rays_scene *s, const rays_pixel *start, int i, int is_widest)
{
    rays_pixel p = *start;
    lit before = light_at(s, 0, i, is_widest);
    rays_sample last = coordinate_at(s, 0, 0, i, 0, 0, is_widest);
    /* Half of the interval before the first slice is drawn, with the slice's value. */
    interval all = {.from = last.value,
                    .to = last.value,
                    .error = last.error,
                    .weight = 0.5,
                    .begin = RAYS_ORDINAL - 1,
                    .end = RAYS_ORDINAL,
                    .light = {&before, &before},
                    .is_weighted = 1,
                    .is_widest = is_widest};
    composite_interval(&p, s, &all);
    /* The interval up to the last slice is drawn when the ray ends, by the table's entries. */
    for (int k = 1; k < s->layer.sheet_count; k++) {
        const rays_sample now = coordinate_at(s, k, k, i, 0, 0, is_widest);
        const lit after = light_at(s, k, i, is_widest);
        all = (interval){.from = last.value,
                         .to = now.value,
                         .error = fmax(last.error, now.error),
                         .weight = 1,
                         .begin = RAYS_ORDINAL + k - 1,
                         .end = RAYS_ORDINAL + k,
                         .light = {&before, &after},
                         .is_widest = is_widest && k + 1 < s->layer.sheet_count};
        composite_interval(&p, s, &all);
        before = after;
        last = now;
    }
    return p;
}

/* ---- projections ----------------------------------------------------------------------------- */

rays_projection rays_project(const rays_scene *s, int i, int is_widest)
{
    rays_projection out = {0, 0, -INFINITY, INFINITY, 0};
    for (int k = 0; k < s->layer.sheet_count; k++) {
        const rays_sample now = rays_sample_at(s, k, k, i, 0, 0, is_widest);
        const cvol_sheet_view *sheet = &s->layer.sheets[k];
        /* The drawn share of half an interval before and behind the slice. */
        const double weight = fmin((double)sheet->back, 0.5) - fmax((double)sheet->front, -0.5);
        if (weight >= 1e-4) {
            out.sum += weight * now.cover * now.value;
            out.weight += weight * now.cover;
            out.error += now.error + 16 * UNIT * fabs(out.sum);
        }
        if (weight >= 1e-4 && now.cover >= 0.5) {
            out.largest = fmax(out.largest, now.value);
            out.smallest = fmin(out.smallest, now.value);
        }
    }
    return out;
}
