/* Camera and clip box of the open volume: by angles or by a named view. */
#include <math.h>

#include "render_options.h"

const cvol_grid *scene_grid(cvol_context *context, const scene *s, cvol_baked_info *info)
{
    if (s->in.array || s->in.volume)
        return input_grid(&s->in);
    cvol_renderer_get_baked_info(context, info, s->renderer);
    return &info->grid;
}

/* Refuses a given footprint that is larger than the slices across the axis along which rays cross
 * the most samples. (The default footprint works for thin volumes too.) */
static int check_footprint(const scene *s, const render_arguments *a, const cvol_grid *grid)
{
    double q[4];
    if (!a->footprint_given)
        return EXIT_DONE;
    cvol_camera_get_rotation(q, &s->options.camera);
    const double eye[3] = {2 * (q[1] * q[3] + q[0] * q[2]), 2 * (q[2] * q[3] - q[0] * q[1]),
                           1 - 2 * (q[1] * q[1] + q[2] * q[2])};
    int axis = 0;
    for (int k = 1; k < 3; k++)
        if (fabs(eye[k]) / grid->spacing[k] > fabs(eye[axis]) / grid->spacing[axis])
            axis = k;
    const size_t lanes = grid->dims[axis == 0 ? 1 : 0], rows = grid->dims[axis == 2 ? 1 : 2];
    const size_t size = (size_t)a->footprint_size;
    return size <= lanes && size <= rows
               ? EXIT_DONE
               : report_error(EXIT_MISUSED,
                              "--footprint-size %zu is larger than the "
                              "slices, %zu x %zu samples: give a smaller one",
                              size, lanes, rows);
}

int aim_camera(cvol_context *context, scene *s, const render_arguments *a, double turn_deg)
{
    cvol_baked_info info;
    for (int c = 0; c < s->other_count; c++) {
        const int status = aim_camera(context, &s->others[c], a, turn_deg);
        if (status)
            return status;
    }
    cvol_camera *camera = &s->options.camera;
    *camera = render_camera(a, turn_deg);
    set_clip(&s->options.clip, a, scene_grid(context, s, &info));
    s->mirrored = a->mirror;
    if (!a->view_name)
        return check_footprint(s, a, scene_grid(context, s, &info));
    const int code = cvol_camera_set_view(context, camera, &s->mirrored, a->view_name,
                                          scene_grid(context, s, &info), turn_deg);
    camera->roll_deg += s->mirrored ? -a->roll : a->roll;
    s->mirrored ^= a->mirror;
    return code ? report_context_error(context, code, NULL)
                : check_footprint(s, a, scene_grid(context, s, &info));
}
