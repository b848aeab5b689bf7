/* cvol-mpi: commands of cvol by several processes, which mpirun starts.
 *
 * All processes run the command with the same arguments. Process 0 alone prints and writes; the
 * messages of the others go to a file without a name. A process that fails before the common work
 * takes part in the agreement with which that work begins (cvol_mpi_agree), so no other process
 * waits for it, and process 0 prints its message. */
#define _POSIX_C_SOURCE 200809L
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "cvol/mpi.h"
#include "tools/base/cli.h"
#include "tools/mpi/frames.h"
#include "tools/mpi/messages.h"
#include "tools/mpi/work.h"

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
    int (*run)(int argc, char **argv);
    void (*divide)(void); /* or NULL: `run` does it */
    char *option;         /* added, or NULL */
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
    char number[16], title[32];
    char **words = calloc((size_t)argc + 4, sizeof *words);
    int count = 0;
    if (!words)
        return report_error(EXIT_FAILED, "not enough memory");
    snprintf(number, sizeof number, "%d", find_threads());
    snprintf(title, sizeof title, "cvol-mpi %s", command->name);
    words[count++] = title;
    for (int i = 2; i < argc; i++)
        words[count++] = argv[i];
    if (!has_option(argc, argv, threads)) {
        words[count++] = threads;
        words[count++] = number;
    }
    if (command->option && !has_option(argc, argv, command->option))
        words[count++] = command->option;
    if (command->divide)
        command->divide();
    const int status = command->run(count, words);
    free(words);
    return status;
}

static char stream[] = "--stream";
static const shared_command commands[] = {
    {"render", command_render, divide_drawing, NULL},
    {"compress", command_compress, divide_compression, stream},
    {"verify", command_verify, divide_computing, NULL},
    {"stats", command_stats, divide_computing, NULL},
    {"add", command_add, divide_computing, NULL},
    {"multiply", command_multiply, divide_computing, NULL},
    {"transcode", command_transcode, divide_computing, NULL},
    {"view", view_together, NULL, NULL},
    {"convolve", command_convolve, divide_whole_operands, NULL},
    {"gradient", command_gradient, divide_whole_operands, NULL},
};
enum { COMMANDS = sizeof commands / sizeof *commands };

static const char help[] =
    "usage: mpirun -n N cvol-mpi render IN -o OUT.png [options]\n"
    "       mpirun -n N cvol-mpi compress IN OUT.cvol [options]\n"
    "       mpirun -n N cvol-mpi verify FILE.cvol... [options]\n"
    "       mpirun -n N cvol-mpi stats A.cvol [B.cvol] [options]\n"
    "       mpirun -n N cvol-mpi add|multiply A.cvol B.cvol -o OUT.cvol [options]\n"
    "       mpirun -n N cvol-mpi convolve|gradient A.cvol -o OUT.cvol [options]\n"
    "       mpirun -n N cvol-mpi transcode IN.cvol OUT.cvol [options]\n"
    "       mpirun -n N cvol-mpi view IN.cvol... [options]\n\n"
    "render draws a picture by N processes: each draws a part of the volume, process 0\n"
    "puts the parts together and writes the picture. Options: those of cvol render for\n"
    "pictures and turntables by engine sheet; see cvol render --help.\n\n"
    "compress encodes a volume by N processes: each reads and encodes layers of 64\n"
    "slices, process 0 writes the file, which has the same bytes as that of\n"
    "cvol compress --stream. Options: those of cvol compress that work with --stream.\n\n"
    "The other commands compute on .cvol files of volumes in dct blocks: each process\n"
    "on its layers of 64 slices. They print what the same commands of cvol print, and\n"
    "process 0 writes the same file. Options: those of these commands, but for --keep,\n"
    "--rms, --background, and convolve --kernel FILE.cvol, which need one process.\n\n"
    "view shows volumes in a browser: process 0 serves the page and answers all requests,\n"
    "all N processes draw the pictures of .cvol files. Options: those of cvol view.\n\n"
    "--threads is for each process (default: the cores of the computer divided by its\n"
    "processes).";

static int run(int argc, char **argv)
{
    char names[200] = "";
    if (argc < 2 || !strcmp(argv[1], "--help") || !strcmp(argv[1], "-h")) {
        puts(help);
        return EXIT_DONE;
    }
    for (int i = 0; i < COMMANDS; i++) {
        if (!strcmp(argv[1], commands[i].name))
            return run_command(&commands[i], argc, argv);
        snprintf(names + strlen(names), sizeof names - strlen(names), "%s%s",
                 i == 0              ? ""
                 : i == COMMANDS - 1 ? " and "
                                     : ", ",
                 commands[i].name);
    }
    return report_error(EXIT_MISUSED, "cvol-mpi has the commands %s, not '%s': use cvol for others",
                        names, argv[1]);
}

int main(int argc, char **argv)
{
    int rank, level, worst;
    if (MPI_Init_thread(&argc, &argv, MPI_THREAD_SERIALIZED, &level))
        return EXIT_FAILED;
    MPI_Comm_rank(MPI_COMM_WORLD, &rank);
    if (rank && !silence())
        MPI_Abort(MPI_COMM_WORLD, EXIT_FAILED);
    int status = run(argc, argv);
    free_drawing();
    json_decref(take_frames());
    if (status)
        report_early_failure();
    if (!rank && fflush(stdout))
        status = report_error(EXIT_FAILED, "cannot write to standard output");
    MPI_Allreduce(&status, &worst, 1, MPI_INT, MPI_MAX, MPI_COMM_WORLD);
    MPI_Finalize();
    return rank ? EXIT_DONE : worst;
}
