/* The parallel camera (camera.h).
 *
 * For azimuth a, elevation e and roll r, before the roll:
 *
 *     eye = (cos e sin a, -cos e cos a, sin e),  right = (cos a, sin a, 0),
 *     up  = eye x right = (-sin e sin a, sin e cos a, cos e)
 *
 * and after it right' = right cos r + up sin r, up' = up cos r - right sin r. Half the picture's
 * height is half the diagonal of the box of sample centres over the zoom.
 */
#include "render/camera.h"

#include <math.h>

#include "base/context.h"

/* A finer step shows nothing more: it only costs. */
#define STEP_MIN (1.0 / 64)

#define RADIANS_PER_DEGREE 0.017453292519943295

cvol_render_options cvol_render_options_defaults(void)
{
    cvol_render_options options = {
        .width = 512,
        .height = 512,
        .mode = CVOL_MODE_COMPOSITE,
        .camera = {.zoom = 1},
        .splat = {.footprint = CVOL_FOOTPRINT_GAUSSIAN,
                  .size = 5,
                  .plane = CVOL_FOOTPRINT_IN_VIEW,
                  .order = CVOL_ORDER_FRONT},
        .transform = {CVOL_DCT, 16, 0.1, CVOL_SCHEDULE_DEFERRED},
    };
    return options;
}

static int check_camera(cvol_context *context, const cvol_camera *camera)
{
    const struct {
        const char *name;
        double degrees;
    } angles[] = {{"azimuth", camera->azimuth_deg},
                  {"elevation", camera->elevation_deg},
                  {"roll", camera->roll_deg}};
    for (int i = 0; i < 3; i++)
        if (!isfinite(angles[i].degrees))
            return cvol_fail(context, CVOL_ERROR_ARGUMENT, "%s %g: must be a finite angle",
                             angles[i].name, angles[i].degrees);
    if (!isfinite(camera->zoom) || !(camera->zoom > 0))
        return cvol_fail(context, CVOL_ERROR_ARGUMENT, "zoom %g: must be a finite number above 0",
                         camera->zoom);
    return CVOL_OK;
}

static int check_options(cvol_context *context, const cvol_render_options *options)
{
    if (options->width < 1 || options->width > CVOL_IMAGE_SIZE_MAX)
        return cvol_fail(context, CVOL_ERROR_ARGUMENT, "width %d: must be 1 to %d", options->width,
                         CVOL_IMAGE_SIZE_MAX);
    if (options->height < 1 || options->height > CVOL_IMAGE_SIZE_MAX)
        return cvol_fail(context, CVOL_ERROR_ARGUMENT, "height %d: must be 1 to %d",
                         options->height, CVOL_IMAGE_SIZE_MAX);
    double step = options->step_voxels;
    if (step != 0 && (!isfinite(step) || !(step >= STEP_MIN)))
        return cvol_fail(context, CVOL_ERROR_ARGUMENT,
                         "step %g: must be 0 (the engine's own) or at least 1/64 voxel", step);
    for (int c = 0; c < 3; c++)
        if (!(options->background[c] >= 0 && options->background[c] <= 1))
            return cvol_fail(context, CVOL_ERROR_ARGUMENT,
                             "background: %s is %g, must be within 0 and 1",
                             (const char *[]){"red", "green", "blue"}[c], options->background[c]);
    return check_camera(context, &options->camera);
}

/* Cosine and sine; exact at multiples of 90 degrees, so that a view along an axis is one. */
static void cos_sin(double degrees, double *cosine, double *sine)
{
    double turn = fmod(degrees, 360);
    double quarters = turn / 90;
    if (quarters == floor(quarters)) {
        static const double quarter_cosines[4] = {1, 0, -1, 0};
        int quarter = ((int)quarters + 4) % 4;
        *cosine = quarter_cosines[quarter];
        *sine = quarter_cosines[(quarter + 3) % 4];
        return;
    }
    *cosine = cos(turn * RADIANS_PER_DEGREE);
    *sine = sin(turn * RADIANS_PER_DEGREE);
}

static void set_directions(cvol_view *view, const cvol_camera *camera)
{
    double ca, sa, ce, se, cr, sr;
    cos_sin(camera->azimuth_deg, &ca, &sa);
    cos_sin(camera->elevation_deg, &ce, &se);
    cos_sin(camera->roll_deg, &cr, &sr);
    const double eye[3] = {ce * sa, -ce * ca, se};
    const double right[3] = {ca, sa, 0};
    const double up[3] = {-se * sa, se * ca, ce};
    for (int a = 0; a < 3; a++) {
        view->eye[a] = eye[a];
        view->right[a] = right[a] * cr + up[a] * sr;
        view->up[a] = up[a] * cr - right[a] * sr;
    }
}

/* rotation = rotation times a turn by `degrees` about x or z. */
static void turn_about(double rotation[4], int axis, double degrees)
{
    const double c = cos(degrees / 2 * RADIANS_PER_DEGREE), s = sin(degrees / 2 * RADIANS_PER_DEGREE);
    const double w = rotation[0], x = rotation[1], y = rotation[2], z = rotation[3];
    rotation[0] = w * c - (axis ? z : x) * s;
    rotation[1] = x * c + (axis ? y : w) * s;
    rotation[2] = y * c + (axis ? -x : z) * s;
    rotation[3] = z * c + (axis ? w : -y) * s;
}

/* From straight above, looking down: about z by the azimuth, then about the new x and z. */
void cvol_camera_rotation(double rotation[4], const cvol_camera *camera)
{
    rotation[0] = 1;
    rotation[1] = rotation[2] = rotation[3] = 0;
    turn_about(rotation, 1, camera->azimuth_deg);
    turn_about(rotation, 0, 90 - camera->elevation_deg);
    turn_about(rotation, 1, camera->roll_deg);
}

int cvol_view_make(cvol_context *context, cvol_view *out, const cvol_grid *grid,
                   const cvol_render_options *options)
{
    *out = (cvol_view){.width = options->width, .height = options->height};
    int code = check_options(context, options);
    if (code)
        return code;
    set_directions(out, &options->camera);
    for (int a = 0; a < 3; a++) {
        out->extent[a] = (double)(grid->dims[a] - 1) * grid->spacing[a];
        out->centre[a] = out->extent[a] / 2;
        out->mean_spacing += grid->spacing[a] / 3;
    }
    double diagonal = hypot(hypot(out->extent[0], out->extent[1]), out->extent[2]);
    /* A single sample has no extent; it is shown as large as its spacing. */
    if (!(diagonal > 0))
        diagonal = out->mean_spacing;
    out->pixel = diagonal / options->camera.zoom / options->height;
    if (!isfinite(out->pixel) || !(out->pixel > 0))
        return cvol_fail(context, CVOL_ERROR_ARGUMENT,
                         "zoom %g: the picture's scale is beyond the range of numbers",
                         options->camera.zoom);
    return CVOL_OK;
}
