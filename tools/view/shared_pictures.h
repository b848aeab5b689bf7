/* Pictures of the viewer by several processes (tools/mpi). */
#ifndef CVOL_TOOLS_SHARED_PICTURES_H
#define CVOL_TOOLS_SHARED_PICTURES_H

#include "viewer/base/options.h"

/* NULL: this process draws alone. */
extern viewer_draw_shared *shared_pictures;

#endif
