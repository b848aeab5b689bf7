/* Window and level of grey pictures: grey becomes linear over another range than that of the
 * samples. Pixels whose ray met no sample stay empty. */
#include "render/engine/engine.h"

void cvol_window_apply(cvol_image *image, const double range[2], const double window[2])
{
    const size_t pixels = (size_t)image->width * (size_t)image->height;
    const double width = window[1] - window[0];
    const float scale = (float)((range[1] - range[0]) / width);
    const float first = (float)((range[0] - window[0]) / width);
    for (size_t i = 0; i < pixels; i++) {
        float *pixel = image->values + 4 * i;
        for (int c = 0; c < 3; c++)
            pixel[c] = scale * pixel[c] + first * pixel[3];
    }
}

void cvol_window_of_cuts(double window[2], const cvol_render_options *options, double min,
                         double max)
{
    const int is_given = options->window[1] > options->window[0];
    window[0] = is_given ? options->window[0] : min;
    window[1] = is_given ? options->window[1] : max;
    if (!(window[1] > window[0])) /* one value: white */
        window[0] = window[1] - 1;
}
