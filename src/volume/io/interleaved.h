/* Files of colours: several bytes per voxel, of which one is a channel. */
#ifndef CVOL_VOLUME_IO_INTERLEAVED_H
#define CVOL_VOLUME_IO_INTERLEAVED_H

#include "volume/io/stored.h"

/* Makes byte `channel` of `channels` the grid's samples, of type uint8. Voxels lie in the file
 * `path`, from `skip` on, which counts after inflating if the file is gzip; `name` begins messages.
 * All are held in memory: the context's limit applies to them. Errors: IO, FORMAT, LIMIT,
 * MEMORY. */
int cvol_interleaved_read(cvol_context *context, cvol_stored *stored, const cvol_grid *grid,
                          const char *path, const char *name, int is_gzip, uint64_t skip,
                          size_t channels, size_t channel);

#endif
