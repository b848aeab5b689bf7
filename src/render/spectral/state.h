/* The state of a transform renderer from picture to picture: for engine.c and baked_file.c. */
#ifndef CVOL_RENDER_SPECTRAL_STATE_H
#define CVOL_RENDER_SPECTRAL_STATE_H

#include "codec/container/baked.h"
#include "render/spectral/frame.h"
#include "render/splat/setup.h"

typedef struct cvol_transform_state {
    cvol_splat_input input; /* first: cvol_splat_state_create */
    cvol_baked baked;
    /* The inputs of `baked`. */
    int has_baked;
    cvol_footprint_shape shape;
    cvol_light light;
    cvol_transform_options options;
    cvol_transform_report report;
    int has_report;
    /* For a renderer over a baked file: its description, without planes; else path is NULL. */
    cvol_baked_file file;
    char *path;
} cvol_transform_state;

/* Refuses options that a baked file does not support: another light, more terms, other slices, wide
 * footprints. Errors: ARGUMENT. */
int cvol_baked_file_serves(cvol_context *context, const cvol_transform_state *state,
                           const cvol_splat_plan *plan, const cvol_render_options *options);
/* Checks that a transfer function is the file's. Errors: ARGUMENT. */
int cvol_baked_file_has_transfer(cvol_context *context, const cvol_transform_state *state,
                                 const cvol_transfer *transfer);

#endif
