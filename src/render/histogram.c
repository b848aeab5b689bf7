/* Counting samples.
 *
 * A value that lies a thousand times as far from all others as these are apart, 1e35, say, where
 * others are between -1 and 1, is a mark that stands for no value. It is noticed by a histogram
 * that has nothing but its two ends; then the range is that of the others, and they are counted
 * again.
 *
 * Mean length of chords of a convex body: 4 V / S (Cauchy).
 */
#include "render/histogram.h"

#include <math.h>
#include <string.h>

#define MARK_FAR 1000

double cvol_histogram_chord(const cvol_grid *grid)
{
    double inverse = 0, mean = 0;
    for (int a = 0; a < 3; a++) {
        inverse += 1 / ((double)grid->dims[a] * grid->spacing[a]);
        mean += grid->spacing[a] / 3;
    }
    return 2 / inverse / mean;
}

static void count(void *user, double value)
{
    cvol_histogram *histogram = user;
    if (!(value >= histogram->min && value <= histogram->max) && histogram->mark_count)
        return;
    /* Halves, since max - min may overflow. */
    double span = histogram->max / 2 - histogram->min / 2;
    double place = span > 0 ? (value / 2 - histogram->min / 2) / span * CVOL_HISTOGRAM_BINS : 0;
    size_t bin = place > 0 ? (size_t)place : 0;
    histogram->bins[bin < CVOL_HISTOGRAM_BINS ? bin : CVOL_HISTOGRAM_BINS - 1]++;
}

/* The two ends of a range, each with the samples that are nearer to it. */
typedef struct ends {
    double middle, min[2], max[2];
} ends;

static void widen(void *user, double value)
{
    ends *e = user;
    const int k = value > e->middle;
    e->min[k] = fmin(e->min[k], value);
    e->max[k] = fmax(e->max[k], value);
}

/* Whether one end is a mark; sets the range of the others. */
static int find_mark(cvol_histogram *out, const ends *e)
{
    const double gap = e->min[1] / 2 - e->max[0] / 2;
    for (int k = 0; k < 2; k++) {
        const double spread = e->max[1 - k] - e->min[1 - k];
        if (e->max[k] > e->min[k] || !(spread > 0) || !(gap > MARK_FAR * (spread / 2)))
            continue;
        out->mark = e->min[k];
        out->mark_count = out->bins[k ? CVOL_HISTOGRAM_BINS - 1 : 0];
        out->min = e->min[1 - k];
        out->max = e->max[1 - k];
        return 1;
    }
    return 0;
}

void cvol_histogram_count(cvol_histogram *out, const cvol_sample_source *source)
{
    source->each(source, count, out);
    if (!out->bins[0] || !out->bins[CVOL_HISTOGRAM_BINS - 1])
        return;
    for (int i = 1; i < CVOL_HISTOGRAM_BINS - 1; i++)
        if (out->bins[i])
            return;
    ends e = {out->min / 2 + out->max / 2, {INFINITY, INFINITY}, {-INFINITY, -INFINITY}};
    source->each(source, widen, &e);
    if (!find_mark(out, &e))
        return;
    memset(out->bins, 0, sizeof out->bins);
    source->each(source, count, out);
}
