/* One picture: renders it, converts it to the format of its file, and writes it. */
#include "tools/render/render_picture.h"
#include "render/counters.h"
#include "tools/render/render_parts.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* The greys of --background gradient. */
#define GRADIENT_TOP 0.27
#define GRADIENT_BOTTOM 0.07

/* ---- arguments ---------------------------------------------------------------------- */

picture_kind picture_kind_of(const char *name)
{
    return has_ending(name, ".png")                                ? PICTURE_PNG
           : has_ending(name, ".jpg") || has_ending(name, ".jpeg") ? PICTURE_JPEG
           : has_ending(name, ".webp")                             ? PICTURE_WEBP
           : has_ending(name, ".pfm")                              ? PICTURE_PFM
           : has_ending(name, ".cvi")                              ? PICTURE_CVI
                                                                   : PICTURE_NONE;
}

static int check_compressed(const scene *s, const render_arguments *a)
{
    if (s->engine != CVOL_ENGINE_TRANSFORM)
        return report_error(
            EXIT_MISUSED,
            "%s: only engine transform draws compressed pictures: write a PNG, then use "
            "cvol compress",
            a->output);
    if (a->annotate)
        return report_error(
            EXIT_MISUSED,
            "%s: a compressed picture cannot be combined with --annotate: write a PNG", a->output);
    if (a->transparent || a->has_gradient)
        return report_error(EXIT_MISUSED,
                            "%s: a compressed picture cannot be combined with --background %s: "
                            "write a PNG",
                            a->output, a->transparent ? "transparent" : "gradient");
    return EXIT_DONE;
}

/* Checks bits, opacity and compression against the format of the file. */
int check_kind(const scene *s, const render_arguments *a)
{
    const picture_kind kind = picture_kind_of(a->output);
    if (kind == PICTURE_NONE)
        return report_error(
            EXIT_MISUSED,
            "%s: the picture's name must end in .png, .jpg, .webp, .pfm for floats, or .cvi for a "
            "compressed one",
            a->output);
    if (kind == PICTURE_CVI && check_compressed(s, a))
        return EXIT_MISUSED;
    if (a->bits != 8 && a->bits != 16)
        return report_error(EXIT_MISUSED, "--bits is %d, must be 8 or 16", a->bits);
    if (a->bits == 16 && kind != PICTURE_PNG)
        return report_error(EXIT_MISUSED, "%s: --bits 16 works only with PNG files", a->output);
    if (a->transparent && (kind == PICTURE_PFM || kind == PICTURE_JPEG))
        return report_error(EXIT_MISUSED,
                            "%s: a %s has no opacity: write a PNG with --background transparent",
                            a->output, kind == PICTURE_PFM ? "PFM" : "JPEG");
    return EXIT_DONE;
}

int check_picture(const scene *s, const render_arguments *a)
{
    if (!a->output)
        return report_error(EXIT_MISUSED, "no output: give -o OUT.png");
    const picture_kind kind = picture_kind_of(a->output);
    if (check_kind(s, a))
        return EXIT_MISUSED;
    if (strstr(a->output, "{n}"))
        return report_error(EXIT_MISUSED,
                            "%s: {n} works only with --turntable, --over-time and --poses",
                            a->output);
    if (kind != PICTURE_CVI && (a->psnr_given || a->ratio_given))
        return report_error(EXIT_MISUSED, "--%s works only with compressed pictures, -o OUT.cvi",
                            a->psnr_given ? "psnr" : "ratio");
    if (a->psnr_given && a->ratio_given)
        return report_error(EXIT_MISUSED, "give only one of --psnr and --ratio");
    if (a->psnr_given && !(a->psnr > 0 && a->psnr <= 100))
        return report_error(EXIT_MISUSED, "--psnr is %g dB, must be above 0 and at most 100",
                            a->psnr);
    if (a->ratio_given && !(a->ratio > 1))
        return report_error(EXIT_MISUSED, "--ratio is %g, must be above 1", a->ratio);
    if (a->budget_given && a->progressive)
        return report_error(EXIT_MISUSED, "give only one of --budget-ms and --progressive");
    if (a->progressive && s->engine != CVOL_ENGINE_SHEET && s->engine != CVOL_ENGINE_TRANSFORM)
        return report_error(EXIT_MISUSED,
                            "--progressive works only with engines sheet and transform");
    return EXIT_DONE;
}

/* ---- rendering and writing ---------------------------------------------------------------------
 */

/* The background; NULL: transparent. */
static const double *picture_background(const scene *s, const render_arguments *a)
{
    return a->transparent ? NULL : s->options.background;
}

/* 1 if the picture is grey. */
static int is_grey(const scene *s)
{
    const double *b = s->options.background;
    return is_grey_mode(s->options.mode) && !s->other_count && !s->overlay_count &&
           !(b[0] < b[1] || b[1] < b[0]) && !(b[1] < b[2] || b[2] < b[1]);
}

/* 1 if grey levels have a window other than the range of the samples. */
static int has_window(const scene *s)
{
    return is_grey_mode(s->options.mode) && s->options.window[1] > s->options.window[0];
}

/* Draws scale bar, axes and colour bar over the picture. */
static int annotate(cvol_context *context, const scene *s, const render_arguments *a,
                    cvol_image *image)
{
    cvol_baked_info info = {0};
    cvol_transfer *baked = NULL;
    cvol_annotation of = {.size = sizeof(cvol_annotation),
                          .grid = scene_grid(context, s, &info),
                          .options = &s->options,
                          .mirrored = s->mirrored,
                          .transparent = a->transparent,
                          .transfer = s->transfer,
                          .rescale = {s->rescale[0], s->rescale[1]},
                          .value_unit = s->value_unit ? s->value_unit : ""};
    int code = CVOL_OK;
    if (info.transfer_count) {
        code = cvol_transfer_create(context, &baked, info.transfer_points, info.transfer_count);
        of.transfer = baked;
        of.rescale[0] = 1;
    }
    if (!code && is_grey_mode(s->options.mode))
        code = cvol_renderer_get_range(context, of.range, s->renderer);
    if (has_window(s))
        memcpy(of.range, s->options.window, sizeof of.range);
    if (s->other_count || s->labels || s->colours) { /* no colour bar */
        of.transfer = NULL;
        of.range[1] = of.range[0];
    }
    const cvol_transfer *bar = overlay_bar(of.rescale, s);
    if (bar) { /* its values matter more than those of the volume */
        of.transfer = bar;
        of.value_unit = "";
    }
    if (!code)
        code = cvol_image_annotate(context, image, &of);
    cvol_transfer_free(baked);
    return code;
}

/* Draws the picture, within the budget if there is one. */
static int draw(cvol_context *context, scene *s, const render_arguments *a, cvol_image *image)
{
    s->drawn_level = s->options.level;
    if (drawing_of_parts)
        return drawing_of_parts->draw(context, s, image);
    if (s->other_count)
        return draw_channels(context, s, image);
    if (s->overlay_count)
        return draw_overlays(context, s, image);
    if (s->numbers || s->colours)
        return draw_coloured(context, s, a->budget_given ? a->budget_ms : 0, image);
    if (!a->budget_given)
        return cvol_renderer_render(context, s->renderer, image, &s->options);
    cvol_refine_report report;
    const int code = cvol_renderer_refine(context, s->renderer, image, &s->options, a->budget_ms,
                                          NULL, NULL, &report);
    if (!code)
        s->drawn_level = report.level;
    return code;
}

/* Puts a dark grey behind the picture, from GRADIENT_TOP to GRADIENT_BOTTOM of white. Neighbouring
 * pixels are rounded differently, so no bands show (Jimenez, "Next generation post processing in
 * Call of Duty: Advanced Warfare", 2014: interleaved gradient noise). */
static void put_gradient_behind(cvol_image *image)
{
    for (int j = 0; j < image->height; j++)
        for (int i = 0; i < image->width; i++) {
            float *pixel = image->values + 4 * ((size_t)j * (size_t)image->width + (size_t)i);
            const double share = (j + 0.5) / image->height,
                         noise = 52.9829189 * fmod(0.06711056 * i + 0.00583715 * j, 1),
                         grey = GRADIENT_TOP + share * (GRADIENT_BOTTOM - GRADIENT_TOP) +
                                (fmod(noise, 1) - 0.5) / 255;
            const float behind = fmaxf(1 - pixel[3], 0);
            for (int c = 0; c < 3; c++)
                pixel[c] += behind * (float)grey;
            pixel[3] = 1;
        }
}

/* Renders to floats; annotations are drawn on floats too. */
static int render_floats(cvol_context *context, scene *s, const render_arguments *a, int floats,
                         cvol_image **out)
{
    cvol_image *values, *bytes = NULL;
    int code = cvol_image_create_float(context, &values, s->options.width, s->options.height);
    if (!code && a->depth_name)
        code = cvol_image_add_depth(context, values);
    if (!code)
        code = draw(context, s, a, values);
    if (!code && s->mirrored)
        cvol_image_mirror(values);
    if (!code && a->has_gradient && !a->opacity_name)
        put_gradient_behind(values);
    if (!code && a->annotate)
        code = annotate(context, s, a, values);
    if (!code && !floats)
        code = cvol_image_create(context, &bytes, values->width, values->height);
    if (!code && !floats)
        code = cvol_image_flatten(context, bytes, values, picture_background(s, a));
    if (code || !floats) {
        cvol_image_free(values);
        values = NULL;
    }
    if (code) {
        cvol_image_free(bytes);
        bytes = NULL;
    }
    *out = floats ? values : bytes;
    return code;
}

static int render_bytes(cvol_context *context, scene *s, const render_arguments *a,
                        cvol_image **out)
{
    int code = cvol_image_create(context, out, s->options.width, s->options.height);
    if (!code)
        code = draw(context, s, a, *out);
    if (!code && s->mirrored)
        cvol_image_mirror(*out);
    if (code) {
        cvol_image_free(*out);
        *out = NULL;
    }
    return code;
}

int take_picture(cvol_context *context, scene *s, const render_arguments *a, int floats,
                 cvol_image **out, double *render_ms)
{
    const double start = milliseconds();
    const int code = floats || drawing_of_parts || a->transparent || a->has_gradient ||
                             a->annotate || s->other_count || s->overlay_count || s->numbers ||
                             s->colours
                         ? render_floats(context, s, a, floats, out)
                         : render_bytes(context, s, a, out);
    *render_ms = milliseconds() - start;
    return code ? report_context_error(context, code, NULL) : EXIT_DONE;
}

static int save_picture(cvol_context *context, const scene *s, const render_arguments *a,
                        const cvol_image *image, const char *output)
{
    if (drawing_of_parts && drawing_of_parts->rank)
        return CVOL_OK;
    if (picture_kind_of(output) == PICTURE_PFM)
        return cvol_image_write_pfm(context, image, s->options.background, is_grey(s), output);
    if (a->bits == 16)
        return cvol_image_write_png16(context, image, picture_background(s, a), is_grey(s), output);
    switch (picture_kind_of(output)) {
    case PICTURE_JPEG:
        return cvol_image_write_jpeg(context, image, a->quality > 0 ? a->quality : 1, output);
    case PICTURE_WEBP:
        return cvol_image_write_webp(context, image, a->quality, output);
    default:
        return cvol_image_write_png(context, image, output);
    }
}

/* From floats to bytes. */
static int round_picture(cvol_context *context, const scene *s, const render_arguments *a,
                         cvol_image **image)
{
    cvol_image *bytes;
    int code = cvol_image_create(context, &bytes, (*image)->width, (*image)->height);
    if (!code)
        code = cvol_image_flatten(context, bytes, *image, picture_background(s, a));
    cvol_image_free(*image);
    *image = bytes;
    return code;
}

/* Returns 1 if every pixel is background. */
static int is_empty(const cvol_image *image, const scene *s, const render_arguments *a)
{
    for (int c = 0; c < 3 && !a->transparent; c++)
        if (fabs(image->rgba[c] - 255 * s->options.background[c]) > 1)
            return 0;
    if (a->transparent && image->rgba[3])
        return 0;
    const size_t count = 4 * (size_t)image->width * (size_t)image->height;
    for (size_t i = 4; i < count; i++)
        if (image->rgba[i] != image->rgba[i % 4])
            return 0;
    return 1;
}

/* States why a picture is empty. */
static void print_empty_note(cvol_context *context, const scene *s, const char *output)
{
    cvol_histogram h;
    double most = 0;
    if (s->options.mode != CVOL_MODE_COMPOSITE || !s->transfer || s->other_count ||
        s->overlay_count || find_histogram(context, &h, s))
        return;
    const size_t count = cvol_transfer_count(s->transfer);
    for (size_t i = 0; i < count; i++) {
        const cvol_transfer_point p = cvol_transfer_point_at(s->transfer, i);
        const int beyond = (p.value < h.min && i + 1 < count) || (p.value > h.max && i > 0);
        most = !beyond && p.opacity > most ? p.opacity : most;
    }
    uint64_t samples = 0;
    for (int i = 0; i < CVOL_HISTOGRAM_BINS; i++)
        samples += h.bins[i];
    clear_progress();
    if (!samples)
        fprintf(stderr, "cvol: %s: the picture is empty: no sample has a value\n", output);
    else if (most > 1e-3)
        fprintf(stderr,
                "cvol: %s: the picture is empty: the camera or the clip shows no visible part\n",
                output);
    else
        fprintf(stderr,
                "cvol: %s: the picture is empty: the transfer function shows none of the values %g "
                "to %g\n",
                output, h.min, h.max);
}

int write_pixels(cvol_context *context, scene *s, const render_arguments *a, const char *output,
                 outcome *result)
{
    cvol_image *image = NULL;
    const int floats = picture_kind_of(output) == PICTURE_PFM || a->bits == 16;
    int status = take_picture(context, s, a, floats || has_maps(a), &image, &result->render_ms);
    if (status)
        return status;
    if (has_maps(a))
        status = write_maps(context, a, image);
    if (!status && a->has_gradient && a->opacity_name)
        put_gradient_behind(image);
    int code = CVOL_OK;
    if (!status && !floats && has_maps(a))
        code = round_picture(context, s, a, &image);
    if (!status && !code && image->rgba && is_empty(image, s, a))
        print_empty_note(context, s, output);
    if (!status && !code)
        code = save_picture(context, s, a, image, output);
    cvol_image_free(image);
    return code ? report_context_error(context, code, NULL) : status;
}

static int write_compressed(cvol_context *context, scene *s, const render_arguments *arguments,
                            const char *output, outcome *result)
{
    cvol_picture_options options = cvol_picture_options_defaults();
    cvol_picture *picture = NULL;
    const double start = milliseconds();
    if (s->mirrored)
        return report_error(
            EXIT_MISUSED, "%s: cannot mirror a compressed picture (%s): write a PNG", output,
            arguments->mirror ? "--mirror was given" : "the volume's axes are left-handed");
    if (arguments->psnr_given)
        options.psnr_db = arguments->psnr;
    options.ratio = arguments->ratio_given ? arguments->ratio : 0;
    int code = cvol_renderer_render_compressed(context, s->renderer, &picture, &s->options,
                                               &options);
    result->render_ms = milliseconds() - start;
    result->is_compressed = 1;
    if (!code)
        code = cvol_picture_get_info(context, &result->info, picture);
    if (!code)
        code = cvol_picture_write(context, picture, output, NULL);
    cvol_picture_free(picture);
    return code ? report_context_error(context, code, NULL) : EXIT_DONE;
}

int write_picture(cvol_context *context, scene *s, const render_arguments *a, const char *output,
                  outcome *result)
{
    *result = (outcome){0};
    const int status = picture_kind_of(output) == PICTURE_CVI
                           ? write_compressed(context, s, a, output, result)
                           : write_pixels(context, s, a, output, result);
    clear_progress();
    return status;
}

void print_picture(const scene *s, const char *output, const outcome *result)
{
    printf("%s: %d x %d, ", output, s->options.width, s->options.height);
    char psnr[PSNR_TEXT];
    if (result->is_compressed)
        printf("%llu bytes, %s, ", (unsigned long long)result->info.file_bytes,
               psnr_text(psnr, result->info.psnr_db));
    printf("loaded in %.0f ms", s->load_ms);
    if (s->in.level && !s->options.level)
        printf(" (level %d, fine enough for this size)", s->in.level);
    printf(", rendered in %.0f ms", result->render_ms);
    if (s->has_kind && !s->other_count)
        printf(" (auto: %s)", cvol_kind_text(s->kind));
    putchar('\n');
}

/* ---- reporting --------------------------------------------------------------------------------
 */

/* The report of engine transform; NULL for other engines. */
static json_t *transform_json(cvol_context *context, const scene *s)
{
    cvol_transform_report report;
    if (s->engine != CVOL_ENGINE_TRANSFORM ||
        cvol_renderer_get_transform_report(context, &report, s->renderer))
        return NULL;
    json_t *error_bound = report.certified ? json_real(report.bound) : NULL;
    return json_pack("{s:[i,i], s:f, s:i, s:I, s:I, s:I, s:f, s:o?, s:f, s:f}", "lattice",
                     (int)report.lattice[0], (int)report.lattice[1], "step", report.step, "slices",
                     (int)report.slices, "coefficients", (json_int_t)report.terms, "bytes",
                     (json_int_t)report.bytes, "multiply_adds", (json_int_t)report.multiply_adds,
                     "rho", report.rho, "error_bound", error_bound, "bake_ms", report.bake_ms,
                     "compose_ms", report.compose_ms);
}

void describe_outcome(json_t *object, cvol_context *context, const scene *s, const outcome *result)
{
    json_t *transform = transform_json(context, s);
    uint64_t multiply_adds;
    json_object_set_new(object, "render_ms", json_real(result->render_ms));
    if (transform)
        json_object_set_new(object, "transform", transform);
    describe_fourier(object, context, s);
    if (s->engine == CVOL_ENGINE_SPLAT &&
        !cvol_renderer_splat_multiply_adds(context, s->renderer, &multiply_adds))
        json_object_set_new(object, "splat",
                            json_pack("{s:I}", "multiply_adds", (json_int_t)multiply_adds));
    if (result->is_compressed)
        json_object_set_new(object, "picture", describe_picture(&result->info));
}

void describe_view(json_t *object, cvol_context *context, const scene *s, const render_arguments *a)
{
    const cvol_camera *camera = &s->options.camera;
    double range[2];
    if (s->has_kind && !s->other_count)
        json_object_set_new(object, "kind", json_string(cvol_kind_text(s->kind)));
    if (s->labels)
        json_object_set_new(object, "labels", describe_labels(s->labels));
    json_object_set_new(object, "camera",
                        json_pack("{s:o, s:f, s:f, s:f, s:f, s:f, s:b}", "view",
                                  a->view_name ? json_text(a->view_name) : json_null(), "azimuth",
                                  camera->azimuth_deg, "elevation", camera->elevation_deg, "roll",
                                  camera->roll_deg, "zoom", camera->zoom, "field_of_view",
                                  camera->fov_deg, "mirrored", s->mirrored));
    if (!is_grey_mode(s->options.mode) || cvol_renderer_get_range(context, range, s->renderer))
        return;
    if (has_window(s))
        memcpy(range, s->options.window, sizeof range);
    for (int k = 0; k < 2; k++) /* as values, like --window */
        range[k] = s->rescale[0] * range[k] + s->rescale[1];
    json_object_set_new(object, "grey", json_pack("[f, f]", range[0], range[1]));
}
