/* Bytes compressed by blosc (blosc.org), through its library. */
#include <blosc.h>
#include <string.h>

#include "base/context.h"
#include "volume/io/unpack_blosc.h"

int cvol_unpack_blosc(cvol_context *context, void *out, size_t room, const uint8_t *data,
                      size_t size, const char *name)
{
    size_t stated = 0;
    if (blosc_cbuffer_validate(data, size, &stated) < 0)
        return cvol_fail(context, CVOL_ERROR_FORMAT,
                         "%s: its compressed samples (blosc) are damaged or cut off", name);
    if (stated != room)
        return cvol_fail(context, CVOL_ERROR_FORMAT,
                         "%s: a chunk holds %zu bytes of samples, must hold %zu", name, stated,
                         room);
    const int done = blosc_decompress_ctx(data, out, room, 1);
    if ((done < 0 || (size_t)done != room) && !strcmp(blosc_cbuffer_complib(data), "Snappy"))
        return cvol_fail(context, CVOL_ERROR_FORMAT,
                         "%s: its compressed samples (blosc with Snappy) are damaged, or this "
                         "build's blosc has no Snappy",
                         name);
    if (done < 0 || (size_t)done != room)
        return cvol_fail(context, CVOL_ERROR_FORMAT,
                         "%s: its compressed samples (blosc) are damaged", name);
    return CVOL_OK;
}
