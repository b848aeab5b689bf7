/* --poses: a stack with one slice for each pose, written in batches. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "tools/render/poses.h"
#include "tools/render/render_projections.h"

/* The width of a pixel in the world. */
static double pixel_of(const cvol_grid *grid, const cvol_render_options *options)
{
    double square = 0, mean = 0;
    for (int a = 0; a < 3; a++) {
        const double extent = (double)(grid->dims[a] - 1) * grid->spacing[a];
        square += extent * extent;
        mean += grid->spacing[a] / 3;
    }
    return (square > 0 ? sqrt(square) : mean) / options->camera.zoom / options->height;
}

/* The slices are pictures; spacing is the width of a pixel; rows run downwards. */
static cvol_grid stack_grid(const scene *s, size_t poses)
{
    const cvol_grid *of = input_grid(&s->in);
    cvol_grid grid = cvol_grid_make((size_t)s->options.width, (size_t)s->options.height, poses,
                                    CVOL_FLOAT32);
    grid.spacing[0] = grid.spacing[1] = pixel_of(of, &s->options);
    snprintf(grid.unit, sizeof grid.unit, "%s", of->unit);
    return grid;
}

/* Slices in a batch: enough for all threads, and at most this memory unless one slice needs more.
 */
#define BATCH_BYTES ((size_t)64 << 20)
#define BATCH_MAX ((size_t)256)

static size_t least(size_t a, size_t b)
{
    return a < b ? a : b;
}

static void rotations_of(double (*out)[4], const pose_list *list, size_t first, size_t count)
{
    for (size_t i = 0; i < count; i++) {
        const double *numbers = list->poses[first + i].numbers;
        const cvol_camera camera = {.azimuth_deg = numbers[0],
                                    .elevation_deg = numbers[1],
                                    .roll_deg = numbers[2],
                                    .zoom = 1};
        if (list->numbers == 4)
            memcpy(out[i], numbers, sizeof out[i]);
        else
            cvol_camera_get_rotation(out[i], &camera);
    }
}

static int write_stack(cvol_context *context, scene *s, const render_arguments *a,
                       const pose_list *list)
{
    const cvol_grid grid = stack_grid(s, list->count);
    const size_t pixels = grid.dims[0] * grid.dims[1];
    const size_t fit = BATCH_BYTES / (pixels * sizeof(float));
    const size_t batch = least(list->count, least(fit ? fit : 1, BATCH_MAX));
    double rotations[BATCH_MAX][4];
    projection_writer writer;
    float *slices = malloc(batch * pixels * sizeof *slices);
    if (!slices)
        return report_error(EXIT_FAILED, "not enough memory for %zu pictures of %zu pixels", batch,
                            pixels);
    int code = open_projections(context, &writer, a, s, &grid);
    for (size_t first = 0; first < list->count && !code; first += batch) {
        const size_t count = least(batch, list->count - first);
        rotations_of(rotations, list, first, count);
        override_progress("projecting", (double)first / (double)list->count);
        code = cvol_renderer_project(context, s->renderer, slices, &s->options,
                                     (const double(*)[4])rotations, count);
        if (!code)
            code = write_projections(context, &writer, slices, count);
    }
    override_progress(NULL, 0);
    code = close_projections(context, &writer, code);
    free(slices);
    if (writer.lacks_memory)
        return report_error(EXIT_FAILED, "not enough memory");
    return code ? report_context_error(context, code, NULL) : EXIT_DONE;
}

static int print_figures(cvol_context *context, const scene *s, const render_arguments *a,
                         size_t count, double render_ms)
{
    if (!a->common.json) {
        printf("%s: %zu projections of %d x %d, loaded in %.0f ms, %.2f ms each\n", a->output,
               count, s->options.width, s->options.height, s->load_ms, render_ms / (double)count);
        return EXIT_DONE;
    }
    json_t *object = json_pack(
        "{s:o, s:I, s:i, s:i, s:f, s:s, s:s, s:b, s:f, s:f, s:i}", "output", json_text(a->output),
        "poses", (json_int_t)count, "width", s->options.width, "height", s->options.height, "pixel",
        pixel_of(input_grid(&s->in), &s->options), "engine", a->engine_name, "mode", a->mode_name,
        "integrals", a->integrals, "load_ms", s->load_ms, "render_ms", render_ms, "threads",
        cvol_context_threads(context));
    if (object)
        describe_fourier(object, context, s);
    return print_json(object);
}

void describe_fourier(json_t *object, cvol_context *context, const scene *s)
{
    cvol_fourier_report report;
    if (s->engine == CVOL_ENGINE_FOURIER &&
        !cvol_renderer_get_fourier_report(context, &report, s->renderer))
        json_object_set_new(object, "fourier",
                            json_pack("{s:o, s:I, s:I, s:f}", "padded", json_dims(report.padded),
                                      "coefficients", (json_int_t)report.places, "bytes",
                                      (json_int_t)report.bytes, "build_ms", report.build_ms));
}

int check_poses(const render_arguments *a)
{
    if (!a->output)
        return report_error(EXIT_MISUSED, "no output: give -o STACK.nrrd or -o 'NAME-{n}.png'");
    if (has_ending(a->output, ".cvi") || has_ending(a->output, ".pfm") ||
        (has_ending(a->output, ".png") && !is_numbered(a->output)))
        return report_error(
            EXIT_MISUSED,
            "%s: --poses writes a volume (.nrrd, .mha, .nii or .raw) or numbered pictures "
            "(-o 'NAME-{n}.png')",
            a->output);
    if (is_numbered(a->output) && a->integrals && !a->window_text)
        return report_error(
            EXIT_MISUSED, "%s: pictures of integrals need a window: give --window C,W", a->output);
    if (!is_numbered(a->output) && (a->window_text || a->bits == 16))
        return report_error(EXIT_MISUSED, "--%s works only with pictures: give -o 'NAME-{n}.png'",
                            a->window_text ? "window" : "bits");
    if (a->psnr_given || a->ratio_given || a->progressive)
        return report_error(EXIT_MISUSED, "--%s cannot be combined with --poses",
                            a->psnr_given    ? "psnr"
                            : a->ratio_given ? "ratio"
                                             : "progressive");
    return EXIT_DONE;
}

int render_poses(cvol_context *context, render_arguments *a, scene *s, const char *path)
{
    pose_list list = {0};
    int status = check_output(path, a->output);
    if (!status)
        status = check_output(a->poses, a->output);
    if (!status)
        status = read_poses(&list, a->poses);
    if (!status)
        status = open_scene(context, s, a, path);
    const double start = milliseconds();
    if (!status)
        status = write_stack(context, s, a, &list);
    const double render_ms = milliseconds() - start;
    clear_progress();
    if (!status)
        status = print_figures(context, s, a, list.count, render_ms);
    free_poses(&list);
    close_scene(s);
    return status;
}
