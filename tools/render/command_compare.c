/* cvol compare: the difference of two volumes or two pictures. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "tools/base/picture.h"
#include "tools/labels/labels.h"

static const char description[] =
    "Compares two volumes of the same shape (any format, compressed or not), or two pictures\n"
    "of the same size (PNG or compressed). It prints the PSNR of B against A: over the value\n"
    "range of A for volumes; over 255 for pictures, and for their foreground (pixels where\n"
    "either picture has a channel above 2), with SSIM. Equal inputs are \"exact\"; their PSNR\n"
    "is null in JSON. Samples that a .cvol file stores as missing, NaN, and in other files a\n"
    "value far from all others, such as 1e35, are left out if they are the same in both.\n"
    "--time, --channel and --series choose a volume of A. --time and --channel also choose a\n"
    "volume of B if B holds several.";

static const char examples[] = "  cvol compare brain.nii.gz brain.cvol\n"
                               "  cvol compare a.png b.cvi --json\n";

static int compare_pictures(cvol_context *context, const common_options *common, const char *a_path,
                            const char *b_path)
{
    cvol_image *a = NULL, *b = NULL;
    cvol_image_difference d;
    char whole[PSNR_TEXT], foreground[PSNR_TEXT];
    int status = EXIT_DONE;
    /* Different sizes are a property of the files: status 1, not 2. */
    if (read_picture(context, &a, a_path) || read_picture(context, &b, b_path) ||
        cvol_image_compare(context, &d, a, b))
        status = report_context_error(context, 0, NULL);
    else if (common->json)
        status = print_json(json_pack(
            "{s:i, s:i, s:o, s:b, s:o, s:f, s:f, s:f, s:I}", "width", a->width, "height", a->height,
            "psnr_db", json_decibels(d.psnr_db), "exact", is_exact(d.psnr_db), "psnr_foreground_db",
            json_decibels(d.psnr_foreground_db), "ssim", d.ssim, "rmse", d.rmse, "max_abs_error",
            d.max_abs_error, "foreground_pixels", (json_int_t)d.foreground_pixels));
    else
        printf("%s, foreground %s (%zu pixels), SSIM %.4f, largest difference %g\n",
               psnr_text(whole, d.psnr_db), psnr_text(foreground, d.psnr_foreground_db),
               d.foreground_pixels, d.ssim, d.max_abs_error);
    cvol_image_free(a);
    cvol_image_free(b);
    return status;
}

/* If B holds several volumes, applies --time and --channel to B too, and to B alone if A has one
 * volume. */
static int copy_choice(cvol_context *context, common_options *a, common_options *b,
                       const char *a_path, int a_has_header, const char *b_path)
{
    const cvol_read_options requested = a->read;
    int times = 1, channels = 1, status = EXIT_DONE;
    if (!requested.has_index && !requested.has_channel)
        return EXIT_DONE;
    choose_of_several(context, &b->read, &requested, b_path);
    if (!b->read.has_index && !b->read.has_channel)
        return EXIT_DONE;
    a->read.has_index = a->read.has_channel = 0;
    if (a_has_header)
        status = count_volumes(context, a, a_path, &times, &channels);
    a->read.has_index = requested.has_index && (times > 1 || !b->read.has_index);
    a->read.has_channel = requested.has_channel && (channels > 1 || !b->read.has_channel);
    return status;
}

/* Sets marked samples to NaN. Integers become float64. */
static int mark_missing(cvol_context *context, cvol_volume **volume, const uint8_t *missing)
{
    const size_t samples = cvol_grid_samples(&(*volume)->grid);
    if (cvol_type_is_integer((*volume)->grid.type)) {
        cvol_grid grid = (*volume)->grid;
        cvol_volume *wide;
        grid.type = CVOL_FLOAT64;
        const int code = cvol_volume_create(context, &wide, &grid);
        if (code)
            return code;
        for (size_t i = 0; i < samples; i++)
            ((double *)wide->data)[i] = value_at(*volume, i);
        cvol_volume_free(*volume);
        *volume = wide;
    }
    for (size_t i = 0; i < samples; i++)
        if (missing[i] && (*volume)->grid.type == CVOL_FLOAT32)
            ((float *)(*volume)->data)[i] = NAN;
        else if (missing[i])
            ((double *)(*volume)->data)[i] = NAN;
    return CVOL_OK;
}

/* missing[i] = 1 for samples of a value far from all others, such as 1e35. *found: some have it. */
static int find_marks(cvol_context *context, int *found, uint8_t *missing,
                      const cvol_volume *volume)
{
    cvol_histogram histogram;
    const int code = cvol_volume_compute_histogram(context, &histogram, volume);
    *found = !code && histogram.mark_count > 0;
    for (size_t i = 0; *found && i < cvol_grid_samples(&volume->grid); i++)
        missing[i] = value_at(volume, i) == histogram.mark;
    return code;
}

/* Sets the samples that volume `of` lacks, and that are equal in both volumes, to NaN: fills such
 * as 1e35 have no part in the range or in the errors. A .cvol file states what it lacks. Exit
 * status. */
static int leave_out_missing(cvol_context *context, input *a, input *b, const input *of)
{
    const cvol_grid *grid = &a->volume->grid;
    const size_t begin[3] = {0, 0, 0}, samples = cvol_grid_samples(grid);
    if (memcmp(grid->dims, b->volume->grid.dims, sizeof grid->dims) != 0)
        return EXIT_DONE;
    uint8_t *missing = malloc(samples);
    if (!missing)
        return report_error(EXIT_FAILED, "not enough memory");
    int code = CVOL_OK, found;
    if (of->array)
        found = cvol_array_evaluate_mask(missing, of->array, begin, grid->dims) > 0;
    else
        code = find_marks(context, &found, missing, of->volume);
    if (found) {
        for (size_t i = 0; i < samples; i++)
            missing[i] = missing[i] && value_at(a->volume, i) == value_at(b->volume, i);
        code = mark_missing(context, &a->volume, missing);
        if (!code)
            code = mark_missing(context, &b->volume, missing);
    }
    free(missing);
    return code ? report_context_error(context, code, NULL) : EXIT_DONE;
}

static int compare_volumes(cvol_context *context, common_options *common, const char *a_path,
                           const char *b_path)
{
    input a = {0}, b = {0};
    cvol_volume_difference d;
    char psnr[PSNR_TEXT];
    common_options plain_a = *common, raw_a = *common, raw_b = *common, plain_b;
    plain_a.read = cvol_read_options_defaults();
    plain_a.type_name = NULL;
    plain_b = plain_a;
    /* --time, --channel and --series choose a volume of A. */
    plain_a.read.has_channel = common->read.has_channel;
    plain_a.read.channel = common->read.channel;
    plain_a.read.has_index = common->read.has_index;
    plain_a.read.index = common->read.index;
    plain_a.read.series = common->read.series;
    raw_b.read.has_channel = raw_b.read.has_index = 0;
    raw_b.read.series = NULL;
    int a_has_header, b_has_header;
    if (find_has_header(context, &a_has_header, a_path) ||
        find_has_header(context, &b_has_header, b_path))
        return EXIT_FAILED;
    if (has_raw_options(common) && a_has_header && b_has_header)
        return report_error(
            EXIT_MISUSED,
            "%s and %s have headers: --dims, --type and --big-endian are for raw samples, and "
            "spacing does not matter",
            a_path, b_path);
    common_options *options_a = a_has_header ? &plain_a : &raw_a;
    int status = copy_choice(context, options_a, &plain_b, a_path, a_has_header, b_path);
    if (!status)
        status = open_input(context, &a, a_path, options_a);
    if (!status)
        status = need_volume(context, &a);
    if (!status)
        status = open_input(context, &b, b_path, b_has_header ? &plain_b : &raw_b);
    if (!status)
        status = need_volume(context, &b);
    if (!status)
        status = leave_out_missing(context, &a, &b, &a);
    if (!status)
        status = leave_out_missing(context, &a, &b, &b);
    if (!status && cvol_volume_compare(context, &d, a.volume, b.volume))
        status = report_error(EXIT_FAILED, "%s and %s: %s", a_path, b_path,
                              cvol_context_message(context));
    if (!status) {
        const char *const paths[2] = {a_path, b_path};
        note_places(paths, &a.volume->grid, &b.volume->grid);
        note_values(paths, &a.volume->grid, &b.volume->grid);
    }
    if (!status && common->json)
        status = print_json(json_pack("{s:o, s:b, s:o, s:o, s:o}", "psnr_db",
                                      json_decibels(d.psnr_db), "exact", is_exact(d.psnr_db),
                                      "rmse", json_number(d.rmse), "max_abs_error",
                                      json_number(d.max_abs_error), "peak", json_number(d.peak)));
    else if (!status)
        printf("%s, RMSE %g, largest error %g\n", psnr_text(psnr, d.psnr_db), d.rmse,
               d.max_abs_error);
    close_input(&a);
    close_input(&b);
    return status;
}

int command_compare(int argc, char **argv)
{
    common_options common = COMMON_DEFAULTS;
    const option_spec specs[] = {INPUT_OPTIONS(common), COMMON_OPTIONS(common)};
    command_line line = {.usage = "cvol compare A B [options]",
                         .description = description,
                         .examples = examples,
                         .options = specs,
                         .option_count = sizeof specs / sizeof *specs,
                         .positional_count = 2};
    int status = parse_command_line(&line, argc, argv);
    if (status >= 0)
        return status;
    const char *a = line.positionals[0], *b = line.positionals[1];
    cvol_context *context = begin_command(&common);
    if (!context)
        return EXIT_FAILED;
    status = is_picture(a) && is_picture(b) ? compare_pictures(context, &common, a, b)
                                            : compare_volumes(context, &common, a, b);
    return end_command(context, status);
}
