/* cvol compress: a dense volume into a .cvol file. */
#include <math.h>
#include <string.h>

#include "cli.h"

typedef struct compress_arguments {
    common_options common;
    double ratio, psnr, max_error;
    int ratio_given, psnr_given, max_error_given;
    int block;
    const char *transform;
} compress_arguments;

static const char description[] =
    "Compresses a volume: the DCT coefficients of its blocks that matter, quantised by one step.\n"
    "The step is searched until the target holds, and the result is verified by decoding it\n"
    "before the file gets its name. Geometry and sample type are kept.";

static const char examples[] =
    "  cvol compress brain.nii.gz brain.cvol                   a thirtieth of the raw bytes\n"
    "  cvol compress ct.mha ct.cvol --psnr 60                  at least 60 dB\n"
    "  cvol compress field.raw f.cvol --dims 128x128x64 --type float32 --max-error 0.01\n";

/* Which target the options ask for; EXIT_DONE, or EXIT_MISUSED after a sentence. */
static int choose_target(cvol_compress_options *options, const compress_arguments *arguments)
{
    if (arguments->ratio_given + arguments->psnr_given + arguments->max_error_given > 1)
        return complain(EXIT_MISUSED, "give only one of --ratio, --psnr and --max-error");
    if (arguments->psnr_given) {
        options->target = CVOL_TARGET_PSNR;
        options->target_value = arguments->psnr;
    } else if (arguments->max_error_given) {
        options->target = CVOL_TARGET_MAX_ERROR;
        options->target_value = arguments->max_error;
    } else if (arguments->ratio_given) {
        options->target = CVOL_TARGET_RATIO;
        options->target_value = arguments->ratio;
    }
    if (arguments->ratio_given && !(arguments->ratio > 1))
        return complain(EXIT_MISUSED, "--ratio is %g, must be above 1", arguments->ratio);
    if (arguments->psnr_given && !(arguments->psnr > 0 && arguments->psnr <= 200))
        return complain(EXIT_MISUSED, "--psnr is %g dB, must be above 0 and at most 200",
                        arguments->psnr);
    if (arguments->max_error_given && !(arguments->max_error >= 0))
        return complain(EXIT_MISUSED, "--max-error is %g, must not be negative",
                        arguments->max_error);
    if (arguments->block != 8 && arguments->block != 16 && arguments->block != 32)
        return complain(EXIT_MISUSED, "--block is %d, must be 8, 16 or 32", arguments->block);
    options->block = arguments->block;
    if (strcmp(arguments->transform, "dct"))
        return complain(EXIT_MISUSED, "--transform is '%s', this version has: dct",
                        arguments->transform);
    return EXIT_DONE;
}

static int report_json(const cvol_array *array, const cvol_compress_report *report)
{
    cvol_array_info info;
    cvol_array_get_info(array, &info);
    const cvol_grid *grid = cvol_array_grid(array);
    return print_json(
        json_pack("{s:o, s:s, s:I, s:f, s:f, s:o, s:f, s:b, s:b, s:i, s:f, s:I, s:f}", "dims",
                  json_dims(grid->dims), "type", cvol_type_name(grid->type), "file_bytes",
                  (json_int_t)report->file_bytes, "ratio", report->ratio, "bits_per_voxel",
                  8 * (double)report->file_bytes / (double)cvol_grid_samples(grid), "psnr_db",
                  json_decibels(report->psnr_db), "max_error", report->max_error, "lossless",
                  report->lossless, "target_met", report->target_met, "block", info.block, "step",
                  info.step, "coefficients", (json_int_t)info.coefficients, "rho", info.rho));
}

static void report_text(const char *path, const cvol_compress_options *options,
                        const cvol_compress_report *report)
{
    clear_progress();
    printf("%s: %llu bytes, 1/%.2f of the raw samples, ", path,
           (unsigned long long)report->file_bytes, report->ratio);
    if (report->lossless)
        printf("lossless\n");
    else
        printf("PSNR %.2f dB, largest error %g\n", report->psnr_db, report->max_error);
    if (report->lossless && options->target == CVOL_TARGET_RATIO &&
        report->ratio > options->target_value * 1.02)
        printf("(the volume is lossless before ratio %g is reached)\n", options->target_value);
    else if (!report->target_met)
        printf("(ratio %g is out of reach: this is the coarsest there is)\n",
               options->target_value);
}

static int compress(cvol_context *context, compress_arguments *arguments,
                    const cvol_compress_options *options, const char *in_path, const char *out_path)
{
    input in;
    cvol_array *array = NULL;
    cvol_compress_report report;
    int status = check_output(in_path, out_path);
    if (status)
        return status;
    status = open_input(context, &in, in_path, &arguments->common);
    if (!status && in.array)
        status = need_volume(context, &in);
    int code = 0;
    if (!status && (code = cvol_compress(context, &array, &report, in.volume->data,
                                         &in.volume->grid, options)))
        status = complain_context(context, code, in_path);
    close_input(&in);
    if (!status && (code = cvol_array_write(context, array, out_path, &report.file_bytes)))
        status = complain_context(context, code, NULL);
    if (!status && arguments->common.json)
        status = report_json(array, &report);
    else if (!status)
        report_text(out_path, options, &report);
    cvol_array_free(array);
    return status;
}

int command_compress(int argc, char **argv)
{
    compress_arguments a = {.block = 16, .transform = "dct"};
    cvol_compress_options options = cvol_compress_options_defaults();
    const option_spec specs[] = {
        {NULL, NULL, "Target (one of):", OPTION_HEADING, NULL, 0, NULL},
        {"--ratio", "R", "raw bytes / file bytes (default 30)", OPTION_NUMBER, &a.ratio, 0,
         &a.ratio_given},
        {"--psnr", "DB", "at least so many dB, over the range of the samples", OPTION_NUMBER,
         &a.psnr, 0, &a.psnr_given},
        {"--max-error", "E", "no sample further off than E (0: lossless, for integers)",
         OPTION_NUMBER, &a.max_error, 0, &a.max_error_given},
        {NULL, NULL, "Method:", OPTION_HEADING, NULL, 0, NULL},
        {"--block", "B", "side of the blocks: 8, 16 (default) or 32", OPTION_INTEGER, &a.block, 0,
         NULL},
        {"--transform", "NAME", "dct", OPTION_TEXT, &a.transform, 0, NULL},
        INPUT_OPTIONS(a.common),
        COMMON_OPTIONS(a.common),
    };
    command_line line = {.usage = "cvol compress IN OUT.cvol [options]",
                         .description = description,
                         .examples = examples,
                         .options = specs,
                         .option_count = sizeof specs / sizeof *specs,
                         .positional_count = 2};
    int status = parse_command_line(&line, argc, argv);
    if (status >= 0 || (status = choose_target(&options, &a)))
        return status;
    if (!has_ending(line.positionals[1], ".cvol"))
        return complain(EXIT_MISUSED, "%s: the output's name must end in .cvol",
                        line.positionals[1]);
    cvol_context *context = begin_command(&a.common);
    if (!context)
        return EXIT_FAILED;
    status = compress(context, &a, &options, line.positionals[0], line.positionals[1]);
    return end_command(context, status);
}
