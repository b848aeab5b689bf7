/* cvol-mpi: cvol render by several processes, which mpirun starts.
 *
 * All processes run the command with the same arguments. Process 0 alone prints and writes; the
 * messages of the others go to a file without a name. A process that fails before the first picture
 * takes part in the agreement with which that picture begins (cvol_mpi_parts_create), so no other
 * process waits for it, and process 0 prints its message. */
#define _POSIX_C_SOURCE 200809L
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "base/context.h"
#include "cli.h"
#include "cvol/mpi.h"
#include "render_parts.h"

#define MESSAGE 1000

static int has_agreed; /* this process has reached a picture */
static FILE *messages; /* of a process other than 0 */

/* ---- pictures ---------------------------------------------------------------------------- */

static int draw_parts(cvol_context *context, const scene *s, cvol_image *image)
{
    cvol_mpi_parts *parts = NULL;
    has_agreed = 1;
    if (s->other_count) { /* the same in all processes */
        int rank;
        const int refused = cvol_fail(context, CVOL_ERROR_UNSUPPORTED,
                                      "cvol-mpi draws one channel: choose it with --channel");
        return cvol_mpi_agree(context, refused, &rank, MPI_COMM_WORLD);
    }
    int code = cvol_mpi_parts_create(context, &parts, s->in.array, s->transfer, &s->options,
                                     MPI_COMM_WORLD);
    if (!code)
        code = cvol_mpi_render(context, parts, s->renderer, image, &s->options);
    cvol_mpi_parts_free(parts);
    return code;
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

/* Tells the other processes that this one failed before its first picture. */
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

/* cvol-mpi render ARGUMENTS; with --threads, if they do not have it. Exit status. */
static int run_render(int argc, char **argv)
{
    static char name[] = "cvol-mpi render", option[] = "--threads";
    char number[16];
    char **words = calloc((size_t)argc + 3, sizeof *words);
    int count = 0, has_threads = 0;
    if (!words)
        return report_error(EXIT_FAILED, "not enough memory");
    snprintf(number, sizeof number, "%d", find_threads());
    words[count++] = name;
    for (int i = 2; i < argc; i++) {
        has_threads |= !strncmp(argv[i], option, strlen(option));
        words[count++] = argv[i];
    }
    if (!has_threads) {
        words[count++] = option;
        words[count++] = number;
    }
    const int status = command_render(count, words);
    free(words);
    return status;
}

static int run(int argc, char **argv)
{
    if (argc < 2 || !strcmp(argv[1], "--help") || !strcmp(argv[1], "-h")) {
        puts(
            "usage: mpirun -n N cvol-mpi render IN -o OUT.png [options]\n\n"
            "Draws a picture by N processes: each draws a part of the volume, process 0 puts the\n"
            "parts together and writes the picture. Options: those of cvol render for one picture\n"
            "by engine sheet; see cvol render --help. --threads is for each process (default: the\n"
            "cores of the computer divided by its processes).");
        return EXIT_DONE;
    }
    if (strcmp(argv[1], "render"))
        return report_error(EXIT_MISUSED,
                            "cvol-mpi has the command render only, not '%s': use cvol for others",
                            argv[1]);
    return run_render(argc, argv);
}

int main(int argc, char **argv)
{
    part_drawing drawing = {.draw = draw_parts};
    int worst;
    if (MPI_Init(&argc, &argv))
        return EXIT_FAILED;
    MPI_Comm_rank(MPI_COMM_WORLD, &drawing.rank);
    if (drawing.rank && !silence())
        MPI_Abort(MPI_COMM_WORLD, EXIT_FAILED);
    drawing_of_parts = &drawing;
    int status = run(argc, argv);
    if (status && !has_agreed)
        report_early_failure();
    if (!drawing.rank && fflush(stdout))
        status = report_error(EXIT_FAILED, "cannot write to standard output");
    MPI_Allreduce(&status, &worst, 1, MPI_INT, MPI_MAX, MPI_COMM_WORLD);
    MPI_Finalize();
    return drawing.rank ? EXIT_DONE : worst;
}
