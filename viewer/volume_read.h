/* How a volume becomes ready: from a file, or from another volume. */
#ifndef CVOL_VIEWER_VOLUME_READ_H
#define CVOL_VIEWER_VOLUME_READ_H

#include "options.h"
#include "shown_volume.h"

/* Reads the file, compresses it if it is not, and fills in what does not change any more. */
int volume_read(cvol_context *context, shown_volume *v, const viewer_options *options);
/* The same of a copy: from its parent. */
int volume_make_copy(cvol_context *context, shown_volume *v);
/* Draws small pictures of all levels, so that the first ones that somebody sees need not wait. */
void volume_warm(cvol_context *context, shown_volume *v);

#endif
