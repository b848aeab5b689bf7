/* The volumes that are shown: read, and compressed where they are not, beside the server's work.
 *
 * One thread reads those of the command line, one after the other; each copy has a thread of its
 * own. What a volume is does not change once it is ready, so that whoever holds it may use it.
 */
#ifndef CVOL_VIEWER_VOLUMES_H
#define CVOL_VIEWER_VOLUMES_H

#include <jansson.h>
#include <pthread.h>

#include "viewer.h"

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
    int level; /* of a file that ends early: which one is whole; else 0 */
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

/* Begins to read them. NULL: no memory. The options must outlive it. */
volumes *volumes_open(const viewer_options *options);
/* Cancels what is being made, and frees all. */
void volumes_close(volumes *all);

/* The volume of this id, held; NULL: there is none. */
shown_volume *volumes_hold(volumes *all, const char *id);
/* Lets go of one; NULL is allowed. The last holder of a removed one frees it. */
void volume_release(shown_volume *v);
/* Whether its array, grid and histogram are there. */
int volume_is_ready(shown_volume *v);
/* What it is at: `error` stays as long as the volume is held. */
typedef struct volume_look {
    volume_state state;
    char doing[64];
    double fraction;
    const char *error;
} volume_look;
volume_look volume_look_at(shown_volume *v);
/* All of them, held; how many. */
int volumes_hold_all(volumes *all, shown_volume *held[VOLUMES_MAX + COPIES_MAX]);
/* What the interface tells of one, and of all: new objects. */
json_t *volume_describe(shown_volume *v);
json_t *volumes_describe(volumes *all);
/* Begins to make a coarser copy of `parent` (which is ready), in the place of the one that
 * `who` (a viewer) has of it; held. NULL: there are too many, or no memory. */
shown_volume *volumes_copy(volumes *all, shown_volume *parent, const cvol_compress_options *wanted,
                           const char *who);
/* Removes a copy, cancelling its making; 0 if it is one. */
int volumes_remove(volumes *all, shown_volume *v);
/* Bytes of memory that arrays and samples take. */
uint64_t volumes_resident_bytes(volumes *all);
/* How many there are. */
int volumes_count(volumes *all);
kept_memory *volumes_kept(volumes *all);

/* ---- renderers ---- */

/* A renderer over the volume's array, for one caller at a time. */
struct idle_renderer {
    cvol_renderer *renderer;
    uint64_t transfer;        /* hash of the transfer function that it has; 0: none yet */
    unsigned drawn;           /* bit L: level L, whose first picture takes longer */
    uint64_t granted, filled; /* of kept_memory */
    idle_renderer *next;
};
/* NULL: the context says why. */
idle_renderer *volume_take_renderer(cvol_context *context, shown_volume *v);
void volume_return_renderer(shown_volume *v, idle_renderer *renderer);
/* Draws by one that was taken, which keeps what it evaluates: of the memory for that each volume
 * has an even share. */
int volume_draw(cvol_context *context, shown_volume *v, idle_renderer *renderer, cvol_image *image,
                const cvol_render_options *options);
/* Bytes that are kept, of all volumes. */
uint64_t volumes_kept_bytes(volumes *all);
/* Frees them: nobody holds the volume any more. */
void volume_free_renderers(shown_volume *v);

#endif
