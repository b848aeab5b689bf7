/* The volumes of files for cvol view and export: a file of several times or channels has several.
 */
#define _GNU_SOURCE
#include "tools/view/view_list.h"

#include <errno.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

/* Adds a volume; takes over the name. Exit status. */
static int add_view(view_list *list, const char *path, char *name, const cvol_read_options *read)
{
    viewer_volume *volumes = realloc(list->volumes, ((size_t)list->count + 1) * sizeof *volumes);
    if (volumes)
        list->volumes = volumes;
    char **names = volumes ? realloc(list->names, ((size_t)list->count + 1) * sizeof *names) : NULL;
    if (!names) {
        free(name);
        return report_error(EXIT_FAILED, "not enough memory");
    }
    list->names = names;
    names[list->count] = name;
    volumes[list->count++] = (viewer_volume){.path = path, .name = name, .read = *read};
    return EXIT_DONE;
}

/* "scan.nii, DAPI"; NULL without memory. */
static char *name_view(const char *path, const volume_labels *labels, int channel)
{
    const char *slash = strrchr(path, '/'), *file = slash ? slash + 1 : path,
               *name = labels->names[channel];
    char *text;
    const int length = labels->channels == 1 ? asprintf(&text, "%s", file)
                       : name[0]             ? asprintf(&text, "%s, %s", file, name)
                                             : asprintf(&text, "%s, channel %d", file, channel);
    return length < 0 ? NULL : text;
}

/* Adds a channel of a file with all its times; labels: of the file. Exit status. */
static int add_channel(view_list *list, const common_options *common, const char *path,
                       const volume_labels *labels, int times, int channel)
{
    cvol_read_options read = common->read;
    read.has_index |= times > 1;
    if (labels->channels > 1) {
        read.has_channel = 1;
        read.channel = channel;
    }
    char *name = name_view(path, labels, channel);
    const int status = name ? add_view(list, path, name, &read)
                            : report_error(EXIT_FAILED, "not enough memory");
    if (status)
        return status;
    viewer_volume *added = &list->volumes[list->count - 1];
    added->times = times;
    added->time_values = times > 1 ? labels->times : NULL;
    added->time_unit = labels->unit;
    if (labels->channels > 1) {
        added->channel = (viewer_channel){.count = labels->channels,
                                          .first = list->count - 1 - channel,
                                          .number = channel,
                                          .name = labels->names[channel],
                                          .is_component = labels->are_colours};
        memcpy(added->channel.rgb, labels->colours + 3 * channel, sizeof added->channel.rgb);
    }
    return EXIT_DONE;
}

/* Adds the volumes of a file of several. Exit status. */
static int add_several(cvol_context *context, view_list *list, common_options *common,
                       const char *path, int times, int channels)
{
    volume_labels *more = realloc(list->named, ((size_t)list->named_count + 1) * sizeof *more);
    if (!more)
        return report_error(EXIT_FAILED, "not enough memory");
    list->named = more;
    volume_labels *labels = &more[list->named_count++];
    int status = find_labels(context, labels, common, path, times, channels);
    for (int c = 0; c < channels && !status; c++)
        status = add_channel(list, common, path, labels, times, c);
    return status;
}

/* Checks, before the server starts, that a reader knows the file. */
static int check_file(cvol_context *context, const char *path, const cvol_read_options *read)
{
    cvol_volume_stream *stream;
    if (is_cvol(path))
        return EXIT_DONE;
    const int code = cvol_volume_stream_open(context, &stream, path, read);
    cvol_volume_stream_free(stream);
    if (code)
        report_context_error(context, code, NULL);
    return code ? EXIT_FAILED : EXIT_DONE;
}

static int list_file(cvol_context *context, view_list *out, common_options *common,
                     const char *path)
{
    int times = 1, channels = 1;
    const cvol_file_kind kind = kind_of(path);
    int status = EXIT_DONE;
    if (access(path, R_OK) && !strchr(path, ':'))
        return report_error(EXIT_FAILED, "%s: %s", path, strerror(errno));
    if (kind == CVOL_FILE_SERIES || kind == CVOL_FILE_OTHER)
        status = count_volumes(context, common, path, &times, &channels) ? EXIT_FAILED : EXIT_DONE;
    if (!status && (times > 1 || channels > 1))
        return channels > VIEWS_MOST
                   ? report_error(EXIT_MISUSED,
                                  "%s: has %d channels, more than %d: choose one with --channel",
                                  path, channels, VIEWS_MOST)
                   : add_several(context, out, common, path, times, channels);
    if (!status && kind == CVOL_FILE_SERIES) { /* the chosen volume exists */
        volume_labels labels;
        status = find_labels(context, &labels, common, path, 1, 1);
        free_labels(&labels);
    }
    if (!status)
        status = check_file(context, path, &common->read);
    return status ? status : add_view(out, path, NULL, &common->read);
}

/* Reads the names and colours of labels of all volumes. Exit status. */
static int add_labels(view_list *list, const char *file)
{
    list->tables = calloc((size_t)list->count, sizeof *list->tables);
    list->labels = calloc((size_t)list->count, sizeof *list->labels);
    int status = list->tables && list->labels ? EXIT_DONE
                                              : report_error(EXIT_FAILED, "not enough memory");
    for (int i = 0; i < list->count && !status; i++) {
        const label_table *table = &list->tables[i];
        status = read_labels(&list->tables[i], file, list->volumes[i].path);
        if (status || !table->count)
            continue;
        viewer_label *labels = list->labels[i] = calloc(table->count, sizeof *labels);
        if (!labels)
            return report_error(EXIT_FAILED, "not enough memory");
        for (size_t k = 0; k < table->count; k++) {
            const label_entry *entry = &table->entries[k];
            labels[k] = (viewer_label){.value = entry->value,
                                       .name = entry->name[0] ? entry->name : NULL,
                                       .has_colour = entry->has_colour};
            memcpy(labels[k].rgb, entry->rgb, sizeof labels[k].rgb);
        }
        list->volumes[i].labels = labels;
        list->volumes[i].label_count = table->count;
    }
    return status;
}

int list_views(cvol_context *context, view_list *out, const common_options *common,
               const char *label_file, const char **paths, int count)
{
    int status = EXIT_DONE;
    *out = (view_list){0};
    for (int i = 0; i < count && !status; i++) {
        common_options own = *common;
        status = list_file(context, out, &own, paths[i]);
    }
    return status ? status : add_labels(out, label_file);
}

void free_views(view_list *list)
{
    for (int i = 0; i < list->count; i++) {
        free(list->names[i]);
        if (list->labels)
            free(list->labels[i]);
        if (list->tables)
            free_labels_table(&list->tables[i]);
    }
    for (int i = 0; i < list->named_count; i++)
        free_labels(&list->named[i]);
    free(list->named);
    free(list->names);
    free(list->labels);
    free(list->tables);
    free(list->volumes);
    *list = (view_list){0};
}
