/* How far a volume is from its samples, found while it is encoded layer by layer: so that neither
 * all samples nor all terms need to be in memory.
 *
 * Bricks' bytes pass through a sink; after each layer they are decoded, and the samples that do not
 * depend on the next layer are compared: of lapped volumes all but the layer's last two sheets,
 * which are compared with the next layer.
 */
#ifndef CVOL_CODEC_RATE_LAYER_MEASURE_H
#define CVOL_CODEC_RATE_LAYER_MEASURE_H

#include "codec/brick/bricks.h"
#include "codec/rate/measure.h"

typedef struct cvol_layer_measure cvol_layer_measure;

/* Of a volume of this shape (grid, block, lapped, offset, range of values), encoded with this step
 * and these tables, which must outlive it. Bytes go on to `sink`. Errors: MEMORY, LIMIT. */
int cvol_layer_measure_make(cvol_context *context, cvol_layer_measure **out,
                            const cvol_array *shape, double step, const cvol_token_tables *tables,
                            const cvol_brick_sink *sink);
void cvol_layer_measure_free(cvol_layer_measure *measure); /* NULL is allowed */

/* What the encoder hands its bricks to. */
cvol_brick_sink cvol_layer_measure_sink(cvol_layer_measure *measure);
/* After layers layer .. end - 1 (of bricks); the slab is that which they were encoded from. */
int cvol_layer_measure_after(cvol_context *context, void *measure, const cvol_slab *slab,
                             size_t layer, size_t end);

/* What was found, after the last layer: the figures that a file's header has, and the norms of the
 * subbands (subbands.h). */
void cvol_layer_measure_tell(const cvol_layer_measure *measure, cvol_array *array,
                             double subband_norm[CVOL_SUBBANDS]);

#endif
