/* cvol render: a picture of a volume. */
#include <string.h>

#include "render_options.h"

static const char description[] =
    "Renders a volume into a PNG, straight from its compressed form (engine sheet). A volume that "
    "is\n"
    "not compressed yet is compressed in memory first.\n"
    "The camera projects in parallel and looks at the volume's centre with +z up; the eye lies in\n"
    "direction (cos e sin a, -cos e cos a, sin e) for azimuth a and elevation e. At zoom 1 the "
    "whole\n"
    "box fits whatever the angle.";

static const char examples[] =
    "  cvol render brain.cvol -o brain.png --azimuth 30 --elevation 20\n"
    "  cvol render ct.cvol -o bones.png --transfer bone --size 1024 --zoom 1.5\n"
    "  cvol render scan.nii.gz -o mip.png --mode mip --background 1,1,1\n";

/* What slices' transforms took; nothing of other engines. */
static json_t *transform_json(cvol_context *context, const scene *s)
{
    cvol_transform_report report;
    if (s->engine != CVOL_ENGINE_TRANSFORM ||
        cvol_renderer_transform_report(context, s->renderer, &report))
        return NULL;
    return json_pack("{s:[i,i], s:f, s:i, s:I, s:I, s:f, s:f, s:b, s:f, s:f}", "lattice",
                     (int)report.lattice[0], (int)report.lattice[1], "step", report.step, "slices",
                     (int)report.slices, "coefficients", (json_int_t)report.terms, "bytes",
                     (json_int_t)report.bytes, "rho", report.rho, "error_bound", report.bound,
                     "certified", report.certified, "bake_ms", report.bake_ms, "compose_ms",
                     report.compose_ms);
}

static int print_report(cvol_context *context, const scene *s, const render_arguments *arguments,
                        const cvol_image *image, double render_ms)
{
    json_t *object = json_pack(
        "{s:o, s:i, s:i, s:i, s:s, s:s, s:f, s:f, s:i}", "output", json_text(arguments->output),
        "level", s->in.level, "width", image->width, "height", image->height, "engine",
        arguments->engine_name, "mode", arguments->mode_name, "load_ms", s->load_ms, "render_ms",
        render_ms, "threads", cvol_context_threads(context));
    json_t *transform = transform_json(context, s);
    if (object && transform)
        json_object_set_new(object, "transform", transform);
    return print_json(object);
}

static int render(cvol_context *context, render_arguments *arguments, scene *s, const char *path)
{
    cvol_image *image = NULL;
    int status = check_output(path, arguments->output);
    if (!status)
        status = open_scene(context, s, arguments, path);
    double start = milliseconds();
    int code = 0;
    if (!status &&
        ((code = cvol_image_create(context, &image, s->options.width, s->options.height)) ||
         (code = cvol_renderer_render(context, s->renderer, image, &s->options))))
        status = complain_context(context, code, NULL);
    double render_ms = milliseconds() - start;
    if (!status && (code = cvol_image_write_png(context, image, arguments->output)))
        status = complain_context(context, code, NULL);
    clear_progress();
    if (!status && arguments->common.json)
        status = print_report(context, s, arguments, image, render_ms);
    else if (!status)
        printf("%s: %d x %d, loaded in %.0f ms, rendered in %.0f ms\n", arguments->output,
               image->width, image->height, s->load_ms, render_ms);
    cvol_image_free(image);
    close_scene(s);
    return status;
}

int command_render(int argc, char **argv)
{
    render_arguments a = RENDER_ARGUMENTS_DEFAULTS;
    const option_spec specs[] = {
        {"-o", "OUT.png", "the picture (needed)", OPTION_TEXT, &a.output, 0, NULL},
        {NULL, NULL, "Camera:", OPTION_HEADING, NULL, 0, NULL},
        {"--size", "W[xH]", "pixels (default 512x512)", OPTION_SIZE, a.size, 0, NULL},
        {"--azimuth", "DEG", "where the eye is, around z (default 0: in front, at -y)",
         OPTION_NUMBER, &a.azimuth, 0, NULL},
        {"--elevation", "DEG", "and above the horizon (default 0)", OPTION_NUMBER, &a.elevation, 0,
         NULL},
        {"--roll", "DEG", "turn the camera counter-clockwise (default 0)", OPTION_NUMBER, &a.roll,
         0, NULL},
        {"--zoom", "Z", "magnification (default 1)", OPTION_NUMBER, &a.zoom, 0, NULL},
        LOOK_OPTIONS(a),
        INPUT_OPTIONS(a.common),
        COMMON_OPTIONS(a.common),
    };
    command_line line = {.usage = "cvol render IN -o OUT.png [options]",
                         .description = description,
                         .examples = examples,
                         .options = specs,
                         .option_count = sizeof specs / sizeof *specs,
                         .positional_count = 1};
    scene s;
    memset(&s, 0, sizeof s);
    int status = parse_command_line(&line, argc, argv);
    if (status >= 0 || (status = check_render_arguments(&s, &a)))
        return status;
    if (!a.output)
        return complain(EXIT_MISUSED, "no picture to write: give -o OUT.png");
    if (!has_ending(a.output, ".png"))
        return complain(EXIT_MISUSED, "%s: the picture's name must end in .png", a.output);
    a.common.accept_cut = 1;
    cvol_context *context = begin_command(&a.common);
    if (!context)
        return EXIT_FAILED;
    return end_command(context, render(context, &a, &s, line.positionals[0]));
}
