/* The camera (camera.h).
 *
 * For azimuth a, elevation e and roll r, before the roll:
 *
 *     eye = (cos e sin a, -cos e cos a, sin e),  right = (cos a, sin a, 0),
 *     up  = eye x right = (-sin e sin a, sin e cos a, cos e)
 *
 * and after it right' = right cos r + up sin r, up' = up cos r - right sin r. Half the picture's
 * height is half the diagonal of the box of sample centres over the zoom. In perspective this holds
 * at the centre, and the eye is at the distance where this spans the field of view. The centre is
 * the box's centre, plus the offset that the camera looks at. */
#include "render/view/camera.h"

#include <math.h>

#include "base/context.h"
#include "render/view/shading.h"

/* A finer step is not visible; it only costs time. */
#define STEP_MIN (1.0 / 64)
/* More than any machine has, so it is a mistake; its bytes are still a number. */
#define KEEP_MB_MAX 1e6

#define RADIANS_PER_DEGREE 0.017453292519943295

/* Beyond these, places of samples in the picture leave the range of numbers. */
#define ZOOM_MIN 1e-9
#define ZOOM_MAX 1e9
#define FOV_MIN 1.0
#define FOV_MAX 150.0
/* The limit for the point that a camera without a place looks at, from the box's centre, in
 * diagonals of the box: nothing is visible further away, and engines count pixels in integers. */
#define LOOK_MAX 1000.0
/* Parts nearer to the eye are not drawn: in mean spacings. */
#define NEAREST 2.0

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
    if (!(camera->zoom >= ZOOM_MIN && camera->zoom <= ZOOM_MAX))
        return cvol_fail(context, CVOL_ERROR_ARGUMENT, "zoom %g: must be %g to %g", camera->zoom,
                         ZOOM_MIN, ZOOM_MAX);
    const double fov = camera->fov_deg;
    if (fov != 0 && !(fov >= FOV_MIN && fov <= FOV_MAX))
        return cvol_fail(context, CVOL_ERROR_ARGUMENT,
                         "field of view %g: must be %g to %g degrees, or 0 for parallel projection",
                         fov, FOV_MIN, FOV_MAX);
    if (camera->placed && fov == 0)
        return cvol_fail(context, CVOL_ERROR_ARGUMENT,
                         "an eye at a place has a field of view above 0");
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
    const cvol_rows *rows = &options->rows;
    if (rows->of && (rows->of < 0 || rows->of > CVOL_IMAGE_SIZE_MAX || rows->first < 0 ||
                     rows->first > rows->of - options->height))
        return cvol_fail(context, CVOL_ERROR_ARGUMENT,
                         "%d rows from row %d: a picture of %d rows does not have them",
                         options->height, rows->first, rows->of);
    double step = options->step_voxels;
    if (step != 0 && (!isfinite(step) || !(step >= STEP_MIN)))
        return cvol_fail(context, CVOL_ERROR_ARGUMENT,
                         "step %g: must be 0 (the engine's own) or at least 1/64 voxel", step);
    const double rays = options->oversample;
    if (rays != 0 && !(rays >= 0.25 && rays <= 4))
        return cvol_fail(context, CVOL_ERROR_ARGUMENT, "oversample %g: must be 0.25 to 4", rays);
    if (!(options->keep_mb >= 0 && options->keep_mb <= KEEP_MB_MAX))
        return cvol_fail(context, CVOL_ERROR_ARGUMENT, "keep_mb %g: must be 0 to %g",
                         options->keep_mb, KEEP_MB_MAX);
    for (int c = 0; c < 3; c++)
        if (!(options->background[c] >= 0 && options->background[c] <= 1))
            return cvol_fail(context, CVOL_ERROR_ARGUMENT,
                             "background: %s is %g, must be within 0 and 1",
                             (const char *[]){"red", "green", "blue"}[c], options->background[c]);
    const int code = cvol_shading_check(context, options);
    return code ? code : check_camera(context, &options->camera);
}

/* Cosine and sine; exact at multiples of 90 degrees, so that a view along an axis is exact. */
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

/* ---- an eye at a place ----------------------------------------------------------------------- */

static double dot(const double a[3], const double b[3])
{
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

static void cross(double out[3], const double a[3], const double b[3])
{
    for (int i = 0; i < 3; i++)
        out[i] = a[(i + 1) % 3] * b[(i + 2) % 3] - a[(i + 2) % 3] * b[(i + 1) % 3];
}

/* Normalises a vector; returns its length, 0 if that is not a number above 0. */
static double normalise(double v[3])
{
    const double length = hypot(hypot(v[0], v[1]), v[2]);
    if (!(length > 0) || !isfinite(length))
        return 0;
    for (int a = 0; a < 3; a++)
        v[a] /= length;
    return length;
}

/* up minus its component along the eye; 0 if nothing is left. */
static int set_up(cvol_view *view, const double up[3])
{
    double v[3] = {up[0], up[1], up[2]};
    if (!(normalise(v) > 0))
        return 0;
    const double along = dot(v, view->eye);
    for (int a = 0; a < 3; a++)
        v[a] -= along * view->eye[a];
    if (!(normalise(v) > 1e-6))
        return 0;
    for (int a = 0; a < 3; a++)
        view->up[a] = v[a];
    cross(view->right, view->up, view->eye);
    return 1;
}

/* Sets the view's middle, the eye's place, and directions, from places relative to the box's
 * centre. */
static int place_eye(cvol_context *context, cvol_view *view, const cvol_camera *camera)
{
    for (int a = 0; a < 3; a++) {
        view->eye[a] = camera->eye[a] - camera->look_at[a];
        view->place[a] = view->centre[a] + camera->eye[a];
        view->centre[a] += camera->look_at[a];
    }
    view->distance = normalise(view->eye);
    if (!(view->distance > 0))
        return cvol_fail(context, CVOL_ERROR_ARGUMENT,
                         "an eye at %g,%g,%g that looks at %g,%g,%g: must be finite and two places",
                         camera->eye[0], camera->eye[1], camera->eye[2], camera->look_at[0],
                         camera->look_at[1], camera->look_at[2]);
    const double *up = camera->up;
    const int given = up[0] < 0 || up[0] > 0 || up[1] < 0 || up[1] > 0 || up[2] < 0 || up[2] > 0;
    if (given ? !set_up(view, up)
              : !set_up(view, (double[3]){0, 0, 1}) && !set_up(view, (double[3]){0, 1, 0}))
        return cvol_fail(context, CVOL_ERROR_ARGUMENT,
                         "up is %g,%g,%g: must be finite, and another direction than that in which "
                         "the eye looks",
                         up[0], up[1], up[2]);
    double c, s;
    cos_sin(camera->roll_deg, &c, &s);
    for (int a = 0; a < 3; a++) {
        const double right = view->right[a];
        view->right[a] = right * c + view->up[a] * s;
        view->up[a] = view->up[a] * c - right * s;
    }
    return CVOL_OK;
}

/* ---- an eye without a place ------------------------------------------------------------------ */

/* Moves the view's middle to the point that the camera looks at. */
static int look_at(cvol_context *context, cvol_view *view, const double at[3], double diagonal)
{
    for (int a = 0; a < 3; a++) {
        if (!(fabs(at[a]) <= LOOK_MAX * diagonal))
            return cvol_fail(context, CVOL_ERROR_ARGUMENT,
                             "look_at %g,%g,%g: must be finite, and within %g diagonals of the "
                             "volume, which is %g long",
                             at[0], at[1], at[2], LOOK_MAX, diagonal);
        view->centre[a] += at[a];
    }
    view->ahead -= dot(view->eye, at);
    return CVOL_OK;
}

/* ---- cuts ---------------------------------------------------------------------------------- */

/* The light of a cut ends at this depth, in mean spacings. */
#define CUT_DEPTH 16

/* A face with the depth n . (p - at) behind it, for places p in the world and a unit vector n. */
static void add_cut(cvol_view *view, const cvol_grid *grid, const double n[3], double d)
{
    double *cut = view->cut[view->cuts++];
    const double scale = 1 / (CUT_DEPTH * view->mean_spacing);
    for (int a = 0; a < 3; a++)
        cut[a] = scale * n[a] * grid->spacing[a];
    cut[3] = scale * d;
}

/* A face of the box at sample `at` of an axis. */
static void add_box_cut(cvol_view *view, const cvol_grid *grid, int axis, double at, double sign)
{
    double n[3] = {0, 0, 0};
    n[axis] = sign;
    add_cut(view, grid, n, -sign * at * grid->spacing[axis]);
}

void cvol_view_add_face(cvol_view *view, const cvol_grid *grid, int axis, int is_upper,
                        double strength)
{
    add_box_cut(view, grid, axis, is_upper ? (double)(grid->dims[axis] - 1) : 0, is_upper ? -1 : 1);
    view->cut[view->cuts - 1][3] += 1 - strength;
}

/* Thinner than this, compared with its second side: a slab. */
#define SLAB 0.4

int cvol_view_thin_axis(const cvol_grid *grid)
{
    double sides[3];
    int thin = 0;
    for (int a = 0; a < 3; a++) {
        sides[a] = (double)grid->dims[a] * grid->spacing[a];
        thin = sides[a] < sides[thin] ? a : thin;
    }
    const double next = fmin(sides[(thin + 1) % 3], sides[(thin + 2) % 3]);
    return sides[thin] < SLAB * next ? thin : -1;
}

/* ---- the drawn part -------------------------------------------------------------------------- */

static int set_box(cvol_context *context, cvol_view *view, const cvol_grid *grid,
                   const cvol_clip *clip)
{
    const int thin = cvol_view_thin_axis(grid);
    for (int a = 0; a < 3; a++) {
        const double last = (double)(grid->dims[a] - 1), margin = grid->dims[a] > 1 ? 0 : 0.5;
        view->lo[a] = -margin;
        view->hi[a] = last + margin;
        if (a == thin) { /* mostly a part of what was scanned: its large faces are cuts */
            add_box_cut(view, grid, a, view->lo[a], 1);
            add_box_cut(view, grid, a, view->hi[a], -1);
        }
        if (!(clip->axes >> a & 1))
            continue;
        const double from = clip->from[a], to = clip->to[a];
        if (!(from < to))
            return cvol_fail(context, CVOL_ERROR_ARGUMENT,
                             "clip of %c from %g to %g: the second must be larger", "xyz"[a], from,
                             to);
        if (!(from < view->hi[a]) || !(to > view->lo[a]))
            return cvol_fail(
                context, CVOL_ERROR_ARGUMENT,
                "clip of %c from %g to %g leaves no part of the volume, which reaches from 0 to %g",
                "xyz"[a], from, to, last);
        view->clipped |= from > view->lo[a] || to < view->hi[a];
        if (from > view->lo[a])
            add_box_cut(view, grid, a, from, 1);
        if (to < view->hi[a])
            add_box_cut(view, grid, a, to, -1);
        view->lo[a] = fmax(view->lo[a], from);
        view->hi[a] = fmin(view->hi[a], to);
    }
    return CVOL_OK;
}

/* Finds the part's box within the drawn one. */
static int set_part(cvol_context *context, cvol_view *view, const cvol_part *part)
{
    for (int a = 0; a < 3; a++) {
        view->own_lo[a] = view->lo[a];
        view->own_hi[a] = view->hi[a];
        if (!(part->axes >> a & 1))
            continue;
        const double from = part->from[a], to = part->to[a];
        if (!(from < to) || !(from < view->hi[a]) || !(to > view->lo[a]))
            return cvol_fail(context, CVOL_ERROR_ARGUMENT,
                             "part of %c from %g to %g: the second must be larger, and some of the "
                             "drawn samples, %g to %g, between them",
                             "xyz"[a], from, to, view -> lo[a] + 0, view -> hi[a]);
        view->clipped |= from > view->lo[a] || to < view->hi[a];
        view->own_lo[a] = fmax(view->lo[a], from);
        view->own_hi[a] = fmin(view->hi[a], to);
    }
    return CVOL_OK;
}

/* Adds n . (p - at) >= d, for places p in the world. */
static void add_plane(cvol_view *view, const cvol_grid *grid, const double n[3], const double at[3],
                      double d)
{
    double *plane = view->plane[view->planes++];
    for (int a = 0; a < 3; a++)
        plane[a] = n[a] * grid->spacing[a];
    plane[3] = -d - dot(n, at);
    view->clipped = 1;
}

static int set_planes(cvol_context *context, cvol_view *view, const cvol_grid *grid,
                      const cvol_clip *clip)
{
    const double middle[3] = {view->extent[0] / 2, view->extent[1] / 2, view->extent[2] / 2};
    if (clip->planes < 0 || clip->planes > CVOL_CLIP_PLANES)
        return cvol_fail(context, CVOL_ERROR_ARGUMENT, "%d clipping planes: must be 0 to %d",
                         clip->planes, CVOL_CLIP_PLANES);
    for (int k = 0; k < clip->planes; k++) {
        const double *p = clip->plane[k];
        double n[3] = {p[0], p[1], p[2]};
        if (!(normalise(n) > 0) || !isfinite(p[3]))
            return cvol_fail(context, CVOL_ERROR_ARGUMENT,
                             "clipping plane %g,%g,%g,%g: must be a direction and a finite length",
                             p[0], p[1], p[2], p[3]);
        add_plane(view, grid, n, middle, p[3]);
        add_cut(view, grid, n, -p[3] - dot(n, middle));
    }
    return CVOL_OK;
}

/* A plane before the eye, if part of the box is nearer. */
static void set_near(cvol_view *view, const cvol_grid *grid)
{
    const double ahead[3] = {-view->eye[0], -view->eye[1], -view->eye[2]};
    const double nearest = NEAREST * view->mean_spacing;
    double least = -dot(ahead, view->place);
    for (int a = 0; a < 3; a++)
        least += fmin(ahead[a] * view->lo[a], ahead[a] * view->hi[a]) * grid->spacing[a];
    if (least < nearest)
        add_plane(view, grid, ahead, view->place, nearest);
}

/* rotation = rotation times a turn by `degrees` about x or z. */
static void turn_about(double rotation[4], int axis, double degrees)
{
    const double c = cos(degrees / 2 * RADIANS_PER_DEGREE),
                 s = sin(degrees / 2 * RADIANS_PER_DEGREE);
    const double w = rotation[0], x = rotation[1], y = rotation[2], z = rotation[3];
    rotation[0] = w * c - (axis ? z : x) * s;
    rotation[1] = x * c + (axis ? y : w) * s;
    rotation[2] = y * c + (axis ? -x : z) * s;
    rotation[3] = z * c + (axis ? w : -y) * s;
}

/* From straight above, looking down: about z by the azimuth, then about the new x and z. */
void cvol_camera_get_rotation(double rotation[4], const cvol_camera *camera)
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
    const cvol_camera *camera = &options->camera;
    *out = (cvol_view){.width = options->width,
                       .height = options->height,
                       .first_row = options->rows.of ? options->rows.first : 0,
                       .all_rows = options->rows.of ? options->rows.of : options->height,
                       .rays = options->oversample > 0 ? options->oversample : 1,
                       .apart = 1,
                       .coarsest = CVOL_COARSEST_PITCH,
                       .step = options->step_voxels};
    int code = check_options(context, options);
    if (code)
        return code;
    set_directions(out, camera);
    for (int a = 0; a < 3; a++) {
        out->extent[a] = (double)(grid->dims[a] - 1) * grid->spacing[a];
        out->centre[a] = out->extent[a] / 2;
        out->mean_spacing += grid->spacing[a] / 3;
    }
    double diagonal = hypot(hypot(out->extent[0], out->extent[1]), out->extent[2]);
    /* A single sample has no extent; it is shown with the size of its spacing. */
    if (!(diagonal > 0))
        diagonal = out->mean_spacing;
    out->ahead = diagonal / 2;
    out->pixel = diagonal / camera->zoom / out->all_rows;
    if ((code = set_box(context, out, grid, &options->clip)) ||
        (code = set_part(context, out, &options->part)) ||
        (code = set_planes(context, out, grid, &options->clip)))
        return code;
    if (!camera->placed && (code = look_at(context, out, camera->look_at, diagonal)))
        return code;
    if (camera->fov_deg > 0) {
        const double tangent = tan(camera->fov_deg / 2 * RADIANS_PER_DEGREE);
        out->perspective = 1;
        out->distance = diagonal / camera->zoom / 2 / tangent;
        for (int a = 0; a < 3; a++)
            out->place[a] = out->centre[a] + out->distance * out->eye[a];
        if (camera->placed && (code = place_eye(context, out, camera)))
            return code;
        out->pixel = 2 * tangent * out->distance / out->all_rows;
        set_near(out, grid);
    }
    if (!isfinite(out->pixel) || !(out->pixel > 0))
        return cvol_fail(context, CVOL_ERROR_ARGUMENT,
                         "zoom %g: the picture's scale is beyond the range of numbers",
                         camera->zoom);
    return CVOL_OK;
}

int cvol_clip_shows(const cvol_clip *clip, const cvol_grid *grid, const double at[3])
{
    double place[3]; /* from the middle of the volume, in its unit */
    for (int a = 0; a < 3; a++) {
        if (clip->axes >> a & 1 && (at[a] < clip->from[a] || at[a] > clip->to[a]))
            return 0;
        place[a] = (at[a] - (double)(grid->dims[a] - 1) / 2) * grid->spacing[a];
    }
    for (int k = 0; k < clip->planes && k < CVOL_CLIP_PLANES; k++) {
        const double *p = clip->plane[k], length = hypot(hypot(p[0], p[1]), p[2]);
        if (p[0] * place[0] + p[1] * place[1] + p[2] * place[2] < p[3] * length)
            return 0;
    }
    return 1;
}
