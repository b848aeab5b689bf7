/* The overlays of a view: their settings, and pictures with them. */
#include "viewer/view/view.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

/* ---- settings -----------------------------------------------------------------------------------
 */

/* [LO, HI]; null: automatic. */
static void take_window(overlay_choice *choice, fields *f)
{
    json_t *window = f->object ? json_object_get(f->object, "window") : NULL;
    if (!window)
        return;
    choice->has_window = !json_is_null(window);
    if (!choice->has_window)
        json_object_del(f->object, "window");
    else if (take_numbers(f, "window", choice->window, 2) && fields_ok(f)) {
        if (!(choice->window[0] < choice->window[1]))
            fields_fail(f, "%swindow: the second value must be larger", f->within);
        else if (!isfinite(choice->window[1] - choice->window[0]))
            fields_fail(f, "%swindow: the difference of the values must be finite", f->within);
    }
}

/* The name of a transfer function; the one that was given stays. */
static void take_transfer(overlay_choice *choice, const viewer_overlay *given, fields *f)
{
    const json_t *named = f->object ? json_object_get(f->object, "transfer") : NULL;
    const char *name = json_string_value(named);
    if (name && given->transfer && !strcmp(name, given->transfer))
        json_object_del(f->object, "transfer");
    else if (take_text(f, "transfer", choice->transfer, sizeof choice->transfer) && fields_ok(f) &&
             !choice->transfer[0])
        fields_fail(f, "%stransfer is empty, must be a name", f->within);
}

/* The values of the labels that are drawn; null: all. */
static void take_labels(overlay_choice *choice, const viewer_overlay *given, fields *f)
{
    json_t *list = take_any(f, "labels");
    if (!list || json_is_null(list)) {
        json_decref(list);
        return;
    }
    int good = json_is_array(list);
    size_t found = 0;
    for (size_t i = 0; good && i < json_array_size(list); i++) {
        const json_t *value = json_array_get(list, i);
        size_t k = 0;
        while (k < given->source->count && given->labels[k].value != json_integer_value(value))
            k++;
        good = json_is_integer(value) && k < given->source->count && !choice->chosen[k];
        if (good)
            choice->chosen[k] = 1;
        found += (size_t)good;
    }
    if (!good)
        fields_fail(f, "%slabels must be different values of labels of the overlay", f->within);
    choice->has_chosen = found < given->source->count;
    if (!choice->has_chosen) /* as without the field */
        memset(choice->chosen, 0, sizeof choice->chosen);
    json_decref(list);
}

/* Refuses a function that does not exist, or that does not fit the values of overlay i. */
static void check_transfer(const view *v, int i, fields *f)
{
    cvol_transfer *colours = NULL, *depths = NULL;
    cvol_context *context = cvol_context_create();
    const int code = context ? overlays_create_transfers(context, &colours, &depths, v->volume, i,
                                                         &v->overlays[i], 1)
                             : CVOL_ERROR_MEMORY;
    if (code && code != CVOL_ERROR_MEMORY) /* the picture reports that */
        fields_fail(f, "%stransfer: %s", f->within, cvol_context_message(context));
    cvol_transfer_free(colours);
    cvol_transfer_free(depths);
    cvol_context_free(context);
}

static void take_one(overlay_choice *choice, const viewer_overlay *given, fields *f)
{
    take_bool(f, "on", &choice->on);
    take_number(f, "opacity", &choice->opacity, 0, 1);
    take_number(f, "depth", &choice->depth, 0, 1e30);
    if (given->source->is_numbered) {
        take_labels(choice, given, f);
    } else {
        take_transfer(choice, given, f);
        take_window(choice, f);
    }
    fields_end(f);
}

void view_take_overlays(view *v, fields *f)
{
    const int count = overlays_owner(v->volume)->overlay_count;
    json_t *list = take_any(f, "overlays");
    const int is_given = list && !json_is_null(list);
    if (is_given && (!json_is_array(list) || json_array_size(list) > (size_t)count))
        fields_fail(f, "%soverlays must be a list of at most %d, the overlays of the volume",
                    f->within, count);
    v->overlay_count = is_given && fields_ok(f) ? (int)json_array_size(list) : count;
    for (int i = 0; i < v->overlay_count; i++)
        v->overlays[i] = overlays_first_choice(v->volume, i);
    for (int i = 0; is_given && fields_ok(f) && i < v->overlay_count; i++) {
        char within[64];
        snprintf(within, sizeof within, "%soverlays[%d].", f->within, i);
        fields inner = {json_array_get(list, (size_t)i), NULL, within, f->error, f->error_bytes};
        if (!json_is_object(inner.object))
            fields_fail(f, "%soverlays[%d] must be an object", f->within, i);
        else
            take_one(&v->overlays[i], overlays_given(v->volume, i), &inner);
        if (fields_ok(f) && v->overlays[i].transfer[0])
            check_transfer(v, i, &inner);
    }
    json_decref(list);
}

int view_shows_overlays(const view *v)
{
    int shown = 0;
    for (int i = 0; i < v->overlay_count; i++)
        shown = shown || overlays_is_drawn(&v->overlays[i], overlays_given(v->volume, i));
    return shown;
}

/* ---- pictures -----------------------------------------------------------------------------------
 */

int view_draw(cvol_context *context, const view *v, idle_renderer *renderer, cvol_image *image,
              const cvol_render_options *options)
{
    cvol_image *floats = NULL;
    if (!view_shows_overlays(v))
        return volume_draw(context, v->volume, renderer, image, options);
    int code = cvol_image_create_float(context, &floats, image->width, image->height);
    if (!code && overlay_mode_has_depth(options->mode))
        code = cvol_image_add_depth(context, floats);
    if (!code)
        code = volume_draw(context, v->volume, renderer, floats, options);
    if (!code)
        code = overlays_draw(context, v->volume, v->overlays, v->overlay_count, floats, options);
    if (!code)
        code = cvol_image_flatten(context, image, floats, options->background);
    cvol_image_free(floats);
    return code;
}
