/* cvol render: a picture of a volume. */
#include <stdlib.h>
#include <string.h>

#include "render_picture.h"

static const char description[] =
    "Renders a volume into a picture, straight from its compressed form (engine sheet). A volume "
    "that is\n"
    "not compressed yet is compressed in memory first. Of many volumes each becomes a picture: "
    "{name} in\n"
    "OUT is the volume's name without folder and ending.\n"
    "The camera looks at the volume's centre, or --look-at, with +z up; the eye lies in direction "
    "(cos e sin a, "
    "-cos e\n"
    "cos a, sin e) for azimuth a and elevation e. It projects in parallel, or, with --perspective, "
    "from a\n"
    "distance at which what is as far as the centre has the same size. At zoom 1 the whole box "
    "fits\n"
    "whatever the angle, in parallel. Lengths are in the volume's unit (spacing times samples).\n"
    "Channels of one input are drawn together, unless --channel chooses one: each in its colour, "
    "with its\n"
    "own window, added as light is.\n"
    "Named views are a patient's, if the file says how it lies in "
    "one, as\n"
    "radiologists look: from the front the patient's left is on the right; from top and bottom the "
    "front\n"
    "is upwards. Of other volumes front is azimuth 0, right 90, back 180, left 270, top elevation "
    "90,\n"
    "bottom -90.\n" TRANSFER_NAMES "--bits 16 and .pfm hold what the engine computed, linearly.";

static const char examples[] =
    "  cvol render brain.cvol -o brain.png --azimuth 30 --elevation 20\n"
    "  cvol render ct.cvol -o bones.png --transfer bone --size 1024 --zoom 1.5\n"
    "  cvol render scan.nii.gz -o mip.png --mode mip --background 1,1,1\n"
    "  cvol render mr.nii.gz -o '{name}.png' --view left --background transparent\n"
    "  cvol render ct.cvol -o cut.png --clip ,50%:,             without the front half\n"
    "  cvol render ct.cvol -o tooth.png --look-at 10,-60,-5 --zoom 4\n"
    "  cvol render ct.cvol -o in.png --perspective 80 --eye 0,-20,10 --look-at 0,40,0\n"
    "  cvol render ct.cvol -o turn.webp --turntable 72 --elevation 15 --background white\n"
    "  cvol render run.cvol -o run.webp --over-time --fps 10   a film of a time series\n"
    "  cvol render ct.cvol -o ct.cvi --engine transform        a compressed picture\n"
    "  cvol render ct.cvol -o ct.png --progressive             ct-1.png, ct-2.png, ..., ct.png\n"
    "  cvol render ct.cvol --engine fourier --poses poses.csv -o stack.nrrd --size 256\n";

static int check_view(const render_arguments *a)
{
    const char *given = a->azimuth_given ? "--azimuth" : a->elevation_given ? "--elevation" : NULL;
    const char *of_pictures = a->view_name     ? "--view"
                              : a->annotate    ? "--annotate"
                              : a->mirror      ? "--mirror"
                              : a->transparent ? "--background transparent"
                                               : NULL;
    if (a->view_name && given)
        return complain(EXIT_MISUSED, "give only one of --view and %s", given);
    if (a->poses && of_pictures)
        return complain(EXIT_MISUSED, "%s is for pictures, not for --poses", of_pictures);
    return EXIT_DONE;
}

static int render_one(cvol_context *context, const render_arguments *a, const scene *fresh,
                      const char *path)
{
    json_t *report = NULL;
    const int status = render_volume(context, a, fresh, path, &report);
    return report ? print_json(report) : status;
}

static int run(render_arguments *a, scene *s, const char **inputs, int count)
{
    a->common.accept_cut = 1;
    cvol_context *context = begin_command(&a->common);
    if (!context)
        return EXIT_FAILED;
    return end_command(context, a->poses     ? render_poses(context, a, s, inputs[0])
                                : count == 1 ? render_one(context, a, s, inputs[0])
                                             : render_many(context, a, s, inputs, count));
}

int command_render(int argc, char **argv)
{
    render_arguments a = RENDER_ARGUMENTS_DEFAULTS;
    const option_spec specs[] = {
        {"-o", "OUT",
         "the picture (needed): .png, .pfm (floats); engine transform: .cvi, compressed",
         OPTION_TEXT, &a.output, 0, NULL},
        {"--annotate", NULL, "with scale bar, axes, and a bar of colours and opacities",
         OPTION_FLAG, &a.annotate, 0, NULL},
        {"--depth", "OUT.pfm",
         "beside it: how far the place is at which opacity passes 1/2, or the surface's",
         OPTION_TEXT, &a.depth_name, 0, NULL},
        {"--opacity", "OUT.pfm", "beside it: how opaque the volume is, 0 to 1", OPTION_TEXT,
         &a.opacity_name, 0, NULL},
        {"--bits", "N", "of a PNG's channels: 8 (default) or 16", OPTION_INTEGER, &a.bits, 0, NULL},
        {"--psnr", "DB", "of OUT.cvi: at least, against the picture as it is (default 45)",
         OPTION_NUMBER, &a.psnr, 0, &a.psnr_given},
        {"--ratio", "R", "of OUT.cvi instead: three bytes a pixel / file bytes", OPTION_NUMBER,
         &a.ratio, 0, &a.ratio_given},
        {"--progressive", NULL,
         "first OUT-1.png to OUT-3.png, ever finer (engines sheet, transform)", OPTION_FLAG,
         &a.progressive, 0, NULL},
        {"--budget-ms", "MS", "the finest level that can be drawn in this time (engine sheet)",
         OPTION_NUMBER, &a.budget_ms, 0, &a.budget_given},
        {NULL, NULL, "Camera:", OPTION_HEADING, NULL, 0, NULL},
        {"--size", "W[xH]", "pixels (default 512x512)", OPTION_SIZE, a.size, 0, NULL},
        {"--azimuth", "DEG", "where the eye is, around z (default 0: in front, at -y)",
         OPTION_NUMBER, &a.azimuth, 0, &a.azimuth_given},
        {"--elevation", "DEG", "and above the horizon (default 0)", OPTION_NUMBER, &a.elevation, 0,
         &a.elevation_given},
        {"--view", "NAME", "front back left right top bottom, instead of these two angles",
         OPTION_TEXT, &a.view_name, 0, NULL},
        {"--roll", "DEG", "turn the camera counter-clockwise (default 0)", OPTION_NUMBER, &a.roll,
         0, NULL},
        {"--zoom", "Z", "magnification (default 1)", OPTION_NUMBER, &a.zoom, 0, &a.zoom_given},
        {"--perspective", "FOV",
         "field of view, of the height, 1 to 150 degrees (default: parallel)", OPTION_NUMBER,
         &a.perspective, 0, &a.perspective_given},
        {"--eye", "X,Y,Z",
         "with --perspective, instead of angles and zoom: from the volume's centre",
         OPTION_NUMBERS3, a.eye, 0, &a.eye_given},
        {"--look-at", "X,Y,Z",
         "what is in the picture's middle, from the volume's centre (default 0,0,0)",
         OPTION_NUMBERS3, a.look_at, 0, NULL},
        {"--up", "X,Y,Z", "what is upwards (default 0,0,1)", OPTION_NUMBERS3, a.up, 0, &a.up_given},
        {"--mirror", NULL, "turn left and right round; with --view, of what it shows", OPTION_FLAG,
         &a.mirror, 0, NULL},
        {"--clip", "BOX", "draw samples X0:X1,Y0:Y1,Z0:Z1 only; as in 10:,25%:75%,; empty: all",
         OPTION_TEXT, &a.clip_text, 0, NULL},
        {"--clip-plane", "NX,NY,NZ,D", "only what is at least D from the centre that way (up to 6)",
         OPTION_TEXTS, &a.clip_planes, CVOL_CLIP_PLANES, NULL},
        {NULL, NULL, "Films:", OPTION_HEADING, NULL, 0, NULL},
        {"--turntable", "N",
         "N pictures all around: turn-{n}.png, .gif, .webp; by ffmpeg .mp4 .mov .mkv .webm",
         OPTION_INTEGER, &a.turntable, 1, &a.turntable_given},
        {"--over-time", NULL, "a picture of each time instead, colours fitted to all alike",
         OPTION_FLAG, &a.over_time, 0, NULL},
        {"--fps", "F", "pictures a second (default 25)", OPTION_NUMBER, &a.fps, 0, &a.fps_given},
        {"--quality", "Q", "of WebP (100: without loss) and ffmpeg, 0 to 100 (default 90)",
         OPTION_INTEGER, &a.quality, 0, &a.quality_given},
        LOOK_OPTIONS(a),
        {"--channel-colors", "A,B",
         "of all channels, drawn together (modes composite, mip, xray): green,magenta or "
         "#00ff40,...",
         OPTION_TEXT, &a.channel_colours, 0, NULL},
        {NULL, NULL,
         "Many projections, as float32 in the volume's units, or grey (engine fourier):",
         OPTION_HEADING, NULL, 0, NULL},
        {"--poses", "FILE",
         "a line for each: w,x,y,z or azimuth,elevation,roll; -o STACK.nrrd, or p-{n}.png",
         OPTION_TEXT, &a.poses, 0, NULL},
        {"--integrals", NULL, "along rays, in the volume's unit of length, not means", OPTION_FLAG,
         &a.integrals, 0, NULL},
        INPUT_OPTIONS(a.common),
        COMMON_OPTIONS(a.common),
    };
    const char **inputs = calloc((size_t)argc, sizeof *inputs);
    if (!inputs)
        return complain(EXIT_FAILED, "not enough memory");
    command_line line = {.usage = "cvol render IN... -o OUT.png [options]",
                         .description = description,
                         .examples = examples,
                         .options = specs,
                         .option_count = sizeof specs / sizeof *specs,
                         .positional_count = 1,
                         .all = inputs};
    scene s;
    memset(&s, 0, sizeof s);
    int status = parse_command_line(&line, argc, argv);
    if (status < 0)
        choose_default_engine(&a, inputs[0]);
    if (status < 0 && !(status = check_render_arguments(&s, &a)) && !(status = check_view(&a)) &&
        !(status = check_many(&a, inputs, line.all_count)) &&
        !(status = check_maps(&s, &a, line.all_count)) && !(status = check_over_time(&a)) &&
        !(status = check_turntable(&s, &a)) &&
        !(status = a.poses             ? check_poses(&a)
                   : a.turntable_given ? EXIT_DONE
                                       : check_picture(&s, &a)))
        status = run(&a, &s, inputs, line.all_count);
    free(inputs);
    return status;
}
