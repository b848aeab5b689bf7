/* The command that reproduces a picture. */
#ifndef CVOL_VIEWER_REQUESTS_COMMAND_H
#define CVOL_VIEWER_REQUESTS_COMMAND_H

#include "viewer/service/request.h"

/* POST api/1/command */
answer command_post(request *r);

#endif
