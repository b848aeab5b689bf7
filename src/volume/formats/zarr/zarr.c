/* Zarr (zarr.dev), format 2 and 3: an image of OME-Zarr (ngff.openmicroscopy.org, 0.4 and 0.5) or
 * an array of up to five axes.
 *
 * A group with multiscales is read at its first level; an array of the group has the geometry of
 * its level. Arrays without a description have the last axes of t, c, z, y, x. */
#define _GNU_SOURCE
#include <errno.h>
#include <limits.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>

#include "base/context.h"
#include "volume/formats/zarr/image.h"
#include "volume/formats/zarr/labels.h"
#include "volume/formats/zarr/layer.h"
#include "volume/formats/zarr/write.h"
#include "volume/io/folder.h"
#include "volume/io/format.h"

/* The folders above an array in which its image is described. */
enum { FOLDERS_ABOVE = 4 };

static int recognise(const char *folder)
{
    static const char *const marks[] = {"zarr.json", ".zarray", ".zgroup", ".zattrs"};
    struct stat status;
    for (size_t i = 0; i < sizeof marks / sizeof *marks; i++) {
        char *mark = cvol_zarr_join(folder, marks[i]);
        const int found = mark && !stat(mark, &status) && S_ISREG(status.st_mode);
        free(mark);
        if (found)
            return 1;
    }
    return 0;
}

/* ---- arrays and their images ---------------------------------------------------------- */

/* Reads the array of a folder; *found: there is one. */
static int open_array(cvol_context *context, cvol_zarr_array *array, int *found, const char *folder)
{
    cvol_zarr_json json;
    int code = cvol_zarr_json_open(context, &json, folder, "zarr.json");
    const json_t *kind = json_object_get(json.root, "node_type");
    const json_t *format = json_object_get(json.root, "zarr_format");
    const int is_3 = json.root != NULL;
    *found = kind && json_string_value(kind) && !strcmp(json_string_value(kind), "array");
    if (!code && is_3 && json_integer_value(format) != 3)
        code = cvol_zarr_json_fail(&json, CVOL_ERROR_UNSUPPORTED, "zarr_format", format,
                                   "must be 3 in zarr.json");
    if (!code && *found)
        code = cvol_zarr_array_read_3(array, &json);
    if (!is_3 && !code) {
        cvol_zarr_json_close(&json);
        code = cvol_zarr_json_open(context, &json, folder, ".zarray");
        *found = json.root != NULL;
        if (!code && *found)
            code = cvol_zarr_array_read_2(array, &json);
    }
    cvol_zarr_json_close(&json);
    if (!code && *found && !(array->path = strdup(folder)))
        code = cvol_fail_memory(context, strlen(folder), folder);
    return code;
}

/* Finds the group above an array that describes it. *level -1: none. The caller closes it. */
static int find_above(cvol_context *context, cvol_zarr_group *group, int *level, const char *path)
{
    *level = -1;
    char *real = realpath(path, NULL);
    if (!real && errno == ENOMEM)
        return cvol_fail_memory(context, PATH_MAX, path);
    const char *inside = real ? real + strlen(real) : NULL;
    int code = CVOL_OK, is_group = 1;
    for (int i = 0; real && i < FOLDERS_ABOVE && !code && is_group && *level < 0; i++) {
        if (i)
            real[inside - real - 1] = '/';
        char *slash = i ? memrchr(real, '/', (size_t)(inside - real - 1)) : strrchr(real, '/');
        if (!slash || slash == real)
            break;
        *slash = '\0';
        inside = slash + 1;
        cvol_zarr_group_close(group);
        code = cvol_zarr_group_open(context, group, &is_group, real);
        if (!code && is_group)
            *level = cvol_zarr_group_find(group, inside);
    }
    free(real);
    return code;
}

int cvol_zarr_find_label_mark(cvol_context *context, int *out, const char *path)
{
    cvol_zarr_group group = {.attributes = NULL};
    int is_group, level = 0;
    *out = 0;
    if (!recognise(path))
        return CVOL_OK;
    int code = cvol_zarr_group_open(context, &group, &is_group, path);
    if (!code && !is_group)
        code = find_above(context, &group, &level, path);
    *out = !code && level >= 0 && json_object_get(group.attributes, "image-label");
    cvol_zarr_group_close(&group);
    return code == CVOL_ERROR_IO || code == CVOL_ERROR_MEMORY ? code : CVOL_OK;
}

/* A group without an image; one of labels lists the folders of their images. */
static int fail_no_image(cvol_context *context, const cvol_zarr_group *group, const char *path)
{
    char names[300] = "";
    const json_t *list = json_object_get(group->attributes, "labels");
    for (size_t i = 0; i < json_array_size(list); i++) {
        const char *name = json_string_value(json_array_get(list, i));
        cvol_channel_label printable;
        const size_t at = strlen(names);
        cvol_labels_set_name(&printable, name ? name : "", name ? strlen(name) : 0);
        if (printable.name[0] && at + sizeof printable.name + 2 < sizeof names)
            snprintf(names + at, sizeof names - at, "%s%s", at ? ", " : "", printable.name);
    }
    return cvol_fail(context, CVOL_ERROR_UNSUPPORTED,
                     "%s: is a Zarr group without multiscales: give the folder of an image or an "
                     "array in it%s%s",
                     path, names[0] ? ", one of " : "", names);
}

/* Opens the first level of a group. */
static int open_level(cvol_context *context, cvol_zarr_array *array, const cvol_zarr_group *group,
                      const char *path)
{
    const char *inside;
    int found = 0, code = cvol_zarr_group_level(group, 0, &inside);
    if (code)
        return code;
    if (!inside)
        return fail_no_image(context, group, path);
    char *folder = cvol_zarr_join(path, inside);
    if (!folder)
        return cvol_fail_memory(context, strlen(path), path);
    code = open_array(context, array, &found, folder);
    if (!code && !found)
        code = cvol_fail(context, CVOL_ERROR_FORMAT,
                         "%s: has neither .zarray nor zarr.json of an array, but the group names "
                         "it as its first level",
                         folder);
    free(folder);
    return code;
}

static int axis_named(const cvol_zarr_image *image, char name)
{
    for (int a = 0; a < image->rank; a++)
        if (image->axis[a] == name)
            return a;
    return -1;
}

/* The axes of an array without a description. */
static int guess_image(cvol_context *context, cvol_zarr_image *image, const cvol_zarr_array *array)
{
    if (!cvol_zarr_image_guess(image, array->rank))
        return cvol_fail(context, CVOL_ERROR_UNSUPPORTED,
                         "%s: its array has %d axes; five can be read", array->path, array->rank);
    int known = 1;
    for (int a = 0; a < array->rank; a++) {
        known = known && array->names[a] && strchr("tczyx", array->names[a]);
        for (int b = 0; b < a; b++)
            known = known && array->names[a] != array->names[b];
    }
    if (!known)
        return CVOL_OK;
    memcpy(image->axis, array->names, sizeof image->axis);
    if (axis_named(image, 'x') >= 0 && (array->rank == 1 || axis_named(image, 'y') >= 0))
        return CVOL_OK;
    return cvol_fail(context, CVOL_ERROR_FORMAT,
                     "%s: its axes are '%.*s'; a volume has the axes y and x", array->path,
                     array->rank, image->axis);
}

static int open_image(cvol_context *context, cvol_zarr_array *array, cvol_zarr_image *image,
                      cvol_zarr_group *group, const char *path)
{
    int found, is_group, level = 0;
    int code = open_array(context, array, &found, path);
    if (code)
        return code;
    if (found)
        code = find_above(context, group, &level, path);
    else if (!(code = cvol_zarr_group_open(context, group, &is_group, path)))
        code = open_level(context, array, group, path);
    if (code)
        return code;
    if (level < 0) {
        cvol_zarr_group_close(group);
        return guess_image(context, image, array);
    }
    code = cvol_zarr_image_read(image, group, (size_t)level);
    if (!code && image->rank != array->rank)
        code = cvol_fail(context, CVOL_ERROR_FORMAT,
                         "%s: its array has %d axes, but the group describes %d", array->path,
                         array->rank, image->rank);
    return code;
}

/* ---- the volume ----------------------------------------------------------------------- */

static void close_zarr(void *state)
{
    cvol_zarr_layers *layers = state;
    if (layers)
        cvol_zarr_layers_close(layers);
    free(layers);
}

static int read_slices(cvol_context *context, void *state, void *out, size_t first, size_t count)
{
    return cvol_zarr_layers_read(context, state, out, first, count);
}

static size_t length_of(const cvol_zarr_array *array, int axis)
{
    return axis < 0 ? 1 : (size_t)array->shape[axis];
}

/* Chooses channel and time, and sets the places of both. */
static int choose(cvol_context *context, cvol_zarr_layers *l, const cvol_zarr_image *image,
                  const char *path, const cvol_read_options *options)
{
    const int c = axis_named(image, 'c'), t = axis_named(image, 't');
    size_t channel, time = 0;
    int code = cvol_format_choose(context, &channel, path, "channel", "--channel",
                                  length_of(&l->array, c), options->has_channel, options->channel);
    if (!code)
        code = cvol_format_choose(context, &time, path, "volume", "--time", length_of(&l->array, t),
                                  options->has_index, options->index);
    if (c >= 0)
        l->begin[c] = channel;
    if (t >= 0)
        l->begin[t] = time;
    return code;
}

static int find_zarr(cvol_context *context, cvol_grid *grid, cvol_stored *stored, const char *path,
                     const cvol_read_options *options)
{
    cvol_zarr_group group = {.attributes = NULL};
    cvol_zarr_image image;
    cvol_zarr_layers *l = calloc(1, sizeof *l);
    if (!l)
        return cvol_fail_memory(context, sizeof *l, path);
    stored->slices = (cvol_slices){.state = l, .read = read_slices, .close = close_zarr};
    int code = open_image(context, &l->array, &image, &group, path);
    if (!code) {
        *grid = cvol_grid_make(1, 1, 1, l->array.type);
        stored->wide = l->array.wide;
        for (int i = 0; i < 3; i++) {
            l->of[i] = axis_named(&image, "xyz"[i]);
            l->dims[i] = grid->dims[i] = length_of(&l->array, l->of[i]);
        }
        cvol_zarr_image_place(grid, &image);
        code = choose(context, l, &image, path, options);
        const int was_asked = code == CVOL_ERROR_ARGUMENT;
        if ((!code || was_asked) &&
            !cvol_zarr_image_label(&stored->labels, &image, &group,
                                   length_of(&l->array, axis_named(&image, 'c'))))
            code = cvol_fail_memory(context, sizeof(cvol_channel_label), path);
        else if (was_asked && !options->has_channel)
            code = cvol_labels_append_names(context, &stored->labels, code);
    }
    cvol_zarr_group_close(&group);
    return code;
}

static int holds_series(const char *path)
{
    (void)path;
    return 1;
}

const cvol_format cvol_format_zarr = {
    .name = "Zarr",
    .endings = {".zarr"},
    .recognise_folder = recognise,
    .find = find_zarr,
    .open_sink = cvol_zarr_write_open,
    .holds_series = holds_series,
    .takes = CVOL_TAKES_SPACING | CVOL_TAKES_CHANNEL | CVOL_TAKES_INDEX,
    .takes_folder = 1,
};
