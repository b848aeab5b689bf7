/* Coarser copies of volumes. */
#ifndef CVOL_VIEWER_REQUESTS_COPY_H
#define CVOL_VIEWER_REQUESTS_COPY_H

#include "viewer/service/request.h"

/* POST api/1/volumes/ID/copy */
answer copy_post(request *r);
/* DELETE api/1/volumes/ID */
answer volume_delete(request *r);

#endif
