/* --progressive: pictures from coarse to fine. */
#include <stdlib.h>
#include <string.h>

#include "tools/render/render_picture.h"

enum { STAGES = 4 };

/* OUT-1.png for OUT.png; the caller frees it; NULL without memory. */
static char *stage_name(const char *output, int number)
{
    const char *ending = strrchr(output, '.');
    const size_t size = strlen(output) + 16;
    char *name = malloc(size);
    if (name)
        snprintf(name, size, "%.*s-%d%s", (int)(ending - output), output, number, ending);
    return name;
}

/* Draws stage `number` of `count`; the last one has the name of the picture. Exit status. */
static int draw_stage(cvol_context *context, scene *s, const render_arguments *arguments,
                      int number, int count, json_t *pictures, outcome *result)
{
    char *name = number < count ? stage_name(arguments->output, number) : NULL;
    const char *output = name ? name : arguments->output;
    if (number < count && !name)
        return report_error(EXIT_FAILED, "not enough memory");
    const int status = write_picture(context, s, arguments, output, result);
    if (!status && !arguments->common.json)
        print_picture(s, output, result);
    json_t *object = status ? NULL
                            : json_pack("{s:o, s:i, s:f}", "output", json_text(output), "level",
                                        s->in.level, "load_ms", s->load_ms);
    if (object)
        describe_outcome(object, context, s, result);
    json_array_append_new(pictures, object);
    free(name);
    return status;
}

/* Engine sheet: draws the levels of the file, from coarse to fine. */
static int refine_levels(cvol_context *context, render_arguments *arguments, scene *s,
                         const char *path, json_t *pictures, outcome *result)
{
    const int finest = arguments->common.level, count = STAGES - finest;
    const scene fresh = *s;
    int status = EXIT_DONE;
    const cvol_file_kind kind = kind_of(path);
    if (kind != CVOL_FILE_ARRAY && kind != CVOL_FILE_SERIES)
        return report_error(EXIT_MISUSED,
                            "%s: --progressive needs a .cvol file: run cvol compress first", path);
    for (int number = 1; number <= count && !status; number++) {
        close_scene(s);
        *s = fresh;
        arguments->common.level = STAGES - number;
        arguments->level_given = 1;
        status = open_scene(context, s, arguments, path);
        if (!status)
            status = draw_stage(context, s, arguments, number, count, pictures, result);
    }
    return status;
}

/* Engine transform: draws with more and more of the strongest terms of the same slices. */
static int refine_terms(cvol_context *context, render_arguments *arguments, scene *s,
                        const char *path, json_t *pictures, outcome *result)
{
    int status = open_scene(context, s, arguments, path);
    const double rho = s->options.transform.rho < 1 ? s->options.transform.rho : 1;
    s->options.transform.stored_rho = s->options.transform.rho;
    for (int number = 1; number <= STAGES && !status; number++) {
        s->options.transform.rho = number < STAGES ? rho / (1 << (STAGES - number))
                                                   : s->options.transform.stored_rho;
        status = draw_stage(context, s, arguments, number, STAGES, pictures, result);
    }
    return status;
}

int render_stages(cvol_context *context, render_arguments *arguments, scene *s, const char *path,
                  json_t *pictures, outcome *result)
{
    return s->engine == CVOL_ENGINE_SHEET
               ? refine_levels(context, arguments, s, path, pictures, result)
               : refine_terms(context, arguments, s, path, pictures, result);
}
