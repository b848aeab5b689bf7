/* Animations: a view that turns about the vertical, or one picture per time, or both. A turn uses
 * its own renderer; frames keep theirs. */
#include "viewer/films/film_make.h"

#include <math.h>
#include <stdio.h>

#include "viewer/base/answer.h"
#include "viewer/view/channels.h"
#include "viewer/volumes/volume_renderers.h"

/* Sample pictures for the choice of colours. */
enum { PALETTE_FRAMES = 8 };

typedef struct making {
    cvol_context *context;
    film_settings *settings;
    idle_renderer renderer;
    cvol_image *image;
    film_out *out;
    char *message;
} making;

static int failed(const making *m, int code)
{
    snprintf(m->message, FILM_MESSAGE_BYTES, "%s", answer_message(m->context, code));
    return -1;
}

static int open_file(making *m, const viewer_movies *movies, const char *path)
{
    const view *v = &m->settings->view;
    const int size[2] = {v->options.width, v->options.height};
    return film_out_open(m->context, &m->out, m->settings->format, movies, path, size,
                         &m->settings->options, m->message);
}

/* 1 if the view shows channels or overlays. */
static int is_of_several(const view *v)
{
    return v->channel_count || view_shows_overlays(v);
}

static int begin(making *m, const viewer_movies *movies, const char *path)
{
    view *v = &m->settings->view;
    int code = m->settings->over_time ? CVOL_OK : view_open(m->context, v);
    if (!code)
        code = cvol_image_create(m->context, &m->image, v->options.width, v->options.height);
    if (!code && (is_of_several(v) || m->settings->over_time))
        return open_file(m, movies, path);
    if (!code)
        code = volume_make_renderer(m->context, &m->renderer, v->volume, view_shows_labels(v));
    if (!code)
        code = view_set_transfer(m->context, &m->renderer, v);
    if (code)
        return failed(m, code);
    return open_file(m, movies, path);
}

/* Draws an open view by renderers of its volumes. */
static int draw_view(cvol_context *context, const view *v, cvol_image *image,
                     const cvol_render_options *options)
{
    if (v->channel_count)
        return channels_draw(context, v, image, options);
    idle_renderer *renderer = volume_take_renderer(context, v->volume, view_shows_labels(v));
    int code = renderer ? view_set_transfer(context, renderer, v) : CVOL_ERROR_MEMORY;
    if (!code)
        code = view_draw(context, v, renderer, image, options);
    volume_return_renderer(v->volume, renderer);
    return code;
}

static int draw_time(making *m, int time, const cvol_render_options *options)
{
    view at;
    int code = view_open_at(m->context, &at, &m->settings->view, time);
    if (!code)
        code = draw_view(m->context, &at, m->image, options);
    view_free(&at);
    return code;
}

static int draw(making *m, double share)
{
    const view *v = &m->settings->view;
    cvol_render_options options = v->options;
    options.camera.azimuth_deg += m->settings->degrees * share;
    const int code = m->settings->over_time
                         ? draw_time(m, (int)(share * m->settings->frames + 0.5), &options)
                     : is_of_several(v)
                         ? draw_view(m->context, v, m->image, &options)
                         : renderer_draw(m->context, &m->renderer, m->image, &options);
    if (code)
        return failed(m, code);
    if (v->mirror)
        cvol_image_mirror(m->image);
    return 0;
}

/* Gives sample pictures from all around to the animation. */
static int sample_palette(making *m)
{
    const int count = m->settings->frames < PALETTE_FRAMES ? m->settings->frames : PALETTE_FRAMES;
    for (int k = 0; k < count; k++) {
        const double share = (double)k / count, time = floor(share * m->settings->frames);
        if (draw(m, m->settings->over_time ? time / m->settings->frames : share) ||
            film_out_sample_palette(m->context, m->out, m->image, m->message))
            return -1;
    }
    return 0;
}

int film_make(cvol_context *context, film_settings *settings, const viewer_movies *movies,
              const char *path, void (*on_progress)(void *user, double fraction), void *user,
              char message[FILM_MESSAGE_BYTES])
{
    making m = {.context = context, .settings = settings, .message = message};
    int code = begin(&m, movies, path);
    if (!code && film_out_needs_palette(m.out))
        code = sample_palette(&m);
    for (int i = 0; i < settings->frames && !code; i++) {
        code = draw(&m, (double)i / settings->frames);
        if (!code)
            code = film_out_add(context, m.out, m.image, message);
        on_progress(user, (double)(i + 1) / settings->frames);
    }
    if (code)
        film_out_abandon(m.out);
    else
        code = film_out_commit(context, m.out, message);
    renderer_clear(&m.renderer);
    cvol_image_free(m.image);
    return code;
}
