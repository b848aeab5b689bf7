/* cvol render: a picture of a volume. */
#include <stdlib.h>
#include <string.h>

#include "picture.h"
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
    "  cvol render scan.nii.gz -o mip.png --mode mip --background 1,1,1\n"
    "  cvol render ct.cvol -o ct.cvi --engine transform        a compressed picture\n"
    "  cvol render ct.cvol -o ct.png --progressive             ct-1.png, ct-2.png, ..., ct.png\n"
    "  cvol render ct.cvol --engine fourier --poses poses.csv -o stack.nrrd --size 256\n";

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

/* What became of one picture. */
typedef struct outcome {
    double render_ms;
    int is_compressed;
    cvol_picture_info info; /* if it is */
} outcome;

/* Adds what is told of one picture only. */
static void describe_outcome(json_t *object, cvol_context *context, const scene *s,
                             const outcome *result)
{
    json_t *transform = transform_json(context, s);
    json_object_set_new(object, "render_ms", json_real(result->render_ms));
    if (transform)
        json_object_set_new(object, "transform", transform);
    describe_fourier(object, context, s);
    if (result->is_compressed)
        json_object_set_new(object, "picture", describe_picture(&result->info));
}

/* pictures: what was told of each, or NULL. */
static int print_report(cvol_context *context, const scene *s, const render_arguments *arguments,
                        const outcome *result, json_t *pictures)
{
    json_t *object = json_pack("{s:o, s:i, s:i, s:i, s:s, s:s, s:f, s:i}", "output",
                               json_text(arguments->output), "level", s->in.level, "width",
                               s->options.width, "height", s->options.height, "engine",
                               arguments->engine_name, "mode", arguments->mode_name, "load_ms",
                               s->load_ms, "threads", cvol_context_threads(context));
    if (object)
        describe_outcome(object, context, s, result);
    if (object && pictures)
        json_object_set(object, "pictures", pictures);
    return print_json(object);
}

/* ---- one picture ---------------------------------------------------------------------------- */

static int write_png(cvol_context *context, scene *s, const char *output, outcome *result)
{
    cvol_image *image = NULL;
    const double start = milliseconds();
    int code = cvol_image_create(context, &image, s->options.width, s->options.height);
    if (!code)
        code = cvol_renderer_render(context, s->renderer, image, &s->options);
    result->render_ms = milliseconds() - start;
    if (!code)
        code = cvol_image_write_png(context, image, output);
    cvol_image_free(image);
    return code;
}

static int write_compressed(cvol_context *context, scene *s, const render_arguments *arguments,
                            const char *output, outcome *result)
{
    cvol_picture_options options = cvol_picture_options_defaults();
    cvol_picture *picture = NULL;
    const double start = milliseconds();
    if (arguments->psnr_given)
        options.psnr_db = arguments->psnr;
    options.ratio = arguments->ratio_given ? arguments->ratio : 0;
    int code = cvol_renderer_picture(context, s->renderer, &picture, &s->options, &options);
    result->render_ms = milliseconds() - start;
    result->is_compressed = 1;
    if (!code)
        code = cvol_picture_get_info(context, &result->info, picture);
    if (!code)
        code = cvol_picture_write(context, picture, output, NULL);
    cvol_picture_free(picture);
    return code;
}

/* Exit status. */
static int write_picture(cvol_context *context, scene *s, const render_arguments *arguments,
                         const char *output, outcome *result)
{
    *result = (outcome){0};
    const int code = has_ending(output, ".cvi")
                         ? write_compressed(context, s, arguments, output, result)
                         : write_png(context, s, output, result);
    clear_progress();
    if (code)
        return complain_context(context, code, NULL);
    if (arguments->common.json)
        return EXIT_DONE;
    printf("%s: %d x %d, ", output, s->options.width, s->options.height);
    if (result->is_compressed)
        printf("%llu bytes, PSNR %.2f dB, ", (unsigned long long)result->info.file_bytes,
               result->info.psnr_db);
    printf("loaded in %.0f ms, rendered in %.0f ms\n", s->load_ms, result->render_ms);
    return EXIT_DONE;
}

/* ---- from coarse to fine -------------------------------------------------------------------- */

enum { STAGES = 4 };

/* OUT-1.png of OUT.png; the caller frees it. NULL without memory. */
static char *stage_name(const char *output, int number)
{
    const char *ending = strrchr(output, '.');
    const size_t size = strlen(output) + 16;
    char *name = malloc(size);
    if (name)
        snprintf(name, size, "%.*s-%d%s", (int)(ending - output), output, number, ending);
    return name;
}

/* Draws stage `number` of `count`, the last one under the picture's own name. Exit status. */
static int draw_stage(cvol_context *context, scene *s, const render_arguments *arguments,
                      int number, int count, json_t *pictures, outcome *result)
{
    char *name = number < count ? stage_name(arguments->output, number) : NULL;
    const char *output = name ? name : arguments->output;
    if (number < count && !name)
        return complain(EXIT_FAILED, "not enough memory");
    int status = write_picture(context, s, arguments, output, result);
    json_t *object = status ? NULL
                            : json_pack("{s:o, s:i, s:f}", "output", json_text(output), "level",
                                        s->in.level, "load_ms", s->load_ms);
    if (object)
        describe_outcome(object, context, s, result);
    json_array_append_new(pictures, object);
    free(name);
    return status;
}

/* Engine sheet: what the file holds at each level, which stand one after the other in it. */
static int refine_levels(cvol_context *context, render_arguments *arguments, scene *s,
                         const char *path, json_t *pictures, outcome *result)
{
    const int finest = arguments->common.level, count = STAGES - finest;
    const scene fresh = *s;
    int status = EXIT_DONE;
    if (cvol_file_kind_of(path) != CVOL_FILE_ARRAY)
        return complain(EXIT_MISUSED,
                        "%s: --progressive draws a .cvol level by level, which this is not: "
                        "cvol compress makes one",
                        path);
    for (int number = 1; number <= count && !status; number++) {
        close_scene(s);
        *s = fresh;
        arguments->common.level = STAGES - number;
        status = open_scene(context, s, arguments, path);
        if (!status)
            status = draw_stage(context, s, arguments, number, count, pictures, result);
    }
    return status;
}

/* Engine transform: ever more of the strongest terms, from slices that are made once. */
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

static int render(cvol_context *context, render_arguments *arguments, scene *s, const char *path)
{
    json_t *pictures = arguments->progressive ? json_array() : NULL;
    outcome result = {0};
    int status = check_output(path, arguments->output);
    if (!status && arguments->progressive)
        status = (s->engine == CVOL_ENGINE_SHEET ? refine_levels : refine_terms)(
            context, arguments, s, path, pictures, &result);
    else if (!status && !(status = open_scene(context, s, arguments, path)))
        status = write_picture(context, s, arguments, arguments->output, &result);
    if (!status && arguments->common.json)
        status = print_report(context, s, arguments, &result, pictures);
    json_decref(pictures);
    close_scene(s);
    return status;
}

/* What the picture's name and the options beside it ask for. Exit status. */
static int check_pictures(const scene *s, const render_arguments *a)
{
    if (!a->output)
        return complain(EXIT_MISUSED, "no picture to write: give -o OUT.png");
    const int is_compressed = has_ending(a->output, ".cvi");
    if (!is_compressed && !has_ending(a->output, ".png"))
        return complain(EXIT_MISUSED,
                        "%s: the picture's name must end in .png, or .cvi for a compressed one",
                        a->output);
    if (is_compressed && s->engine != CVOL_ENGINE_TRANSFORM)
        return complain(EXIT_MISUSED,
                        "%s: only engine transform composes compressed pictures; cvol compress "
                        "makes them of any PNG",
                        a->output);
    if (!is_compressed && (a->psnr_given || a->ratio_given))
        return complain(EXIT_MISUSED, "--%s is for compressed pictures, -o OUT.cvi",
                        a->psnr_given ? "psnr" : "ratio");
    if (a->psnr_given && a->ratio_given)
        return complain(EXIT_MISUSED, "give only one of --psnr and --ratio");
    if (a->psnr_given && !(a->psnr > 0 && a->psnr <= 100))
        return complain(EXIT_MISUSED, "--psnr is %g dB, must be above 0 and at most 100", a->psnr);
    if (a->ratio_given && !(a->ratio > 1))
        return complain(EXIT_MISUSED, "--ratio is %g, must be above 1", a->ratio);
    if (a->progressive && s->engine != CVOL_ENGINE_SHEET && s->engine != CVOL_ENGINE_TRANSFORM)
        return complain(EXIT_MISUSED, "--progressive is for engines sheet and transform");
    return EXIT_DONE;
}

int command_render(int argc, char **argv)
{
    render_arguments a = RENDER_ARGUMENTS_DEFAULTS;
    const option_spec specs[] = {
        {"-o", "OUT.png", "the picture (needed); engine transform: also OUT.cvi, compressed",
         OPTION_TEXT, &a.output, 0, NULL},
        {"--psnr", "DB", "of OUT.cvi: at least, against the picture as it is (default 45)",
         OPTION_NUMBER, &a.psnr, 0, &a.psnr_given},
        {"--ratio", "R", "of OUT.cvi instead: three bytes a pixel / file bytes", OPTION_NUMBER,
         &a.ratio, 0, &a.ratio_given},
        {"--progressive", NULL,
         "first OUT-1.png to OUT-3.png, ever finer (engines sheet, transform)", OPTION_FLAG,
         &a.progressive, 0, NULL},
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
        {NULL, NULL, "Many projections, as float32 in the volume's units (engine fourier):",
         OPTION_HEADING, NULL, 0, NULL},
        {"--poses", "FILE", "a line for each: w,x,y,z or azimuth,elevation,roll; -o STACK.nrrd",
         OPTION_TEXT, &a.poses, 0, NULL},
        {"--integrals", NULL, "along rays, in the volume's unit of length, not means", OPTION_FLAG,
         &a.integrals, 0, NULL},
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
    if ((status = a.poses ? check_poses(&a) : check_pictures(&s, &a)))
        return status;
    a.common.accept_cut = 1;
    cvol_context *context = begin_command(&a.common);
    if (!context)
        return EXIT_FAILED;
    return end_command(context,
                       (a.poses ? render_poses : render)(context, &a, &s, line.positionals[0]));
}
