/* Reading PNG files in builds without libpng: fails. */
#include "cvol/image.h"

#include "base/context.h"

int cvol_image_read_png(cvol_context *context, cvol_image **out, const char *path)
{
    *out = NULL;
    return cvol_fail(context, CVOL_ERROR_UNSUPPORTED,
                     "%s: this build of cvol reads no PNG files (built without libpng)", path);
}
