/* The level of a volume's file that a picture by engine sheet needs. If pixels are so large that
 * blocks are evaluated on half the points along each axis of a slice (plan.c), frequencies above
 * half of the highest one are not visible in any slice: they only make slices differ. Their number
 * of bytes decides if they may be left out; volumes of ordinary size are read in a moment,
 * completely.
 *
 * Level 2 is never enough: blocks are never evaluated on fewer points than half of the samples, so
 * even a coarse picture shows more (36 dB between the two; level 1 has 52 dB unlit and 41 dB lit).
 * Level 1 is not enough for surfaces, which noise makes rough (34 dB). */
#include <math.h>

#include "base/grid.h"
#include "cvol/render.h"
#include "render/sheet/frame/plan.h"
#include "render/view/camera.h"
#include "render/view/options.h"

/* Volumes of fewer samples are always read whole. */
#define MIN_SAMPLES ((size_t)1 << 27)

/* World size of a pixel at the volume's nearest point to the eye; 0: next to the eye, or behind
 * it. */
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

int cvol_render_choose_file_level(cvol_context *context, int *out, const cvol_grid *grid,
                                  const cvol_render_options *options)
{
    cvol_view view;
    cvol_render_options all;
    *out = 0;
    int code = cvol_render_options_complete(context, &all, options);
    all.clip = (cvol_clip){0}; /* the drawn part has no effect */
    if (!code)
        code = cvol_view_make(context, &view, grid, &all);
    if (code || all.mode == CVOL_MODE_ISO || cvol_grid_samples(grid) < MIN_SAMPLES)
        return code;
    double widest = 0;
    for (int a = 0; a < 3; a++)
        if (grid->dims[a] > 1)
            widest = fmax(widest, grid->spacing[a]);
    *out = CVOL_COARSEST_PITCH * find_pixel(&view) / view.rays >= 2 * widest;
    return code;
}
