/* Writes an animation: by the library, as numbered pictures in an archive, or by functions of the
 * program that started the viewer. */
#define _POSIX_C_SOURCE 200809L
#include "viewer/films/film_out.h"

#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "viewer/base/answer.h"
#include "viewer/films/tar.h"

struct film_out {
    cvol_film *film;             /* exactly one of these three is set */
    FILE *archive;               /* of pictures */
    void *movie;                 /* of `movies` */
    const viewer_movies *movies; /* NULL: none */
    char *path;
    int pictures;
};

static const film_format formats[] = {{"gif", "image/gif", ".gif"},
                                      {"webp", "image/webp", ".webp"},
                                      {"png", "application/x-tar", ".tar"},
                                      {"mp4", "video/mp4", ".mp4"}};

static int is_available(const film_format *f, const viewer_movies *movies)
{
    return !strcmp(f->name, "mp4")   ? movies && movies->is_available()
           : !strcmp(f->name, "png") ? 1
                                     : strstr(cvol_film_formats(), f->ending) != NULL;
}

const film_format *film_format_at(int i, const viewer_movies *movies)
{
    for (size_t k = 0; k < sizeof formats / sizeof *formats; k++)
        if (is_available(&formats[k], movies) && !i--)
            return &formats[k];
    return NULL;
}

const film_format *film_format_find(const char *name, const viewer_movies *movies)
{
    const film_format *f;
    for (int i = 0; (f = film_format_at(i, movies)); i++)
        if (!strcmp(f->name, name))
            return f;
    return NULL;
}

/* Copies the message of the library after a failure. */
static int copy_error(const cvol_context *context, int code, char *message)
{
    if (code)
        snprintf(message, FILM_MESSAGE_BYTES, "%s", answer_message(context, code));
    return code ? -1 : 0;
}

static int copy_system_error(const film_out *f, char *message)
{
    snprintf(message, FILM_MESSAGE_BYTES, "cannot write %s: %s", f->path,
             errno ? strerror(errno) : "the disk may be full");
    return -1;
}

int film_out_open(cvol_context *context, film_out **out, const film_format *format,
                  const viewer_movies *movies, const char *path, const int size[2],
                  const cvol_film_options *options, char message[FILM_MESSAGE_BYTES])
{
    film_out *f = calloc(1, sizeof *f);
    *out = NULL;
    if (f)
        f->path = strdup(path);
    int failed = 0;
    if (!f || !f->path) {
        snprintf(message, FILM_MESSAGE_BYTES, "not enough memory for an animation");
        failed = 1;
    } else if (!strcmp(format->name, "png")) {
        f->archive = fopen(path, "wbxe");
        failed = f->archive ? 0 : copy_system_error(f, message);
    } else if (!strcmp(format->name, "mp4")) {
        f->movies = movies;
        f->movie = movies->open(path, size[0], size[1], options, message, FILM_MESSAGE_BYTES);
        failed = !f->movie;
    } else {
        failed = copy_error(
            context, cvol_film_open(context, &f->film, path, size[0], size[1], options), message);
    }
    if (failed)
        film_out_abandon(f);
    else
        *out = f;
    return failed ? -1 : 0;
}

int film_out_needs_palette(const film_out *f)
{
    return f->film && cvol_film_needs_palette(f->film);
}

int film_out_sample_palette(cvol_context *context, film_out *f, const cvol_image *image,
                            char message[FILM_MESSAGE_BYTES])
{
    return copy_error(context, cvol_film_sample_palette(context, f->film, image), message);
}

/* Adds a file to the archive: 0001.png, ... */
static int add_picture(cvol_context *context, film_out *f, const cvol_image *image, char *message)
{
    char name[32];
    void *bytes;
    size_t size;
    if (copy_error(context, cvol_image_encode_png(context, image, CVOL_PNG_QUICK, &bytes, &size),
                   message))
        return -1;
    snprintf(name, sizeof name, "%04d.png", ++f->pictures);
    errno = 0;
    const int failed = tar_add(f->archive, name, bytes, size);
    free(bytes);
    return failed ? copy_system_error(f, message) : 0;
}

int film_out_add(cvol_context *context, film_out *f, const cvol_image *image,
                 char message[FILM_MESSAGE_BYTES])
{
    if (f->movie)
        return f->movies->add(f->movie, image, message, FILM_MESSAGE_BYTES);
    return f->archive ? add_picture(context, f, image, message)
                      : copy_error(context, cvol_film_add(context, f->film, image), message);
}

/* 0 if everything was written. */
static int end_archive(film_out *f, char *message)
{
    errno = 0;
    const int ended = !tar_end(f->archive);
    const int closed = !fclose(f->archive);
    f->archive = NULL;
    if (ended && closed)
        return 0;
    copy_system_error(f, message);
    unlink(f->path);
    return -1;
}

int film_out_commit(cvol_context *context, film_out *f, char message[FILM_MESSAGE_BYTES])
{
    int failed = 0;
    if (f->archive) {
        failed = end_archive(f, message);
    } else if (f->movie) {
        failed = f->movies->commit(f->movie, message, FILM_MESSAGE_BYTES);
        f->movie = NULL;
    } else {
        failed = copy_error(context, cvol_film_commit(context, f->film), message);
        f->film = NULL;
    }
    film_out_abandon(f);
    return failed;
}

void film_out_abandon(film_out *f)
{
    if (!f)
        return;
    cvol_film_abandon(f->film);
    if (f->movie)
        f->movies->abandon(f->movie);
    if (f->archive) {
        fclose(f->archive);
        unlink(f->path);
    }
    free(f->path);
    free(f);
}
