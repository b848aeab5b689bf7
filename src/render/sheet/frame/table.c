/* The transfer function of a frame, in two forms.
 *
 * Entries: opacity and colour at CVOL_TABLE_SIZE values. Segments: colour times opacity, and
 * opacity, as straight lines between some of these values, found from one end to the other. A
 * segment extends while some slope keeps all its entries within a tolerance (Tomek, "Two algorithms
 * for piecewise-linear continuous approximation of functions of one variable", 1974, gives the cone
 * of slopes); the next segment begins at the function itself. The tolerance is relative, so that
 * many weak samples add up correctly. It grows until there are few enough segments. */
#include "render/sheet/frame/table.h"

#include <math.h>
#include <string.h>

/* The smallest tolerance, and the largest: a share of a value, up to this part of 1. */
#define FINEST 0.002
#define COARSE 0.0046 /* for fewer segments, which are faster */
#define COARSEST 0.02
#define MAX_OFF 0.0015
/* Between two slices, a value on an image-order ray departs from a straight line. Smooth samples do
 * so by up to a quarter of the interval's rise, times the ray's movement in samples; a parabola
 * through its middle has two thirds of that on average. With translucent, smooth functions an
 * interval has a midpoint sample if its opacity could be wrong by more than half a step of 255, or
 * by more than this part of the error that the array itself makes. Thin objects depart by any
 * amount, whatever the rise: other functions show it, so that all their intervals have one, if rays
 * move at all. */
#define MIDPOINT_TOLERANCE 0.002
#define MIDPOINT_NOISE 0.125
#define MIDPOINT_SHEAR_MIN 0.02
/* In image order an interval may depart from a straight line by the error of opacity that the
 * array itself makes, within these limits. */
#define FLAT_LEAST 0.005
#define FLAT_MOST 0.02
/* A function that departs from a straight line over `flat` entries by the tolerance, since it has a
 * corner there, departs n times as much over n times as many; in n parts, one of them does. So for
 * equal errors there are 2 parts from `flat` on, 4 from 4 times that, and integrals from 16 times.
 */
#define STEEP_FLATS 4
#define INTEGRATED_FLATS 16
/* Lit intervals have up to 8 parts. */
#define LIT_INTEGRATED_FLATS 64

/* If the lit ends of an interval differ by d in colour or opacity, a straight line between them
 * departs from the light by about d / 4, and in n parts by d / 4 n. So there are 2 parts where d
 * exceeds the error of opacity that the array itself makes, within these limits, 4 from twice that
 * on, and 8 from four times. */
#define LIGHT_CHANGE_LEAST (1.0 / 255)
#define LIGHT_CHANGE_MOST (4.0 / 255)

/* For numbers, without a library call. */
static inline double less_of(double a, double b)
{
    return a < b ? a : b;
}

static inline double more_of(double a, double b)
{
    return a > b ? a : b;
}

/* An estimate of the widest interval (entries) over which classification departs from a straight
 * line by at most `tolerance` in its middle. */
static int find_flat(double (*channels)[4], double tolerance)
{
    for (int span = CVOL_TABLE_SIZE / 2; span > 1; span = 5 * span / 12 * 2) {
        double worst = 0;
        for (int t = 0; t + span < CVOL_TABLE_SIZE && worst <= tolerance; t++)
            for (int k = 0; k < 4; k++) {
                const double ends = channels[t][k] + channels[t + span][k];
                worst = more_of(worst, fabs(channels[t + span / 2][k] - 0.5 * ends));
            }
        if (worst <= tolerance)
            return span;
    }
    return 1;
}

/* The steepest rise of colour or opacity per entry, over `span` of them. */
static float find_slope(double (*channels)[4], int span)
{
    double most = 0;
    for (int t = 0; t + span < CVOL_TABLE_SIZE; t++)
        for (int k = 0; k < 4; k++)
            most = more_of(most, fabs(channels[t + span][k] - channels[t][k]));
    return (float)(most / span);
}

/* ---- integrals ------------------------------------------------------------------------------- */

/* The extinction of opacity 1, so that a small part of an interval is opaque, too. */
#define MAX_EXTINCTION 200
/* The extinction of an entry (3), or its colour times that (0 to 2). */
static double extinction_of_channel(const double channel[4], int k)
{
    const double opacity = channel[3];
    if (!(opacity > 0))
        return 0;
    const double extinction = opacity < 1 ? less_of(-log1p(-opacity), MAX_EXTINCTION)
                                          : MAX_EXTINCTION;
    return channel[k] / opacity * extinction;
}

/* Fills the integrals from colours times opacity, and opacities. */
static void fill_integrals(cvol_sheet_table *table, double (*channels)[4])
{
    double sum[CVOL_INTEGRAL_CELLS + 1][4] = {{0}};
    for (int i = 0; i < CVOL_INTEGRAL_CELLS; i++) {
        for (int k = 0; k < 4; k++)
            sum[i + 1][k] = sum[i][k];
        for (int t = 2 * i; t < 2 * i + 2; t++) {
            for (int k = 0; k < 4; k++)
                sum[i + 1][k] += extinction_of_channel(channels[t], k);
        }
    }
    /* Differences, not sums, must fit into 32 bits. */
    const double scale = 0x1p30 / more_of(sum[CVOL_INTEGRAL_CELLS][3], 1e-6);
    for (int i = 0; i <= CVOL_INTEGRAL_CELLS; i++)
        for (int k = 0; k < 4; k++)
            table->integral[i][k] = (int32_t)lround(sum[i][k] * scale);
    table->integral_unit = (float)(1 / scale);
    const double *first = channels[0], *last = channels[CVOL_TABLE_SIZE - 1];
    for (int k = 0; k < 4; k++) {
        table->extinction_before[k] = (float)extinction_of_channel(first, k);
        table->extinction_behind[k] = (float)extinction_of_channel(last, k);
    }
}

/* ---- segments -------------------------------------------------------------------------------- */

static double tolerance_of(double value, double share)
{
    return 2e-6 + less_of(share * value, MAX_OFF);
}

/* The extent of a segment from entry `from`, up to entry `most`, and its slopes. */
static int find_segment(double slope[4], double (*channels)[4], int from, int most, double share)
{
    double lo[4], hi[4];
    for (int k = 0; k < 4; k++) {
        lo[k] = -INFINITY;
        hi[k] = INFINITY;
        slope[k] = 0;
    }
    int to = from + 1;
    for (; to <= most; to++) {
        double below[4], above[4];
        int fits = 1;
        /* Colours have the tolerance of their opacity. */
        const double off = tolerance_of(channels[to][3], share), run = to - from;
        for (int k = 0; k < 4; k++) {
            const double rise = channels[to][k] - channels[from][k];
            below[k] = more_of(lo[k], (rise - off) / run);
            above[k] = less_of(hi[k], (rise + off) / run);
            fits &= below[k] <= above[k];
        }
        if (!fits)
            break;
        for (int k = 0; k < 4; k++) {
            lo[k] = below[k];
            hi[k] = above[k];
            const double chord = (channels[to][k] - channels[from][k]) / (to - from);
            slope[k] = less_of(more_of(chord, lo[k]), hi[k]);
        }
    }
    return to - 1;
}

/* The start of a line of this slope whose largest distances above and below the entries from .. to
 * are equal. */
static double middle_of(double (*channels)[4], int k, double slope, int from, int to)
{
    double least = INFINITY, most = -INFINITY;
    for (int t = from; t <= to; t++) {
        const double start = channels[t][k] - slope * (t + 0.5);
        least = less_of(least, start);
        most = more_of(most, start);
    }
    return 0.5 * (least + most);
}

/* The last entry of a run from `first`: of transparent entries, or of others. */
static int find_run(double (*channels)[4], int first)
{
    const int transparent = channels[first][3] <= 0;
    int last = first;
    while (last + 1 < CVOL_TABLE_SIZE && (channels[last + 1][3] <= 0) == transparent)
        last++;
    return last;
}

/* Ends of the first segments that lie in the bin of this one. */
static int count_segment_ends(const cvol_sheet_table *table, int count, double end)
{
    const int bin = (int)end >> CVOL_SEGMENT_BIN_LOG2;
    int ends_here = 0;
    while (ends_here < count &&
           table->segment_end[count - 1 - ends_here] > (float)(bin << CVOL_SEGMENT_BIN_LOG2))
        ends_here++;
    return ends_here;
}

/* Entry t lies at coordinate t + 1/2. Transparent entries stay exactly transparent: no segment
 * mixes them with others; it begins and ends at the midpoints between entries. Returns `most`, or 0
 * if the function does not fit into `most` segments. */
static int fit_segments(cvol_sheet_table *table, double (*channels)[4], double share, int most)
{
    const int few = most < CVOL_SEGMENTS, most_steps = few ? 1 : 2;
    int count = 0, from = 0, last = find_run(channels, 0);
    while (from < CVOL_TABLE_SIZE) {
        double slope[4];
        if (count == most)
            return 0;
        int to = find_segment(slope, channels, from, last, share);
        /* If many short segments would end near each other, one gets a larger tolerance. */
        for (double own = share; to < last && !few && own < COARSEST &&
                                 count_segment_ends(table, count, to + 0.5) >= most_steps;) {
            own *= 1.5;
            to = find_segment(slope, channels, from, last, own);
        }
        for (int k = 0; k < 4; k++) {
            table->segment_rise[k][count] = (float)slope[k];
            table->segment_start[k][count] = (float)(middle_of(channels, k, slope[k], from, to));
        }
        const int ends = to == last;
        table->segment_end[count++] = (float)(ends ? last + 1 : to + 0.5);
        from = ends ? last + 1 : to;
        if (ends && from < CVOL_TABLE_SIZE)
            last = find_run(channels, from);
    }
    for (int i = count - 1; i < CVOL_SEGMENTS; i++)
        table->segment_end[i] = INFINITY;
    for (int bin = 0, segment = 0; bin < CVOL_SEGMENT_BINS; bin++) {
        int steps = 0;
        while (table->segment_end[segment] <= (float)(bin << CVOL_SEGMENT_BIN_LOG2))
            segment++;
        table->segment_of[bin] = (int16_t)segment;
        while (table->segment_end[segment + steps] < (float)((bin + 1) << CVOL_SEGMENT_BIN_LOG2))
            steps++;
        if (steps > most_steps)
            return 0;
    }
    return most;
}

/* The difference of the values of neighbouring entries; *lo: the value of the first entry. */
static double find_unit(double *lo, const cvol_array *array, const cvol_transfer *transfer)
{
    double hi = transfer->points[transfer->count - 1].value;
    *lo = less_of(more_of(transfer->points[0].value, array->range_min), array->range_max);
    hi = less_of(more_of(hi, array->range_min), array->range_max);
    const double span = hi > *lo ? hi - *lo : array->range_max - array->range_min;
    return span > 0 ? span / (CVOL_TABLE_SIZE - 3) : 1;
}

/* Its first and last entries lie one step outside, so they are constants even if the function
 * begins or ends with a jump. */
void cvol_sheet_table_fill(cvol_sheet_table *table, const cvol_array *array,
                           const cvol_transfer *transfer, double distance, double noise)
{
    double(*channels)[4] = table->channels;
    double lo, unit = find_unit(&lo, array, transfer);
    lo -= unit;
    table->from = (float)(lo - array->offset - 0.5 * unit);
    table->scale = (float)(1 / unit);
    int first = CVOL_TABLE_SIZE, last = -1;
    double most = 0;
    for (int t = 0; t < CVOL_TABLE_SIZE; t++) {
        cvol_transfer_point p = cvol_transfer_at(transfer, lo + t * unit);
        uint32_t colour = (uint32_t)lround(p.r * 1023) | (uint32_t)lround(p.g * 1023) << 10 |
                          (uint32_t)lround(p.b * 1023) << 20;
        double opacity = cvol_opacity_over(p.opacity, distance);
        channels[t][0] = opacity * p.r;
        channels[t][1] = opacity * p.g;
        channels[t][2] = opacity * p.b;
        channels[t][3] = opacity;
        most = more_of(most, p.opacity);
        table->entries[t] = (cvol_pair){(float)opacity, colour};
        if (p.opacity > 0) {
            first = t < first ? t : first;
            last = t;
        }
    }
    /* In table coordinates, entry t is at t + 1/2. */
    table->visible_from = first == 0 ? -INFINITY : (float)(first - 0.5);
    table->visible_to = last == CVOL_TABLE_SIZE - 1 ? INFINITY : (float)(last + 1.5);
    table->flat = (float)find_flat(channels, (double)CVOL_FLAT_TOLERANCE);
    const int is_opaque = most > CVOL_TRANSLUCENT;
    table->flat_coarse = (float)find_flat(channels, (double)CVOL_FLAT_TOLERANCE_COARSE);
    table->is_translucent = !is_opaque && table->flat >= CVOL_SMOOTH * CVOL_TABLE_SIZE;
    table->flat_fine = (float)find_flat(channels, less_of(more_of(noise, FLAT_LEAST), FLAT_MOST));
    table->slope = find_slope(channels, (int)table->flat_fine);
    table->steep = STEEP_FLATS * table->flat;
    table->midpoint = INFINITY;
    table->midpoint_ramp = 1;
    table->light_change = 0; /* any change divides an interval */
    table->integrated = INTEGRATED_FLATS * table->flat;
    fill_integrals(table, channels);
    table->segments = 0;
    for (double share = FINEST; share <= COARSE && !table->segments; share *= 1.5)
        table->segments = fit_segments(table, channels, share, CVOL_SEGMENTS_FEW);
    for (double share = FINEST; share <= COARSEST && !table->segments; share *= 2)
        table->segments = fit_segments(table, channels, share, CVOL_SEGMENTS);
}

void cvol_sheet_table_image_order(cvol_sheet_table *table, double shear, double noise, int lit)
{
    const double tolerance = more_of(MIDPOINT_TOLERANCE, MIDPOINT_NOISE * noise);
    table->midpoint = table->midpoint_ramp = (float)less_of(
        6 * tolerance / more_of((double)table->slope * shear, 1e-9), 4 * CVOL_TABLE_SIZE);
    if (!table->is_translucent && shear > MIDPOINT_SHEAR_MIN)
        table->midpoint = -table->midpoint_ramp; /* the weight is 1 at any rise */
    table->flat = table->flat_fine;
    table->steep = STEEP_FLATS * table->flat;
    table->light_change = (float)less_of(more_of(noise, LIGHT_CHANGE_LEAST), LIGHT_CHANGE_MOST);
    table->integrated = (lit ? LIT_INTEGRATED_FLATS : INTEGRATED_FLATS) * table->flat;
}
