/* The common options of render and bench, and the renderer that they describe. */
#ifndef CVOL_TOOLS_RENDER_OPTIONS_H
#define CVOL_TOOLS_RENDER_OPTIONS_H

#include "tools/base/cli.h"
#include "tools/labels/labels.h"
#include "tools/render/overlay_options.h"

/* One bound of --clip. */
typedef struct render_bound {
    enum { BOUND_NONE = 0, BOUND_SAMPLES, BOUND_PERCENT } kind;
    double value;
} render_bound;

typedef struct render_arguments {
    common_options common;
    const char *engine_name, *mode_name, *transfer_name, *output;
    int size[2], size_given;
    double azimuth, elevation, roll, zoom, step;
    int azimuth_given, elevation_given;
    const char *background_text, *window_text, *rescale_text; /* NULL: not given */
    double background[3], window[2], rescale[2]; /* their values, set by check_render_arguments */
    double opacity_scale;
    int transparent, has_gradient, opacity_scale_given, window_auto;
    /* of cvol render only */
    const char *view_name;
    int bits, annotate;
    double perspective, eye[3], look_at[3], up[3];
    int perspective_given, eye_given, up_given, zoom_given, look_at_given, mirror;
    int fit;               /* FIT_OBJECT or FIT_BOX, set by check_render_arguments */
    const char *clip_text; /* NULL: not given */
    text_list clip_planes;
    render_bound clip[6]; /* their values, set by check_clip */
    double clip_plane[CVOL_CLIP_PLANES][4];
    int over_time; /* then turntable is the number of times */
    int turntable, turntable_given, quality, quality_given, fps_given;
    double fps;
    const char *colormap;              /* NULL: not given */
    const char *light_text, *fit_name; /* NULL: not given */
    int is_channel;       /* one of several that are drawn together, set by open_channels */
    int has_default_look; /* cvol render: camera, frame and light of cvol/look.h */
    double fill_light, occlusion, shadows;
    int samples, samples_given;
    int fill_light_given, occlusion_given, shadows_given, keep_brightness;
    int shade, ambient_given, diffuse_given, specular_given, shininess_given,
        gradient_opacity_given, shininess, iso_given, iso_colour_given;
    double light[3], ambient, diffuse, specular, gradient_opacity, iso, iso_colour[3];
    /* engine splat; NULL: not given */
    const char *footprint_name, *order_name, *plane_name, *ray_order_name;
    int footprint_size, footprint_given, sigma_given;
    double sigma;
    const char *spectrum_name, *schedule_name; /* engine transform; NULL: not given */
    double rho;
    int rho_given, tile, tile_given;
    double psnr, ratio; /* of a compressed picture */
    int psnr_given, ratio_given, progressive;
    double depth_cue; /* engine fourier */
    int depth_cue_given, integrals;
    const char *poses;
    int transfer_given;
    const char *channel_colours; /* of several channels; NULL: not given */
    const char *axis_name;       /* of cvol bake */
    double oversample;
    int oversample_given; /* engine sheet */
    double keep_mb;
    int keep_given;                        /* engine sheet */
    const char *depth_name, *opacity_name; /* further files; NULL: none */
    int certify;
    const char *labels_text, *label_file; /* --labels and --label-table; NULL: not given */
    overlay_options overlay;
    int views, repeat;
    double budget_ms;
    int budget_given, level_given;
} render_arguments;

#define RENDER_ARGUMENTS_DEFAULTS                                                          \
    {                                                                                      \
        .common = COMMON_DEFAULTS, .transfer_name = "auto", .size = {512, 512}, .zoom = 1, \
        .views = 12, .repeat = 3, .opacity_scale = 1, .bits = 8, .quality = 90, .fps = 25  \
    }

#define LOOK_OPTIONS(a)                                                                            \
    {NULL, NULL, "Look:", OPTION_HEADING, NULL, 0, NULL},                                          \
        {"--mode",                                                                                 \
         "MODE",                                                                                   \
         "composite (default), xray (default of fourier), mip, min, mean (= xray) or iso",         \
         OPTION_TEXT,                                                                              \
         &(a).mode_name,                                                                           \
         0,                                                                                        \
         NULL},                                                                                    \
        {"--transfer",                                                                             \
         "NAME|FILE",                                                                              \
         "name (see cvol render --help) or JSON file of the transfer function (default auto)",     \
         OPTION_TEXT,                                                                              \
         &(a).transfer_name,                                                                       \
         0,                                                                                        \
         &(a).transfer_given},                                                                     \
        {"--colormap",                                                                             \
         "NAME",                                                                                   \
         "colours of another named transfer function, by value: viridis, hot, gray, ...",          \
         OPTION_TEXT,                                                                              \
         &(a).colormap,                                                                            \
         0,                                                                                        \
         NULL},                                                                                    \
        {"--window",                                                                               \
         "C,W",                                                                                    \
         "spread colours, greys or those of a cut over the values C - W/2 to C + W/2; or auto",    \
         OPTION_TEXT,                                                                              \
         &(a).window_text,                                                                         \
         0,                                                                                        \
         NULL},                                                                                    \
        {"--opacity-scale",                                                                        \
         "S",                                                                                      \
         "multiply the density by S (default 1)",                                                  \
         OPTION_NUMBER,                                                                            \
         &(a).opacity_scale,                                                                       \
         0,                                                                                        \
         &(a).opacity_scale_given},                                                                \
        {"--rescale",                                                                              \
         "S,I",                                                                                    \
         "a sample s means S s + I, as in 1,-1024 (default: as in the file)",                      \
         OPTION_TEXT,                                                                              \
         &(a).rescale_text,                                                                        \
         0,                                                                                        \
         NULL},                                                                                    \
        {"--iso",       "VALUE",  "value of the surface in mode iso, after --rescale",             \
         OPTION_NUMBER, &(a).iso, 0,                                                               \
         &(a).iso_given},                                                                          \
        {"--iso-colour",                                                                           \
         "R,G,B",                                                                                  \
         "colour of the surface, each 0..1 (default 0.9,0.85,0.75)",                               \
         OPTION_NUMBERS3,                                                                          \
         (a).iso_colour,                                                                           \
         0,                                                                                        \
         &(a).iso_colour_given},                                                                   \
        {"--light",                                                                                \
         "LIGHT",                                                                                  \
         "studio (default), cinematic (scattered), headlight, flat (none), or a direction X,Y,Z",  \
         OPTION_TEXT,                                                                              \
         &(a).light_text,                                                                          \
         0,                                                                                        \
         NULL},                                                                                    \
        {"--samples",                                                                              \
         "N",                                                                                      \
         "scatter light once, from N directions, 2 to 65536 (--light cinematic: 64)",              \
         OPTION_INTEGER,                                                                           \
         &(a).samples,                                                                             \
         0,                                                                                        \
         &(a).samples_given},                                                                      \
        {"--shade", NULL, "the same as --light headlight", OPTION_FLAG, &(a).shade, 0, NULL},      \
        {"--occlusion",                                                                            \
         "O",                                                                                      \
         "darken what its surroundings hide from ambient light, 0 to 1",                           \
         OPTION_NUMBER,                                                                            \
         &(a).occlusion,                                                                           \
         0,                                                                                        \
         &(a).occlusion_given},                                                                    \
        {"--shadows",       "S",          "strength of the shadows of the light, 0 to 1",          \
         OPTION_NUMBER,     &(a).shadows, 0,                                                       \
         &(a).shadows_given},                                                                      \
        {"--fill-light",                                                                           \
         "F",                                                                                      \
         "a second light, from the eye, 0 to 10",                                                  \
         OPTION_NUMBER,                                                                            \
         &(a).fill_light,                                                                          \
         0,                                                                                        \
         &(a).fill_light_given},                                                                   \
        {"--keep-brightness",                                                                      \
         NULL,                                                                                     \
         "expose lit pictures as brightly as unlit ones (part of --light studio)",                 \
         OPTION_FLAG,                                                                              \
         &(a).keep_brightness,                                                                     \
         0,                                                                                        \
         NULL},                                                                                    \
        {"--ambient",  "A", "ambient light, 0 to 10", OPTION_NUMBER,                               \
         &(a).ambient, 0,   &(a).ambient_given},                                                   \
        {"--diffuse",       "D", "diffuse reflection, 0 to 10", OPTION_NUMBER, &(a).diffuse, 0,    \
         &(a).diffuse_given},                                                                      \
        {"--specular",       "S", "specular reflection, 0 to 10", OPTION_NUMBER, &(a).specular, 0, \
         &(a).specular_given},                                                                     \
        {"--shininess",                                                                            \
         "N",                                                                                      \
         "exponent of highlights, 1 to 256: larger makes them smaller",                            \
         OPTION_INTEGER,                                                                           \
         &(a).shininess,                                                                           \
         0,                                                                                        \
         &(a).shininess_given},                                                                    \
        {"--gradient-opacity",                                                                     \
         "G",                                                                                      \
         "reduce the density where the gradient is below G per sample",                            \
         OPTION_NUMBER,                                                                            \
         &(a).gradient_opacity,                                                                    \
         0,                                                                                        \
         &(a).gradient_opacity_given},                                                             \
        {"--background",                                                                           \
         "COLOUR",                                                                                 \
         "R,G,B (0..1), #rrggbb, black (default), white, grey, red, gradient or transparent",      \
         OPTION_TEXT,                                                                              \
         &(a).background_text,                                                                     \
         0,                                                                                        \
         NULL},                                                                                    \
        {"--level",                                                                                \
         "L",                                                                                      \
         "resolution of a .cvol: 0 full, 1 to 3: 1/2, 1/4, 1/8 (default: as fine as needed)",      \
         OPTION_INTEGER,                                                                           \
         &(a).common.level,                                                                        \
         0,                                                                                        \
         &(a).level_given},                                                                        \
        {"--engine",                                                                               \
         "ENGINE",                                                                                 \
         "sheet (default), ray (slow reference), splat, transform or fourier",                     \
         OPTION_TEXT,                                                                              \
         &(a).engine_name,                                                                         \
         0,                                                                                        \
         NULL},                                                                                    \
        {"--footprint",                                                                            \
         "NAME",                                                                                   \
         "sheet: linear, catmull-rom, b-spline, gaussian; splat: gaussian, sinc, box, cone",       \
         OPTION_TEXT,                                                                              \
         &(a).footprint_name,                                                                      \
         0,                                                                                        \
         NULL},                                                                                    \
        {"--footprint-size",                                                                       \
         "N",                                                                                      \
         "splat, transform: width of the footprint in samples, 3 to 31 (default 5)",               \
         OPTION_INTEGER,                                                                           \
         &(a).footprint_size,                                                                      \
         0,                                                                                        \
         &(a).footprint_given},                                                                    \
        {"--sigma",                                                                                \
         "S",                                                                                      \
         "standard deviation of a Gaussian, in samples (default N / 6; sheet: 5 / 6)",             \
         OPTION_NUMBER,                                                                            \
         &(a).sigma,                                                                               \
         0,                                                                                        \
         &(a).sigma_given},                                                                        \
        {"--order",                                                                                \
         "ORDER",                                                                                  \
         "splat, transform: composite slices from: front (default) or back",                       \
         OPTION_TEXT,                                                                              \
         &(a).order_name,                                                                          \
         0,                                                                                        \
         NULL},                                                                                    \
        {"--footprint-plane",                                                                      \
         "PLANE",                                                                                  \
         "splat: plane in which footprints are round: view (default) or slices",                   \
         OPTION_TEXT,                                                                              \
         &(a).plane_name,                                                                          \
         0,                                                                                        \
         NULL},                                                                                    \
        {"--tile",                                                                                 \
         "N",                                                                                      \
         "transform: tiles of 8, 16 (default) or 32 samples a side; 0: whole slices",              \
         OPTION_INTEGER,                                                                           \
         &(a).tile,                                                                                \
         0,                                                                                        \
         &(a).tile_given},                                                                         \
        {"--spectrum",                                                                             \
         "NAME",                                                                                   \
         "transform: dct (default), dft or dht (these two for whole slices only)",                 \
         OPTION_TEXT,                                                                              \
         &(a).spectrum_name,                                                                       \
         0,                                                                                        \
         NULL},                                                                                    \
        {"--rho",                                                                                  \
         "SHARE",                                                                                  \
         "transform, fourier: share of coefficients to keep (default 0.1; fourier: all)",          \
         OPTION_NUMBER,                                                                            \
         &(a).rho,                                                                                 \
         0,                                                                                        \
         &(a).rho_given},                                                                          \
        {"--schedule",                                                                             \
         "NAME",                                                                                   \
         "transform: deferred (default; composite samples) or literal (coefficients)",             \
         OPTION_TEXT,                                                                              \
         &(a).schedule_name,                                                                       \
         0,                                                                                        \
         NULL},                                                                                    \
        {"--depth-cue",                                                                            \
         "S",                                                                                      \
         "fourier: how much darker the far end is, 0 (default) to 1",                              \
         OPTION_NUMBER,                                                                            \
         &(a).depth_cue,                                                                           \
         0,                                                                                        \
         &(a).depth_cue_given},                                                                    \
        {"--oversample",                                                                           \
         "N",                                                                                      \
         "sheet: N x N rays per pixel, 0.25 to 4 (default 1; mode iso: means of 2 x 2)",           \
         OPTION_NUMBER,                                                                            \
         &(a).oversample,                                                                          \
         0,                                                                                        \
         &(a).oversample_given},                                                                   \
        {"--keep-mb",                                                                              \
         "MB",                                                                                     \
         "sheet: block cache size for later pictures (default 0: off)",                            \
         OPTION_NUMBER,                                                                            \
         &(a).keep_mb,                                                                             \
         0,                                                                                        \
         &(a).keep_given},                                                                         \
        {"--ray-order",                                                                            \
         "ORDER",                                                                                  \
         "sheet: order of the rays: image, object (faster, softer) or auto (default)",             \
         OPTION_TEXT,                                                                              \
         &(a).ray_order_name,                                                                      \
         0,                                                                                        \
         NULL},                                                                                    \
    {                                                                                              \
        "--step", "VOXELS",                                                                        \
            "distance of samples along rays (default: ray 0.5; sheet one per slice)",              \
            OPTION_NUMBER, &(a).step, 0, NULL                                                      \
    }

/* Names of transfer functions: a paragraph of the help. */
#define TRANSFER_NAMES                                                                            \
    "Transfer functions: auto gray bone skin-bone mri microscopy field dense hot viridis magma\n" \
    "cool-warm adapt to the values of the volume; ct-body ct-bone ct-skin ct-lung ct-vessels\n"   \
    "are in Hounsfield units.\n"

/* A renderer over an input, with its transfer function. */
typedef struct scene_colours scene_colours; /* render_colours.c */

typedef struct scene {
    input in;
    uint8_t *mask; /* for engine ray; NULL: all samples have a value */
    cvol_renderer *renderer;
    cvol_render_options options;
    cvol_engine engine;
    double rho;              /* of engine fourier */
    double rescale[2];       /* a sample s means rescale[0] s + rescale[1] */
    const char *value_unit;  /* unit of the meaning: "HU", or "" */
    cvol_transfer *transfer; /* of mode composite; NULL: a baked volume's own */
    int mirrored; /* by --mirror, or a named view of samples whose axes are left-handed; */
                  /* not by both */
    double load_ms;
    int drawn_level; /* of the last picture; engine sheet */
    /* Of several processes: the level at which each reads its box of the file, while `in` has a
     * coarse level of the whole; -1: `in` has all. */
    int box_level;
    const char *path;
    const common_options *common;
    /* The first of several channels; see open_channels. */
    struct scene *others;
    int other_count;
    double colour[3];
    /* Animations over time: the histogram of each channel over all times, to which values are
     * fitted; or NULL. */
    const cvol_histogram *shared;
    scene_colours *colours; /* of RGB samples, of which `in` is the shape; NULL: none */
    label_set *labels;      /* the drawn labels; NULL: no labels, or their own values */
    cvol_volume
        *numbers; /* of the labels, whose shape is drawn (render_labels.c); NULL: the samples */
                  /* that are drawn are the numbers */
    struct scene_overlay *overlays; /* render_overlay.c */
    int overlay_count;
    int has_kind; /* --transfer auto chose the colours of a kind of data */
    cvol_kind kind;
    int has_frame, has_joined; /* the frame has those of the other channels */
    cvol_camera frame;         /* zoom and look_at of --fit object, at zoom 1 */
} scene;

/* The largest number of channels in one picture. */
#define CHANNELS_MAX 16

/* 1 if the mode shows values as grey levels. */
static inline int is_grey_mode(cvol_mode mode)
{
    return mode == CVOL_MODE_XRAY || mode == CVOL_MODE_MIP || mode == CVOL_MODE_MIN;
}

/* Sets the engine, unless one was given, to one that can draw the file. */
void choose_default_engine(render_arguments *a, const char *path);
/* Checks the options and sets the default mode. Exit status. */
int check_render_arguments(scene *s, render_arguments *arguments);
/* render_unused.c: print which options change nothing; note_unused_level of the open input. */
void note_unused(const scene *s, const render_arguments *a);
void note_unused_level(const scene *s, const render_arguments *a, const char *path);
/* Opens the input and makes the renderer. Exit status. */
int open_scene(cvol_context *context, scene *s, render_arguments *arguments, const char *path);
/* The grid of the open volume or baked volume. */
const cvol_grid *scene_grid(cvol_context *context, const scene *s, cvol_baked_info *info);
/* Sets the camera to the named view, if there is one, and turns it. Exit status. */
int aim_camera(cvol_context *context, scene *s, const render_arguments *a, double turn_deg);
void close_scene(scene *s);

/* render_clip.c: --clip, --clip-plane and --eye. Exit status. */
/* --light and the options of light. Exit status. */
int choose_light(scene *s, render_arguments *a);
/* The first given option that needs a light and chooses none; NULL: none. */
const char *find_light_detail(const render_arguments *a);
/* No light where only faces are visible, unless the options ask for one. */
void drop_default_light(scene *s, const render_arguments *a);

int check_clip(render_arguments *a);
int check_eye(const render_arguments *a);
void set_clip(cvol_clip *clip, const render_arguments *a, const cvol_grid *grid);
cvol_camera render_camera(const render_arguments *a, double turn_deg);

/* render_mask.c: find_marks finds a value that marks missing dense samples; find_mask makes
 * s->mask, which stays NULL if none is missing. Exit status. */
int find_marks(cvol_context *context, scene *s, const char *path);
int find_mask(scene *s);

/* render_transfer.c: transfer function, window and scale of values. Exit status. */
int check_values(render_arguments *a, cvol_mode mode);
int choose_values(cvol_context *context, scene *s, const render_arguments *a, const char *path);
int is_file_name(const char *name);
/* Reads a transfer function of values, and makes that of samples: a sample s means rescale[0] s +
 * rescale[1]. Exit status. */
int read_transfer(cvol_context *context, cvol_transfer **out, const char *name,
                  const double rescale[2]);

/* The histogram of the open volume. Exit status. */
int find_histogram(cvol_context *context, cvol_histogram *out, const scene *s);

/* render_labels.c: --labels and --label-table. check_label_options checks them; choose_labels
 * numbers the labels of the open input, if the options ask for it or its labels need it. Exit
 * status. */
int check_label_options(const render_arguments *a, cvol_mode mode);
int choose_labels(cvol_context *context, scene *s, const render_arguments *a, const char *path);
/* Draws a picture of floats of the shape of numbered labels, in their colours. A code of the
 * library. */
int draw_labels(cvol_context *context, cvol_renderer *renderer, cvol_image *image,
                const cvol_render_options *options, const cvol_volume *numbers,
                const label_set *labels, const cvol_transfer *transfer);
/* colours[3 i + k] of label i of a set. */
void list_colours(double colours[3 * LABELS_DRAWN_MAX], const label_set *labels);

/* render_colours.c: volumes of RGB samples, of which s->in has a component until choose_colours
 * reads the others and puts their shape in its place. choose_colours: exit status;
 * make_colour_transfer: a code of the library, the transfer function of the shape. */
int choose_colours(cvol_context *context, scene *s, const render_arguments *a, const char *path);
int make_colour_transfer(cvol_context *context, cvol_transfer **out, const scene *s);
void close_colours(scene *s);

/* render_parts.c. The level at which the whole volume is opened, where one process would open level
 * `enough`: a coarse one, if each process can read its own box later; s->box_level is then
 * `enough`, else -1. */
int find_whole_level(cvol_context *context, scene *s, const render_arguments *a, int enough,
                     const char *path);

/* render_overlay.c: --overlay. check_overlays checks the options; open_overlays opens them for the
 * grid of an open scene. Exit status. */
int check_overlays(const scene *s, const render_arguments *a);
int open_overlays(cvol_context *context, scene *s, const render_arguments *a, const char *path);
void close_overlays(scene *s);

/* render_poses.c: renders `arguments->poses` as a stack of projections. Exit status. */
int check_poses(const render_arguments *arguments);
int render_poses(cvol_context *context, render_arguments *arguments, scene *s, const char *path);
/* Adds the report of engine fourier; nothing for other engines. */
void describe_fourier(json_t *object, cvol_context *context, const scene *s);

#endif
