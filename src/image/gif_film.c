/* Animated GIF (CompuServe, GIF 89a): one palette for all pictures, of which each after the first
 * shows only the box in which something changed, and there pixels that did not are transparent. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/bytes.h"
#include "base/context.h"
#include "base/memory.h"
#include "image/film.h"
#include "image/gif_lzw.h"
#include "image/palette.h"

#define SAME CVOL_PALETTE_MAX /* the index that lets the picture before show through */

typedef struct gif {
    cvol_palette *palette;
    int learnt;
    uint8_t *before, *now, *box; /* indices of whole pictures, and of what changed */
    cvol_bytes bytes;
} gif;

static void free_gif(void *state)
{
    gif *g = state;
    cvol_palette_free(g->palette);
    free(g->before);
    free(g->now);
    free(g->box);
    cvol_bytes_free(&g->bytes);
    free(g);
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
    if (!g->palette || !g->before || !g->now || !g->box)
        return cvol_fail_memory(context, 3 * width * height, "a film");
    return CVOL_OK;
}

static int learn_gif(cvol_context *context, cvol_film *film, const cvol_image *image)
{
    gif *g = film->state;
    (void)context;
    if (!g->learnt)
        cvol_palette_count(g->palette, image->rgba, (size_t)image->width * (size_t)image->height);
    return CVOL_OK;
}

static int write_bytes(cvol_context *context, cvol_film *film)
{
    gif *g = film->state;
    if (g->bytes.failed)
        return cvol_fail_memory(context, (size_t)film->width * (size_t)film->height, "a film");
    const int code = cvol_output_write(context, film->output, g->bytes.data, g->bytes.size);
    g->bytes.size = 0;
    return code;
}

/* Signature, size, palette, and that it runs for ever. */
static void put_head(cvol_bytes *bytes, const cvol_film *film, const cvol_palette *palette)
{
    static const uint8_t black[3] = {0, 0, 0};
    static const uint8_t forever[] = {3, 1, 0, 0, 0};
    cvol_bytes_put_text(bytes, "GIF89a");
    cvol_bytes_put_u16(bytes, (uint16_t)film->width);
    cvol_bytes_put_u16(bytes, (uint16_t)film->height);
    cvol_bytes_put_u8(bytes, 0xf7); /* a palette of 256, 8 bits a channel */
    cvol_bytes_put_u16(bytes, 0);
    for (int i = 0; i < 256; i++)
        cvol_bytes_append(
            bytes, i < cvol_palette_size(palette) ? cvol_palette_colour(palette, i) : black, 3);
    cvol_bytes_put_u8(bytes, 0x21);
    cvol_bytes_put_u8(bytes, 0xff);
    cvol_bytes_put_u8(bytes, 11);
    cvol_bytes_put_text(bytes, "NETSCAPE2.0");
    cvol_bytes_append(bytes, forever, sizeof forever);
}

typedef struct box {
    int x0, x1, y0, y1; /* up to x1 - 1, y1 - 1 */
} box;

/* Where pictures differ; a pixel where they do not. */
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

/* Hundredths of a second, so that the sum is right. */
static uint16_t delay_of(const cvol_film *film)
{
    const double unit = 100 / film->options.frames_per_second;
    const double delay = round((film->frames + 1) * unit) - round(film->frames * unit);
    return (uint16_t)fmin(fmax(delay, 2), 65535);
}

static void put_frame(cvol_bytes *bytes, const cvol_film *film, const box *b,
                      const uint8_t *indices)
{
    cvol_bytes_put_u8(bytes, 0x21);
    cvol_bytes_put_u8(bytes, 0xf9);
    cvol_bytes_put_u8(bytes, 4);
    cvol_bytes_put_u8(bytes, 0x05); /* stays when the next one comes; has a transparent index */
    cvol_bytes_put_u16(bytes, delay_of(film));
    cvol_bytes_put_u8(bytes, SAME);
    cvol_bytes_put_u8(bytes, 0);
    cvol_bytes_put_u8(bytes, 0x2c);
    cvol_bytes_put_u16(bytes, (uint16_t)b->x0);
    cvol_bytes_put_u16(bytes, (uint16_t)b->y0);
    cvol_bytes_put_u16(bytes, (uint16_t)(b->x1 - b->x0));
    cvol_bytes_put_u16(bytes, (uint16_t)(b->y1 - b->y0));
    cvol_bytes_put_u8(bytes, 0);
    cvol_gif_lzw(bytes, indices, (size_t)(b->x1 - b->x0) * (size_t)(b->y1 - b->y0));
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
    if (!g->learnt) {
        if (!cvol_palette_choose(g->palette))
            return cvol_fail_memory(context, 1 << 17, "a palette");
        g->learnt = 1;
        put_head(&g->bytes, film, g->palette);
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
    put_frame(&g->bytes, film, &b, g->box);
    uint8_t *kept = g->before;
    g->before = g->now;
    g->now = kept;
    return write_bytes(context, film);
}

static int finish_gif(cvol_context *context, cvol_film *film)
{
    gif *g = film->state;
    cvol_bytes_put_u8(&g->bytes, 0x3b);
    return write_bytes(context, film);
}

const cvol_film_format cvol_film_gif = {.ending = ".gif",
                                        .learns = 1,
                                        .size_max = CVOL_IMAGE_SIZE_MAX,
                                        .rate_max = 50,
                                        .open = open_gif,
                                        .learn = learn_gif,
                                        .add = add_gif,
                                        .finish = finish_gif,
                                        .free = free_gif};
