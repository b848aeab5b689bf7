/* Shared by the compression of one volume and of a series. */
#ifndef CVOL_TOOLS_COMPRESS_H
#define CVOL_TOOLS_COMPRESS_H

#include "tools/compress/compress_stream.h"

/* How to compress: by the codec (DCT blocks, search for a step), or, for other transforms, whole
 * arrays and --keep, by truncation. */
typedef struct method {
    cvol_compress_options options;
    int truncate;
    cvol_transform transform;
    int block;
    cvol_keep keep;
} method;

typedef struct compress_arguments {
    common_options common;
    double ratio, psnr, max_error, bits;
    int ratio_given, psnr_given, max_error_given, bits_given;
    int block, stream;
    int lossless, no_lap, force;
    int fast, smallest;      /* other spellings of --effort fast and --effort max */
    const char *effort_name; /* NULL: not given */
    cvol_effort effort;      /* the result of these three */
    const char *transform, *keep, *attributes, *label_file, *fill, *background, *bricks;
    const char *labels_name;
    int labels; /* LABELS_AUTO, ...: choose_method sets it */
    const char *output, *as, *channel_names, *channel_colours; /* NULL: not given */
    char *own_output; /* the output's name, if it follows from the input's; to be freed */
    double time_step;
    int time_step_given;
    int was_compressed; /* what compress_to_array found */
    int has_yielded;    /* PSNR_INSTEAD replaced the default ratio */
    int has_labels;     /* the samples are labels, so the file is lossless */
    int is_one_of_many; /* of a series: one report for all */
} compress_arguments;

/* command_compress.c: compresses one volume in memory, with its attributes; the caller frees
 * *array. Exit status. */
int compress_to_array(cvol_context *context, compress_arguments *arguments, const method *m,
                      const char *in_path, cvol_array **array, cvol_compress_report *report);

/* compress_method.c: sets *m, a->effort and a->labels by the options. EXIT_DONE, or EXIT_MISUSED
 * after a message. */
int choose_method(method *m, compress_arguments *a);
/* The number of targets that were given; --psnr with --max-error counts as one. */
int count_targets(const compress_arguments *a);
/* The option that made the file lossless. */
const char *lossless_option(const compress_arguments *a);
/* The option that prevents compression slab by slab; NULL: none. */
const char *option_against_streams(const compress_arguments *a, const method *m);
/* Refuses --stream with such an option. Exit status. */
int check_stream(const compress_arguments *a, const method *m);
/* The option that set the effort, as it was spelled; NULL: none. */
const char *effort_option(const compress_arguments *a);

/* compress_report.c: reports on one volume; has_yielded: see compress_arguments. */
int report_one_json(const cvol_grid *grid, const cvol_array_info *info,
                    const cvol_compress_report *report, int by_slab, int has_yielded);
void report_one_text(const char *path, const method *m, const cvol_grid *grid,
                     const cvol_compress_report *report, int has_yielded);

/* The wanted size over that of the file; 0: the target is no size. */
double size_wanted(const method *m, const cvol_grid *grid, const cvol_compress_report *report);

/* compress_least_psnr.c.
 * 1 if the compression that returned `code` must be repeated with PSNR_INSTEAD, since the default
 * ratio leaves too low a PSNR; then sets *options. */
int yields_to_psnr(compress_arguments *a, cvol_compress_options *options, int code,
                   const cvol_compress_report *report);
/* Prints that it is repeated, and why; `reason` is the message of the library. */
void print_yielding_note(const compress_arguments *a, const char *path, const char *reason);
/* Prints the error of too low a PSNR, after `reason`; EXIT_FAILED. */
int report_low_psnr(const char *path, const char *reason);
/* Prints the error of a failed compression; EXIT_FAILED or EXIT_MISUSED. */
int report_compression_error(cvol_context *context, int code, const char *path,
                             const cvol_compress_options *options,
                             const cvol_compress_report *report);
/* Refuses to lose labels slab by slab, if the file says that its samples are labels and no option
 * accepts loss. Samples are not read. Exit status. */
int check_slab_labels(cvol_context *context, const compress_arguments *a, const char *path,
                      cvol_type type);
/* Fills in the numbers that truncation does not report. */
void fill_report(cvol_compress_report *report, const cvol_array *array);
/* compress_attributes.c: the attributes in the file `path`, or, without one, those of a .cvol
 * input. The caller frees *text. Exit status. */
int find_attributes(char **text, const input *in, const char *path);
/* Names of input files, with patterns replaced by the files that match. */
typedef struct volume_list {
    char **paths;
    int count;
} volume_list;

/* compress_inputs.c: sets the inputs of the command line and a->output. Exit status. */
int find_volumes(volume_list *out, const command_line *line, compress_arguments *a);
void free_volumes(volume_list *list);

/* compress_series.c: compresses several volumes into one file. If there is only one, *many stays 0
 * and nothing is done. Exit status. */
int compress_series(cvol_context *context, compress_arguments *a, const method *m,
                    const volume_list *inputs, int *many);

#endif
