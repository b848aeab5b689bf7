/* Connections: HTTP by libmicrohttpd, one request after the other on each. */
#ifndef CVOL_VIEWER_SERVER_H
#define CVOL_VIEWER_SERVER_H

#include "gate.h"
#include "request.h"

enum { CONNECTIONS_MAX = 128, BODY_MAX = 1 << 20 };

typedef struct server server;

/* Listens; NULL: `message` is the sentence why not. */
server *server_open(char *message, size_t message_bytes, service *s, const gate *g);
int server_port(const server *s);
/* Closes connections whose request, or whose taking of an answer, does not come to an end. */
void server_sweep(server *s);
/* The jobs must have ended, so that none waits for an answer. */
void server_close(server *s);

#endif
