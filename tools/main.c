/* cvol: the command. Each subcommand is one file, command_NAME.c. */
#include <string.h>

#include "cli.h"

typedef struct subcommand {
    const char *name;
    int (*run)(int argc, char **argv);
    const char *summary;
} subcommand;

static const subcommand subcommands[] = {
    {"compress", command_compress, "a volume into a .cvol file"},
    {"decompress", command_decompress, "a .cvol file back into a volume"},
    {"transcode", command_transcode, "a .cvol file made smaller, and coarser"},
    {"info", command_info, "what a volume or a .cvol file is"},
    {"verify", command_verify, "whether .cvol files are whole"},
    {"compare", command_compare, "how far two volumes or two pictures are apart"},
    {"add", command_add, "a weighted sum of two volumes"},
    {"multiply", command_multiply, "a product of two volumes, sample by sample"},
    {"convolve", command_convolve, "a volume through a small filter"},
    {"scale", command_scale, "a volume times a number, plus another"},
    {"gradient", command_gradient, "the length of a volume's gradient"},
    {"stats", command_stats, "sums, means and distances, from coefficients"},
    {"render", command_render, "a picture of a volume"},
    {"view", command_view, "volumes in a browser, to be turned, coloured and cut"},
    {"bake", command_bake, "slices of a volume, classified and transformed, for many pictures"},
    {"bench", command_bench, "how long pictures take"},
};

static void print_help(void)
{
    puts("usage: cvol COMMAND ...\n\n"
         "Volume data that stays compressed while you look at it and compute on it.\n\nCommands:");
    for (size_t i = 0; i < sizeof subcommands / sizeof *subcommands; i++)
        printf("  %-12s %s\n", subcommands[i].name, subcommands[i].summary);
    puts("\ncvol COMMAND --help tells more. A first picture of a scan:\n\n"
         "  cvol render brain.nii.gz -o brain.png");
}

/* Runs subcommand `name` with the words behind it. */
static int run_subcommand(const char *called, int argc, char **argv)
{
    for (size_t i = 0; i < sizeof subcommands / sizeof *subcommands; i++)
        if (!strcmp(called, subcommands[i].name)) {
            char name[32];
            snprintf(name, sizeof name, "cvol %s", subcommands[i].name);
            argv[0] = name;
            return subcommands[i].run(argc, argv);
        }
    const char *meant = NULL;
    for (size_t i = 0; i < sizeof subcommands / sizeof *subcommands; i++)
        if (spelling_distance(called, strlen(called), subcommands[i].name) <=
            spelling_near(strlen(called)))
            meant = subcommands[i].name;
    return complain(EXIT_MISUSED, "there is no command '%s'%s%s; see cvol --help", called,
                    meant ? ", is it " : "", meant ? meant : "");
}

static int run(int argc, char **argv)
{
    if (argc < 2)
        return complain(EXIT_MISUSED, "which command? See cvol --help");
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
    return run_subcommand(argv[1], argc - 1, argv + 1);
}

/* What was promised on standard output must have arrived there. */
int main(int argc, char **argv)
{
    int status = run(argc, argv);
    int lost = fflush(stdout) || ferror(stdout);
    if (lost && status == EXIT_DONE)
        return complain(EXIT_FAILED, "standard output cannot be written");
    return status;
}
