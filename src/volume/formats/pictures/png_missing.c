/* PNG slices in builds without libpng. */
#include "base/context.h"
#include "volume/formats/pictures/picture.h"

int cvol_picture_read_png(cvol_context *context, cvol_picture *out, const char *path)
{
    *out = (cvol_picture){0};
    return cvol_fail(context, CVOL_ERROR_UNSUPPORTED,
                     "%s: this build of cvol reads no PNG files (built without libpng)", path);
}
