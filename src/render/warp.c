/* The last step: from the intermediate image, which lies in the plane of sheet 0, to the picture,
 * by Catmull-Rom interpolation (Catmull and Rom 1974), 4 x 4 taps a pixel. */
#include <math.h>
#include <string.h>

#include "render/sheet.h"

/* Weights of the samples at -1, 0, 1, 2 for a point at t in 0..1. */
static void catmull_rom(float weights[4], float t)
{
    weights[0] = ((-0.5f * t + 1) * t - 0.5f) * t;
    weights[1] = (1.5f * t - 2.5f) * t * t + 1;
    weights[2] = ((-1.5f * t + 2) * t + 0.5f) * t;
    weights[3] = (0.5f * t - 0.5f) * t * t;
}

/* The four lines' values at pixel coordinates (u, v) of the intermediate image; `empty` is what
 * lies around it. 0 where all taps fall outside. */
static int sample_lines(float out[4], const cvol_intermediate *image, const float empty[4],
                        double u, double v)
{
    double column = floor(u), row = floor(v);
    if (!(column >= -2 && column <= image->width && row >= -2 && row <= image->height))
        return 0;
    float across[4], down[4];
    catmull_rom(across, (float)(u - column));
    catmull_rom(down, (float)(v - row));
    const int i0 = (int)column - 1, j0 = (int)row - 1;
    memset(out, 0, 4 * sizeof *out);
    for (int dj = 0; dj < 4; dj++) {
        const int j = j0 + dj;
        const float *line = image->lines + (size_t)j * 4 * (size_t)image->width;
        for (int di = 0; di < 4; di++) {
            const int i = i0 + di;
            const float weight = across[di] * down[dj];
            const int inside = j >= 0 && j < image->height && i >= 0 && i < image->width;
            for (int k = 0; k < 4; k++)
                out[k] += weight * (inside ? line[k * image->width + i] : empty[k]);
        }
    }
    return 1;
}

static uint8_t to_byte(double value)
{
    return (uint8_t)(value <= 0 ? 0 : value >= 1 ? 255 : 255 * value + 0.5);
}

/* Intermediate pixel coordinates of picture pixel (x, y). */
static void locate(double out[2], const cvol_sheet_plan *plan, int x, int y)
{
    out[0] = (plan->warp[0][0] + x * plan->warp[0][1] + y * plan->warp[0][2] - plan->u0) / plan->du;
    out[1] = (plan->warp[1][0] + x * plan->warp[1][1] + y * plan->warp[1][2] - plan->v0) / plan->dv;
}

void cvol_warp_composite(cvol_image *image, const cvol_intermediate *intermediate,
                         const cvol_sheet_plan *plan, const double background[3], int threads)
{
    static const float empty[4] = {0, 0, 0, 1};
#pragma omp parallel for num_threads(threads) schedule(static)
    for (int y = 0; y < image->height; y++)
        for (int x = 0; x < image->width; x++) {
            double at[2];
            float v[4];
            locate(at, plan, x, y);
            if (!sample_lines(v, intermediate, empty, at[0], at[1]))
                memcpy(v, empty, sizeof v);
            uint8_t *pixel = image->rgba + 4 * ((size_t)y * (size_t)image->width + (size_t)x);
            double through = v[3] < 0 ? 0 : v[3] > 1 ? 1 : (double)v[3];
            for (int k = 0; k < 3; k++)
                pixel[k] = to_byte((double)v[k] + through * background[k]);
            pixel[3] = 255;
        }
}

void cvol_warp_grey(cvol_image *image, const cvol_intermediate *intermediate,
                    const cvol_sheet_plan *plan, double lo, double hi, const double background[3],
                    int threads)
{
    static const float empty[4] = {0, 0, 0, 0};
    const double scale = hi > lo ? 1 / (hi - lo) : 1;
#pragma omp parallel for num_threads(threads) schedule(static)
    for (int y = 0; y < image->height; y++)
        for (int x = 0; x < image->width; x++) {
            double at[2];
            float v[4];
            locate(at, plan, x, y);
            uint8_t *pixel = image->rgba + 4 * ((size_t)y * (size_t)image->width + (size_t)x);
            int hit = sample_lines(v, intermediate, empty, at[0], at[1]) && v[1] > 0.5f;
            double grey = hit ? ((double)v[0] / (double)v[1] - lo) * scale : 0;
            for (int k = 0; k < 3; k++)
                pixel[k] = to_byte(hit ? grey : background[k]);
            pixel[3] = 255;
        }
}
