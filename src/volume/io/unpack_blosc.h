/* Bytes compressed by blosc (blosc.org). */
#ifndef CVOL_VOLUME_IO_UNPACK_BLOSC_H
#define CVOL_VOLUME_IO_UNPACK_BLOSC_H

#include "cvol/base.h"

/* Unpacks into exactly `room` bytes. `name` begins messages. Threads may call it at once, each with
 * its own context. Errors: FORMAT, UNSUPPORTED (in builds without its library). */
int cvol_unpack_blosc(cvol_context *context, void *out, size_t room, const uint8_t *data,
                      size_t size, const char *name);

#endif
