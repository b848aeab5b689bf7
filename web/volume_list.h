/* The volumes that a page shows, as cvol view lists them: each channel of a file with its times. */
#ifndef CVOL_WEB_VOLUME_LIST_H
#define CVOL_WEB_VOLUME_LIST_H

#include "viewer/base/options.h"

/* It is never freed: an instance ends with its memory. */
typedef struct volume_list {
    viewer_volume *volumes;
    int count;
    int last; /* the first volume that was added last */
} volume_list;

/* Adds the volumes of a .cvol file in the memory file system. name: to show. time, channel: the
 * chosen ones; -1: all. level: to read. A file that cannot be read gets a volume too, which then
 * fails. 0, or -1 without memory or for too many volumes. */
int volume_list_add(volume_list *list, const char *path, const char *name, int time, int channel,
                    int level);

/* Sets the levels of bricks of the volumes that were added last (cvol_file_part). The list owns
 * them. */
void volume_list_set_bricks(volume_list *list, uint8_t *levels, size_t count);

/* Adds a label to the volumes that were added last, after those of smaller values. name "": none; r
 * < 0: no colour. 0, or -1 without memory. */
int volume_list_add_label(volume_list *list, int value, const char *name, const double rgb[3]);

#endif
