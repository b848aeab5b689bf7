/* Classification and light: what a picture shares before its samples are looked at. */
#include <math.h>

#include "render/splat.h"

static int is_integer(cvol_type type)
{
    return type != CVOL_FLOAT32 && type != CVOL_FLOAT64;
}

void cvol_splat_table_fill(cvol_splat_table *table, const cvol_transfer *transfer,
                           const cvol_splat_source *source, cvol_type type, double distance,
                           double share)
{
    const double min = source->min, max = source->max, cells = CVOL_SPLAT_ENTRIES - 4;
    double lo = fmin(fmax(transfer->points[0].value, min), max);
    double hi = fmin(fmax(transfer->points[transfer->count - 1].value, min), max);
    double unit = hi > lo ? (hi - lo) / cells : 1;
    if (is_integer(type) && hi - lo + 2 <= cells) {
        lo = floor(lo);
        unit = 1 / floor(cells / (ceil(hi) - lo + 1));
    }
    table->from = (float)(lo - unit);
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
    table->visible_from = first == 0 ? -INFINITY : (float)(lo + (first - 2) * unit);
    table->visible_to = last == CVOL_SPLAT_ENTRIES - 1 ? INFINITY : (float)(lo + last * unit);
    if (last < 0)
        table->visible_from = INFINITY;
}

void cvol_splat_light_set(cvol_splat_light *light, const cvol_splat_plan *plan,
                          const cvol_grid *grid, const cvol_view *view,
                          const cvol_splat_options *options, int ascending)
{
    const int axes[3] = {plan->axis_lane, plan->axis_row, plan->axis_slice};
    const double *given = options->light;
    const double length = hypot(hypot(given[0], given[1]), given[2]);
    double towards[3], half[3], half_length = 0;
    light->shade = options->shade;
    for (int a = 0; a < 3; a++) {
        towards[a] = length > 0 ? given[a] / length : view->eye[a];
        half[a] = towards[a] + view->eye[a];
        half_length = hypot(half_length, half[a]);
    }
    double facing_light = 0, facing_halfway = 0;
    for (int k = 0; k < 3; k++) {
        const int a = axes[k];
        const double turn = k == 2 && !ascending ? -1 : 1;
        /* light from behind has no highlight */
        const double halfway = half_length > 1e-6 ? half[a] / half_length : 0;
        light->eye[k] = (float)(turn * view->eye[a]);
        light->light[k] = (float)(turn * towards[a]);
        light->halfway[k] = (float)(turn * halfway);
        light->inverse_spacing[k] = (float)(view->mean_spacing / grid->spacing[a]);
        facing_light += view->eye[a] * towards[a];
        facing_halfway += view->eye[a] * halfway;
    }
    light->facing_light = (float)facing_light;
    light->facing_halfway = (float)facing_halfway;
}
