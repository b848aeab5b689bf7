/* The segments of a table, as integers. */
#include "render/sheet/frame/int16_format.h"

#include <math.h>
#include <string.h>

#include "render/sheet/frame/frame.h"

/* Below this span in samples, a table is too fine for int16. */
#define MIN_SPAN 1024
/* The largest sum of a layer's slices, in units of 2^-15. */
#define ONE 32767
#define CLASSIFIED_ONE 16383
/* The most slices of one call for a line: a layer's, those held by the one before, and one
 * behind. */
#define MAX_SHEETS (CVOL_BLOCK_MAX + 3)

static int clamp(double value, int least, int most)
{
    return !(value > least) ? least : value > most ? most : (int)lround(value);
}

/* Table coordinates of samples: t = q rate + offset. */
typedef struct coordinates {
    double rate, offset;
} coordinates;

static double sample_at(const coordinates *c, double t)
{
    return (t - c->offset) / c->rate;
}

/* Functions of low opacity everywhere do not need the highest bits. They use them for precision:
 * `shift` of the sum over a layer's slices, and `fine` more of each slice's opacity. */
static void find_shifts(cvol_int16_table *int16, const cvol_sheet_table *table)
{
    double most = 1e-6;
    for (int t = 0; t < CVOL_TABLE_SIZE; t++) { /* not fmax, on which GCC 12 for ARM fails */
        const double opacity = (double)table->entries[t].first;
        most = opacity > most ? opacity : most;
    }
    int all = 0;
    while (all < 10 && most * (2 << all) < 1)
        all++;
    while (int16->shift < all && most * MAX_SHEETS * (2 << int16->shift) < 1)
        int16->shift++;
    int16->fine = all - int16->shift;
}

/* Ends and beginnings of segments; the start of bins, and their number of steps. */
static void find_places(cvol_int16_table *int16, const cvol_sheet_table *table,
                        const coordinates *c)
{
    int count = 0;
    while (count < CVOL_INT16_SEGMENTS - 1 && isfinite(table->segment_end[count]))
        count++;
    for (int i = 0; i < CVOL_INT16_SEGMENTS; i++) {
        int16->end[i] = i < count ? (int16_t)clamp(ceil(sample_at(c, table->segment_end[i])),
                                                   int16->from, int16->to)
                                  : CVOL_INT16_MAX;
        int16->begin[i] = i ? int16->end[i - 1] : int16->from;
    }
    int16->steps = 0;
    for (int bin = 0, segment = 0; bin < CVOL_INT16_BINS; bin++) {
        const int next = int16->from + (((bin + 1) << 16) + int16->bins - 1) / int16->bins,
                  first = int16->from + ((bin << 16) + int16->bins - 1) / int16->bins;
        while (int16->end[segment] <= first)
            segment++;
        int16->segment_of[bin] = (int16_t)segment;
        int last = segment;
        while (int16->end[last] < next && last < count)
            last++;
        int16->steps = last - segment > int16->steps ? last - segment : int16->steps;
    }
}

static void find_values(cvol_int16_table *int16, const cvol_sheet_table *table,
                        const coordinates *c)
{
    const double one = 16384.0 * (1 << (int16->shift + int16->fine));
    for (int i = 0; i < CVOL_INT16_SEGMENTS; i++) {
        const int last = int16->end[i] < int16->to ? int16->end[i] : int16->to;
        int length = last - int16->begin[i], up = 0;
        length = length < 1 ? 1 : length;
        while (length << (up + 1) <= CVOL_INT16_MAX)
            up++;
        int16->up[i] = (int16_t)up;
        /* From its start to its end, but not beyond the table's segment, so that nothing falls
         * below 0 or rises above one. */
        const double first = i ? (double)table->segment_end[i - 1] : 0.5,
                     most = fmin((double)table->segment_end[i], CVOL_TABLE_SIZE - 0.5);
        double t[2] = {int16->begin[i] * c->rate + c->offset, last * c->rate + c->offset};
        for (int side = 0; side < 2; side++)
            t[side] = fmin(fmax(t[side], first), most);
        for (int k = 0; k < 4; k++) {
            double value[2];
            for (int side = 0; side < 2; side++)
                value[side] = fmin(fmax(one * ((double)table->segment_start[k][i] +
                                               (double)table->segment_rise[k][i] * t[side]),
                                        0),
                                   CLASSIFIED_ONE);
            int16->start[k][i] = (int16_t)clamp(value[0], 0, CLASSIFIED_ONE);
            int16->rise[k][i] = (int16_t)clamp(
                32768 * (value[1] - int16->start[k][i]) / (length << up), -ONE, ONE);
        }
    }
}

static void find_midpoints(cvol_int16_table *int16)
{
    for (int i = 0; i < CVOL_INT16_SEGMENTS; i++) {
        double share[2];
        for (int k = 0; k < 2; k++)
            share[k] = 1 / (1 + sqrt(1 - (i + k) / (double)CVOL_INT16_SEGMENTS));
        int16->half_start[i] = (int16_t)clamp(32768 * share[0], 0, ONE);
        int16->half_rise[i] = (int16_t)clamp(32768 * (share[1] - share[0]), 0, ONE);
    }
}

void cvol_int16_table_fill(cvol_int16_table *int16, const cvol_sheet_table *table, float scale,
                           float offset)
{
    memset(int16, 0, sizeof *int16);
    if (!table->segments || !(scale > 0))
        return;
    const coordinates c = {.rate = (double)table->scale / (double)scale,
                           .offset = -(double)table->from * (double)table->scale -
                                     (double)offset * (double)table->scale / (double)scale};
    /* Values outside of the entries equal the end entries, even if these are narrower than a
     * sample. */
    int16->from = (int16_t)clamp(floor(sample_at(&c, 0.5)), 0, CVOL_INT16_MAX - 1);
    int16->to = (int16_t)clamp(ceil(sample_at(&c, CVOL_TABLE_SIZE - 0.5)), 0, CVOL_INT16_MAX - 1);
    const int span = int16->to - int16->from;
    if (span < MIN_SPAN)
        return;
    int16->bins = (uint16_t)((CVOL_INT16_BINS << 16) / (span + 1));
    int16->visible_from = (int16_t)clamp(floor(sample_at(&c, (double)table->visible_from)), 0,
                                         CVOL_INT16_MAX);
    int16->visible_to = (int16_t)clamp(ceil(sample_at(&c, (double)table->visible_to)), 0,
                                       CVOL_INT16_MAX);
    int16->flat = (int16_t)clamp((double)table->flat / c.rate, 1, CVOL_INT16_MAX);
    int16->steep = (int16_t)clamp((double)table->steep / c.rate, 1, CVOL_INT16_MAX);
    int16->integrated = (int16_t)clamp((double)table->integrated / c.rate, 1, CVOL_INT16_MAX);
    int16->midpoint = (int16_t)clamp((double)table->midpoint / c.rate, -ONE, CVOL_INT16_MAX);
    int16->midpoint_ramp = (int16_t)clamp((double)table->midpoint_ramp / c.rate, 1, CVOL_INT16_MAX);
    while (int16->midpoint_ramp << (int16->midpoint_up + 1) < 1 << 16)
        int16->midpoint_up++;
    int16->midpoint_rate = (uint16_t)(((int64_t)ONE << 16) /
                                      (int16->midpoint_ramp << int16->midpoint_up));
    find_shifts(int16, table);
    find_places(int16, table, &c);
    find_values(int16, table, &c);
    find_midpoints(int16);
    int16->usable = int16->steps <= CVOL_INT16_STEPS;
}
