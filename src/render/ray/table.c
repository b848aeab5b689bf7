/* The table covers the part of the samples' range in which the transfer function changes, and one
 * cell more on either side, so that the constant parts outside have their own entries even if the
 * first or the last value is a jump. Between its points the function is linear except for the
 * correction of opacity, so linear interpolation in the table is wrong only within cells that
 * contain a point. Cells are small compared with the distance of points. */
#include "render/ray/table.h"

#include <math.h>

#include "base/context.h"
#include "base/memory.h"

#define CELLS_MIN 16384.0
#define CELLS_MAX 262144.0
/* Cells between two neighbouring points, unless CELLS_MAX forbids. */
#define CELLS_BETWEEN_POINTS 32

/* The smallest distance of two different points within lo..hi; hi - lo if none. */
static double smallest_gap(const cvol_transfer *transfer, double lo, double hi)
{
    double gap = hi - lo;
    for (size_t i = 1; i < transfer->count; i++) {
        double a = transfer->points[i - 1].value, b = transfer->points[i].value;
        if (b > lo && a < hi && b > a)
            gap = fmin(gap, b - a);
    }
    return gap;
}

int cvol_ray_table_make(cvol_context *context, cvol_ray_table *table, const cvol_transfer *transfer,
                        double min, double max, double step)
{
    double lo = fmax(transfer->points[0].value, min);
    double hi = fmin(transfer->points[transfer->count - 1].value, max);
    if (!(lo < hi)) {
        /* At most one jump, at lo, or no change at all. */
        lo = fmin(fmax(lo, min), max);
        hi = lo;
    }
    double span = hi > lo ? hi - lo : max - min;
    double cells = span > 0 ? CELLS_BETWEEN_POINTS * span / smallest_gap(transfer, lo, lo + span)
                            : 0;
    cells = ceil(fmin(fmax(cells, CELLS_MIN), CELLS_MAX));
    double cell = span / cells;
    table->lo = lo - cell;
    table->scale = cell > 0 && isfinite(1 / cell) ? 1 / cell : 0;
    table->last = hi > lo ? (size_t)cells + 2 : 2;
    table->entries = cvol_allocate(table->last + 1, sizeof *table->entries);
    if (!table->entries)
        return cvol_fail_memory(context, (table->last + 1) * sizeof *table->entries,
                                "the transfer function's table");
    for (size_t i = 0; i <= table->last; i++) {
        cvol_transfer_point point = cvol_transfer_at(transfer, table->lo + (double)i * cell);
        table->entries[i][0] = (float)point.r;
        table->entries[i][1] = (float)point.g;
        table->entries[i][2] = (float)point.b;
        table->entries[i][3] = (float)cvol_opacity_over(point.opacity, step);
    }
    return CVOL_OK;
}
