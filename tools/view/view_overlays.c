/* The overlays of cvol view: they are read before the server starts, so that the command reports
 * their errors. The viewer puts them on the grids of the volumes. */
#include "tools/view/view_overlays.h"

#include <stdlib.h>
#include <string.h>

/* The grid of a volume, from the header of its file. A code of the library. */
static int read_grid(cvol_context *context, cvol_grid *out, const viewer_volume *v)
{
    const cvol_file_part part = {.size = sizeof part,
                                 .time = v->read.has_index ? v->read.index : 0,
                                 .channel = v->read.has_channel ? v->read.channel : 0};
    cvol_volume_stream *stream = NULL;
    if (cvol_file_is_cvol(v->path))
        return cvol_file_read_grid(context, out, v->path, &part);
    const int code = cvol_volume_stream_open(context, &stream, v->path, &v->read);
    if (!code)
        *out = *cvol_volume_stream_grid(stream);
    cvol_volume_stream_free(stream);
    return code;
}

/* Refuses what cannot be drawn. Exit status. */
static int check_overlay(cvol_context *context, const viewer_overlay *o, const view_list *list)
{
    cvol_transfer *colours, *depths;
    cvol_grid grid;
    int code = overlay_create_transfers(context, &colours, &depths, o->source, &o->look, 1);
    cvol_transfer_free(colours);
    cvol_transfer_free(depths);
    for (int i = 0; i < list->count && !code; i++) {
        code = read_grid(context, &grid, &list->volumes[i]);
        if (code == CVOL_ERROR_CORRUPT || code == CVOL_ERROR_FORMAT) { /* the page shows it */
            code = CVOL_OK;
            continue;
        }
        if (!code)
            code = overlay_check(context, o->source, &grid, list->volumes[i].path);
    }
    return code ? report_context_error(context, code, NULL) : EXIT_DONE;
}

/* Exit status. */
static int list_labels(view_overlays *all, int i)
{
    const label_set *set = all->sets[i];
    if (!set)
        return EXIT_DONE;
    viewer_label *labels = all->labels[i] = calloc(set->count ? set->count : 1, sizeof *labels);
    for (size_t k = 0; labels && k < set->count; k++) {
        const label_entry *entry = &set->entries[k];
        labels[k] = (viewer_label){
            .value = entry->value, .name = entry->name[0] ? entry->name : NULL, .has_colour = 1};
        memcpy(labels[k].rgb, entry->rgb, sizeof labels[k].rgb);
    }
    return labels ? EXIT_DONE : report_error(EXIT_FAILED, "not enough memory");
}

static int open_one(cvol_context *context, view_overlays *out, const overlay_options *o, int i,
                    const view_list *list, int threads)
{
    viewer_overlay *shown = &out->shown[i];
    int status = read_overlay(context, &out->sources[i], &out->sets[i], o, i, threads);
    if (!status)
        status = choose_overlay_look(context, &shown->look, &out->files[i], &out->sources[i], o, i);
    if (!status)
        status = list_labels(out, i);
    shown->source = &out->sources[i];
    shown->labels = out->labels[i];
    shown->transfer = o->transfers.texts[i];
    shown->labels_text = o->labels.texts[i];
    shown->label_file = o->tables.texts[i];
    if (!status)
        status = check_overlay(context, shown, list);
    if (!status)
        warn_of_blank_overlay(shown->source, &shown->look);
    return status;
}

int open_view_overlays(cvol_context *context, view_overlays *out, const overlay_options *o,
                       const view_list *list, int threads)
{
    int status = EXIT_DONE;
    *out = (view_overlays){.count = o->files.count};
    for (int i = 0; i < list->count && out->count; i++)
        if (list->volumes[i].channel.count)
            return report_error(EXIT_MISUSED,
                                "%s: has several channels: choose one with --channel to draw an "
                                "overlay",
                                list->volumes[i].path);
    for (int i = 0; i < out->count && !status; i++)
        status = open_one(context, out, o, i, list, threads);
    return status;
}

void close_view_overlays(view_overlays *overlays)
{
    for (int i = 0; i < overlays->count; i++) {
        cvol_volume_free(overlays->sources[i].samples);
        cvol_transfer_free(overlays->files[i]);
        free(overlays->sets[i]);
        free(overlays->labels[i]);
    }
    overlays->count = 0;
}
