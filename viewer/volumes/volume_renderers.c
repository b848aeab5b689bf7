/* Idle renderers of a volume, and pictures by them. A renderer keeps its caches for the next
 * picture. */
#include <stdlib.h>
#include <string.h>

#include "viewer/volumes/labels.h"
#include "viewer/volumes/volume_renderers.h"

/* Upper limit of the block cache per sample: 32 bits, three axes, and levels. */
enum { KEPT_SAMPLE_BYTES = 16 };

int volume_make_renderer(cvol_context *context, idle_renderer *out, const shown_volume *v,
                         int of_labels)
{
    *out = (idle_renderer){.labels = of_labels ? v->labels : NULL};
    return cvol_renderer_create(context, &out->renderer, CVOL_ENGINE_SHEET,
                                CVOL_SOURCE(.array = out->labels ? out->labels->shape : v->array));
}

static idle_renderer **idle_list(shown_volume *v, int of_labels)
{
    return of_labels ? &v->idle_of_labels : &v->idle;
}

idle_renderer *volume_take_renderer(cvol_context *context, shown_volume *v, int of_labels)
{
    pthread_mutex_lock(&v->idle_lock);
    idle_renderer **list = idle_list(v, of_labels), *r = *list;
    if (r)
        *list = r->next;
    pthread_mutex_unlock(&v->idle_lock);
    if (r)
        return r;
    r = calloc(1, sizeof *r);
    if (r && !volume_make_renderer(context, r, v, of_labels))
        return r;
    free(r);
    return NULL;
}

void volume_return_renderer(shown_volume *v, idle_renderer *renderer)
{
    if (!renderer)
        return;
    pthread_mutex_lock(&v->idle_lock);
    idle_renderer **list = idle_list(v, renderer->labels != NULL);
    renderer->next = *list;
    *list = renderer;
    pthread_mutex_unlock(&v->idle_lock);
}

static uint64_t least(uint64_t a, uint64_t b)
{
    return a < b ? a : b;
}

static uint64_t rest(uint64_t of, uint64_t taken)
{
    return of > taken ? of - taken : 0;
}

/* Changes the share of a renderer; a smaller one takes effect with the next picture. */
static void grant(shown_volume *v, idle_renderer *renderer, uint64_t wanted)
{
    kept_memory *kept = volumes_kept(v->all);
    const int volume_count = volumes_count(v->all);
    const uint64_t share = kept->most / (uint64_t)(volume_count > 1 ? volume_count : 1);
    pthread_mutex_lock(&kept->lock);
    kept->granted -= renderer->granted;
    v->granted -= renderer->granted;
    renderer->granted = least(wanted,
                              least(rest(share, v->granted), rest(kept->most, kept->granted)));
    kept->granted += renderer->granted;
    v->granted += renderer->granted;
    pthread_mutex_unlock(&kept->lock);
}

static void store_filled(shown_volume *v, idle_renderer *renderer, uint64_t filled)
{
    kept_memory *kept = volumes_kept(v->all);
    pthread_mutex_lock(&kept->lock);
    kept->filled += filled - renderer->filled;
    renderer->filled = filled;
    pthread_mutex_unlock(&kept->lock);
}

double volume_grant_mb(shown_volume *v, idle_renderer *renderer, size_t samples)
{
    grant(v, renderer, KEPT_SAMPLE_BYTES * (uint64_t)samples);
    return 1e-6 * (double)renderer->granted;
}

void volume_store_filled(shown_volume *v, idle_renderer *renderer)
{
    store_filled(v, renderer, cvol_renderer_kept_bytes(renderer->renderer));
}

/* FNV-1a */
uint64_t transfer_hash(const cvol_transfer *transfer)
{
    uint64_t hash = 14695981039346656037u;
    for (size_t i = 0; i < cvol_transfer_count(transfer); i++) {
        const cvol_transfer_point point = cvol_transfer_point_at(transfer, i);
        uint8_t bytes[sizeof point];
        memcpy(bytes, &point, sizeof point);
        for (size_t k = 0; k < sizeof bytes; k++)
            hash = (hash ^ bytes[k]) * 1099511628211u;
    }
    return hash | 1;
}

static int keep_points(idle_renderer *renderer, const cvol_transfer *transfer)
{
    const size_t count = cvol_transfer_count(transfer);
    cvol_transfer_point *points = realloc(renderer->points, count * sizeof *points);
    if (!points)
        return CVOL_ERROR_MEMORY;
    for (size_t i = 0; i < count; i++)
        points[i] = cvol_transfer_point_at(transfer, i);
    renderer->points = points;
    renderer->point_count = count;
    return CVOL_OK;
}

int renderer_set_transfer(cvol_context *context, idle_renderer *renderer,
                          const cvol_transfer *transfer)
{
    const uint64_t hash = transfer_hash(transfer);
    if (hash == renderer->transfer)
        return CVOL_OK;
    renderer->transfer = 0;
    int code = cvol_renderer_set_transfer(context, renderer->renderer, transfer);
    if (!code)
        code = keep_points(renderer, transfer);
    if (!code)
        renderer->transfer = hash;
    return code;
}

void renderer_clear(idle_renderer *renderer)
{
    cvol_renderer_free(renderer->renderer);
    cvol_transfer_free(renderer->shown);
    free(renderer->points);
    *renderer = (idle_renderer){0};
}

int renderer_draw(cvol_context *context, const idle_renderer *renderer, cvol_image *image,
                  const cvol_render_options *options)
{
    return renderer->labels ? labels_draw(context, renderer->labels, renderer->renderer, image,
                                          options, renderer->shown)
                            : cvol_renderer_render(context, renderer->renderer, image, options);
}

/* 1 if several processes draw the picture: of a .cvol file, which the others can open, too. */
static int can_share(const shown_volume *v, const idle_renderer *renderer, const cvol_image *image)
{
    return volumes_options(v->all)->draw_shared && !renderer->labels && !image->depth &&
           !v->parent && !v->dense;
}

static int draw_shared(cvol_context *context, const shown_volume *v, const idle_renderer *renderer,
                       cvol_image *image, const cvol_render_options *options)
{
    viewer_shared_picture picture = {.path = v->path,
                                     .part = volume_part(v),
                                     .array = v->array,
                                     .renderer = renderer->renderer,
                                     .points = renderer->points,
                                     .point_count = renderer->point_count,
                                     .options = options};
    cvol_image *floats = NULL;
    int code = CVOL_OK;
    if (image->rgba)
        code = cvol_image_create_float(context, &floats, image->width, image->height);
    picture.image = floats ? floats : image;
    if (!code)
        code = volumes_options(v->all)->draw_shared(context, &picture);
    if (!code && floats)
        code = cvol_image_flatten(context, image, floats, options->background);
    cvol_image_free(floats);
    return code;
}

int volume_draw(cvol_context *context, shown_volume *v, idle_renderer *renderer, cvol_image *image,
                const cvol_render_options *options)
{
    cvol_render_options granted_options = *options;
    granted_options.keep_mb = volume_grant_mb(v, renderer, cvol_grid_samples(&v->grid));
    const int code = can_share(v, renderer, image)
                         ? draw_shared(context, v, renderer, image, &granted_options)
                         : renderer_draw(context, renderer, image, &granted_options);
    volume_store_filled(v, renderer);
    return code;
}

uint64_t volumes_kept_bytes(volumes *all)
{
    kept_memory *kept = volumes_kept(all);
    pthread_mutex_lock(&kept->lock);
    const uint64_t filled = kept->filled;
    pthread_mutex_unlock(&kept->lock);
    return filled;
}

void volume_free_list(shown_volume *v, idle_renderer *list)
{
    while (list) {
        idle_renderer *r = list;
        list = r->next;
        store_filled(v, r, 0);
        grant(v, r, 0);
        renderer_clear(r);
        free(r);
    }
}

void volume_free_renderers(shown_volume *v)
{
    volume_free_list(v, v->idle);
    volume_free_list(v, v->idle_of_labels);
    v->idle = v->idle_of_labels = NULL;
}
