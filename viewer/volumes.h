/* The volumes that are shown: read, and compressed where they are not, beside the server's work.
 *
 * One thread reads those of the command line, one after the other; each copy has a thread of its
 * own. What a volume is does not change once it is ready, so that whoever holds it may use it.
 */
#ifndef CVOL_VIEWER_VOLUMES_H
#define CVOL_VIEWER_VOLUMES_H

#include <jansson.h>

#include "options.h"
#include "shown_volume.h"

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

#endif
