/* POST api/1/volumes/ID/open: reads a time before it is shown. */
#ifndef CVOL_VIEWER_REQUESTS_OPEN_H
#define CVOL_VIEWER_REQUESTS_OPEN_H

#include "viewer/service/request.h"

answer open_post(request *r);

#endif
