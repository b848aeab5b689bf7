/* Slices, and single samples. */
#ifndef CVOL_VIEWER_REQUESTS_SLICE_H
#define CVOL_VIEWER_REQUESTS_SLICE_H

#include "viewer/service/request.h"

/* GET api/1/volumes/ID/slice?axis=z&index=40&window=LO,HI */
answer slice_get(request *r);
/* GET api/1/volumes/ID/value?x=1&y=2&z=3 */
answer value_get(request *r);

#endif
