/* Writes projections: a volume with one slice for each, or numbered grey pictures. */
#include "tools/render/render_projections.h"

#include <stdlib.h>
#include <string.h>

#include "tools/render/render_picture.h"

int is_numbered(const char *output)
{
    return has_ending(output, ".png") && strstr(output, "{n}");
}

static char *name_of(const projection_writer *w, size_t number)
{
    return output_name(w->output, NULL, (int)number + 1, w->digits);
}

static int open_pictures(cvol_context *context, projection_writer *w, const render_arguments *a,
                         const scene *s, size_t count)
{
    for (w->digits = 1; count >= 10; count /= 10)
        w->digits++;
    int code = cvol_renderer_get_range(context, w->range, s->renderer);
    if (a->window_text)
        memcpy(w->range, s->options.window, sizeof w->range);
    if (!code && w->bits == 16)
        code = cvol_image_create_float(context, &w->image, s->options.width, s->options.height);
    else if (!code)
        code = cvol_image_create(context, &w->image, s->options.width, s->options.height);
    return code;
}

int open_projections(cvol_context *context, projection_writer *w, const render_arguments *a,
                     const scene *s, const cvol_grid *grid)
{
    *w = (projection_writer){.output = a->output, .bits = a->bits};
    cvol_context_hold_outputs(context); /* all of them, or none */
    return is_numbered(a->output) ? open_pictures(context, w, a, s, grid->dims[2])
                                  : cvol_volume_writer_open(context, &w->sink, a->output, grid);
}

/* Grey levels, linear in the window. */
static void paint(cvol_image *image, const float *slice, const double range[2])
{
    const size_t pixels = (size_t)image->width * (size_t)image->height;
    const double width = range[1] - range[0];
    for (size_t i = 0; i < pixels; i++) {
        double level = width > 0 ? ((double)slice[i] - range[0]) / width : 0;
        level = level > 0 ? level < 1 ? level : 1 : 0;
        for (size_t c = 0; c < 4; c++)
            if (image->values)
                image->values[4 * i + c] = c < 3 ? (float)level : 1;
            else
                image->rgba[4 * i + c] = c < 3 ? (uint8_t)(level * 255 + 0.5) : 255;
    }
}

static int write_picture_of(cvol_context *context, projection_writer *w, const float *slice)
{
    const double black[3] = {0, 0, 0};
    char *name = name_of(w, w->written);
    if (!name) {
        w->lacks_memory = 1;
        return CVOL_ERROR_MEMORY;
    }
    paint(w->image, slice, w->range);
    const int code = w->bits == 16 ? cvol_image_write_png16(context, w->image, black, 1, name)
                                   : cvol_image_write_png(context, w->image, name);
    free(name);
    return code;
}

int write_projections(cvol_context *context, projection_writer *w, const float *slices,
                      size_t count)
{
    if (w->sink)
        return cvol_volume_writer_write(context, w->sink, slices, count);
    const size_t pixels = (size_t)w->image->width * (size_t)w->image->height;
    int code = CVOL_OK;
    for (size_t i = 0; i < count && !code; i++) {
        code = write_picture_of(context, w, slices + i * pixels);
        w->written += !code;
    }
    return code;
}

int close_projections(cvol_context *context, projection_writer *w, int code)
{
    if (!code && w->sink)
        code = cvol_volume_writer_commit(context, w->sink);
    else if (w->sink)
        cvol_volume_writer_abandon(w->sink);
    code = cvol_context_release_outputs(context, code);
    cvol_image_free(w->image);
    return code;
}
