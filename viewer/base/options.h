/* The options of the viewer. */
#ifndef CVOL_VIEWER_BASE_OPTIONS_H
#define CVOL_VIEWER_BASE_OPTIONS_H

#include "cvol/cvol.h"
#include "tools/overlay/overlay.h"

#define VIEWER_HOSTS_MAX 8

/* Functions of the calling program that write animations in formats beyond the library (MPEG-4). */
typedef struct viewer_movies {
    int (*is_available)(void); /* 1 if they can work */
    /* NULL, or from the next two functions not 0: failed, with a message in `message`. */
    void *(*open)(const char *path, int width, int height, const cvol_film_options *options,
                  char *message, size_t message_bytes);
    int (*add)(void *movie, const cvol_image *image, char *message, size_t message_bytes);
    /* Completes the file and frees the movie, after a failure too. */
    int (*commit)(void *movie, char *message, size_t message_bytes);
    void (*abandon)(void *movie);
} viewer_movies;

/* Facts about a label of a volume. */
typedef struct viewer_label {
    int value;
    const char *name; /* NULL: none */
    int has_colour;
    double rgb[3];
} viewer_label;

/* The place of a volume among the channels of its file. */
typedef struct viewer_channel {
    int count;        /* of channels; 0: one, the other fields do not count */
    int first;        /* the number of the volume of channel 0 in the list */
    int number;       /* from 0 */
    const char *name; /* "": none */
    double rgb[3];
    int is_component; /* red, green, blue or alpha of one colour */
} viewer_channel;

enum { VOLUMES_MAX = 256 }; /* in a list */

/* One volume of a file, compressed or not. */
typedef struct viewer_volume {
    const char *path, *name;    /* name NULL: that of the file */
    cvol_read_options read;     /* of .cvol files only time and channel count */
    const viewer_label *labels; /* in rising order; NULL: unknown */
    size_t label_count;
    int times; /* the number of its times, of which `read` chooses the first; 0: 1 */
    const double *time_values; /* [times]; NULL: unknown */
    const char *time_unit;     /* "s"; NULL: unknown */
    viewer_channel channel;
    /* Of a .cvol file, as in cvol_file_part: 0 and NULL: all coefficients. */
    int level;
    const uint8_t *brick_levels; /* [brick_count] */
    size_t brick_count;
} viewer_volume;

/* A volume that is drawn over the others: an option --overlay. */
typedef struct viewer_overlay {
    const overlay_source *source;
    overlay_look look;          /* as it was given; depth below 0: by the volume */
    const viewer_label *labels; /* [source->count]: of the numbered labels */
    /* The options as they were given, or NULL: transfer function, labels and their table. */
    const char *transfer, *labels_text, *label_file;
} viewer_overlay;

/* A picture that several processes can draw, because its volume is a .cvol file. */
typedef struct viewer_shared_picture {
    const char *path;
    cvol_file_part part;     /* time, channel and level of the volume */
    const cvol_array *array; /* the volume, and a renderer of it with the transfer function */
    cvol_renderer *renderer;
    const cvol_transfer_point *points; /* [point_count]: of the transfer function */
    size_t point_count;
    const cvol_render_options *options;
    cvol_image *image; /* of floats, without depth */
} viewer_shared_picture;

/* Draws a picture by several processes (tools/mpi); called on any thread. An error code. */
typedef int viewer_draw_shared(cvol_context *context, const viewer_shared_picture *picture);

typedef struct viewer_options {
    const viewer_volume *volumes;
    int volume_count;
    const viewer_overlay *overlays; /* at most OVERLAYS_MAX */
    int overlay_count;
    int has_fill; /* NaN and infinite samples become `fill` */
    double fill;
    const char *listen;                  /* an address; NULL: 127.0.0.1 */
    int port;                            /* 0: a free one */
    const char *hosts[VIEWER_HOSTS_MAX]; /* further allowed host names */
    int host_count;
    int once;        /* 1: the viewer ends when its page is closed */
    int threads;     /* 0: all cores */
    double keep_mb;  /* size of the block caches of all volumes; 0: off */
    double times_mb; /* memory for open times of volumes that have several; two are always kept */
    int is_cold; /* 1: volumes that were read wait for requests; 0: they are drawn once, so that the
                    first frames are fast */
    const viewer_movies *movies;     /* NULL: none */
    viewer_draw_shared *draw_shared; /* NULL: this process draws alone */
} viewer_options;

#endif
