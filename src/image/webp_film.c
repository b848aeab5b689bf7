/* Animated WebP, through libwebp's encoder of animations. */
#include <math.h>
#include <stdlib.h>
#include <webp/encode.h>
#include <webp/mux.h>

#include "base/context.h"
#include "image/film.h"

typedef struct webp {
    WebPAnimEncoder *encoder;
    WebPConfig config;
} webp;

static void free_webp(void *state)
{
    webp *w = state;
    WebPAnimEncoderDelete(w->encoder);
    free(w);
}

static int open_webp(cvol_context *context, cvol_film *film)
{
    WebPAnimEncoderOptions options;
    webp *w = calloc(1, sizeof *w);
    if (!w)
        return cvol_fail_memory(context, sizeof *w, "a film");
    film->state = w;
    if (!WebPAnimEncoderOptionsInit(&options) || !WebPConfigInit(&w->config))
        return cvol_fail(context, CVOL_ERROR_UNSUPPORTED,
                         "%s: libwebp is another one than this build was made with", film->path);
    w->config.lossless = film->options.quality == 100;
    w->config.quality = w->config.lossless ? 50 : (float)film->options.quality;
    w->config.thread_level = 1;
    w->encoder = WebPAnimEncoderNew(film->width, film->height, &options);
    return w->encoder ? CVOL_OK : cvol_fail_memory(context, sizeof *w, "libwebp");
}

static int milliseconds_at(const cvol_film *film, int frame)
{
    return (int)round(frame * 1000 / film->options.frames_per_second);
}

static int fail(cvol_context *context, const cvol_film *film)
{
    const webp *w = film->state;
    /* libwebp reports a lack of memory by many numbers. */
    return cvol_fail(context, CVOL_ERROR_IO, "%s: libwebp failed, probably without memory: %s",
                     film->path, WebPAnimEncoderGetError(w->encoder));
}

static int add_webp(cvol_context *context, cvol_film *film, const cvol_image *image)
{
    webp *w = film->state;
    WebPPicture picture;
    if (!WebPPictureInit(&picture))
        return cvol_fail_memory(context, sizeof picture, "libwebp");
    picture.use_argb = 1;
    picture.width = film->width;
    picture.height = film->height;
    int code = WebPPictureImportRGBA(&picture, image->rgba, 4 * film->width)
                   ? CVOL_OK
                   : cvol_fail_memory(context, 4 * (size_t)film->width * (size_t)film->height,
                                      "libwebp");
    if (!code &&
        !WebPAnimEncoderAdd(w->encoder, &picture, milliseconds_at(film, film->frames), &w->config))
        code = fail(context, film);
    WebPPictureFree(&picture);
    return code;
}

static int finish_webp(cvol_context *context, cvol_film *film)
{
    webp *w = film->state;
    WebPData data;
    WebPDataInit(&data);
    if (!WebPAnimEncoderAdd(w->encoder, NULL, milliseconds_at(film, film->frames), NULL) ||
        !WebPAnimEncoderAssemble(w->encoder, &data))
        return fail(context, film);
    const int code = cvol_output_write(context, film->output, data.bytes, data.size);
    WebPDataClear(&data);
    return code;
}

const cvol_film_format cvol_film_webp = {.ending = ".webp",
                                         .name = "WebP",
                                         .size_max = WEBP_MAX_DIMENSION,
                                         .rate_max = 1000,
                                         .open = open_webp,
                                         .add = add_webp,
                                         .finish = finish_webp,
                                         .free = free_webp};
