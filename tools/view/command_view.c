/* cvol view: shows volumes in a browser. */
#define _XOPEN_SOURCE 700
#include <errno.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>
#include <unistd.h>

#include "tools/base/browser.h"
#include "tools/base/cli.h"
#include "tools/base/ffmpeg.h"
#include "tools/view/shared_pictures.h"
#include "tools/view/view_list.h"
#include "tools/view/view_overlays.h"
#include "viewer/viewer.h"

static const char description[] =
    "Shows volumes in a browser, drawn from their compressed form: turn, light, colour and\n"
    "cut them. The viewer listens on localhost only. It prints its URL, which carries a\n"
    "secret token, and opens a browser if there is a screen. A volume that is not compressed\n"
    "is compressed in memory while the page loads. A file of several times has a slider of\n"
    "time, and can be played; the channels of a file are shown together. Overlays are drawn\n"
    "over every file, on slices too. For a remote machine, give --port PORT there, run\n"
    "ssh -L 8080:localhost:PORT MACHINE, and open the URL with port 8080. Ctrl-C ends the\n"
    "viewer.";
static const char examples[] =
    "  cvol view brain.cvol\n"
    "  cvol view a.cvol b.nii.gz                 two volumes, to compare\n"
    "  cvol view atlas.nii.gz --label-table names.txt\n"
    "  cvol view mri.nii.gz --overlay pet.nii.gz --overlay-transfer hot\n"
    "  cvol view scan.nii.gz --port 8000 --no-browser\n";

typedef struct view_arguments {
    common_options common;
    const char *listen, *label_file;
    int port, no_browser, once;
    double keep_mb, times_mb;
    text_list hosts;
    overlay_options overlay;
} view_arguments;

/* Animations through ffmpeg, if it is installed. */
static void *start_movie(const char *path, int width, int height, const cvol_film_options *options,
                         char *message, size_t bytes)
{
    return open_ffmpeg(path, width, height, options, message, bytes);
}

static int add_picture(void *movie, const cvol_image *image, char *message, size_t bytes)
{
    return add_to_ffmpeg(movie, image, message, bytes);
}

static int end_movie(void *movie, char *message, size_t bytes)
{
    return commit_ffmpeg(movie, message, bytes);
}

static void discard_movie(void *movie)
{
    abandon_ffmpeg(movie);
}

static const viewer_movies movies = {has_ffmpeg, start_movie, add_picture, end_movie,
                                     discard_movie};

static int print_address(const view_arguments *a, const viewer *v)
{
    if (a->common.json) {
        const int status = print_json(json_pack("{s:s}", "address", viewer_address(v)));
        fflush(stdout);
        return status;
    }
    printf("%s\n", viewer_address(v));
    fflush(stdout);
    fputs("cvol: open this URL in a browser; Ctrl-C ends the viewer\n", stderr);
    return EXIT_DONE;
}

/* Waits until a signal or --once ends the viewer. */
static void wait_for_end(viewer *v)
{
    const struct timespec pause = {0, 200000000};
    while (!viewer_tick(v) && !was_interrupted())
        nanosleep(&pause, NULL);
}

static int check_arguments(view_arguments *a)
{
    if (a->port > 65535)
        return report_error(EXIT_MISUSED, "--port is %d, must be 0 (a free one) to 65535", a->port);
    if (!(a->keep_mb >= 0 && a->keep_mb <= 1e6))
        return report_error(EXIT_MISUSED, "--keep-mb is %g, must be 0 to 1000000", a->keep_mb);
    if (!(a->times_mb >= 0 && a->times_mb <= 1e6))
        return report_error(EXIT_MISUSED, "--times-mb is %g, must be 0 to 1000000", a->times_mb);
    for (int i = 0; i < a->hosts.count; i++)
        if (!*a->hosts.texts[i])
            return report_error(EXIT_MISUSED, "--host is empty");
    if (check_overlay_values(&a->overlay))
        return EXIT_MISUSED;
    return read_type_name(&a->common);
}

static viewer_options make_options(const view_arguments *a, const view_list *list,
                                   const view_overlays *overlays)
{
    viewer_options options = {.volumes = list->volumes,
                              .volume_count = list->count,
                              .overlays = overlays->shown,
                              .overlay_count = overlays->count,
                              .has_fill = a->common.fill_given,
                              .fill = a->common.fill,
                              .listen = a->listen,
                              .port = a->port,
                              .host_count = a->hosts.count,
                              .once = a->once,
                              .threads = a->common.threads,
                              .keep_mb = a->keep_mb,
                              .times_mb = a->times_mb,
                              .movies = &movies,
                              .draw_shared = shared_pictures};
    for (int i = 0; i < a->hosts.count; i++)
        options.hosts[i] = a->hosts.texts[i];
    return options;
}

/* Restarts the command with OMP_WAIT_POLICY=passive. Otherwise idle OpenMP threads would keep the
 * cores busy for some milliseconds each time, and the browser on the same machine needs them.
 * OpenMP reads the variable only when a program starts. */
static void restart_with_passive_threads(int argc, char **argv)
{
    if (getenv("OMP_WAIT_POLICY") || setenv("OMP_WAIT_POLICY", "passive", 1))
        return;
    char *program = realpath("/proc/self/exe", NULL);
    char **new_arguments = program ? calloc((size_t)argc + 2, sizeof *new_arguments) : NULL;
    if (!new_arguments) {
        free(program);
        return;
    }
    char name[] = "cvol", command[] = "view";
    new_arguments[0] = name;
    new_arguments[1] = command;
    for (int i = 1; i < argc; i++)
        new_arguments[i + 1] = argv[i];
    execv(program, new_arguments); /* returns only if it fails */
    free(new_arguments);
    free(program);
}

static int show(cvol_context *context, const view_arguments *a, const command_line *line)
{
    char message[512];
    viewer *v;
    view_list list;
    view_overlays overlays = {0};
    int status = list_views(context, &list, &a->common, a->label_file, line->all, line->all_count);
    if (!status)
        status = open_view_overlays(context, &overlays, &a->overlay, &list, a->common.threads);
    const viewer_options options = make_options(a, &list, &overlays);
    if (!status && viewer_open(&v, message, sizeof message, &options))
        status = report_error(EXIT_FAILED, "%s", message);
    if (status) {
        close_view_overlays(&overlays);
        free_views(&list);
        return status;
    }
    status = print_address(a, v);
    browser_page page = {"", ""};
    if (!status) {
        if (!a->no_browser && !a->common.json)
            open_browser(&page, viewer_address(v));
        wait_for_end(v);
        close_browser(&page);
    }
    viewer_close(v);
    close_view_overlays(&overlays);
    free_views(&list);
    return status;
}

int command_view(int argc, char **argv)
{
    restart_with_passive_threads(argc, argv);
    view_arguments a = {.common = COMMON_DEFAULTS, .keep_mb = 256, .times_mb = 512};
    begin_overlay_options(&a.overlay);
    const option_spec specs[] = {
        {"--label-table", "FILE",
         "names and colours of labels: a file of ITK-SNAP, FreeSurfer or 3D Slicer", OPTION_TEXT,
         &a.label_file, 0, NULL},
        {NULL, NULL, "Overlays, as in cvol render:", OPTION_HEADING, NULL, 0, NULL},
        OVERLAY_OPTIONS(a.overlay),
        {NULL, NULL, "Server:", OPTION_HEADING, NULL, 0, NULL},
        {"--port", "P", "port to listen on (default: a free one)", OPTION_INTEGER, &a.port, 0,
         NULL},
        {"--listen", "ADDRESS", "address of this machine to listen on (default 127.0.0.1)",
         OPTION_TEXT, &a.listen, 0, NULL},
        {"--host", "NAME", "accept requests to this host name too (up to 8 times)", OPTION_TEXTS,
         &a.hosts, VIEWER_HOSTS_MAX, NULL},
        {"--no-browser", NULL, "only print the URL", OPTION_FLAG, &a.no_browser, 0, NULL},
        {"--keep-mb", "MB", "size of the block caches of all volumes (default 256; 0: off)",
         OPTION_NUMBER, &a.keep_mb, 0, NULL},
        {"--times-mb", "MB",
         "memory for the times of a series that stay open (default 512; two always do)",
         OPTION_NUMBER, &a.times_mb, 0, NULL},
        {"--once", NULL, "end when the page is closed", OPTION_FLAG, &a.once, 0, NULL},
        INPUT_OPTIONS(a.common),
        COMMON_OPTIONS(a.common),
    };
    const char **paths = malloc((size_t)argc * sizeof *paths);
    if (!paths)
        return report_error(EXIT_FAILED, "not enough memory");
    command_line line = {.usage = "cvol view IN... [options]",
                         .description = description,
                         .examples = examples,
                         .options = specs,
                         .option_count = sizeof specs / sizeof *specs,
                         .positional_count = 1,
                         .all = paths};
    int status = parse_command_line(&line, argc, argv);
    if (status < 0) {
        status = check_arguments(&a);
        cvol_context *context = status ? NULL
                                       : begin_command(&a.common); /* for its signal handlers */
        if (context)
            status = end_command(context, show(context, &a, &line));
        else if (!status)
            status = EXIT_FAILED;
    }
    free(paths);
    return status;
}
