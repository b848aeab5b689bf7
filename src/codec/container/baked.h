/* A baked volume as stored in a file: planes of all slices along an axis, and the settings that
 * made them. The transform engine (src/render/spectral/frame.h) makes and draws them. */
#ifndef CVOL_CODEC_CONTAINER_BAKED_H
#define CVOL_CODEC_CONTAINER_BAKED_H

#include "array/core/array.h"
#include "base/bytes.h"
#include "cvol/baked.h"

enum { CVOL_BAKED_PLANES = 4, CVOL_BAKED_OPACITY = 3, CVOL_BAKED_NAME_BYTES = 32 };

/* Planes of slice k: one colour or three, and opacity; all NULL if the slice is invisible. */
typedef cvol_array *cvol_baked_slice[CVOL_BAKED_PLANES];

typedef struct cvol_baked_file {
    cvol_grid grid; /* shape, type and spacing of the volume */
    int axis;       /* slices lie across it */
    cvol_transform transform;
    int tile, channels;
    double distance; /* for which opacities hold, in mean spacings */
    double rho, step;
    cvol_splat_options splat;                  /* footprint */
    cvol_shading shading;                      /* light on or off, and the light's direction only */
    char transfer_name[CVOL_BAKED_NAME_BYTES]; /* "" if it has none */
    size_t point_count;
    cvol_transfer_point *points;
    size_t slices;
    cvol_baked_slice *planes;
} cvol_baked_file;

/* The number of samples along x and y of a slice's planes. */
void cvol_baked_file_samples(size_t out[2], const cvol_baked_file *file);
/* The step whose rounding loses a quarter of the energy that truncation lost, by its bounds. */
double cvol_baked_file_step(const cvol_baked_file *file);

/* Appends the file; rounds planes to its step. Errors: DATA, MEMORY, CANCELLED. */
int cvol_baked_file_put(cvol_context *context, cvol_bytes *out, const cvol_baked_file *file);
/* Reads a file. Errors: FORMAT, CORRUPT, LIMIT, UNSUPPORTED, MEMORY, CANCELLED; after an error
 * there is nothing to free. */
int cvol_baked_file_take(cvol_context *context, cvol_baked_file *out, const uint8_t *data,
                         size_t size, const char *name);
void cvol_baked_file_free(cvol_baked_file *file);

#endif
