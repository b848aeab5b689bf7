/* The difference of the pictures of two volumes. */
#ifndef CVOL_VIEWER_REQUESTS_DIFFERENCE_H
#define CVOL_VIEWER_REQUESTS_DIFFERENCE_H

#include "viewer/service/request.h"

/* POST api/1/difference */
answer difference_post(request *r);

#endif
