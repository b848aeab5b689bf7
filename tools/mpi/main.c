/* cvol-mpi: cvol render and cvol compress by several processes, which mpirun starts.
 *
 * All processes run the command with the same arguments. Process 0 alone prints and writes; the
 * messages of the others go to a file without a name. A process that fails before the common work
 * takes part in the agreement with which that work begins (cvol_mpi_agree), so no other process
 * waits for it, and process 0 prints its message. */
#define _POSIX_C_SOURCE 200809L
#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "base/context.h"
#include "cvol/mpi.h"
#include "tools/base/cli.h"
#include "tools/compress/compress_stream.h"
#include "tools/mpi/frames.h"
#include "tools/render/render_parts.h"

#define MESSAGE 1000

static int has_agreed; /* this process has reached the common work */
static FILE *messages; /* of a process other than 0 */

/* ---- pictures ---------------------------------------------------------------------------- */

/* Samples of a level around a part that its pictures need: for gradients, and wide filters. */
#define MARGIN 10

/* Reads the samples of this process's part. A code of the library. */
static int read_box(cvol_context *context, cvol_array **out, const scene *s, const cvol_part *part)
{
    const cvol_grid *grid = input_grid(&s->in);
    common_options common = *s->common;
    size_t begin[3], end[3];
    cvol_file_part box = {
        .size = sizeof box, .begin = begin, .end = end, .level = s->box_level, .with_ranges = 1};
    for (int a = 0; a < 3; a++) {
        const double margin = MARGIN << s->box_level, last = (double)grid->dims[a];
        begin[a] = (size_t)fmax(floor(part->from[a] - margin), 0);
        end[a] = (size_t)fmin(ceil(part->to[a] + margin) + 1, last);
    }
    if (choose_volume(context, &common, s->path, &box))
        return cvol_fail(context, CVOL_ERROR_IO, "%s: cannot be read again", s->path);
    return cvol_array_read_part(context, out, NULL, s->path, &box);
}

/* What the pictures of a film share: the boxes, and this process's own. */
static struct shared {
    const scene *of; /* NULL: nothing */
    cvol_mpi_parts *parts;
    cvol_array *array;       /* NULL: the scene's */
    cvol_renderer *renderer; /* of the array */
} shared;

static void free_shared(void)
{
    cvol_renderer_free(shared.renderer);
    cvol_array_free(shared.array);
    cvol_mpi_parts_free(shared.parts);
    shared = (struct shared){.of = NULL};
}

/* Opens this process's box of the file. A code of the library, which all processes have. */
static int open_box(cvol_context *context, const scene *s)
{
    int rank;
    MPI_Comm_rank(MPI_COMM_WORLD, &rank);
    const cvol_part part = cvol_mpi_part(shared.parts, rank);
    int code = read_box(context, &shared.array, s, &part);
    if (!code)
        code = cvol_renderer_create(context, &shared.renderer, s->engine,
                                    CVOL_SOURCE(.array = shared.array, .whole = s->in.array));
    if (!code && s->transfer)
        code = cvol_renderer_set_transfer(context, shared.renderer, s->transfer);
    return cvol_mpi_agree(context, code, &rank, MPI_COMM_WORLD);
}

/* Finds the boxes of a scene. A code of the library, which all processes have. */
static int open_parts(cvol_context *context, const scene *s)
{
    int rank;
    if (s->other_count)
        return cvol_mpi_agree(context,
                              cvol_fail(context, CVOL_ERROR_UNSUPPORTED,
                                        "cvol-mpi draws one channel: choose it with --channel"),
                              &rank, MPI_COMM_WORLD);
    free_shared();
    int code = cvol_mpi_parts_create(context, &shared.parts, s->in.array, s->transfer, &s->options,
                                     MPI_COMM_WORLD);
    if (!code && s->box_level >= 0)
        code = open_box(context, s);
    shared.of = code ? NULL : s;
    return code;
}

/* *read_s: the longest time of a process since it began to open the file. */
static int time_parts(cvol_context *context, double *read_s, const scene *s)
{
    const double start = MPI_Wtime();
    const int code = open_parts(context, s);
    *read_s = MPI_Wtime() - start + 1e-3 * s->load_ms;
    if (!code) /* then all processes are here */
        MPI_Allreduce(MPI_IN_PLACE, read_s, 1, MPI_DOUBLE, MPI_MAX, MPI_COMM_WORLD);
    return code;
}

/* Labels take their colours from the depths of the whole picture: process 0 draws it alone. */
static int draw_labels_alone(cvol_context *context, const scene *s, cvol_image *image)
{
    int rank, code = CVOL_OK;
    MPI_Comm_rank(MPI_COMM_WORLD, &rank);
    if (!rank)
        code = draw_labels(context, s->renderer, image, &s->options, s->numbers, s->labels);
    return cvol_mpi_agree(context, code, &rank, MPI_COMM_WORLD);
}

static int draw_parts(cvol_context *context, const scene *s, cvol_image *image)
{
    has_agreed = 1;
    if (s->numbers)
        return draw_labels_alone(context, s, image);
    cvol_mpi_render_report report;
    double read_s = 0;
    int code = shared.of == s ? CVOL_OK : time_parts(context, &read_s, s);
    if (!code)
        code = cvol_mpi_render(context, &report, shared.parts,
                               shared.renderer ? shared.renderer : s->renderer, image, &s->options);
    if (!code)
        note_frame(&report, read_s);
    return code;
}

static int agree(cvol_context *context, int status)
{
    int rank;
    has_agreed = 1;
    const int failed = status ? cvol_fail(context, CVOL_ERROR_IO, "failed") : CVOL_OK,
              code = cvol_mpi_agree(context, failed, &rank, MPI_COMM_WORLD);
    return status || !code ? status : report_context_error(context, code, NULL);
}

/* ---- files ------------------------------------------------------------------------------- */

static int compress_by_all(cvol_context *context, cvol_compress_report *report, const char *path,
                           const cvol_sample_source *source, const cvol_grid *grid,
                           const cvol_compress_options *options)
{
    has_agreed = 1;
    return cvol_mpi_compress_stream(context, report, path, source, grid, options, MPI_COMM_WORLD);
}

/* ---- processes --------------------------------------------------------------------------- */

/* Only process 0 writes to the terminal. */
static int silence(void)
{
    messages = tmpfile();
    return messages && freopen("/dev/null", "w", stdout) && dup2(fileno(messages), 2) >= 0;
}

/* The last message of this process, without the name of the program. */
static void find_message(char text[MESSAGE])
{
    char line[MESSAGE];
    strcpy(text, "failed");
    fflush(stderr);
    if (!messages)
        return;
    rewind(messages);
    while (fgets(line, sizeof line, messages)) {
        line[strcspn(line, "\n")] = '\0';
        strcpy(text, strncmp(line, "cvol: ", 6) ? line : line + 6);
    }
}

/* Tells the other processes that this one failed before the common work. */
static void report_early_failure(void)
{
    cvol_context *context = cvol_context_create();
    char text[MESSAGE];
    int first;
    if (!context)
        MPI_Abort(MPI_COMM_WORLD, EXIT_FAILED);
    find_message(text);
    const int code = cvol_fail(context, CVOL_ERROR_IO, "%s", text);
    cvol_mpi_agree(context, code, &first, MPI_COMM_WORLD);
    cvol_context_free(context);
}

/* The number of threads of each process on this computer. */
static int find_threads(void)
{
    MPI_Comm here;
    int processes;
    const long cores = sysconf(_SC_NPROCESSORS_ONLN);
    MPI_Comm_split_type(MPI_COMM_WORLD, MPI_COMM_TYPE_SHARED, 0, MPI_INFO_NULL, &here);
    MPI_Comm_size(here, &processes);
    MPI_Comm_free(&here);
    return cores > processes ? (int)(cores / processes) : 1;
}

/* A command that several processes run. */
typedef struct shared_command {
    const char *name;
    char *title;
    int (*run)(int argc, char **argv);
    char *option; /* added, or NULL */
} shared_command;

static int has_option(int argc, char **argv, const char *option)
{
    for (int i = 2; i < argc; i++)
        if (!strncmp(argv[i], option, strlen(option)))
            return 1;
    return 0;
}

/* Runs the command with --threads, and its own option, if the arguments do not have them. Exit
 * status. */
static int run_command(const shared_command *command, int argc, char **argv)
{
    static char threads[] = "--threads";
    char number[16];
    char **words = calloc((size_t)argc + 4, sizeof *words);
    int count = 0;
    if (!words)
        return report_error(EXIT_FAILED, "not enough memory");
    snprintf(number, sizeof number, "%d", find_threads());
    words[count++] = command->title;
    for (int i = 2; i < argc; i++)
        words[count++] = argv[i];
    if (!has_option(argc, argv, threads)) {
        words[count++] = threads;
        words[count++] = number;
    }
    if (command->option && !has_option(argc, argv, command->option))
        words[count++] = command->option;
    const int status = command->run(count, words);
    free(words);
    return status;
}

static int run(int argc, char **argv)
{
    static char render[] = "cvol-mpi render", compress[] = "cvol-mpi compress",
                stream[] = "--stream";
    static const shared_command commands[] = {{"render", render, command_render, NULL},
                                              {"compress", compress, command_compress, stream}};
    if (argc < 2 || !strcmp(argv[1], "--help") || !strcmp(argv[1], "-h")) {
        puts("usage: mpirun -n N cvol-mpi render IN -o OUT.png [options]\n"
             "       mpirun -n N cvol-mpi compress IN OUT.cvol [options]\n\n"
             "render draws a picture by N processes: each draws a part of the volume, process 0\n"
             "puts the parts together and writes the picture. Options: those of cvol render for\n"
             "pictures and turntables by engine sheet; see cvol render --help.\n\n"
             "compress encodes a volume by N processes: each reads and encodes layers of 64\n"
             "slices, process 0 writes the file, which has the same bytes as that of\n"
             "cvol compress --stream. Options: those of cvol compress that work with --stream.\n\n"
             "--threads is for each process (default: the cores of the computer divided by its\n"
             "processes).");
        return EXIT_DONE;
    }
    for (size_t i = 0; i < sizeof commands / sizeof *commands; i++)
        if (!strcmp(argv[1], commands[i].name))
            return run_command(&commands[i], argc, argv);
    return report_error(EXIT_MISUSED,
                        "cvol-mpi has the commands render and compress, not '%s': use cvol for "
                        "others",
                        argv[1]);
}

int main(int argc, char **argv)
{
    part_drawing drawing = {
        .level = cvol_mpi_level, .draw = draw_parts, .agree = agree, .describe = take_frames};
    int worst;
    if (MPI_Init(&argc, &argv))
        return EXIT_FAILED;
    MPI_Comm_rank(MPI_COMM_WORLD, &drawing.rank);
    if (drawing.rank && !silence())
        MPI_Abort(MPI_COMM_WORLD, EXIT_FAILED);
    drawing_of_parts = &drawing;
    compressor_of_streams = compress_by_all;
    int status = run(argc, argv);
    free_shared();
    json_decref(take_frames());
    if (status && !has_agreed)
        report_early_failure();
    if (!drawing.rank && fflush(stdout))
        status = report_error(EXIT_FAILED, "cannot write to standard output");
    MPI_Allreduce(&status, &worst, 1, MPI_INT, MPI_MAX, MPI_COMM_WORLD);
    MPI_Finalize();
    return drawing.rank ? EXIT_DONE : worst;
}
