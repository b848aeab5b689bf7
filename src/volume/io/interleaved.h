/* Files of colours: several bytes per voxel, of which one is a channel. */
#ifndef CVOL_VOLUME_IO_INTERLEAVED_H
#define CVOL_VOLUME_IO_INTERLEAVED_H

#include "volume/io/strided.h"

/* cvol_strided_read for a stream of gzip or zlib that begins at byte `at` of the file; `skip` bytes
 * of it are before the elements. */
int cvol_strided_inflate(cvol_context *context, cvol_stored *stored, cvol_strided *strided,
                         const cvol_grid *grid, const char *path, uint64_t at, uint64_t skip,
                         size_t count);

/* Makes byte `channel` of `channels` the grid's samples, of type uint8. Voxels lie in the file
 * `path`, from `skip` on, which counts after inflating if the file is gzip; `name` begins messages.
 * All are held in memory: the context's limit applies to them. Errors: IO, FORMAT, LIMIT,
 * MEMORY. */
int cvol_interleaved_read(cvol_context *context, cvol_stored *stored, const cvol_grid *grid,
                          const char *path, const char *name, int is_gzip, uint64_t skip,
                          size_t channels, size_t channel);

#endif
