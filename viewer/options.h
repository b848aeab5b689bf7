/* The options of the viewer. */
#ifndef CVOL_VIEWER_OPTIONS_H
#define CVOL_VIEWER_OPTIONS_H

#include "cvol/cvol.h"

#define VIEWER_HOSTS_MAX 8

/* Films in a format that the library does not write (MPEG-4), by whoever starts the viewer. */
typedef struct viewer_movies {
    int (*is_there)(void); /* whether there is what it takes */
    /* NULL, and from the next two not 0: `sentence` is why. */
    void *(*open)(const char *path, int width, int height, const cvol_film_options *options,
                  char *sentence, size_t sentence_bytes);
    int (*add)(void *movie, const cvol_image *image, char *sentence, size_t sentence_bytes);
    /* Gives the file its name, and frees the movie, also when it fails. */
    int (*commit)(void *movie, char *sentence, size_t sentence_bytes);
    void (*abandon)(void *movie);
} viewer_movies;

typedef struct viewer_options {
    const char *const *paths; /* volumes, compressed or not */
    int path_count;
    cvol_read_options read; /* of those that are not compressed */
    int has_fill;           /* NaN and infinite samples become `fill` */
    double fill;
    const char *listen;                  /* an address; NULL: 127.0.0.1 */
    int port;                            /* 0: a free one */
    const char *hosts[VIEWER_HOSTS_MAX]; /* further names that requests may call it by */
    int host_count;
    int once;                    /* it ends when its page asks it to */
    int threads;                 /* 0: all cores */
    double keep_mb;              /* of memory for what pictures evaluate, of all volumes; 0: none */
    const viewer_movies *movies; /* NULL: none */
} viewer_options;

#endif
