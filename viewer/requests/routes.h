/* From paths to handlers: the requests that every kind of service answers. */
#ifndef CVOL_VIEWER_REQUESTS_ROUTES_H
#define CVOL_VIEWER_REQUESTS_ROUTES_H

#include "viewer/service/request.h"

/* Answers a request; status 0: a job answers it later. */
answer route(request *r);
/* Describes a service as a new JSON object, without formats of films. */
json_t *service_describe(const service *s);

#endif
