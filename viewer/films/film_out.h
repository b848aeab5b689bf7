/* Writes an animation, in any format. */
#ifndef CVOL_VIEWER_FILMS_FILM_OUT_H
#define CVOL_VIEWER_FILMS_FILM_OUT_H

#include "viewer/base/options.h"

enum { FILM_MESSAGE_BYTES = 512 };

/* One format. */
typedef struct film_format {
    const char *name, *type; /* "webp", "image/webp" */
    const char *ending;      /* of the file: ".webp", ".tar" */
} film_format;

/* The format with this name; NULL: unknown, or not in this build. */
const film_format *film_format_find(const char *name, const viewer_movies *movies);
/* Format i = 0, 1, 2, ... of this build; NULL: no more. */
const film_format *film_format_at(int i, const viewer_movies *movies);

typedef struct film_out film_out;

/* These functions return 0, or -1 and a message. `path` has the extension of the format. */
int film_out_open(cvol_context *context, film_out **out, const film_format *format,
                  const viewer_movies *movies, const char *path, const int size[2],
                  const cvol_film_options *options, char message[FILM_MESSAGE_BYTES]);
/* 1 if the format chooses its colours from sample pictures, given to film_out_sample_palette first.
 */
int film_out_needs_palette(const film_out *f);
int film_out_sample_palette(cvol_context *context, film_out *f, const cvol_image *image,
                            char message[FILM_MESSAGE_BYTES]);
int film_out_add(cvol_context *context, film_out *f, const cvol_image *image,
                 char message[FILM_MESSAGE_BYTES]);
/* Completes the file and frees the object, after a failure too. */
int film_out_commit(cvol_context *context, film_out *f, char message[FILM_MESSAGE_BYTES]);
/* Removes the unfinished file and frees the object; NULL is allowed. */
void film_out_abandon(film_out *f);

#endif
