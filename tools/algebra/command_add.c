/* cvol add: alpha a + beta b of compressed volumes. */
#include "tools/algebra/algebra_options.h"

static const char description[] =
    "Computes X A + Y B, sample by sample, without decompressing. The result has a certified\n"
    "bound of its distance from the same sum of the original samples. A and B must have the\n"
    "same shape, spacing, transform and block size. An operand that is not compressed is\n"
    "compressed first, at ratio 30.";

static const char examples[] = "  cvol add a.cvol b.cvol -o sum.cvol\n"
                               "  cvol add after.cvol before.cvol -o change.cvol --beta -1\n";

int command_add(int argc, char **argv)
{
    algebra_arguments a = {.common = COMMON_DEFAULTS};
    double alpha = 1, beta = 1;
    const option_spec specs[] = {
        RESULT_OPTIONS(a),
        {"--alpha", "X", "factor of A (default 1)", OPTION_NUMBER, &alpha, 0, NULL},
        {"--beta", "Y", "factor of B (default 1)", OPTION_NUMBER, &beta, 0, NULL},
        KEEP_OPTIONS(a),
        RAW_OPERAND_OPTIONS(a.common),
        COMMON_OPTIONS(a.common),
    };
    command_line line = {.usage = "cvol add A B -o OUT.cvol [options]",
                         .description = description,
                         .examples = examples,
                         .options = specs,
                         .option_count = sizeof specs / sizeof *specs,
                         .positional_count = 2};
    input in[2] = {{0}, {0}};
    cvol_array *result = NULL;
    int status = parse_command_line(&line, argc, argv);
    if (status >= 0 || (status = check_result_arguments(&a)) ||
        (status = check_result_output(&a, line.positionals, 2)))
        return status;
    cvol_context *context = begin_command(&a.common);
    if (!context)
        return EXIT_FAILED;
    status = open_operands(context, in, line.positionals, &a);
    if (!status) {
        int code = cvol_array_add(context, &result, alpha, in[0].array, beta, in[1].array,
                                  chosen_keep(&a, in[0].array));
        status = finish_result(context, result, code, NULL, &a, NULL);
    }
    close_input(&in[0]);
    close_input(&in[1]);
    return end_command(context, status);
}
