/* Work that takes longer than an answer may: frames above all, done by as many threads as there are
 * cores.
 *
 * Jobs belong to viewers, by name. Of each viewer one waits at most and one runs at most: a newer
 * one takes the place of the one that waits and cancels the one that runs. Whoever was served
 * longest ago is next, so that nobody starves. Jobs without a viewer's name wait in line, and are
 * served in turn with the viewers. Large ones have threads of their own, which give way, so that
 * small ones need not wait for them.
 */
#ifndef CVOL_VIEWER_JOBS_H
#define CVOL_VIEWER_JOBS_H

#include <stdint.h>

#include "answer.h"
#include "options.h"
#include "pace.h"

enum { VIEWER_NAME_BYTES = 64, VIEWERS_MAX = 256, WAITING_MAX = 256 };

typedef struct jobs jobs;
typedef struct job job;

struct job {
    char viewer[VIEWER_NAME_BYTES]; /* "": nobody's */
    int64_t sequence;               /* -1: one more than the viewer's last */
    int large;                      /* it takes many times as long as a frame in motion */
    answer (*run)(job *j, cvol_context *context, void *state); /* on a thread of its own */
    void *state;
    void (*free_state)(void *state);
    void (*done)(void *user, answer a); /* always called, once, on any thread */
    void *user;
    /* what run() may look at */
    double queue_ms;
    int threads;
    pace *pace; /* what the viewer's frames took; of nobody's NULL */
    /* the scheduler's own */
    jobs *all;
    double queued_at;
    int cancelled;
    struct stream *stream;
    job *next;
};

/* NULL: no memory, or no threads. */
jobs *jobs_open(int threads);
/* Answers what waits, and what comes from now on, by 503, and cancels what runs; NULL is allowed.
 */
void jobs_stop(jobs *all);
/* After nobody can add any more. */
void jobs_free(jobs *all);
/* Takes a copy of the job, and answers it in any case. */
void jobs_add(jobs *all, const job *j);
/* {"viewers", "waiting", "frames", "cancelled"}: a new object. */
json_t *jobs_describe(jobs *all);
/* Milliseconds of a clock that only goes forward. */
double jobs_now(void);
/* What a failure of the library is answered with: 409 if the job was cancelled. */
answer jobs_failed(const job *j, const cvol_context *context, int code);

#endif
