/* What compressing one volume and many share. */
#ifndef CVOL_TOOLS_COMPRESS_H
#define CVOL_TOOLS_COMPRESS_H

#include "compress_stream.h"

/* How it is compressed: by the codec, which searches the step of DCT blocks by the size of the
 * coded file, or by truncation, for any other transform and block, or a number of terms. */
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
    cvol_effort effort;      /* what these three ask for */
    const char *transform, *keep, *attributes, *fill, *background, *bricks;
    const char *labels_name;
    int labels; /* LABELS_AUTO, ...: choose_method sets it */
    const char *output, *as, *channel_names, *channel_colours; /* NULL: not given */
    double time_step;
    int time_step_given;
    int was_compressed; /* what compress_to_array found */
    int has_yielded;    /* the usual ratio has, to PSNR_INSTEAD */
    int has_labels;     /* kept without loss without being asked for */
    int is_one_of_many; /* which are told of together */
} compress_arguments;

/* command_compress.c: one volume compressed, in memory, with its attributes; the caller frees
 * *array. Exit status. */
int compress_to_array(cvol_context *context, compress_arguments *arguments, const method *m,
                      const char *in_path, cvol_array **array, cvol_compress_report *report);
/* How many targets are asked for; a PSNR and a bound may be together. */
int count_targets(const compress_arguments *a);

/* compress_report.c: what came of one volume; has_yielded: as compress_arguments has it. */
int report_one_json(const cvol_grid *grid, const cvol_array_info *info,
                    const cvol_compress_report *report, int by_slab, int has_yielded);
void report_one_text(const char *path, const method *m, const cvol_grid *grid,
                     const cvol_compress_report *report, int has_yielded);

/* compress_least_psnr.c.
 * After a compression that returned `code`: whether it is made again, to PSNR_INSTEAD, which
 * *options then say, as the usual ratio leaves too little. */
int yields_to_psnr(compress_arguments *a, cvol_compress_options *options, int code,
                   const cvol_compress_report *report);
/* That it is made again, and why: what the library says of the usual ratio. */
void note_yielding(const compress_arguments *a, const char *path, const char *says);
/* The sentence where too little is left, as `says`; EXIT_FAILED. */
int complain_too_little(const char *path, const char *says);
/* The sentence of a compression that failed; EXIT_FAILED or EXIT_MISUSED. */
int complain_compression(cvol_context *context, int code, const char *path,
                         const cvol_compress_options *options, const cvol_compress_report *report);
/* The figures that the codec does not report itself. */
void fill_report(cvol_compress_report *report, const cvol_array *array);
/* compress_attributes.c: the attributes of the file named so, or those of a .cvol that is
 * compressed again; the caller frees *text. Exit status. */
int find_attributes(char **text, const input *in, const char *path);
/* Whether what is asked for can be done slab by slab. */
int can_be_streamed(const compress_arguments *a, const method *m);

/* Names of files, which patterns stand for. */
typedef struct volume_list {
    char **paths;
    int count;
} volume_list;

/* compress_inputs.c: what the command line names, and a->output. Exit status. */
int find_volumes(volume_list *out, const command_line *line, compress_arguments *a);
void free_volumes(volume_list *list);

/* compress_series.c: many volumes into one file; *many stays 0, and nothing is done, if there is
 * but one. Exit status. */
int compress_series(cvol_context *context, compress_arguments *a, const method *m,
                    const volume_list *inputs, int *many);

#endif
