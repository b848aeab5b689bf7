/* cvol/camera.h - the camera, named views, and the part of a volume that is drawn.
 *
 * World coordinates: sample (x, y, z) is at (x, y, z) times the spacing of the grid. Origin and
 * axis directions of the grid are stored in files, but do not turn the picture. */
#ifndef CVOL_CAMERA_H
#define CVOL_CAMERA_H

#include "cvol/base.h"

#ifdef __cplusplus
extern "C" {
#endif

/* The camera. For azimuth a and elevation e the eye is in direction (cos e sin a, -cos e cos a, sin
 * e) of the centre; +z is up; roll turns the camera counter-clockwise about its viewing direction.
 * The centre is that of the box of sample centres, plus look_at (world length, at most 1000
 * diagonals of the box).
 *
 * In parallel projection, half the height of the picture is half the diagonal of the box divided by
 * zoom. In perspective this holds at the distance of the centre; the eye is so far away that the
 * height of the picture spans fov_deg. Points nearer to the eye than two mean spacings, along the
 * viewing direction, are not drawn. With `placed`, eye and up replace azimuth, elevation and zoom.
 * Engines sheet and ray have perspective. */
typedef struct cvol_camera {
    double azimuth_deg, elevation_deg, roll_deg, zoom;
    double fov_deg; /* 0: parallel projection; else perspective, 1 to 150 degrees */
    int placed;     /* 1, in perspective: use eye and up instead of azimuth, elevation and zoom */
    double eye[3];
    double look_at[3]; /* the point at the centre of the picture, from the centre of the box */
    double up[3]; /* direction that is up in the picture; 0 0 0: +z, or +y for an eye that looks
                     along z */
} cvol_camera;

/* The part of a volume that is drawn: inside the box, and in front of all planes. Cut faces are
 * sharp, also between two samples. All zero: the whole volume. Engines sheet and ray. */
#define CVOL_CLIP_PLANES 6
typedef struct cvol_clip {
    int axes; /* bit a: only samples from[a] to to[a] of axis a, which may be fractions */
    double from[3], to[3];
    int planes;                        /* number of planes */
    double plane[CVOL_CLIP_PLANES][4]; /* draw only points at least plane[k][3] (world length) from
                                          the centre of the box in direction plane[k][0 .. 2] */
} cvol_clip;

/* "front back left right top bottom", and their names of anatomy, "anterior posterior superior
 * inferior coronal sagittal axial"; static storage. */
CVOL_API const char *cvol_view_names(void);
/* Sets the angles of a camera (not its zoom) to a named view, turned by turn_deg around the
 * vertical. If the grid has a patient orientation, the view is that of the patient, as in
 * radiology: from the front the patient's left is on the right, from top and bottom the front is
 * up. *mirrored: the axes of the samples are left-handed, so the picture must be mirrored
 * (cvol_image_mirror). In other grids front is at -y (azimuth 0), right at +x (azimuth 90), back
 * and left opposite, top at +z (elevation 90), bottom at -z. Errors: ARGUMENT (unknown view; the
 * message lists them). */
CVOL_API int cvol_camera_set_view(cvol_context *context, cvol_camera *camera, int *mirrored,
                                  const char *name, const cvol_grid *grid, double turn_deg);
/* Sets rotation, a unit quaternion (w, x, y, z), to that of a camera with these angles, as
 * cvol_renderer_project takes it: it turns a camera that looks along -z with y up. */
CVOL_API void cvol_camera_get_rotation(double rotation[4], const cvol_camera *camera);

#ifdef __cplusplus
}
#endif
#endif
