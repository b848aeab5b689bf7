/* Depths: the distance before the eye at which the opacity along a ray passes one half.
 *
 * Kernels give these places as slice numbers, in the intermediate image. For a pixel of the picture
 * the four pixels around it are interpolated, but only those on the surface of the nearest one: at
 * edges a depth belongs to one side or the other, never between. The ray then converts the place to
 * a distance. */
#include <math.h>

#include "base/thread.h"
#include "render/sheet/frame/frame.h"
#include "render/sheet/warp/row.h"
#include "render/view/view_ray.h"

/* Slices per pixel of the intermediate image: a steeper slope is an edge. */
#define EDGE 4.0

void cvol_sheet_depth_clear(cvol_image *image)
{
    const size_t pixels = (size_t)image->width * (size_t)image->height;
    for (size_t i = 0; i < pixels && image->depth; i++)
        image->depth[i] = INFINITY;
}

/* The place in slices at (u, v) of the intermediate image; infinity if opacity does not reach one
 * half there. */
static double interpolate(const cvol_intermediate *image, double u, double v)
{
    if (!(u > -1 && v > -1 && u < image->width && v < image->height))
        return INFINITY;
    const ptrdiff_t x = (ptrdiff_t)floor(u), y = (ptrdiff_t)floor(v);
    const double s = u - (double)x, t = v - (double)y;
    double weights[4] = {0}, most = 0, opacity = 0, sum = 0, whole = 0;
    float places[4], nearest = INFINITY;
    for (int k = 0; k < 4; k++) {
        const ptrdiff_t i = x + k % 2, j = y + k / 2;
        places[k] = INFINITY;
        if (i < 0 || j < 0 || i >= image->width || j >= image->height)
            continue;
        places[k] = image->depth[cvol_pixel_place(image, 1, 0, i, j)];
        weights[k] = (k % 2 ? s : 1 - s) * (k / 2 ? t : 1 - t);
        opacity += weights[k] * (1 - image->lines[cvol_pixel_place(image, CVOL_LINES, 3, i, j)]);
        if (weights[k] > most && !isinf(places[k])) {
            most = weights[k];
            nearest = places[k];
        }
    }
    if (opacity < 0.5 || isinf(nearest))
        return INFINITY;
    for (int k = 0; k < 4; k++)
        if (fabsf(places[k] - nearest) <= EDGE) {
            sum += weights[k] * places[k];
            whole += weights[k];
        }
    return sum / whole;
}

/* Converts a place in slices to samples along their axis. */
static double find_sample(const cvol_sheet_plan *plan, double place)
{
    const double number = plan->ascending ? place : (double)(plan->sheet_count - 1) - place;
    return plan->first_sheet + number * plan->pitch_sheet;
}

static void draw_line(cvol_image *image, const cvol_intermediate *intermediate,
                      const cvol_sheet_plan *plan, const cvol_view *view, const double spacing[3],
                      int y)
{
    float *out = image->depth + (size_t)y * (size_t)image->width;
    const int c = plan->axis_sheet;
    cvol_warp_places places;
    int begin, end;
    cvol_warp_pixels(&begin, &end, plan, y, image->width);
    for (int first = begin; first < end; first += CVOL_WARP_CHUNK) {
        places.count = end - first < CVOL_WARP_CHUNK ? end - first : CVOL_WARP_CHUNK;
        cvol_warp_locate(&places, plan, y, first);
        for (int i = 0; i < places.count; i++) {
            const double place = interpolate(intermediate, places.u[i], places.v[i]);
            cvol_view_ray ray;
            out[first + i] = INFINITY;
            if (isinf(place) || !cvol_view_ray_make(&ray, view, spacing, first + i, y))
                continue;
            const double t = (find_sample(plan, place) - ray.start[c]) / ray.direction[c];
            out[first + i] = (float)(ray.depth + ray.rise * fmin(fmax(t, ray.near), ray.far));
        }
    }
}

void cvol_sheet_depth_draw(cvol_image *image, const cvol_intermediate *intermediate,
                           const cvol_sheet_plan *plan, const cvol_view *view,
                           const double spacing[3], int threads)
{
#pragma omp parallel for num_threads(threads) schedule(static)
    for (int y = 0; y < image->height; y++)
        draw_line(image, intermediate, plan, view, spacing, y);
}
