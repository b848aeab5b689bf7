/* Samples of an array in blocks around any place, mirrored beyond the array's ends (a[-1 - x] =
 * a[x]), for producers that compute one block of a result at a time (build.h). The producer's
 * scratch caches evaluated blocks, since neighbours need them again. For lapped volumes the samples
 * are post-filtered from the cached blocks. */
#ifndef CVOL_ARRAY_BLOCK_HALO_H
#define CVOL_ARRAY_BLOCK_HALO_H

#include "array/core/array.h"

/* Bytes of scratch for the helper, a multiple of 64. The scratch must be zero at first. */
size_t cvol_halo_bytes(const cvol_array *array);

/* The box of size[0] x size[1] x size[2] samples from `begin` on, which may lie beyond the array;
 * with the offset, and with the value of a separate background; x fastest. size[a] <=
 * CVOL_HALO_MAX, or of a lapped volume three blocks and two more samples on either side; 1 beyond
 * the rank. */
enum { CVOL_HALO_MAX = 96 };
void cvol_halo_read(float *out, void *halo, const cvol_array *array, const ptrdiff_t begin[3],
                    const size_t size[3]);

/* The same of the terms of a lapped volume alone: without the offset, and with what the terms have
 * behind a separate background. */
void cvol_halo_read_terms(float *out, void *halo, const cvol_array *array, const ptrdiff_t begin[3],
                          const size_t size[3]);

/* As cvol_block_evaluate, also for lapped volumes: post-filtered, and mirrored where the block
 * reaches beyond the volume. Of the terms alone: without the offset, and with what the terms have
 * behind a separate background. */
void cvol_halo_evaluate(float *out, void *halo, const cvol_array *array, size_t index);

/* Converts the samples of block `index` of `shape` to its slots. Padding first repeats the last
 * sample within the array. Returns the largest magnitude of the samples. */
float cvol_halo_finish(float *slots, float *samples, const cvol_array *shape, size_t index);

#endif
