/* Volumes of labels: --labels, --label-table, and volumes whose samples are labels.
 *
 * A picture shows the shape of the drawn labels, coloured by depth (cvol_image_colour_labels).
 * Where pictures have no depths, numbers of labels are drawn, which have colours by value. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "tools/render/render_options.h"
#include "tools/render/render_parts.h"

/* Labels of more values have no colours by value (cvol_transfer_create_auto). */
#define BY_VALUE_MOST 32
/* A mask, of two values, ends half way between them. */
#define MASK_VALUES 2

/* 1 if the shape of labels can be drawn. */
static int can_draw_shape(const scene *s, const render_arguments *a)
{
    return (s->engine == CVOL_ENGINE_SHEET || s->engine == CVOL_ENGINE_RAY) &&
           s->options.mode == CVOL_MODE_COMPOSITE && !a->certify;
}

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
 * or are more than `least`. Exit status. */
static int needs_numbers(cvol_context *context, int *out, const cvol_volume *volume, int least,
                         const char *path)
{
    label_table table;
    label_values values = {0};
    int status = find_label_kind(context, out, volume, path);
    if (status || !*out)
        return status;
    status = read_labels(&table, NULL, path);
    if (!status)
        status = count_labels(&values, volume, path);
    *out = !status && (table.count > 0 || values.count > (size_t)least);
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

/* Puts the shape of the numbered labels in their place. Exit status. */
static int draw_shape(cvol_context *context, scene *s)
{
    s->numbers = s->in.volume;
    s->in.volume = NULL;
    const int code = s->engine == CVOL_ENGINE_SHEET
                         ? cvol_labels_create_shape(context, &s->in.array, s->numbers)
                         : cvol_labels_create_mask(context, &s->in.volume, s->numbers);
    return code ? report_context_error(context, code, NULL) : EXIT_DONE;
}

void list_colours(double colours[3 * LABELS_DRAWN_MAX], const label_set *labels)
{
    for (size_t i = 0; i < labels->count; i++)
        memcpy(colours + 3 * i, labels->entries[i].rgb, 3 * sizeof *colours);
}

int draw_labels(cvol_context *context, cvol_renderer *renderer, cvol_image *image,
                const cvol_render_options *options, const cvol_volume *numbers,
                const label_set *labels, const cvol_transfer *transfer)
{
    double colours[3 * LABELS_DRAWN_MAX];
    list_colours(colours, labels);
    return overlay_draw_labels(context, renderer, image, options, numbers, colours, labels->count,
                               transfer);
}

int choose_labels(cvol_context *context, scene *s, const render_arguments *a, const char *path)
{
    int wanted = a->labels_text || a->label_file;
    const int has_shape = can_draw_shape(s, a), least = has_shape ? MASK_VALUES : BY_VALUE_MOST;
    if (wanted && a->is_channel)
        return report_error(EXIT_MISUSED, "%s: has several channels: choose one with --channel",
                            path);
    if (wanted && check_whole_samples(&s->in, path))
        return EXIT_MISUSED;
    if (!wanted && (s->options.mode != CVOL_MODE_COMPOSITE || strcmp(a->transfer_name, "auto") ||
                    a->colormap || a->window_text || a->is_channel || a->certify ||
                    (s->in.array && !may_be_labels(context, &s->in, least))))
        return EXIT_DONE;
    int status = need_volume(context, &s->in);
    if (!status)
        status = clear_missing_labels(&s->in);
    if (!status && !wanted)
        status = needs_numbers(context, &wanted, s->in.volume, least, path);
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
    return status || !has_shape ? status : draw_shape(context, s);
}
