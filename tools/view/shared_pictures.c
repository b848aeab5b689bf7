/* Pictures of the viewer by several processes (shared_pictures.h). */
#include "tools/view/shared_pictures.h"

viewer_draw_shared *shared_pictures;
