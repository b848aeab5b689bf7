/* The command that reproduces a picture. */
#ifndef CVOL_VIEWER_COMMAND_H
#define CVOL_VIEWER_COMMAND_H

#include "request.h"

/* POST api/1/command */
answer command_post(request *r);

#endif
