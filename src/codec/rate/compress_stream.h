/* Compresses samples that are read slab by slab: into a part of a file, or with a number of
 * estimated bricks that only tests set. */
#ifndef CVOL_CODEC_RATE_COMPRESS_STREAM_H
#define CVOL_CODEC_RATE_COMPRESS_STREAM_H

#include "base/file.h"
#include "base/team.h"
#include "cvol/codec.h"

/* Works as cvol_compress_stream. If a volume has at least twice `estimated` bricks, it first
 * estimates the result on `estimated` bricks or slightly more. */
int cvol_compress_stream_estimating(cvol_context *context, cvol_compress_report *report,
                                    const char *path, const cvol_sample_source *source,
                                    const cvol_grid *grid, const cvol_compress_options *options,
                                    size_t estimated);

/* Works as cvol_compress_stream, but writes a part of an output, from the output's current
 * position. */
int cvol_compress_stream_within(cvol_context *context, cvol_compress_report *report,
                                cvol_output *output, const cvol_sample_source *source,
                                const cvol_grid *grid, const cvol_compress_options *options);

/* Works as cvol_compress_stream, by the processes of a team: each reads and encodes every size-th
 * layer of bricks, and the first writes the file, which has the same bytes as that of one process.
 * estimated: as above, 0: as cvol_compress_stream. Errors: those of the first process that failed.
 */
int cvol_compress_stream_by_team(cvol_context *context, cvol_compress_report *report,
                                 const char *path, const cvol_sample_source *source,
                                 const cvol_grid *grid, const cvol_compress_options *options,
                                 size_t estimated, cvol_team *team);

#endif
