/* Streams and writers inside the library: ranges of bytes instead of slices, for whole volumes. */
#ifndef CVOL_VOLUME_IO_STREAM_H
#define CVOL_VOLUME_IO_STREAM_H

#include "volume/io/format.h"

/* A stream of a file of this format; grids beyond `limit_bytes` are refused. */
int cvol_stream_begin(cvol_context *context, cvol_volume_stream **out, const cvol_format *format,
                      const char *path, const cvol_read_options *options, uint64_t limit_bytes);
/* Reads `size` bytes of the samples from byte `offset` on: whole samples, in the machine's byte
 * order. */
int cvol_stream_read_bytes(cvol_context *context, cvol_volume_stream *stream, void *out,
                           size_t offset, size_t size);
/* The volume of a stream that holds it in memory as a whole; the caller frees it, and closes the
 * stream. NULL for all others. */
cvol_volume *cvol_stream_take_whole(cvol_volume_stream *stream);

/* Opens a writer of a file of this format; grid and series have been checked. series->labels are
 * only read here. */
int cvol_volume_writer_begin(cvol_context *context, cvol_volume_writer **out,
                             const cvol_format *format, const char *path, const cvol_grid *grid,
                             const cvol_series_options *series, int are_labels);
/* Writes the next `size` bytes of the samples: whole samples, at most as many as are missing. */
int cvol_volume_writer_write_bytes(cvol_context *context, cvol_volume_writer *sink,
                                   const void *data, size_t size);

#endif
