/* Renderers over a volume that is shown: each is used by one caller at a time, and kept for the
 * next. */
#ifndef CVOL_VIEWER_VOLUME_RENDERERS_H
#define CVOL_VIEWER_VOLUME_RENDERERS_H

#include "shown_volume.h"

/* A renderer over the volume's array, for one caller at a time. */
struct idle_renderer {
    cvol_renderer *renderer;
    uint64_t transfer;        /* hash of the transfer function that it has; 0: none yet */
    unsigned drawn;           /* bit L: level L, whose first picture takes longer */
    uint64_t granted, filled; /* of kept_memory */
    idle_renderer *next;
};
/* NULL: the context says why. */
idle_renderer *volume_take_renderer(cvol_context *context, shown_volume *v);
void volume_return_renderer(shown_volume *v, idle_renderer *renderer);
/* Draws by one that was taken, which keeps what it evaluates: of the memory for that each volume
 * has an even share. */
int volume_draw(cvol_context *context, shown_volume *v, idle_renderer *renderer, cvol_image *image,
                const cvol_render_options *options);
/* Bytes that are kept, of all volumes. */
uint64_t volumes_kept_bytes(volumes *all);
/* Frees them: nobody holds the volume any more. */
void volume_free_renderers(shown_volume *v);

#endif
