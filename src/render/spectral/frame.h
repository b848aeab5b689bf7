/* Internals of the transform engine: the paper's renderer (Chen and Reif 2003, sections 3 and 4).
 *
 * Slices along the axis most parallel to the view are images. The planes of a slice are stored as
 * compressed arrays of rank 2: its samples' red, green and blue (intensity times opacity; one plane
 * if colour is grey), and opacity. A footprint spreads them, they are shifted to their position on
 * the view's lattice, and composited.
 *
 * Planes are in tiles of B x B samples (DCT), or whole. Tiles depend on the view only by the
 * distance of slices along it, and by the light. Whole planes under DFT and DHT have the length of
 * the view's lattice, since phase ramps shift them. */
#ifndef CVOL_RENDER_SPECTRAL_FRAME_H
#define CVOL_RENDER_SPECTRAL_FRAME_H

#include <string.h>

#include "cvol/algebra.h"
#include "render/splat/object_order.h"

enum { CVOL_PLANES = 4, CVOL_PLANE_OPACITY = 3 };

/* Classified and compressed samples. Files store this, and the planes: doc/format.md. */
typedef struct cvol_baked {
    size_t samples[2], slices; /* lanes and rows of a slice */
    int axis_slice;
    cvol_transform transform;
    int tile;        /* their side; 0: whole planes */
    size_t margin;   /* zeros before sample 0 of a plane: whole ones under DFT and DHT */
    int channels;    /* of colour: 3; 1: grey, planes 1 and 2 are NULL */
    double distance; /* between slices along the view, in mean spacings: opacity is for it */
    cvol_intermediate_grid image_grid;  /* whole planes under DFT and DHT: their lattice */
    cvol_array *(*planes)[CVOL_PLANES]; /* of slice k; all NULL if the slice is transparent */
    uint64_t terms, bytes;              /* of all planes, and in memory */
    uint8_t *filled; /* tiles: of tile t of slice k, at [k tiles + t], bit c: plane c has terms */
} cvol_baked;

/* The inputs of classification. */
typedef struct cvol_bake_source {
    const cvol_splat_source *samples;
    const cvol_splat_plan *plan;
    const cvol_splat_table *table;
    const cvol_light *light;
    int ascending; /* the light is for slices composited in rising order */
} cvol_bake_source;

/* Returns 1 if planes of these options must be made for each lattice. */
static inline int cvol_transform_is_periodic(const cvol_transform_options *options)
{
    return options->tile == 0 && options->transform != CVOL_DCT;
}

/* Classifies, lights and compresses all slices. Tiles: one threshold for all terms, weighted by
 * their attenuation by this footprint, so that all nonempty planes together keep rho of their
 * samples; whole planes keep rho each. Errors: MEMORY, CANCELLED. */
int cvol_bake(cvol_context *context, cvol_baked *out, const cvol_bake_source *source,
              const cvol_intermediate_grid *image_grid, const cvol_footprint_shape *shape,
              const cvol_transform_options *options);
/* The same with fewer terms: the strongest by the same weights. Errors: MEMORY, CANCELLED. */
int cvol_baked_reduce(cvol_context *context, cvol_baked *out, const cvol_baked *baked,
                      const cvol_footprint_shape *shape, double rho);
/* Derives terms, bytes and `filled` from the planes. Errors: MEMORY. */
int cvol_baked_count(cvol_context *context, cvol_baked *baked);
/* The number of planes that exist. */
size_t cvol_baked_planes(const cvol_baked *baked);
void cvol_baked_free(cvol_baked *baked);

/* A picture on the lattice: planes of intensity, premultiplied, and opacity; the bound of its
 * error. */
typedef struct cvol_composed {
    float *planes[CVOL_PLANES];      /* dims[0] * dims[1] each */
    cvol_array *arrays[CVOL_PLANES]; /* literal: the same, as arrays; else NULL */
    uint64_t terms;                  /* of these */
    uint64_t multiply_adds;          /* of spreading and compositing */
    double bound; /* on the L2 norm of the error of all planes of intensity together */
    int certified;
    int is_useful; /* the bound is less than the distance of intensities from the ends of their
                      range */
} cvol_composed;

/* Composites the slices, front to back (front 1) or back to front; `rising`: slice 0 is the
 * nearest. `distance` between slices along the view; if planes are for another one, opacities are
 * corrected after spreading. Errors: ARGUMENT (whole planes of another lattice), MEMORY, CANCELLED,
 * UNSUPPORTED. */
int cvol_compose(cvol_context *context, cvol_composed *out, const cvol_baked *baked,
                 const cvol_intermediate_grid *image_grid, const cvol_footprint_shape *shape,
                 double distance, int rising, int front, const cvol_transform_options *options);
void cvol_composed_free(cvol_composed *composed);

/* ---- tiles ----------------------------------------------------------------------------------- */

/* The selection of terms of a plane's tiles. */
typedef struct cvol_tile_weights {
    float of[CVOL_PLANES][32]; /* weights of a frequency along one axis; a term has the product */
} cvol_tile_weights;
void cvol_tile_weights_make(cvol_tile_weights *out, const cvol_footprint_shape *shape, int tile);

/* Terms by weighted magnitude: bits of the float, shifted. */
enum { CVOL_TILE_BINS = 1 << 15 };
static inline uint32_t cvol_tile_bin(float key)
{
    uint32_t bits;
    memcpy(&bits, &key, sizeof bits);
    return bits >> 16;
}
/* The least key of the strongest `count` terms, or a few less. */
float cvol_tile_threshold(const uint64_t *bins, uint64_t count);

/* Counts a dense plane's terms in bins. scratch: 2 B B floats, 64-byte aligned. */
void cvol_tiles_count(uint64_t *bins, const float *samples, const cvol_array *like,
                      const float *weights, float *scratch);
/* An array of a dense plane's terms of at least this key; 0: all. Errors: MEMORY. */
int cvol_tiles_compress(cvol_context *context, cvol_array **out, const float *samples,
                        const size_t dims[2], int tile, const float *weights, float least);

#endif
