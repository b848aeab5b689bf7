/* POST api/1/volumes/ID/open: reads a time before it is shown. */
#ifndef CVOL_VIEWER_OPEN_H
#define CVOL_VIEWER_OPEN_H

#include "request.h"

answer open_post(request *r);

#endif
