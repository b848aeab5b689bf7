/* Internals of the loops: the common part of both schedules. */
#ifndef CVOL_RENDER_SPECTRAL_COMPOSE_H
#define CVOL_RENDER_SPECTRAL_COMPOSE_H

#include "render/spectral/frame.h"

typedef struct cvol_compose_job {
    const cvol_baked *baked;
    const cvol_intermediate_grid *image_grid;
    const cvol_footprint_shape *shape;
    double power; /* opacity D becomes 1 - (1 - D)^power */
    double norm;  /* cvol_intermediate_grid_norm */
    int rising, front;
} cvol_compose_job;

/* The largest contribution of a sample, relative to its opacity. */
#define CVOL_BRIGHTEST CVOL_SPLAT_BRIGHTEST

/* The slice that is composited as number n. */
static inline size_t cvol_compose_slice(const cvol_compose_job *job, size_t n)
{
    return job->rising == job->front ? n : job->baked->slices - 1 - n;
}

static inline int cvol_compose_has(const cvol_compose_job *job, size_t k)
{
    return job->baked->planes[k][CVOL_PLANE_OPACITY] != NULL;
}

/* The largest errors of a slice's planes, and the largest values of their samples: |C~|, and |1 -
 * D~|. */
typedef struct cvol_slice_bounds {
    double errors[CVOL_PLANES], most[CVOL_PLANES];
} cvol_slice_bounds;
/* Errors of the planes of slice k, spread; most: 1. */
cvol_slice_bounds cvol_slice_bounds_of(const cvol_compose_job *job, size_t k);
/* Errors of intensities and opacity after a slice in front of or behind the picture. */
void cvol_compose_errors(double errors[CVOL_PLANES], const cvol_slice_bounds *slice, int front);
/* The same after a slice without truncation, in any order: samples with a transmittance of at most
 * `transmittance`, in magnitude. */
void cvol_compose_visible_errors(double errors[CVOL_PLANES], const cvol_slice_bounds *slice,
                                 double transmittance);
/* The norm over the intensities together; a single channel counts three times. */
double cvol_error_norm(const double errors[CVOL_PLANES], int channels);

/* Multiply-adds by formula, for transforms in other code: of evaluating plane c of slice k on the
 * lattice (or transforming it back) and spreading it. A transform of n samples counts n log2 n, in
 * tiles 2 n B. */
uint64_t cvol_plane_multiply_adds(const cvol_compose_job *job);
uint64_t cvol_transform_multiply_adds(size_t n, int tile);

/* Each fills out->planes (allocated, zero) and bound. Errors: MEMORY, CANCELLED. */
int cvol_compose_literal(cvol_context *context, cvol_composed *out, const cvol_compose_job *job,
                         const cvol_transform_options *options);
int cvol_compose_whole(cvol_context *context, cvol_composed *out, const cvol_compose_job *job);
int cvol_compose_tiles(cvol_context *context, cvol_composed *out, const cvol_compose_job *job);

#endif
