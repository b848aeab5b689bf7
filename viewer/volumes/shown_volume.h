/* A volume in the viewer. */
#ifndef CVOL_VIEWER_VOLUMES_SHOWN_VOLUME_H
#define CVOL_VIEWER_VOLUMES_SHOWN_VOLUME_H

#include <pthread.h>

#include "cvol/cvol.h"
#include "viewer/base/options.h"

enum { COPIES_MAX = 16, VOLUME_ID_BYTES = 16 };

typedef enum volume_state {
    VOLUME_READING,
    VOLUME_COMPRESSING,
    VOLUME_READY,
    VOLUME_FAILED
} volume_state;

typedef struct volumes volumes;
typedef struct idle_renderer idle_renderer;
typedef struct shown_labels shown_labels;
typedef struct shown_overlay shown_overlay;
struct open_times;
struct shown_colours;

/* The memory of all block caches. */
typedef struct kept_memory {
    pthread_mutex_t lock;
    uint64_t most, granted, filled; /* bytes */
} kept_memory;

typedef struct shown_volume {
    char id[VOLUME_ID_BYTES];
    char *path, *name;
    const char *file;       /* the last part of the path */
    cvol_read_options read; /* constant, like the next two; of a copy empty */
    const viewer_label *named;
    size_t named_count;
    int times;                 /* the number of its times; `read` chooses the first */
    const double *time_values; /* [times]; NULL: unknown */
    const char *time_unit;
    viewer_channel channel;
    volumes *all;
    int holders; /* protected by the lock of the registry, like the next five fields */
    int removed;
    volume_state state;
    char doing[64];
    double fraction;
    char *error;
    /* constant when the volume is ready */
    cvol_array *array;
    cvol_volume *dense;      /* samples of a file that was not compressed; NULL for a copy */
    shown_labels *labels;    /* NULL: the samples are not labels (labels.h) */
    shown_overlay *overlays; /* [overlay_count]; of times and copies: those of overlays_owner */
    int overlay_count;
    cvol_grid grid;
    cvol_histogram histogram;
    int level; /* of the array: 0, a wanted one, or that of a file that ends early */
    const uint8_t *brick_levels; /* [brick_count]: wanted ones, or NULL */
    size_t brick_count;
    int cut, residual_missing; /* cvol_file_report */
    uint64_t raw_bytes, compressed_bytes;
    double psnr_db, max_error; /* NaN: unknown */
    int measured;              /* 0: these two are bounds */
    /* The default view, the size of what is visible in it, in the volume's unit, and if it is lit.
     */
    cvol_camera home;
    double home_size[2];
    int home_lit;
    double rescale[2]; /* to Hounsfield units; 0, 0: unknown */
    /* A later time of a volume: that volume, which is held; NULL: another volume. A time has the
     * histogram, the rescale and the default view of its series. */
    struct shown_volume *series;
    /* of a copy */
    struct shown_volume *parent; /* held; NULL: not a copy */
    char viewer[64];             /* the viewer that asked for it; "": none */
    int copied_time;             /* of the parent */
    cvol_compress_options copy_options;
    int flattened; /* the parent has a separate background, the copy has none */
    /* idle renderers, with their own lock */
    pthread_mutex_t idle_lock;
    idle_renderer *idle, *idle_of_labels;
    uint64_t granted; /* bytes of kept_memory, under its lock */
} shown_volume;
/* 1 if the samples are the original ones. */
static inline int volume_is_exact(const shown_volume *v)
{
    return v->psnr_db > 1e300 && !v->level; /* infinite */
}

/* The part of the file that the volume is. */
static inline cvol_file_part volume_part(const shown_volume *v)
{
    return (cvol_file_part){.size = sizeof(cvol_file_part),
                            .time = v->read.has_index ? v->read.index : 0,
                            .channel = v->read.has_channel ? v->read.channel : 0,
                            .level = v->level,
                            .cut = 1,
                            .brick_levels = v->brick_levels,
                            .brick_count = v->brick_count};
}

/* The volume that a time belongs to, or the volume itself. */
static inline const shown_volume *volume_series(const shown_volume *v)
{
    return v->series ? v->series : v;
}

/* The last part of a path, with its slash if it ends in one. */
const char *volume_last_name(const char *path);

/* Holds a held volume once more. */
void volume_hold(shown_volume *v);
/* Releases a volume; NULL is allowed. The last release of a removed volume frees it. */
void volume_release(shown_volume *v);
/* Reads a later time of a volume, and holds it; *out is NULL after an error. Returns a code of the
 * library. */
int volume_read_time(cvol_context *context, shown_volume **out, shown_volume *series, int time);

/* Sets the state that clients see. */
void volume_set_state(shown_volume *v, volume_state state);

/* The memory of block caches, the number of volumes and open times, the open times, the colours. */
kept_memory *volumes_kept(volumes *all);
/* The options of the viewer. */
const viewer_options *volumes_options(const volumes *all);
struct open_times *volumes_times(volumes *all);
struct shown_colours *volumes_colours(volumes *all);
int volumes_count(volumes *all);

#endif
