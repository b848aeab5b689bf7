/* Notes about options that are allowed but change nothing in the picture. */
#include <math.h>
#include <stdio.h>

#include "tools/render/render_parts.h"

/* Why no picture with these options has rays in image order; NULL: it may have them. */
static const char *without_image_order(const scene *s, const render_arguments *a)
{
    return s->options.mode != CVOL_MODE_COMPOSITE               ? "with modes other than composite"
           : a->perspective_given || a->eye_given               ? "in perspective"
           : s->options.sheet.footprint != CVOL_SHEET_LINEAR    ? "with this --footprint"
           : a->common.level > 0                                ? "with --level"
           : a->oversample_given && fabs(a->oversample - 1) > 0 ? "with --oversample"
                                                                : NULL;
}

void note_unused(const scene *s, const render_arguments *a)
{
    const cvol_illumination *light = &s->options.illumination;
    const char *reason = s->options.sheet.ray_order == CVOL_RAY_ORDER_IMAGE
                             ? without_image_order(s, a)
                             : NULL;
    if (drawing_of_parts && drawing_of_parts->rank) /* the first process prints them */
        return;
    if (a->transfer_given && s->options.mode != CVOL_MODE_COMPOSITE)
        fprintf(stderr, "cvol: --transfer has no effect: mode %s uses no transfer function\n",
                a->mode_name);
    if (reason)
        fprintf(stderr, "cvol: --ray-order image has no effect: rays are in object order %s\n",
                reason);
    if (a->samples_given && !(light->occlusion > 0) && !(light->shadows > 0))
        fprintf(stderr, "cvol: --samples has no effect without --occlusion or --shadows\n");
}

void note_unused_level(const scene *s, const render_arguments *a, const char *path)
{
    const int skips_places = s->engine == CVOL_ENGINE_SHEET ||
                             (s->engine == CVOL_ENGINE_TRANSFORM && !a->axis_name);
    if (!s->in.volume || a->common.level <= 0 || skips_places)
        return;
    clear_progress();
    fprintf(stderr, "cvol: %s: --level has no effect: the file is not compressed\n", path);
}
