/* cvol scale: factor a + offset of a compressed volume. */
#include "tools/algebra/algebra_options.h"

static const char description[] =
    "Computes X A + Y, sample by sample, without decompressing. The error of A is multiplied\n"
    "by X; rounding adds to it, and for lossless files a step of about a 1024th of their range.";

static const char examples[] = "  cvol scale a.cvol -o half.cvol --factor 0.5\n"
                               "  cvol scale a.cvol -o negative.cvol --factor -1 --offset 255\n";

int command_scale(int argc, char **argv)
{
    algebra_arguments a = {.common = COMMON_DEFAULTS};
    double factor = 1, offset = 0;
    int factor_given = 0, offset_given = 0;
    const option_spec specs[] = {
        RESULT_OPTIONS(a),
        {"--factor", "X", "factor of every value (default 1)", OPTION_NUMBER, &factor, 0,
         &factor_given},
        {"--offset", "Y", "number to add to every value (default 0)", OPTION_NUMBER, &offset, 0,
         &offset_given},
        RAW_OPERAND_OPTIONS(a.common),
        COMMON_OPTIONS(a.common),
    };
    command_line line = {.usage = "cvol scale A -o OUT.cvol --factor X [options]",
                         .description = description,
                         .examples = examples,
                         .options = specs,
                         .option_count = sizeof specs / sizeof *specs,
                         .positional_count = 1};
    input in = {0};
    cvol_array *result = NULL;
    int status = parse_command_line(&line, argc, argv);
    if (status >= 0 || (status = check_result_arguments(&a)) ||
        (status = check_result_output(&a, line.positionals, 1)))
        return status;
    if (!factor_given && !offset_given)
        return report_error(EXIT_MISUSED, "nothing to do: give --factor, --offset or both");
    cvol_context *context = begin_command(&a.common);
    if (!context)
        return EXIT_FAILED;
    status = open_operand(context, &in, line.positionals[0], &a);
    if (!status) {
        /* The constant is added to values, the library adds to stored samples. */
        const double per_sample = cvol_array_grid(in.array)->value_scale;
        int code = cvol_array_scale(context, &result, factor, in.array, offset / per_sample);
        status = finish_result(context, result, code, line.positionals[0], &a, NULL);
    }
    close_input(&in);
    return end_command(context, status);
}
