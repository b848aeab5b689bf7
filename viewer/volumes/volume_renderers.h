/* Renderers of a volume in the viewer; one caller at a time uses a renderer. */
#ifndef CVOL_VIEWER_VOLUMES_VOLUME_RENDERERS_H
#define CVOL_VIEWER_VOLUMES_VOLUME_RENDERERS_H

#include "viewer/volumes/shown_volume.h"

/* A renderer of the volume's array, or of the shape of its labels. */
struct idle_renderer {
    cvol_renderer *renderer;
    const shown_labels *labels;  /* NULL: of the array */
    cvol_transfer *shown;        /* of labels: its transfer function */
    uint64_t transfer;           /* hash of its transfer function; 0: none yet */
    cvol_transfer_point *points; /* of it, [point_count]: for other processes */
    size_t point_count;
    unsigned drawn;           /* bit L: it has drawn level L, whose first picture is slow */
    uint64_t granted, filled; /* bytes of kept_memory */
    idle_renderer *next;
};
/* Makes a renderer of the volume's array, or of its labels. */
int volume_make_renderer(cvol_context *context, idle_renderer *out, const shown_volume *v,
                         int of_labels);
/* Takes an idle renderer or makes one; NULL: the context has the message. */
idle_renderer *volume_take_renderer(cvol_context *context, shown_volume *v, int of_labels);
void volume_return_renderer(shown_volume *v, idle_renderer *renderer);
/* Sets a transfer function, unless the renderer has it. */
int renderer_set_transfer(cvol_context *context, idle_renderer *renderer,
                          const cvol_transfer *transfer);
/* A hash of the points of a transfer function; never 0. */
uint64_t transfer_hash(const cvol_transfer *transfer);
/* Draws by a renderer, with its transfer function, into a picture of bytes or floats. */
int renderer_draw(cvol_context *context, const idle_renderer *renderer, cvol_image *image,
                  const cvol_render_options *options);
/* Frees what the renderer has. */
void renderer_clear(idle_renderer *renderer);
/* Draws with a taken renderer and its block cache, by several processes if the options say so. All
 * volumes share the cache memory evenly. */
int volume_draw(cvol_context *context, shown_volume *v, idle_renderer *renderer, cvol_image *image,
                const cvol_render_options *options);
/* The size of the block cache of a renderer of so many samples, in MB, for its next picture; and
 * after the picture: what it uses. The memory is of the share of the volume. */
double volume_grant_mb(shown_volume *v, idle_renderer *renderer, size_t samples);
void volume_store_filled(shown_volume *v, idle_renderer *renderer);
/* Frees a list of renderers. */
void volume_free_list(shown_volume *v, idle_renderer *list);
/* Bytes in the block caches of all volumes. */
uint64_t volumes_kept_bytes(volumes *all);
/* Frees all renderers of a volume without holders. */
void volume_free_renderers(shown_volume *v);

#endif
