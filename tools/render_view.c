/* Where the camera stands: angles, or a named view of what was opened; and what of it is drawn. */
#include "render_options.h"

const cvol_grid *scene_grid(cvol_context *context, const scene *s, cvol_baked_info *info)
{
    if (s->in.array || s->in.volume)
        return input_grid(&s->in);
    cvol_renderer_baked_info(context, s->renderer, info);
    return &info->grid;
}

int aim_camera(cvol_context *context, scene *s, const render_arguments *a, double turn_deg)
{
    cvol_baked_info info;
    cvol_camera *camera = &s->options.camera;
    *camera = render_camera(a, turn_deg);
    set_clip(&s->options.clip, a, scene_grid(context, s, &info));
    if (!a->view_name)
        return EXIT_DONE;
    const int code = cvol_camera_named(context, camera, &s->mirrored, a->view_name,
                                       scene_grid(context, s, &info), turn_deg);
    camera->roll_deg += s->mirrored ? -a->roll : a->roll;
    return code ? complain_context(context, code, NULL) : EXIT_DONE;
}
