/* Animated GIF (CompuServe, GIF 89a) by giflib: one palette for all pictures. Each picture after
 * the first has only the box of changed pixels, in which unchanged pixels are transparent.
 */
#include <gif_lib.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/bytes.h"
#include "base/context.h"
#include "base/memory.h"
#include "image/film.h"
#include "image/palette.h"

#define SAME CVOL_PALETTE_MAX /* the index of transparent pixels, which show the picture before */

typedef struct gif {
    cvol_palette *palette;
    int has_palette;
    uint8_t *before, *now, *box; /* indices of whole pictures, and of changed pixels */
    GifFileType *file;
    cvol_bytes bytes; /* written by giflib */
} gif;

static void free_gif(void *state)
{
    gif *g = state;
    if (g->file)
        EGifCloseFile(g->file, NULL);
    cvol_palette_free(g->palette);
    free(g->before);
    free(g->now);
    free(g->box);
    cvol_bytes_free(&g->bytes);
    free(g);
}

static int take_bytes(GifFileType *file, const GifByteType *data, int count)
{
    gif *g = file->UserData;
    cvol_bytes_append(&g->bytes, data, (size_t)count);
    return g->bytes.failed ? 0 : count;
}

static int open_gif(cvol_context *context, cvol_film *film)
{
    const size_t width = (size_t)film->width, height = (size_t)film->height;
    gif *g = calloc(1, sizeof *g);
    if (!g)
        return cvol_fail_memory(context, sizeof *g, "a film");
    film->state = g;
    g->palette = cvol_palette_create();
    g->before = cvol_allocate(width, height);
    g->now = cvol_allocate(width, height);
    g->box = cvol_allocate(width, height);
    g->file = EGifOpen(g, take_bytes, NULL);
    if (!g->palette || !g->before || !g->now || !g->box || !g->file)
        return cvol_fail_memory(context, 3 * width * height, "a film");
    return CVOL_OK;
}

static int sample_palette(cvol_context *context, cvol_film *film, const cvol_image *image)
{
    gif *g = film->state;
    (void)context;
    if (!g->has_palette)
        cvol_palette_count(g->palette, image->rgba, (size_t)image->width * (size_t)image->height);
    return CVOL_OK;
}

/* `status` is giflib's, which fails only without memory. */
static int write_bytes(cvol_context *context, cvol_film *film, int status)
{
    gif *g = film->state;
    if (status != GIF_OK || g->bytes.failed)
        return cvol_fail_memory(context, (size_t)film->width * (size_t)film->height, "a film");
    const int code = cvol_output_write(context, film->output, g->bytes.data, g->bytes.size);
    g->bytes.size = 0;
    return code;
}

/* Writes signature, size, palette, and endless repetition. */
static int put_head(gif *g, const cvol_film *film)
{
    static const uint8_t forever[] = {1, 0, 0};
    ColorMapObject *map = GifMakeMapObject(256, NULL);
    if (!map)
        return GIF_ERROR;
    for (int i = 0; i < cvol_palette_size(g->palette); i++) {
        const uint8_t *rgb = cvol_palette_colour(g->palette, i);
        map->Colors[i] = (GifColorType){rgb[0], rgb[1], rgb[2]};
    }
    EGifSetGifVersion(g->file, true);
    const int put = EGifPutScreenDesc(g->file, film->width, film->height, 8, 0, map) == GIF_OK &&
                    EGifPutExtensionLeader(g->file, APPLICATION_EXT_FUNC_CODE) == GIF_OK &&
                    EGifPutExtensionBlock(g->file, 11, "NETSCAPE2.0") == GIF_OK &&
                    EGifPutExtensionBlock(g->file, sizeof forever, forever) == GIF_OK &&
                    EGifPutExtensionTrailer(g->file) == GIF_OK;
    GifFreeMapObject(map);
    return put ? GIF_OK : GIF_ERROR;
}

typedef struct box {
    int x0, x1, y0, y1; /* up to x1 - 1, y1 - 1 */
} box;

/* The box of different pixels of two pictures; one pixel if there are none. */
static box changed(const gif *g, const cvol_film *film)
{
    box b = {film->width, 0, film->height, 0};
    for (int y = 0; y < film->height; y++)
        for (int x = 0; x < film->width; x++) {
            const size_t i = (size_t)y * (size_t)film->width + (size_t)x;
            if (g->now[i] == g->before[i])
                continue;
            b.x0 = x < b.x0 ? x : b.x0;
            b.x1 = x >= b.x1 ? x + 1 : b.x1;
            b.y0 = y < b.y0 ? y : b.y0;
            b.y1 = y + 1;
        }
    return b.x1 ? b : (box){0, 1, 0, 1};
}

/* Hundredths of a second; rounding keeps the sum right. */
static int delay_of(const cvol_film *film)
{
    const double unit = 100 / film->options.frames_per_second;
    const double delay = round((film->frames + 1) * unit) - round(film->frames * unit);
    return (int)fmin(fmax(delay, 2), 65535);
}

static int put_frame(gif *g, const cvol_film *film, const box *b)
{
    const GraphicsControlBlock control = {
        .DisposalMode = DISPOSE_DO_NOT, .DelayTime = delay_of(film), .TransparentColor = SAME};
    GifByteType extension[4];
    const int width = b->x1 - b->x0, height = b->y1 - b->y0;
    const int size = (int)EGifGCBToExtension(&control, extension);
    if (EGifPutExtension(g->file, GRAPHICS_EXT_FUNC_CODE, size, extension) != GIF_OK ||
        EGifPutImageDesc(g->file, b->x0, b->y0, width, height, false, NULL) != GIF_OK)
        return GIF_ERROR;
    for (int y = 0; y < height; y++)
        if (EGifPutLine(g->file, g->box + (size_t)y * (size_t)width, width) != GIF_OK)
            return GIF_ERROR;
    return GIF_OK;
}

static int is_opaque(const cvol_image *image)
{
    const size_t pixels = (size_t)image->width * (size_t)image->height;
    for (size_t i = 0; i < pixels; i++)
        if (image->rgba[4 * i + 3] != 255)
            return 0;
    return 1;
}

static int add_gif(cvol_context *context, cvol_film *film, const cvol_image *image)
{
    gif *g = film->state;
    if (!is_opaque(image))
        return cvol_fail(context, CVOL_ERROR_ARGUMENT,
                         "%s: a GIF has no pixels that are partly transparent", film->path);
    if (!g->has_palette) {
        if (!cvol_palette_choose(g->palette))
            return cvol_fail_memory(context, 1 << 17, "a palette");
        g->has_palette = 1;
        if (put_head(g, film) != GIF_OK)
            return write_bytes(context, film, GIF_ERROR);
    }
    const size_t width = (size_t)film->width;
    for (int y = 0; y < film->height; y++)
        cvol_palette_map(g->palette, g->now + (size_t)y * width,
                         image->rgba + 4 * (size_t)y * width, film->width, y);
    const box b = film->frames ? changed(g, film) : (box){0, film->width, 0, film->height};
    uint8_t *out = g->box;
    for (int y = b.y0; y < b.y1; y++)
        for (int x = b.x0; x < b.x1; x++) {
            const size_t i = (size_t)y * width + (size_t)x;
            *out++ = film->frames && g->now[i] == g->before[i] ? SAME : g->now[i];
        }
    const int status = put_frame(g, film, &b);
    uint8_t *kept = g->before;
    g->before = g->now;
    g->now = kept;
    return write_bytes(context, film, status);
}

static int finish_gif(cvol_context *context, cvol_film *film)
{
    gif *g = film->state;
    const int status = EGifCloseFile(g->file, NULL);
    g->file = NULL;
    return write_bytes(context, film, status);
}

const cvol_film_format cvol_film_gif = {.ending = ".gif",
                                        .name = "GIF",
                                        .needs_palette = 1,
                                        .size_max = CVOL_IMAGE_SIZE_MAX,
                                        .rate_max = 50,
                                        .open = open_gif,
                                        .sample_palette = sample_palette,
                                        .add = add_gif,
                                        .finish = finish_gif,
                                        .free = free_gif};
