/* Animations: by the library, or by ffmpeg. */
#include "tools/render/movie.h"

#include <stdlib.h>

#include "tools/base/ffmpeg.h"

/* Size of messages: file names may be long. */
#define MESSAGE_BYTES 4608

struct movie {
    cvol_film *film;
    ffmpeg *pipe;
};

int is_ffmpeg_movie(const char *name)
{
    return has_ending(name, ".mp4") || has_ending(name, ".mov") || has_ending(name, ".mkv") ||
           has_ending(name, ".webm");
}

int is_movie(const char *name)
{
    return has_ending(name, ".gif") || has_ending(name, ".webp") || is_ffmpeg_movie(name);
}

movie *open_movie(cvol_context *context, const char *path, int width, int height,
                  const cvol_film_options *options, int *status)
{
    movie *m = calloc(1, sizeof *m);
    if (!m) {
        *status = report_error(EXIT_FAILED, "not enough memory");
        return NULL;
    }
    if (is_ffmpeg_movie(path)) {
        char message[MESSAGE_BYTES];
        m->pipe = open_ffmpeg(path, width, height, options, message, sizeof message);
        if (!m->pipe)
            *status = report_error(EXIT_FAILED, "%s", message);
    } else {
        const int code = cvol_film_open(context, &m->film, path, width, height, options);
        if (code)
            *status = report_context_error(context, code, NULL);
    }
    if (m->pipe || m->film)
        return m;
    free(m);
    return NULL;
}

int movie_needs_palette(const movie *m)
{
    return m->film && cvol_film_needs_palette(m->film);
}

int sample_movie_palette(cvol_context *context, movie *m, const cvol_image *image)
{
    const int code = cvol_film_sample_palette(context, m->film, image);
    return code ? report_context_error(context, code, NULL) : EXIT_DONE;
}

int add_to_movie(cvol_context *context, movie *m, const cvol_image *image)
{
    char message[MESSAGE_BYTES];
    if (m->pipe)
        return add_to_ffmpeg(m->pipe, image, message, sizeof message)
                   ? report_error(EXIT_FAILED, "%s", message)
                   : EXIT_DONE;
    const int code = cvol_film_add(context, m->film, image);
    return code ? report_context_error(context, code, NULL) : EXIT_DONE;
}

int commit_movie(cvol_context *context, movie *m)
{
    char message[MESSAGE_BYTES];
    int status = EXIT_DONE, code = CVOL_OK;
    if (m->pipe && commit_ffmpeg(m->pipe, message, sizeof message))
        status = report_error(EXIT_FAILED, "%s", message);
    else if (!m->pipe && (code = cvol_film_commit(context, m->film)))
        status = report_context_error(context, code, NULL);
    free(m);
    return status;
}

void abandon_movie(movie *m)
{
    if (!m)
        return;
    if (m->pipe)
        abandon_ffmpeg(m->pipe);
    cvol_film_abandon(m->film);
    free(m);
}
