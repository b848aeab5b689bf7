/* Transfer functions, fitted to a volume or from a file. */
#ifndef CVOL_VIEWER_REQUESTS_TRANSFER_H
#define CVOL_VIEWER_REQUESTS_TRANSFER_H

#include "viewer/service/request.h"

/* GET api/1/volumes/ID/transfer?name=bone, or of an overlay: ?overlay=0&name=hot&window=10,90 */
answer transfer_get(request *r);
/* POST api/1/volumes/ID/transfer, with the text of a file. */
answer transfer_post(request *r);
/* {"points": [[value, r, g, b, opacity], ...]}: a new object. */
json_t *transfer_describe(const cvol_transfer *transfer);

#endif
