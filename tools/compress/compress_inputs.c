/* The inputs of cvol compress: names and patterns, in natural order. */
#define _GNU_SOURCE
#include <glob.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "tools/base/picture.h"
#include "tools/compress/compress.h"

void free_volumes(volume_list *list)
{
    for (int i = 0; i < list->count; i++)
        free(list->paths[i]);
    free(list->paths);
    *list = (volume_list){0};
}

static int add_path(volume_list *list, const char *path)
{
    char **paths = realloc(list->paths, (size_t)(list->count + 1) * sizeof *paths);
    if (paths)
        list->paths = paths;
    if (!paths || !(list->paths[list->count] = strdup(path)))
        return report_error(EXIT_FAILED, "not enough memory");
    list->count++;
    return EXIT_DONE;
}

static int compare(const void *a, const void *b)
{
    return strverscmp(*(char *const *)a, *(char *const *)b);
}

/* A name that is not a file may be a pattern. */
static int add_name(volume_list *list, const char *name)
{
    glob_t found;
    if (!strpbrk(name, "*?[") || !access(name, F_OK))
        return add_path(list, name);
    const int refused = glob(name, 0, NULL, &found);
    if (refused == GLOB_NOMATCH)
        return report_error(EXIT_FAILED, "%s: no file matches this pattern", name);
    if (refused)
        return report_error(EXIT_FAILED, "%s: cannot read the folder", name);
    int status = EXIT_DONE;
    qsort(found.gl_pathv, found.gl_pathc, sizeof *found.gl_pathv, compare);
    for (size_t i = 0; i < found.gl_pathc && !status; i++)
        if (!(status = add_path(list, found.gl_pathv[i])))
            status = find_kind(found.gl_pathv[i]);
    globfree(&found);
    return status;
}

/* 1 if the paths are in alphabetical order, in which a shell lists matches: run_10 before run_2. */
static int is_by_letters(const volume_list *list)
{
    for (int i = 1; i < list->count; i++)
        if (strcmp(list->paths[i - 1], list->paths[i]) >= 0)
            return 0;
    return 1;
}

/* The only argument is the input: the output lies next to it, with the extension .cvol, or .cvi for
 * a picture. It does not replace a file. */
static int choose_output(volume_list *out, const char *path, compress_arguments *a)
{
    static const char *const endings[] = {".gz",  ".nii", ".nrrd", ".nhdr", ".mha", ".mhd", ".raw",
                                          ".img", ".hdr", ".tif",  ".tiff", ".npy", ".mrc", ".mgz",
                                          ".mgh", ".map", ".png",  ".vti",  ".vtk", ".h5",  ".mnc",
                                          ".dcm", ".vdb", ".mat",  ".zarr", ".ome"};
    size_t length = strlen(path);
    while (length > 1 && path[length - 1] == '/')
        length--;
    const char *ending = is_png(path) ? ".cvi" : ".cvol";
    char *name = malloc(length + strlen(ending) + 1);
    if (!name)
        return report_error(EXIT_FAILED, "not enough memory");
    memcpy(name, path, length);
    name[length] = '\0';
    for (int round = 0; round < 2; round++) /* .nii.gz, .ome.tif */
        for (size_t k = 0; k < sizeof endings / sizeof *endings; k++)
            if (has_ending(name, endings[k]) && strlen(name) > strlen(endings[k])) {
                name[strlen(name) - strlen(endings[k])] = '\0';
                break;
            }
    strcat(name, ending);
    a->output = a->own_output = name;
    if (has_ending(path, ".cvol") || has_ending(path, ".cvi"))
        return report_error(EXIT_MISUSED, "%s: is compressed already: give the name of the output",
                            path);
    if (strpbrk(path, "*?["))
        return report_error(EXIT_MISUSED, "%s: give the name of the output with -o OUT.cvol", path);
    if (!access(name, F_OK))
        return report_error(EXIT_FAILED, "%s: exists already: give the name of the output", name);
    return add_name(out, path);
}

/* Sorts by number what a shell sorted by letters. Names and colours of channels were perhaps given
 * in the other order. */
static int sort_volumes(volume_list *list, const compress_arguments *a)
{
    const int are_channels = a->as && !strcmp(a->as, "channels");
    const char *option = !are_channels        ? NULL
                         : a->channel_names   ? "--channel-names"
                         : a->channel_colours ? "--channel-colors"
                                              : NULL;
    for (int i = 1; option && i < list->count; i++)
        if (compare(&list->paths[i - 1], &list->paths[i]) > 0)
            return report_error(
                EXIT_MISUSED,
                "%s: the order is not clear, as %s is given before %s: list the files by number, "
                "or in quotes, as in 'run_*.nrrd'",
                option, list->paths[i - 1], list->paths[i]);
    qsort(list->paths, (size_t)list->count, sizeof *list->paths, compare);
    return EXIT_DONE;
}

int find_volumes(volume_list *out, const command_line *line, compress_arguments *a)
{
    int inputs = line->all_count, status = EXIT_DONE;
    if (!a->output && inputs == 1)
        return choose_output(out, line->all[0], a);
    if (!a->output && inputs < 1)
        return report_error(EXIT_MISUSED, "%d of 2 arguments given; usage: %s", inputs,
                            line->usage);
    if (!a->output && inputs > 2)
        return report_error(
            EXIT_MISUSED,
            "too many arguments: '%s'; usage: %s; give several volumes with -o OUT.cvol",
            line->all[2], line->usage);
    if (!a->output)
        a->output = line->all[--inputs];
    for (int i = 0; i < inputs && !status; i++)
        status = add_name(out, line->all[i]);
    return !status && is_by_letters(out) ? sort_volumes(out, a) : status;
}
