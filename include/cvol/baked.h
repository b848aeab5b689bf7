/* cvol/baked.h - baked volumes: files of compressed slices, classified and lit for one axis. */
#ifndef CVOL_BAKED_H
#define CVOL_BAKED_H

#include "cvol/render.h"

#ifdef __cplusplus
extern "C" {
#endif

/* Bakes what a renderer of engine transform draws into a file: its planes of all slices across
 * `axis` (0 x, 1 y, 2 z), with the transfer function that was set, light, footprint, transform
 * (DCT) and rho of the options; opacities are for the axis' own direction. Light is that of an eye
 * in this direction, of the default material (else UNSUPPORTED). Planes are rounded, by which a
 * quarter is added to the energy that truncation lost. transfer_name (or NULL) is kept for people.
 * file_bytes may be NULL. Errors: ARGUMENT (also a footprint larger than a slice, rho 0 or above
 * 1), UNSUPPORTED (DFT and DHT, whose planes serve one direction), LIMIT, IO, MEMORY, CANCELLED. */
CVOL_API int cvol_renderer_bake(cvol_context *context, cvol_renderer *renderer, const char *path,
                                int axis, const char *transfer_name,
                                const cvol_render_options *options, uint64_t *file_bytes);
/* What a baked file holds. */
typedef struct cvol_baked_info {
    cvol_grid grid; /* shape, type and spacing of the original volume */
    int axis;
    size_t slices, visible; /* all slices; slices that are not empty */
    int channels;           /* colour channels: 3, or 1 (grey) */
    cvol_transform transform;
    int tile;
    double rho, kept, step; /* the option; terms divided by samples; quantizer step of the terms */
    uint64_t terms, resident_bytes;
    cvol_splat_options splat; /* footprint */
    cvol_shading shading;     /* on and light; the other fields have default values */
    char transfer_name[32];   /* "": no name */
    const cvol_transfer_point *transfer_points; /* owned by the renderer */
    size_t transfer_count;
} cvol_baked_info;
/* Describes the baked volume of a renderer. Errors: ARGUMENT (not over a baked volume). */
CVOL_API int cvol_renderer_baked_info(cvol_context *context, const cvol_renderer *renderer,
                                      cvol_baked_info *out);

#ifdef __cplusplus
}
#endif
#endif
