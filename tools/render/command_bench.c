/* cvol bench render: times pictures from views around the volume. */
#define _GNU_SOURCE
#include <stdlib.h>
#include <string.h>
#include <sys/resource.h>
#include <time.h>

#include "render/counters.h"
#include "tools/render/render_options.h"

static const char description[] =
    "Renders a volume from azimuths 15 + 360 i / N, i = 0 .. N - 1, at elevation 20, and\n"
    "times each picture, after one that does not count. The time of a view is the least of\n"
    "its repetitions. min and median are over the views; `all` lists every picture in order.\n"
    "cpu_ms is the least processor time of all threads together.";

/* Processor time: the load of other programs does not affect it. */
static double processor_ms(void)
{
    struct timespec t;
    clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &t);
    return 1e3 * (double)t.tv_sec + 1e-6 * (double)t.tv_nsec;
}

static double peak_rss_mb(void)
{
    struct rusage usage;
    getrusage(RUSAGE_SELF, &usage);
    return (double)usage.ru_maxrss / 1024;
}

static int compare_values(const void *a, const void *b)
{
    double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

/* From all[repeat * views + view] to the sorted best[view]. */
static void find_best_times(double *best, const double *all, int views, int repeat)
{
    for (int v = 0; v < views; v++) {
        best[v] = all[v];
        for (int r = 1; r < repeat; r++)
            if (all[r * views + v] < best[v])
                best[v] = all[r * views + v];
    }
    qsort(best, (size_t)views, sizeof *best, compare_values);
}

static int time_views(cvol_context *context, scene *s, double *all, double *cpu_ms, int views,
                      int repeat, cvol_image *image)
{
    *cpu_ms = 1e30;
    s->options.camera.elevation_deg = 20;
    for (int i = -1; i < views * repeat; i++) {
        s->options.camera.azimuth_deg = 15 + 360.0 * (i < 0 ? 0 : i % views) / views;
        const double start = milliseconds(), worked = processor_ms();
        int code = cvol_renderer_render(context, s->renderer, image, &s->options);
        if (code)
            return report_context_error(context, code, NULL);
        const double work = processor_ms() - worked;
        if (i >= 0)
            all[i] = milliseconds() - start;
        if (i >= 0 && work < *cpu_ms)
            *cpu_ms = work;
    }
    return EXIT_DONE;
}

/* Counts them for the first view; NULL: this engine or mode cannot count. */
static json_t *count_multiply_adds(cvol_context *context, scene *s, cvol_image *image)
{
    uint64_t count;
    s->options.camera.azimuth_deg = 15;
    if (s->engine != CVOL_ENGINE_SHEET || s->options.mode != CVOL_MODE_COMPOSITE ||
        s->options.shading.on || s->options.level ||
        cvol_renderer_sheet_multiply_adds(context, s->renderer, image, &s->options, &count))
        return NULL;
    return json_integer((json_int_t)count);
}

static int report(cvol_context *context, const render_arguments *arguments, scene *s,
                  const double *all, double cpu_ms, double *best, cvol_image *image)
{
    const int views = arguments->views, repeat = arguments->repeat;
    find_best_times(best, all, views, repeat);
    double median = (best[(views - 1) / 2] + best[views / 2]) / 2;
    clear_progress();
    cvol_baked_info baked; /* it has no samples */
    const int is_baked = !s->in.array && !s->in.volume &&
                         !cvol_renderer_get_baked_info(context, &baked, s->renderer);
    size_t voxels = cvol_grid_samples(is_baked ? &baked.grid : input_grid(&s->in));
    if (!arguments->common.json) {
        printf("%s, %d x %d, %d views, %d threads: %.2f ms a picture (median; fastest view %.2f), "
               "%.3f ns a voxel; loaded in %.0f ms; peak memory %.0f MB\n",
               arguments->engine_name, s->options.width, s->options.height, views,
               cvol_context_threads(context), median, best[0], 1e6 * median / (double)voxels,
               s->load_ms, peak_rss_mb());
        return EXIT_DONE;
    }
    json_t *times = json_array();
    for (int i = 0; i < views * repeat; i++)
        json_array_append_new(times, json_real(all[i]));
    return print_json(json_pack(
        "{s:{s:f, s:f, s:o}, s:f, s:f, s:f, s:I, s:f, s:i, s:s, s:s, s:i, s:i, s:i, s:i, s:o*}",
        "frame_ms", "min", best[0], "median", median, "all", times, "cpu_ms", cpu_ms, "load_ms",
        s->load_ms, "peak_rss_mb", peak_rss_mb(), "voxels", (json_int_t)voxels, "ns_per_voxel",
        1e6 * median / (double)voxels, "file_level", s->in.level, "engine", arguments->engine_name,
        "mode", arguments->mode_name, "width", s->options.width, "height", s->options.height,
        "views", views, "threads", cvol_context_threads(context), "multiply_adds",
        count_multiply_adds(context, s, image)));
}

static int bench(cvol_context *context, render_arguments *arguments, scene *s, const char *path)
{
    const size_t frames = (size_t)arguments->views * (size_t)arguments->repeat;
    double *all = calloc(frames + (size_t)arguments->views, sizeof *all);
    double cpu_ms = 0;
    cvol_image *image = NULL;
    int status = all ? open_scene(context, s, arguments, path)
                     : report_error(EXIT_FAILED, "not enough memory for %zu times", frames);
    int code = 0;
    if (!status && (code = cvol_image_create(context, &image, s->options.width, s->options.height)))
        status = report_context_error(context, code, NULL);
    if (!status)
        status = time_views(context, s, all, &cpu_ms, arguments->views, arguments->repeat, image);
    if (!status)
        status = report(context, arguments, s, all, cpu_ms, all + frames, image);
    cvol_image_free(image);
    close_scene(s);
    free(all);
    return status;
}

int command_bench(int argc, char **argv)
{
    render_arguments a = RENDER_ARGUMENTS_DEFAULTS;
    const option_spec specs[] = {
        {"--views", "N", "number of views around the volume (default 12)", OPTION_INTEGER, &a.views,
         1, NULL},
        {"--repeat", "N", "number of pictures of each view (default 3)", OPTION_INTEGER, &a.repeat,
         1, NULL},
        {"--size", "W[xH]", "size of the picture in pixels (default 512x512)", OPTION_SIZE, a.size,
         0, NULL},
        {"--zoom", "Z", "magnification (default 1)", OPTION_NUMBER, &a.zoom, 0, NULL},
        LOOK_OPTIONS(a),
        INPUT_OPTIONS(a.common),
        COMMON_OPTIONS(a.common),
    };
    command_line line = {.usage = "cvol bench render IN [options]",
                         .description = description,
                         .options = specs,
                         .option_count = sizeof specs / sizeof *specs,
                         .positional_count = 2};
    scene s;
    memset(&s, 0, sizeof s);
    int status = parse_command_line(&line, argc, argv);
    if (status < 0)
        choose_default_engine(&a, line.positionals[1]);
    if (status >= 0 || (status = check_render_arguments(&s, &a)))
        return status;
    if (strcmp(line.positionals[0], "render"))
        return report_error(EXIT_MISUSED, "cvol bench %s is unknown: give cvol bench render IN",
                            line.positionals[0]);
    if (a.transparent)
        return report_error(EXIT_MISUSED, "--background transparent works only with cvol render");
    if (a.has_gradient)
        return report_error(EXIT_MISUSED, "--background gradient works only with cvol render");
    if (a.views > 100000 || a.repeat > 100000)
        return report_error(EXIT_MISUSED, "--views %d and --repeat %d: each must be at most 100000",
                            a.views, a.repeat);
    cvol_context *context = begin_command(&a.common);
    if (!context)
        return EXIT_FAILED;
    return end_command(context, bench(context, &a, &s, line.positionals[1]));
}
