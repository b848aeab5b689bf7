/* Camera and clip box of the open volume: by angles or by a named view. */
#include <math.h>
#include <string.h>

#include "tools/render/render_options.h"

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

/* ---- the frame --------------------------------------------------------------------------- */

/* The most pictures of a turn whose frames are compared. */
#define TURNS_MAX 24

/* 1 if the array is in DCT blocks, whose low frequencies show what is visible. */
static int has_blocks(const scene *s)
{
    cvol_array_info info = {.brick = {0}};
    if (s->in.array)
        cvol_array_get_info(&info, s->in.array);
    return info.brick[0] > 0;
}

static int fits_object(const scene *s, const render_arguments *a)
{
    const int is_chosen = a->fit_name != NULL;
    if (!has_blocks(s) && !s->in.volume)
        return 0;
    return a->fit != FIT_BOX && !a->eye_given && !a->poses && (s->in.array || s->in.volume) &&
           (is_chosen || !a->look_at_given);
}

/* The parts of an annotated picture on the right, for the bar of colours, and below, for the scale
 * bar and the axes. */
#define ROOM_RIGHT 0.18
#define ROOM_BELOW 0.12

/* The directions to the right and up in the picture. */
static void find_axes(double right[3], double up[3], const cvol_camera *camera)
{
    double q[4];
    cvol_camera_get_rotation(q, camera);
    const double w = q[0], x = q[1], y = q[2], z = q[3];
    memcpy(right, (double[]){1 - 2 * (y * y + z * z), 2 * (x * y + w * z), 2 * (x * z - w * y)},
           3 * sizeof *right);
    memcpy(up, (double[]){2 * (x * y - w * z), 1 - 2 * (x * x + z * z), 2 * (y * z + w * x)},
           3 * sizeof *up);
}

/* The height of the picture at zoom 1. */
static double diagonal_of(const cvol_grid *grid)
{
    double diagonal = 0;
    for (int a = 0; a < 3; a++)
        diagonal = hypot(diagonal, (double)(grid->dims[a] - 1) * grid->spacing[a]);
    return diagonal;
}

/* Moves the object to the upper left, out of the way of annotations, for which the frame was made
 * smaller. */
static void leave_room(cvol_camera *camera, const scene *s, const cvol_grid *grid)
{
    double right[3], up[3];
    find_axes(right, up, camera);
    camera->zoom *= 1 - ROOM_BELOW;
    const double height = diagonal_of(grid) / camera->zoom,
                 width = height * s->options.width / s->options.height;
    const double by = (s->mirrored ? -0.5 : 0.5) * ROOM_RIGHT * width,
                 down = 0.5 * ROOM_BELOW * height;
    for (int a = 0; a < 3; a++)
        camera->look_at[a] += by * right[a] - down * up[a];
}

/* 1 if one frame is for all pictures of a turn. */
static int is_turn(const render_arguments *a)
{
    return a->fit == FIT_TURN || (a->turntable_given && !a->over_time);
}

static const cvol_camera *frame_of(const scene *s, int channel)
{
    return channel ? &s->others[channel - 1].frame : &s->frame;
}

/* Widens the frame so that it has the frames of the other channels. */
static void join_frames(scene *s)
{
    double right[3], up[3], lo[2] = {0, 0}, hi[2] = {0, 0};
    const double diagonal = diagonal_of(input_grid(&s->in)),
                 aspect = (double)s->options.width / s->options.height;
    find_axes(right, up, &s->frame);
    for (int c = 0; c <= s->other_count; c++) {
        const cvol_camera *frame = frame_of(s, c);
        const double half[2] = {0.5 * aspect * diagonal / frame->zoom,
                                0.5 * diagonal / frame->zoom};
        for (int k = 0; k < 2; k++) {
            const double *axis = k ? up : right;
            double at = 0;
            for (int a = 0; a < 3; a++)
                at += axis[a] * (frame->look_at[a] - s->frame.look_at[a]);
            lo[k] = fmin(lo[k], at - half[k]);
            hi[k] = fmax(hi[k], at + half[k]);
        }
    }
    const double height = fmax(hi[1] - lo[1], (hi[0] - lo[0]) / aspect);
    if (!(height > 0))
        return;
    s->frame.zoom = diagonal / height;
    for (int a = 0; a < 3; a++)
        s->frame.look_at[a] += 0.5 * ((lo[0] + hi[0]) * right[a] + (lo[1] + hi[1]) * up[a]);
}

/* The same for a turn: from every side a middle is no further from the common middle than in
 * space. */
static void join_turns(scene *s)
{
    const double diagonal = diagonal_of(input_grid(&s->in)),
                 across = fmax(1, (double)s->options.height / s->options.width);
    double middle[3], half = 0;
    for (int a = 0; a < 3; a++) {
        double lo = INFINITY, hi = -INFINITY;
        for (int c = 0; c <= s->other_count; c++) {
            const cvol_camera *frame = frame_of(s, c);
            lo = fmin(lo, frame->look_at[a] - 0.5 * diagonal / frame->zoom);
            hi = fmax(hi, frame->look_at[a] + 0.5 * diagonal / frame->zoom);
        }
        middle[a] = 0.5 * (lo + hi);
    }
    for (int c = 0; c <= s->other_count; c++) {
        const cvol_camera *frame = frame_of(s, c);
        const double *at = frame->look_at;
        const double distance = hypot(hypot(at[0] - middle[0], at[1] - middle[1]),
                                      at[2] - middle[2]);
        half = fmax(half, 0.5 * diagonal / frame->zoom + across * distance);
    }
    if (half > 0)
        s->frame.zoom = 0.5 * diagonal / half;
    memcpy(s->frame.look_at, middle, sizeof middle);
}

/* Finds zoom and middle of the picture, so that what is visible fills it. Several times have one
 * frame, around the whole volume. Exit status. */
static int find_frame(cvol_context *context, scene *s, const render_arguments *a)
{
    const cvol_transfer_point opaque = {.opacity = 1},
                              shape[2] = {{0.5, 1, 1, 1, 0}, {1.5, 1, 1, 1, 1}};
    cvol_transfer *all = NULL;
    cvol_render_options options = s->options;
    const cvol_source source = {.size = sizeof source,
                                .array = has_blocks(s) ? s->in.array : NULL,
                                .volume = has_blocks(s) ? NULL : s->in.volume,
                                .mask = has_blocks(s) ? NULL : s->mask};
    const int turns = !is_turn(a)                                      ? 1
                      : a->turntable_given && a->turntable < TURNS_MAX ? a->turntable
                                                                       : TURNS_MAX;
    int code = CVOL_OK;
    if (a->annotate) {
        options.width = (int)fmax(1, (1 - ROOM_RIGHT) * options.width);
        options.height = (int)fmax(1, (1 - ROOM_BELOW) * options.height);
    }
    if (a->over_time) {
        options.mode = CVOL_MODE_COMPOSITE;
        code = cvol_transfer_create(context, &all, &opaque, 1);
    } else if (s->numbers) /* thin parts of the shape are a small part of a cell's mean */
        code = cvol_transfer_create(context, &all, shape, 2);
    if (!code)
        code = cvol_camera_fit(context, &options, &source, all ? all : s->transfer, turns);
    cvol_transfer_free(all);
    if (code)
        return report_context_error(context, code, NULL);
    s->frame = options.camera;
    if (a->annotate && turns == 1)
        leave_room(&s->frame, s, input_grid(&s->in));
    s->has_frame = 1;
    return EXIT_DONE;
}

/* ---- the camera -------------------------------------------------------------------------- */

/* Sets the angles by the options, by a named view, or to the default view. */
static int set_angles(cvol_context *context, scene *s, const render_arguments *a, double turn_deg,
                      const cvol_grid *grid)
{
    cvol_camera *camera = &s->options.camera;
    const int is_default = a->has_default_look && !a->view_name && !a->azimuth_given &&
                           !a->elevation_given && !a->eye_given && !a->poses &&
                           (s->in.array || s->in.volume);
    s->mirrored = 0;
    if (a->view_name) {
        const int code = cvol_camera_set_view(context, camera, &s->mirrored, a->view_name, grid,
                                              turn_deg);
        if (code)
            return report_context_error(context, code, NULL);
    } else if (is_default)
        cvol_camera_set_default(camera, &s->mirrored, grid, turn_deg);
    if (a->view_name || is_default)
        camera->roll_deg += s->mirrored ? -a->roll : a->roll;
    s->mirrored ^= a->mirror;
    return EXIT_DONE;
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
    int status = set_angles(context, s, a, turn_deg, scene_grid(context, s, &info));
    if (s->options.illumination.in_view)
        s->options.illumination.in_view = s->mirrored ? -1 : 1;
    if (!status && fits_object(s, a) && !s->has_frame)
        status = find_frame(context, s, a);
    int has_frames = s->has_frame && !s->has_joined && s->other_count;
    for (int c = 0; c < s->other_count; c++)
        has_frames = has_frames && s->others[c].has_frame;
    if (!status && has_frames) {
        if (is_turn(a))
            join_turns(s);
        else
            join_frames(s);
        s->has_joined = 1;
    }
    if (!status && s->has_frame) {
        camera->zoom = a->zoom * s->frame.zoom;
        memcpy(camera->look_at, s->frame.look_at, sizeof camera->look_at);
    }
    for (int c = 0; c < s->other_count && s->has_frame; c++)
        s->others[c].options.camera = *camera;
    return status ? status : check_footprint(s, a, scene_grid(context, s, &info));
}
