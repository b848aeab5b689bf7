/* Connections: HTTP by libmicrohttpd, one request after the other on each. */
#ifndef CVOL_VIEWER_HTTP_SERVER_H
#define CVOL_VIEWER_HTTP_SERVER_H

#include "viewer/http/access.h"
#include "viewer/service/request.h"

enum { CONNECTIONS_MAX = 128, BODY_MAX = 1 << 20 };

typedef struct server server;

/* Limits of connections. A client is unknown until it has sent the token: then it has unknown_ms
 * for its request and the answer, and later receiving_ms for each request. It must receive an
 * answer, or step_bytes more of it, every sending_ms. */
typedef struct server_limits {
    double unknown_ms, receiving_ms, sending_ms;
    uint64_t step_bytes;
} server_limits;

/* Starts listening; NULL: failed, with the reason in `message`. */
server *server_open(char *message, size_t message_bytes, service *s, const access_rules *rules);
/* For tests. */
void server_set_limits(server *s, const server_limits *limits);
int server_port(const server *s);
/* Closes connections that exceed their time limit. */
void server_sweep(server *s);
/* Call it after the jobs have ended. */
void server_close(server *s);

#endif
