/* Measures a volume's distance from its samples strip by strip (slab_source.h), while it is
 * encoded, so that neither all samples nor all terms need memory.
 *
 * Bricks' bytes pass through a sink. After each strip it decodes them and compares the samples that
 * do not depend on later strips. In lapped volumes the strip's last two rows and slices depend on
 * them, and are compared with later strips. */
#ifndef CVOL_CODEC_RATE_STRIP_MEASURE_H
#define CVOL_CODEC_RATE_STRIP_MEASURE_H

#include "codec/brick/bricks.h"
#include "codec/brick/slab_source.h"
#include "codec/rate/measure.h"

typedef struct cvol_strip_measure cvol_strip_measure;

/* Makes a measure for a volume of this shape (grid, block, lapped, offset, range of values),
 * encoded with this step and these tables, which must outlive it, from this source. Bytes go on to
 * `sink`. In the source's team each process measures its own strips, and all get the results.
 * Errors: MEMORY, LIMIT. */
int cvol_strip_measure_make(cvol_context *context, cvol_strip_measure **out,
                            const cvol_array *shape, double step, const cvol_token_tables *tables,
                            const cvol_brick_sink *sink, const cvol_slab_source *source);
void cvol_strip_measure_free(cvol_strip_measure *measure); /* NULL is allowed */

/* The sink that receives the encoder's bricks. */
cvol_brick_sink cvol_strip_measure_sink(cvol_strip_measure *measure);
/* Call it after a strip, with the slab that it was encoded from; see cvol_strip_callback for
 * teams. */
int cvol_strip_measure_after(cvol_context *context, void *measure, const cvol_slab *slab,
                             const cvol_strip *strip);

/* After the last strip: sets the array's measured figures, which go into a file's header, and the
 * norms of the subbands (subbands.h). */
void cvol_strip_measure_report(const cvol_strip_measure *measure, cvol_array *array,
                               double subband_norm[CVOL_SUBBANDS]);

#endif
