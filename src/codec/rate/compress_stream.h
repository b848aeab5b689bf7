/* Compressing samples that are read slab by slab: into a part of a file, or with a choice that only
 * tests make. */
#ifndef CVOL_CODEC_RATE_COMPRESS_STREAM_H
#define CVOL_CODEC_RATE_COMPRESS_STREAM_H

#include "base/file.h"
#include "cvol/codec.h"

/* cvol_compress_stream; before the first pass, estimates are made of `estimated` bricks or some
 * more, of volumes that have twice as many. */
int cvol_compress_stream_estimating(cvol_context *context, cvol_compress_report *report,
                                    const char *path, const cvol_sample_source *source,
                                    const cvol_grid *grid, const cvol_compress_options *options,
                                    size_t estimated);

/* cvol_compress_stream as a part of an output, from where that is. */
int cvol_compress_stream_within(cvol_context *context, cvol_compress_report *report,
                                cvol_output *output, const cvol_sample_source *source,
                                const cvol_grid *grid, const cvol_compress_options *options);

#endif
