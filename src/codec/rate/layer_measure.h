/* Measures a volume's distance from its samples layer by layer, while it is encoded, so that
 * neither all samples nor all terms need memory.
 *
 * Bricks' bytes pass through a sink. After each layer it decodes them and compares the samples that
 * do not depend on the next layer. In lapped volumes the layer's last two slices depend on it, and
 * are compared with the next layer. */
#ifndef CVOL_CODEC_RATE_LAYER_MEASURE_H
#define CVOL_CODEC_RATE_LAYER_MEASURE_H

#include "base/team.h"
#include "codec/brick/bricks.h"
#include "codec/rate/measure.h"

typedef struct cvol_layer_measure cvol_layer_measure;

/* Makes a measure for a volume of this shape (grid, block, lapped, offset, range of values),
 * encoded with this step and these tables, which must outlive it. Bytes go on to `sink`. In a team
 * (or NULL) each process measures its own layers, and all get the results. Errors: MEMORY, LIMIT.
 */
int cvol_layer_measure_make(cvol_context *context, cvol_layer_measure **out,
                            const cvol_array *shape, double step, const cvol_token_tables *tables,
                            const cvol_brick_sink *sink, cvol_team *team);
void cvol_layer_measure_free(cvol_layer_measure *measure); /* NULL is allowed */

/* The sink that receives the encoder's bricks. */
cvol_brick_sink cvol_layer_measure_sink(cvol_layer_measure *measure);
/* Call it after layers layer .. end - 1 (of bricks), with the slab that they were encoded from; see
 * cvol_layer_callback for teams. */
int cvol_layer_measure_after(cvol_context *context, void *measure, const cvol_slab *slab,
                             size_t layer, size_t end);

/* After the last layer: sets the array's measured figures, which go into a file's header, and the
 * norms of the subbands (subbands.h). */
void cvol_layer_measure_report(const cvol_layer_measure *measure, cvol_array *array,
                               double subband_norm[CVOL_SUBBANDS]);

#endif
