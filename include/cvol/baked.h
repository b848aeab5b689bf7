/* cvol/baked.h - baked volumes: files of compressed slices, classified and lit for one axis. */
#ifndef CVOL_BAKED_H
#define CVOL_BAKED_H

#include "cvol/render.h"

#ifdef __cplusplus
extern "C" {
#endif

/* Bakes the volume of a renderer of engine transform into a file: the planes of all slices across
 * `axis` (0 x, 1 y, 2 z), classified by the transfer function of the renderer, with light,
 * footprint, transform (DCT) and rho of the options. Opacities are for rays along the axis. Light
 * is that of an eye on the axis, and of the default material (else UNSUPPORTED). Planes are rounded
 * to a step that loses a quarter as much energy as truncation. The file stores transfer_name (at
 * most 31 bytes, or NULL) as a note. file_bytes may be NULL. Errors: ARGUMENT (also a footprint
 * larger than a slice, rho 0 or above 1), UNSUPPORTED (DFT and DHT, whose planes serve one
 * direction), LIMIT, IO, MEMORY, CANCELLED. */
CVOL_API int cvol_renderer_bake(cvol_context *context, cvol_renderer *renderer, const char *path,
                                int axis, const char *transfer_name,
                                const cvol_render_options *options, uint64_t *file_bytes);
/* Properties of a baked volume. */
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
/* Copies the properties of the baked volume of a renderer to *out. Errors: ARGUMENT (another
 * engine, or a renderer that does not draw a baked file). */
CVOL_API int cvol_renderer_get_baked_info(cvol_context *context, cvol_baked_info *out,
                                          const cvol_renderer *renderer);

#ifdef __cplusplus
}
#endif
#endif
