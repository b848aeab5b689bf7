/* Affine matrices of NIfTI headers, and the quaternions by which a qform describes a rotation. */
#ifndef CVOL_VOLUME_FORMATS_NIFTI_AFFINE_H
#define CVOL_VOLUME_FORMATS_NIFTI_AFFINE_H

/* Rows 0 to 2: step[i][a] is the part along world axis i of a step along sample axis a. */
typedef struct cvol_nifti_affine {
    double step[3][3], origin[3];
} cvol_nifti_affine;

/* A rotation by the quaternion (a, b, c, d) of length 1 with a >= 0, whose b, c, d are stored. The
 * third axis is mirrored if handedness is -1. */
typedef struct cvol_nifti_rotation {
    double quaternion[3];
    double handedness; /* 1 or -1 */
} cvol_nifti_rotation;

/* The affine of a rotation, whose axes have the lengths `spacing` > 0. */
cvol_nifti_affine cvol_nifti_affine_of(const cvol_nifti_rotation *rotation, const double spacing[3],
                                       const double origin[3]);

/* The rotation closest to the directions of an affine, whose steps are not 0. */
cvol_nifti_rotation cvol_nifti_rotation_of(const cvol_nifti_affine *affine);

#endif
