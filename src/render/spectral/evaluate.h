/* Planes of a slice on the lattice. */
#ifndef CVOL_RENDER_SPECTRAL_EVALUATE_H
#define CVOL_RENDER_SPECTRAL_EVALUATE_H

#include "render/spectral/compose.h"

/* Plane c of slice k, spread and shifted, as an array again: planes with a margin (whole, DFT and
 * DHT). Errors: MEMORY. */
int cvol_plane_reconstruct(cvol_context *context, cvol_array **out, const cvol_compose_job *job,
                           size_t k, int c);
/* Any plane, spread and shifted, as samples on the lattice. Errors: MEMORY. */
int cvol_plane_evaluate(cvol_context *context, float *out, const cvol_compose_job *job, size_t k,
                        int c);
/* Opacities D become 1 - (1 - D)^power, and intensities change by the same factor. */
void cvol_planes_correct_opacity(float *const planes[CVOL_PLANES], int channels, size_t places,
                                 double power);

#endif
