/* cvol compress: a ratio, or bits per voxel, that give less than LEAST_PSNR. */
#include "tools/compress/compress.h"

static int is_below_least_psnr(const cvol_compress_options *options, int code,
                               const cvol_compress_report *report)
{
    return code == CVOL_ERROR_TARGET && report->psnr_db < options->least_psnr &&
           (options->target == CVOL_TARGET_RATIO || options->target == CVOL_TARGET_BITS);
}

int yields_to_psnr(compress_arguments *a, cvol_compress_options *options, int code,
                   const cvol_compress_report *report)
{
    if (count_targets(a) || !is_below_least_psnr(options, code, report))
        return 0;
    options->target = CVOL_TARGET_PSNR;
    options->target_value = PSNR_INSTEAD;
    a->has_yielded = 1;
    return 1;
}

int report_low_psnr(const char *path, const char *reason)
{
    return report_error(EXIT_FAILED,
                        "%s: %s; give --psnr %d for more quality, or --force to accept this", path,
                        reason, PSNR_INSTEAD);
}

int report_compression_error(cvol_context *context, int code, const char *path,
                             const cvol_compress_options *options,
                             const cvol_compress_report *report)
{
    return is_below_least_psnr(options, code, report)
               ? report_low_psnr(path, cvol_context_message(context))
               : report_context_error(context, code, path);
}

void print_yielding_note(const compress_arguments *a, const char *path, const char *reason)
{
    if (a->common.json || a->is_one_of_many)
        return;
    clear_progress();
    fprintf(stderr, "cvol: %s: %s; compressed to %d dB instead (--force: keep to the ratio)\n",
            path, reason, PSNR_INSTEAD);
}
