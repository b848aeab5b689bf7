/* Contexts with progress and Ctrl-C, inputs of any format, JSON. */
#define _GNU_SOURCE
#include <dirent.h>
#include <errno.h>
#include <fcntl.h>
#include <math.h>
#include <signal.h>
#include <stdatomic.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <time.h>
#include <unistd.h>

#include "tools/base/cli.h"
#include "tools/base/processes.h"

/* ---- progress -------------------------------------------------------------------------------- */

/* Set by the signal handler. */
static volatile sig_atomic_t interrupted;

static void on_interrupt(int signal_number)
{
    (void)signal_number;
    interrupted = 1;
}

typedef struct progress_line {
    double shown_at; /* milliseconds */
    int on_terminal, visible;
    const char *held; /* shown instead of the text of the library, or NULL */
    double fraction;
} progress_line;

static progress_line progress_state;

static int show_progress(void *user, const char *what, double fraction)
{
    progress_line *line = user;
    if (line->on_terminal && milliseconds() - line->shown_at > 100) {
        line->shown_at = milliseconds();
        line->visible = 1;
        fprintf(stderr, "\r\033[K%s %3.0f %%", line->held ? line->held : what,
                100 * (line->held ? line->fraction : fraction));
        fflush(stderr);
    }
    return interrupted;
}

void override_progress(const char *what, double fraction)
{
    progress_state.held = what;
    progress_state.fraction = fraction;
}

int was_interrupted(void)
{
    return interrupted != 0;
}

void clear_progress(void)
{
    if (progress_state.visible)
        fputs("\r\033[K", stderr);
    progress_state.visible = 0;
}

/* The reader maps files. SIGBUS arrives when a file becomes shorter or a disk fails; the handler
 * cannot know which file it was. */
static void on_lost_page(int signal_number)
{
    static const char message[] = "\r\033[Kcvol: a file became shorter, or unreadable, "
                                  "while cvol was reading it\n";
    const size_t skipped = progress_state.visible ? 0
                                                  : 4; /* the bytes that clear the progress line */
    (void)signal_number;
    (void)!write(STDERR_FILENO, message + skipped, sizeof message - 1 - skipped);
    _exit(EXIT_FAILED);
}

/* ---- JSON without memory --------------------------------------------------------------------- */

/* Functions of Jansson that add a member ignore one that could not be made. So the command counts
 * failures of its allocations, and prints no object with a part missing. */
static atomic_int json_failures;

static void *allocate_json(size_t size)
{
    void *memory = malloc(size);
    if (!memory)
        atomic_store(&json_failures, 1);
    return memory;
}

int json_lacks_memory(void)
{
    return atomic_load(&json_failures);
}

/* ---- contexts -------------------------------------------------------------------------------- */

static uint64_t limit_of(double gib)
{
    const double bytes = gib * 1073741824;
    return bytes < 0x1p63 ? (uint64_t)bytes : UINT64_MAX;
}

cvol_context *begin_command(const common_options *common)
{
    json_set_alloc_funcs(allocate_json, free);
    cvol_context *context = cvol_context_create();
    if (!context) {
        report_error(EXIT_FAILED, "not enough memory");
        return NULL;
    }
    cvol_context_set_threads(context, common->threads);
    cvol_context_set_external(context, !common->no_external);
    if (common->memory_limit > 0)
        cvol_context_set_limit_bytes(context, limit_of(common->memory_limit));
    struct sigaction action = {.sa_handler = on_interrupt}, before;
    sigaction(SIGINT, &action, NULL);
    sigaction(SIGTERM, &action, NULL);
    if (!sigaction(SIGHUP, NULL, &before) && before.sa_handler != SIG_IGN) /* as under nohup */
        sigaction(SIGHUP, &action, NULL);
    signal(SIGBUS, on_lost_page);
    signal(SIGPIPE, SIG_IGN);
    signal(SIGXFSZ, SIG_IGN); /* a file size limit is reported like any failure to write */
    progress_state.on_terminal = isatty(STDERR_FILENO);
    progress_state.shown_at = milliseconds() + 200; /* quick work shows no progress */
    cvol_context_set_progress(context, show_progress, &progress_state);
    const int code = processes ? processes->begin(context) : CVOL_OK;
    if (!code)
        return context;
    report_context_error(context, code, NULL);
    cvol_context_free(context);
    return NULL;
}

static int size_failure; /* errno of a file whose size could not be found */

int end_command(cvol_context *context, int status)
{
    clear_progress();
    if (processes)
        status = processes->end(context, status);
    cvol_context_free(context);
    forget_kinds();
    if (!status && json_lacks_memory())
        return report_error(EXIT_FAILED, "not enough memory for the whole description");
    if (!status && size_failure)
        return report_error(EXIT_FAILED, "the whole description needs the size of a file: %s",
                            strerror(size_failure));
    return status;
}

int release_outputs(cvol_context *context, int status)
{
    const int code = cvol_context_release_outputs(context, status ? CVOL_ERROR_CANCELLED : CVOL_OK);
    return !status && code ? report_context_error(context, code, NULL) : status;
}

double milliseconds(void)
{
    struct timespec t;
    clock_gettime(CLOCK_MONOTONIC, &t);
    return 1e3 * (double)t.tv_sec + 1e-6 * (double)t.tv_nsec;
}

/* ---- inputs ---------------------------------------------------------------------------------- */

/* 1 if a folder is one of Zarr, whose samples are in folders inside. */
static int is_zarr(int folder)
{
    static const char *const marks[] = {"zarr.json", ".zarray", ".zgroup", ".zattrs"};
    for (size_t i = 0; i < sizeof marks / sizeof *marks; i++)
        if (!faccessat(folder, marks[i], F_OK, 0))
            return 1;
    return 0;
}

/* The size of the files in a folder; deep: also of those in folders inside. */
static uint64_t folder_size(const char *path, int deep)
{
    uint64_t size = 0;
    DIR *folder = opendir(path);
    struct stat status;
    deep = deep || (folder && is_zarr(dirfd(folder)));
    for (const struct dirent *entry; folder && (entry = readdir(folder));) {
        const char *name = entry->d_name;
        char *inside;
        if (!fstatat(dirfd(folder), name, &status, 0) && S_ISREG(status.st_mode))
            size += (uint64_t)status.st_size;
        else if (deep && strcmp(name, ".") && strcmp(name, "..") &&
                 !fstatat(dirfd(folder), name, &status, AT_SYMLINK_NOFOLLOW) &&
                 S_ISDIR(status.st_mode) && asprintf(&inside, "%s/%s", path, name) >= 0) {
            size += folder_size(inside, deep);
            free(inside);
        }
    }
    if (folder)
        closedir(folder);
    return size;
}

uint64_t file_size(const char *path)
{
    struct stat status;
    if (stat(path, &status)) { /* FILE.h5:/a/dataset? */
        if (errno != ENOENT && errno != ENOTDIR)
            size_failure = errno;
        const char *colon = strrchr(path, ':');
        char *file = colon ? strndup(path, (size_t)(colon - path)) : NULL;
        const uint64_t size = file ? file_size(file) : 0;
        free(file);
        return size;
    }
    return S_ISDIR(status.st_mode) ? folder_size(path, 0) : (uint64_t)status.st_size;
}

int read_type_name(common_options *common)
{
    int type;
    if (!common->type_name)
        return EXIT_DONE;
    if (parse_word(&type, &type_words, "--type", common->type_name))
        return EXIT_MISUSED;
    common->read.type = (cvol_type)type;
    return EXIT_DONE;
}

static int read_dense(cvol_context *context, input *in, const char *path, common_options *common)
{
    int status = read_type_name(common);
    if (status)
        return status;
    int code = cvol_volume_read(context, &in->volume, path, &common->read);
    if (code) /* all messages but that of MEMORY name the file */
        return report_context_error(context, code, code == CVOL_ERROR_MEMORY ? path : NULL);
    if (common->fill_given)
        code = cvol_volume_fill(context, in->volume, common->fill);
    return code ? report_context_error(context, code, path) : EXIT_DONE;
}

int has_raw_options(const common_options *common)
{
    const cvol_read_options *read = &common->read;
    return read->dims[0] || common->type_name || read->big_endian || read->spacing[0] != 0 ||
           read->spacing[1] != 0 || read->spacing[2] != 0;
}

int open_input(cvol_context *context, input *in, const char *path, common_options *common)
{
    memset(in, 0, sizeof *in);
    in->are_colours = common->are_colours;
    if (is_cvol(path)) {
        if (has_raw_options(common))
            return report_error(EXIT_MISUSED,
                                "%s: is a .cvol file, which has a header: --dims, --type and "
                                "--big-endian are for raw samples, --spacing also for formats "
                                "without it",
                                path);
        cvol_file_part part = {
            .size = sizeof(cvol_file_part), .level = common->level, .cut = common->accept_cut};
        cvol_file_report report;
        const int status = choose_volume(context, common, path, &part);
        if (status)
            return status;
        int code = read_array(context, &in->array, &report, path, &part);
        if (code)
            return report_context_error(context, code, NULL);
        in->file_bytes = report.file_bytes;
        in->level = report.level;
        in->cut = report.cut;
        in->residual_missing = report.residual_missing;
        return EXIT_DONE;
    }
    if (processes && !access(path, R_OK))
        return report_error(
            EXIT_FAILED, "%s: several processes compute on .cvol files: compress it first", path);
    in->file_bytes = file_size(path);
    return read_dense(context, in, path, common);
}

void close_input(input *in)
{
    cvol_array_free(in->array);
    cvol_volume_free(in->volume);
    memset(in, 0, sizeof *in);
}

const cvol_grid *input_grid(const input *in)
{
    return in->array ? cvol_array_grid(in->array) : &in->volume->grid;
}

double rms_bound(const cvol_array_info *info, const cvol_grid *grid)
{
    const double samples = (double)(cvol_grid_samples(grid) - info->missing_samples);
    return samples > 0 ? info->l2_error / sqrt(samples) : 0;
}

int need_volume(cvol_context *context, input *in)
{
    if (in->volume)
        return EXIT_DONE;
    const cvol_grid *grid = cvol_array_grid(in->array);
    const size_t begin[3] = {0, 0, 0};
    int code = cvol_volume_create(context, &in->volume, grid);
    if (!code)
        code = cvol_array_evaluate_box(context, in->volume->data, in->array, begin, grid->dims);
    return code ? report_context_error(context, code, NULL) : EXIT_DONE;
}

int need_array(cvol_context *context, input *in, const char *path, int block,
               cvol_background background)
{
    if (in->array)
        return EXIT_DONE;
    cvol_compress_options options = cvol_compress_options_defaults();
    cvol_compress_report report;
    if (block)
        options.block = block;
    options.background = background;
    /* The result is a picture, for which the user waits. */
    if (background == CVOL_BACKGROUND_FIND)
        options.effort = CVOL_EFFORT_FAST;
    options.has_fill = in->has_fill;
    options.fill = in->fill;
    options.least_psnr = LEAST_PSNR;
    options.lossless = in->are_labels;
    int code = CVOL_OK;
    if (!in->are_labels && !in->has_fill && !in->are_colours)
        code = cvol_volume_compute_is_labels(context, &options.lossless, in->volume, path);
    if (code)
        return report_context_error(context, code, code == CVOL_ERROR_MEMORY ? path : NULL);
    code = cvol_compress(context, &in->array, &report, in->volume->data, &in->volume->grid,
                         &options);
    if (code == CVOL_ERROR_TARGET) {
        options.target = CVOL_TARGET_PSNR;
        options.target_value = PSNR_INSTEAD;
        code = cvol_compress(context, &in->array, &report, in->volume->data, &in->volume->grid,
                             &options);
    }
    if (code)
        return report_context_error(context, code, path);
    if (in->are_labels || in->is_quiet) /* a file of labels may well be compressed */
        return EXIT_DONE;
    char share[SHARE_TEXT];
    clear_progress();
    fprintf(stderr,
            "cvol: %s: was compressed in memory first, at %s; run cvol compress once to avoid "
            "this\n",
            path, share_text(share, report.ratio));
    return EXIT_DONE;
}

/* Checks before the work that the folder of `path` accepts new files. */
static int check_folder_of(const char *path)
{
    const char *slash = strrchr(path, '/');
    int length = slash ? (int)(slash + 1 - path) : 0;
    size_t bytes = (size_t)length + 2;
    char *folder = malloc(bytes);
    if (!folder)
        return report_error(EXIT_FAILED, "not enough memory");
    snprintf(folder, bytes, "%.*s.", length, path); /* "FOLDER/.", or "." */
    int refused = access(folder, W_OK | X_OK), reason = errno;
    free(folder);
    if (!refused)
        return EXIT_DONE;
    return report_error(EXIT_FAILED, "%s: cannot be written: %s", path, strerror(reason));
}

int check_output(const char *in, const char *out)
{
    struct stat a, b;
    if (stat(out, &b))
        return check_folder_of(out);
    if (stat(in, &a) || a.st_dev != b.st_dev || a.st_ino != b.st_ino)
        return EXIT_DONE;
    return report_error(EXIT_FAILED, "%s: input and output are the same file", out);
}

int has_ending(const char *name, const char *ending)
{
    size_t length = strlen(name), tail = strlen(ending);
    return length > tail && !strcasecmp(name + length - tail, ending);
}

/* ---- JSON -------------------------------------------------------------------------------------
 */

json_t *json_number(double value)
{
    return isfinite(value) ? json_real(value) : json_null();
}

int is_exact(double psnr_db)
{
    return isinf(psnr_db) && psnr_db > 0;
}

json_t *json_decibels(double value)
{
    return json_number(value);
}

const char *share_text(char text[SHARE_TEXT], double ratio)
{
    snprintf(text, SHARE_TEXT,
             ratio < 1 ? "%.3g times the raw samples" : "1/%.2f of the raw samples",
             ratio < 1 ? 1 / ratio : ratio);
    return text;
}

const char *psnr_text(char text[PSNR_TEXT], double psnr_db)
{
    if (is_exact(psnr_db))
        snprintf(text, PSNR_TEXT, "exact");
    else
        snprintf(text, PSNR_TEXT, "PSNR %.2f dB", psnr_db);
    return text;
}

json_t *json_text(const char *text)
{
    json_t *string = json_string(text);
    if (string)
        return string;
    char *ascii = strdup(text);
    for (char *c = ascii; c && *c; c++)
        if ((unsigned char)*c > '~')
            *c = '?';
    string = ascii ? json_string(ascii) : NULL;
    free(ascii);
    return string;
}

json_t *json_triple(const double values[3])
{
    return json_pack("[f, f, f]", values[0], values[1], values[2]);
}

json_t *json_dims(const size_t dims[3])
{
    return json_pack("[I, I, I]", (json_int_t)dims[0], (json_int_t)dims[1], (json_int_t)dims[2]);
}

int print_json(json_t *object)
{
    char *text = object && !json_lacks_memory()
                     ? json_dumps(object, JSON_INDENT(1) | JSON_REAL_PRECISION(15))
                     : NULL;
    json_decref(object);
    if (!text || json_lacks_memory()) {
        free(text);
        return report_error(EXIT_FAILED, "not enough memory for the JSON output");
    }
    clear_progress();
    puts(text);
    free(text);
    return EXIT_DONE;
}
