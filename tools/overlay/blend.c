/* Mixes the pictures of overlays into the picture of a volume, pixel by pixel.
 *
 * Let B be the colour of the volume (times its opacity b) at depth d, and O that of an overlay with
 * opacity o, which begins at depth e. The overlay gets the weight
 *
 *     w = 1                                   where it is in front, e <= d
 *     w = 1 - b (1 - exp(-(e - d) / D))       where it is behind, D = --overlay-depth
 *
 * and, with its opacity p of --overlay-opacity, the pixel becomes
 *
 *     B (1 - p w o) + p w O,   b (1 - p w o) + p w o
 *
 * so what shines through keeps its colour, and only its strength tells the depth. w is 1 in
 * modes without depths, and where the volume has no depth because it is faint. Overlays are mixed
 * from back to front. */
#include <math.h>

#include "tools/overlay/overlay.h"

/* The order of the overlays at a pixel, from back to front; equal depths: as given. */
static void sort_by_depth(int order[OVERLAYS_MAX], const overlay_layer *layers, int count, size_t i)
{
    for (int k = 0; k < count; k++) {
        int at = k;
        while (at > 0 && layers[k].picture->depth &&
               layers[order[at - 1]].picture->depth[i] < layers[k].picture->depth[i]) {
            order[at] = order[at - 1];
            at--;
        }
        order[at] = k;
    }
}

static float weight_of(const cvol_image *image, const cvol_image *picture, double depth, size_t i)
{
    if (!image->depth || !picture->depth || !isfinite(image->depth[i]))
        return 1;
    const float behind = picture->depth[i] - image->depth[i];
    if (!(behind > 0))
        return 1;
    const double seen = depth > 0 && isfinite(behind) ? exp(-(double)behind / depth) : 0;
    const double opacity = fmin(fmax((double)image->values[4 * i + 3], 0), 1);
    return (float)(1 - opacity * (1 - seen));
}

static int is_empty(const float pixel[4])
{
    return !(fabsf(pixel[0]) + fabsf(pixel[1]) + fabsf(pixel[2]) + fabsf(pixel[3]) > 0);
}

void overlay_blend(cvol_image *image, const overlay_layer *layers, int count)
{
    const size_t pixels = (size_t)image->width * (size_t)image->height;
    for (size_t i = 0; i < pixels; i++) {
        int order[OVERLAYS_MAX];
        float *to = image->values + 4 * i;
        sort_by_depth(order, layers, count, i);
        for (int k = 0; k < count; k++) {
            const overlay_layer *layer = &layers[order[k]];
            const float *from = layer->picture->values + 4 * i;
            if (is_empty(from)) /* most pixels */
                continue;
            const float w = (float)layer->opacity *
                            weight_of(image, layer->picture, layer->depth, i);
            for (int c = 0; c < 4; c++)
                to[c] = to[c] * (1 - w * from[3]) + w * from[c];
        }
    }
}
