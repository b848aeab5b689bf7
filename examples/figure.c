/* Pictures for publications: a figure with scale bar, axes and values on a white background; the
 * same without background and with 16 bits; and an animation of a turn.
 *
 * It renders pictures as floats (colour times opacity, and opacity), draws annotations over them,
 * and then converts them for the file. It writes figure.png, figure_clear.png and figure_turn.gif.
 * usage: figure samples/ch2better.nii.gz */
#include "example.h"

#define FRAMES 12

typedef struct stage {
    cvol_context *context;
    cvol_array *array;
    cvol_renderer *renderer;
    cvol_transfer *transfer;
    cvol_render_options options;
} stage;

static stage set_up(cvol_context *context, const char *path)
{
    stage s = {.context = context, .options = cvol_render_options_defaults()};
    cvol_compress_options compression = cvol_compress_options_defaults();
    cvol_histogram histogram;
    cvol_volume *volume;
    must(context, cvol_volume_read(context, &volume, path, NULL));
    compression.effort = CVOL_EFFORT_FAST;
    must(context,
         cvol_compress(context, &s.array, NULL, volume->data, &volume->grid, &compression));
    cvol_volume_free(volume);
    must(context, cvol_array_compute_histogram(context, &histogram, s.array));
    must(context, cvol_transfer_create_named(context, &s.transfer, "auto", &histogram));
    must(context, cvol_renderer_create(context, &s.renderer, CVOL_ENGINE_SHEET,
                                       CVOL_SOURCE(.array = s.array)));
    must(context, cvol_renderer_set_transfer(context, s.renderer, s.transfer));
    s.options.camera.zoom = 1.5;
    return s;
}

/* Renders from the front, turned by some degrees; left and right as in the patient. */
static cvol_image *look(stage *s, int size, double turn_deg)
{
    cvol_image *image;
    int mirrored;
    s->options.width = s->options.height = size;
    must(s->context, cvol_camera_set_view(s->context, &s->options.camera, &mirrored, "front",
                                          cvol_array_grid(s->array), turn_deg));
    must(s->context, cvol_image_create_float(s->context, &image, size, size));
    must(s->context, cvol_renderer_render(s->context, s->renderer, image, &s->options));
    if (mirrored)
        cvol_image_mirror(image);
    return image;
}

static void write_figures(stage *s)
{
    const double white[3] = {1, 1, 1};
    cvol_context *context = s->context;
    cvol_image *picture = look(s, 640, 0), *bytes;
    must(context, cvol_image_write_png16(context, picture, NULL, 0, "figure_clear.png"));
    for (int c = 0; c < 3; c++)
        s->options.background[c] = white[c]; /* annotations are dark on white */
    const cvol_annotation annotation = {.size = sizeof(cvol_annotation),
                                        .grid = cvol_array_grid(s->array),
                                        .options = &s->options,
                                        .transfer = s->transfer,
                                        .rescale = {1, 0},
                                        .value_unit = ""};
    must(context, cvol_image_annotate(context, picture, &annotation));
    must(context, cvol_image_create(context, &bytes, picture->width, picture->height));
    must(context, cvol_image_flatten(context, bytes, picture, white));
    must(context, cvol_image_write_png(context, bytes, "figure.png"));
    cvol_image_free(picture);
    cvol_image_free(bytes);
}

static void write_film(stage *s)
{
    const double black[3] = {0, 0, 0};
    const cvol_film_options options = {
        .size = sizeof(cvol_film_options), .frames_per_second = 6, .quality = 90};
    cvol_context *context = s->context;
    cvol_film *film;
    cvol_image *bytes;
    must(context, cvol_image_create(context, &bytes, 200, 200));
    must(context, cvol_film_open(context, &film, "figure_turn.gif", 200, 200, &options));
    for (int i = 0; i < FRAMES; i++) {
        cvol_image *picture = look(s, 200, 360.0 * i / FRAMES);
        must(context, cvol_image_flatten(context, bytes, picture, black));
        must(context, cvol_film_add(context, film, bytes));
        cvol_image_free(picture);
    }
    must(context, cvol_film_commit(context, film));
    cvol_image_free(bytes);
}

int main(int argc, char **argv)
{
    if (argc != 2) {
        fprintf(stderr, "usage: figure samples/ch2better.nii.gz\n");
        return 2;
    }
    cvol_context *context = cvol_context_create();
    if (!context)
        return 1;
    stage s = set_up(context, argv[1]);
    write_figures(&s);
    write_film(&s);
    cvol_renderer_free(s.renderer);
    cvol_transfer_free(s.transfer);
    cvol_array_free(s.array);
    cvol_context_free(context);
    return 0;
}
