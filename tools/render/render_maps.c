/* --depth and --opacity: files with the depth and the opacity of each pixel. */
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>

#include "tools/render/render_picture.h"

/* The last part of a name, after its folder. */
static const char *file_part(const char *name)
{
    const char *slash = strrchr(name, '/');
    return slash ? slash + 1 : name;
}

/* 1 if both names are those of one file, which need not exist: ./x.pfm and x.pfm. */
static int are_one_file(const char *a, const char *b)
{
    struct stat of[2];
    const char *names[2] = {a, b};
    if (strcmp(file_part(a), file_part(b)))
        return 0;
    for (int k = 0; k < 2; k++) {
        const size_t length = (size_t)(file_part(names[k]) - names[k]);
        char *folder = malloc(length + 2);
        if (!folder)
            return !strcmp(a, b);
        memcpy(folder, names[k], length);
        memcpy(folder + length, ".", 2); /* "FOLDER/.", or "." */
        const int failed = stat(folder, &of[k]);
        free(folder);
        if (failed)
            return !strcmp(a, b);
    }
    return of[0].st_dev == of[1].st_dev && of[0].st_ino == of[1].st_ino;
}

static int check_map(const render_arguments *a, const char *option, const char *name, int volumes)
{
    const char *other = a->poses             ? "--poses"
                        : a->turntable_given ? "--turntable"
                        : a->progressive     ? "--progressive"
                                             : NULL;
    if (!name)
        return EXIT_DONE;
    if (!has_ending(name, ".pfm"))
        return report_error(EXIT_MISUSED, "%s: %s writes floats: its name must end in .pfm", name,
                            option);
    if (other)
        return report_error(EXIT_MISUSED, "%s cannot be combined with %s", option, other);
    if (a->output && has_ending(a->output, ".cvi"))
        return report_error(EXIT_MISUSED, "%s: a compressed picture cannot be combined with %s",
                            a->output, option);
    if (volumes > 1 && !strstr(name, "{name}"))
        return report_error(EXIT_MISUSED, "%s: this is one name for %d volumes: put {name} into it",
                            name, volumes);
    if (a->output && are_one_file(name, a->output))
        return report_error(EXIT_MISUSED, "%s: is the name of the picture; give another one for %s",
                            name, option);
    return EXIT_DONE;
}

int check_maps(const scene *s, const render_arguments *a, int volumes)
{
    if (a->depth_name && s->engine != CVOL_ENGINE_SHEET && s->engine != CVOL_ENGINE_RAY)
        return report_error(EXIT_MISUSED, "--depth works only with engines sheet and ray");
    if (a->depth_name && s->options.mode != CVOL_MODE_COMPOSITE && s->options.mode != CVOL_MODE_ISO)
        return report_error(
            EXIT_MISUSED, "--depth works only in modes composite and iso, not in %s", a->mode_name);
    if (a->opacity_name && a->annotate)
        return report_error(EXIT_MISUSED,
                            "--opacity cannot be combined with --annotate, which changes "
                            "the opacity");
    if (check_map(a, "--depth", a->depth_name, volumes) ||
        check_map(a, "--opacity", a->opacity_name, volumes))
        return EXIT_MISUSED;
    if (a->depth_name && a->opacity_name && are_one_file(a->depth_name, a->opacity_name))
        return report_error(EXIT_MISUSED,
                            "%s: is given for both --depth and --opacity: give two names",
                            a->depth_name);
    return EXIT_DONE;
}

int write_maps(cvol_context *context, const render_arguments *a, const cvol_image *image)
{
    int code = CVOL_OK;
    if (a->depth_name)
        code = cvol_image_write_depth(context, image, a->depth_name);
    if (!code && a->opacity_name)
        code = cvol_image_write_opacity(context, image, a->opacity_name);
    return code ? report_context_error(context, code, NULL) : EXIT_DONE;
}

int name_maps(render_arguments *a, const char *path)
{
    const char **names[] = {&a->depth_name, &a->opacity_name};
    int status = EXIT_DONE;
    for (int k = 0; k < 2; k++)
        if (*names[k]) {
            *names[k] = output_name(*names[k], path, 0, 0);
            if (!status)
                status = *names[k] ? check_output(path, *names[k])
                                   : report_error(EXIT_FAILED, "not enough memory");
        }
    return status;
}

void free_maps(render_arguments *a)
{
    free((char *)a->depth_name);
    free((char *)a->opacity_name);
}

void describe_maps(json_t *object, const render_arguments *a)
{
    if (a->depth_name)
        json_object_set_new(object, "depth", json_text(a->depth_name));
    if (a->opacity_name)
        json_object_set_new(object, "opacity", json_text(a->opacity_name));
}
