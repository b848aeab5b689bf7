/* Who may ask: the token in the path, and the names that the server goes by.
 *
 * A page of another site can make a browser send requests here. It does not know the token, may not
 * read answers, and says where it comes from (Origin); a name of its own that it lets point here
 * (DNS rebinding) is not one of ours (Host).
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

/* A token of 128 random bits, and the names; the options' texts must stay. 0, or -1: the system has
 * no random numbers. */
int gate_make(gate *g, const viewer_options *options);
/* What follows the token in a path; or NULL, and *refusal says why. host, origin, site: the
 * request's headers of these names (Sec-Fetch-Site), or NULL. */
const char *gate_pass(const gate *g, answer *refusal, const char *path, const char *host,
                      const char *origin, const char *site);

#endif
