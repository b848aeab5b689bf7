/* A request, and how it is handled: what is quick is answered at once, what takes its time is a
 * job.
 */
#ifndef CVOL_VIEWER_REQUEST_H
#define CVOL_VIEWER_REQUEST_H

#include <stdatomic.h>
#include <stdint.h>

#include "answer.h"
#include "fields.h"
#include "jobs.h"
#include "volumes.h"

typedef struct request request;
typedef struct films films;

/* What handlers work on. */
typedef struct service {
    const viewer_options *options;
    volumes *volumes;
    jobs *jobs;
    films *films;
    int threads;
    atomic_int end_asked;
    /* It ends at end_ms, by jobs_now, unless it is asked for something from stay_ms on; 0: no. */
    _Atomic int64_t end_ms, stay_ms;
} service;

struct request {
    service *service;
    const char *method; /* "GET", ... */
    const char *path;   /* behind the token and its slash */
    char name[64];      /* what stands in the path for the route's star */
    const char *body;   /* NULL: empty */
    size_t body_bytes;
    void *connection; /* the server's */
};

/* A parameter of the address, as ?name=value; NULL: not there. */
const char *request_query(const request *r, const char *name);
/* Whether the address has no other parameters than these, with spaces between; else *refusal names
 * one. */
int request_knows(const request *r, const char *names, answer *refusal);
/* Hands the request to a job, which answers it; run, state and free_state as in jobs.h. The answer
 * to return from the handler. who: a viewer, or ""; large: as of a job. */
answer request_later(request *r, const char *who, int64_t sequence, int large,
                     answer (*run)(job *j, cvol_context *context, void *state), void *state,
                     void (*free_state)(void *state));
/* The volume that the path names, held, and ready; NULL: *refusal says why not. */
shown_volume *request_ready_volume(const request *r, answer *refusal);

/* Answers a request, or has it answered later: then the status is 0. */
answer route(request *r);

#endif
