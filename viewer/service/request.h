/* Requests: fast ones are answered at once, others become jobs. */
#ifndef CVOL_VIEWER_SERVICE_REQUEST_H
#define CVOL_VIEWER_SERVICE_REQUEST_H

#include <stdatomic.h>
#include <stdint.h>

#include "viewer/base/answer.h"
#include "viewer/base/fields.h"
#include "viewer/service/jobs.h"
#include "viewer/volumes/volumes.h"

typedef struct request request;
typedef struct films films;

/* A path and its handler. */
typedef struct route_entry {
    const char *method, *pattern; /* a star stands for one name */
    answer (*handle)(request *r);
} route_entry;

/* Shared by all handlers. */
typedef struct service {
    const viewer_options *options;
    /* Requests that this kind of service answers in addition to the common ones; the files of its
     * page (NULL: none), with status 0 for other paths. */
    const route_entry *own;
    size_t own_count;
    answer (*page)(const char *path);
    volumes *volumes;
    jobs *jobs;
    films *films;
    int threads;
    atomic_int end_requested;
    /* The viewer ends at end_ms (jobs_now), unless a request arrives after stay_ms; 0: it does not.
     */
    _Atomic int64_t end_ms, stay_ms;
} service;

struct request {
    service *service;
    const char *method; /* "GET", ... */
    const char *path;   /* after the token and its slash */
    char name[64];      /* the part of the path at the star of the route */
    const char *body;   /* NULL: empty */
    size_t body_bytes;
    void *connection; /* the server's */
};

/* A parameter of the URL, ?name=value; NULL: not there. */
const char *request_query(const request *r, const char *name);
/* 1 if the URL has no parameters but these names, separated by spaces; else *refusal names one. */
int request_knows(const request *r, const char *names, answer *refusal);
/* Makes a job that answers the request; run, state, free_state and large: as in jobs.h; who: a
 * viewer, or "". The handler must return the result. */
answer request_later(request *r, const char *who, int64_t sequence, int large,
                     answer (*run)(job *j, cvol_context *context, void *state), void *state,
                     void (*free_state)(void *state));
/* Holds the volume in the path, which must be ready; NULL: see *refusal. */
shown_volume *request_ready_volume(const request *r, answer *refusal);

#endif
