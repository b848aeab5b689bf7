/* cvol render: a picture of a volume. */
#include <stdlib.h>
#include <string.h>

#include "tools/render/render_parts.h"
#include "tools/render/render_picture.h"

static const char description[] =
    "Draws a picture of a volume from its compressed form. A volume that is not compressed is\n"
    "compressed in memory first. Several inputs give several pictures: put {name} into OUT,\n"
    "which stands for the name of the input without folder and extension.\n"
    "\n"
    "If nothing is chosen, the picture shows the volume from the front, a little from the side\n"
    "and from above; what is visible fills it; colours follow the kind of data (CT in Hounsfield\n"
    "units, MRI, microscopy, fields, ...), and a studio light shows the shape.\n"
    "\n"
    "Camera: it looks at the middle of what is visible, or at --look-at, with +z up. For azimuth\n"
    "a and elevation e the eye is in direction (cos e sin a, -cos e cos a, sin e). The\n"
    "projection is parallel, unless --perspective is given. With --fit box the whole volume\n"
    "fits at every angle, and in perspective objects at its centre keep their size. Lengths are\n"
    "in the unit of the volume (spacing times samples). If the file gives a patient orientation,\n"
    "named views follow radiology: from the front the patient's left is on the right; from\n"
    "top and bottom the front is up. In other volumes front is azimuth 0, right 90, back 180,\n"
    "left 270; top is elevation 90, bottom -90.\n"
    "\n"
    "Channels are drawn together, unless --channel chooses one: each in its colour and with\n"
    "its own window; the colours are added. RGB samples have their own colours, and RGBA\n"
    "samples their own opacity.\n" TRANSFER_NAMES "\n"
    "--certify draws by engine ray. Every pixel of the picture that engine ray makes of the\n"
    "original samples, with the same options, lies between OUT.lower.png and OUT.upper.png.\n"
    "That is proved from max_error of the file (cvol info); OUT.width.png shows the largest\n"
    "difference of the channels. Files with a small --max-error give narrow bounds. If nothing\n"
    "else is chosen, --certify means --fit box and --light flat.\n"
    "\n"
    "PNG files with --bits 16 and PFM files hold linear values, as the engine computed them.";

static const char examples[] =
    "  cvol render brain.cvol -o brain.png\n"
    "  cvol render ct.cvol -o bones.png --transfer bone --size 1024\n"
    "  cvol render scan.nii.gz -o mip.png --mode mip --background 1,1,1\n"
    "  cvol render mr.nii.gz -o '{name}.png' --view left --background transparent\n"
    "  cvol render mri.nii.gz -o fused.png --overlay pet.nii.gz\n"
    "  cvol render atlas.nii.gz -o left.png --label-table names.txt --labels 3,7-9,left_ventricle\n"
    "  cvol render ct.cvol -o cut.png --clip ,50%:,             without the front half\n"
    "  cvol render ct.cvol -o tooth.png --look-at 10,-60,-5 --zoom 4\n"
    "  cvol render ct.cvol -o in.png --perspective 80 --eye 0,-20,10 --look-at 0,40,0\n"
    "  cvol render ct.cvol -o turn.webp --turntable 72 --elevation 15 --background white\n"
    "  cvol render run.cvol -o run.webp --over-time --fps 10   an animation of a time series\n"
    "  cvol render ct.cvol -o ct.cvi --engine transform        a compressed picture\n"
    "  cvol render ct.cvol -o ct.png --progressive             ct-1.png, ct-2.png, ..., ct.png\n"
    "  cvol render ct.cvol -o ct.png --certify                 and how far the original may "
    "differ\n"
    "  cvol render ct.cvol --engine fourier --poses poses.csv -o stack.nrrd --size 256\n";

static int check_view(const render_arguments *a)
{
    const char *given = a->azimuth_given ? "--azimuth" : a->elevation_given ? "--elevation" : NULL;
    const char *of_pictures = a->view_name      ? "--view"
                              : a->annotate     ? "--annotate"
                              : a->mirror       ? "--mirror"
                              : a->transparent  ? "--background transparent"
                              : a->has_gradient ? "--background gradient"
                                                : NULL;
    if (a->view_name && given)
        return report_error(EXIT_MISUSED, "give only one of --view and %s", given);
    if (a->poses && of_pictures)
        return report_error(EXIT_MISUSED, "%s cannot be combined with --poses", of_pictures);
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
    note_unused(s, a);
    return end_command(context, a->poses     ? render_poses(context, a, s, inputs[0])
                                : count == 1 ? render_one(context, a, s, inputs[0])
                                             : render_many(context, a, s, inputs, count));
}

int command_render(int argc, char **argv)
{
    render_arguments a = RENDER_ARGUMENTS_DEFAULTS;
    a.has_default_look = 1;
    begin_overlay_options(&a.overlay);
    const option_spec specs[] = {
        {"-o", "OUT",
         "the picture (required): .png, .pfm (floats), .cvi (compressed, engine transform)",
         OPTION_TEXT, &a.output, 0, NULL},
        {"--annotate", NULL, "draw a scale bar, axes, and a bar of colours and opacities",
         OPTION_FLAG, &a.annotate, 0, NULL},
        {"--depth", "OUT.pfm",
         "also write the distance at which the opacity reaches 1/2, or of the surface", OPTION_TEXT,
         &a.depth_name, 0, NULL},
        {"--opacity", "OUT.pfm", "also write the opacity of each pixel, 0 to 1", OPTION_TEXT,
         &a.opacity_name, 0, NULL},
        {"--certify", NULL,
         "also write bounds of the picture of the original samples: OUT.lower.png, .upper, .width",
         OPTION_FLAG, &a.certify, 0, NULL},
        {"--bits", "N", "bits per channel of a PNG: 8 (default) or 16", OPTION_INTEGER, &a.bits, 0,
         NULL},
        {"--psnr", "DB", "PSNR of OUT.cvi against the rendered picture, at least (default 45)",
         OPTION_NUMBER, &a.psnr, 0, &a.psnr_given},
        {"--ratio", "R", "or its ratio: 3 bytes per pixel / file bytes", OPTION_NUMBER, &a.ratio, 0,
         &a.ratio_given},
        {"--progressive", NULL,
         "first write OUT-1.png to OUT-3.png, from coarse to fine (engines sheet, transform)",
         OPTION_FLAG, &a.progressive, 0, NULL},
        {"--budget-ms", "MS", "draw the finest level that takes at most this time (engine sheet)",
         OPTION_NUMBER, &a.budget_ms, 0, &a.budget_given},
        {NULL, NULL, "Camera:", OPTION_HEADING, NULL, 0, NULL},
        {"--size", "W[xH]", "size of the picture in pixels (default 512x512)", OPTION_SIZE, a.size,
         0, NULL},
        {"--azimuth", "DEG",
         "angle of the eye around z; 0 is in front, at -y (default: three-quarter view)",
         OPTION_NUMBER, &a.azimuth, 0, &a.azimuth_given},
        {"--elevation", "DEG",
         "angle of the eye above the horizon (default 0 if --azimuth is given)", OPTION_NUMBER,
         &a.elevation, 0, &a.elevation_given},
        {"--view", "NAME",
         "instead of these angles: front, back, left, right, top, bottom, anterior, axial, ...",
         OPTION_TEXT, &a.view_name, 0, NULL},
        {"--roll", "DEG", "turn the camera counter-clockwise (default 0)", OPTION_NUMBER, &a.roll,
         0, NULL},
        {"--zoom", "Z", "magnification (default 1)", OPTION_NUMBER, &a.zoom, 0, &a.zoom_given},
        {"--perspective", "FOV",
         "perspective with a vertical field of view of 1 to 150 degrees (default: parallel)",
         OPTION_NUMBER, &a.perspective, 0, &a.perspective_given},
        {"--eye", "X,Y,Z",
         "position of the eye from the volume's centre, instead of angles and zoom",
         OPTION_NUMBERS3, a.eye, 0, &a.eye_given},
        {"--look-at", "X,Y,Z",
         "centre of the picture, from the volume's centre (default: by --fit)", OPTION_NUMBERS3,
         a.look_at, 0, &a.look_at_given},
        {"--fit", "WHAT",
         "zoom 1 shows: object (default), what is visible; turn, that from all sides; or box",
         OPTION_TEXT, &a.fit_name, 0, NULL},
        {"--up", "X,Y,Z", "up direction of --eye (default 0,0,1)", OPTION_NUMBERS3, a.up, 0,
         &a.up_given},
        {"--mirror", NULL, "exchange left and right", OPTION_FLAG, &a.mirror, 0, NULL},
        {"--clip", "BOX", "draw only samples X0:X1,Y0:Y1,Z0:Z1, as in 10:,25%:75%, (empty: all)",
         OPTION_TEXT, &a.clip_text, 0, NULL},
        {"--clip-plane", "NX,NY,NZ,D",
         "draw only points at least D from the centre in direction N (up to 6)", OPTION_TEXTS,
         &a.clip_planes, CVOL_CLIP_PLANES, NULL},
        {NULL, NULL, "Animations:", OPTION_HEADING, NULL, 0, NULL},
        {"--turntable", "N",
         "N pictures of one turn: turn-{n}.png, .gif, .webp; with ffmpeg .mp4 .mov .mkv .webm",
         OPTION_INTEGER, &a.turntable, 1, &a.turntable_given},
        {"--over-time", NULL, "a picture of each time of a series, all with the same colours",
         OPTION_FLAG, &a.over_time, 0, NULL},
        {"--fps", "F", "pictures per second (default 25)", OPTION_NUMBER, &a.fps, 0, &a.fps_given},
        {"--quality", "Q", "quality of WebP and video, 0 to 100 (default 90; WebP 100: lossless)",
         OPTION_INTEGER, &a.quality, 0, &a.quality_given},
        LOOK_OPTIONS(a),
        {"--channel-colors", "A,B",
         "colours of channels (modes composite, mip, xray), as in green,magenta or #00ff40,...",
         OPTION_TEXT, &a.channel_colours, 0, NULL},
        {"--labels", "LIST",
         "of a volume of labels draw only these: numbers and names, as in 3,5,7-9", OPTION_TEXT,
         &a.labels_text, 0, NULL},
        {"--label-table", "FILE",
         "names and colours of labels: a file of ITK-SNAP, FreeSurfer or 3D Slicer", OPTION_TEXT,
         &a.label_file, 0, NULL},
        {NULL, NULL, "Overlays (engines sheet and ray):", OPTION_HEADING, NULL, 0, NULL},
        OVERLAY_OPTIONS(a.overlay),
        {NULL, NULL, "Many projections (engine fourier), as float32 volume or grey pictures:",
         OPTION_HEADING, NULL, 0, NULL},
        {"--poses", "FILE",
         "one line per projection: w,x,y,z or azimuth,elevation,roll; -o STACK.nrrd or p-{n}.png",
         OPTION_TEXT, &a.poses, 0, NULL},
        {"--integrals", NULL,
         "integrals along rays, in the volume's unit of length, instead of means", OPTION_FLAG,
         &a.integrals, 0, NULL},
        INPUT_OPTIONS(a.common),
        COMMON_OPTIONS(a.common),
    };
    const char **inputs = calloc((size_t)argc, sizeof *inputs);
    if (!inputs)
        return report_error(EXIT_FAILED, "not enough memory");
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
        !(status = check_parts(&s, &a, line.all_count)) && !(status = check_certify(&s, &a)) &&
        !(status = check_maps(&s, &a, line.all_count)) && !(status = check_overlays(&s, &a)) &&
        !(status = check_over_time(&a)) && !(status = check_turntable(&s, &a)) &&
        !(status = a.poses             ? check_poses(&a)
                   : a.turntable_given ? EXIT_DONE
                                       : check_picture(&s, &a)))
        status = run(&a, &s, inputs, line.all_count);
    free(inputs);
    return status;
}
