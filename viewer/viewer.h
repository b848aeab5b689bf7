/* The viewer: a server that shows volumes in a browser. doc/viewer-api.md says what it answers.
 *
 * Only the cvol command starts it; it stands on the public headers alone.
 */
#ifndef CVOL_VIEWER_VIEWER_H
#define CVOL_VIEWER_VIEWER_H

#include "cvol/cvol.h"

#define VIEWER_HOSTS_MAX 8

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
    int once;    /* it ends when its page asks it to */
    int threads; /* 0: all cores */
} viewer_options;

typedef struct viewer viewer;

/* Starts listening, and to read the volumes. *out NULL: it could not, and `message` is the sentence
 * why. */
int viewer_open(viewer **out, char *message, size_t message_bytes, const viewer_options *options);
/* "http://127.0.0.1:40123/TOKEN/". */
const char *viewer_address(const viewer *v);
/* Now and then, some four times a second: closes connections that take too long. 1: the page has
 * asked to end. */
int viewer_tick(viewer *v);
/* Ends what runs, answers what waits, and frees it; NULL is allowed. */
void viewer_close(viewer *v);

#endif
