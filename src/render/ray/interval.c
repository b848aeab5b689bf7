/* Light of one interval of a ray (interval.h).
 *
 * Along most intervals the transfer function is nearly linear and changes little (table.c). These
 * are one part, with colour and opacity from the table.
 *
 * Others are divided. Along each half of an interval the volume is linear, so the function is
 * passed at a constant rate, from one end's value to the other's. The half is divided where it
 * passes a point of the function, and each piece into n equal parts, n = ceil(8 times the largest
 * change of r, g, b and opacity along the piece). A part has the colour in the centre of its light.
 * Its opacity is exact: the opacity per mean spacing is linear along it, 1 - (p + (q - p) s) for
 * 0 <= s <= 1, so over a length of d mean spacings
 *
 *     a = 1 - exp(-d M),  M = integral of -log(p + (q - p) s) over 0..1
 *                           = 1 - (p log p - q log q) / (p - q)
 *
 * M is infinite only if p = q = 0: an opacity of 1 along a positive length is opaque. */
#include "render/ray/interval.h"

#include <math.h>

/* Parts of a piece along which a channel changes by 1. */
#define PARTS 8
/* A half that passes more points of the function has this number of equal parts instead. */
#define PIECES_MAX 64

/* Composites a part of the interval, between the shares t and t + length of it, with this
 * opacity. */
static inline void add_part(cvol_ray_seen *light, const cvol_ray_interval *in, double t,
                            double length, const double rgb[3], double opacity)
{
    const double factor = in->lit.factor, gloss = in->lit.gloss;
    const double before = light->through;
    for (int c = 0; c < 3; c++)
        light->rgb[c] += before * opacity * (rgb[c] * factor + gloss);
    light->through *= 1 - opacity;
    if (before > 0.5 && light->through <= 0.5)
        light->depth = in->depth +
                       in->rise * (t + length * log(2 * before) / log(before / light->through));
}

void cvol_ray_interval_add(cvol_ray_seen *light, const cvol_ray_table *table,
                           const cvol_ray_interval *in, double value)
{
    double colour[4];
    cvol_ray_table_at(colour, table, value);
    if (colour[3] > 0)
        add_part(light, in, 0, 1, colour,
                 in->share < 1 ? cvol_opacity_over(colour[3], in->share) : colour[3]);
}

/* ---- halves ---------------------------------------------------------------------------- */

/* One half of an interval. */
typedef struct half {
    const cvol_ray_interval *whole;
    double from, to; /* its values */
    double begin;    /* share of the interval in front of it */
    double distance; /* its length in mean spacings */
} half;

/* Composites a part of the half, between the shares t and t + length of it. */
static void add_half_part(cvol_ray_seen *light, const half *in, double t, double length,
                          const double rgb[3], double opacity)
{
    add_part(light, in->whole, in->begin + t / 2, length / 2, rgb, opacity);
}

/* M of transparencies p and q. */
static double mean_extinction(double p, double q)
{
    const double sum = p + q, difference = p - q;
    if (!(sum > 0))
        return INFINITY;
    if (!(fabs(difference) > 0.01 * sum)) {
        const double ratio = difference / sum;
        return ratio * ratio / 6 - log(sum / 2);
    }
    return 1 - ((p > 0 ? p * log(p) : 0) - (q > 0 ? q * log(q) : 0)) / difference;
}

/* The function at a value of a segment, without the jumps at its ends. */
static cvol_transfer_point within(const cvol_transfer *transfer, size_t segment, double value)
{
    const cvol_transfer_point *q = &transfer->points[segment];
    if (segment == 0)
        return *q;
    const cvol_transfer_point *p = q - 1;
    if (segment == transfer->count)
        return *p;
    /* Halves, because the distance itself may overflow. */
    const double t = (value / 2 - p->value / 2) / (q->value / 2 - p->value / 2);
    return (cvol_transfer_point){value, p->r + (q->r - p->r) * t, p->g + (q->g - p->g) * t,
                                 p->b + (q->b - p->b) * t,
                                 p->opacity + (q->opacity - p->opacity) * t};
}

static double largest_change(const cvol_transfer_point *p, const cvol_transfer_point *q)
{
    return fmax(fmax(fabs(q->r - p->r), fabs(q->g - p->g)),
                fmax(fabs(q->b - p->b), fabs(q->opacity - p->opacity)));
}

/* The mean place of the light of a part, as a share of it, for d M = x and an opacity a: the centre
 * of exp(-x s). */
static double centre_of_light(double x, double a)
{
    return x > 1e-3 ? 1 / x - (1 - a) / a : 0.5 - x / 12;
}

/* Composites the piece from..to, two values of one segment, which begins at the share t. */
static void add_piece(cvol_ray_seen *light, const cvol_ray_table *table, const half *in,
                      size_t segment, double t, double from, double to)
{
    const cvol_transfer_point p = within(table->transfer, segment, from),
                              q = within(table->transfer, segment, to);
    if (!(p.opacity > 0 || q.opacity > 0))
        return;
    const double parts = fmax(ceil(PARTS * largest_change(&p, &q) - 1e-9), 1);
    const double length = (to - from) / (in->to - in->from) / parts;
    double front = 1 - p.opacity;
    for (double k = 0; k < parts; k++) {
        const double back = 1 - (p.opacity + (q.opacity - p.opacity) * ((k + 1) / parts));
        const double distance = length * in->distance;
        /* Not infinity times 0. */
        const double x = distance > 0 ? distance * mean_extinction(front, back) : 0;
        const double opacity = -expm1(-x), at = (k + centre_of_light(x, opacity)) / parts;
        const double rgb[3] = {p.r + (q.r - p.r) * at, p.g + (q.g - p.g) * at,
                               p.b + (q.b - p.b) * at};
        add_half_part(light, in, t + k * length, length, rgb, opacity);
        front = back;
    }
}

/* The segment in which a half that rises (or falls) from a value begins. */
static size_t segment_at(const cvol_ray_table *table, double value, int falls)
{
    const cvol_transfer *transfer = table->transfer;
    size_t segment = table->cells[cvol_ray_table_cell(table, value)].segment;
    while (segment > 0 && (falls ? transfer->points[segment - 1].value >= value
                                 : transfer->points[segment - 1].value > value))
        segment--;
    while (segment < transfer->count && (falls ? transfer->points[segment].value < value
                                               : transfer->points[segment].value <= value))
        segment++;
    return segment;
}

static void add_pieces(cvol_ray_seen *light, const cvol_ray_table *table, const half *in,
                       size_t first, size_t last, int falls)
{
    const cvol_transfer_point *points = table->transfer->points;
    double from = in->from;
    for (size_t segment = first;; segment = falls ? segment - 1 : segment + 1) {
        const double to = segment == last ? in->to
                          : falls         ? points[segment - 1].value
                                          : points[segment].value;
        if (falls ? to < from : to > from)
            add_piece(light, table, in, segment, (from - in->from) / (in->to - in->from), from, to);
        if (segment == last)
            return;
        from = to;
    }
}

/* For a function with very many points. */
static void add_equal_parts(cvol_ray_seen *light, const cvol_ray_table *table, const half *in)
{
    const double length = 1.0 / PIECES_MAX, distance = length * in->distance;
    for (int k = 0; k < PIECES_MAX; k++) {
        const double middle = (k + 0.5) * length;
        const cvol_transfer_point point = cvol_transfer_at(table->transfer,
                                                           in->from + (in->to - in->from) * middle);
        const double rgb[3] = {point.r, point.g, point.b};
        add_half_part(light, in, k * length, length, rgb,
                      cvol_opacity_over(point.opacity, distance));
    }
}

/* A half of one value. */
static void add_value(cvol_ray_seen *light, const cvol_ray_table *table, const half *in)
{
    const cvol_transfer_point point = cvol_transfer_at(table->transfer, in->from);
    const double rgb[3] = {point.r, point.g, point.b};
    add_half_part(light, in, 0, 1, rgb, cvol_opacity_over(point.opacity, in->distance));
}

/* Composites one of its halves. */
static void add_half(cvol_ray_seen *light, const cvol_ray_table *table, const half *in)
{
    const int falls = in->to < in->from;
    if (!falls && !(in->from < in->to)) {
        add_value(light, table, in);
        return;
    }
    const size_t first = segment_at(table, in->from, falls),
                 last = segment_at(table, in->to, !falls);
    if ((falls ? first - last : last - first) < PIECES_MAX)
        add_pieces(light, table, in, first, last, falls);
    else
        add_equal_parts(light, table, in);
}

void cvol_ray_interval_add_divided(cvol_ray_seen *light, const cvol_ray_table *table,
                                   const cvol_ray_interval *in, const double values[3])
{
    for (int k = 0; k < 2; k++) {
        const half part = {in, values[k], values[k + 1], 0.5 * k, in->share / 2 * table->step};
        add_half(light, table, &part);
    }
}
