/* Reads and compresses volumes for the viewer. */
#ifndef CVOL_VIEWER_VOLUME_READ_H
#define CVOL_VIEWER_VOLUME_READ_H

#include "options.h"
#include "shown_volume.h"

/* Reads the file, compresses it if necessary, and sets the constant fields. */
int volume_read(cvol_context *context, shown_volume *v, const viewer_options *options);
/* The same for a copy, from its parent. */
int volume_make_copy(cvol_context *context, shown_volume *v);
/* Draws small pictures of all levels, so that the first frames are fast. */
void volume_warm(cvol_context *context, shown_volume *v);

#endif
