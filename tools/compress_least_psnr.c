/* cvol compress: a ratio, or bits per voxel, that give less than LEAST_PSNR. */
#include "compress.h"

static int leaves_too_little(const cvol_compress_options *options, int code,
                             const cvol_compress_report *report)
{
    return code == CVOL_ERROR_TARGET && report->psnr_db < options->least_psnr &&
           (options->target == CVOL_TARGET_RATIO || options->target == CVOL_TARGET_BITS);
}

int yields_to_psnr(compress_arguments *a, cvol_compress_options *options, int code,
                   const cvol_compress_report *report)
{
    if (count_targets(a) || !leaves_too_little(options, code, report))
        return 0;
    options->target = CVOL_TARGET_PSNR;
    options->target_value = PSNR_INSTEAD;
    a->has_yielded = 1;
    return 1;
}

int complain_too_little(const char *path, const char *says)
{
    return complain(EXIT_FAILED,
                    "%s: %s; give --psnr %d for more quality, or --force to accept this", path,
                    says, PSNR_INSTEAD);
}

int complain_compression(cvol_context *context, int code, const char *path,
                         const cvol_compress_options *options, const cvol_compress_report *report)
{
    return leaves_too_little(options, code, report)
               ? complain_too_little(path, cvol_context_message(context))
               : complain_context(context, code, path);
}

void note_yielding(const compress_arguments *a, const char *path, const char *says)
{
    if (a->common.json || a->is_one_of_many)
        return;
    clear_progress();
    fprintf(stderr, "cvol: %s: %s; compressed to %d dB instead (--force: keep to the ratio)\n",
            path, says, PSNR_INSTEAD);
}
