/* Jobs: requests that take long. */
#include "viewer/service/jobs.h"

#include <pthread.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

#include "viewer/base/priority.h"

enum { WORKERS_MAX = 16 };

typedef struct stream {
    char viewer[VIEWER_NAME_BYTES];
    int64_t newest;     /* sequence */
    uint64_t served_at; /* the count of jobs then */
    double seen_ms;
    job *running;
    int is_waiting; /* 1: a job of it is in the queue */
    pace pace;
} stream;

struct jobs {
    pthread_mutex_t lock;
    pthread_cond_t wake;
    pthread_t workers[WORKERS_MAX + WORKERS_MAX / 2];
    int worker_count, begun, cores, closing;
    int running[2];    /* number of small and of large jobs */
    int large_workers; /* these workers do only large jobs, at low priority */
    stream *streams[VIEWERS_MAX];
    int stream_count;
    double forget_ms;   /* a viewer without requests for this time makes room for others */
    uint64_t served_at; /* of jobs without a viewer */
    uint64_t served, cancelled;
    job *first; /* waiting jobs, in order of arrival */
    int waiting;
};

double jobs_now(void)
{
    struct timespec t;
    clock_gettime(CLOCK_MONOTONIC, &t);
    return 1e3 * (double)t.tv_sec + 1e-6 * (double)t.tv_nsec;
}

static void end_job(job *j, answer a)
{
    if (j->free_state)
        j->free_state(j->state);
    j->done(j->user, a);
    free(j);
}

/* ---- the next job ------------------------------------------------------------------------------
 */

static uint64_t served_at(const jobs *all, const job *j)
{
    return j->stream ? j->stream->served_at : all->served_at;
}

/* Removes a job from its place in the queue. */
static job *take(jobs *all, job **place)
{
    job *j = *place;
    *place = j->next;
    all->waiting--;
    if (j->stream)
        j->stream->is_waiting = 0;
    return j;
}

/* Removes the next job from the queue; NULL: none can run. */
static job *take_next(jobs *all, int large)
{
    job **best = NULL;
    for (job **place = &all->first; *place; place = &(*place)->next) {
        const job *j = *place;
        if ((j->stream && j->stream->running) || j->large != large)
            continue;
        if (!best || served_at(all, j) < served_at(all, *best))
            best = place;
    }
    return best ? take(all, best) : NULL;
}

static int is_cancelled(void *user, const char *what, double fraction)
{
    job *j = user;
    (void)what;
    (void)fraction;
    pthread_mutex_lock(&j->all->lock);
    const int cancelled = j->cancelled || j->all->closing;
    pthread_mutex_unlock(&j->all->lock);
    return cancelled;
}

/* The number of threads for a job: the cores divided by the jobs that can run at the same time.
 * Large jobs do not count for small ones, because they have low priority. */
static int share_cores(const jobs *all, const job *j)
{
    int running = all->running[0] + (j->large ? all->running[1] : 0);
    for (const job *other = all->first; other; other = other->next)
        running += other->large <= j->large;
    const int share = all->cores / (running > 1 ? running : 1);
    return share > 1 ? share : 1;
}

/* Each job has its own context, so that it cannot report the failure of another. */
static answer run_in_context(job *j)
{
    cvol_context *context = cvol_context_create();
    if (!context)
        return answer_error(500, "not enough memory for a context");
    cvol_context_set_threads(context, j->threads);
    cvol_context_set_progress(context, is_cancelled, j);
    const answer a = j->run(j, context, j->state);
    cvol_context_free(context);
    return a;
}

static void run_job(jobs *all, job *j)
{
    all->running[j->large]++;
    j->threads = share_cores(all, j);
    j->queue_ms = jobs_now() - j->queued_at;
    all->served++;
    if (j->stream) {
        j->stream->running = j;
        j->stream->served_at = all->served;
        j->pace = &j->stream->pace;
    } else {
        all->served_at = all->served;
    }
    pthread_mutex_unlock(&all->lock);
    const answer a = run_in_context(j);
    pthread_mutex_lock(&all->lock);
    all->running[j->large]--;
    all->cancelled += j->cancelled != 0;
    if (j->stream)
        j->stream->running = NULL;
    pthread_cond_broadcast(&all->wake);
    pthread_mutex_unlock(&all->lock);
    end_job(j, a);
    pthread_mutex_lock(&all->lock);
}

static void *work(void *argument)
{
    jobs *all = argument;
    pthread_mutex_lock(&all->lock);
    const int large = all->begun++ < all->large_workers;
    pthread_mutex_unlock(&all->lock);
    if (large)
        lower_thread_priority();
    pthread_mutex_lock(&all->lock);
    while (!all->closing) {
        job *j = take_next(all, large);
        if (j)
            run_job(all, j);
        else
            pthread_cond_wait(&all->wake, &all->lock);
    }
    pthread_mutex_unlock(&all->lock);
    return NULL;
}

/* ---- viewers ---------------------------------------------------------------------------------
 */

/* The stream of a viewer, or a new one; NULL: too many. */
static stream *find_stream(jobs *all, const char *who)
{
    const double now = jobs_now();
    int oldest = -1;
    for (int i = 0; i < all->stream_count; i++) {
        stream *s = all->streams[i];
        if (!strcmp(s->viewer, who))
            return s;
        if (!s->running && !s->is_waiting &&
            (oldest < 0 || s->seen_ms < all->streams[oldest]->seen_ms))
            oldest = i;
    }
    stream *s = NULL;
    if (all->stream_count < VIEWERS_MAX) {
        s = calloc(1, sizeof *s);
        if (s)
            all->streams[all->stream_count++] = s;
    } else if (oldest >= 0 && now - all->streams[oldest]->seen_ms > all->forget_ms) {
        s = all->streams[oldest];
        memset(s, 0, sizeof *s);
    }
    if (s) {
        snprintf(s->viewer, sizeof s->viewer, "%s", who);
        s->newest = -1;
        s->served_at = all->served;
    }
    return s;
}

/* Removes the waiting job of a stream from the queue; NULL: none. */
static job *take_waiting(jobs *all, const stream *s)
{
    for (job **place = &all->first; *place; place = &(*place)->next)
        if ((*place)->stream == s)
            return take(all, place);
    return NULL;
}

static answer superseded(int64_t by)
{
    return answer_error(409, "replaced by request %lld of this viewer", (long long)by);
}

/* Adds a job to the queue; *older: the waiting job that it replaces. Status 0, or a refusal. */
static answer line_up(jobs *all, job *j, job **older)
{
    stream *s = NULL;
    if (all->closing)
        return answer_error(503, "the viewer is ending");
    if (j->viewer[0]) {
        s = find_stream(all, j->viewer);
        if (!s)
            return answer_error(429, "there are already %d viewers: try again later", VIEWERS_MAX);
        if (j->sequence < 0)
            j->sequence = s->newest + 1;
        if (j->sequence < s->newest)
            return superseded(s->newest);
    }
    if (all->waiting >= WAITING_MAX && !(s && s->is_waiting))
        return answer_error(429, "%d requests are waiting: try again later", WAITING_MAX);
    if (s) {
        s->newest = j->sequence;
        s->seen_ms = j->queued_at;
        *older = take_waiting(all, s);
        all->cancelled += *older != NULL;
        if (s->running)
            s->running->cancelled = 1;
        j->stream = s;
        s->is_waiting = 1;
    }
    job **place = &all->first;
    while (*place)
        place = &(*place)->next;
    *place = j;
    all->waiting++;
    pthread_cond_broadcast(&all->wake); /* two kinds of workers wait for it */
    return (answer){0};
}

void jobs_add(jobs *all, const job *given)
{
    job *j = malloc(sizeof *j), *older = NULL;
    if (!j) {
        given->free_state(given->state);
        given->done(given->user, answer_error(500, "not enough memory for a request"));
        return;
    }
    *j = *given;
    j->all = all;
    j->queued_at = jobs_now();
    j->stream = NULL;
    j->pace = NULL;
    j->next = NULL;
    j->cancelled = 0;
    pthread_mutex_lock(&all->lock);
    const answer refusal = line_up(all, j, &older);
    const int64_t sequence = j->sequence; /* read it now: a worker may free the job at any time */
    pthread_mutex_unlock(&all->lock);
    if (older)
        end_job(older, superseded(sequence));
    if (refusal.status)
        end_job(j, refusal);
}

answer jobs_failed(const job *j, const cvol_context *context, int code)
{
    pthread_mutex_lock(&j->all->lock);
    const int closing = j->all->closing;
    pthread_mutex_unlock(&j->all->lock);
    if (code == CVOL_ERROR_CANCELLED && closing)
        return answer_error(503, "the viewer is ending");
    if (code == CVOL_ERROR_CANCELLED)
        return answer_error(409, "replaced by a newer request of this viewer");
    return answer_failure(context, code);
}

void jobs_set_forget_ms(jobs *all, double forget_ms)
{
    pthread_mutex_lock(&all->lock);
    all->forget_ms = forget_ms;
    pthread_mutex_unlock(&all->lock);
}

json_t *jobs_describe(jobs *all)
{
    pthread_mutex_lock(&all->lock);
    const double now = jobs_now();
    int viewers = 0;
    for (int i = 0; i < all->stream_count; i++)
        viewers += now - all->streams[i]->seen_ms < all->forget_ms;
    json_t *object = json_pack("{s:i, s:i, s:I, s:I}", "viewers", viewers, "waiting", all->waiting,
                               "jobs", (json_int_t)all->served, "cancelled",
                               (json_int_t)all->cancelled);
    pthread_mutex_unlock(&all->lock);
    return object;
}

/* ---- beginning and end ------------------------------------------------------------------------
 */

jobs *jobs_open(int threads)
{
    jobs *all = calloc(1, sizeof *all);
    if (!all)
        return NULL;
    pthread_mutex_init(&all->lock, NULL);
    pthread_cond_init(&all->wake, NULL);
    all->cores = threads;
    all->forget_ms = 60e3;
    const int workers = threads < 2 ? 2 : threads > WORKERS_MAX ? WORKERS_MAX : threads;
    all->large_workers = workers / 2;
    while (all->worker_count < workers + all->large_workers &&
           !pthread_create(&all->workers[all->worker_count], NULL, work, all))
        all->worker_count++;
    if (all->worker_count > all->large_workers)
        return all;
    jobs_free(all);
    return NULL;
}

void jobs_stop(jobs *all)
{
    if (!all)
        return;
    pthread_mutex_lock(&all->lock);
    all->closing = 1;
    job *waiting = all->first;
    all->first = NULL;
    all->waiting = 0;
    pthread_cond_broadcast(&all->wake);
    pthread_mutex_unlock(&all->lock);
    while (waiting) {
        job *next = waiting->next;
        end_job(waiting, answer_error(503, "the viewer is ending"));
        waiting = next;
    }
    for (int i = 0; i < all->worker_count; i++)
        pthread_join(all->workers[i], NULL);
    all->worker_count = 0;
}

void jobs_free(jobs *all)
{
    if (!all)
        return;
    jobs_stop(all);
    for (int i = 0; i < all->stream_count; i++)
        free(all->streams[i]);
    pthread_cond_destroy(&all->wake);
    pthread_mutex_destroy(&all->lock);
    free(all);
}
