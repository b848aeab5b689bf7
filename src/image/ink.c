/* Strokes (ink.h): the cover of a pixel depends on the distance of its middle to the nearest
 * segment, and falls from 1 to 0 within one pixel. */
#include "image/ink.h"

#include <math.h>

static float squared_distance(const cvol_segment *s, float x, float y)
{
    const float dx = s->x1 - s->x0, dy = s->y1 - s->y0, length = dx * dx + dy * dy;
    float t = length > 0 ? ((x - s->x0) * dx + (y - s->y0) * dy) / length : 0;
    t = t < 0 ? 0 : t > 1 ? 1 : t;
    const float rx = x - s->x0 - t * dx, ry = y - s->y0 - t * dy;
    return rx * rx + ry * ry;
}

static void blend(cvol_image *image, int x, int y, const float rgb[3], float cover)
{
    float *pixel = image->values + 4 * ((size_t)y * (size_t)image->width + (size_t)x);
    for (int c = 0; c < 3; c++)
        pixel[c] += cover * (rgb[c] - pixel[c]);
    pixel[3] += cover * (1 - pixel[3]);
}

static int within(double value, int most)
{
    return value < 0 ? 0 : value > most ? most : (int)value;
}

/* All within `radius` of a segment. */
static void paint(cvol_image *image, const cvol_segment *segments, int count, float radius,
                  const float rgb[3], float opacity)
{
    float x0 = INFINITY, y0 = INFINITY, x1 = -INFINITY, y1 = -INFINITY;
    for (int i = 0; i < count; i++) {
        const cvol_segment *s = &segments[i];
        x0 = fminf(x0, fminf(s->x0, s->x1));
        y0 = fminf(y0, fminf(s->y0, s->y1));
        x1 = fmaxf(x1, fmaxf(s->x0, s->x1));
        y1 = fmaxf(y1, fmaxf(s->y0, s->y1));
    }
    const int left = within(x0 - radius - 1, image->width),
              top = within(y0 - radius - 1, image->height);
    const int right = within(x1 + radius + 2, image->width);
    const int bottom = within(y1 + radius + 2, image->height);
    for (int y = top; y < bottom; y++)
        for (int x = left; x < right; x++) {
            float least = INFINITY;
            for (int i = 0; i < count; i++)
                least = fminf(least,
                              squared_distance(&segments[i], (float)x + 0.5f, (float)y + 0.5f));
            const float cover = radius + 0.5f - sqrtf(least);
            if (cover > 0)
                blend(image, x, y, rgb, opacity * (cover < 1 ? cover : 1));
        }
}

void cvol_ink_halo(cvol_image *image, const cvol_segment *segments, int count, const cvol_pen *pen)
{
    if (pen->halo > 0)
        paint(image, segments, count, pen->width / 2 + pen->halo, pen->ground, pen->ground_opacity);
}

void cvol_ink_stroke(cvol_image *image, const cvol_segment *segments, int count,
                     const cvol_pen *pen)
{
    paint(image, segments, count, pen->width / 2, pen->rgb, pen->opacity);
}

void cvol_ink_mask(cvol_image *image, const unsigned char *shares, int width, int height, int x,
                   int y, const cvol_pen *pen)
{
    for (int j = y < 0 ? -y : 0; j < height && y + j < image->height; j++)
        for (int i = x < 0 ? -x : 0; i < width && x + i < image->width; i++) {
            const float share = (float)shares[(size_t)j * (size_t)width + (size_t)i] / 255;
            if (share > 0)
                blend(image, x + i, y + j, pen->rgb, pen->opacity * share);
        }
}

/* The share of pixel `at` that lies within from .. to. */
static float share(int at, double from, double to)
{
    const double covered = fmin(to, at + 1) - fmax(from, at);
    return covered > 0 ? (float)covered : 0;
}

void cvol_ink_box(cvol_image *image, double x0, double y0, double x1, double y1, const float rgb[3],
                  float opacity)
{
    for (int y = within(y0, image->height); y < image->height && y < y1; y++)
        for (int x = within(x0, image->width); x < image->width && x < x1; x++)
            blend(image, x, y, rgb, opacity * share(x, x0, x1) * share(y, y0, y1));
}
