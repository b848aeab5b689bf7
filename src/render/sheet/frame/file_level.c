/* How much of a volume's file a picture by engine sheet needs. Where its pixels span so many
 * samples that blocks are evaluated on half as many points along each axis of a sheet
 * (plan.c), frequencies above half of the highest one are seen in no sheet: they only tell
 * sheets apart. What they weigh (volumes of ordinary size are read in a moment, all of them)
 * decides whether they may be left away.
 *
 * Level 2 is never enough: blocks are never evaluated on fewer points than a half, so that a
 * picture, coarse as it is, shows more (36 dB between the two, where level 1 has 52 unlit and
 * 41 lit). Nor is level 1 for surfaces, which noise makes rough (34 dB).
 */
#include <math.h>

#include "base/grid.h"
#include "cvol/render.h"
#include "render/sheet/frame/plan.h"
#include "render/view/camera.h"

/* Volumes of fewer samples are always read whole. */
#define LEAST_SAMPLES ((size_t)1 << 27)

/* World size of a pixel where the volume is nearest to the eye; 0: beside the eye, or behind it. */
static double find_pixel(const cvol_view *view)
{
    double nearest = 0;
    if (!view->perspective)
        return view->pixel;
    for (int a = 0; a < 3; a++) {
        const double low = -view->eye[a] * (0 - view->place[a]),
                     high = -view->eye[a] * (view->extent[a] - view->place[a]);
        nearest += fmin(low, high);
    }
    return nearest > 0 ? view->pixel * nearest / view->distance : 0;
}

int cvol_render_file_level(cvol_context *context, int *out, const cvol_grid *grid,
                           const cvol_render_options *options)
{
    cvol_view view;
    cvol_render_options all = *options;
    all.clip = (cvol_clip){0}; /* what is drawn of it does not matter */
    const int code = cvol_view_make(context, &view, grid, &all);
    *out = 0;
    if (code || options->mode == CVOL_MODE_ISO || cvol_grid_samples(grid) < LEAST_SAMPLES)
        return code;
    double widest = 0;
    for (int a = 0; a < 3; a++)
        if (grid->dims[a] > 1)
            widest = fmax(widest, grid->spacing[a]);
    *out = CVOL_COARSEST_PITCH * find_pixel(&view) / view.rays >= 2 * widest;
    return code;
}
