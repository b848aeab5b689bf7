/* Named transfer functions, fitted to a histogram (fit.h).
 *
 * The background is transparent. Beyond its edge the opacity of depth u is
 *
 *     opacity(u) = ramp(u) min(A share^-0.4 S(u)^-0.65, 0.35)
 *
 * with S(u) the share of the object's samples that lie deeper than u. So common values get a low
 * opacity and rare, deep values a high one, such that both hide about the same along a ray. An
 * object that fills little of the box, and that rays cross in short intervals, is more opaque than
 * one that fills it. The ramp is a smooth step from the edge to the depth that a third of the
 * object lies below, so that the object's skin and the last noise are faint.
 *
 * The density is multiplied by (170 / c)^0.6, with c the mean length of a ray through the box in
 * samples: thin slabs and small volumes are as visible as large ones.
 *
 * "mri" is 2.5 times denser; "bone" shows only dense tissue (fit.h: divide), and "skin-bone" the
 * same within a faint skin.
 *
 * "dense" is for values without empty space, as in electron microscopy: all are opaque, also in a
 * single slice, so the faces of the volume, or of a cut, show grey levels.
 *
 * Colours run along the robust range of the object, by value; for "auto" half by value and half by
 * rank, which spreads them over soft tissue and over rare peaks. If the object lies on both sides
 * of the background (signed data), the side below has the lower half of a colour map; "auto" has a
 * cold map for it. */
#include "render/transfer/transfer.h"

#include <math.h>
#include <string.h>

#include "base/context.h"
#include "render/transfer/fit.h"

#define KNOTS 32 /* intervals of depth */
#define OPACITY_BASE 0.013
#define OPACITY_MAX 0.35
#define CHORD 170 /* samples along a mean ray through 256^3 */
#define CHORD_POWER 0.6
#define COLOURS_MAX 9
#define DENSE_OPACITY 0.5
#define PLAIN_OPACITY 0.05 /* of a single value */
#define DENSE_BLACK 0.05
#define DENSE_WHITE 0.95

/* Evenly spaced colours, 0xRRGGBB. */
typedef struct colour_map {
    int count;
    uint32_t colours[COLOURS_MAX];
} colour_map;

typedef double (*profile_fn)(const cvol_fit *fit, double depth);

static double opacity_balanced(const cvol_fit *fit, double depth);
static double opacity_dense(const cvol_fit *fit, double depth);
static double opacity_skin_bone(const cvol_fit *fit, double depth);
static double opacity_firm(const cvol_fit *fit, double depth);
static double place_by_rank(const cvol_fit *fit, double depth);
static double place_by_value(const cvol_fit *fit, double depth);
static double place_dense(const cvol_fit *fit, double depth);
static double place_skin_bone(const cvol_fit *fit, double depth);

static const colour_map cold = {5, {0x0d1f4d, 0x1a59a6, 0x4da6e6, 0xa6e0ff, 0xf2faff}};

/* viridis and magma: S. van der Walt and N. Smith, CC0. cool-warm: K. Moreland 2009. */
static const struct named {
    const char *name;
    colour_map map;
    profile_fn opacity, place;
    const colour_map *map_below; /* for the side below of signed data, if it has its own */
} named[] = {
    {"auto",
     {5, {0x4a2f27, 0x9c6b4a, 0xd4a878, 0xf0dcb8, 0xfffaf2}},
     opacity_balanced,
     place_by_rank,
     &cold},
    {"gray", {2, {0x202020, 0xffffff}}, opacity_balanced, place_by_value, NULL},
    {"bone", {4, {0x5a4630, 0xb8a078, 0xeeddb8, 0xffffff}}, opacity_dense, place_dense, NULL},
    {"skin-bone",
     {5, {0xd98a6a, 0xcc6650, 0xb8784f, 0xf2dcb8, 0xffffff}},
     opacity_skin_bone,
     place_skin_bone,
     NULL},
    {"mri",
     {5, {0x3f2722, 0x8e5f50, 0xcda48c, 0xecd8c6, 0xffffff}},
     opacity_firm,
     place_by_value,
     NULL},
    {"microscopy",
     {5, {0x06203a, 0x0b6e75, 0x2fbf71, 0xb8f06a, 0xfffff0}},
     opacity_balanced,
     place_by_rank,
     NULL},
    {"field",
     {6, {0x3b3f8f, 0x2f6fa8, 0x2a9d8f, 0x6cc36a, 0xd7d84f, 0xfff3b0}},
     opacity_balanced,
     place_by_value,
     NULL},
    {"hot", {4, {0x400000, 0xff2000, 0xffd000, 0xffffff}}, opacity_balanced, place_by_value, NULL},
    {"viridis",
     {9,
      {0x440154, 0x472d7b, 0x3b528b, 0x2c728e, 0x21918c, 0x28ae80, 0x5ec962, 0xaddc30, 0xfde725}},
     opacity_balanced,
     place_by_value,
     NULL},
    {"magma",
     {9,
      {0x1d1147, 0x3b0f70, 0x641a80, 0x8c2981, 0xb73779, 0xde4968, 0xf7705c, 0xfe9f6d, 0xfcfdbf}},
     opacity_balanced,
     place_by_value,
     NULL},
    {"cool-warm",
     {9,
      {0x3b4cc0, 0x688aef, 0x99baff, 0xc9d8ef, 0xdddddd, 0xeed0c0, 0xf6a789, 0xe26a53, 0xb40426}},
     opacity_balanced,
     place_by_value,
     NULL},
};

const char *cvol_transfer_names(void)
{
    return "auto gray bone skin-bone mri microscopy field dense hot viridis magma cool-warm";
}

/* ---- opacities ------------------------------------------------------------------------- */

static double smooth_step(double from, double to, double x)
{
    double t = to > from ? (x - from) / (to - from) : x >= to;
    t = fmin(fmax(t, 0), 1);
    return t * t * (3 - 2 * t);
}

/* The depth that `share` of the object's samples stay below. */
static double depth_of(const cvol_fit *fit, double share)
{
    int k = 0;
    while (k < CVOL_HISTOGRAM_BINS && 1 - fit->beyond[k + 1] < share)
        k++;
    return (k + 0.5) * fit->bin;
}

static double opacity_balanced(const cvol_fit *fit, double depth)
{
    double rare = fmax(cvol_fit_share_deeper(fit, depth), 1e-3);
    double opacity = OPACITY_BASE * pow(fmax(fit->share, 1e-3), -0.4) * pow(rare, -0.65);
    return smooth_step(0, depth_of(fit, 0.33), depth) * fmin(opacity, OPACITY_MAX);
}

/* The depth at which dense tissue becomes visible: a little below the depth that divides it from
 * soft tissue. */
static double dense_start(const cvol_fit *fit)
{
    return fit->divide - 0.3 * (fit->divide - fmin(depth_of(fit, 0.5), fit->divide));
}

static double opacity_dense(const cvol_fit *fit, double depth)
{
    double start = dense_start(fit);
    return 0.25 * smooth_step(start, start + 0.8 * (fit->top - start), depth);
}

/* Dense tissue within a faint skin. */
static double opacity_skin_bone(const cvol_fit *fit, double depth)
{
    return fmax(opacity_dense(fit, depth),
                0.012 * smooth_step(0, fmin(depth_of(fit, 0.33), 0.25 * fit->top), depth));
}

/* Twice as dense: the surface of soft tissue. */
static double opacity_firm(const cvol_fit *fit, double depth)
{
    return fmin(2.5 * opacity_balanced(fit, depth), 0.6);
}

/* ---- the places of a colour map, 0..1 --------------------------------------------------- */

static double place_between(double from, double to, double x)
{
    return to > from ? fmin(fmax((x - from) / (to - from), 0), 1) : x >= to;
}

static double place_by_value(const cvol_fit *fit, double depth)
{
    return place_between(fmin(depth_of(fit, 0.02), 0.5 * fit->top), fit->top, depth);
}

static double place_by_rank(const cvol_fit *fit, double depth)
{
    return 0.5 * depth / fit->top + 0.5 * (1 - cvol_fit_share_deeper(fit, depth));
}

static double place_dense(const cvol_fit *fit, double depth)
{
    return place_between(dense_start(fit), fit->top, depth);
}

/* The lower half for soft tissue, the upper for dense. */
static double place_skin_bone(const cvol_fit *fit, double depth)
{
    double start = dense_start(fit);
    return 0.5 * place_between(0, start, depth) + 0.5 * place_between(start, fit->top, depth);
}

/* ---- points ---------------------------------------------------------------------------- */

static void set_colour(cvol_transfer_point *point, const colour_map *map, double t)
{
    double at = fmin(fmax(t, 0), 1) * (map->count - 1);
    int i = (int)at < map->count - 1 ? (int)at : map->count - 2;
    double f = at - i, rgb[3];
    for (int c = 0; c < 3; c++) {
        int shift = 16 - 8 * c;
        double p = (map->colours[i] >> shift) & 255, q = (map->colours[i + 1] >> shift) & 255;
        rgb[c] = (p + (q - p) * f) / 255;
    }
    point->r = rgb[0];
    point->g = rgb[1];
    point->b = rgb[2];
}

/* An opacity in a volume of these rays. */
static double at_density(double opacity, double chord)
{
    return cvol_opacity_over(opacity, chord > 0 ? pow(CHORD / chord, CHORD_POWER) : 1);
}

/* The point at `depth` on the side of direction +1 or -1. */
static cvol_transfer_point point_at(const struct named *name, const cvol_fit *fit, double depth,
                                    int direction)
{
    cvol_transfer_point point = {.opacity = at_density(name->opacity(fit, depth), fit->chord)};
    point.value = direction > 0 ? fit->edge_above + depth : fit->edge_below - depth;
    double t = name->place(fit, depth);
    if (fit->above && fit->below && direction < 0 && name->map_below)
        set_colour(&point, name->map_below, t);
    else if (fit->above && fit->below && !name->map_below)
        set_colour(&point, &name->map, 0.5 + direction * (0.15 + 0.35 * t));
    else
        set_colour(&point, &name->map, t);
    return point;
}

/* An empty histogram, or one of a single value: that value is faintly visible. */
static int create_plain(cvol_context *context, cvol_transfer **out, const struct named *name,
                        const cvol_histogram *histogram)
{
    cvol_transfer_point point = {.value = histogram->min,
                                 .opacity = at_density(PLAIN_OPACITY, histogram->chord)};
    set_colour(&point, &name->map, 0.7);
    return cvol_transfer_create(context, out, &point, 1);
}

static int create_fitted(cvol_context *context, cvol_transfer **out, const struct named *name,
                         const cvol_histogram *histogram)
{
    cvol_fit fit = cvol_fit_make(histogram);
    if (!(fit.share > 0))
        return create_plain(context, out, name, histogram);
    cvol_transfer_point points[2 * (KNOTS + 1)];
    size_t count = 0;
    for (int k = KNOTS; k >= 0 && fit.below; k--)
        points[count++] = point_at(name, &fit, fit.top * k / KNOTS, -1);
    for (int k = 0; k <= KNOTS && fit.above; k++)
        points[count++] = point_at(name, &fit, fit.top * k / KNOTS, 1);
    return cvol_transfer_create(context, out, points, count);
}

/* Grey levels over all but the least and the largest values. */
static int create_dense(cvol_context *context, cvol_transfer **out, const cvol_histogram *histogram)
{
    double window[2];
    cvol_histogram_get_window(window, histogram);
    if (!(window[1] > window[0])) {
        window[0] = histogram->min;
        window[1] = histogram->max;
    }
    const double opacity = fmax(at_density(DENSE_OPACITY, histogram->chord), DENSE_OPACITY);
    const cvol_transfer_point points[2] = {
        {window[0], DENSE_BLACK, DENSE_BLACK, DENSE_BLACK, opacity},
        {window[1], DENSE_WHITE, DENSE_WHITE, DENSE_WHITE, opacity}};
    return cvol_transfer_create(context, out, points, 2);
}

int cvol_transfer_create_named(cvol_context *context, cvol_transfer **out, const char *name,
                               const cvol_histogram *histogram)
{
    *out = NULL;
    if (!strcmp(name, "dense"))
        return create_dense(context, out, histogram);
    for (size_t i = 0; i < sizeof named / sizeof *named; i++)
        if (!strcmp(name, named[i].name))
            return create_fitted(context, out, &named[i], histogram);
    return cvol_fail(context, CVOL_ERROR_ARGUMENT,
                     "no transfer function is named %s; there are: %s", name,
                     cvol_transfer_names());
}
