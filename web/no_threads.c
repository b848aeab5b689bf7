/* Work of a service without threads: jobs and background work run at once. It takes the place of
 * viewer/service/jobs.c, viewer/base/background.c and of the connections of viewer/http/server.c.
 */
#include "no_threads.h"

#include <emscripten.h>
#include <stdio.h>
#include <string.h>

#include "viewer/base/background.h"

double jobs_now(void)
{
    return emscripten_get_now();
}

int run_in_background(void *(*run)(void *), void *argument)
{
    run(argument);
    return 0;
}

answer jobs_failed(const job *j, const cvol_context *context, int code)
{
    (void)j;
    return answer_failure(context, code);
}

answer request_later(request *r, const char *who, int64_t sequence, int large,
                     answer (*run)(job *j, cvol_context *context, void *state), void *state,
                     void (*free_state)(void *state))
{
    job j = {.sequence = sequence, .large = large, .run = run, .state = state, .threads = 1};
    (void)r;
    snprintf(j.viewer, sizeof j.viewer, "%s", who);
    cvol_context *context = cvol_context_create();
    const answer a = context ? run(&j, context, state)
                             : answer_error(500, "not enough memory for a context");
    cvol_context_free(context);
    free_state(state);
    return a;
}

/* ---- parameters of the URL ------------------------------------------------------------------- */

const char *request_query(const request *r, const char *name)
{
    const web_call *call = r->connection;
    const size_t length = strlen(name);
    for (const char *at = call->query; *at; at += strlen(at) + 1)
        if (!strncmp(at, name, length) && at[length] == '=')
            return at + length + 1;
    return NULL;
}

/* 1 if the list of names, separated by spaces, has this one. */
static int has_name(const char *names, const char *name, size_t length)
{
    while (*names) {
        const size_t size = strcspn(names, " ");
        if (size == length && !strncmp(names, name, size))
            return 1;
        names += size + strspn(names + size, " ");
    }
    return 0;
}

int request_knows(const request *r, const char *names, answer *refusal)
{
    const web_call *call = r->connection;
    for (const char *at = call->query; *at; at += strlen(at) + 1) {
        const size_t length = strcspn(at, "=");
        if (!has_name(names, at, length)) {
            *refusal = answer_error(400, "unknown parameter %.*s: give %s",
                                    length < 60 ? (int)length : 60, at, names);
            return 0;
        }
    }
    return 1;
}
