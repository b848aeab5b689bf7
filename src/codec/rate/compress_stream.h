/* Compresses samples that are read slab by slab: into a part of a file, or by several processes. */
#ifndef CVOL_CODEC_RATE_COMPRESS_STREAM_H
#define CVOL_CODEC_RATE_COMPRESS_STREAM_H

#include "base/file.h"
#include "base/team.h"
#include "cvol/codec.h"

/* Works as cvol_compress_stream, but writes a part of an output, from the output's current
 * position. */
int cvol_compress_stream_within(cvol_context *context, cvol_compress_report *report,
                                cvol_output *output, const cvol_sample_source *source,
                                const cvol_grid *grid, const cvol_compress_options *options);

/* How samples are compressed slab by slab; all zero: by one process. */
typedef struct cvol_stream_work {
    /* Only tests set these two. If a volume has at least twice `estimated` bricks, the result is
     * first estimated on `estimated` bricks or slightly more. strip_bytes: the samples of a strip
     * (codec/brick/slab_source.h). */
    size_t estimated, strip_bytes;
    cvol_team *team; /* the processes, or NULL */
} cvol_stream_work;

/* Works as cvol_compress_stream. Of the processes of a team each reads and encodes every size-th
 * strip of bricks, and the first writes the file, which has the same bytes as that of one process.
 * Errors: those of the first process that failed. */
int cvol_compress_stream_by(cvol_context *context, cvol_compress_report *report, const char *path,
                            const cvol_sample_source *source, const cvol_grid *grid,
                            const cvol_compress_options *options, const cvol_stream_work *work);

#endif
