/* cvol gradient: the length of the gradient of a compressed volume. */
#include "tools/algebra/algebra_options.h"

static const char description[] =
    "Computes the length of the gradient (central differences, per unit of spacing): large at\n"
    "edges, 0 where samples are constant.";

static const char examples[] = "  cvol gradient ct.cvol -o edges.cvol\n";

int command_gradient(int argc, char **argv)
{
    algebra_arguments a = {.common = COMMON_DEFAULTS};
    const option_spec specs[] = {
        RESULT_OPTIONS(a),
        KEEP_OPTIONS(a),
        RAW_OPERAND_OPTIONS(a.common),
        COMMON_OPTIONS(a.common),
    };
    command_line line = {.usage = "cvol gradient A -o OUT.cvol [options]",
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
    cvol_context *context = begin_command(&a.common);
    if (!context)
        return EXIT_FAILED;
    status = open_operand(context, &in, line.positionals[0], &a);
    if (!status) {
        int code = cvol_array_gradient(context, &result, in.array, chosen_keep(&a, in.array));
        status = finish_result(context, result, code, line.positionals[0], &a, NULL);
    }
    close_input(&in);
    return end_command(context, status);
}
