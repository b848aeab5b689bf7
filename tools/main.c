/* cvol: the command. Each subcommand is one file, command_NAME.c. */
#include <string.h>
#include <unistd.h>

#include "tools/base/cli.h"

typedef struct subcommand {
    const char *name;
    int (*run)(int argc, char **argv);
    const char *summary;
} subcommand;

static const subcommand subcommands[] = {
    {"compress", command_compress, "compress a volume into a .cvol file"},
    {"decompress", command_decompress, "decode a .cvol file into a volume"},
    {"transcode", command_transcode, "make a .cvol file smaller and coarser"},
    {"info", command_info, "describe a volume or a .cvol file"},
    {"verify", command_verify, "check .cvol files for damage"},
    {"compare", command_compare, "compare two volumes or two pictures"},
    {"add", command_add, "add two volumes, with weights"},
    {"multiply", command_multiply, "multiply two volumes, sample by sample"},
    {"convolve", command_convolve, "convolve a volume with a small filter"},
    {"scale", command_scale, "multiply a volume by a number and add another"},
    {"gradient", command_gradient, "compute the gradient length of a volume"},
    {"stats", command_stats, "compute sums, means and distances from coefficients"},
    {"measure", command_measure, "measure the volume above a value, with a proven error"},
    {"evaluate", command_evaluate, "evaluate a volume between its samples"},
    {"render", command_render, "draw a picture or an animation of a volume"},
    {"view", command_view, "show volumes in a browser: turn, colour and cut them"},
    {"export", command_export, "write volumes and their viewer to one HTML file"},
    {"bake", command_bake, "prepare a volume for many pictures by engine transform"},
    {"bench", command_bench, "measure rendering times"},
};

static void print_help(void)
{
    puts("usage: cvol COMMAND ...\n\n"
         "Compresses volume data; renders and computes without decompressing it.\n\nCommands:");
    for (size_t i = 0; i < sizeof subcommands / sizeof *subcommands; i++)
        printf("  %-12s %s\n", subcommands[i].name, subcommands[i].summary);
    puts("\nRun cvol COMMAND --help for the options of a command. A first picture of a scan:\n\n"
         "  cvol render brain.nii.gz -o brain.png\n\ncvol FILE is the same as cvol view FILE.");
}

/* Runs the subcommand `called` with the arguments after it. */
static int run_subcommand(const char *called, int argc, char **argv)
{
    for (size_t i = 0; i < sizeof subcommands / sizeof *subcommands; i++)
        if (!strcmp(called, subcommands[i].name)) {
            char name[32];
            snprintf(name, sizeof name, "cvol %s", subcommands[i].name);
            argv[0] = name;
            return subcommands[i].run(argc, argv);
        }
    if (strpbrk(called, "./"))
        return report_error(EXIT_MISUSED, "%s: is no file, and no command; see cvol --help",
                            called);
    const char *meant = NULL;
    for (size_t i = 0; i < sizeof subcommands / sizeof *subcommands; i++)
        if (spelling_distance(called, strlen(called), subcommands[i].name) <=
            spelling_near(strlen(called)))
            meant = subcommands[i].name;
    return report_error(EXIT_MISUSED, "unknown command '%s'%s%s%s; see cvol --help", called,
                        meant ? " (did you mean " : "", meant ? meant : "", meant ? "?)" : "");
}

static int is_subcommand(const char *name)
{
    for (size_t i = 0; i < sizeof subcommands / sizeof *subcommands; i++)
        if (!strcmp(name, subcommands[i].name))
            return 1;
    return 0;
}

static int run(int argc, char **argv)
{
    static char view[] = "view";
    if (argc < 2)
        return report_error(EXIT_MISUSED, "no command given; see cvol --help");
    if (argc == 3 && !strcmp(argv[1], "help")) { /* cvol help COMMAND */
        char help[] = "--help", *words[] = {NULL, help, NULL};
        return run_subcommand(argv[2], 2, words);
    }
    if (!strcmp(argv[1], "--help") || !strcmp(argv[1], "-h") || !strcmp(argv[1], "help")) {
        print_help();
        return EXIT_DONE;
    }
    if (argc == 2 && !strcmp(argv[1], "--version")) {
        printf("cvol %s\n", cvol_version());
        return EXIT_DONE;
    }
    if (!is_subcommand(argv[1]) && argv[1][0] != '-' && !access(argv[1], F_OK)) {
        argv[0] = view; /* cvol FILE... */
        return run_subcommand(view, argc, argv);
    }
    return run_subcommand(argv[1], argc - 1, argv + 1);
}

/* Fails if standard output did not accept everything. */
int main(int argc, char **argv)
{
    int status = run(argc, argv);
    int lost = fflush(stdout) || ferror(stdout);
    if (lost && status == EXIT_DONE)
        return report_error(EXIT_FAILED, "cannot write to standard output");
    return status;
}
