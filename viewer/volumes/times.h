/* The times of volumes that have several. A time is read when a request needs it, as a volume of
 * its own. The last ones stay in memory, within a limit. */
#ifndef CVOL_VIEWER_VOLUMES_TIMES_H
#define CVOL_VIEWER_VOLUMES_TIMES_H

#include "viewer/volumes/shown_volume.h"

enum { TIMES_LEAST = 2 }; /* these stay, whatever the limit is */

typedef struct open_times open_times;

/* most: bytes of arrays and their renderers to keep. NULL: no memory. */
open_times *times_open(uint64_t most);
/* Releases all times; NULL is allowed. */
void times_close(open_times *all);
/* Holds a volume at a time, 0 <= time < series->times, and reads it if it is not open. If another
 * thread reads it at the moment, this one waits for it. The caller releases *out. Returns a code of
 * the library. */
int times_hold(cvol_context *context, shown_volume **out, shown_volume *series, int time);
/* The number of open times besides the first ones, and the bytes of their arrays. */
int times_count(open_times *all, uint64_t *bytes);

#endif
