/* Animations: by the library, or by ffmpeg. */
#include "movie.h"

#include <stdlib.h>

#include "ffmpeg.h"

/* Size of messages: file names may be long. */
#define SENTENCE_BYTES 4608

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
        *status = complain(EXIT_FAILED, "not enough memory");
        return NULL;
    }
    if (is_ffmpeg_movie(path)) {
        char sentence[SENTENCE_BYTES];
        m->pipe = open_ffmpeg(path, width, height, options, sentence, sizeof sentence);
        if (!m->pipe)
            *status = complain(EXIT_FAILED, "%s", sentence);
    } else {
        const int code = cvol_film_open(context, &m->film, path, width, height, options);
        if (code)
            *status = complain_context(context, code, NULL);
    }
    if (m->pipe || m->film)
        return m;
    free(m);
    return NULL;
}

int movie_learns(const movie *m)
{
    return m->film && cvol_film_needs_palette(m->film);
}

int show_movie(cvol_context *context, movie *m, const cvol_image *image)
{
    const int code = cvol_film_sample_palette(context, m->film, image);
    return code ? complain_context(context, code, NULL) : EXIT_DONE;
}

int add_to_movie(cvol_context *context, movie *m, const cvol_image *image)
{
    char sentence[SENTENCE_BYTES];
    if (m->pipe)
        return add_to_ffmpeg(m->pipe, image, sentence, sizeof sentence)
                   ? complain(EXIT_FAILED, "%s", sentence)
                   : EXIT_DONE;
    const int code = cvol_film_add(context, m->film, image);
    return code ? complain_context(context, code, NULL) : EXIT_DONE;
}

int commit_movie(cvol_context *context, movie *m)
{
    char sentence[SENTENCE_BYTES];
    int status = EXIT_DONE, code = CVOL_OK;
    if (m->pipe && commit_ffmpeg(m->pipe, sentence, sizeof sentence))
        status = complain(EXIT_FAILED, "%s", sentence);
    else if (!m->pipe && (code = cvol_film_commit(context, m->film)))
        status = complain_context(context, code, NULL);
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
