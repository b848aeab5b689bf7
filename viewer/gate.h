/* Authorization of requests: a secret token in the path, and the allowed host names.
 *
 * A page of another site can make a browser send requests to this server. Such a page does not know
 * the token, cannot read the answers, and the browser sends its origin (Origin). A name of its own
 * that points to this machine (DNS rebinding) is not an allowed host (Host).
 */
#ifndef CVOL_VIEWER_GATE_H
#define CVOL_VIEWER_GATE_H

#include "answer.h"
#include "options.h"

#define TOKEN_LETTERS 32

typedef struct gate {
    char token[TOKEN_LETTERS + 1];
    const char *hosts[VIEWER_HOSTS_MAX + 4];
    int host_count;
} gate;

/* Makes a token of 128 random bits and the list of host names; the texts in the options must
 * outlive it. 0, or -1: the system has no random numbers. */
int gate_make(gate *g, const viewer_options *options);
/* Returns the path after the token, or NULL and *refusal. host, origin, site: the headers Host,
 * Origin and Sec-Fetch-Site of the request, or NULL. */
const char *gate_pass(const gate *g, answer *refusal, const char *path, const char *host,
                      const char *origin, const char *site);

#endif
