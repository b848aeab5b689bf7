/* cvol transcode: makes a .cvol file smaller and coarser. */
#include <math.h>
#include <string.h>

#include "tools/base/cli.h"
#include "tools/base/processes.h"
#include "tools/compress/compress.h"
#include "tools/labels/labels.h"

static const char description[] =
    "Makes a .cvol file smaller by coarser quantization, without the original samples. The\n"
    "error of the result is certified, not measured: the bound of the input plus the change\n"
    "of its samples; --psnr is the PSNR that this bound guarantees. Attributes and geometry\n"
    "stay the same. Compressing the original volume to the same size gives slightly better\n"
    "quality. Labels, and a size that leaves less than 25 dB, need --force. Of a series it\n"
    "takes one volume; cvol compress takes all.";

static const char examples[] = "  cvol transcode scan.cvol --ratio 100 small.cvol\n"
                               "  cvol transcode scan.cvol small.cvol --bpv 0.1\n"
                               "  cvol transcode scan.cvol planes.cvol --bricks 32,32,16\n"
                               "  cvol transcode run.cvol third.cvol --time 2\n";

typedef struct transcode_arguments {
    common_options common;
    double ratio, bits, psnr;
    int ratio_given, bits_given, psnr_given;
    int force;
    const char *bricks, *background;
} transcode_arguments;

static int choose_target(cvol_compress_options *options, const transcode_arguments *a)
{
    const int targets = a->ratio_given + a->bits_given + a->psnr_given;
    const int chosen = a->common.read.has_index || a->common.read.has_channel;
    const int status = parse_bricks(options->brick, a->bricks);
    if (status)
        return status;
    if (a->background && strcmp(a->background, "none"))
        return report_error(EXIT_MISUSED, "--background is '%s', must be none (default: keep it)",
                            a->background);
    if (a->background && !targets)
        return report_error(EXIT_MISUSED, "--background needs --ratio, --bpv or --psnr");
    if (processes && (a->background || !(targets || a->bricks)))
        return report_error(EXIT_MISUSED,
                            "several processes transcode with --ratio, --bpv, --psnr or --bricks "
                            "only: use cvol transcode");
    if (targets > 1)
        return report_error(EXIT_MISUSED, "give only one of --ratio, --bpv and --psnr");
    if (!targets && !chosen && !a->bricks)
        return report_error(EXIT_MISUSED,
                            "no target: give one of --ratio, --bpv and --psnr, or only --bricks");
    options->target = a->ratio_given  ? CVOL_TARGET_RATIO
                      : a->bits_given ? CVOL_TARGET_BITS
                                      : CVOL_TARGET_PSNR;
    options->target_value = a->ratio_given ? a->ratio : a->bits_given ? a->bits : a->psnr;
    options->least_psnr = a->force ? 0 : LEAST_PSNR;
    return EXIT_DONE;
}

static int report(const char *path, const cvol_array *array, const cvol_compress_report *r,
                  const transcode_arguments *a)
{
    const cvol_grid *grid = cvol_array_grid(array);
    const double bits = 8 * (double)r->file_bytes / (double)cvol_grid_samples(grid);
    const int is_finest = a->bits_given ? bits <= a->bits : a->ratio_given && r->ratio >= a->ratio;
    cvol_array_info info;
    cvol_array_get_info(&info, array);
    if (a->common.json)
        return print_json(json_pack(
            "{s:o, s:s, s:I, s:f, s:f, s:o, s:b, s:o, s:b, s:b, s:f, s:I, s:o, s:o}", "dims",
            json_dims(grid->dims), "type", cvol_type_name(grid->type), "file_bytes",
            (json_int_t)r->file_bytes, "ratio", r->ratio, "bits_per_voxel", bits, "psnr_db",
            json_decibels(info.psnr_db), "exact", is_exact(info.psnr_db), "max_error",
            json_number(info.max_error), "measured", info.measured, "target_met", r->target_met,
            "step", info.step, "coefficients", (json_int_t)info.coefficients, "l2_error",
            json_number(info.l2_error), "point_error", json_number(info.point_error)));
    char share[SHARE_TEXT];
    clear_progress();
    printf("%s: %llu bytes, %s, %.4g bits per voxel, ", path, (unsigned long long)r->file_bytes,
           share_text(share, r->ratio), bits);
    if (is_exact(info.psnr_db))
        printf("exact\n");
    else
        printf("PSNR at least %.2f dB\n", info.psnr_db);
    if (!r->target_met)
        printf("(the target is out of reach: %s)\n",
               is_finest ? "the finest file is smaller" : "this is the smallest possible file");
    return EXIT_DONE;
}

/* Copies one volume of a series into its own file, unchanged. */
static int extract(cvol_context *context, const transcode_arguments *a, const cvol_file_part *part,
                   const char *in_path, const char *out_path)
{
    uint64_t bytes;
    const int code = cvol_series_extract(context, in_path, part->time, part->channel, out_path,
                                         &bytes);
    if (code)
        return report_context_error(context, code, NULL);
    if (a->common.json)
        return print_json(json_pack("{s:i, s:i, s:I}", "time", part->time, "channel", part->channel,
                                    "file_bytes", (json_int_t)bytes));
    clear_progress();
    printf("%s: %llu bytes, unchanged\n", out_path, (unsigned long long)bytes);
    return EXIT_DONE;
}

/* Adds a separately stored background, if there is one, to the coefficients. */
static int flatten(cvol_context *context, cvol_array **array)
{
    cvol_array_info info;
    cvol_array *flat = NULL;
    cvol_array_get_info(&info, *array);
    if (!info.background_samples)
        return CVOL_OK;
    const char *attributes = cvol_array_attributes(*array);
    int code = cvol_array_flatten(context, &flat, *array);
    if (!code && attributes)
        code = cvol_array_set_attributes(context, flat, attributes);
    if (code) {
        cvol_array_free(flat);
        return code;
    }
    cvol_array_free(*array);
    *array = flat;
    return CVOL_OK;
}

/* Labels are stored without loss, and a target would make them lossy: their file names them, or
 * they look like labels. EXIT_FAILED, after a message, if the array has labels. */
static int refuse_labels(cvol_context *context, const transcode_arguments *a,
                         const cvol_array *array, const char *path)
{
    const cvol_grid *grid = cvol_array_grid(array);
    const size_t begin[3] = {0, 0, 0};
    cvol_array_info info;
    label_table table = {0};
    cvol_volume *volume = NULL;
    cvol_array_get_info(&info, array);
    if (a->force || processes || !is_exact(info.psnr_db) || !cvol_type_is_integer(grid->type))
        return EXIT_DONE;
    const int status = read_label_attributes(&table, path);
    int are_labels = table.count > 0;
    free_labels_table(&table);
    if (status)
        return status;
    int code = are_labels ? CVOL_OK : cvol_volume_create(context, &volume, grid);
    if (volume)
        code = cvol_array_evaluate_box(context, volume->data, array, begin, grid->dims);
    if (volume && !code)
        code = cvol_volume_compute_is_labels(context, &are_labels, volume, NULL);
    cvol_volume_free(volume);
    if (code)
        return report_context_error(context, code, path);
    return are_labels
               ? report_error(EXIT_FAILED,
                              "%s: samples are labels, which %s would change; keep the file, "
                              "or give --force for lossy compression",
                              path,
                              a->ratio_given  ? "--ratio"
                              : a->bits_given ? "--bpv"
                                              : "--psnr")
               : EXIT_DONE;
}

static int transcode(cvol_context *context, transcode_arguments *a,
                     const cvol_compress_options *options, const char *in_path,
                     const char *out_path)
{
    const int has_target = a->ratio_given || a->bits_given || a->psnr_given;
    cvol_array *from = NULL, *array = NULL;
    cvol_compress_report r = {.psnr_db = INFINITY};
    int status = check_output(in_path, out_path);
    cvol_file_part part = {.size = sizeof(cvol_file_part)};
    if (!status && is_cvol(in_path))
        status = choose_volume(context, &a->common, in_path, &part);
    if (status)
        return status;
    if (!has_target && !a->bricks)
        return extract(context, a, &part, in_path, out_path);
    int code = read_array(context, &from, NULL, in_path, &part);
    if (!code && a->background)
        code = flatten(context, &from);
    if (code) {
        cvol_array_free(from);
        return report_context_error(context, code, NULL);
    }
    if (has_target && (status = refuse_labels(context, a, from, in_path))) {
        cvol_array_free(from);
        return status;
    }
    if (has_target) {
        code = cvol_array_transcode(context, &array, &r, from, options);
        cvol_array_free(from);
    } else {
        array = from;
        r = (cvol_compress_report){.target_met = 1};
        code = cvol_array_set_bricks(context, array, options->brick);
    }
    if (code) {
        cvol_array_free(array);
        return report_compression_error(context, code, in_path, options, &r);
    }
    code = cvol_array_write(context, array, out_path, &r.file_bytes);
    r.ratio = (double)cvol_grid_bytes(cvol_array_grid(array)) / (double)r.file_bytes;
    status = code ? report_context_error(context, code, NULL) : report(out_path, array, &r, a);
    cvol_array_free(array);
    return status;
}

int command_transcode(int argc, char **argv)
{
    transcode_arguments a = {.common = COMMON_DEFAULTS, .ratio = 0};
    cvol_compress_options options = cvol_compress_options_defaults();
    const option_spec specs[] = {
        {NULL, NULL, "Target (one of):", OPTION_HEADING, NULL, 0, NULL},
        {"--ratio", "R", "raw bytes / file bytes", OPTION_NUMBER, &a.ratio, 0, &a.ratio_given},
        {"--bpv", "B", "at most B bits per voxel: 8 file bytes / samples", OPTION_NUMBER, &a.bits,
         0, &a.bits_given},
        {"--psnr", "DB", "at least DB decibels, certified", OPTION_NUMBER, &a.psnr, 0,
         &a.psnr_given},
        {"--force", NULL, "make labels lossy, and keep to --ratio or --bpv below 25 dB",
         OPTION_FLAG, &a.force, 0, NULL},
        {"--background", "none",
         "store a separate background with the other samples: its mask may be large", OPTION_TEXT,
         &a.background, 0, NULL},
        {NULL, NULL, "Random access (without a target: coefficients do not change):",
         OPTION_HEADING, NULL, 0, NULL},
        {"--bricks", "B or X,Y,Z",
         "samples per side of the boxes that decode alone: 16 to 64 (default: as in the input)",
         OPTION_TEXT, &a.bricks, 0, NULL},
        {NULL, NULL, "Volume of a series (without a target: copied unchanged):", OPTION_HEADING,
         NULL, 0, NULL},
        PLACE_OPTIONS(a.common),
        COMMON_OPTIONS(a.common),
    };
    command_line line = {.usage = "cvol transcode IN.cvol OUT.cvol [options]",
                         .description = description,
                         .examples = examples,
                         .options = specs,
                         .option_count = sizeof specs / sizeof *specs,
                         .positional_count = 2};
    int status = parse_command_line(&line, argc, argv);
    if (status >= 0 || (status = choose_target(&options, &a)))
        return status;
    if (!has_ending(line.positionals[1], ".cvol"))
        return report_error(EXIT_MISUSED, "%s: the output's name must end in .cvol",
                            line.positionals[1]);
    cvol_context *context = begin_command(&a.common);
    if (!context)
        return EXIT_FAILED;
    return end_command(context,
                       transcode(context, &a, &options, line.positionals[0], line.positionals[1]));
}
