/* Writing WebP files in builds without libwebp: fails. */
#include "base/context.h"
#include "image/photo.h"

int cvol_photo_write_webp(cvol_context *context, const cvol_image *image, int quality,
                          const char *path)
{
    (void)image;
    (void)quality;
    return cvol_fail(context, CVOL_ERROR_UNSUPPORTED,
                     "%s: this build of cvol writes no WebP files (built without libwebp)", path);
}
