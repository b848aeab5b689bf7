/* cvol bake: classified, lit and transformed slices of a volume, for engine transform. */
#include <string.h>

#include "tools/render/render_options.h"

static const char description[] =
    "Prepares a volume for engine transform: classifies the samples by the transfer function\n"
    "(and lights them), transforms the slices across one axis, and keeps their strongest\n"
    "coefficients. cvol render OUT.cvol --engine transform then draws pictures from all\n"
    "directions for which this axis is the one most parallel to the view. Baked slices use\n"
    "the DCT. Slices under DFT or DHT would serve one direction only; cvol render --tile 0\n"
    "--spectrum dft makes them for each picture.";

static const char examples[] =
    "  cvol bake ct.cvol -o ct-y.cvol --transfer bone --axis y\n"
    "  cvol render ct-y.cvol -o ct.png --engine transform --azimuth 20\n";

static json_t *describe(const render_arguments *a, const cvol_baked_info *info, double bake_ms)
{
    const uint64_t bytes = file_size(a->output);
    return json_pack("{s:o, s:s, s:s, s:i, s:i, s:s, s:i, s:f, s:f, s:f, s:I, s:I, s:f, s:f}",
                     "output", json_text(a->output), "axis", a->axis_name, "transfer",
                     a->transfer_name, "slices", (int)info->slices, "visible_slices",
                     (int)info->visible, "transform", cvol_transform_name(info->transform), "tile",
                     info->tile, "rho", info->rho, "kept", info->kept, "step", info->step,
                     "coefficients", (json_int_t)info->terms, "file_bytes", (json_int_t)bytes,
                     "ratio", (double)cvol_grid_bytes(&info->grid) / (double)bytes, "bake_ms",
                     bake_ms);
}

/* Reads the written file and reports on it. Exit status. */
static int report(cvol_context *context, const render_arguments *a, double bake_ms)
{
    cvol_renderer *renderer = NULL;
    cvol_baked_info info;
    int code = cvol_renderer_create(context, &renderer, CVOL_ENGINE_TRANSFORM,
                                    CVOL_SOURCE(.baked_path = a->output));
    if (!code)
        code = cvol_renderer_get_baked_info(context, &info, renderer);
    clear_progress();
    int status = EXIT_DONE;
    if (code)
        status = report_error(EXIT_FAILED, "%s: was written, but cannot be described: %s",
                              a->output, cvol_context_message(context));
    else if (a->common.json)
        status = print_json(describe(a, &info, bake_ms));
    else
        printf("%s: %zu slices across %s, %llu terms, %llu bytes, baked in %.0f ms\n", a->output,
               info.slices, a->axis_name, (unsigned long long)info.terms,
               (unsigned long long)file_size(a->output), bake_ms);
    cvol_renderer_free(renderer);
    return status;
}

static int bake(cvol_context *context, scene *s, render_arguments *a, const char *path)
{
    int status = check_output(path, a->output);
    if (!status)
        status = open_scene(context, s, a, path);
    const double start = milliseconds();
    int code = status ? CVOL_OK
                      : cvol_renderer_bake(context, s->renderer, a->output, a->axis_name[0] - 'x',
                                           a->transfer_name, &s->options, NULL);
    if (code)
        status = report_context_error(context, code, NULL);
    const double bake_ms = milliseconds() - start;
    close_scene(s);
    return status ? status : report(context, a, bake_ms);
}

static int check_baking(const render_arguments *a)
{
    if (!a->output)
        return report_error(EXIT_MISUSED, "no file to write: give -o OUT.cvol");
    if (!has_ending(a->output, ".cvol"))
        return report_error(EXIT_MISUSED, "%s: the output's name must end in .cvol", a->output);
    if (!a->axis_name)
        return report_error(EXIT_MISUSED, "no axis: give --axis x, y or z, the one nearest to the "
                                          "directions of your views");
    int axis;
    if (parse_word(&axis, &axis_words, "--axis", a->axis_name))
        return EXIT_MISUSED;
    if (a->rho_given && !(a->rho > 0 && a->rho <= 1))
        return report_error(EXIT_MISUSED, "--rho is %g, must be above 0 and at most 1", a->rho);
    return EXIT_DONE;
}

int command_bake(int argc, char **argv)
{
    render_arguments a = RENDER_ARGUMENTS_DEFAULTS;
    a.engine_name = "transform";
    const option_spec specs[] = {
        {"-o", "OUT.cvol", "the baked volume (required)", OPTION_TEXT, &a.output, 0, NULL},
        {"--axis", "AXIS", "x, y or z: the axis that the slices are across (required)", OPTION_TEXT,
         &a.axis_name, 0, NULL},
        {NULL, NULL, "Look:", OPTION_HEADING, NULL, 0, NULL},
        {"--transfer", "NAME|FILE",
         "name (see cvol render --help) or JSON file of the transfer function (default auto)",
         OPTION_TEXT, &a.transfer_name, 0, &a.transfer_given},
        {"--shade", NULL, "light the samples by their gradients, for a viewer on the axis",
         OPTION_FLAG, &a.shade, 0, NULL},
        {"--light", "X,Y,Z", "direction of the light (default: that viewer's)", OPTION_TEXT,
         &a.light_text, 0, NULL},
        {"--level", "L",
         "resolution of a .cvol: 0 (default) full, 1 to 3: 1/2, 1/4, 1/8 of the samples",
         OPTION_INTEGER, &a.common.level, 0, &a.level_given},
        {NULL, NULL, "Slices:", OPTION_HEADING, NULL, 0, NULL},
        {"--rho", "SHARE", "share of the coefficients to keep, at most 1 (default 0.1)",
         OPTION_NUMBER, &a.rho, 0, &a.rho_given},
        {"--spectrum", "NAME",
         "transform of the slices: only dct, since dft and dht serve one direction", OPTION_TEXT,
         &a.spectrum_name, 0, NULL},
        {"--tile", "N", "transform tiles of 8, 16 (default) or 32 samples a side; 0: whole slices",
         OPTION_INTEGER, &a.tile, 0, &a.tile_given},
        {"--footprint", "NAME", "footprint of the pictures: gaussian (default), sinc or box",
         OPTION_TEXT, &a.footprint_name, 0, NULL},
        {"--footprint-size", "N", "width of the footprint in samples, 3 to 31 (default 5)",
         OPTION_INTEGER, &a.footprint_size, 0, &a.footprint_given},
        {"--sigma", "S", "standard deviation of a Gaussian footprint, in samples (default N / 6)",
         OPTION_NUMBER, &a.sigma, 0, &a.sigma_given},
        INPUT_OPTIONS(a.common),
        COMMON_OPTIONS(a.common),
    };
    command_line line = {.usage = "cvol bake IN -o OUT.cvol --axis AXIS [options]",
                         .description = description,
                         .examples = examples,
                         .options = specs,
                         .option_count = sizeof specs / sizeof *specs,
                         .positional_count = 1};
    scene s;
    memset(&s, 0, sizeof s);
    int status = parse_command_line(&line, argc, argv);
    if (status >= 0 || (status = check_baking(&a)) || (status = check_render_arguments(&s, &a)))
        return status;
    cvol_context *context = begin_command(&a.common);
    if (!context)
        return EXIT_FAILED;
    return end_command(context, bake(context, &s, &a, line.positionals[0]));
}
