/* The volumes in the viewer, read and compressed in the background.
 *
 * One thread reads the volumes of the command line in order; each copy has its own thread. A ready
 * volume does not change, so every holder may use it without a lock.
 */
#ifndef CVOL_VIEWER_VOLUMES_VOLUMES_H
#define CVOL_VIEWER_VOLUMES_VOLUMES_H

#include <jansson.h>

#include "viewer/base/options.h"
#include "viewer/volumes/shown_volume.h"

/* Starts to read the volumes. NULL: no memory. The options must outlive it. */
volumes *volumes_open(const viewer_options *options);
/* Cancels work in progress and frees everything. */
void volumes_close(volumes *all);

/* Holds the volume with this id; NULL: there is none. */
shown_volume *volumes_hold(volumes *all, const char *id);
/* 1 if array, grid and histogram are ready. */
int volume_is_ready(shown_volume *v);
/* The state of a volume; `error` is valid while the volume is held. */
typedef struct volume_look {
    volume_state state;
    char doing[64];
    double fraction;
    const char *error;
} volume_look;
volume_look volume_look_at(shown_volume *v);
enum { UNREADY_BYTES = 512 };
/* Writes why a volume is not ready: its error, or that it is not read yet. */
void volume_say_unready(char *text, size_t size, shown_volume *v, const char *id);
/* Holds all volumes; returns their number. */
int volumes_hold_all(volumes *all, shown_volume *held[VOLUMES_MAX + COPIES_MAX]);
/* Describe one volume, or all, as new JSON objects. */
json_t *volume_describe(shown_volume *v);
json_t *volumes_describe(volumes *all);
/* Starts to make a coarser copy of a time of `parent`, which must be ready, and holds it. It
 * replaces the copy that viewer `who` has of the same volume. NULL: too many copies, or no memory.
 */
shown_volume *volumes_copy(volumes *all, shown_volume *parent, int time,
                           const cvol_compress_options *options, const char *who);
/* Removes a copy, and cancels its making; -1: not a copy. */
int volumes_remove(volumes *all, shown_volume *v);
/* Bytes of arrays and samples in memory. */
uint64_t volumes_resident_bytes(volumes *all);

#endif
