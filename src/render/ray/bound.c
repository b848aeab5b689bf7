/* Bounds of one interval of a ray (bound.h). Let v be a drawn value, v' that of the original, and e
 * the error.
 *
 * Values. Weights of trilinear interpolation are not negative and add up to 1, so |v' - v| <= e at
 * every place. An end half way between two samples is (9 (b + c) - (a + d)) / 16, limited to values
 * between b and c. The weights have absolute values that add up to 1.25, and limiting to b and c,
 * which move by at most e, does not increase a distance: |v' - v| <= 1.25 e at ends. v' is always
 * within min .. max.
 *
 * One part or two halves. Engine ray decides this by sums over the cells of its table (table.h)
 * between the values v'. These sums only grow with the interval of values. job->table has the same
 * sums for a wider range of values: those over all cells that v' may touch decide that the interval
 * is certainly one part, and those over the cells that v' certainly covers, that it is certainly
 * divided. Otherwise both are bounded, and the result is the hull of both.
 *
 * One part. Its colour and opacity are from the table at one value: a mean of the function at two
 * values at most one cell from v'. So they are within the extremes of the function over v - e -
 * cell
 * .. v + e + cell. Colour and opacity depend on the same v'. The range of v' is therefore divided
 * into four, each with its own extremes: v' is in one of them.
 *
 * Two halves. A half is linear between its ends, so over any share of it the value is within those
 * of v there, widened by the larger error of the two ends. Engine ray divides a half into parts.
 * The sum of the parts' optical depths is the integral of -log(1 - opacity) along the half
 * (interval.c), so it is within the integrals of the lower and the upper extremes; or, with very
 * many points of the function, 64 equal parts, of which each is within the extremes over its own
 * share. The half is divided into n equal shares for these sums, and n divides 64. Each part has a
 * colour of the function at a value of the half. Parts with opacities a_k, colours c_k and light C
 * behind them give
 *
 *     sum w_k c_k + (1 - a) C,   a = 1 - product (1 - a_k),   w_k >= 0,   sum w_k = a
 *
 * which is a c + (1 - a) C with a mean c of the c_k. So one part with the half's opacity, and a
 * colour within the extremes over the whole half, has the same effect.
 *
 * Compositing. a c + (1 - a) C is linear in each of a, c and C. With independent bounds its
 * extremes are at ends: the largest at the largest c and C, and at the largest a if c > C, else the
 * least.
 *
 * Rounding. Entries of the table are floats: opacities over one step get a slack of 2^-23 of
 * themselves, but 1 stays 1. Sums of optical depths get 2^-20 of themselves; engine ray's formula
 * is off by at most 2^-24 of the depth. Everything else is far below the slack of pixels
 * (certify.c). */
#include "render/ray/bound.h"

#include <math.h>

#define ENTRY_ROUNDING 0x1p-23
#define DEPTH_ROUNDING 0x1p-20
#define END_WEIGHT 1.25
/* Of sums over the table: relative to all of the sum. */
#define SUM_ROUNDING 1e-10
#define SHARES_MAX 16

/* An interval of values. */
typedef struct extent {
    double lo, hi;
} extent;

static extent limited(const cvol_ray_known *known, double lo, double hi)
{
    return (extent){fmin(fmax(lo, known->min), known->max), fmax(fmin(hi, known->max), known->min)};
}

/* The values that the original may have where v has this one. */
static extent around(const cvol_ray_known *known, double value)
{
    return limited(known, value - known->error, value + known->error);
}

static extent joined(extent a, extent b)
{
    return (extent){fmin(a.lo, b.lo), fmax(a.hi, b.hi)};
}

/* ---- one part, two halves, or either ----------------------------------------------------- */

typedef struct shape {
    int may_be_smooth, may_be_divided;
} shape;

/* 1 if engine ray certainly takes one part for values within this extent, of which two neighbours
 * differ by at most `change`. */
static int is_smooth(const cvol_ray_doubt *doubt, extent values, double change)
{
    const cvol_ray_table *table = &doubt->job->table;
    const double cell = doubt->known.cell;
    const size_t a = cvol_ray_table_cell(table, values.lo - cell),
                 b = cvol_ray_table_cell(table, values.hi + cell);
    const cvol_ray_cell *begin = &table->cells[a], *end = &table->cells[b + 1],
                        *all = &table->cells[table->last];
    const double variation = end->variation - begin->variation + SUM_ROUNDING * all->variation,
                 bend = end->bend - begin->bend + SUM_ROUNDING * all->bend;
    return variation <= CVOL_RAY_VARIATION * (1 - 1e-9) &&
           bend * change <= CVOL_RAY_BEND * (1 - 1e-9);
}

/* 1 if it certainly divides an interval whose values cover this extent (none if lo > hi). */
static int is_divided(const cvol_ray_doubt *doubt, extent covered)
{
    const cvol_ray_table *table = &doubt->job->table;
    const double cell = doubt->known.cell;
    if (!(covered.hi - covered.lo > 2 * cell))
        return 0;
    const size_t a = cvol_ray_table_cell(table, covered.lo + cell) + 1,
                 b = cvol_ray_table_cell(table, covered.hi - cell);
    if (b <= a)
        return 0;
    const double variation = table->cells[b].variation - table->cells[a].variation -
                             SUM_ROUNDING * table->cells[table->last].variation;
    return variation > CVOL_RAY_VARIATION * (1 + 1e-9);
}

/* The largest difference of the middle from its neighbours. */
static double largest_change(const double values[3])
{
    return fmax(fabs(values[1] - values[0]), fabs(values[2] - values[1]));
}

/* The values of the original between its outer samples; and whether the interval is one part. */
static shape shape_of(const cvol_ray_doubt *doubt, extent outer, extent inner,
                      const double samples[3], const double ends[3])
{
    const double e = doubt->known.error, wide = (1 + END_WEIGHT) * e, most = END_WEIGHT * e;
    shape out = {1, 1};
    if (is_smooth(doubt, outer, largest_change(samples) + 2 * e) ||
        is_smooth(doubt, inner, 2 * (largest_change(ends) + wide)))
        out.may_be_divided = 0;
    else if (is_divided(doubt, (extent){fmin(fmin(ends[0], ends[2]) + most, ends[1] + e),
                                        fmax(fmax(ends[0], ends[2]) - most, ends[1] - e)}))
        out.may_be_smooth = 0;
    return out;
}

/* ---- parts --------------------------------------------------------------------------------- */

/* Light and shares of an interval. */
typedef struct setting {
    cvol_ray_lit_range lit;
    double share[2]; /* least, most */
} setting;

static void set_colour(cvol_ray_part *part, const cvol_ray_extremes *range, const setting *in)
{
    for (int c = 0; c < 3; c++) {
        part->colour[0][c] = range->lo[c] * in->lit.lo.factor + in->lit.lo.gloss;
        part->colour[1][c] = range->hi[c] * in->lit.hi.factor + in->lit.hi.gloss;
    }
    part->colour[0][3] = part->colour[1][3] = 1;
}

static cvol_ray_part smooth_part(const cvol_ray_doubt *doubt, extent values, const setting *in)
{
    const double cell = doubt->known.cell, step = doubt->job->table.step;
    const cvol_ray_extremes range = cvol_ray_envelope_over(&doubt->envelope, values.lo - cell,
                                                           values.hi + cell);
    double least = cvol_opacity_over(range.lo[3], step),
           most = cvol_opacity_over(range.hi[3], step);
    least = least < 1 ? least * (1 - ENTRY_ROUNDING) : 1;
    most = fmin(most * (1 + ENTRY_ROUNDING), 1);
    cvol_ray_part part;
    part.opacity[0] = in->share[0] < 1 ? cvol_opacity_over(least, in->share[0]) : least;
    part.opacity[1] = in->share[1] < 1 ? cvol_opacity_over(most, in->share[1]) : most;
    set_colour(&part, &range, in);
    return part;
}

/* The number of shares of a half: more than the error's part of the values gains nothing. */
static int share_count(double change, double error)
{
    int count = 1;
    while (count < SHARES_MAX && count * 2 * error < 3 * fabs(change))
        count *= 2;
    return count;
}

static double opacity_of(double depth, double length)
{
    return length > 0 ? -expm1(-depth * length) : 0;
}

/* A half from one value of v to the other, with this error at most. */
static cvol_ray_part half_part(const cvol_ray_doubt *doubt, double from, double to, double error,
                               const setting *in)
{
    const cvol_ray_known *known = &doubt->known;
    const int count = share_count(to - from, error);
    const double each = (to - from) / count, step = doubt->job->table.step;
    double depth[2] = {0, 0};
    cvol_ray_extremes all = {{0}, {0}};
    for (int k = 0; k < count; k++) {
        const double a = from + each * k, b = from + each * (k + 1);
        const extent values = limited(known, fmin(a, b) - error, fmax(a, b) + error);
        const cvol_ray_extremes range = cvol_ray_envelope_over(&doubt->envelope, values.lo,
                                                               values.hi);
        for (int c = 0; c < 4; c++) {
            all.lo[c] = k ? fmin(all.lo[c], range.lo[c]) : range.lo[c];
            all.hi[c] = k ? fmax(all.hi[c], range.hi[c]) : range.hi[c];
        }
        depth[0] -= log1p(-range.lo[3]) / count;
        depth[1] -= log1p(-range.hi[3]) / count;
    }
    cvol_ray_part part = {
        .opacity = {opacity_of(depth[0] * (1 - DEPTH_ROUNDING), in->share[0] / 2 * step),
                    opacity_of(depth[1] * (1 + DEPTH_ROUNDING), in->share[1] / 2 * step)}};
    set_colour(&part, &all, in);
    return part;
}

/* ---- intervals ----------------------------------------------------------------------------- */

static void set_smooth(cvol_ray_bound *out, const cvol_ray_doubt *doubt, double value,
                       const setting *in)
{
    const extent all = around(&doubt->known, value);
    const double each = (all.hi - all.lo) / CVOL_RAY_RANGES;
    out->smooth_count = CVOL_RAY_RANGES;
    for (int k = 0; k < CVOL_RAY_RANGES; k++)
        out->smooth[k] = smooth_part(doubt, (extent){all.lo + each * k, all.lo + each * (k + 1)},
                                     in);
}

/* The share of light that passes, over all possibilities. */
static void find_through(cvol_ray_bound *out)
{
    const cvol_ray_part *h = out->halves;
    double least = 1, most = 0;
    for (int k = 0; k < out->smooth_count; k++) {
        least = fmin(least, 1 - out->smooth[k].opacity[1]);
        most = fmax(most, 1 - out->smooth[k].opacity[0]);
    }
    if (out->half_count) {
        least = fmin(least, (1 - h[0].opacity[1]) * (1 - h[1].opacity[1]));
        most = fmax(most, (1 - h[0].opacity[0]) * (1 - h[1].opacity[0]));
    }
    out->through[0] = least;
    out->through[1] = most;
}

static setting find_setting(const cvol_ray_doubt *doubt, const cvol_ray_step *step)
{
    const cvol_ray_job *job = doubt->job;
    const cvol_ray_point *middle = &step->s[2];
    const double share = step->length * middle->cover;
    setting out = {{{1, 0, 1}, {1, 0, 1}}, {share, share}};
    if (!job->light)
        return out;
    const cvol_ray_reader reader = {&job->state->field, job->state->line, job->state->masked};
    double at[3];
    for (int a = 0; a < 3; a++)
        at[a] = step->path->entry[a] + (step->place + step->length / 2) * step->path->delta[a];
    out.lit = cvol_ray_light_bound(job->light, &reader, at, middle->value, doubt->known.error);
    out.share[0] *= out.lit.lo.density;
    out.share[1] *= out.lit.hi.density;
    return out;
}

/* 1 if the function is transparent for all these values. */
static int hides(const cvol_ray_doubt *doubt, extent values)
{
    const cvol_ray_table *table = &doubt->job->table;
    return cvol_ray_table_hides(table, cvol_ray_table_cell(table, values.lo - doubt->known.cell),
                                cvol_ray_table_cell(table, values.hi + doubt->known.cell));
}

int cvol_ray_bound_step(cvol_ray_bound *out, const cvol_ray_doubt *doubt, const cvol_ray_step *step)
{
    const cvol_ray_known *known = &doubt->known;
    const cvol_ray_point *s = step->s, *middle = &s[2], *before = step->front ? step->front : &s[1],
                         *after = step->back ? step->back : &s[3];
    if (!(middle->cover > 0))
        return 0;
    extent outer = around(known, middle->value);
    if (before->cover > 0)
        outer = joined(outer, around(known, before->value));
    if (after->cover > 0)
        outer = joined(outer, around(known, after->value));
    if (hides(doubt, outer))
        return 0;
    cvol_ray_point e[2];
    cvol_ray_step_ends(e, doubt->job, step);
    const double samples[3] = {before->value, middle->value, after->value},
                 ends[3] = {e[0].value, middle->value, e[1].value};
    const double error = END_WEIGHT * known->error;
    const extent inner = limited(known,
                                 fmin(fmin(ends[0], ends[2]) - error, ends[1] - known->error),
                                 fmax(fmax(ends[0], ends[2]) + error, ends[1] + known->error));
    const shape is = shape_of(doubt, outer, inner, samples, ends);
    const setting in = find_setting(doubt, step);
    out->smooth_count = out->half_count = 0;
    if (is.may_be_smooth)
        set_smooth(out, doubt, middle->value, &in);
    if (is.may_be_divided) {
        out->half_count = 2;
        out->halves[0] = half_part(doubt, ends[0], ends[1], error, &in);
        out->halves[1] = half_part(doubt, ends[1], ends[2], error, &in);
    }
    find_through(out);
    return out->through[0] < 1;
}

/* ---- compositing --------------------------------------------------------------------------- */

static double largest_over(const cvol_ray_part *part, int c, double behind)
{
    const double colour = part->colour[1][c];
    const double a = part->opacity[colour > behind];
    return a * colour + (1 - a) * behind;
}

static double least_over(const cvol_ray_part *part, int c, double behind)
{
    const double colour = part->colour[0][c];
    const double a = part->opacity[colour < behind];
    return a * colour + (1 - a) * behind;
}

void cvol_ray_bound_apply(double light[2][4], const cvol_ray_bound *bound, int count)
{
    for (int c = 0; c < count; c++) {
        double least = INFINITY, most = -INFINITY;
        for (int k = 0; k < bound->smooth_count; k++) {
            least = fmin(least, least_over(&bound->smooth[k], c, light[0][c]));
            most = fmax(most, largest_over(&bound->smooth[k], c, light[1][c]));
        }
        if (bound->half_count) {
            const cvol_ray_part *h = bound->halves;
            least = fmin(least, least_over(&h[0], c, least_over(&h[1], c, light[0][c])));
            most = fmax(most, largest_over(&h[0], c, largest_over(&h[1], c, light[1][c])));
        }
        light[0][c] = least;
        light[1][c] = most;
    }
}
