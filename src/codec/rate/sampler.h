/* Some bricks of a volume, kept as they are transformed: by these a step is found before all is
 * encoded.
 *
 * Which bricks: those at the points frac(k (g^-1, g^-2, g^-3)), g^4 = g + 1 (Roberts 2018), of the
 * grid of bricks, which spread evenly. Where samples are read from a file they lie in few layers.
 */
#ifndef CVOL_CODEC_RATE_SAMPLER_H
#define CVOL_CODEC_RATE_SAMPLER_H

#include "codec/brick/encode_pass.h"

typedef struct cvol_sampler cvol_sampler;

/* Chooses and reads `most` <= 32 bricks; *shape's dims, block and offset count. both: lapped and
 * not, else as shape says. About 1 MiB a brick (2 with both). Errors: the source's, MEMORY. */
int cvol_sampler_make(cvol_context *context, cvol_sampler **out, const cvol_array *shape,
                      const cvol_slab_source *source, size_t most, int both);
void cvol_sampler_free(cvol_sampler *sampler); /* NULL is allowed */

/* The samples of its bricks, those beyond the volume too, as a share of all; how many lie within.
 */
double cvol_sampler_share(const cvol_sampler *sampler, const cvol_array *shape);
uint64_t cvol_sampler_inside(const cvol_sampler *sampler, const cvol_array *shape);

/* Which share of the coefficients' squared error is that of samples: measured on about
 * `most` of its bricks, encoded as cvol_sampler_run does; counts may be NULL. The rest lies beyond
 * the volume, or goes where the post-filter smooths it away. Errors: as cvol_sampler_run. */
int cvol_sampler_measure(cvol_context *context, double *share, const cvol_sampler *sampler,
                         const cvol_array *shape, const cvol_token_tables *tables,
                         const cvol_chooser_options *options, cvol_token_counts *counts,
                         size_t most);

/* How many bricks; the cells of the i-th, lapped or not, and which brick it is. */
size_t cvol_sampler_count(const cvol_sampler *sampler);
const float *cvol_sampler_brick(const cvol_sampler *sampler, size_t i, int lapped, size_t *brick);

/* Encodes those bricks, lapped or not as shape says; or about `most` of them, if it is not 0.
 * counts may be NULL. Errors: MEMORY, TARGET (the step is too small for the coder's numbers; no
 * message). */
int cvol_sampler_run(cvol_context *context, cvol_encode_result *out, cvol_token_counts *counts,
                     const cvol_sampler *sampler, const cvol_array *shape,
                     const cvol_token_tables *tables, const cvol_chooser_options *options,
                     size_t most);

#endif
