/* From the options of render and bench to a renderer. */
#include "tools/render/render_options.h"

#include <stdlib.h>
#include <string.h>
#include <strings.h>

static int choose_footprint(cvol_splat_options *splat, const render_arguments *a)
{
    int footprint = CVOL_FOOTPRINT_GAUSSIAN;
    if (a->footprint_name &&
        parse_word(&footprint, &footprint_words, "--footprint", a->footprint_name))
        return EXIT_MISUSED;
    splat->footprint = (cvol_footprint)footprint;
    if (a->footprint_given) {
        if (a->footprint_size < 3 || a->footprint_size > 31)
            return report_error(EXIT_MISUSED, "--footprint-size is %d, must be 3 to 31 samples",
                                a->footprint_size);
        splat->size = a->footprint_size;
    }
    if (a->sigma_given && footprint != CVOL_FOOTPRINT_GAUSSIAN)
        return report_error(EXIT_MISUSED, "--sigma works only with --footprint gaussian, not %s",
                            a->footprint_name);
    if (a->sigma_given && !(a->sigma >= 0.2 && a->sigma <= 31))
        return report_error(EXIT_MISUSED, "--sigma is %g, must be 0.2 to 31 samples", a->sigma);
    splat->sigma = a->sigma;
    return EXIT_DONE;
}

/* Footprints and rays of engine sheet. */
static int choose_sheet(cvol_sheet_options *sheet, const render_arguments *a)
{
    int footprint = CVOL_SHEET_LINEAR, ray_order = CVOL_RAY_ORDER_AUTO;
    if (a->footprint_name && parse_word(&footprint, &sheet_footprint_words,
                                        "--footprint of engine sheet", a->footprint_name))
        return EXIT_MISUSED;
    sheet->footprint = (cvol_sheet_footprint)footprint;
    if (a->sigma_given && footprint != CVOL_SHEET_GAUSSIAN)
        return report_error(EXIT_MISUSED, "--sigma works only with --footprint gaussian, not %s",
                            word_of(&sheet_footprint_words, footprint));
    if (a->sigma_given && !(a->sigma >= 0.5 && a->sigma <= 1))
        return report_error(EXIT_MISUSED,
                            "--sigma is %g, must be 0.5 to 1 samples with engine sheet", a->sigma);
    sheet->sigma = a->sigma;
    if (a->ray_order_name &&
        parse_word(&ray_order, &ray_order_words, "--ray-order", a->ray_order_name))
        return EXIT_MISUSED;
    sheet->ray_order = (cvol_ray_order)ray_order;
    return EXIT_DONE;
}

/* The surface of mode iso. */
static int choose_surface(scene *s, const render_arguments *a)
{
    cvol_surface *surface = &s->options.surface;
    const int is_surface = s->options.mode == CVOL_MODE_ISO;
    if (!is_surface && (a->iso_given || a->iso_colour_given))
        return report_error(EXIT_MISUSED, "%s works only with --mode iso",
                            a->iso_given ? "--iso" : "--iso-colour");
    if (!is_surface)
        return EXIT_DONE;
    if (!a->iso_given)
        return report_error(EXIT_MISUSED, "no surface: give --iso VALUE with --mode iso");
    for (int c = 0; c < 3 && a->iso_colour_given; c++) {
        if (!(a->iso_colour[c] >= 0 && a->iso_colour[c] <= 1))
            return report_error(EXIT_MISUSED, "--iso-colour has %g, each must be 0 to 1",
                                a->iso_colour[c]);
        surface->colour[c] = a->iso_colour[c];
    }
    surface->value = a->iso;
    return EXIT_DONE;
}

static int has_splats(const scene *s)
{
    return s->engine == CVOL_ENGINE_SPLAT || s->engine == CVOL_ENGINE_TRANSFORM;
}

/* Footprints, and the options of engines splat and transform. */
static int choose_splat(scene *s, const render_arguments *a)
{
    cvol_splat_options *splat = &s->options.splat;
    const struct {
        const char *name;
        int given;
    } own[] = {{"--footprint-size", a->footprint_given},
               {"--order", a->order_name != NULL},
               {"--footprint-plane", a->plane_name != NULL},
               {"--footprint", a->footprint_name != NULL},
               {"--sigma", a->sigma_given}};
    for (int k = 0; k < 5 && !has_splats(s); k++)
        if (own[k].given && (k < 3 || s->engine != CVOL_ENGINE_SHEET))
            return report_error(EXIT_MISUSED, "%s works only with engines %ssplat and transform",
                                own[k].name, k < 3 ? "" : "sheet, ");
    if (s->engine == CVOL_ENGINE_SHEET)
        return choose_sheet(&s->options.sheet, a);
    if (!has_splats(s))
        return EXIT_DONE;
    if (s->options.mode != CVOL_MODE_COMPOSITE)
        return report_error(EXIT_MISUSED,
                            "--mode %s does not work with engine %s, which has mode composite only",
                            a->mode_name, a->engine_name);
    int order = CVOL_ORDER_FRONT, plane = CVOL_FOOTPRINT_IN_VIEW;
    if ((a->order_name && parse_word(&order, &order_words, "--order", a->order_name)) ||
        (a->plane_name && parse_word(&plane, &plane_words, "--footprint-plane", a->plane_name)))
        return EXIT_MISUSED;
    if (a->plane_name && s->engine == CVOL_ENGINE_TRANSFORM && plane == CVOL_FOOTPRINT_IN_VIEW)
        return report_error(EXIT_MISUSED,
                            "--footprint-plane view works only with engine splat; leave "
                            "it out with engine transform");
    splat->plane = (cvol_footprint_plane)plane;
    splat->order = (cvol_order)order;
    int status = choose_footprint(splat, a);
    if (!status && s->engine == CVOL_ENGINE_TRANSFORM && splat->footprint == CVOL_FOOTPRINT_CONE)
        return report_error(EXIT_MISUSED,
                            "--footprint cone works only with engine splat; give gaussian, "
                            "sinc or box");
    return status;
}

/* The options of engine transform. */
static int choose_transform(scene *s, const render_arguments *a)
{
    cvol_transform_options *own = &s->options.transform;
    const char *given = a->spectrum_name   ? "--spectrum"
                        : a->schedule_name ? "--schedule"
                        : a->tile_given    ? "--tile"
                                           : NULL;
    if (a->rho_given && s->engine != CVOL_ENGINE_TRANSFORM && s->engine != CVOL_ENGINE_FOURIER)
        return report_error(EXIT_MISUSED, "--rho works only with engines transform and fourier");
    if (a->rho_given && !(a->rho > 0 && a->rho <= 1))
        return report_error(EXIT_MISUSED, "--rho is %g, must be above 0 and at most 1", a->rho);
    if (s->engine != CVOL_ENGINE_TRANSFORM)
        return given ? report_error(EXIT_MISUSED, "%s works only with engine transform", given)
                     : EXIT_DONE;
    int schedule = CVOL_SCHEDULE_DEFERRED, transform = CVOL_DCT;
    if ((a->schedule_name &&
         parse_word(&schedule, &schedule_words, "--schedule", a->schedule_name)) ||
        (a->spectrum_name &&
         parse_word(&transform, &transform_words, "--spectrum", a->spectrum_name)))
        return EXIT_MISUSED;
    own->schedule = (cvol_schedule)schedule;
    own->transform = (cvol_transform)transform;
    if (own->transform != CVOL_DCT)
        own->tile = 0; /* DFT and DHT need whole slices */
    if (a->tile_given && a->tile != 0 && a->tile != 8 && a->tile != 16 && a->tile != 32)
        return report_error(EXIT_MISUSED, "--tile is %d, must be 0, 8, 16 or 32", a->tile);
    if (a->tile_given && a->tile != 0 && own->transform != CVOL_DCT)
        return report_error(EXIT_MISUSED, "--tile %d works only with --spectrum dct, not %s",
                            a->tile, a->spectrum_name);
    if (a->tile_given)
        own->tile = a->tile;
    if (a->rho_given)
        own->rho = a->rho;
    return EXIT_DONE;
}

/* The mode and the options of engine fourier. */
static int choose_fourier(scene *s, const render_arguments *a)
{
    const char *given = a->depth_cue_given ? "--depth-cue"
                        : a->poses         ? "--poses"
                        : a->integrals     ? "--integrals"
                                           : NULL;
    if (s->engine != CVOL_ENGINE_FOURIER)
        return given ? report_error(EXIT_MISUSED, "%s works only with engine fourier", given)
                     : EXIT_DONE;
    if (s->options.mode != CVOL_MODE_XRAY)
        return report_error(EXIT_MISUSED,
                            "--mode %s does not work with engine fourier, which has mode xray only",
                            a->mode_name);
    if (!(a->depth_cue >= 0 && a->depth_cue <= 1))
        return report_error(EXIT_MISUSED, "--depth-cue is %g, must be 0 to 1", a->depth_cue);
    if (a->integrals && !a->poses)
        return report_error(EXIT_MISUSED, "--integrals needs --poses; pictures show means");
    s->options.fourier.depth_cue = a->depth_cue;
    s->options.fourier.integrals = a->integrals;
    s->rho = a->rho;
    return EXIT_DONE;
}

static int parse_background(render_arguments *a, const char *text)
{
    if (!strcmp(text, "grey") || !strcmp(text, "gray")) { /* dark, as in the viewer */
        a->background[0] = 0.22;
        a->background[1] = 0.23;
        a->background[2] = 0.25;
        return EXIT_DONE;
    }
    if (!strchr(text, ',') && parse_colour(a->background, text, strlen(text)))
        return EXIT_DONE;
    if (!parse_numbers(a->background, 3, text))
        return report_error(
            EXIT_MISUSED,
            "--background is '%s', must be R,G,B, as in 1,0.5,0.5, #rrggbb, a name, as black, "
            "white, grey or red, gradient or transparent",
            text);
    for (int k = 0; k < 3; k++)
        if (!(a->background[k] >= 0 && a->background[k] <= 1))
            return report_error(EXIT_MISUSED, "--background has %g, each must be 0 to 1",
                                a->background[k]);
    return EXIT_DONE;
}

static int choose_picture_background(render_arguments *a)
{
    int background = PICTURE_BLACK;
    if (a->background_text &&
        !find_word(&background, &picture_background_words, a->background_text))
        return parse_background(a, a->background_text);
    a->transparent = background == PICTURE_TRANSPARENT;
    a->has_gradient = background == PICTURE_GRADIENT;
    for (int k = 0; k < 3 && background == PICTURE_WHITE; k++)
        a->background[k] = 1;
    return EXIT_DONE;
}

void choose_default_engine(render_arguments *a, const char *path)
{
    if (!a->engine_name)
        a->engine_name = a->certify                         ? "ray"
                         : kind_of(path) == CVOL_FILE_BAKED ? "transform"
                                                            : "sheet";
}

/* The word of the table that is written with other cases; NULL: none. */
static const char *lower_mode(const char *text)
{
    for (size_t i = 0; i < mode_words.count; i++)
        if (!strcasecmp(text, mode_words.words[i].word))
            return mode_words.words[i].word;
    return NULL;
}

int check_render_arguments(scene *s, render_arguments *a)
{
    s->options = cvol_render_options_defaults();
    int engine, mode;
    if (parse_word(&engine, &engine_words, "--engine", a->engine_name))
        return EXIT_MISUSED;
    s->engine = (cvol_engine)engine;
    if (!a->mode_name)
        a->mode_name = s->engine == CVOL_ENGINE_FOURIER ? "xray" : "composite";
    const char *const usual = lower_mode(a->mode_name);
    if (usual)
        a->mode_name = usual;
    if (parse_word(&mode, &mode_words, "--mode", a->mode_name))
        return EXIT_MISUSED;
    s->options.mode = (cvol_mode)mode;
    const int is_sheet = s->engine == CVOL_ENGINE_SHEET;
    if (a->step != 0 && s->engine != CVOL_ENGINE_RAY && !is_sheet)
        return report_error(EXIT_MISUSED, "--step works only with engines sheet and ray");
    if (a->step != 0 && a->step < 1 && is_sheet && is_grey_mode(s->options.mode))
        return report_error(
            EXIT_MISUSED,
            "--step below 1 works with engine sheet only in modes composite and iso, not in %s",
            a->mode_name);
    if (a->ray_order_name && !is_sheet)
        return report_error(EXIT_MISUSED, "--ray-order works only with engine sheet");
    if (a->oversample_given && !is_sheet)
        return report_error(EXIT_MISUSED, "--oversample works only with engine sheet");
    if (a->oversample_given && !(a->oversample >= 0.25 && a->oversample <= 4))
        return report_error(EXIT_MISUSED, "--oversample is %g, must be 0.25 to 4", a->oversample);
    s->options.oversample = a->oversample;
    if (a->keep_given && !is_sheet)
        return report_error(EXIT_MISUSED, "--keep-mb works only with engine sheet");
    if (!(a->keep_mb >= 0 && a->keep_mb <= 1e6))
        return report_error(EXIT_MISUSED, "--keep-mb is %g, must be 0 to 1000000", a->keep_mb);
    s->options.keep_mb = a->keep_mb;
    if (choose_splat(s, a) || choose_transform(s, a) || choose_fourier(s, a) ||
        choose_light(s, a) || choose_surface(s, a))
        return EXIT_MISUSED;
    if (a->step < 0)
        return report_error(EXIT_MISUSED, "--step is %g, must be above 0", a->step);
    if (!(a->zoom > 0))
        return report_error(EXIT_MISUSED, "--zoom is %g, must be above 0", a->zoom);
    if (a->budget_given && s->engine != CVOL_ENGINE_SHEET)
        return report_error(EXIT_MISUSED, "--budget-ms works only with engine sheet");
    if (a->budget_given && !(a->budget_ms > 0))
        return report_error(EXIT_MISUSED, "--budget-ms is %g, must be above 0", a->budget_ms);
    if (a->common.level > 3)
        return report_error(EXIT_MISUSED, "--level is %d, must be 0 to 3", a->common.level);
    for (int i = 0; i < 2; i++)
        if (a->size[i] > CVOL_IMAGE_SIZE_MAX)
            return report_error(EXIT_MISUSED, "--size has %d, must be 1 to %d", a->size[i],
                                CVOL_IMAGE_SIZE_MAX);
    if (choose_picture_background(a) || check_label_options(a, s->options.mode) ||
        check_values(a, s->options.mode) || check_clip(a) || check_eye(a))
        return EXIT_MISUSED;
    a->fit = a->has_default_look && !a->certify ? FIT_OBJECT : FIT_BOX;
    if (a->fit_name && parse_word(&a->fit, &fit_words, "--fit", a->fit_name))
        return EXIT_MISUSED;
    if (a->fit_name && a->fit != FIT_BOX && a->certify)
        return report_error(EXIT_MISUSED,
                            "--fit %s cannot be combined with --certify: its frame depends on the "
                            "samples; give --fit box",
                            a->fit_name);
    if (a->fit_name && a->fit != FIT_BOX && (a->eye_given || a->poses))
        return report_error(EXIT_MISUSED, "--fit %s cannot be combined with %s", a->fit_name,
                            a->eye_given ? "--eye" : "--poses");
    s->options.width = a->size[0];
    s->options.height = a->size[1];
    s->options.camera = render_camera(a, 0);
    s->options.step_voxels = a->step;
    memcpy(s->options.background, a->background, sizeof a->background);
    return EXIT_DONE;
}

static int create_renderer(cvol_context *context, scene *s, int compressed)
{
    cvol_source source = {.size = sizeof source, .mask = s->mask, .rho = s->rho};
    if (s->engine == CVOL_ENGINE_SHEET || (s->engine != CVOL_ENGINE_RAY && compressed))
        source.array = s->in.array;
    else
        source.volume = s->in.volume;
    return cvol_renderer_create(context, &s->renderer, s->engine, &source);
}

static int make_renderer(cvol_context *context, scene *s, const char *path)
{
    int status = find_marks(context, s, path);
    if (status)
        return status;
    /* Sheet needs an array and ray needs samples; the others take either, but with missing samples
     * an array. */
    const int compressed = s->engine == CVOL_ENGINE_SHEET ||
                           (s->engine != CVOL_ENGINE_RAY && (s->in.array || s->in.has_fill));
    status = compressed ? need_array(context, &s->in, path, 0, CVOL_BACKGROUND_FIND)
                        : need_volume(context, &s->in);
    if (!status && s->engine == CVOL_ENGINE_RAY)
        status = find_mask(s);
    if (status)
        return status;
    const int code = create_renderer(context, s, compressed);
    if (code)
        return report_context_error(context, code, NULL);
    /* The engine does not need the samples any more. */
    if (compressed) {
        cvol_volume_free(s->in.volume);
        s->in.volume = NULL;
    }
    return EXIT_DONE;
}

/* Takes options that were not given from the baked file. */
static void fill_from(scene *s, const render_arguments *a, const cvol_baked_info *info)
{
    cvol_splat_options *splat = &s->options.splat;
    cvol_transform_options *own = &s->options.transform;
    if (!a->footprint_name && !a->footprint_given && !a->sigma_given) {
        splat->footprint = info->splat.footprint;
        splat->size = info->splat.size;
        splat->sigma = info->splat.sigma;
    }
    if (!a->shade && !a->light_text) {
        s->options.shading.on = info->shading.on;
        memcpy(s->options.shading.light, info->shading.light, sizeof info->shading.light);
    }
    if (!a->rho_given)
        own->rho = info->rho;
    if (!a->spectrum_name)
        own->transform = info->transform;
    if (!a->tile_given && !a->spectrum_name)
        own->tile = info->tile;
}

/* Refuses a transfer function other than that of the file. Exit status. */
static int check_baked_transfer(cvol_context *context, scene *s, const render_arguments *a,
                                const cvol_baked_info *info, const char *path)
{
    const char *name = a->transfer_name;
    cvol_transfer *transfer = NULL;
    if (!a->transfer_given)
        return EXIT_DONE;
    if (!is_file_name(name) && strcmp(name, info->transfer_name))
        return report_error(EXIT_MISUSED, "%s: was baked with transfer function %s, not %s", path,
                            info->transfer_name[0] ? info->transfer_name : "of a file", name);
    if (!is_file_name(name))
        return EXIT_DONE;
    const double rescale[2] = {info->grid.value_scale, info->grid.value_offset};
    const int status = read_transfer(context, &transfer, name, rescale);
    if (status)
        return status;
    const int code = cvol_renderer_set_transfer(context, s->renderer, transfer);
    cvol_transfer_free(transfer);
    return code ? report_context_error(context, code, NULL) : EXIT_DONE;
}

/* Makes a renderer over baked slices. Exit status. */
static int open_baked(cvol_context *context, scene *s, const render_arguments *a, const char *path)
{
    cvol_baked_info info;
    if (s->engine != CVOL_ENGINE_TRANSFORM)
        return report_error(
            EXIT_MISUSED,
            "%s: is a baked volume, which engine %s cannot draw: give --engine transform", path,
            a->engine_name);
    if (a->axis_name)
        return report_error(EXIT_MISUSED, "%s: is already a baked volume: give the original volume",
                            path);
    if (a->labels_text || a->label_file)
        return report_error(EXIT_MISUSED, "%s: is a baked volume: leave out --label%s", path,
                            a->labels_text ? "s" : "-table");
    if (a->common.level || has_raw_options(&a->common) || a->common.fill_given)
        return report_error(EXIT_MISUSED,
                            "%s: is a baked volume: leave out --level and options for raw samples",
                            path);
    if (a->window_text || a->opacity_scale_given || a->rescale_text)
        return report_error(EXIT_MISUSED,
                            "%s: was baked with its transfer function: leave out --%s", path,
                            a->window_text           ? "window"
                            : a->opacity_scale_given ? "opacity-scale"
                                                     : "rescale");
    int code = cvol_renderer_create(context, &s->renderer, CVOL_ENGINE_TRANSFORM,
                                    CVOL_SOURCE(.baked_path = path));
    if (!code)
        code = cvol_renderer_get_baked_info(context, &info, s->renderer);
    if (code)
        return report_context_error(context, code, NULL);
    fill_from(s, a, &info);
    return check_baked_transfer(context, s, a, &info, path);
}

/* A frame around the visible part enlarges the picture about so much, or less. */
#define FRAME_ZOOM 2.5

/* *level: the coarsest level of the file that is fine enough for the picture; 0 if unknown. Exit
 * status. */
static int find_level(cvol_context *context, int *level, const scene *s, const render_arguments *a,
                      const char *path)
{
    const cvol_read_options *read = &a->common.read;
    const cvol_file_part part = {.size = sizeof(cvol_file_part),
                                 .time = read->has_index ? read->index : 0,
                                 .channel = read->has_channel ? read->channel : 0};
    cvol_grid grid;
    *level = a->level_given ? a->common.level : 0;
    if (a->level_given || a->labels_text || a->label_file || /* coarser samples are no labels */
        s->engine != CVOL_ENGINE_SHEET || !is_cvol(path))
        return EXIT_DONE;
    cvol_render_options options = s->options;
    if (a->fit != FIT_BOX)
        options.camera.zoom *= FRAME_ZOOM;
    const int code = cvol_file_read_grid(context, &grid, path, &part);
    if (code == CVOL_ERROR_IO || code == CVOL_ERROR_MEMORY)
        return report_context_error(context, code, code == CVOL_ERROR_MEMORY ? path : NULL);
    if (!code && cvol_render_choose_file_level(context, level, &grid, &options))
        *level = 0;
    return EXIT_DONE;
}

int open_scene(cvol_context *context, scene *s, render_arguments *arguments, const char *path)
{
    double start = milliseconds();
    if (kind_of(path) == CVOL_FILE_BAKED) {
        int baked_status = open_baked(context, s, arguments, path);
        if (!baked_status)
            baked_status = aim_camera(context, s, arguments, 0);
        s->load_ms = milliseconds() - start;
        return baked_status;
    }
    const int given = arguments->common.level;
    int enough, status = find_level(context, &enough, s, arguments, path);
    if (status)
        return status;
    arguments->common.level = find_whole_level(context, s, arguments, enough, path);
    status = open_input(context, &s->in, path, &arguments->common);
    arguments->common.level = given;
    if (!status && s->in.cut) {
        clear_progress();
        if (s->in.residual_missing)
            fprintf(stderr,
                    "cvol: %s: the file ends early; drawn without its residual, so samples are not "
                    "exact\n",
                    path);
        else
            fprintf(stderr, "cvol: %s: the file ends early; drawn at level %d, which is complete\n",
                    path, s->in.level);
    }
    if (!status)
        note_unused_level(s, arguments, path);
    const int level = s->in.level > enough && s->box_level < 0 ? s->in.level
                      : arguments->level_given                 ? enough
                                                               : 0;
    s->options.level = s->engine == CVOL_ENGINE_SHEET || s->engine == CVOL_ENGINE_TRANSFORM ? level
                                                                                            : 0;
    if (!status)
        status = choose_colours(context, s, arguments, path);
    if (!status)
        status = choose_labels(context, s, arguments, path);
    if (!status)
        status = make_renderer(context, s, path);
    if (!status)
        status = choose_values(context, s, arguments, path);
    if (!status)
        status = aim_camera(context, s, arguments, 0);
    s->load_ms = milliseconds() - start;
    return status;
}

void close_scene(scene *s)
{
    for (int c = 0; c < s->other_count; c++)
        close_scene(&s->others[c]);
    free(s->others);
    close_overlays(s);
    cvol_renderer_free(s->renderer); /* before its samples */
    close_colours(s);
    cvol_transfer_free(s->transfer);
    free(s->labels);
    cvol_volume_free(s->numbers);
    close_input(&s->in);
    free(s->mask);
}
