/* The overlays of a volume. Each is on a grid over the volume (tools/overlay). Labels that a view
 * hides must not hide others, so each choice of labels has a shape of its own; the last ones stay
 * in memory. */
#include "viewer/volumes/overlays.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "viewer/base/answer.h"
#include "viewer/volumes/volume_renderers.h"

/* Choices of labels in memory, besides all labels. */
enum { FITS_KEPT = 2 };

/* An overlay on the grid, with its renderers. The lock of the idle renderers of the volume protects
 * holders and lists. */
struct held_overlay {
    overlay fitted;
    uint8_t chosen[OVERLAY_LABELS_MAX];
    int holders;
    idle_renderer *idle[2]; /* of colours, and of depths */
};

struct shown_overlay {
    const viewer_overlay *given;
    held_overlay *all;             /* constant: with all labels */
    held_overlay *fits[FITS_KEPT]; /* held; the last one that was used is the first */
    pthread_mutex_t making;        /* one fit at a time; taken before the lock of the lists */
};

shown_volume *overlays_owner(const shown_volume *v)
{
    const shown_volume *owner = volume_series(v);
    while (owner->parent)
        owner = owner->parent;
    return (shown_volume *)owner;
}

const viewer_overlay *overlays_given(const shown_volume *v, int i)
{
    return overlays_owner(v)->overlays[i].given;
}

/* ---- fits ---------------------------------------------------------------------------------------
 */

static int make_fit(cvol_context *context, held_overlay **out, const shown_volume *owner,
                    const viewer_overlay *given, const overlay_choice *choice)
{
    held_overlay *f = calloc(1, sizeof *f);
    *out = NULL;
    if (!f)
        return CVOL_ERROR_MEMORY;
    f->holders = 1;
    memcpy(f->chosen, choice->chosen, sizeof f->chosen);
    const int code = overlay_fit(context, &f->fitted, given->source, &owner->grid, owner->name,
                                 CVOL_ENGINE_SHEET, choice->has_chosen ? choice->chosen : NULL);
    if (!code) {
        *out = f;
        return code;
    }
    overlay_free(&f->fitted);
    free(f);
    return code;
}

static void release_fit(shown_volume *owner, held_overlay *f)
{
    if (!f)
        return;
    pthread_mutex_lock(&owner->idle_lock);
    const int last = --f->holders == 0;
    pthread_mutex_unlock(&owner->idle_lock);
    if (!last)
        return;
    volume_free_list(owner, f->idle[0]);
    volume_free_list(owner, f->idle[1]);
    overlay_free(&f->fitted);
    free(f);
}

static int is_choice(const held_overlay *f, const overlay_choice *choice)
{
    return f && !memcmp(f->chosen, choice->chosen, sizeof f->chosen);
}

/* Puts a held fit in front; the last one leaves, and the caller gets its reference. */
static held_overlay *put_in_front(shown_overlay *o, held_overlay *f)
{
    int at = 0;
    while (at < FITS_KEPT - 1 && o->fits[at] != f && o->fits[at])
        at++;
    held_overlay *gone = o->fits[at] == f ? NULL : o->fits[at];
    memmove(o->fits + 1, o->fits, (size_t)at * sizeof(held_overlay *));
    o->fits[0] = f;
    return gone;
}

/* Holds the fit of a choice; NULL: it is not in memory. */
static held_overlay *find_fit(shown_volume *owner, shown_overlay *o, const overlay_choice *choice)
{
    held_overlay *found = choice->has_chosen ? NULL : o->all;
    pthread_mutex_lock(&owner->idle_lock);
    for (int k = 0; k < FITS_KEPT && !found; k++)
        found = is_choice(o->fits[k], choice) ? o->fits[k] : NULL;
    if (found)
        found->holders++;
    if (found && choice->has_chosen)
        put_in_front(o, found);
    pthread_mutex_unlock(&owner->idle_lock);
    return found;
}

/* Makes the fit of a choice, and keeps it. */
static int add_fit(cvol_context *context, held_overlay **out, shown_volume *owner, shown_overlay *o,
                   const overlay_choice *choice)
{
    const int code = make_fit(context, out, owner, o->given, choice);
    if (code)
        return code;
    pthread_mutex_lock(&owner->idle_lock);
    (*out)->holders++; /* that of the list */
    held_overlay *gone = put_in_front(o, *out);
    pthread_mutex_unlock(&owner->idle_lock);
    release_fit(owner, gone);
    return code;
}

/* Holds the fit of a choice, and makes it if it is not in memory. A frame and slices ask for a new
 * choice at once: the first makes it, and the others wait. */
static int hold_fit(cvol_context *context, held_overlay **out, shown_volume *owner,
                    shown_overlay *o, const overlay_choice *choice)
{
    int code = CVOL_OK;
    *out = find_fit(owner, o, choice);
    if (*out)
        return code;
    pthread_mutex_lock(&o->making);
    *out = find_fit(owner, o, choice);
    if (!*out)
        code = add_fit(context, out, owner, o, choice);
    pthread_mutex_unlock(&o->making);
    return code;
}

int overlays_hold(cvol_context *context, held_overlay **held, const overlay **out,
                  const shown_volume *v, int i, const overlay_choice *choice)
{
    shown_volume *owner = overlays_owner(v);
    const int code = hold_fit(context, held, owner, &owner->overlays[i], choice);
    *out = code ? NULL : &(*held)->fitted;
    return code;
}

void overlays_release(const shown_volume *v, held_overlay *held)
{
    release_fit(overlays_owner(v), held);
}

int overlays_fit(cvol_context *context, shown_volume *v, const viewer_options *options)
{
    if (!options->overlay_count)
        return CVOL_OK;
    v->overlays = calloc((size_t)options->overlay_count, sizeof *v->overlays);
    if (!v->overlays)
        return CVOL_ERROR_MEMORY;
    v->overlay_count = options->overlay_count;
    for (int i = 0; i < v->overlay_count; i++)
        pthread_mutex_init(&v->overlays[i].making, NULL);
    int code = CVOL_OK;
    for (int i = 0; i < v->overlay_count && !code; i++) {
        const overlay_choice all = {.on = 1};
        v->overlays[i].given = &options->overlays[i];
        code = make_fit(context, &v->overlays[i].all, v, v->overlays[i].given, &all);
    }
    return code;
}

void overlays_free(shown_volume *v)
{
    for (int i = 0; i < v->overlay_count; i++) {
        for (int k = 0; k < FITS_KEPT; k++)
            release_fit(v, v->overlays[i].fits[k]);
        release_fit(v, v->overlays[i].all);
        pthread_mutex_destroy(&v->overlays[i].making);
    }
    free(v->overlays);
    v->overlays = NULL;
    v->overlay_count = 0;
}

uint64_t overlays_resident_bytes(const shown_volume *v)
{
    uint64_t bytes = 0;
    for (int i = 0; i < v->overlay_count; i++) {
        const overlay *o = &v->overlays[i].all->fitted;
        cvol_array_info info;
        cvol_array_get_info(&info, o->array);
        bytes += info.resident_bytes + (o->numbers ? cvol_grid_bytes(&o->numbers->grid) : 0);
    }
    return bytes;
}

/* ---- choices ------------------------------------------------------------------------------------
 */

overlay_choice overlays_first_choice(const shown_volume *v, int i)
{
    const shown_volume *owner = overlays_owner(v);
    const overlay_look *look = &owner->overlays[i].given->look;
    overlay_choice choice = {.on = 1,
                             .has_window = look->has_window,
                             .opacity = look->opacity,
                             .depth = look->depth < 0 ? overlay_default_depth(&owner->grid)
                                                      : look->depth};
    memcpy(choice.window, look->window, sizeof choice.window);
    return choice;
}

/* The look of an overlay by a choice. */
static overlay_look look_of(const overlay_choice *choice, const viewer_overlay *given)
{
    overlay_look look = given->look;
    if (choice->transfer[0]) {
        look.transfer = choice->transfer;
        look.given = NULL;
    }
    look.has_window = choice->has_window;
    memcpy(look.window, choice->window, sizeof look.window);
    return look;
}

int overlays_is_drawn(const overlay_choice *choice, const viewer_overlay *given)
{
    const int has_labels = !choice->has_chosen || memchr(choice->chosen, 1, given->source->count);
    const overlay_look look = look_of(choice, given);
    return choice->on && choice->opacity > 0 && has_labels &&
           !overlay_is_blank(given->source, &look);
}

int overlays_create_transfers(cvol_context *context, cvol_transfer **colours,
                              cvol_transfer **depths, const shown_volume *v, int i,
                              const overlay_choice *choice, double density)
{
    const viewer_overlay *given = overlays_given(v, i);
    const overlay_look look = look_of(choice, given);
    return overlay_create_transfers(context, colours, depths, given->source, &look, density);
}

/* ---- drawing ------------------------------------------------------------------------------------
 */

static idle_renderer *take_renderer(cvol_context *context, shown_volume *owner, held_overlay *f,
                                    int kind)
{
    pthread_mutex_lock(&owner->idle_lock);
    idle_renderer *r = f->idle[kind];
    if (r)
        f->idle[kind] = r->next;
    pthread_mutex_unlock(&owner->idle_lock);
    if (r)
        return r;
    r = calloc(1, sizeof *r);
    if (r && !overlay_create_renderer(context, &r->renderer, &f->fitted, CVOL_ENGINE_SHEET))
        return r;
    free(r);
    return NULL;
}

static void return_renderer(shown_volume *owner, held_overlay *f, int kind, idle_renderer *r)
{
    pthread_mutex_lock(&owner->idle_lock);
    r->next = f->idle[kind];
    f->idle[kind] = r;
    pthread_mutex_unlock(&owner->idle_lock);
}

/* Draws the colours of an overlay (kind 0), or adds its depths (1). */
static int draw_part(cvol_context *context, shown_volume *owner, held_overlay *f, int kind,
                     const cvol_transfer *transfer, cvol_image *picture,
                     const cvol_render_options *options)
{
    cvol_render_options granted = *options;
    idle_renderer *r = take_renderer(context, owner, f, kind);
    if (!r)
        return CVOL_ERROR_MEMORY;
    granted.keep_mb = volume_grant_mb(owner, r,
                                      cvol_grid_samples(cvol_array_grid(f->fitted.array)));
    int code = renderer_set_transfer(context, r, transfer);
    if (!code)
        code = (kind ? overlay_add_depths : overlay_draw)(context, &f->fitted, r->renderer, picture,
                                                          &granted);
    volume_store_filled(owner, r);
    return_renderer(owner, f, kind, r);
    return code;
}

static int draw_one(cvol_context *context, shown_volume *owner, int i, const overlay_choice *choice,
                    overlay_layer *layer, const cvol_render_options *options)
{
    cvol_transfer *colours = NULL, *depths = NULL;
    held_overlay *f = NULL;
    int code = hold_fit(context, &f, owner, &owner->overlays[i], choice);
    if (!code)
        code = overlays_create_transfers(context, &colours, &depths, owner, i, choice,
                                         f->fitted.density);
    if (!code)
        code = cvol_image_create_float(context, &layer->picture, options->width, options->height);
    if (!code)
        code = draw_part(context, owner, f, 0, colours, layer->picture, options);
    if (!code && overlay_needs_depths(&f->fitted, options->mode))
        code = draw_part(context, owner, f, 1, depths, layer->picture, options);
    layer->opacity = choice->opacity;
    layer->depth = choice->depth;
    cvol_transfer_free(colours);
    cvol_transfer_free(depths);
    release_fit(owner, f);
    return code;
}

int overlays_draw(cvol_context *context, const shown_volume *v, const overlay_choice *choices,
                  int count, cvol_image *image, const cvol_render_options *options)
{
    shown_volume *owner = overlays_owner(v);
    overlay_layer layers[OVERLAYS_MAX] = {{NULL, 0, 0}};
    int code = CVOL_OK, drawn = 0;
    for (int i = 0; i < count && !code; i++)
        if (overlays_is_drawn(&choices[i], owner->overlays[i].given))
            code = draw_one(context, owner, i, &choices[i], &layers[drawn++], options);
    if (!code)
        overlay_blend(image, layers, drawn);
    for (int k = 0; k < drawn; k++)
        cvol_image_free(layers[k].picture);
    return code;
}

int overlays_find_depth(cvol_context *context, double *depth, const shown_volume *v,
                        const overlay_choice *choices, int count,
                        const cvol_render_options *options, size_t pixel)
{
    shown_volume *owner = overlays_owner(v);
    int code = CVOL_OK;
    for (int i = 0; i < count && !code; i++) {
        const viewer_overlay *given = owner->overlays[i].given;
        overlay_layer layer = {NULL, 0, 0};
        if (!given->source->is_numbered || !overlays_is_drawn(&choices[i], given))
            continue;
        code = draw_one(context, owner, i, &choices[i], &layer, options);
        const double *spacing = owner->overlays[i].all->fitted.numbers->grid.spacing;
        const double below = (spacing[0] + spacing[1] + spacing[2]) / 6,
                     at = code ? INFINITY : (double)layer.picture->depth[pixel];
        if (at < *depth)
            *depth = at + below;
        cvol_image_free(layer.picture);
    }
    return code;
}

/* ---- describing ---------------------------------------------------------------------------------
 */

static json_t *describe_labels(const viewer_overlay *given)
{
    if (!given->source->is_numbered)
        return json_null();
    json_t *list = json_array();
    for (size_t k = 0; k < given->source->count; k++) {
        const viewer_label *label = &given->labels[k];
        json_array_append_new(list, json_pack("{s:i, s:o, s:[f, f, f]}", "value", label->value,
                                              "name", answer_text(label->name), "colour",
                                              label->rgb[0], label->rgb[1], label->rgb[2]));
    }
    return list;
}

static json_t *describe_values(const viewer_overlay *given, const overlay_choice *choice)
{
    const cvol_grid *grid = &given->source->grid;
    const cvol_histogram *h = &given->source->histogram;
    if (given->source->is_numbered)
        return json_null();
    return json_pack("{s:f, s:f, s:s, s:f, s:f, s:o, s:o}", "min", h->min, "max", h->max, "type",
                     cvol_type_name(grid->type), "value_scale", grid->value_scale, "value_offset",
                     grid->value_offset, "transfer",
                     answer_text(given->transfer            ? given->transfer
                                 : given->source->is_labels ? "auto"
                                                            : "hot"),
                     "window",
                     choice->has_window ? json_pack("[f, f]", choice->window[0], choice->window[1])
                                        : json_null());
}

json_t *overlays_describe(const shown_volume *v)
{
    const shown_volume *owner = overlays_owner(v);
    json_t *list = json_array();
    for (int i = 0; i < owner->overlay_count; i++) {
        const viewer_overlay *given = owner->overlays[i].given;
        const overlay_choice choice = overlays_first_choice(v, i);
        json_array_append_new(list,
                              json_pack("{s:o, s:o, s:f, s:f, s:o, s:o}", "name",
                                        answer_text(volume_last_name(given->source->path)), "path",
                                        answer_text(given->source->path), "opacity", choice.opacity,
                                        "depth", choice.depth, "labels", describe_labels(given),
                                        "values", describe_values(given, &choice)));
    }
    return list;
}
