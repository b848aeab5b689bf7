/* Jobs: requests that take long, mainly frames, done by one thread per core.
 *
 * A job can have the name of a viewer. Each viewer has at most one waiting and one running job: a
 * new job replaces the waiting one and cancels the running one. The viewer whose last job is oldest
 * comes next, so no viewer starves. Jobs without a name wait in order of arrival and take turns
 * with the viewers. Large jobs have their own threads with low priority, so small jobs do not wait
 * for them.
 */
#ifndef CVOL_VIEWER_SERVICE_JOBS_H
#define CVOL_VIEWER_SERVICE_JOBS_H

#include <stdint.h>

#include "viewer/base/answer.h"
#include "viewer/base/options.h"
#include "viewer/service/pace.h"

enum { VIEWER_NAME_BYTES = 64, VIEWERS_MAX = 256, WAITING_MAX = 256 };

typedef struct jobs jobs;
typedef struct job job;

struct job {
    char viewer[VIEWER_NAME_BYTES]; /* "": no viewer */
    int64_t sequence;               /* -1: one more than the last of the viewer */
    int large;                      /* 1: it takes much longer than a frame in motion */
    answer (*run)(job *j, cvol_context *context, void *state); /* called on a worker thread */
    void *state;
    void (*free_state)(void *state);
    void (*done)(void *user, answer a); /* always called, once, on any thread */
    void *user;
    /* for run() */
    double queue_ms;
    int threads;
    pace *pace; /* times of the viewer's frames; NULL: no viewer */
    /* for the scheduler */
    jobs *all;
    double queued_at;
    int cancelled;
    struct stream *stream;
    job *next;
};

/* NULL: no memory, or no threads. */
jobs *jobs_open(int threads);
/* Answers waiting and later jobs with 503, and cancels running ones; NULL is allowed. */
void jobs_stop(jobs *all);
/* Call it when no thread can add jobs any more. */
void jobs_free(jobs *all);
/* Copies the job; always answers it. */
void jobs_add(jobs *all, const job *j);
/* For tests: a viewer without requests for this time makes room for others when there are too many.
 */
void jobs_set_forget_ms(jobs *all, double forget_ms);
/* {"viewers", "waiting", "jobs", "cancelled"}: a new object. "jobs": the number of those that were
 * begun. */
json_t *jobs_describe(jobs *all);
/* Milliseconds of a monotonic clock. */
double jobs_now(void);
/* The answer for a failure of the library: 409 if the job was cancelled. */
answer jobs_failed(const job *j, const cvol_context *context, int code);

#endif
