/* Classification and light: the common data of a picture, independent of its samples. */
#include <math.h>

#include "render/splat/frame.h"
#include "render/view/shading.h"

static int is_integer(cvol_type type)
{
    return type != CVOL_FLOAT32 && type != CVOL_FLOAT64;
}

void cvol_splat_table_fill(cvol_splat_table *table, const cvol_transfer *transfer,
                           const cvol_splat_source *source, cvol_type type, double distance,
                           double share)
{
    const double min = source->min, max = source->max, offset = source->offset;
    const double cells = CVOL_SPLAT_ENTRIES - 4;
    double lo = fmin(fmax(transfer->points[0].value, min), max);
    double hi = fmin(fmax(transfer->points[transfer->count - 1].value, min), max);
    double unit = hi > lo ? (hi - lo) / cells : 1;
    if (is_integer(type) && hi - lo + 2 <= cells) {
        lo = floor(lo);
        unit = 1 / floor(cells / (ceil(hi) - lo + 1));
    }
    table->from = (float)(lo - unit - offset);
    table->scale = (float)(1 / unit);
    int first = CVOL_SPLAT_ENTRIES, last = -1;
    for (int t = 0; t < CVOL_SPLAT_ENTRIES; t++) {
        cvol_transfer_point p = cvol_transfer_at(transfer, lo + (t - 1) * unit);
        double opacity = cvol_opacity_over(p.opacity, distance) / share;
        const double channels[4] = {p.r * opacity, p.g * opacity, p.b * opacity, opacity};
        for (int c = 0; c < CVOL_SPLAT_CHANNELS; c++)
            table->entries[t][c] = (float)channels[c];
        if (p.opacity > 0) {
            first = t < first ? t : first;
            last = t;
        }
    }
    table->visible_from = first == 0 ? -INFINITY : (float)(lo + (first - 2) * unit - offset);
    table->visible_to = last == CVOL_SPLAT_ENTRIES - 1 ? INFINITY
                                                       : (float)(lo + last * unit - offset);
    if (last < 0)
        table->visible_from = INFINITY;
}

void cvol_splat_light_set(cvol_light *light, const cvol_splat_plan *plan, const cvol_grid *grid,
                          const cvol_view *view, const cvol_shading *shading,
                          cvol_light_values values, int ascending)
{
    const int axes[3] = {plan->axis_lane, plan->axis_row, plan->axis_slice};
    const int turns[3] = {1, 1, ascending ? 1 : -1};
    cvol_light_set(light, view, grid, shading, 0, values, axes, turns);
}
