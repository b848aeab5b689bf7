/* Shared by all subcommands: options, messages, progress, JSON, and opening volumes. */
#ifndef CVOL_TOOLS_CLI_H
#define CVOL_TOOLS_CLI_H

#include <jansson.h>
#include <stdio.h>

#include "cvol/cvol.h"
#include "tools/words/words.h"

/* Exit statuses. */
enum { EXIT_DONE = 0, EXIT_FAILED = 1, EXIT_MISUSED = 2 };

/* ---- options --------------------------------------------------------------------------- */

typedef enum option_kind {
    OPTION_FLAG,     /* int: set to 1 */
    OPTION_TEXT,     /* const char * */
    OPTION_TEXTS,    /* text_list: at most `least` times; `least` <= TEXTS_MAX */
    OPTION_OF_LAST,  /* texts_of: for the text before it of a list */
    OPTION_INTEGER,  /* int, at least `least` */
    OPTION_THREADS,  /* int, 1 to THREADS_MAX */
    OPTION_NUMBER,   /* double, finite */
    OPTION_POSITIVE, /* double, finite, above 0 */
    OPTION_DIMS,     /* size_t[3]: NXxNYxNZ */
    OPTION_SIZE,     /* int[2]: W or WxH */
    OPTION_NUMBERS3, /* double[3]: A,B,C */
    OPTION_SPACING,  /* double[3]: A,B,C, above 0 */
    OPTION_BOX,      /* size_t[6]: X0:X1,Y0:Y1,Z0:Z1 */
    OPTION_HEADING   /* not an option: a heading in the help */
} option_kind;

#define TEXTS_MAX 8
typedef struct text_list {
    const char *texts[TEXTS_MAX];
    int count;
} text_list;

/* One text for each text of `list`; NULL: not given. */
typedef struct texts_of {
    const text_list *list;
    const char *list_option; /* its name, for messages */
    const char *texts[TEXTS_MAX];
} texts_of;

typedef struct option_spec {
    const char *name;     /* with dashes: "--ratio", "-o" */
    const char *argument; /* as in the help: "R"; NULL for flags */
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
    int positional_count; /* number of positional arguments */
    int optional_count;   /* how many of them, at the end, are optional */
    const char *positionals[POSITIONALS_MAX];
    const char **all; /* if not NULL: receives positional_count or more (at most argc) */
    int all_count;
} command_line;

/* Reads argv[1 ..]. -1: continue; otherwise the exit status, after the help or an error message. */
int parse_command_line(command_line *line, int argc, char **argv);

/* Reads `count` finite numbers separated by commas; 1 on success. */
int parse_numbers(double *out, int count, const char *text);
/* Reads the value of an option, one word of the table. Exit status: EXIT_MISUSED after a message
 * that lists the words. */
int parse_word(int *out, const word_table *table, const char *option, const char *word);
/* Reads the sides of bricks, "B" or "X,Y,Z"; NULL: 0, 0, 0. Exit status, after a message. */
int parse_bricks(int side[3], const char *text);
/* Reads "K,S" as a cvol_keep. Exit status, after a message. */
int parse_keep(cvol_keep *keep, const char *text);

/* Prints a message on standard error, after "cvol: ", instead of the progress line; returns
 * `status`. A message states what happened, where, and what to do. */
int report_error(int status, const char *format, ...) __attribute__((format(printf, 2, 3)));
/* The same with the message of the context, after the name of the file if that is not NULL.
 * EXIT_MISUSED if the library's code is CVOL_ERROR_ARGUMENT, else EXIT_FAILED. */
int report_context_error(const cvol_context *context, int code, const char *path);

/* The edit distance of the first `length` letters of `a` from `b`, and the largest distance at
 * which a word of that length is probably a misspelling. */
enum { SPELLING_FAR = 1000 };
size_t spelling_distance(const char *a, size_t length, const char *b);
size_t spelling_near(size_t length);

/* ---- start and end of a command --------------------------------------------------- */

typedef struct common_options {
    int threads, json;
    cvol_read_options read;
    double fill;
    int fill_given;
    const char *type_name; /* of raw samples */
    int level;             /* of .cvol files */
    int accept_cut;        /* a file that ends early may be opened, at its finest complete level */
    int are_colours;       /* the samples are a component of colours: no labels */
    int no_external;
    double memory_limit; /* in 2^30 bytes; 0: that of the library */
    int choice_printed;  /* the message about the chosen volume of a series was printed */
} common_options;

#define COMMON_DEFAULTS                              \
    {                                                \
        .read = {.size = sizeof(cvol_read_options) } \
    }

#define COMMON_OPTIONS(c)                                                                      \
    {NULL, NULL, "General:", OPTION_HEADING, NULL, 0, NULL},                                   \
        {"--threads",                                                                          \
         "N",                                                                                  \
         "number of worker threads (default: all cores)",                                      \
         OPTION_THREADS,                                                                       \
         &(c).threads,                                                                         \
         1,                                                                                    \
         NULL},                                                                                \
        {"--memory-limit",                                                                     \
         "GIB",                                                                                \
         "refuse files that declare more samples than these 2^30 bytes hold (default 64)",     \
         OPTION_POSITIVE,                                                                      \
         &(c).memory_limit,                                                                    \
         0,                                                                                    \
         NULL},                                                                                \
        {"--no-external",                                                                      \
         NULL,                                                                                 \
         "open no other files that a header of NRRD or MetaImage names",                       \
         OPTION_FLAG,                                                                          \
         &(c).no_external,                                                                     \
         0,                                                                                    \
         NULL},                                                                                \
    {                                                                                          \
        "--json", NULL, "print one JSON object to standard output", OPTION_FLAG, &(c).json, 0, \
            NULL                                                                               \
    }

/* Raw samples, without a header. type_option: the name of the option for their type. */
#define SHAPE_OPTIONS(c, heading, type_option)                                                  \
    {NULL, NULL, heading, OPTION_HEADING, NULL, 0, NULL},                                       \
        {"--dims", "NXxNYxNZ", "number of samples along each axis", OPTION_DIMS, (c).read.dims, \
         0,        NULL},                                                                       \
        {type_option,                                                                           \
         "TYPE",                                                                                \
         "sample type: uint8, int8, uint16, int16, uint32, int32, float32, float64",            \
         OPTION_TEXT,                                                                           \
         &(c).type_name,                                                                        \
         0,                                                                                     \
         NULL},                                                                                 \
        {"--big-endian",                                                                        \
         NULL,                                                                                  \
         "samples are stored with the high byte first",                                         \
         OPTION_FLAG,                                                                           \
         &(c).read.big_endian,                                                                  \
         0,                                                                                     \
         NULL},                                                                                 \
    {                                                                                           \
        "--spacing", "SX,SY,SZ",                                                                \
            "distance of samples (default 1,1,1); also for TIFF, NumPy, HDF5", OPTION_SPACING,  \
            (c).read.spacing, 0, NULL                                                           \
    }

/* The volume of a .cvol series, or of another file with several volumes. */
#define PLACE_OPTIONS(c)                                                                 \
    {"--time",        "I", "time I of a series, from 0", OPTION_INTEGER,                 \
     &(c).read.index, 0,   &(c).read.has_index},                                         \
    {                                                                                    \
        "--channel", "I", "channel I of a series or of colours, from 0", OPTION_INTEGER, \
            &(c).read.channel, 0, &(c).read.has_channel                                  \
    }

/* Choices where a file or folder has several volumes. */
#define CHOICE_OPTIONS(c)                                                                         \
    {NULL, NULL, "Files with several volumes:", OPTION_HEADING, NULL, 0, NULL}, PLACE_OPTIONS(c), \
        {"--index",       "I", "the same as --time", OPTION_INTEGER,                              \
         &(c).read.index, 0,   &(c).read.has_index},                                              \
    {                                                                                             \
        "--series", "NAME", "the DICOM series with this number, UID or description", OPTION_TEXT, \
            &(c).read.series, 0, NULL                                                             \
    }

#define RAW_OPTIONS(c, heading, type)                                                    \
    SHAPE_OPTIONS(c, heading, type),                                                     \
    {                                                                                    \
        "--fill", "VALUE", "replace NaN and infinite samples with VALUE", OPTION_NUMBER, \
            &(c).fill, 0, &(c).fill_given                                                \
    }

#define INPUT_OPTIONS(c) RAW_OPTIONS(c, "Raw samples (x fastest):", "--type"), CHOICE_OPTIONS(c)

/* Makes a context: threads, progress on a terminal, cancelling by Ctrl-C. NULL, after a message,
 * without memory. */
cvol_context *begin_command(const common_options *common);
/* From now on the progress line shows this text and fraction instead of those of the library, which
 * counts each of several steps from 0 to 1. NULL: those of the library again. */
void override_progress(const char *what, double fraction);
/* 1 after Ctrl-C. */
int was_interrupted(void);
/* Clears the progress line; call it before any other output to a terminal. */
void clear_progress(void);
/* Clears the progress line and frees the context; returns `status`. */
int end_command(cvol_context *context, int status);

/* ---- volumes and files ------------------------------------------------------------------- */

/* The least PSNR, in dB, of compression to a ratio or bits per voxel without --force; and the PSNR
 * that replaces the default ratio if that gives less. */
#define LEAST_PSNR 25
#define PSNR_INSTEAD 35

/* An input volume, compressed or dense. */
typedef struct input {
    cvol_array *array;
    cvol_volume *volume;
    uint64_t file_bytes;
    int level, cut, residual_missing; /* cvol_file_report */
    int are_labels;                   /* need_array: compress without loss */
    int are_colours;                  /* common_options */
    int is_quiet;                     /* need_array: another component has printed the message */
    int has_fill;                     /* need_array: samples that are `fill` have no value */
    double fill;
} input;

/* Sets the type of raw samples from its name. Exit status. */
int read_type_name(common_options *common);
/* Opens a .cvol file or any other readable format (then applies --fill). Exit status. */
int open_input(cvol_context *context, input *in, const char *path, common_options *common);
void close_input(input *in);
/* 1 if an option for raw samples was given. */
int has_raw_options(const common_options *common);
const cvol_grid *input_grid(const input *in);
/* The bound of the root mean square error of the samples that have a value. */
double rms_bound(const cvol_array_info *info, const cvol_grid *grid);
/* Make in->volume from in->array, or in->array from in->volume, where it is missing. need_array
 * compresses to the default ratio in blocks of `block` (0: the default), and prints that. Exit
 * status. */
int need_volume(cvol_context *context, input *in);
int need_array(cvol_context *context, input *in, const char *path, int block,
               cvol_background background);

/* series.c: sets the chosen volume of a .cvol file: the first one if the options choose none;
 * prints that once. Exit status. */
int choose_volume(cvol_context *context, common_options *common, const char *path,
                  cvol_file_part *part);
/* The numbers of times and channels of a file, each 1 if an option chooses one. Exit status. */
int count_volumes(cvol_context *context, common_options *common, const char *path, int *times,
                  int *channels);
/* For commands of two inputs: copies the requested --time if the file has several times, and the
 * requested --channel if it has several channels. */
void choose_of_several(cvol_context *context, cvol_read_options *out,
                       const cvol_read_options *requested, const char *path);
/* The times and channels of a file of any format. */
typedef struct volume_labels {
    double *times;   /* [times]; NULL: the file does not give them */
    char *unit;      /* of the times */
    char **names;    /* [channels]; "": no name */
    double *colours; /* [3 channels] */
    int channels;
    int are_colours; /* the channels are red, green and blue of one colour, and alpha */
} volume_labels;
/* Reads them; times and channels: as count_volumes returns them. The caller frees *out, after a
 * failure too. Exit status. */
int find_labels(cvol_context *context, volume_labels *out, common_options *common, const char *path,
                int times, int channels);
void free_labels(volume_labels *labels);
/* Reads a colour: a name (red green blue yellow magenta cyan orange white) or #rrggbb; 1 on
 * success. */
int parse_colour(double rgb[3], const char *text, size_t length);
/* Reads `count` colours of channels separated by commas. Exit status. */
int parse_colours(double *out, int count, const char *text);
/* Refuses an output that is the input, or whose folder is not writable. Exit status. */
int check_output(const char *in, const char *out);
/* 1 if `name` ends in `ending`, in upper or lower case. */
int has_ending(const char *name, const char *ending);
uint64_t file_size(const char *path);
/* cvol_context_release_outputs, with an exit status. */
int release_outputs(cvol_context *context, int status);
/* Reads a text file; the caller frees the text; NULL after a message. */
char *read_text(const char *path);

/* file_kind.c: parse_command_line finds the kinds of the positional arguments; a command calls
 * find_kind for its other inputs. A path that names no file is no error. Exit status. */
int find_kind(const char *path);
/* Frees the table of kinds. */
void forget_kinds(void);
/* As cvol_file_kind_of and cvol_file_is_cvol, from the table. */
cvol_file_kind kind_of(const char *path);
int is_cvol(const char *path);
/* Sets *out to 1 for a .cvol file and any other file with a header, to 0 for raw samples. Exit
 * status: EXIT_FAILED, after a message, if the file cannot be read. */
int find_has_header(cvol_context *context, int *out, const char *path);

double milliseconds(void);

/* ---- JSON ---------------------------------------------------------------------------------- */

/* A number, or null if it is NaN or infinite. */
json_t *json_number(double value);
/* 1 if the PSNR is that of equal samples. */
int is_exact(double psnr_db);
/* A PSNR, or null: for equal samples ("exact" is then true) and for a range of 0. */
json_t *json_decibels(double value);
/* Writes "PSNR 43.21 dB" or "exact" to `text`, and returns it. */
enum { PSNR_TEXT = 64 };
const char *psnr_text(char text[PSNR_TEXT], double psnr_db);
/* Writes "1/30.05 of the raw samples", or "1.24 times the raw samples" for a ratio (raw bytes /
 * file bytes) below 1, to `text`, and returns it. */
enum { SHARE_TEXT = 64 };
const char *share_text(char text[SHARE_TEXT], double ratio);
/* A string; if it is not UTF-8, with '?' for bytes that are not ASCII. */
json_t *json_text(const char *text);
json_t *json_triple(const double values[3]);
json_t *json_dims(const size_t dims[3]);
/* 1 if an allocation for JSON failed: an object may lack members. */
int json_lacks_memory(void);
/* Prints the object on standard output and frees it; fails if it lacks members. Exit status. */
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
int command_measure(int argc, char **argv);
int command_evaluate(int argc, char **argv);
int command_view(int argc, char **argv);
int command_export(int argc, char **argv);

/* Print a line to stderr if two volumes lie at different places, of which both state a patient's
 * space; if their samples mean values by different slopes or intercepts. */
void note_places(const char *const paths[2], const cvol_grid *a, const cvol_grid *b);
void note_values(const char *const paths[2], const cvol_grid *a, const cvol_grid *b);

#endif
