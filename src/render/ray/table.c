/* The table covers the part of the samples' range in which the transfer function changes, and two
 * cells more before and one behind, so that the constant parts outside have their own cells even if
 * the first or the last value is a jump. Between its points the function is linear except for the
 * correction of opacity, so linear interpolation in the table is wrong only within cells that
 * contain a point. Cells are small compared with the distance of points.
 *
 * Two sums over the function decide if an interval of a ray may be one part, classified in its
 * middle. They weight changes of opacity by 1 / (1 - opacity), as the logarithm of transparency
 * does.
 *
 *     variation   sum of |changes|. Along a linear piece of variation v the mean of the logarithm
 *                 is at most v^2 / 24 from its value in the middle.
 *     bend        sum of |changes of slope| at points. A change of k at the distance d from the
 *                 nearer end of an interval of h values moves the mean by k d^2 / 2 h, at most
 *                 k h / 8. */
#include "render/ray/table.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/context.h"
#include "base/memory.h"

#define CELLS_MIN 16384.0
#define CELLS_MAX 262144.0
/* Cells between two neighbouring points, unless CELLS_MAX forbids. */
#define CELLS_BETWEEN_POINTS 32
/* The entry at which the changing part begins. */
#define FIRST 2
#define LEAST_TRANSPARENCY 1e-3
/* No interval with a jump is smooth. */
#define VARIATION_OF_JUMP 1

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

/* ---- sums -------------------------------------------------------------------------------- */

static int is_jump(const cvol_transfer *transfer, size_t segment)
{
    return segment > 0 && segment < transfer->count &&
           !(transfer->points[segment].value > transfer->points[segment - 1].value);
}

/* The rise of a segment's channels per unit of value; 0 for jumps and outside of the points. */
static void find_slope(double slope[4], const cvol_transfer *transfer, size_t segment)
{
    memset(slope, 0, 4 * sizeof *slope);
    if (segment == 0 || segment == transfer->count || is_jump(transfer, segment))
        return;
    const cvol_transfer_point *q = &transfer->points[segment], *p = q - 1;
    const double gap = q->value - p->value;
    slope[0] = (q->r - p->r) / gap;
    slope[1] = (q->g - p->g) / gap;
    slope[2] = (q->b - p->b) / gap;
    slope[3] = (q->opacity - p->opacity) / gap;
}

/* The largest opacity at the ends of a segment. */
static double most_opaque(const cvol_transfer *transfer, size_t segment)
{
    const double before = segment > 0 ? transfer->points[segment - 1].opacity : 0;
    return segment < transfer->count ? fmax(before, transfer->points[segment].opacity) : before;
}

static double weighted(const double change[4], double opacity)
{
    const double colour = fmax(fmax(fabs(change[0]), fabs(change[1])), fabs(change[2]));
    return fmax(colour * opacity, fabs(change[3]) / fmax(1 - opacity, LEAST_TRANSPARENCY));
}

/* The variation per unit of value. */
static double variation_of(const cvol_transfer *transfer, size_t segment)
{
    double slope[4];
    const double opacity = most_opaque(transfer, segment);
    find_slope(slope, transfer, segment);
    return opacity > 0 ? weighted(slope, opacity) : 0;
}

/* The change of slope at the end of a segment. */
static double bend_after(const cvol_transfer *transfer, size_t segment)
{
    double before[4], after[4];
    if (!(most_opaque(transfer, segment) > 0 || most_opaque(transfer, segment + 1) > 0))
        return 0;
    find_slope(before, transfer, segment);
    find_slope(after, transfer, segment + 1);
    for (int c = 0; c < 4; c++)
        after[c] -= before[c];
    return weighted(after, transfer->points[segment].opacity);
}

/* The cell from a value, which has the sums of the cell before it, from `before` on. */
static cvol_ray_cell next_cell(const cvol_ray_table *table, cvol_ray_cell cell, double before,
                               double value)
{
    const cvol_transfer *transfer = table->transfer;
    int is_visible = 0;
    for (; cell.segment < transfer->count && transfer->points[cell.segment].value <= value;
         cell.segment++) {
        const double at = transfer->points[cell.segment].value;
        cell.variation += is_jump(transfer, cell.segment)
                              ? VARIATION_OF_JUMP
                              : variation_of(transfer, cell.segment) * (at - before);
        cell.bend += bend_after(transfer, cell.segment);
        is_visible |= transfer->points[cell.segment].opacity > 0;
        before = at;
    }
    cell.variation += variation_of(transfer, cell.segment) * (value - before);
    cell.visible += (uint32_t)is_visible;
    return cell;
}

/* ---- the table ------------------------------------------------------------------------- */

/* The value of entry i; exact at both ends of the changing part, which may be jumps. */
static double entry_value(const cvol_ray_table *table, double lo, double hi, double cell, size_t i)
{
    return i == FIRST ? lo : i + 1 == table->last ? hi : table->lo + (double)i * cell;
}

static void fill_entries(cvol_ray_table *table, double lo, double hi, double cell)
{
    for (size_t i = 0; i <= table->last; i++) {
        const cvol_transfer_point point = cvol_transfer_at(table->transfer,
                                                           entry_value(table, lo, hi, cell, i));
        table->entries[i][0] = (float)point.r;
        table->entries[i][1] = (float)point.g;
        table->entries[i][2] = (float)point.b;
        table->entries[i][3] = (float)cvol_opacity_over(point.opacity, table->step);
    }
}

/* With the scale 0 there is one cell, visible and smooth. */
static void fill_cells(cvol_ray_table *table, double lo, double hi, double cell)
{
    const cvol_transfer *transfer = table->transfer;
    cvol_ray_cell *cells = table->cells;
    for (size_t i = 0; i <= table->last; i++)
        cells[i] = (cvol_ray_cell){.visible = (uint32_t)i};
    if (!(table->scale > 0))
        return;
    double before = entry_value(table, lo, hi, cell, 0);
    cells[0] = (cvol_ray_cell){0};
    while (cells[0].segment < transfer->count && transfer->points[cells[0].segment].value <= before)
        cells[0].segment++;
    for (size_t i = 1; i <= table->last; i++) {
        const double value = entry_value(table, lo, hi, cell, i);
        cells[i] = next_cell(table, cells[i - 1], before, value);
        if (cells[i].visible == cells[i - 1].visible &&
            (table->entries[i - 1][3] > 0 || table->entries[i][3] > 0))
            cells[i].visible++;
        before = value;
    }
}

static int allocate(cvol_context *context, cvol_ray_table *table)
{
    const size_t count = table->last + 1;
    table->entries = cvol_allocate(count, sizeof *table->entries);
    table->cells = cvol_allocate(count, sizeof *table->cells);
    if (table->entries && table->cells)
        return CVOL_OK;
    return cvol_fail_memory(context, count * (sizeof *table->entries + sizeof *table->cells),
                            "the transfer function's table");
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
    const double cell = span / cells;
    *table = (cvol_ray_table){.transfer = transfer, .step = step, .lo = lo - FIRST * cell};
    table->scale = cell > 0 && isfinite(1 / cell) ? 1 / cell : 0;
    table->last = hi > lo ? (size_t)cells + FIRST + 1 : FIRST + 1;
    const int code = allocate(context, table);
    if (code)
        return code;
    fill_entries(table, lo, hi, cell);
    fill_cells(table, lo, hi, cell);
    return CVOL_OK;
}

void cvol_ray_table_free(cvol_ray_table *table)
{
    free(table->entries);
    free(table->cells);
}
