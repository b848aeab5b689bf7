/* The requests of the server of cvol view. */
#ifndef CVOL_VIEWER_HTTP_SERVER_ROUTES_H
#define CVOL_VIEWER_HTTP_SERVER_ROUTES_H

#include "viewer/service/request.h"

/* Adds the server's own requests and the page to a service. */
void server_routes_set(service *s);
/* Answers a request, like route(), and keeps a program running that was about to end. */
answer server_route(request *r);

#endif
