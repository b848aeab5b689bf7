/* The context's members, and functions to report failures and progress. */
#ifndef CVOL_BASE_CONTEXT_H
#define CVOL_BASE_CONTEXT_H

#include "cvol/base.h"

#define CVOL_MESSAGE_BYTES 1024

struct cvol_context {
    char message[CVOL_MESSAGE_BYTES];
    int threads;          /* 0: OpenMP's number */
    int threads_possible; /* the maximum; constant unless the caller sets another number */
    uint64_t limit_bytes;
    int refuses_external; /* cvol_context_set_external */
    cvol_progress_fn progress;
    void *progress_user;
    size_t found_times, found_channels; /* the number of choices in a reader's last request */
    struct cvol_team *team; /* that shares the work on arrays (base/team.h); NULL: one process */
    int holds_outputs;
    struct cvol_output **held; /* complete outputs that wait for their names */
    size_t held_count;
};

/* Stores the message and returns `code`, so that a failure is one line:
 *
 *     return cvol_fail(context, CVOL_ERROR_FORMAT, "%s: sizes has %d values", name, n);
 */
int cvol_fail(cvol_context *context, int code, const char *format, ...)
    __attribute__((format(printf, 3, 4)));

/* Stores the message of a failed allocation; returns CVOL_ERROR_MEMORY. */
int cvol_fail_memory(cvol_context *context, size_t bytes, const char *what);
/* Fails with CVOL_ERROR_LIMIT if a size of a file does not fit into a size_t. */
int cvol_check_size(cvol_context *context, const char *path, const char *field, uint64_t size);

/* Calls the progress callback; CVOL_OK or CVOL_ERROR_CANCELLED (with its message). Call it from the
 * calling thread, outside parallel regions. */
int cvol_report_progress(cvol_context *context, const char *what, double fraction);

#endif
