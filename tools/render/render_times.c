/* --over-time: an animation with a picture of each time. All pictures share colours and grey
 * levels, which are fitted to the values of up to FITTED times, spread from the first to the last.
 */
#include <stdlib.h>
#include <string.h>

#include "tools/render/render_picture.h"

enum { FITTED = 8 /* times to fit values to, at most */ };

int check_over_time(render_arguments *a)
{
    if (!a->over_time)
        return EXIT_DONE;
    if (a->turntable_given)
        return report_error(EXIT_MISUSED, "--turntable cannot be combined with --over-time");
    if (a->common.read.has_index)
        return report_error(EXIT_MISUSED, "--time cannot be combined with --over-time");
    a->turntable_given = 1;
    a->turntable = 2; /* the real number is known when the file is open */
    return EXIT_DONE;
}

int open_time(cvol_context *context, scene *s, render_arguments *a, const char *path, int time)
{
    render_arguments at = *a;
    const cvol_histogram *shared = s->shared;
    scene fresh = {.options = s->options, .engine = s->engine, .rho = s->rho, .shared = shared};
    memset(fresh.options.window, 0, sizeof fresh.options.window);
    close_scene(s);
    *s = fresh;
    at.common.read.has_index = 1;
    at.common.read.index = time;
    const int status = open_channels(context, s, &at, path);
    a->common.choice_printed = at.common.choice_printed;
    return status;
}

/* Fits the values of one channel at some times. */
static int fit_channel(cvol_context *context, cvol_histogram *out, const scene *fresh,
                       const render_arguments *a, const char *path)
{
    const int count = a->turntable < FITTED ? a->turntable : FITTED;
    cvol_histogram *each = calloc((size_t)count, sizeof *each);
    int status = each ? EXIT_DONE : report_error(EXIT_FAILED, "not enough memory");
    for (int k = 0; k < count && !status; k++) {
        common_options at = a->common;
        scene s = {.engine = fresh->engine};
        override_progress("fitting values", (double)k / count);
        at.read.has_index = 1;
        at.read.index = count > 1 ? (int)((double)k * (a->turntable - 1) / (count - 1)) : 0;
        status = open_input(context, &s.in, path, &at);
        if (!status)
            status = find_histogram(context, &each[k], &s);
        close_scene(&s);
    }
    override_progress(NULL, 0);
    if (!status)
        cvol_histogram_join(out, each, (size_t)count);
    free(each);
    return status;
}

int fit_times(cvol_context *context, cvol_histogram **out, const scene *fresh, render_arguments *a,
              const char *path)
{
    int times, channels;
    *out = NULL;
    int status = count_drawn(context, fresh, a, path, &times, &channels);
    if (status)
        return status;
    if (times == 1)
        return report_error(EXIT_MISUSED, "%s: has one time: leave out --over-time", path);
    a->turntable = times;
    *out = calloc((size_t)channels, sizeof **out);
    if (!*out)
        return report_error(EXIT_FAILED, "not enough memory");
    for (int c = 0; c < channels && !status; c++) {
        render_arguments of = *a;
        if (channels > 1) {
            of.common.read.has_channel = 1;
            of.common.read.channel = c;
        }
        status = fit_channel(context, *out + c, fresh, &of, path);
    }
    return status;
}
