/* Checks the options of a compression. */
#include "codec/rate/compress_options.h"

#include <math.h>

#include "base/context.h"
#include "base/options.h"
#include "codec/brick/brick_shape.h"
#include "codec/rate/step_search.h"
#include "transform/cell.h"

static const cvol_compress_options defaults = {.size = sizeof(cvol_compress_options),
                                               .transform = CVOL_DCT,
                                               .block = 16,
                                               .target = CVOL_TARGET_RATIO,
                                               .target_value = 30,
                                               .lapped = 1};

void cvol_compress_options_set_defaults(cvol_compress_options *options, size_t size)
{
    cvol_options_fill(options, size, &defaults, sizeof defaults);
}

int cvol_compress_options_complete(cvol_context *context, cvol_compress_options *out,
                                   const cvol_compress_options *options)
{
    *out = defaults;
    return cvol_options_copy(context, out, sizeof *out, CVOL_SIZE_TO(cvol_compress_options, brick),
                             "cvol_compress_options", options);
}

int cvol_compress_options_check(cvol_context *context, const cvol_compress_options *options)
{
    const double value = options->target_value;
    if (options->transform != CVOL_DCT)
        return cvol_fail(context, CVOL_ERROR_UNSUPPORTED, "transform is %d, must be 1 (dct)",
                         (int)options->transform);
    if (options->block != 8 && options->block != 16 && options->block != 32)
        return cvol_fail(context, CVOL_ERROR_ARGUMENT, "block is %d, must be 8, 16 or 32",
                         options->block);
    const int code = cvol_brick_sides_check(context, options->brick, options->block);
    if (code)
        return code;
    if ((int)options->effort < CVOL_EFFORT_DEFAULT || options->effort > CVOL_EFFORT_MAX)
        return cvol_fail(context, CVOL_ERROR_ARGUMENT, "effort is %d, must be 0, 1 or 2",
                         (int)options->effort);
    if (options->effort == CVOL_EFFORT_MAX && options->block != CVOL_CELL)
        return cvol_fail(context, CVOL_ERROR_ARGUMENT,
                         "maximum effort needs blocks of 16 samples a side, not of %d",
                         options->block);
    if (options->effort == CVOL_EFFORT_MAX &&
        (options->lossless || options->max_error > 0 || options->target == CVOL_TARGET_MAX_ERROR))
        return cvol_fail(context, CVOL_ERROR_ARGUMENT,
                         "maximum effort cannot be combined with a maximum error or lossless "
                         "compression");
    if (!(options->least_psnr >= 0) || !isfinite(options->least_psnr))
        return cvol_fail(context, CVOL_ERROR_ARGUMENT,
                         "the least PSNR is %g dB, must be finite and 0 or more",
                         options->least_psnr);
    if (!(options->max_error >= 0) || !isfinite(options->max_error))
        return cvol_fail(context, CVOL_ERROR_ARGUMENT,
                         "maximum error is %g, must be finite and 0 or more", options->max_error);
    if (options->max_error > 0 && options->target != CVOL_TARGET_PSNR)
        return cvol_fail(context, CVOL_ERROR_ARGUMENT,
                         "a maximum error can only be combined with a PSNR target");
    if ((int)options->background < CVOL_BACKGROUND_NONE ||
        options->background > CVOL_BACKGROUND_VALUE)
        return cvol_fail(context, CVOL_ERROR_ARGUMENT, "background is %d, must be 0, 1 or 2",
                         (int)options->background);
    if (options->background == CVOL_BACKGROUND_VALUE &&
        (options->lossless || options->has_fill || options->max_error > 0 ||
         options->target == CVOL_TARGET_MAX_ERROR))
        return cvol_fail(
            context, CVOL_ERROR_ARGUMENT,
            "a background cannot be combined with a maximum error, lossless or a fill");
    if (options->background == CVOL_BACKGROUND_VALUE && !isfinite(options->background_value))
        return cvol_fail(context, CVOL_ERROR_ARGUMENT, "the background is %g, must be finite",
                         options->background_value);
    if (options->has_value_range && !(options->value_min <= options->value_max &&
                                      isfinite(options->value_min) && isfinite(options->value_max)))
        return cvol_fail(context, CVOL_ERROR_ARGUMENT,
                         "the range of the original samples is %g to %g: both must be finite, and "
                         "the first one not larger",
                         options->value_min, options->value_max);
    if (options->lossless)
        return CVOL_OK;
    switch (options->target) {
    case CVOL_TARGET_BITS:
        if (!(value > 0) || !isfinite(value))
            return cvol_fail(context, CVOL_ERROR_ARGUMENT,
                             "bits a sample are %g, must be finite and above 0", value);
        return CVOL_OK;
    case CVOL_TARGET_RATIO:
        if (!(value > 1) || !isfinite(value))
            return cvol_fail(context, CVOL_ERROR_ARGUMENT,
                             "ratio is %g, must be finite and above 1", value);
        return CVOL_OK;
    case CVOL_TARGET_PSNR:
        if (!(value > 0) || !(value <= 200))
            return cvol_fail(context, CVOL_ERROR_ARGUMENT,
                             "PSNR is %g dB, must be above 0 and at most 200", value);
        return CVOL_OK;
    case CVOL_TARGET_MAX_ERROR:
        if (!(value >= 0) || !isfinite(value))
            return cvol_fail(context, CVOL_ERROR_ARGUMENT,
                             "maximum error is %g, must be finite and 0 or more", value);
        return CVOL_OK;
    }
    return cvol_fail(context, CVOL_ERROR_ARGUMENT, "target %d is unknown", (int)options->target);
}

int cvol_compress_check_least_psnr(cvol_context *context, const cvol_compress_options *options,
                                   double psnr_db, int is_certified)
{
    const char *kind = is_certified ? "certified " : "";
    const int by_size = options->target == CVOL_TARGET_RATIO || options->target == CVOL_TARGET_BITS;
    const int has_range = psnr_db > -(double)INFINITY; /* samples that are equal have no PSNR */
    if (!by_size || options->lossless || !has_range || !(psnr_db < options->least_psnr))
        return CVOL_OK;
    return cvol_fail(context, CVOL_ERROR_TARGET,
                     options->target == CVOL_TARGET_RATIO
                         ? "ratio %g leaves a %sPSNR of %.2f dB, less than %g dB"
                         : "%g bits a sample leave a %sPSNR of %.2f dB, less than %g dB",
                     options->target_value, kind, psnr_db, options->least_psnr);
}

int cvol_ratio_of_bits(cvol_context *context, double *ratio, double bits, cvol_type type)
{
    const double raw = 8 * (double)cvol_type_size(type);
    if (!(bits < raw) || !isfinite(raw / bits))
        return cvol_fail(context, CVOL_ERROR_ARGUMENT,
                         "bits a sample are %g, must be above 0 and below the %g of %s samples",
                         bits, raw, cvol_type_name(type));
    *ratio = raw / bits;
    return CVOL_OK;
}
