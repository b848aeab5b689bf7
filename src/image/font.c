/* Text (font.h): stb_truetype reads outlines and computes which share of each pixel they cover.
 *
 * It tests few of its allocations, so all its memory comes from one block, large enough for any
 * letter at the font's size. */
#include "image/font.h"

#include <math.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include "base/context.h"

/* For one letter at a time. */
typedef struct memory {
    unsigned char *bytes;
    size_t size, used;
} memory;

static void *take(void *user, size_t size)
{
    memory *m = user;
    const size_t from = (m->used + 15) / 16 * 16;
    if (from > m->size || size > m->size - from)
        return NULL;
    m->used = from + size;
    return m->bytes + from;
}

#define STBTT_malloc(size, user) take(user, size)
#define STBTT_free(pointer, user) ((void)(user))
#define STBTT_assert(condition) ((void)0)
#define STBTT_STATIC
#define STB_TRUETYPE_IMPLEMENTATION
#include <stb_truetype.h>

static const unsigned char inter[] = {
#include "inter.inc"
};

/* For the outline of a letter, flattened, and the edges that cross a row; and, for each pixel of
 * its width, two sums. A letter of the font has at most 200 points. */
#define OUTLINE_BYTES 262144
#define SEGMENTS_MAX 1024
#define CURVE 5 /* straight segments of a curved one */
#define HEIGHT_MAX 1024

struct cvol_font {
    stbtt_fontinfo info;
    memory memory;
    unsigned char *cover; /* of one letter, by pixel */
    int width, height;    /* pixels: the largest letter */
    float scale, halo;    /* pixels per unit of the font; pixels */
    int count;
    cvol_segment segments[SEGMENTS_MAX];
};

int cvol_font_open(cvol_context *context, cvol_font **out, double height)
{
    int x0, y0, x1, y1;
    cvol_font *font = calloc(1, sizeof *font);
    *out = font;
    if (!font)
        return cvol_fail(context, CVOL_ERROR_MEMORY, "not enough memory for letters");
    stbtt_InitFont(&font->info, inter, 0);
    stbtt_GetCodepointBox(&font->info, 'H', &x0, &y0, &x1, &y1);
    const double capital = fmin(fmax(round(height), 1), HEIGHT_MAX);
    font->scale = (float)(capital / y1);
    font->halo = (float)fmax(capital / 8, 1);
    stbtt_GetFontBoundingBox(&font->info, &x0, &y0, &x1, &y1);
    font->width = (int)ceil((double)font->scale * (x1 - x0)) + 2;
    font->height = (int)ceil((double)font->scale * (y1 - y0)) + 2;
    font->memory.size = OUTLINE_BYTES + 16 * (size_t)font->width;
    font->memory.bytes = malloc(font->memory.size);
    font->cover = malloc((size_t)font->width * (size_t)font->height);
    font->info.userdata = &font->memory;
    if (font->memory.bytes && font->cover)
        return CVOL_OK;
    cvol_font_free(font);
    *out = NULL;
    return cvol_fail(context, CVOL_ERROR_MEMORY, "not enough memory for letters");
}

void cvol_font_free(cvol_font *font)
{
    if (!font)
        return;
    free(font->memory.bytes);
    free(font->cover);
    free(font);
}

/* ---- letters of a text ------------------------------------------------------------------ */

/* The next code point of UTF-8; a byte that is none counts as U+FFFD. */
static int next_code(const char **text)
{
    const unsigned char *at = (const unsigned char *)*text;
    const int more = at[0] < 0x80   ? 0
                     : at[0] < 0xc2 ? -1
                     : at[0] < 0xe0 ? 1
                     : at[0] < 0xf0 ? 2
                     : at[0] < 0xf5 ? 3
                                    : -1;
    int code = more < 0 ? 0xfffd : more ? at[0] & (0x3f >> more) : at[0];
    for (int i = 1; i <= more; i++) {
        if ((at[i] & 0xc0) != 0x80) {
            *text += i;
            return 0xfffd;
        }
        code = code << 6 | (at[i] & 0x3f);
    }
    *text += more > 0 ? 1 + more : 1;
    return code;
}

/* The letters of a text, one by one. */
typedef struct letters {
    const char *rest;
    int glyph;
    double x, next; /* pixels: where the letter and the one after it start */
} letters;

static int next_letter(letters *at, cvol_font *font)
{
    const int before = at->glyph;
    int advance;
    if (!*at->rest)
        return 0;
    at->glyph = stbtt_FindGlyphIndex(&font->info, next_code(&at->rest));
    stbtt_GetGlyphHMetrics(&font->info, at->glyph, &advance, NULL);
    const int kern = before ? stbtt_GetGlyphKernAdvance(&font->info, before, at->glyph) : 0;
    at->x = at->next + (double)font->scale * kern;
    at->next = at->x + (double)font->scale * advance;
    return 1;
}

double cvol_text_width(cvol_font *font, const char *text)
{
    letters at = {.rest = text};
    while (next_letter(&at, font))
        ;
    return at.next;
}

/* ---- drawing ---------------------------------------------------------------------------- */

static void add_segment(cvol_font *font, const double p[2], const double q[2])
{
    if (font->count < SEGMENTS_MAX)
        font->segments[font->count++] = (cvol_segment){(float)p[0], (float)p[1], (float)q[0],
                                                       (float)q[1]};
}

/* The outline in segments, for its halo. */
static void flatten(cvol_font *font, const stbtt_vertex *points, int count, double x, double y)
{
    double from[2] = {x, y};
    font->count = 0;
    for (int i = 0; i < count; i++) {
        const stbtt_vertex *v = &points[i];
        const double to[2] = {x + (double)font->scale * v->x, y - (double)font->scale * v->y};
        const double by[2] = {x + (double)font->scale * v->cx, y - (double)font->scale * v->cy};
        const int steps = v->type == STBTT_vmove ? 0 : v->type == STBTT_vcurve ? CURVE : 1;
        double last[2] = {from[0], from[1]};
        for (int k = 1; k <= steps; k++) {
            const double t = (double)k / steps, s = 1 - t;
            double at[2];
            for (int c = 0; c < 2; c++)
                at[c] = steps == 1 ? to[c] : s * s * from[c] + 2 * s * t * by[c] + t * t * to[c];
            add_segment(font, last, at);
            memcpy(last, at, sizeof last);
        }
        memcpy(from, to, sizeof from);
    }
}

static void draw_halo(cvol_image *image, cvol_font *font, int glyph, double x, double y,
                      const cvol_pen *pen)
{
    stbtt_vertex *points = NULL;
    font->memory.used = 0;
    const int count = stbtt_GetGlyphShape(&font->info, glyph, &points);
    flatten(font, points, count, x, y);
    if (font->count)
        cvol_ink_halo(image, font->segments, font->count, pen);
}

static void draw_letter(cvol_image *image, cvol_font *font, int glyph, double x, double y,
                        const cvol_pen *pen)
{
    int x0, y0, x1, y1;
    const double left = floor(x);
    const float shift = (float)(x - left);
    stbtt_GetGlyphBitmapBoxSubpixel(&font->info, glyph, font->scale, font->scale, shift, 0, &x0,
                                    &y0, &x1, &y1);
    const int width = x1 - x0, height = y1 - y0;
    if (width <= 0 || height <= 0 || width > font->width || height > font->height)
        return;
    font->memory.used = 0;
    memset(font->cover, 0, (size_t)width * (size_t)height);
    stbtt_MakeGlyphBitmapSubpixel(&font->info, font->cover, width, height, width, font->scale,
                                  font->scale, shift, 0, glyph);
    cvol_ink_mask(image, font->cover, width, height, (int)left + x0, (int)y + y0, pen);
}

void cvol_text_draw(cvol_image *image, cvol_font *font, const char *text, double x, double y,
                    const cvol_pen *pen)
{
    cvol_pen own = *pen;
    own.width = 0;
    own.halo = font->halo;
    y = round(y);
    for (letters at = {.rest = text}; next_letter(&at, font);)
        draw_halo(image, font, at.glyph, x + at.x, y, &own);
    for (letters at = {.rest = text}; next_letter(&at, font);)
        draw_letter(image, font, at.glyph, x + at.x, y, &own);
}
