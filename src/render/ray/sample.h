/* Samples of a dense volume along a straight line, interpolated linearly along each axis. */
#ifndef CVOL_RENDER_RAY_SAMPLE_H
#define CVOL_RENDER_RAY_SAMPLE_H

#include "cvol/volume.h"

/* The view of a volume that the line functions use. */
typedef struct cvol_ray_field {
    const void *data;
    double last[3];      /* index of the last sample of each axis */
    size_t cell_max[3];  /* the last index that has a neighbour, 0 for an axis of one sample */
    size_t next[3];      /* distance in memory of the neighbour, 0 for an axis of one sample */
    size_t row, slice;   /* distances in memory of the next row and the next slice */
    double min, max;     /* of the finite samples with a value */
    const uint8_t *mask; /* for each sample, not 0 if it has no value; NULL: all have one */
} cvol_ray_field;

/* out[k] = the volume at start + k delta, in sample indices, for k < count; constant beyond the
 * outermost samples. NaN counts as min; infinities as min and max. */
typedef void (*cvol_ray_line_fn)(double *out, const cvol_ray_field *field, const double start[3],
                                 const double delta[3], size_t count);

/* The same for samples that may have no value: cover[k] is the weight of those that have one, and
 * out[k] their weighted mean (0 if there are none). */
typedef void (*cvol_ray_masked_fn)(double *out, double *cover, const cvol_ray_field *field,
                                   const double start[3], const double delta[3], size_t count);

/* The field of a volume whose samples range over min..max. */
cvol_ray_field cvol_ray_field_make(const cvol_volume *volume, double min, double max);
/* The line function of a sample type. */
cvol_ray_line_fn cvol_ray_line_of(cvol_type type);
cvol_ray_masked_fn cvol_ray_masked_of(cvol_type type);
/* The smallest and largest of the finite samples with a value; 0 if there are none. */
int cvol_ray_field_bound(double *min, double *max, const cvol_volume *volume, const uint8_t *mask);

#endif
