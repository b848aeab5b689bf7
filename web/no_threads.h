/* Work of a service without threads: it is done at once. */
#ifndef CVOL_WEB_NO_THREADS_H
#define CVOL_WEB_NO_THREADS_H

#include "viewer/service/request.h"

/* A request from JavaScript, in request.connection. Parameters of the URL are "name=value" texts,
 * decoded, each with its zero byte; an empty one ends them. */
typedef struct web_call {
    const char *query;
} web_call;

#endif
