/* Chunks of codec cvol, in builds without the codec: fuzzers of volume formats. */
#include "base/context.h"
#include "volume/formats/zarr/chunk.h"

int cvol_zarr_decode_cvol(cvol_context *context, void *out, const cvol_zarr_array *array,
                          const uint8_t *data, size_t size, const char *name)
{
    (void)out, (void)array, (void)data, (void)size;
    return cvol_fail(context, CVOL_ERROR_UNSUPPORTED,
                     "%s: is compressed by codec cvol, which this build does not read", name);
}
