/* The faces across one axis that lie in a box, in the form that the filter's kernels need. */
#ifndef CVOL_TRANSFORM_LAP_FACES_H
#define CVOL_TRANSFORM_LAP_FACES_H

#include <stdint.h>

typedef struct cvol_lap_faces {
    int64_t first;              /* of the first face's four samples, from the box's first */
    int64_t count, face_stride; /* faces, and floats from one to the next */
    int64_t stride;             /* from sample to sample across a face */
    int64_t lines[2], line_stride[2];
} cvol_lap_faces;

#endif
