/* Bounds of one interval of a ray (bound.h). Let v be a drawn value, v' that of the original, and e
 * the error.
 *
 * Values. Weights of trilinear interpolation are not negative and add up to 1, so |v' - v| <= e at
 * every place. An end half way between two samples is (9 (b + c) - (a + d)) / 16, limited to values
 * between b and c. The absolute values of the weights add up to 1.25, and limiting to b and c,
 * which move by at most e, does not increase a distance: |v' - v| <= 1.25 e at ends. v' is also
 * within e of the values between b and c, and always within min .. max.
 *
 * One part or two halves. Engine ray decides this by sums over the cells of its table (table.h)
 * between the values v'. These sums only grow with the interval of values. job->table has the same
 * sums for a wider range of values. The sums over all cells that v' may touch show that an interval
 * is certainly one part; those over the cells that v' certainly covers, that it is certainly
 * divided. Otherwise both are bounded, and the result is the hull of both.
 *
 * Cases. The ranges of v' in the middle and at each end are divided into equal parts. v' is in one
 * part of each, so the effect of the interval is within the bounds of one of these cases. Opacity
 * and colour thus stay connected.
 *
 * One part. Its colour and opacity are from the table at the value in the middle: a mean of the
 * function at two values at most one cell from v'. So they are within the extremes of the function
 * over the values of the case, widened by a cell.
 *
 * Two halves. A half is linear between its ends, so at each place of it v' lies between the lines
 * that join the limits of the case. The half is divided into n equal shares, each with its own
 * extremes of the function. Engine ray divides a half into parts of lengths l_k (as shares of it),
 * opacities a_k and colours c_k. With the light C behind them they give
 *
 *     sum w_k c_k + (1 - a) C,   a = 1 - product (1 - a_k),   w_k >= 0,   sum w_k = a
 *
 * which is a c + (1 - a) C with c = sum w_k c_k / a. So the half has the effect of one part.
 *
 * Its opacity: -log(1 - a) is D times the integral of t = -log(1 - opacity) along the half, of
 * length D in mean spacings (interval.c), so it lies between D times the means of the lower and the
 * upper extremes of t. (With very many points of the function it is the mean at 64 places in equal
 * steps, which holds too, because n divides 64.)
 *
 * Its colour: let m_k be the colour in the middle of part k. The function is linear along a part,
 * so sum l_k m_k is the mean colour along the half, which lies between the means of the extremes. c
 * differs from it by at most s times the range of the colour over the half, where
 *
 *     s = (r - 1) / (r + 1) + X / 12,   r^2 = exp(X) T / t_0,   X = D T,
 *
 * and T and t_0 are the largest and the least t. First, the ratio of w_k and l_k is that of t,
 * times the transmittance in front of a share of the part: within a constant and exp(X) T / t_0
 * times it. Two sets of weights with that property, which both add up to 1, differ by (r - 1) / (r
 * + 1) at most, summed over the k where the first is larger. Second, c_k is the colour at the share
 * 1 / x - 1 / (exp(x) - 1) of part k, with x = -log(1 - a_k) <= X: between 1/2 - x / 12 and 1/2. If
 * s >= 1, or t_0 = 0, the colour is only known to be within the extremes over the half.
 *
 * Compositing. a c + (1 - a) C is linear in each of a, c and C. With independent bounds its
 * extremes are at ends: the largest at the largest c and C, and at the largest a if c > C, else the
 * least.
 *
 * Rounding. Entries of the table are floats: opacities over one step get a slack of 2^-23 of
 * themselves, but 1 stays 1. Optical depths get 2^-20 of themselves; engine ray's formula is off by
 * at most 2^-24 of the depth. Everything else is far below the slack of pixels (certify.c). */
#include "render/ray/bound.h"

#include <math.h>

#define ENTRY_ROUNDING 0x1p-23
#define DEPTH_ROUNDING 0x1p-20
#define END_WEIGHT 1.25
/* The error of sums over the table, as a share of the sum over all cells. */
#define SUM_ROUNDING 1e-10
#define SHARES_MAX 16
#define COLOUR_ROUNDING 0x1p-40
/* Ranges of values over which no channel changes by more than this are not divided. */
#define FLAT 0.015
/* Nor those of intervals that change a pixel by at most this. */
#define FAINT 1e-4

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

/* 1 if the function is transparent for all these values. */
static int hides(const cvol_ray_doubt *doubt, extent values)
{
    const cvol_ray_table *table = &doubt->job->table;
    return cvol_ray_table_hides(table, cvol_ray_table_cell(table, values.lo - doubt->known.cell),
                                cvol_ray_table_cell(table, values.hi + doubt->known.cell));
}

/* The values around an interval: those of v, and what the original may have. */
typedef struct surroundings {
    double samples[3]; /* before, in the middle, after */
    double values[3];  /* at the front end, in the middle, at the back end */
    extent outer;      /* of the samples that have a value */
    extent middle, ends[2];
    int has_end[2]; /* else the end has the value of the middle */
} surroundings;

/* The original's value at an end between a sample and the middle: see above. `given`: the end is
 * not half way. */
static extent around_end(const cvol_ray_known *known, double value, double sample, double middle,
                         int given)
{
    const double e = known->error;
    if (given)
        return around(known, value);
    return limited(known, fmax(value - END_WEIGHT * e, fmin(sample, middle) - e),
                   fmin(value + END_WEIGHT * e, fmax(sample, middle) + e));
}

/* Returns 0 if the interval is certainly transparent. */
static int find_surroundings(surroundings *out, const cvol_ray_doubt *doubt,
                             const cvol_ray_step *step)
{
    const cvol_ray_known *known = &doubt->known;
    const cvol_ray_point *middle = &step->s[2], *before = step->front ? step->front : &step->s[1],
                         *after = step->back ? step->back : &step->s[3];
    if (!(middle->cover > 0))
        return 0;
    *out = (surroundings){.samples = {before->value, middle->value, after->value},
                          .middle = around(known, middle->value),
                          .has_end = {before->cover > 0, after->cover > 0}};
    out->outer = out->middle;
    if (out->has_end[0])
        out->outer = joined(out->outer, around(known, before->value));
    if (out->has_end[1])
        out->outer = joined(out->outer, around(known, after->value));
    if (hides(doubt, out->outer))
        return 0;
    cvol_ray_point ends[2];
    cvol_ray_step_ends(ends, doubt->job, step);
    for (int k = 0; k < 2; k++) {
        out->values[2 * k] = ends[k].value;
        out->ends[k] = out->has_end[k] ? around_end(known, ends[k].value, out->samples[2 * k],
                                                    middle->value, k ? !!step->back : !!step->front)
                                       : out->middle;
    }
    out->values[1] = middle->value;
    return 1;
}

/* ---- one part, two halves, or either ----------------------------------------------------- */

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

/* Decides which of the two are possible. */
static void find_shape(cvol_ray_bound *out, const cvol_ray_doubt *doubt, const surroundings *at)
{
    const double e = doubt->known.error;
    const extent *front = &at->ends[0], *back = &at->ends[1], *middle = &at->middle;
    const extent inner = joined(joined(*front, *back), *middle);
    const extent covered = {fmin(fmin(front->hi, back->hi), middle->hi),
                            fmax(fmax(front->lo, back->lo), middle->lo)};
    out->may_be_smooth = out->may_be_divided = 1;
    if (is_smooth(doubt, at->outer, largest_change(at->samples) + 2 * e) ||
        is_smooth(doubt, inner, 2 * (largest_change(at->values) + (1 + END_WEIGHT) * e)))
        out->may_be_divided = 0;
    else if (is_divided(doubt, covered))
        out->may_be_smooth = 0;
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

static double opacity_of(double depth, double length)
{
    return length > 0 ? -expm1(-depth * length) : 0;
}

static cvol_ray_part smooth_part(const cvol_ray_doubt *doubt, extent values, const setting *in)
{
    const double cell = doubt->known.cell, step = doubt->job->table.step;
    cvol_ray_extremes range;
    cvol_ray_envelope_over(&range, &doubt->envelope, values.lo - cell, values.hi + cell);
    double least = opacity_of(range.lo[3], step), most = opacity_of(range.hi[3], step);
    least = least < 1 ? least * (1 - ENTRY_ROUNDING) : 1;
    most = fmin(most * (1 + ENTRY_ROUNDING), 1);
    cvol_ray_part part;
    part.opacity[0] = in->share[0] < 1 ? cvol_opacity_over(least, in->share[0]) : least;
    part.opacity[1] = in->share[1] < 1 ? cvol_opacity_over(most, in->share[1]) : most;
    set_colour(&part, &range, in);
    return part;
}

/* Part `k` of `count` equal parts. */
static extent part_of(extent all, int k, int count)
{
    const double each = (all.hi - all.lo) / count;
    return (extent){all.lo + each * k, k + 1 < count ? all.lo + each * (k + 1) : all.hi};
}

/* The number of shares of a half: values that change by less than their extent need no more. */
static int share_count(extent from, extent to)
{
    const double change = fmax(fabs(to.lo - from.lo), fabs(to.hi - from.hi));
    const double wide = fmax(to.hi - to.lo, from.hi - from.lo);
    int count = 1;
    while (count < SHARES_MAX && count * wide < change)
        count *= 2;
    return count;
}

/* Sums over the shares of a half: extremes over all of it, and means of the extremes. */
typedef struct half_sums {
    cvol_ray_extremes all, mean;
} half_sums;

/* Adds up a half whose value goes from one extent to the other. */
static void sum_half(half_sums *out, const cvol_ray_doubt *doubt, extent from, extent to)
{
    const int count = share_count(from, to);
    const double below = (to.lo - from.lo) / count, above = (to.hi - from.hi) / count;
    *out = (half_sums){.mean = {{0}, {0}}};
    for (int k = 0; k < count; k++) {
        cvol_ray_extremes range;
        cvol_ray_envelope_over(&range, &doubt->envelope,
                               from.lo + fmin(below * k, below * (k + 1)) - doubt->known.rounding,
                               from.hi + fmax(above * k, above * (k + 1)) + doubt->known.rounding);
        for (int c = 0; c < 4; c++) {
            out->all.lo[c] = k ? fmin(out->all.lo[c], range.lo[c]) : range.lo[c];
            out->all.hi[c] = k ? fmax(out->all.hi[c], range.hi[c]) : range.hi[c];
            out->mean.lo[c] += range.lo[c] / count;
            out->mean.hi[c] += range.hi[c] / count;
        }
    }
}

/* How far the mean colour of a half's light may be from the mean over its length, as a share of the
 * colours' range. */
static double colour_shift(const half_sums *sums, double length)
{
    const double least = sums->all.lo[3], most = sums->all.hi[3];
    const double ratio = sqrt(most / least * exp(most * length) * (1 + DEPTH_ROUNDING));
    const double shift = (1 - 2 / (ratio + 1)) + most * length / 12;
    return least > 0 && shift < 1 ? shift : 1; /* infinities and NaN: 1 */
}

static cvol_ray_part half_part(const cvol_ray_doubt *doubt, extent from, extent to,
                               const setting *in)
{
    half_sums sums;
    sum_half(&sums, doubt, from, to);
    const double half = doubt->job->table.step / 2, least = in->share[0] * half,
                 most = in->share[1] * half;
    cvol_ray_part part = {.opacity = {opacity_of(sums.mean.lo[3] * (1 - DEPTH_ROUNDING), least),
                                      opacity_of(sums.mean.hi[3] * (1 + DEPTH_ROUNDING), most)}};
    const double shift = colour_shift(&sums, most);
    cvol_ray_extremes colours;
    for (int c = 0; c < 3; c++) {
        const double reach = (sums.all.hi[c] - sums.all.lo[c]) * shift + COLOUR_ROUNDING;
        colours.lo[c] = fmax(sums.all.lo[c], sums.mean.lo[c] - reach);
        colours.hi[c] = fmin(sums.all.hi[c], sums.mean.hi[c] + reach);
    }
    set_colour(&part, &colours, in);
    return part;
}

/* ---- intervals ----------------------------------------------------------------------------- */

/* The numbers of parts of ranges: one, if more would hardly change a pixel. `through`: the most
 * light that passes what lies in front. */
static void choose_counts(cvol_ray_bound *out, const cvol_ray_doubt *doubt, const surroundings *at,
                          double through)
{
    const extent all = joined(joined(at->ends[0], at->ends[1]), at->middle);
    cvol_ray_extremes range;
    cvol_ray_envelope_over(&range, &doubt->envelope, all.lo, all.hi);
    double change = exp(-range.lo[3]) - exp(-range.hi[3]);
    for (int c = 0; c < 3; c++)
        change = fmax(change, range.hi[c] - range.lo[c]);
    const double effect = change * through * opacity_of(range.hi[3], doubt->job->table.step);
    const int is_worth = change > FLAT && effect > FAINT;
    out->middle_count = is_worth ? CVOL_RAY_MIDDLES : 1;
    out->end_count = is_worth ? CVOL_RAY_ENDS : 1;
}

static void set_middle(cvol_ray_bound *out, const cvol_ray_doubt *doubt, const surroundings *at,
                       int m, const setting *in)
{
    cvol_ray_middle *to = &out->middles[m];
    const extent middle = part_of(at->middle, m, out->middle_count);
    if (out->may_be_smooth)
        to->smooth = smooth_part(doubt, middle, in);
    for (int k = 0; k < out->end_count && out->may_be_divided; k++) {
        const extent front = at->has_end[0] ? part_of(at->ends[0], k, out->end_count) : middle,
                     back = at->has_end[1] ? part_of(at->ends[1], k, out->end_count) : middle;
        to->halves[0][k] = half_part(doubt, front, middle, in);
        to->halves[1][k] = half_part(doubt, middle, back, in);
    }
}

/* Adds the share of light that passes parts of which one applies. */
static void add_through(double through[2], const cvol_ray_part *parts, int count)
{
    for (int k = 0; k < count; k++) {
        through[0] = fmin(through[0], 1 - parts[k].opacity[1]);
        through[1] = fmax(through[1], 1 - parts[k].opacity[0]);
    }
}

/* The share of light that passes, over all possibilities. */
static void find_through(cvol_ray_bound *out)
{
    out->through[0] = 1;
    out->through[1] = 0;
    for (int m = 0; m < out->middle_count; m++) {
        const cvol_ray_middle *middle = &out->middles[m];
        double halves[2][2] = {{1, 0}, {1, 0}};
        if (out->may_be_smooth)
            add_through(out->through, &middle->smooth, 1);
        if (!out->may_be_divided)
            continue;
        for (int k = 0; k < 2; k++)
            add_through(halves[k], middle->halves[k], out->end_count);
        out->through[0] = fmin(out->through[0], halves[0][0] * halves[1][0]);
        out->through[1] = fmax(out->through[1], halves[0][1] * halves[1][1]);
    }
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

int cvol_ray_bound_step(cvol_ray_bound *out, const cvol_ray_doubt *doubt, const cvol_ray_step *step,
                        double through)
{
    surroundings at;
    if (!find_surroundings(&at, doubt, step))
        return 0;
    find_shape(out, doubt, &at);
    choose_counts(out, doubt, &at, through);
    const setting in = find_setting(doubt, step);
    for (int m = 0; m < out->middle_count; m++)
        set_middle(out, doubt, &at, m, &in);
    find_through(out);
    return 1;
}

/* ---- compositing --------------------------------------------------------------------------- */

/* The least light in front of parts of which one applies. */
static double least_over(const cvol_ray_part *parts, int count, int c, double behind)
{
    double least = INFINITY;
    for (int k = 0; k < count; k++) {
        const double colour = parts[k].colour[0][c], a = parts[k].opacity[colour < behind];
        least = fmin(least, a * colour + (1 - a) * behind);
    }
    return least;
}

static double most_over(const cvol_ray_part *parts, int count, int c, double behind)
{
    double most = -INFINITY;
    for (int k = 0; k < count; k++) {
        const double colour = parts[k].colour[1][c], a = parts[k].opacity[colour > behind];
        most = fmax(most, a * colour + (1 - a) * behind);
    }
    return most;
}

void cvol_ray_bound_apply(double light[2][4], const cvol_ray_bound *bound, int count)
{
    const int ends = bound->end_count;
    for (int c = 0; c < count; c++) {
        const double behind[2] = {light[0][c], light[1][c]};
        double least = INFINITY, most = -INFINITY;
        for (int m = 0; m < bound->middle_count; m++) {
            const cvol_ray_middle *at = &bound->middles[m];
            if (bound->may_be_smooth) {
                least = fmin(least, least_over(&at->smooth, 1, c, behind[0]));
                most = fmax(most, most_over(&at->smooth, 1, c, behind[1]));
            }
            if (!bound->may_be_divided)
                continue;
            const double least_back = least_over(at->halves[1], ends, c, behind[0]),
                         most_back = most_over(at->halves[1], ends, c, behind[1]);
            least = fmin(least, least_over(at->halves[0], ends, c, least_back));
            most = fmax(most, most_over(at->halves[0], ends, c, most_back));
        }
        light[0][c] = least;
        light[1][c] = most;
    }
}
