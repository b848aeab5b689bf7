/* Reads and compresses volumes for the viewer. */
#ifndef CVOL_VIEWER_VOLUMES_VOLUME_READ_H
#define CVOL_VIEWER_VOLUMES_VOLUME_READ_H

#include "viewer/base/options.h"
#include "viewer/volumes/shown_volume.h"

/* Reads the file, compresses it if necessary, and sets the constant fields. A later time of a
 * volume does not keep its samples. */
int volume_read(cvol_context *context, shown_volume *v, const viewer_options *options);
/* The same for a copy, from its parent. */
int volume_make_copy(cvol_context *context, shown_volume *v, const viewer_options *options);
/* volume_values.c: sets the histogram of a volume of several times, whose first time was read, to
 * that of up to 8 of them, so that all times have the same colours. */
int volume_fit_values(cvol_context *context, shown_volume *v, const viewer_options *options);
/* Draws small pictures of all levels, so that the first frames are fast. */
void volume_warm(cvol_context *context, shown_volume *v);

#endif
