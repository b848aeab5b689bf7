/* Volumes of labels: --labels, --label-table, and volumes of more labels than colours by value
 * show (cvol_transfer_create_auto). */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "render_options.h"

/* Labels of more values are numbered; those of fewer have colours by value. */
#define BY_VALUE_MOST 32

int check_label_options(const render_arguments *a, cvol_mode mode)
{
    const char *given = a->labels_text ? "--labels" : a->label_file ? "--label-table" : NULL;
    const char *other = a->transfer_given    ? "--transfer"
                        : a->colormap        ? "--colormap"
                        : a->window_text     ? "--window"
                        : a->certify         ? "--certify"
                        : a->channel_colours ? "--channel-colors"
                                             : NULL;
    if (!given)
        return EXIT_DONE;
    if (mode != CVOL_MODE_COMPOSITE)
        return report_error(EXIT_MISUSED, "%s works only with --mode composite", given);
    return other ? report_error(EXIT_MISUSED, "%s cannot be combined with %s", given, other)
                 : EXIT_DONE;
}

/* Numbers the labels of a volume without --labels if they have names or colours in their own file,
 * or are many. Exit status. */
static int needs_numbers(int *out, const cvol_volume *volume, const char *path)
{
    label_table table;
    label_values values = {0};
    *out = 0;
    if (!cvol_type_is_integer(volume->grid.type) || !cvol_volume_is_labels(volume, path))
        return EXIT_DONE;
    int status = read_labels(&table, NULL, path);
    if (!status)
        status = count_labels(&values, volume, path);
    *out = !status && (table.count > 0 || values.count > BY_VALUE_MOST);
    if (*out && values.count > LABELS_DRAWN_MAX + 1) {
        clear_progress();
        fprintf(stderr,
                "cvol: %s: has %zu labels, more than the %d that have their own colours in a "
                "picture; choose some with --labels\n",
                path, values.count - 1, LABELS_DRAWN_MAX);
        *out = 0;
    }
    free_values(&values);
    free_labels_table(&table);
    return status;
}

int choose_labels(cvol_context *context, scene *s, const render_arguments *a, const char *path)
{
    int wanted = a->labels_text || a->label_file;
    if (wanted && a->is_channel)
        return report_error(EXIT_MISUSED, "%s: has several channels: choose one with --channel",
                            path);
    if (wanted && check_whole_samples(&s->in, path))
        return EXIT_MISUSED;
    if (!wanted && (s->options.mode != CVOL_MODE_COMPOSITE || strcmp(a->transfer_name, "auto") ||
                    a->colormap || a->window_text || a->is_channel || a->certify ||
                    (s->in.array && !may_be_labels(context, &s->in, BY_VALUE_MOST))))
        return EXIT_DONE;
    int status = need_volume(context, &s->in);
    if (!status && !wanted)
        status = needs_numbers(&wanted, s->in.volume, path);
    if (status || !wanted) {
        if (s->in.array) {
            cvol_volume_free(s->in.volume);
            s->in.volume = NULL;
        }
        return status;
    }
    s->labels = calloc(1, sizeof *s->labels);
    if (!s->labels)
        return report_error(EXIT_FAILED, "not enough memory");
    const label_choice choice = {a->labels_text, a->label_file, "--labels", "--label-table"};
    status = number_labels(context, s->labels, &s->in.volume, &choice, path);
    cvol_array_free(s->in.array);
    s->in.array = NULL;
    s->in.are_labels = 1;
    return status;
}
