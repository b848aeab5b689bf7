/* JPEG slices in builds without libturbojpeg. */
#include "base/context.h"
#include "volume/formats/pictures/picture.h"

int cvol_picture_read_jpeg(cvol_context *context, cvol_picture *out, const char *path)
{
    *out = (cvol_picture){0};
    return cvol_fail(context, CVOL_ERROR_UNSUPPORTED,
                     "%s: this build of cvol reads no JPEG files (built without libturbojpeg)",
                     path);
}
