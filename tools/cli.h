/* What all subcommands share: options, messages, progress, JSON, and opening volumes. */
#ifndef CVOL_TOOLS_CLI_H
#define CVOL_TOOLS_CLI_H

#include <jansson.h>
#include <stdio.h>

#include "cvol/cvol.h"

/* Exit statuses. */
enum { EXIT_DONE = 0, EXIT_FAILED = 1, EXIT_MISUSED = 2 };

/* ---- options --------------------------------------------------------------------------- */

typedef enum option_kind {
    OPTION_FLAG,     /* int: set to 1 */
    OPTION_TEXT,     /* const char * */
    OPTION_TEXTS,    /* text_list: may be given `least` times, which is at most TEXTS_MAX */
    OPTION_INTEGER,  /* int, at least `least` */
    OPTION_THREADS,  /* int, 1 to THREADS_MAX */
    OPTION_NUMBER,   /* double, finite */
    OPTION_DIMS,     /* size_t[3]: NXxNYxNZ */
    OPTION_SIZE,     /* int[2]: W or WxH */
    OPTION_NUMBERS3, /* double[3]: A,B,C */
    OPTION_BOX,      /* size_t[6]: X0:X1,Y0:Y1,Z0:Z1 */
    OPTION_HEADING   /* no option: a line of the help */
} option_kind;

#define TEXTS_MAX 8
typedef struct text_list {
    const char *texts[TEXTS_MAX];
    int count;
} text_list;

typedef struct option_spec {
    const char *name;     /* with its dashes: "--ratio", "-o" */
    const char *argument; /* as the help shows it: "R"; NULL for flags */
    const char *help;
    option_kind kind;
    void *value;
    int least;
    int *given; /* set to 1 when the option occurs; may be NULL */
} option_spec;

#define POSITIONALS_MAX 8
#define THREADS_MAX 1024

typedef struct command_line {
    const char *usage;       /* "cvol compress IN OUT.cvol [options]" */
    const char *description; /* a few sentences */
    const char *examples;    /* may be NULL */
    const option_spec *options;
    size_t option_count;
    int positional_count; /* this many, */
    int optional_count;   /* of which the last ones may be left out */
    const char *positionals[POSITIONALS_MAX];
    const char **all; /* if not NULL: positional_count or more, which are put here (argc at most) */
    int all_count;
} command_line;

/* Reads argv[1 ..]. -1: go on; otherwise the exit status (help was printed, or one sentence about
 * what is wrong). */
int parse_command_line(command_line *line, int argc, char **argv);

/* `count` finite numbers between commas; 1 if that is what the text is. */
int parse_numbers(double *out, int count, const char *text);
/* "B" or "X,Y,Z" as the sides of bricks; NULL: 0, 0, 0. Exit status, after a sentence. */
int parse_bricks(int side[3], const char *text);
/* "K,S" as a cvol_keep. Exit status, after a sentence. */
int parse_keep(cvol_keep *keep, const char *text);

/* One sentence on standard error, after "cvol: ", in the place of the progress line; returns
 * `status`. */
int complain(int status, const char *format, ...) __attribute__((format(printf, 2, 3)));
/* The same with the context's message and, if it is not NULL, the file that it is about.
 * EXIT_MISUSED if the library's code is CVOL_ERROR_ARGUMENT, else EXIT_FAILED. */
int complain_context(const cvol_context *context, int code, const char *path);

/* How many letters were mistaken if `length` letters of `a` were meant to be `b`, and with how many
 * that is likely. */
enum { SPELLING_FAR = 1000 };
size_t spelling_distance(const char *a, size_t length, const char *b);
size_t spelling_near(size_t length);

/* ---- every command's own start and end --------------------------------------------------- */

typedef struct common_options {
    int threads, json;
    cvol_read_options read;
    double fill;
    int fill_given;
    const char *type_name; /* of raw samples */
    int level;             /* of .cvol files */
    int accept_cut;  /* whether one that ends early may be opened, at the finest whole level */
    int choice_said; /* it was said which volume of many was taken */
} common_options;

#define COMMON_OPTIONS(c)                                                                       \
    {NULL, NULL, "Everywhere:", OPTION_HEADING, NULL, 0, NULL},                                 \
        {"--threads", "N", "worker threads (default: all cores)", OPTION_THREADS, &(c).threads, \
         1,           NULL},                                                                    \
    {                                                                                           \
        "--json", NULL, "print one JSON object on standard output", OPTION_FLAG, &(c).json, 0,  \
            NULL                                                                                \
    }

/* Samples without a header; type_option is what their type is called. */
#define SHAPE_OPTIONS(c, heading, type_option)                                                     \
    {NULL, NULL, heading, OPTION_HEADING, NULL, 0, NULL},                                          \
        {"--dims", "NXxNYxNZ", "number of samples along each axis", OPTION_DIMS, (c).read.dims,    \
         0,        NULL},                                                                          \
        {type_option, "TYPE",         "uint8 int8 uint16 int16 uint32 int32 float32 float64",      \
         OPTION_TEXT, &(c).type_name, 0,                                                           \
         NULL},                                                                                    \
        {"--big-endian",                                                                           \
         NULL,                                                                                     \
         "samples are stored high byte first",                                                     \
         OPTION_FLAG,                                                                              \
         &(c).read.big_endian,                                                                     \
         0,                                                                                        \
         NULL},                                                                                    \
    {                                                                                              \
        "--spacing", "SX,SY,SZ", "distance of samples (default 1,1,1); also of TIFF, NumPy, HDF5", \
            OPTION_NUMBERS3, (c).read.spacing, 0, NULL                                             \
    }

/* Which volume of a .cvol of many, or of other files of several. */
#define PLACE_OPTIONS(c)                                                             \
    {"--time",                                                                       \
     "I",                                                                            \
     "time I, from 0: volume I of a series or array of them",                        \
     OPTION_INTEGER,                                                                 \
     &(c).read.index,                                                                \
     0,                                                                              \
     &(c).read.has_index},                                                           \
    {                                                                                \
        "--channel", "I", "channel I, from 0", OPTION_INTEGER, &(c).read.channel, 0, \
            &(c).read.has_channel                                                    \
    }

/* Which of what a file or folder has several of. */
#define CHOICE_OPTIONS(c)                                                               \
    {NULL, NULL, "Files with more than one volume:", OPTION_HEADING, NULL, 0, NULL},    \
        PLACE_OPTIONS(c), {"--index",       "I", "the same as --time", OPTION_INTEGER,  \
                           &(c).read.index, 0,   &(c).read.has_index},                  \
    {                                                                                   \
        "--series", "NAME", "DICOM series, by number, UID or description", OPTION_TEXT, \
            &(c).read.series, 0, NULL                                                   \
    }

#define RAW_OPTIONS(c, heading, type)                                                             \
    SHAPE_OPTIONS(c, heading, type),                                                              \
    {                                                                                             \
        "--fill", "VALUE", "replace NaN and infinite samples by VALUE", OPTION_NUMBER, &(c).fill, \
            0, &(c).fill_given                                                                    \
    }

#define INPUT_OPTIONS(c) RAW_OPTIONS(c, "Raw samples (x fastest):", "--type"), CHOICE_OPTIONS(c)

/* A context with the threads, progress on a terminal, and cancelling by Ctrl-C; NULL (after a
 * sentence) without memory. */
cvol_context *begin_command(const common_options *common);
/* What the progress line says from now on, in spite of the library, which counts each of many steps
 * from 0 to 1; NULL: what the library says. */
void hold_progress(const char *what, double fraction);
/* Whether Ctrl-C was pressed. */
int was_interrupted(void);
/* Clears the progress line: before anything else is written on a terminal. */
void clear_progress(void);
/* Clears the progress line and frees the context; returns `status`. */
int end_command(cvol_context *context, int status);

/* ---- volumes and files ------------------------------------------------------------------- */

/* What a volume keeps, in dB, unless --force says that a ratio or bits a voxel go before it; and
 * the PSNR that it is compressed to where nothing was asked for and the usual ratio would leave
 * less. */
#define LEAST_PSNR 25
#define PSNR_INSTEAD 35

/* A volume as the user gave it: compressed or dense. */
typedef struct input {
    cvol_array *array;
    cvol_volume *volume;
    uint64_t file_bytes;
    int level, cut, residual_missing; /* cvol_file_report */
    int has_fill;                     /* need_array: samples that are `fill` have no value */
    double fill;
} input;

/* Takes raw samples' type from its name. Exit status. */
int read_type_name(common_options *common);
/* Opens a .cvol or any format that a reader knows (then with --fill applied). Exit status. */
int open_input(cvol_context *context, input *in, const char *path, common_options *common);
void close_input(input *in);
/* Whether an option was given that only raw samples can have. */
int has_raw_options(const common_options *common);
const cvol_grid *input_grid(const input *in);
/* Makes in->volume from in->array, or in->array (at the default ratio, and says so; in blocks of
 * `block`, 0: the default) from in->volume, where it is missing. Exit status. */
int need_volume(cvol_context *context, input *in);
int need_array(cvol_context *context, input *in, const char *path, int block,
               cvol_background background);

/* series.c: which volume of a .cvol file is meant; where there are several and none was asked for,
 * the first, which is said once. Exit status. */
int choose_volume(cvol_context *context, common_options *common, const char *path,
                  cvol_file_part *part);
/* How many times and channels a file of any kind has that the options leave open. Exit status. */
int count_volumes(cvol_context *context, common_options *common, const char *path, int *times,
                  int *channels);
/* What a file of any kind says of its times and channels. */
typedef struct volume_labels {
    double *times;   /* [times]; NULL: it does not say it */
    char *unit;      /* of these */
    char **names;    /* [channels], "" where there is none */
    double *colours; /* [3 channels] */
    int channels;
    int are_colours; /* the channels are red, green and blue of one colour, and alpha */
} volume_labels;
/* Of a file that has as many of both as count_volumes says; the caller frees it, after a failure
 * too. Exit status. */
int find_labels(cvol_context *context, volume_labels *out, common_options *common, const char *path,
                int times, int channels);
void free_labels(volume_labels *labels);
/* Colours of channels, between commas; as many as there are. Exit status. */
int parse_colours(double *out, int count, const char *text);
/* Refuses an output that is the input, or whose folder takes no files. Exit status. */
int check_output(const char *in, const char *out);
/* Whether `name` ends in `ending`, whatever the case. */
int has_ending(const char *name, const char *ending);
uint64_t file_size(const char *path);

double milliseconds(void);

/* ---- JSON ---------------------------------------------------------------------------------- */

/* A number, or null where it is none that JSON can hold. */
json_t *json_number(double value);
/* Whether a PSNR is that of equal things. */
int is_exact(double psnr_db);
/* A PSNR, or null where there is none: of equal things, beside which "exact" is true, and of a
 * range of zero. */
json_t *json_decibels(double value);
/* "PSNR 43.21 dB", or "exact"; `text` has room for it. */
enum { PSNR_TEXT = 64 };
const char *psnr_text(char text[PSNR_TEXT], double psnr_db);
/* A text, or what is left of it as ASCII where it is not UTF-8. */
json_t *json_text(const char *text);
json_t *json_triple(const double values[3]);
json_t *json_dims(const size_t dims[3]);
/* Prints the object on standard output and frees it. Exit status. */
int print_json(json_t *object);

/* ---- the subcommands ------------------------------------------------------------------------ */

int command_compress(int argc, char **argv);
int command_decompress(int argc, char **argv);
int command_transcode(int argc, char **argv);
int command_info(int argc, char **argv);
int command_verify(int argc, char **argv);
int command_compare(int argc, char **argv);
int command_render(int argc, char **argv);
int command_bench(int argc, char **argv);
int command_bake(int argc, char **argv);
int command_add(int argc, char **argv);
int command_multiply(int argc, char **argv);
int command_convolve(int argc, char **argv);
int command_scale(int argc, char **argv);
int command_gradient(int argc, char **argv);
int command_stats(int argc, char **argv);
int command_view(int argc, char **argv);

#endif
