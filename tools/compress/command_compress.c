/* cvol compress: a dense volume into a .cvol file. */
#define _GNU_SOURCE
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "tools/base/picture.h"
#include "tools/compress/compress.h"
#include "tools/labels/labels.h"

static const char description[] =
    "Compresses a volume. By default it transforms blocks by the DCT and quantizes the\n"
    "coefficients with one step, for which it searches until the target holds. With\n"
    "--transform dht or dft, with --block 0 and with --keep it drops the smallest\n"
    "coefficients instead. It decodes the result and prints the measured error. The file\n"
    "keeps geometry and sample type.\n"
    "\n"
    "Several volumes of the same shape (given with -o, or in a 4-D file, or as channels) become\n"
    "one series; commands that read it choose a volume by --time and --channel. Each volume\n"
    "keeps the target, and the list of volumes adds some bytes. Inputs in alphabetical order\n"
    "are sorted by number: run_2 before run_10.\n"
    "\n"
    "A PNG becomes a compressed picture, OUT.cvi, by --ratio (raw pixel bytes / file bytes) or\n"
    "--psnr.";

static const char examples[] =
    "  cvol compress brain.nii.gz brain.cvol                   1/30 of the raw bytes\n"
    "  cvol compress ct.mha ct.cvol --psnr 60                  at least 60 dB\n"
    "  cvol compress ct.mha ct.cvol --bpv 0.5                  half a bit per voxel\n"
    "  cvol compress field.raw f.cvol --dims 128x128x64 --type float32 --max-error 0.01\n"
    "  cvol compress ct.mha ct.cvol --lossless                 without loss\n"
    "  cvol compress ocean.nrrd o.cvol --fill 1e35 --psnr 60   1e35 marks land\n"
    "  cvol compress wave.nrrd w.cvol --transform dft --block 0 --keep 16,1000\n"
    "  cvol compress 'run_*.nrrd' -o run.cvol --time-step 2.5  a time series\n"
    "  cvol compress cell.ome.zarr cell.cvol                   all times and channels of OME-Zarr\n"
    "  cvol compress dapi.tif gfp.tif -o cell.cvol --as channels --channel-names DAPI,GFP\n"
    "  cvol compress ct.mha ct.cvol --psnr 60 --bricks 48,48,16\n"
    "                                                          small bricks: faster slices, and\n"
    "                                                          0.5 to 1 % more bytes\n"
    "  cvol compress brain.png brain.cvi --psnr 40             a picture\n";

/* ---- compressing ---------------------------------------------------------------------------- */

/* Axes beyond the rank have one sample. Volumes in DCT blocks have rank 3, whatever their shape. */
static int rank_of(const cvol_grid *grid, const method *m)
{
    if (m->transform == CVOL_DCT && m->block)
        return 3;
    return grid->dims[2] > 1 ? 3 : grid->dims[1] > 1 ? 2 : 1;
}

static int truncate_to(cvol_context *context, cvol_array **array, const cvol_volume *volume,
                       const method *m)
{
    const cvol_grid *grid = &volume->grid;
    int code = cvol_array_compress(context, array, volume->data, grid, rank_of(grid, m),
                                   m->transform, m->block, &m->keep);
    return code ? code : cvol_array_measure(context, *array, volume->data);
}

void fill_report(cvol_compress_report *report, const cvol_array *array)
{
    cvol_array_info info;
    cvol_array_get_info(&info, array);
    report->ratio = (double)cvol_grid_bytes(cvol_array_grid(array)) / (double)report->file_bytes;
    report->psnr_db = info.psnr_db;
    report->max_error = info.max_error;
    report->lossless = info.max_error <= 0;
    report->target_met = 1;
}

/* Compresses by truncation. The least PSNR does not apply to --keep. */
static int truncate_samples(cvol_context *context, compress_arguments *a, const method *m,
                            const char *path, const cvol_volume *volume, cvol_array **array)
{
    method own = *m;
    cvol_compress_report report = {0};
    char reason[160] = "";
    int code = truncate_to(context, array, volume, m);
    if (!code)
        fill_report(&report, *array);
    if (code == CVOL_ERROR_TARGET && !count_targets(a) &&
        !a->force) /* few samples: even an array without terms is too large */
        snprintf(reason, sizeof reason, "%s", cvol_context_message(context));
    else if (!code && !a->keep && !a->psnr_given && report.psnr_db < m->options.least_psnr)
        snprintf(reason, sizeof reason, "ratio %g leaves a PSNR of %.2f dB, less than %d dB",
                 a->ratio, report.psnr_db, LEAST_PSNR);
    if (code && !*reason)
        return report_context_error(context, code, path);
    if (!*reason)
        return EXIT_DONE;
    if (!yields_to_psnr(a, &own.options, CVOL_ERROR_TARGET, &report))
        return report_low_psnr(path, reason);
    print_yielding_note(a, path, reason);
    cvol_array_free(*array);
    *array = NULL;
    own.keep = cvol_keep_psnr(PSNR_INSTEAD);
    code = truncate_to(context, array, volume, &own);
    return code ? report_context_error(context, code, path) : EXIT_DONE;
}

/* Compresses by the codec. */
static int compress_samples(cvol_context *context, compress_arguments *a, const method *m,
                            const char *path, const cvol_volume *volume, cvol_array **array,
                            cvol_compress_report *report)
{
    cvol_compress_options options = m->options;
    int code = cvol_compress(context, array, report, volume->data, &volume->grid, &options);
    if (code && yields_to_psnr(a, &options, code, report)) {
        print_yielding_note(a, path, cvol_context_message(context));
        code = cvol_compress(context, array, report, volume->data, &volume->grid, &options);
    }
    return code ? report_compression_error(context, code, path, &options, report) : EXIT_DONE;
}

/* Treats samples of a value far from all others, such as 1e35, as missing, as cvol render does,
 * unless --fill says what is missing. They would take most of the bits and leave noise elsewhere;
 * the PSNR, over the wide range, would not show it. Exact files keep them to the bit, and pictures
 * of these files leave them out. Where fills are not possible: warns, if loss is possible. Exit
 * status. */
static int choose_marks(cvol_context *context, const compress_arguments *a, method *m,
                        const cvol_volume *volume, const char *path)
{
    cvol_histogram histogram;
    int are_labels = 0;
    if (a->fill)
        return EXIT_DONE;
    int code = a->labels != LABELS_NO
                   ? cvol_volume_compute_is_labels(context, &are_labels, volume, path)
                   : CVOL_OK;
    if (!code && !are_labels)
        code = cvol_volume_compute_histogram(context, &histogram, volume);
    if (code)
        return report_context_error(context, code, code == CVOL_ERROR_MEMORY ? path : NULL);
    if (are_labels || !histogram.mark_count)
        return EXIT_DONE;
    const int has_fills = !m->truncate && m->options.background != CVOL_BACKGROUND_VALUE;
    if (has_fills) {
        m->options.has_fill = 1;
        m->options.fill = histogram.mark;
    }
    if (!has_fills && m->options.lossless)
        return EXIT_DONE;
    clear_progress();
    fprintf(stderr,
            has_fills ? "cvol: %s: samples of %g, far from all others, are treated as missing; "
                        "give --fill nan if they are values\n"
                      : "cvol: %s: some samples are %g, far from all others; give --fill %g if "
                        "they mark missing values, or they degrade the others\n",
            path, histogram.mark, histogram.mark);
    return EXIT_DONE;
}

/* Makes *m lossless if the samples are labels, unless a target or --labels was given. Drops options
 * that only lossy files have. Exit status. */
static int keep_labels_lossless(cvol_context *context, compress_arguments *a, method *m,
                                const cvol_volume *volume, const char *path)
{
    int are_labels;
    if (a->labels == LABELS_NO || m->truncate || count_targets(a))
        return EXIT_DONE;
    const int code = cvol_volume_compute_is_labels(context, &are_labels, volume, path);
    if (code)
        return report_context_error(context, code, code == CVOL_ERROR_MEMORY ? path : NULL);
    if (!are_labels)
        return EXIT_DONE;
    a->has_labels = 1;
    m->options.lossless = 1;
    if (m->options.effort == CVOL_EFFORT_MAX)
        m->options.effort = CVOL_EFFORT_DEFAULT;
    if (m->options.background == CVOL_BACKGROUND_VALUE)
        m->options.background = CVOL_BACKGROUND_NONE;
    if (!a->common.json && !a->is_one_of_many) {
        clear_progress();
        fprintf(
            stderr,
            "cvol: %s: samples are labels: compressed without loss; give --labels no or a target, "
            "as in --ratio 30, for lossy compression\n",
            path);
    }
    return EXIT_DONE;
}

int compress_to_array(cvol_context *context, compress_arguments *arguments, const method *m,
                      const char *in_path, cvol_array **array, cvol_compress_report *report)
{
    input in;
    char *attributes = NULL;
    *array = NULL;
    int status = open_input(context, &in, in_path, &arguments->common);
    if (!status)
        status = find_attributes(&attributes, &in, arguments->attributes);
    if (!status)
        status = add_label_attributes(&attributes, arguments->label_file, in_path);
    arguments->was_compressed = !status && in.array;
    if (arguments->was_compressed)
        status = need_volume(context, &in);
    method own = *m;
    own.options.attributes = attributes;
    if (!status && !arguments->was_compressed) {
        status = keep_labels_lossless(context, arguments, &own, in.volume, in_path);
        if (!status)
            status = choose_marks(context, arguments, &own, in.volume, in_path);
    }
    int code;
    if (!status)
        status = m->truncate ? truncate_samples(context, arguments, &own, in_path, in.volume, array)
                             : compress_samples(context, arguments, &own, in_path, in.volume, array,
                                                report);
    close_input(&in);
    if (!status && m->truncate && (code = cvol_array_set_attributes(context, *array, attributes)))
        status = report_context_error(context, code, arguments->attributes);
    free(attributes);
    return status;
}

static int compress_in_memory(cvol_context *context, compress_arguments *arguments, const method *m,
                              const char *in_path, const char *out_path)
{
    cvol_array *array;
    cvol_compress_report report = {0};
    int code, status = compress_to_array(context, arguments, m, in_path, &array, &report);
    if (!status && (code = cvol_array_write(context, array, out_path, &report.file_bytes)))
        status = report_context_error(context, code, NULL);
    if (!status && m->truncate)
        fill_report(&report, array);
    if (!status) {
        const cvol_grid *grid = cvol_array_grid(array);
        cvol_array_info info;
        cvol_array_get_info(&info, array);
        report.ratio = (double)cvol_grid_bytes(grid) / (double)report.file_bytes;
        clear_progress();
        if (arguments->common.fill_given && !info.missing_samples)
            fprintf(stderr,
                    "cvol: %s: --fill %s changes nothing: no sample has this value, or is NaN or "
                    "infinite\n",
                    in_path, arguments->fill);
        if (arguments->common.json)
            status = report_one_json(grid, &info, &report, 0, arguments->has_yielded);
        else
            report_one_text(out_path, m, grid, &report, arguments->has_yielded);
        if (arguments->was_compressed && !arguments->common.json)
            printf("(%s was compressed before: errors are relative to its decoded samples)\n",
                   in_path);
    }
    cvol_array_free(array);
    return status;
}

int check_slab_labels(cvol_context *context, const compress_arguments *a, const char *path,
                      cvol_type type)
{
    double sample = 0;
    const cvol_volume none = {cvol_grid_make(1, 1, 1, type), &sample};
    int are_labels;
    if (a->labels == LABELS_NO || count_targets(a))
        return EXIT_DONE;
    const int code = cvol_volume_compute_is_labels(context, &are_labels, &none, path);
    if (code)
        return report_context_error(context, code, NULL);
    return are_labels ? report_error(EXIT_FAILED,
                                     "%s: samples are labels, which are compressed with loss slab "
                                     "by slab: %sgive --labels no or a target to accept that",
                                     path,
                                     compressor_of_streams != cvol_compress_stream
                                         ? "use cvol compress, or "
                                     : a->stream ? "leave out --stream, or "
                                                 : "")
                      : EXIT_DONE;
}

static int compress_by_slab(cvol_context *context, compress_arguments *arguments, const method *m,
                            slab_input *in, const char *out_path)
{
    const input none = {0};
    char *attributes = NULL;
    cvol_compress_report report = {0};
    cvol_array_info info;
    const cvol_grid grid = *slab_input_grid(in);
    int status = check_slab_labels(context, arguments, in->path, grid.type);
    if (!status)
        status = find_attributes(&attributes, &none, arguments->attributes);
    if (!status)
        status = add_label_attributes(&attributes, arguments->label_file, in->path);
    if (!status) {
        cvol_compress_options options = m->options;
        options.attributes = attributes;
        int code = compress_slabs(context, in, out_path, &options, &report);
        if (code && yields_to_psnr(arguments, &options, code, &report)) {
            print_yielding_note(arguments, in->path, cvol_context_message(context));
            code = compress_slabs(context, in, out_path, &options, &report);
        }
        if (code)
            status = report_compression_error(
                context, code, code == CVOL_ERROR_IO ? NULL : in->path, &options, &report);
        else
            status = read_streamed_info(context, &info, out_path, &grid, &report);
    }
    free(attributes);
    if (!status && arguments->common.json)
        status = report_one_json(&grid, &info, &report, 1, arguments->has_yielded);
    else if (!status)
        report_one_text(out_path, m, &grid, &report, arguments->has_yielded);
    return status;
}

static int compress(cvol_context *context, compress_arguments *arguments, const method *m,
                    const char *in_path, const char *out_path)
{
    slab_input in = {0};
    int status = check_output(in_path, out_path);
    if (status)
        return status;
    status = check_stream(arguments, m);
    if (status)
        return status;
    if (arguments->stream && is_cvol(in_path))
        return report_error(
            EXIT_MISUSED,
            "%s: is a .cvol file, which --stream does not read: use cvol transcode to make "
            "it smaller",
            in_path);
    if (!option_against_streams(arguments, m) && !is_cvol(in_path))
        status = open_slab_input(context, &in, in_path, &arguments->common, arguments->stream);
    if (!status)
        status = in.stream ? compress_by_slab(context, arguments, m, &in, out_path)
                           : compress_in_memory(context, arguments, m, in_path, out_path);
    close_slab_input(&in);
    return status;
}

/* Compresses a PNG, which has fewer options. */
static int compress_png(cvol_context *context, const compress_arguments *a, const method *m,
                        const char *in_path, const char *out_path)
{
    cvol_picture_options options = cvol_picture_options_defaults();
    int status = check_output(in_path, out_path);
    options.transform = m->transform;
    options.block = m->block;
    options.psnr_db = a->psnr;
    options.ratio = a->psnr_given ? 0 : a->ratio;
    return status ? status : compress_picture(context, in_path, out_path, &options, a->common.json);
}

/* Refuses options that pictures do not have. */
static int check_png(const compress_arguments *a, const char *in_path, const char *out_path)
{
    const char *given = a->bits_given                 ? "--bpv"
                        : a->max_error_given          ? "--max-error"
                        : a->lossless                 ? lossless_option(a)
                        : a->keep                     ? "--keep"
                        : a->fill                     ? "--fill"
                        : a->attributes               ? "--attributes"
                        : a->label_file               ? "--label-table"
                        : a->no_lap                   ? "--no-lap"
                        : effort_option(a)            ? effort_option(a)
                        : a->stream                   ? "--stream"
                        : a->background               ? "--background"
                        : a->bricks                   ? "--bricks"
                        : has_raw_options(&a->common) ? "--dims, --type and the like"
                                                      : NULL;
    if (given)
        return report_error(EXIT_MISUSED, "%s: is a picture: leave out %s", in_path, given);
    if (a->psnr_given && a->psnr > 100)
        return report_error(EXIT_MISUSED, "--psnr is %g dB, must be at most 100 for a picture",
                            a->psnr);
    if (!has_ending(out_path, ".cvi"))
        return report_error(EXIT_MISUSED, "%s: is a picture: the output's name must end in .cvi",
                            in_path);
    return EXIT_DONE;
}

/* Compresses one file, or several, which then must not be pictures. */
static int run(compress_arguments *a, const method *m, const volume_list *inputs)
{
    const char *in_path = inputs->paths[0], *out_path = a->output;
    const int is_a_png = inputs->count == 1 && is_png(in_path);
    int status;
    if (is_a_png && (status = check_png(a, in_path, out_path)))
        return status;
    if (!is_a_png && !has_ending(out_path, ".cvol"))
        return report_error(EXIT_MISUSED, "%s: the output's name must end in .cvol", out_path);
    cvol_context *context = begin_command(&a->common);
    if (!context)
        return EXIT_FAILED;
    int many = 0;
    status = is_a_png ? compress_png(context, a, m, in_path, out_path)
                      : compress_series(context, a, m, inputs, &many);
    if (!status && !is_a_png && !many)
        status = compress(context, a, m, in_path, out_path);
    return end_command(context, status);
}

int command_compress(int argc, char **argv)
{
    compress_arguments a = {.common = COMMON_DEFAULTS,
                            .ratio = 30,
                            .block = 16,
                            .transform = "dct",
                            .labels_name = "auto"};
    method m;
    const option_spec specs[] = {
        {NULL, NULL, "Target (one of):", OPTION_HEADING, NULL, 0, NULL},
        {"--ratio", "R",
         "raw bytes / file bytes (default 30); without DCT blocks: 4 bytes a sample / memory",
         OPTION_NUMBER, &a.ratio, 0, &a.ratio_given},
        {"--bpv", "B", "at most B bits per voxel: 8 file bytes / samples", OPTION_NUMBER, &a.bits,
         0, &a.bits_given},
        {"--psnr", "DB", "at least DB decibels, over the value range of the samples", OPTION_NUMBER,
         &a.psnr, 0, &a.psnr_given},
        {"--max-error", "E", "no sample changes by more than E; can be combined with --psnr",
         OPTION_NUMBER, &a.max_error, 0, &a.max_error_given},
        {"--lossless", NULL, "every sample decodes to its original bits", OPTION_FLAG, &a.lossless,
         0, NULL},
        {"--labels", "auto|yes|no",
         "yes: labels, lossless; no: not labels; auto (default): decided by file and samples",
         OPTION_TEXT, &a.labels_name, 0, NULL},
        {"--keep", "K,S", "keep the K lowest frequencies of each axis and S others", OPTION_TEXT,
         &a.keep, 0, NULL},
        {NULL, NULL, "Special samples:", OPTION_HEADING, NULL, 0, NULL},
        {"--fill", "V",
         "missing values: samples equal to V, NaN or infinite, all decoded as V; nan: keep NaN",
         OPTION_TEXT, &a.fill, 0, NULL},
        {"--background", "V",
         "store samples equal to V separately, without loss; none; auto (default): if smaller",
         OPTION_TEXT, &a.background, 0, NULL},
        {NULL, NULL, "Attributes:", OPTION_HEADING, NULL, 0, NULL},
        {"--attributes", "FILE.json",
         "JSON to store in the file (default: the attributes of a .cvol input)", OPTION_TEXT,
         &a.attributes, 0, NULL},
        {"--label-table", "FILE",
         "names and colours of labels to store: a file of ITK-SNAP, FreeSurfer or 3D Slicer",
         OPTION_TEXT, &a.label_file, 0, NULL},
        {NULL, NULL, "Method:", OPTION_HEADING, NULL, 0, NULL},
        {"--block", "B",
         "side of the blocks: 8, 16 (default) or 32; 0: one transform of the whole volume",
         OPTION_INTEGER, &a.block, 0, NULL},
        {"--bricks", "B or X,Y,Z",
         "samples per side of the boxes that decode alone: 16 to 64 (default 64; large files: "
         "less)",
         OPTION_TEXT, &a.bricks, 0, NULL},
        {"--transform", "NAME", "transform: dct (default), dht or dft", OPTION_TEXT, &a.transform,
         0, NULL},
        {"--no-lap", NULL, "no filter across block faces: multiply and convolve are then faster",
         OPTION_FLAG, &a.no_lap, 0, NULL},
        {"--effort", "EFFORT",
         "fast (half the time, 3 to 9 % more bits), default, max (up to 1.8 dB more, 20 times "
         "slower)",
         OPTION_TEXT, &a.effort_name, 0, NULL},
        {"--fast", NULL, "the same as --effort fast", OPTION_FLAG, &a.fast, 0, NULL},
        {"--smallest", NULL, "the same as --effort max", OPTION_FLAG, &a.smallest, 0, NULL},
        {"--force", NULL,
         "keep to --ratio or --bpv even below 25 dB (without a target: instead of 35 dB)",
         OPTION_FLAG, &a.force, 0, NULL},
        {"--stream", NULL, "compress slab by slab, in little memory, at any size", OPTION_FLAG,
         &a.stream, 0, NULL},
        {NULL, NULL, "Several volumes in one file (series):", OPTION_HEADING, NULL, 0, NULL},
        {"-o", "OUT.cvol", "the output; all other names are inputs or patterns, as in 'run_*.nrrd'",
         OPTION_TEXT, &a.output, 0, NULL},
        {"--as", "WHAT", "meaning of several inputs: times (default) or channels", OPTION_TEXT,
         &a.as, 0, NULL},
        {"--time-step", "S", "seconds between times (default: as in the input)", OPTION_NUMBER,
         &a.time_step, 0, &a.time_step_given},
        {"--channel-names", "A,B", "names of the channels (default: as in the input)", OPTION_TEXT,
         &a.channel_names, 0, NULL},
        {"--channel-colors", "A,B",
         "colours of the channels, as in green,magenta or #00ff40,#ff00ff", OPTION_TEXT,
         &a.channel_colours, 0, NULL},
        SHAPE_OPTIONS(a.common, "Raw samples (x fastest):", "--type"),
        CHOICE_OPTIONS(a.common),
        COMMON_OPTIONS(a.common),
    };
    const char **names = calloc((size_t)argc, sizeof *names);
    if (!names)
        return report_error(EXIT_FAILED, "not enough memory");
    command_line line = {.usage = "cvol compress IN [OUT.cvol] [options]",
                         .description = description,
                         .examples = examples,
                         .options = specs,
                         .option_count = sizeof specs / sizeof *specs,
                         .positional_count = 1,
                         .all = names};
    volume_list inputs = {0};
    int status = parse_command_line(&line, argc, argv);
    if (status < 0 && !(status = choose_method(&m, &a)) &&
        !(status = find_volumes(&inputs, &line, &a)))
        status = run(&a, &m, &inputs);
    free(names);
    free(a.own_output);
    free_volumes(&inputs);
    return status;
}
