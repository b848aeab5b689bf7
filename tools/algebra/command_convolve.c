/* cvol convolve: the convolution of a compressed volume with a small filter, or with another
 * compressed volume. */
#include <string.h>

#include "tools/algebra/algebra_options.h"

static const char description[] =
    "Convolves a volume with a small filter, on coefficients; the result is exact across the\n"
    "faces of blocks. The radius of the filter is at most one block. A FILE (its name ends in\n"
    ".json) holds one line of taps for all axes, an odd number, symmetric or antisymmetric:\n"
    "{\"taps\": [1, 2, 1]}. A FILE that ends in .cvol is a volume of the same shape: the\n"
    "convolution is circular then, of whole arrays (block 0) under dft or dht.";

static const char examples[] = "  cvol convolve a.cvol -o smooth.cvol --kernel gaussian:1.5\n"
                               "  cvol convolve a.cvol -o sharp.cvol --kernel unsharp:1.5,0.7\n"
                               "  cvol convolve a.cvol -o edges.cvol --kernel derivative:x\n"
                               "  cvol convolve a.cvol -o spread.cvol --kernel b.cvol\n";

static int fail_file(const char *path, const char *what)
{
    return report_error(EXIT_FAILED, "%s: %s", path, what);
}

/* Copies the numbers of "taps" into taps[] and sets *radius. */
static int take_taps(double taps[2 * CVOL_KERNEL_RADIUS + 1], int *radius, const json_t *root,
                     const char *path)
{
    const json_t *list = json_object_get(root, "taps");
    const size_t count = json_array_size(list);
    if (!json_is_array(list))
        return fail_file(path, "has no list \"taps\": [...]");
    if (count % 2 == 0 || count > 2 * CVOL_KERNEL_RADIUS + 1)
        return report_error(EXIT_FAILED, "%s: has %zu taps, must have an odd number, at most %d",
                            path, count, 2 * CVOL_KERNEL_RADIUS + 1);
    for (size_t i = 0; i < count; i++) {
        const json_t *tap = json_array_get(list, i);
        if (!json_is_number(tap))
            return report_error(EXIT_FAILED, "%s: tap %zu is not a number", path, i);
        taps[i] = json_number_value(tap);
    }
    *radius = (int)(count / 2);
    return EXIT_DONE;
}

static int read_kernel(cvol_context *context, cvol_kernel *kernel, int rank, const char *path)
{
    double taps[2 * CVOL_KERNEL_RADIUS + 1];
    int radius = 0;
    json_error_t error;
    char *text = read_text(path);
    if (!text)
        return EXIT_FAILED;
    json_t *root = json_loads(text, JSON_REJECT_DUPLICATES, &error);
    free(text);
    if (!root && json_lacks_memory())
        return fail_file(path, "not enough memory");
    if (!root)
        return report_error(EXIT_FAILED, "%s: line %d: %s", path, error.line, error.text);
    int status = take_taps(taps, &radius, root, path);
    json_decref(root);
    if (!status && cvol_kernel_taps(context, kernel, rank, taps, radius))
        status = fail_file(path, cvol_context_message(context));
    return status;
}

static int make_kernel(cvol_context *context, cvol_kernel *kernel, const cvol_array *array,
                       const char *text)
{
    cvol_array_info info;
    cvol_array_get_info(&info, array);
    if (has_ending(text, ".json"))
        return read_kernel(context, kernel, info.rank, text);
    int code = cvol_kernel_parse(context, kernel, info.rank, text);
    return code ? report_context_error(context, code, "--kernel") : EXIT_DONE;
}

/* The filter of --kernel, or the volume in[1]. */
static int convolve(cvol_context *context, cvol_array **result, const input in[2],
                    const cvol_kernel *kernel, const cvol_keep *keep)
{
    if (in[1].array)
        return cvol_array_convolve(context, result, in[0].array, in[1].array, keep);
    return cvol_array_convolve_kernel(context, result, in[0].array, kernel, keep);
}

int command_convolve(int argc, char **argv)
{
    algebra_arguments a = {.common = COMMON_DEFAULTS};
    const char *text = NULL;
    const option_spec specs[] = {
        RESULT_OPTIONS(a),
        {"--kernel", "KERNEL",
         "gaussian:SIGMA box:WIDTH laplacian unsharp:SIGMA[,AMOUNT] derivative:x, or FILE "
         "(required)",
         OPTION_TEXT, &text, 0, NULL},
        KEEP_OPTIONS(a),
        RAW_OPERAND_OPTIONS(a.common),
        COMMON_OPTIONS(a.common),
    };
    command_line line = {.usage = "cvol convolve A --kernel KERNEL -o OUT.cvol [options]",
                         .description = description,
                         .examples = examples,
                         .options = specs,
                         .option_count = sizeof specs / sizeof *specs,
                         .positional_count = 1};
    input in[2] = {{0}, {0}};
    cvol_kernel kernel;
    cvol_array *result = NULL;
    int status = parse_command_line(&line, argc, argv);
    if (status >= 0 || (status = check_result_arguments(&a)) ||
        (status = check_result_output(&a, line.positionals, 1)))
        return status;
    if (!text)
        return report_error(EXIT_MISUSED, "no filter: give --kernel, as in --kernel gaussian:1.5");
    const int other = has_ending(text, ".cvol");
    const char *paths[2] = {line.positionals[0], text};
    if (other && (status = check_result_output(&a, paths, 2)))
        return status;
    cvol_context *context = begin_command(&a.common);
    if (!context)
        return EXIT_FAILED;
    memset(&kernel, 0, sizeof kernel);
    status = other ? open_operands(context, in, paths, &a)
                   : open_operand(context, &in[0], paths[0], &a);
    if (!status && !other)
        status = make_kernel(context, &kernel, in[0].array, text);
    if (!status) {
        int code = convolve(context, &result, in, &kernel, chosen_keep(&a, in[0].array));
        status = finish_result(context, result, code, other ? NULL : paths[0], &a, NULL);
    }
    close_input(&in[0]);
    close_input(&in[1]);
    return end_command(context, status);
}
