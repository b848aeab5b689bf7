/* Connections: HTTP by libmicrohttpd, one request after the other on each. */
#ifndef CVOL_VIEWER_HTTP_SERVER_H
#define CVOL_VIEWER_HTTP_SERVER_H

#include "viewer/http/access.h"
#include "viewer/service/request.h"

enum { CONNECTIONS_MAX = 128, BODY_MAX = 1 << 20 };

typedef struct server server;

/* Starts listening; NULL: failed, with the reason in `message`. */
server *server_open(char *message, size_t message_bytes, service *s, const access_rules *rules);
int server_port(const server *s);
/* Closes connections that exceed their time limit. */
void server_sweep(server *s);
/* Call it after the jobs have ended. */
void server_close(server *s);

#endif
