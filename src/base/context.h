/* The context's inside, and how library code reports failures and progress. */
#ifndef CVOL_BASE_CONTEXT_H
#define CVOL_BASE_CONTEXT_H

#include "cvol/base.h"

#define CVOL_MESSAGE_BYTES 1024

struct cvol_context {
    char message[CVOL_MESSAGE_BYTES];
    int threads;          /* 0: as many as OpenMP would have */
    int threads_possible; /* at most; constant unless the caller sets another number */
    uint64_t limit_bytes;
    cvol_progress_fn progress;
    void *progress_user;
    size_t found_times, found_channels; /* the numbers that a reader last had to choose from */
};

/* Stores the sentence and returns `code`, so that a failure is one line:
 *     return cvol_fail(context, CVOL_ERROR_FORMAT, "%s: sizes has %d values", name, n); */
int cvol_fail(cvol_context *context, int code, const char *format, ...)
    __attribute__((format(printf, 3, 4)));

/* The message of an allocation that failed; returns CVOL_ERROR_MEMORY. */
int cvol_fail_memory(cvol_context *context, size_t bytes, const char *what);

/* Calls the progress callback; CVOL_OK or CVOL_ERROR_CANCELLED (with its message). Call it from the
 * calling thread, outside parallel regions. */
int cvol_report_progress(cvol_context *context, const char *what, double fraction);

#endif
