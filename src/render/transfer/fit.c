/* Background and object of a histogram, by the following steps; widths and positions are in bins.
 *
 * 1. Smooth the histogram over 5 bins, since integers leave combs in it.
 * 2. Ignore padding that some scanners write around the picture: a single spike at the lowest
 * value, followed by an empty range and by a peak at the low end of the rest.
 * 3. The robust range leaves out a thousandth at either end. Where one bin holds so many samples
 *    that this were much of the others, as in a volume that is empty but for a small object, the
 *    thousandth is that of the others. The background is the lowest peak that is narrow (half its
 *    width below 15 % of the robust range), holds a tenth of the samples and lies in the lowest
 *    quarter. Otherwise it is the highest peak, if it is narrow and holds a quarter. Otherwise
 *    there is none, and the brighter half of the samples is the object.
 * 4. The object lies on both sides of a background around zero whose two tails have comparable
 *    lengths (velocities, vorticity); else on the side whose tail is much longer (above, if in
 *    doubt).
 * 5. The background's edge is the knee of the histogram's slope towards the object: the bin
 *    farthest below the straight line from the peak to the robust end (the triangle method, Zack,
 *    Rogers, Latt 1977), and at least at the distance of the noise on the peak's other side.
 *    With two edges, at least three tenths of the samples lie beyond them, or all but the fullest
 *    bin: data that oscillates around zero has no empty space.
 * 6. Count the object's samples by their depth beyond the edge, and divide them into two classes of
 *    the greatest variance between (Otsu 1979): soft and dense tissue in CT. */
#include "render/transfer/fit.h"

#include <math.h>
#include <string.h>

#define BINS CVOL_HISTOGRAM_BINS
#define SMOOTH 2          /* bins on either side */
#define TAIL 0.001        /* share beyond the robust range */
#define LEAST_SHARE 1e-15 /* of a sum of shares: less is rounding */
#define FEW_TAILS 10      /* times TAIL: fewer samples outside of the fullest bin are few */
#define NARROW 0.15       /* of the robust range: half the width of a background's peak */
#define LOW_PEAK_SHARE 0.10
#define LOW_PEAK_PLACE 0.25 /* of the robust range */
#define HIGH_PEAK_SHARE 0.25
#define PEAK_REACH 2.5       /* half widths that belong to a peak */
#define PADDING_GAP 8        /* empty bins after padding */
#define PADDING_EMPTY 0.0005 /* of all samples: a bin this low is empty */
#define BOTH_SIDES_RATIO 0.4 /* of the shorter tail to the longer */
#define BOTH_SHARE 0.3       /* least share of the samples for an object on both sides */
#define OTHER_SIDE_RATIO 2.5 /* of the tail below to the tail above */

typedef struct shape {
    double raw[BINS], smooth[BINS]; /* shares of all samples */
    double total;                   /* of raw */
    double lo, hi;                  /* robust range */
} shape;

/* ---- the histogram's shape ------------------------------------------------------------- */

/* The place (bins and a fraction) below which this share of the samples lies. */
static double quantile(const double *bins, double share)
{
    double sum = 0, total = 0;
    for (int i = 0; i < BINS; i++)
        total += bins[i];
    for (int i = 0; i < BINS; i++) {
        if (bins[i] > 0 && sum + bins[i] >= share * total)
            return i + (share * total - sum) / bins[i];
        sum += bins[i];
    }
    return BINS;
}

/* The fullest bin from `from` to `to`, as a first bin and the end. A summary of fewer bins makes
 * several equal ones of each (histogram.c). */
static void find_fullest(int out[2], const double *raw, int from, int to)
{
    int fullest = from;
    for (int i = from; i <= to; i++)
        if (raw[i] > raw[fullest])
            fullest = i;
    out[0] = fullest;
    out[1] = fullest + 1;
    while (out[0] > 0 && !(raw[out[0] - 1] < raw[fullest]) && !(raw[out[0] - 1] > raw[fullest]))
        out[0]--;
    while (out[1] < BINS && !(raw[out[1]] < raw[fullest]) && !(raw[out[1]] > raw[fullest]))
        out[1]++;
}

/* Step 3: the robust range. */
static void find_range(shape *s)
{
    int bin[2];
    find_fullest(bin, s->raw, 0, BINS - 1);
    const double others = s->total - (bin[1] - bin[0]) * s->raw[bin[0]];
    s->lo = quantile(s->raw, TAIL);
    s->hi = quantile(s->raw, 1 - TAIL);
    if (!(others > LEAST_SHARE * s->total && others < FEW_TAILS * TAIL * s->total))
        return;
    double rest[BINS];
    memcpy(rest, s->raw, sizeof rest);
    for (int i = bin[0]; i < bin[1]; i++)
        rest[i] = 0;
    s->lo = fmin(bin[0], quantile(rest, TAIL));
    s->hi = fmax(bin[1], quantile(rest, 1 - TAIL));
}

static void finish_shape(shape *s)
{
    s->total = 0;
    for (int i = 0; i < BINS; i++) {
        s->total += s->raw[i];
        s->smooth[i] = 0;
        for (int j = i - SMOOTH; j <= i + SMOOTH; j++)
            s->smooth[i] += j >= 0 && j < BINS ? s->raw[j] / (2 * SMOOTH + 1) : 0;
    }
    find_range(s);
}

static double mass(const shape *s, double from, double to)
{
    double sum = 0;
    for (int i = 0; i < BINS; i++)
        if (i + 0.5 >= from && i + 0.5 <= to)
            sum += s->raw[i];
    return s->total > 0 ? sum / s->total : 0;
}

/* The distance from the peak at which the smoothed histogram falls to half: the wider side. */
static double half_width(const shape *s, int peak)
{
    int below = peak, above = peak;
    while (below > 0 && s->smooth[below] > s->smooth[peak] / 2)
        below--;
    while (above < BINS - 1 && s->smooth[above] > s->smooth[peak] / 2)
        above++;
    return fmax(peak - below, above - peak);
}

static int is_peak(const shape *s, int i)
{
    for (int j = i - 2 * SMOOTH; j <= i + 2 * SMOOTH; j++)
        if (j >= 0 && j < BINS && s->smooth[j] > s->smooth[i])
            return 0;
    return s->smooth[i] > 0;
}

/* 1 if the peak is narrow and holds this share. */
static int stands_out(const shape *s, int peak, double share)
{
    double half = half_width(s, peak);
    return half < NARROW * fmax(s->hi - s->lo, 4 * SMOOTH) &&
           mass(s, peak - PEAK_REACH * half, peak + PEAK_REACH * half + 1) >= share;
}

/* The lowest peak that may be a background, or -1. */
static int low_peak(const shape *s)
{
    double end = s->lo + LOW_PEAK_PLACE * (s->hi - s->lo);
    for (int i = 0; i < BINS && i <= end; i++)
        if (is_peak(s, i) && stands_out(s, i, LOW_PEAK_SHARE))
            return i;
    return -1;
}

static int highest_peak(const shape *s)
{
    int highest = 0;
    for (int i = 1; i < BINS; i++)
        if (s->smooth[i] > s->smooth[highest])
            highest = i;
    return highest;
}

/* Step 2. */
static void drop_padding(shape *s)
{
    for (int i = 1; i <= PADDING_GAP; i++)
        if (s->raw[i] > PADDING_EMPTY * s->total)
            return;
    shape rest = *s;
    rest.raw[0] = 0;
    finish_shape(&rest);
    if (rest.total > LOW_PEAK_SHARE * s->total && low_peak(&rest) >= 0)
        *s = rest;
}

/* ---- background ------------------------------------------------------------------------ */

/* The triangle method from the peak towards the robust end in direction +1 or -1. */
static int knee(const shape *s, int peak, int direction)
{
    int end = direction > 0 ? (int)s->hi : (int)s->lo;
    end = end < BINS ? end : BINS - 1;
    int length = (end - peak) * direction, best = 0;
    double drop = s->smooth[peak], farthest = 0;
    for (int k = 1; k <= length; k++) {
        double distance = drop * (1 - (double)k / length) - s->smooth[peak + direction * k];
        if (distance > farthest) {
            farthest = distance;
            best = k;
        }
    }
    return peak + direction * best;
}

/* The reach of the noise on the peak's side without the object. */
static double noise_reach(const shape *s, int peak, int direction)
{
    double side[BINS] = {0}, sum = 0;
    for (int i = peak; i >= 0 && i < BINS; i -= direction) {
        side[i] = s->raw[i];
        sum += i == peak ? 0 : s->raw[i];
    }
    side[peak] = 0;
    if (sum < 0.01 * s->total)
        return 0;
    double end = quantile(side, direction > 0 ? 0.05 : 0.95);
    return fabs(peak + 0.5 - end);
}

typedef struct background {
    int above, below, is_found;
    double edge_above, edge_below; /* places in bins */
} background;

/* Moves both edges inwards, until enough samples lie beyond them, or to the fullest bin. */
static void draw_near(background *found, const shape *s, int peak)
{
    const double middle = peak + 0.5;
    int bin[2];
    find_fullest(bin, s->raw, peak > SMOOTH ? peak - SMOOTH : 0,
                 peak + SMOOTH < BINS ? peak + SMOOTH : BINS - 1);
    for (int k = 0; k < 100 && mass(s, found->edge_below, found->edge_above) > 1 - BOTH_SHARE;
         k++) {
        found->edge_above = fmax(middle + 0.95 * (found->edge_above - middle), bin[1]);
        found->edge_below = fmin(middle + 0.95 * (found->edge_below - middle), bin[0]);
    }
}

static background find_background(const shape *s, double zero)
{
    int peak = low_peak(s);
    if (peak < 0) {
        peak = highest_peak(s);
        if (!stands_out(s, peak, HIGH_PEAK_SHARE)) {
            double middle = quantile(s->raw, 0.5);
            return (background){1, 0, 0, middle, middle};
        }
    }
    double reach_below = peak - s->lo, reach_above = s->hi - peak;
    double shorter = fmin(reach_below, reach_above), longer = fmax(reach_below, reach_above);
    int around_zero = fabs(peak + 0.5 - zero) <= fmax(half_width(s, peak), 1);
    background found = {.above = 1, .is_found = 1};
    if (around_zero && shorter > BOTH_SIDES_RATIO * longer)
        found.below = 1;
    else if (reach_below > OTHER_SIDE_RATIO * reach_above)
        found = (background){.below = 1, .is_found = 1};
    found.edge_above = knee(s, peak, 1) + 1;
    found.edge_below = knee(s, peak, -1);
    if (found.above && found.below)
        draw_near(&found, s, peak);
    if (!found.below)
        found.edge_above = fmax(found.edge_above, peak + 0.5 + noise_reach(s, peak, 1));
    if (!found.above)
        found.edge_below = fmin(found.edge_below, peak + 0.5 - noise_reach(s, peak, -1));
    return found;
}

/* ---- object ---------------------------------------------------------------------------- */

/* Adds the share of a bin at places a..b beyond the edge to the depths that it covers. */
static void add_depth(double *depths, double a, double b, double share)
{
    double from = fmax(a, 0);
    if (b <= from)
        return;
    for (int k = (int)from; k < BINS && k < b; k++)
        depths[k] += share * (fmin(b, k + 1) - fmax(from, k)) / (b - a);
}

static void count_depths(double *depths, const shape *s, const background *ground)
{
    memset(depths, 0, BINS * sizeof *depths);
    for (int i = 0; i < BINS; i++) {
        if (ground->above)
            add_depth(depths, i - ground->edge_above, i + 1 - ground->edge_above, s->raw[i]);
        if (ground->below)
            add_depth(depths, ground->edge_below - i - 1, ground->edge_below - i, s->raw[i]);
    }
}

/* Otsu's threshold. */
static double divide(const double *depths)
{
    double total = 0, moment = 0;
    for (int k = 0; k < BINS; k++) {
        total += depths[k];
        moment += depths[k] * (k + 0.5);
    }
    double below = 0, moment_below = 0, most = 0, best = 0;
    for (int k = 0; k < BINS; k++) {
        below += depths[k];
        moment_below += depths[k] * (k + 0.5);
        if (!(below > 0 && below < total))
            continue;
        double difference = moment_below / below - (moment - moment_below) / (total - below);
        double between = below * (total - below) * difference * difference;
        if (between > most) {
            most = between;
            best = k + 1;
        }
    }
    return best;
}

static void count_beyond(cvol_fit *fit, const double *depths)
{
    double sum = 0;
    fit->beyond[BINS] = 0;
    for (int k = BINS - 1; k >= 0; k--)
        fit->beyond[k] = sum += depths[k];
    fit->share = sum;
    for (int k = 0; k <= BINS; k++)
        fit->beyond[k] = sum > 0 ? fit->beyond[k] / sum : 0;
}

cvol_fit cvol_fit_make(const cvol_histogram *histogram)
{
    double width = (histogram->max - histogram->min) / BINS;
    cvol_fit fit = {.above = 1, .edge_above = histogram->min, .edge_below = histogram->min};
    uint64_t count = 0;
    for (int i = 0; i < BINS; i++)
        count += histogram->bins[i];
    if (!(width > 0) || !isfinite(width) || count == 0)
        return fit;
    shape s;
    for (int i = 0; i < BINS; i++)
        s.raw[i] = (double)histogram->bins[i] / (double)count;
    finish_shape(&s);
    drop_padding(&s);
    background ground = find_background(&s, -histogram->min / width);
    double depths[BINS];
    count_depths(depths, &s, &ground);
    fit.has_background = ground.is_found;
    fit.above = ground.above;
    fit.below = ground.below;
    fit.edge_above = histogram->min + ground.edge_above * width;
    fit.edge_below = histogram->min + ground.edge_below * width;
    fit.bin = width;
    fit.chord = histogram->chord;
    count_beyond(&fit, depths);
    fit.top = fmax(quantile(depths, 1 - TAIL), 1) * width;
    fit.divide = divide(depths) * width;
    return fit;
}

double cvol_fit_share_deeper(const cvol_fit *fit, double depth)
{
    double place = fit->bin > 0 ? depth / fit->bin : 0;
    if (!(place > 0))
        return 1;
    if (place >= BINS)
        return 0;
    int k = (int)place;
    return fit->beyond[k] + (fit->beyond[k + 1] - fit->beyond[k]) * (place - k);
}
