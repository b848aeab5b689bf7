/* Named views: the place of the eye for front, back, left, right, top and bottom.
 *
 * If a volume states its orientation in a patient (LPS or RAS), directions are the patient's. The
 * eye is in front of the face with the patient's left on the right of the picture, as radiologists
 * look. Left and right are the patient's own. From the top and from the bottom the front is
 * upwards, and the view from the bottom is that of axial slices. Otherwise directions follow the
 * axes: front is at -y, right at +x, top at +z.
 *
 * With D the grid's directions, a vector w of the world is D w along the axes of the samples, which
 * cameras use. With left-handed axes (det D < 0) a picture is a mirror image: then D (up x eye) =
 * -(D up) x (D eye), and the picture must be mirrored.
 *
 * The default view is the front view, turned and raised; slabs are seen across their thin axis, and
 * a single slice exactly along it.
 *
 * From eye E and up U to the angles of a camera: e = asin E_z, a = atan2(E_x, -E_y), and the roll
 * is the angle of U in the plane of the directions right and up without a roll (camera.c). */
#include <math.h>
#include <string.h>

#include "base/context.h"
#include "cvol/look.h"
#include "render/view/camera.h"

#define DEGREES (180 / 3.14159265358979323846)
#define SNAP 1e-3 /* degrees: headers store directions as rounded numbers */

/* Eye and up, in the patient as LPS, or along the axes. */
static const struct named_view {
    const char *name;
    double eye[3], up[3], plain_eye[3], plain_up[3];
} views[] = {
    {"front", {0, -1, 0}, {0, 0, 1}, {0, -1, 0}, {0, 0, 1}},
    {"back", {0, 1, 0}, {0, 0, 1}, {0, 1, 0}, {0, 0, 1}},
    {"left", {1, 0, 0}, {0, 0, 1}, {-1, 0, 0}, {0, 0, 1}},
    {"right", {-1, 0, 0}, {0, 0, 1}, {1, 0, 0}, {0, 0, 1}},
    {"top", {0, 0, 1}, {0, -1, 0}, {0, 0, 1}, {0, 1, 0}},
    {"bottom", {0, 0, -1}, {0, -1, 0}, {0, 0, -1}, {0, -1, 0}},
};

/* Other names: of anatomy, and of the slices that look alike. */
static const char *const synonyms[][2] = {
    {"anterior", "front"}, {"posterior", "back"}, {"superior", "top"}, {"inferior", "bottom"},
    {"coronal", "front"},  {"sagittal", "left"},  {"axial", "bottom"}};

#define VIEWS (sizeof views / sizeof *views)

const char *cvol_view_names(void)
{
    return "front back left right top bottom anterior posterior superior inferior coronal sagittal "
           "axial";
}

static double dot(const double a[3], const double b[3])
{
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

static void cross(double out[3], const double a[3], const double b[3])
{
    for (int i = 0; i < 3; i++)
        out[i] = a[(i + 1) % 3] * b[(i + 2) % 3] - a[(i + 2) % 3] * b[(i + 1) % 3];
}

static double snap(double degrees)
{
    const double quarter = 90 * round(degrees / 90);
    return fabs(degrees - quarter) < SNAP ? quarter : degrees;
}

/* The angles of a camera with this eye and this up, which need not have length 1 nor be exactly
 * perpendicular. */
static void set_angles(cvol_camera *camera, const double eye[3], const double up[3])
{
    const double level = hypot(eye[0], eye[1]);
    const double elevation = atan2(eye[2], level);
    const double azimuth = level > 1e-6 * fabs(eye[2]) ? atan2(eye[0], -eye[1]) : 0;
    const double ca = cos(azimuth), sa = sin(azimuth), ce = cos(elevation), se = sin(elevation);
    const double right_before[3] = {ca, sa, 0}, up_before[3] = {-se * sa, se * ca, ce};
    camera->azimuth_deg = snap(azimuth * DEGREES);
    camera->elevation_deg = snap(elevation * DEGREES);
    camera->roll_deg = snap(atan2(-dot(up, right_before), dot(up, up_before)) * DEGREES);
}

/* Turns the eye by `degrees` around the vertical, towards larger azimuths. */
static void turn(double vector[3], double degrees)
{
    const double c = cos(degrees / DEGREES), s = sin(degrees / DEGREES);
    const double x = vector[0], y = vector[1];
    vector[0] = c * x - s * y;
    vector[1] = s * x + c * y;
}

/* From LPS to the axes of the samples; the determinant of the directions. */
static double to_axes(double vector[3], const cvol_grid *grid)
{
    const double sign = grid->space == CVOL_SPACE_RAS ? -1 : 1;
    const double world[3] = {sign * vector[0], sign * vector[1], vector[2]};
    double normal[3];
    for (int a = 0; a < 3; a++)
        vector[a] = dot(grid->direction[a], world);
    cross(normal, grid->direction[0], grid->direction[1]);
    return dot(normal, grid->direction[2]);
}

/* The camera at the eye and up of a view, turned and raised. */
static void place(cvol_camera *camera, int *mirrored, const struct named_view *view,
                  const cvol_grid *grid, double turn_deg, double raise_deg)
{
    const int is_plain = grid->space == CVOL_SPACE_UNKNOWN;
    const double *from = is_plain ? view->plain_eye : view->eye,
                 *above = is_plain ? view->plain_up : view->up;
    const double c = cos(raise_deg / DEGREES), s = sin(raise_deg / DEGREES);
    double eye[3], up[3];
    for (int a = 0; a < 3; a++) {
        eye[a] = c * from[a] + s * above[a];
        up[a] = c * above[a] - s * from[a];
    }
    *mirrored = 0;
    turn(eye, turn_deg);
    turn(up, turn_deg);
    if (!is_plain) {
        *mirrored = to_axes(eye, grid) < 0;
        to_axes(up, grid);
    }
    set_angles(camera, eye, up);
}

int cvol_camera_set_view(cvol_context *context, cvol_camera *camera, int *mirrored,
                         const char *name, const cvol_grid *grid, double turn_deg)
{
    *mirrored = 0;
    size_t k = 0;
    for (size_t i = 0; i < sizeof synonyms / sizeof *synonyms; i++)
        if (!strcmp(name, synonyms[i][0]))
            name = synonyms[i][1];
    while (k < VIEWS && strcmp(name, views[k].name))
        k++;
    if (k == VIEWS)
        return cvol_fail(context, CVOL_ERROR_ARGUMENT, "no view is named %s; there are: %s", name,
                         cvol_view_names());
    place(camera, mirrored, &views[k], grid, turn_deg, 0);
    return CVOL_OK;
}

/* ---- the default view -------------------------------------------------------------------- */

/* The axis of a slab, in the patient (L, P, S) if it is known; -1: not a slab. */
static int thin_axis(const cvol_grid *grid)
{
    const int thin = cvol_view_thin_axis(grid);
    if (thin < 0 || grid->space == CVOL_SPACE_UNKNOWN)
        return thin;
    int most = 0;
    for (int a = 1; a < 3; a++)
        if (fabs(grid->direction[thin][a]) > fabs(grid->direction[thin][most]))
            most = a;
    return most;
}

void cvol_camera_set_default(cvol_camera *camera, int *mirrored, const cvol_grid *grid,
                             double turn_deg)
{
    /* Turned to the side, and raised: along x, y, z, and for volumes that are no slabs. */
    static const double angles[4][2] = {{62, 20}, {24, 20}, {24, 58}, {30, 20}};
    /* Slices: y of those across z runs downwards, as rows of pictures. */
    static const double flat[3][2] = {{90, 0}, {0, 0}, {0, -90}};
    const int axis = thin_axis(grid), k = axis < 0 ? 3 : axis;
    const int is_flat = axis >= 0 && grid->dims[cvol_view_thin_axis(grid)] == 1;
    const double *to = is_flat ? flat[k] : angles[k];
    place(camera, mirrored, &views[0], grid, to[0] + turn_deg, to[1]);
}
