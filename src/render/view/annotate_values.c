/* The bar of an annotation: colours of values, and next to them opacities, or grey levels. */
#include <math.h>
#include <stdio.h>

#include "render/transfer/transfer.h"
#include "render/view/annotate.h"

#define STEPS_MIN 4 /* intervals between ticks, at least, unless there is no room */
#define DIGITS_MIN 5
#define DIGITS_MAX 15 /* of a double */

typedef struct bar {
    double lo, hi;                /* samples */
    double x, top, height, width; /* of the colour bar, in pixels */
    double graph;                 /* width of the graph of opacities, on its left */
    double most;                  /* opacity at the graph's far side */
    double tick, first;           /* of labelled values */
    double label;                 /* the widest one, in pixels */
    int ticks, digits;            /* digits: so many that neighbouring labels differ */
} bar;

static double display_value(const cvol_sketch *s, double sample)
{
    return s->of->rescale[0] * sample + s->of->rescale[1];
}

static double sample_of(const cvol_sketch *s, double value)
{
    return (value - s->of->rescale[1]) / s->of->rescale[0];
}

/* Finds the range; 0 if there is nothing to show. */
static int find_range(bar *b, const cvol_sketch *s)
{
    const cvol_transfer *transfer = s->of->transfer;
    if (s->grey) {
        b->lo = s->of->range[0];
        b->hi = s->of->range[1];
    } else {
        if (!transfer)
            return 0;
        b->lo = transfer->points[0].value;
        b->hi = transfer->points[transfer->count - 1].value;
        for (size_t i = 0; i < transfer->count; i++)
            b->most = fmax(b->most, transfer->points[i].opacity);
    }
    return isfinite(b->hi - b->lo) && b->hi > b->lo && fabs(s->of->rescale[0]) > 0;
}

static void tick_text(char text[32], const bar *b, int k)
{
    const double value = b->first + k * b->tick;
    snprintf(text, 32, "%.*g", b->digits, fabs(value) < 1e-9 * b->tick ? 0 : value);
}

static void choose_ticks(bar *b, const cvol_sketch *s)
{
    const double a = display_value(s, b->lo), c = display_value(s, b->hi), least = fmin(a, c),
                 most = fmax(a, c);
    const double room = fmax(b->height / (2.2 * s->letter), 1);
    b->tick = cvol_length_round((most - least) / fmin(STEPS_MIN, room));
    b->first = ceil(least / b->tick - 1e-6) * b->tick;
    b->ticks = (int)floor((most - b->first) / b->tick + 1e-6) + 1;
    const double digits = floor(log10(fmax(fabs(least), fabs(most)) / b->tick)) + 2;
    b->digits = (int)fmin(fmax(digits, DIGITS_MIN), DIGITS_MAX);
    for (int k = 0; k < b->ticks; k++) {
        char text[32];
        tick_text(text, b, k);
        b->label = fmax(b->label, cvol_text_width(s->font, text));
    }
}

static double row_of(const bar *b, double sample)
{
    return b->top + b->height * (b->hi - sample) / (b->hi - b->lo);
}

static cvol_transfer_point look(const cvol_sketch *s, const bar *b, double sample)
{
    if (!s->grey)
        return cvol_transfer_at(s->of->transfer, sample);
    const double level = (sample - b->lo) / (b->hi - b->lo);
    return (cvol_transfer_point){sample, level, level, level, 1};
}

/* Row by row, at its middle. */
static void draw_rows(const cvol_sketch *s, const bar *b)
{
    const float white[3] = {1, 1, 1}, black[3] = {0, 0, 0};
    const float *ground = s->is_bright ? white : black;
    for (int y = (int)b->top; y < b->top + b->height; y++) {
        const double t = fmin(fmax((b->top + b->height - y - 0.5) / b->height, 0), 1);
        const cvol_transfer_point p = look(s, b, b->lo + t * (b->hi - b->lo));
        const float rgb[3] = {(float)p.r, (float)p.g, (float)p.b};
        const double y0 = fmax(y, b->top), y1 = fmin(y + 1, b->top + b->height);
        cvol_ink_box(s->image, b->x, y0, b->x + b->width, y1, rgb, 1);
        if (b->graph <= 0)
            continue;
        const double reach = b->most > 0 ? b->graph * p.opacity / b->most : 0;
        cvol_ink_box(s->image, b->x - b->graph, y0, b->x - reach, y1, ground, 0.35f);
        cvol_ink_box(s->image, b->x - reach, y0, b->x, y1, s->pen.rgb, 0.75f);
    }
}

static void draw_frame(const cvol_sketch *s, const bar *b)
{
    const float x0 = (float)(b->x - b->graph), x1 = (float)b->x, x2 = (float)(b->x + b->width);
    const float y0 = (float)b->top, y1 = (float)(b->top + b->height);
    const cvol_segment lines[5] = {
        {x0, y0, x2, y0}, {x0, y1, x2, y1}, {x0, y0, x0, y1}, {x2, y0, x2, y1}, {x1, y0, x1, y1}};
    cvol_pen pen = s->pen;
    pen.width = fmaxf(pen.width * 0.7f, 1);
    cvol_ink_halo(s->image, lines, 5, &pen);
    draw_rows(s, b);
    cvol_ink_stroke(s->image, lines, b->graph > 0 ? 5 : 4, &pen);
}

static void draw_labels(const cvol_sketch *s, const bar *b)
{
    const double x = b->x + b->width;
    for (int k = 0; k < b->ticks; k++) {
        char text[32];
        const double row = row_of(b, sample_of(s, b->first + k * b->tick));
        const float y = (float)row, from = (float)x, to = (float)(x + 0.45 * s->letter);
        const cvol_segment line = {from, y, to, y};
        tick_text(text, b, k);
        cvol_ink_halo(s->image, &line, 1, &s->pen);
        cvol_ink_stroke(s->image, &line, 1, &s->pen);
        cvol_text_draw(s->image, s->font, text, x + 0.8 * s->letter, row + s->letter / 2, &s->pen);
    }
}

/* From x on, or ending at the margin if it is too long. */
static void draw_head(const cvol_sketch *s, const char *text, double x, double y)
{
    const double most = s->view.width - s->margin - cvol_text_width(s->font, text);
    cvol_text_draw(s->image, s->font, text, fmin(x, most), y, &s->pen);
}

/* The unit above; below, the range of opacities in the graph, in two lines: one would reach the
 * object. */
static void draw_heads(const cvol_sketch *s, const bar *b)
{
    char text[48];
    const double left = b->x - b->graph, below = b->top + b->height + 1.9 * s->letter;
    draw_head(s, s->of->value_unit, b->x, b->top - 0.8 * s->letter);
    if (b->graph <= 0)
        return;
    snprintf(text, sizeof text, "0\xe2\x80\x93%.2g", b->most);
    draw_head(s, "opacity", left, below);
    draw_head(s, text, left, below + 1.6 * s->letter);
}

void cvol_sketch_values(const cvol_sketch *s)
{
    bar b = {0};
    if (!find_range(&b, s))
        return;
    b.height = 0.36 * s->view.height;
    b.top = 0.2 * s->view.height;
    b.width = 1.6 * s->letter;
    b.graph = s->grey ? 0 : 2.4 * s->letter;
    choose_ticks(&b, s);
    b.x = s->view.width - s->margin - b.label - 0.8 * s->letter - b.width;
    if (b.x - b.graph < s->margin || b.height < 3 * s->letter)
        return;
    draw_frame(s, &b);
    draw_labels(s, &b);
    draw_heads(s, &b);
}
