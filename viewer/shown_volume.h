/* A volume that the viewer shows. */
#ifndef CVOL_VIEWER_SHOWN_VOLUME_H
#define CVOL_VIEWER_SHOWN_VOLUME_H

#include <pthread.h>

#include "cvol/cvol.h"

enum { VOLUMES_MAX = 256, COPIES_MAX = 16, VOLUME_ID_BYTES = 16 };

typedef enum volume_state {
    VOLUME_READING,
    VOLUME_COMPRESSING,
    VOLUME_READY,
    VOLUME_FAILED
} volume_state;

typedef struct volumes volumes;
typedef struct idle_renderer idle_renderer;

/* Memory in which renderers keep what they evaluated for the next pictures, of all volumes. */
typedef struct kept_memory {
    pthread_mutex_t lock;
    uint64_t most, granted, filled; /* bytes */
} kept_memory;

typedef struct shown_volume {
    char id[VOLUME_ID_BYTES];
    char *path, *name;
    volumes *all;
    int holders; /* under the registry's lock, as are the next five */
    int removed;
    volume_state state;
    char doing[64];
    double fraction;
    char *error;
    /* what does not change once it is ready */
    cvol_array *array;
    cvol_volume *dense; /* the samples of a file that was not compressed; of a copy NULL */
    cvol_grid grid;
    cvol_histogram histogram;
    int level;                 /* of a file that ends early: which one is whole; else 0 */
    int cut, residual_missing; /* cvol_file_report */
    uint64_t raw_bytes, compressed_bytes;
    double psnr_db, max_error; /* NaN: not known */
    int measured;              /* else the PSNR is at least that, the error at most */
    double rescale[2];         /* to Hounsfield units; 0, 0: it is not known what samples mean */
    /* a copy's */
    struct shown_volume *parent; /* held; NULL: it is none */
    char viewer[64];             /* who it was made for; "": nobody in particular */
    cvol_compress_options wanted;
    int flattened; /* its parent keeps a background apart, and it does not */
    /* renderers that nobody uses, under a lock of their own */
    pthread_mutex_t idle_lock;
    idle_renderer *idle;
    uint64_t granted; /* of kept_memory, under its lock */
} shown_volume;
/* Says what it is at. */
void volume_set_state(shown_volume *v, volume_state state);

/* What all volumes share: the memory that renderers keep, and how many volumes there are. */
kept_memory *volumes_kept(volumes *all);
int volumes_count(volumes *all);

#endif
