/* Some transformed bricks of a volume, on which the step search works before all bricks are
 * encoded.
 *
 * It takes the bricks at the points frac(k (g^-1, g^-2, g^-3)), g^4 = g + 1 (Roberts 2018), of the
 * grid of bricks, which spread evenly. If samples come from a file, the bricks lie in few
 * layers. */
#ifndef CVOL_CODEC_RATE_SAMPLER_H
#define CVOL_CODEC_RATE_SAMPLER_H

#include "codec/brick/encode_pass.h"

typedef struct cvol_sampler cvol_sampler;

/* Chooses and reads `most` <= 32 bricks; uses *shape's dims, block and offset. both: keeps them
 * lapped and not lapped, else as shape says. Memory: about 1 MiB per brick (2 with both). Errors:
 * the source's, MEMORY. */
int cvol_sampler_make(cvol_context *context, cvol_sampler **out, const cvol_array *shape,
                      const cvol_slab_source *source, size_t most, int both);
void cvol_sampler_free(cvol_sampler *sampler); /* NULL is allowed */

/* The samples of its bricks as a share of all samples, padding included; and the number of samples
 * within the volume. */
double cvol_sampler_share(const cvol_sampler *sampler, const cvol_array *shape);
uint64_t cvol_sampler_inside(const cvol_sampler *sampler, const cvol_array *shape);

/* Measures the samples' share of the coefficients' squared error, on about `most` of its bricks,
 * encoded as by cvol_sampler_run; counts may be NULL. The rest of the error lies in padding, or the
 * post-filter smooths it away. Errors: as cvol_sampler_run. */
int cvol_sampler_measure(cvol_context *context, double *share, const cvol_sampler *sampler,
                         const cvol_array *shape, const cvol_token_tables *tables,
                         const cvol_chooser_options *options, cvol_token_counts *counts,
                         size_t most);

/* The number of bricks; the cells of the i-th brick, lapped or not, with its brick index. */
size_t cvol_sampler_count(const cvol_sampler *sampler);
const float *cvol_sampler_brick(const cvol_sampler *sampler, size_t i, int lapped, size_t *brick);

/* Encodes those bricks, lapped or not as shape says; if `most` is not 0, about `most` of them.
 * counts may be NULL. Errors: MEMORY, TARGET (the step is too small for the coder's numbers; no
 * message). */
int cvol_sampler_run(cvol_context *context, cvol_encode_result *out, cvol_token_counts *counts,
                     const cvol_sampler *sampler, const cvol_array *shape,
                     const cvol_token_tables *tables, const cvol_chooser_options *options,
                     size_t most);

#endif
