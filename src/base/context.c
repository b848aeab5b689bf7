/* Contexts: the message of the last failure, threads, limits, progress. */
#include "base/context.h"

#include <limits.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>

#include "base/thread.h"

#define DEFAULT_LIMIT_BYTES (UINT64_C(64) << 30)

#define QUOTE(x) #x
#define VERSION_STRING(major, minor, patch) QUOTE(major) "." QUOTE(minor) "." QUOTE(patch)

const char *cvol_version(void)
{
    return VERSION_STRING(CVOL_VERSION_MAJOR, CVOL_VERSION_MINOR, CVOL_VERSION_PATCH);
}

cvol_context *cvol_context_create(void)
{
    cvol_context *context = calloc(1, sizeof *context);
    cvol_threads_survive_fork();
    if (!context)
        return NULL;
    cvol_context_set_limit_bytes(context, DEFAULT_LIMIT_BYTES);
    cvol_context_set_threads(context, 0);
    return context;
}

void cvol_context_free(cvol_context *context)
{
    if (context)
        (void)cvol_context_release_outputs(context, CVOL_ERROR_CANCELLED);
    free(context);
}

const char *cvol_context_message(const cvol_context *context)
{
    return context->message;
}

void cvol_context_set_threads(cvol_context *context, int threads)
{
    context->threads_possible = cvol_threads_possible(threads > 0 ? threads : INT_MAX);
    context->threads = threads > 0 ? context->threads_possible : 0;
}

int cvol_context_threads(const cvol_context *context)
{
#ifdef _OPENMP
    const int threads = omp_get_max_threads();
    if (context->threads)
        return context->threads;
    return threads < context->threads_possible ? threads : context->threads_possible;
#else
    (void)context;
    return 1;
#endif
}

void cvol_context_set_progress(cvol_context *context, cvol_progress_fn progress, void *user)
{
    context->progress = progress;
    context->progress_user = user;
}

void cvol_context_set_limit_bytes(cvol_context *context, uint64_t limit_bytes)
{
    context->limit_bytes = limit_bytes < SIZE_MAX ? limit_bytes : SIZE_MAX;
}

void cvol_context_set_external(cvol_context *context, int allowed)
{
    context->refuses_external = !allowed;
}

uint64_t cvol_context_limit_bytes(const cvol_context *context)
{
    return context->limit_bytes;
}

int cvol_fail(cvol_context *context, int code, const char *format, ...)
{
    va_list args;
    va_start(args, format);
    vsnprintf(context->message, sizeof context->message, format, args);
    va_end(args);
    return code;
}

int cvol_fail_memory(cvol_context *context, size_t bytes, const char *what)
{
    return cvol_fail(context, CVOL_ERROR_MEMORY, "not enough memory: %zu bytes for %s", bytes,
                     what);
}

int cvol_check_size(cvol_context *context, const char *path, const char *field, uint64_t size)
{
    if (size <= SIZE_MAX)
        return CVOL_OK;
    return cvol_fail(context, CVOL_ERROR_LIMIT,
                     "%s: %s is %llu, more than a program of 32 bits can address", path, field,
                     (unsigned long long)size);
}

int cvol_report_progress(cvol_context *context, const char *what, double fraction)
{
    if (context->progress && context->progress(context->progress_user, what, fraction))
        return cvol_fail(context, CVOL_ERROR_CANCELLED, "cancelled while %s", what);
    return CVOL_OK;
}
