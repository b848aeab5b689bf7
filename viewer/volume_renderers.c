/* Renderers of a volume that nobody uses: they keep what they made for the next picture. */
#include <stdlib.h>

#include "volumes.h"

idle_renderer *volume_take_renderer(cvol_context *context, shown_volume *v)
{
    pthread_mutex_lock(&v->idle_lock);
    idle_renderer *r = v->idle;
    if (r)
        v->idle = r->next;
    pthread_mutex_unlock(&v->idle_lock);
    if (r)
        return r;
    r = calloc(1, sizeof *r);
    if (r && !cvol_renderer_create_sheet(context, &r->renderer, v->array))
        return r;
    free(r);
    return NULL;
}

void volume_return_renderer(shown_volume *v, idle_renderer *renderer)
{
    if (!renderer)
        return;
    pthread_mutex_lock(&v->idle_lock);
    renderer->next = v->idle;
    v->idle = renderer;
    pthread_mutex_unlock(&v->idle_lock);
}

void volume_free_renderers(shown_volume *v)
{
    while (v->idle) {
        idle_renderer *r = v->idle;
        v->idle = r->next;
        cvol_renderer_free(r->renderer);
        free(r);
    }
}
