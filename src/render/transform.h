/* The transform engine's inside: the paper's renderer (Chen and Reif 2003, sections 3 and 4).
 *
 * Slices of the axis most parallel to the view are images on one lattice, large enough for all of
 * them sheared: sample (i, j) of slice k lies at place
 *
 *     base[0] + i + k shear[0],   base[1] + j + k shear[1]
 *
 * of it. Of every slice four planes are kept as compressed arrays of rank 2: what its samples add
 * to red, green and blue (intensity times opacity), and opacity. With DFTs and DHTs the shear is a
 * phase ramp and the footprint a factor for each frequency.
 */
#ifndef CVOL_RENDER_TRANSFORM_H
#define CVOL_RENDER_TRANSFORM_H

#include "cvol/algebra.h"
#include "render/splat.h"

enum { CVOL_PLANES = 4, CVOL_PLANE_OPACITY = 3 };

/* Where slices lie on the lattice. */
typedef struct cvol_lattice {
    size_t dims[2];
    double base[2], shear[2];
    size_t reach;   /* places around a slice that its footprints reach: planes keep as many free */
    size_t samples; /* of a slice */
} cvol_lattice;

/* What has been made of the samples: NULL for slices of which nothing can be seen. */
typedef struct cvol_baked {
    cvol_lattice lattice;
    size_t slices;
    cvol_array *(*planes)[CVOL_PLANES]; /* of slice k */
    uint64_t terms, bytes;              /* of all planes, and in memory */
} cvol_baked;

/* The lattice of a plan, for footprints that reach so many places. */
cvol_lattice cvol_lattice_make(const cvol_splat_plan *plan, int reach);

/* Classifies, lights and compresses all slices. Errors: MEMORY, CANCELLED. */
int cvol_bake(cvol_context *context, cvol_baked *out, const cvol_splat_source *source,
              const cvol_splat_plan *plan, const cvol_lattice *lattice,
              const cvol_splat_table *table, const cvol_splat_light *light, int ascending,
              const cvol_transform_options *options);
void cvol_baked_free(cvol_baked *baked);

/* A picture on the lattice: planes of intensity, premultiplied, and opacity; the bound of its
 * error. */
typedef struct cvol_composed {
    float *planes[CVOL_PLANES]; /* dims[0] * dims[1] each */
    uint64_t terms;             /* of the compressed image */
    double bound;               /* on the L2 norm of the error of all planes together */
} cvol_composed;

/* Composites the slices, front to back (front 1) or back to front; `rising`: slice 0 is the
 * nearest. Errors: MEMORY, CANCELLED, UNSUPPORTED. */
int cvol_compose(cvol_context *context, cvol_composed *out, const cvol_baked *baked,
                 const cvol_kernel *footprint, int rising, int front,
                 const cvol_transform_options *options);
void cvol_composed_free(cvol_composed *composed);

/* What is kept of a plane, or of the picture. */
cvol_keep cvol_transform_keep(const cvol_transform_options *options, const cvol_lattice *lattice);

#endif
