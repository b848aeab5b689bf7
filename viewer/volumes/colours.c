/* The components of RGB files, drawn as one shape with colours (colours.h). */
#include "viewer/volumes/colours.h"

#include <stdlib.h>
#include <string.h>

#include "viewer/volumes/volume_renderers.h"

struct shown_colours {
    pthread_mutex_t lock; /* of the rest */
    colour_choice choice; /* its volumes are held; count 0: nothing is kept */
    cvol_array *shape;
    cvol_colours *colours;
    cvol_transfer *transfer;
    idle_renderer *renderer; /* of the shape */
};

shown_colours *colours_open(void)
{
    shown_colours *shown = calloc(1, sizeof *shown);
    if (shown)
        pthread_mutex_init(&shown->lock, NULL);
    return shown;
}

/* Frees what is kept. */
static void forget(shown_colours *shown)
{
    if (shown->renderer)
        volume_free_list(shown->choice.components[0], shown->renderer);
    cvol_transfer_free(shown->transfer);
    cvol_colours_free(shown->colours);
    cvol_array_free(shown->shape);
    for (size_t i = 0; i < shown->choice.count; i++)
        volume_release(shown->choice.components[i]);
    shown->renderer = NULL;
    shown->transfer = NULL;
    shown->colours = NULL;
    shown->shape = NULL;
    shown->choice = (colour_choice){.count = 0};
}

void colours_close(shown_colours *shown)
{
    if (!shown)
        return;
    forget(shown);
    pthread_mutex_destroy(&shown->lock);
    free(shown);
}

static int is_alpha(const shown_volume *v)
{
    return v->channel.number == CVOL_COLOURS_MAX - 1;
}

/* The components of a choice; alpha counts if it is not the same everywhere. */
static cvol_colour_source source_of(const cvol_array *arrays[CVOL_COLOURS_MAX],
                                    const colour_choice *choice)
{
    cvol_colour_source source = {.size = sizeof source, .arrays = arrays, .rgb = choice->rgb};
    for (size_t i = 0; i < choice->count; i++) {
        const shown_volume *v = choice->components[i];
        const cvol_histogram *h = &volume_series(v)->histogram;
        if (is_alpha(v) && !(h->max > h->min))
            continue;
        source.has_alpha = is_alpha(v);
        arrays[source.count++] = v->array;
    }
    memcpy(source.range, choice->range, sizeof source.range);
    source.by_range = volume_series(choice->components[0])->times > 1;
    return source;
}

static int make_transfer(cvol_context *context, shown_colours *shown)
{
    cvol_transfer *plain = NULL;
    int code = cvol_colours_create_transfer(context, &plain, shown->colours);
    if (!code)
        code = cvol_transfer_create_adjusted(context, &shown->transfer, plain, NULL,
                                             shown->choice.opacity_scale);
    cvol_transfer_free(plain);
    return code;
}

/* Makes everything for a choice. */
static int make(cvol_context *context, shown_colours *shown, const colour_choice *choice)
{
    const cvol_array *arrays[CVOL_COLOURS_MAX];
    cvol_volume *none;
    forget(shown);
    shown->choice = *choice;
    for (size_t i = 0; i < choice->count; i++)
        volume_hold(choice->components[i]);
    const cvol_colour_source source = source_of(arrays, choice);
    int code = cvol_colours_create(context, &shown->colours, &shown->shape, &none, &source);
    if (!code)
        code = make_transfer(context, shown);
    shown->renderer = code ? NULL : calloc(1, sizeof *shown->renderer);
    if (!code && !shown->renderer)
        code = CVOL_ERROR_MEMORY;
    if (!code)
        code = cvol_renderer_create(context, &shown->renderer->renderer, CVOL_ENGINE_SHEET,
                                    CVOL_SOURCE(.array = shown->shape));
    if (!code)
        code = renderer_set_transfer(context, shown->renderer, shown->transfer);
    if (code)
        forget(shown);
    return code;
}

static int is_kept(const shown_colours *shown, const colour_choice *choice)
{
    const colour_choice *kept = &shown->choice;
    if (kept->count != choice->count || kept->opacity_scale < choice->opacity_scale ||
        kept->opacity_scale > choice->opacity_scale ||
        memcmp(kept->range, choice->range, sizeof kept->range))
        return 0;
    for (size_t i = 0; i < choice->count; i++)
        if (kept->components[i] != choice->components[i] ||
            memcmp(kept->rgb + 3 * i, choice->rgb + 3 * i, 3 * sizeof *kept->rgb))
            return 0;
    return 1;
}

int colours_draw(cvol_context *context, shown_colours *shown, const colour_choice *choice,
                 cvol_image *image, const cvol_render_options *options)
{
    pthread_mutex_lock(&shown->lock);
    int code = is_kept(shown, choice) ? CVOL_OK : make(context, shown, choice);
    if (!code)
        code = cvol_image_add_depth(context, image);
    if (!code)
        code = volume_draw(context, choice->components[0], shown->renderer, image, options);
    if (!code)
        code = cvol_image_colour_components(context, image, shown->colours, shown->transfer,
                                            options);
    pthread_mutex_unlock(&shown->lock);
    free(image->depth);
    image->depth = NULL;
    return code;
}
