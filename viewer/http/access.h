/* Authorization of requests: a secret token in the path, and the allowed host names.
 *
 * A page of another site can make a browser send requests to this server. Such a page does not know
 * the token, cannot read the answers, and the browser sends its origin (Origin). A name of its own
 * that points to this machine (DNS rebinding) is not an allowed host (Host).
 */
#ifndef CVOL_VIEWER_HTTP_ACCESS_H
#define CVOL_VIEWER_HTTP_ACCESS_H

#include "viewer/base/answer.h"
#include "viewer/base/options.h"

#define TOKEN_LETTERS 32

typedef struct access_rules {
    char token[TOKEN_LETTERS + 1];
    const char *hosts[VIEWER_HOSTS_MAX + 4];
    int host_count;
} access_rules;

/* Makes a token of 128 random bits and the list of host names; the texts in the options must
 * outlive it. 0, or -1: the system has no random numbers. */
int access_rules_make(access_rules *rules, const viewer_options *options);
/* Returns the path after the token, or NULL and *refusal. host, origin, site: the headers Host,
 * Origin and Sec-Fetch-Site of the request, or NULL. */
const char *access_rules_check(const access_rules *rules, answer *refusal, const char *path,
                               const char *host, const char *origin, const char *site);

#endif
