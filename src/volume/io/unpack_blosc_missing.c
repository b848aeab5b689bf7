/* Bytes compressed by blosc, in builds without its library. */
#include "base/context.h"
#include "volume/io/unpack_blosc.h"

int cvol_unpack_blosc(cvol_context *context, void *out, size_t room, const uint8_t *data,
                      size_t size, const char *name)
{
    (void)out, (void)room, (void)data, (void)size;
    return cvol_fail(context, CVOL_ERROR_UNSUPPORTED,
                     "%s: is compressed by blosc, which this build of cvol does not read (built "
                     "without libblosc)",
                     name);
}
