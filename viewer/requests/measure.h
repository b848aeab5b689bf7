/* Distances, angles and statistics of regions. */
#ifndef CVOL_VIEWER_REQUESTS_MEASURE_H
#define CVOL_VIEWER_REQUESTS_MEASURE_H

#include "viewer/service/request.h"

/* POST api/1/volumes/ID/measure */
answer measure_post(request *r);

#endif
