/* cvol compress: how to compress, by the options. */
#include <math.h>
#include <stdlib.h>

#include "tools/compress/compress.h"
#include "tools/labels/labels.h"

/* --fill V: samples equal to V have no value, nor have NaN and infinite ones; nan: only the latter.
 */
static int choose_fill(cvol_compress_options *options, compress_arguments *a)
{
    char *end;
    if (!a->fill)
        return EXIT_DONE;
    options->has_fill = 1;
    options->fill = strtod(a->fill, &end);
    if (isfinite(options->fill)) {
        a->common.fill = options->fill;
        a->common.fill_given = 1;
    }
    if (end == a->fill || *end || isinf(options->fill))
        return report_error(EXIT_MISUSED, "--fill is '%s', must be a number or nan", a->fill);
    return EXIT_DONE;
}

/* The option that made the file lossless. */
const char *lossless_option(const compress_arguments *a)
{
    return a->labels == LABELS_YES ? "--labels yes" : "--lossless";
}

/* The option that set the effort, as it was spelled; NULL: none. */
const char *effort_option(const compress_arguments *a)
{
    return a->effort_name ? "--effort" : a->fast ? "--fast" : a->smallest ? "--smallest" : NULL;
}

/* The effort, of which --fast and --smallest are other spellings. */
static int choose_effort(compress_arguments *a)
{
    const char *name = a->effort_name;
    int effort = (int)a->effort;
    if (name && parse_word(&effort, &effort_words, "--effort", name))
        return EXIT_MISUSED;
    a->effort = (cvol_effort)effort;
    const cvol_effort alias = a->fast ? CVOL_EFFORT_FAST : CVOL_EFFORT_MAX;
    if (a->fast && a->smallest)
        return report_error(EXIT_MISUSED, "--fast cannot be combined with --smallest");
    if (name && (a->fast || a->smallest) && alias != a->effort)
        return report_error(EXIT_MISUSED, "--effort %s cannot be combined with %s", name,
                            a->fast ? "--fast" : "--smallest");
    if (a->fast || a->smallest)
        a->effort = alias;
    if (a->effort == CVOL_EFFORT_MAX && (a->max_error_given || a->lossless))
        return report_error(EXIT_MISUSED,
                            "--effort max cannot be combined with --max-error or --lossless");
    return EXIT_DONE;
}

/* The background value: found, given, or none. By default the encoder does not look for it in
 * volumes that will be multiplied: products of arrays without one are faster. */
static int choose_background(cvol_compress_options *options, const compress_arguments *a)
{
    char *end;
    const int is_skipped = !a->background && a->no_lap;
    int background = is_skipped ? CVOL_BACKGROUND_NONE : CVOL_BACKGROUND_FIND;
    if (!a->background || find_word(&background, &background_words, a->background)) {
        options->background = (cvol_background)background;
        return EXIT_DONE;
    }
    options->background = CVOL_BACKGROUND_VALUE;
    options->background_value = strtod(a->background, &end);
    if (end == a->background || *end || !isfinite(options->background_value))
        return report_error(EXIT_MISUSED, "--background is '%s', must be auto, none or a number",
                            a->background);
    const char *other = a->fill              ? "--fill"
                        : a->lossless        ? lossless_option(a)
                        : a->max_error_given ? "--max-error"
                        : a->stream          ? "--stream"
                                             : NULL;
    return other ? report_error(EXIT_MISUSED, "--background %s cannot be combined with %s",
                                a->background, other)
                 : EXIT_DONE;
}

int count_targets(const compress_arguments *a)
{
    const int bounded = a->psnr_given || a->max_error_given;
    return a->ratio_given + a->bits_given + bounded + (a->keep != NULL) + a->lossless;
}

/* The target of the options. EXIT_DONE, or EXIT_MISUSED after a message. */
static int choose_target(method *m, compress_arguments *a)
{
    m->options.target = a->psnr_given        ? CVOL_TARGET_PSNR
                        : a->max_error_given ? CVOL_TARGET_MAX_ERROR
                        : a->bits_given      ? CVOL_TARGET_BITS
                                             : CVOL_TARGET_RATIO;
    if (count_targets(a) > 1)
        return report_error(EXIT_MISUSED, "give only one of --ratio, --bpv, --psnr, --max-error, "
                                          "--lossless and --keep, or --psnr with --max-error");
    if (a->ratio_given && !(a->ratio > 1))
        return report_error(EXIT_MISUSED, "--ratio is %g, must be above 1", a->ratio);
    if (a->bits_given && !(a->bits > 0))
        return report_error(EXIT_MISUSED, "--bpv is %g, must be above 0", a->bits);
    if (a->psnr_given && !(a->psnr > 0 && a->psnr <= 200))
        return report_error(EXIT_MISUSED, "--psnr is %g dB, must be above 0 and at most 200",
                            a->psnr);
    if (a->max_error_given && !(a->max_error >= 0))
        return report_error(EXIT_MISUSED, "--max-error is %g, must not be negative", a->max_error);
    m->options.target_value = a->psnr_given        ? a->psnr
                              : a->max_error_given ? a->max_error
                              : a->bits_given      ? a->bits
                                                   : a->ratio;
    if (a->psnr_given && a->max_error_given)
        m->options.max_error = a->max_error;
    /* A maximum error of 0 is lossless, whatever the PSNR. */
    m->options.lossless = a->lossless || (a->max_error_given && a->max_error <= 0);
    m->options.least_psnr = a->force ? 0 : LEAST_PSNR;
    m->options.lapped = !a->no_lap;
    m->options.effort = a->effort;
    m->keep = a->psnr_given ? cvol_keep_psnr(a->psnr) : cvol_keep_ratio(a->ratio);
    return a->keep ? parse_keep(&m->keep, a->keep) : EXIT_DONE;
}

/* --labels yes is lossless, like --lossless. */
static int choose_labels(compress_arguments *a)
{
    if (parse_word(&a->labels, &labels_words, "--labels", a->labels_name))
        return EXIT_MISUSED;
    if (a->labels != LABELS_YES)
        return EXIT_DONE;
    if (count_targets(a) > a->lossless)
        return report_error(EXIT_MISUSED, "--labels yes is lossless: leave out the target");
    a->lossless = 1;
    return EXIT_DONE;
}

int choose_method(method *m, compress_arguments *a)
{
    m->options = cvol_compress_options_defaults();
    int status = choose_labels(a);
    if (!status)
        status = choose_effort(a);
    if (!status)
        status = choose_target(m, a);
    if (!status)
        status = choose_fill(&m->options, a);
    if (!status)
        status = choose_background(&m->options, a);
    if (!status)
        status = parse_bricks(m->options.brick, a->bricks);
    if (status)
        return status;
    m->options.block = m->block = a->block;
    if (a->block != 0 && a->block != 8 && a->block != 16 && a->block != 32)
        return report_error(EXIT_MISUSED, "--block is %d, must be 8, 16 or 32, or 0 for none",
                            a->block);
    int transform;
    if (parse_word(&transform, &transform_words, "--transform", a->transform))
        return EXIT_MISUSED;
    m->transform = (cvol_transform)transform;
    m->truncate = m->transform != CVOL_DCT || m->block == 0 || a->keep;
    const char *of_blocks = a->bits_given                                    ? "--bpv"
                            : a->max_error_given                             ? "--max-error"
                            : a->lossless                                    ? lossless_option(a)
                            : isnan(m->options.fill)                         ? "--fill nan"
                            : m->options.background == CVOL_BACKGROUND_VALUE ? "--background"
                            : a->bricks                                      ? "--bricks"
                                                                             : NULL;
    if (m->truncate && of_blocks)
        return report_error(EXIT_MISUSED,
                            "%s needs DCT blocks: leave out --transform, --block 0 and --keep",
                            of_blocks);
    return EXIT_DONE;
}

const char *option_against_streams(const compress_arguments *a, const method *m)
{
    const cvol_background background = m->options.background;
    return m->transform != CVOL_DCT             ? "--transform"
           : m->block != 16                     ? "--block"
           : a->keep                            ? "--keep"
           : a->max_error_given                 ? "--max-error"
           : m->options.lossless                ? lossless_option(a)
           : m->options.has_fill                ? "--fill"
           : !a->background                     ? NULL
           : background != CVOL_BACKGROUND_NONE ? "--background"
                                                : NULL;
}

int check_stream(const compress_arguments *a, const method *m)
{
    const char *other = a->stream ? option_against_streams(a, m) : NULL;
    const int by_processes = compressor_of_streams != cvol_compress_stream;
    return other ? report_error(EXIT_MISUSED,
                                "%s cannot be combined with %s: %s DCT blocks of 16 and --ratio, "
                                "--bpv or --psnr",
                                by_processes ? "cvol-mpi" : "--stream", other,
                                by_processes ? "use cvol compress, or" : "it needs")
                 : EXIT_DONE;
}
