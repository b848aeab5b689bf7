/* Pictures within a time budget: a coarse level at once, finer ones as time allows. A level is
 * expected to take about GROWTH times the time of the next coarser one, or, once it was drawn, its
 * measured time. A level that turns out to be late is abandoned, and the picture before it
 * stays. */
#define _POSIX_C_SOURCE 200809L
#include <stdlib.h>
#include <string.h>
#include <time.h>

#include "base/context.h"
#include "base/memory.h"
#include "render/engine/engine.h"
#include "render/view/options.h"

#define COARSEST 3
#define GROWTH 4

static double milliseconds(void)
{
    struct timespec t;
    clock_gettime(CLOCK_MONOTONIC, &t);
    return 1e3 * (double)t.tv_sec + 1e-6 * (double)t.tv_nsec;
}

/* Forwards progress to the caller, and stops a late level. */
typedef struct watch {
    cvol_progress_fn progress;
    void *user;
    double deadline; /* 0: none */
    int late;
} watch;

static int on_progress(void *user, const char *what, double fraction)
{
    watch *w = user;
    if (w->progress && w->progress(w->user, what, fraction))
        return 1;
    w->late = w->deadline > 0 && fraction < 1 && milliseconds() > w->deadline;
    return w->late;
}

/* A picture in perspective is drawn in parts: a copy of the picture, in case one is abandoned. NULL
 * without memory. */
static float *keep_picture(const cvol_image *image)
{
    const size_t pixels = (size_t)image->width * (size_t)image->height;
    float *kept = cvol_allocate(pixels, 5 * sizeof *kept);
    if (kept && image->values)
        memcpy(kept, image->values, 4 * pixels * sizeof *kept);
    else if (kept)
        memcpy(kept, image->rgba, 4 * pixels);
    if (kept && image->depth)
        memcpy(kept + 4 * pixels, image->depth, pixels * sizeof *kept);
    return kept;
}

static void restore_picture(cvol_image *image, const float *kept)
{
    const size_t pixels = (size_t)image->width * (size_t)image->height;
    if (image->values)
        memcpy(image->values, kept, 4 * pixels * sizeof *kept);
    else
        memcpy(image->rgba, kept, 4 * pixels);
    if (image->depth)
        memcpy(image->depth, kept + 4 * pixels, pixels * sizeof *kept);
}

/* Draws the image's next level; *late: it was abandoned. */
static int draw(cvol_context *context, cvol_renderer *renderer, cvol_image *image,
                const cvol_render_options *options, int level, double deadline, int *late)
{
    watch w = {context->progress, context->progress_user, deadline, 0};
    cvol_render_options of_level = *options;
    const int in_parts = deadline > 0 && options->camera.fov_deg > 0;
    float *kept = in_parts ? keep_picture(image) : NULL;
    if (in_parts && !kept)
        return cvol_fail_memory(context, (size_t)image->width * (size_t)image->height, "a picture");
    of_level.level = level;
    cvol_context_set_progress(context, on_progress, &w);
    const int code = cvol_renderer_render(context, renderer, image, &of_level);
    cvol_context_set_progress(context, w.progress, w.user);
    *late = code == CVOL_ERROR_CANCELLED && w.late;
    if (*late && kept)
        restore_picture(image, kept);
    free(kept);
    return code;
}

/* Clears the measured times of levels if another kind of picture is requested. */
static void keep_level_times(cvol_level_times *pace, const cvol_render_options *options)
{
    const int lit = options->shading.on != 0;
    if (pace->width == options->width && pace->height == options->height &&
        pace->mode == options->mode && pace->lit == lit)
        return;
    *pace = (cvol_level_times){options->width, options->height, options->mode, lit, {0}};
}

/* The first level: the finest that is known to be fast enough; if there is none, or if all are
 * requested, the coarsest. */
static int choose_first(const cvol_level_times *pace, int finest, double budget_ms, int all)
{
    for (int level = finest; level < COARSEST && !all; level++)
        if (pace->ms[level] > 0 && pace->ms[level] <= budget_ms)
            return level;
    return finest > COARSEST ? finest : COARSEST; /* rendering refuses an invalid value */
}

int cvol_renderer_refine(cvol_context *context, cvol_renderer *renderer, cvol_image *image,
                         const cvol_render_options *options, double budget_ms,
                         cvol_picture_fn drawn, void *user, cvol_refine_report *report)
{
    const double start = milliseconds();
    cvol_level_times *pace = &renderer->pace;
    cvol_render_options full;
    const int refused = cvol_render_options_complete(context, &full, options);
    if (refused)
        return refused;
    if (!(budget_ms > 0))
        return cvol_fail(context, CVOL_ERROR_ARGUMENT, "a budget of %g ms, must be above 0",
                         budget_ms);
    if (renderer->engine != &cvol_sheet_engine)
        return cvol_fail(context, CVOL_ERROR_ARGUMENT, "only engine sheet has levels to refine by");
    keep_level_times(pace, &full);
    int level = choose_first(pace, full.level, budget_ms, drawn != NULL), have = 0;
    for (;;) {
        const double begin = milliseconds();
        int late = 0;
        const int code = draw(context, renderer, image, &full, level, have ? start + budget_ms : 0,
                              &late);
        const double took = milliseconds() - begin;
        if (code && !late)
            return code;
        if (late && pace->ms[level] < GROWTH * took)
            pace->ms[level] = GROWTH * took;
        if (late)
            break;
        pace->ms[level] = took;
        have = 1;
        if (report)
            *report = (cvol_refine_report){level, took, 0};
        if ((drawn && drawn(user, image, level)) || level <= full.level)
            break;
        level--;
        const double expected = pace->ms[level] > 0 ? pace->ms[level] : GROWTH * took;
        if (milliseconds() - start + expected > budget_ms)
            break;
    }
    if (report)
        report->total_ms = milliseconds() - start;
    return CVOL_OK;
}
