/* Several volumes in one call: draws each, and at the end lists the failures. */
#include <stdlib.h>
#include <string.h>

#include "tools/render/render_picture.h"

/* Refuses two volumes with the same output. */
static int check_names(const render_arguments *a, const char **paths, int count)
{
    int status = EXIT_DONE;
    char **names = calloc((size_t)count, sizeof *names);
    if (!names)
        return report_error(EXIT_FAILED, "not enough memory");
    for (int i = 0; i < count && !status; i++) {
        names[i] = output_name(a->output, paths[i], 0, 0);
        if (!names[i])
            status = report_error(EXIT_FAILED, "not enough memory");
        for (int k = 0; k < i && !status; k++)
            if (!strcmp(names[i], names[k]))
                status = report_error(EXIT_MISUSED, "%s and %s would both be written to %s",
                                      paths[k], paths[i], names[i]);
    }
    for (int i = 0; i < count; i++)
        free(names[i]);
    free(names);
    return status;
}

int check_many(const render_arguments *a, const char **paths, int count)
{
    if (count == 1)
        return EXIT_DONE;
    if (a->poses)
        return report_error(EXIT_MISUSED, "--poses reads one volume, but %d were given", count);
    if (!a->output && count == 2 && has_ending(paths[1], ".png"))
        return report_error(EXIT_MISUSED, "no output: give -o %s", paths[1]);
    if (!a->output)
        return report_error(EXIT_MISUSED, "no output: give -o '{name}.png'");
    if (!strstr(a->output, "{name}"))
        return report_error(
            EXIT_MISUSED,
            "%s: this is one name for %d volumes: put {name} into it, as in -o '{name}.png'",
            a->output, count);
    return check_names(a, paths, count);
}

/* Prints one message with all names. */
static void list_failures(const char **paths, const int *statuses, int count, int failures)
{
    clear_progress();
    fprintf(stderr, "cvol: %d of %d volumes failed:", failures, count);
    for (int i = 0; i < count; i++)
        if (statuses[i])
            fprintf(stderr, " %s", paths[i]);
    fputc('\n', stderr);
}

static int print_reports(json_t *pictures, const char **paths, const int *statuses, int count)
{
    json_t *failed = json_array();
    for (int i = 0; i < count; i++)
        if (statuses[i])
            json_array_append_new(failed, json_text(paths[i]));
    return print_json(json_pack("{s:O, s:o}", "pictures", pictures, "failed", failed));
}

int render_many(cvol_context *context, const render_arguments *a, const scene *fresh,
                const char **paths, int count)
{
    int failures = 0, stopped = 0;
    int *statuses = calloc((size_t)count, sizeof *statuses);
    json_t *pictures = json_array();
    if (!statuses || !pictures) {
        free(statuses);
        json_decref(pictures);
        return report_error(EXIT_FAILED, "not enough memory");
    }
    for (int i = 0; i < count && !stopped; i++) {
        char what[96];
        json_t *report = NULL;
        snprintf(what, sizeof what, "volume %d of %d, %.40s", i + 1, count, paths[i]);
        override_progress(what, (double)i / count);
        statuses[i] = render_volume(context, a, fresh, paths[i], &report);
        override_progress(NULL, 0);
        failures += statuses[i] != 0;
        stopped = was_interrupted();
        if (report)
            json_array_append_new(pictures, report);
    }
    int status = failures ? EXIT_FAILED : EXIT_DONE;
    if (failures && !stopped)
        list_failures(paths, statuses, count, failures);
    if (a->common.json && !stopped && print_reports(pictures, paths, statuses, count))
        status = EXIT_FAILED;
    json_decref(pictures);
    free(statuses);
    return status;
}
