/* The sample at a place of a picture. */
#ifndef CVOL_VIEWER_REQUESTS_PICK_H
#define CVOL_VIEWER_REQUESTS_PICK_H

#include "viewer/service/request.h"

/* POST api/1/pick */
answer pick_post(request *r);

#endif
