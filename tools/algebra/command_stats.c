/* cvol stats: sums, means and distances of compressed volumes, from their coefficients. */

#include <math.h>

#include "tools/algebra/algebra_options.h"

static const char description[] =
    "Prints sum, mean, variance, standard deviation and L2 norm of a volume, computed from\n"
    "its coefficients; after +- stands a certified bound of the difference from the value of\n"
    "the original samples. Values are those that the file states, such as Hounsfield units.\n"
    "Samples without a value do not count. With two volumes it also\n"
    "prints inner product, cosine similarity and L2 distance.";

static const char examples[] = "  cvol stats brain.cvol\n"
                               "  cvol stats before.cvol after.cvol --json\n";

static void print_line(const char *name, double value, double error)
{
    if (error >= 0)
        print_bounded(name, value, error);
    else
        printf("  %-20s %.8g\n", name, value);
}

static json_t *statistics_json(const cvol_array_statistics *s)
{
    return json_pack("{s:o, s:o, s:o, s:o, s:o, s:o, s:o, s:o, s:o}", "sum", json_number(s->sum),
                     "mean", json_number(s->mean), "variance", json_number(s->variance),
                     "standard_deviation", json_number(s->standard_deviation), "l2_norm",
                     json_number(s->l2_norm), "sum_error", json_number(s->sum_error), "mean_error",
                     json_number(s->mean_error), "standard_deviation_error",
                     json_number(s->standard_deviation_error), "l2_norm_error",
                     json_number(s->l2_norm_error));
}

static void print_statistics(const char *path, const cvol_array_statistics *s)
{
    printf("%s\n", path);
    print_line("sum", s->sum, s->sum_error);
    print_line("mean", s->mean, s->mean_error);
    print_line("variance", s->variance, -1);
    print_line("standard deviation", s->standard_deviation, s->standard_deviation_error);
    print_line("L2 norm", s->l2_norm, s->l2_norm_error);
}

/* 1 if samples mean other values than their own. */
static int is_rescaled(const cvol_grid *grid)
{
    return fabs(grid->value_scale - 1) > 0 || fabs(grid->value_offset) > 0;
}

/* Statistics of the values. */
static int compute_statistics(cvol_context *context, cvol_array_statistics *s,
                              const cvol_array *array)
{
    const cvol_grid *grid = cvol_array_grid(array);
    const double scale = grid->value_scale, factor = fabs(scale);
    const int code = cvol_array_compute_statistics(context, s, array);
    if (code || !is_rescaled(grid))
        return code;
    /* Samples that have a value. */
    const double square = s->variance + s->mean * s->mean;
    const double count = square > 0 ? round(s->l2_norm * s->l2_norm / square)
                                    : (double)cvol_grid_samples(grid);
    s->mean = scale * s->mean + grid->value_offset;
    s->sum = count * s->mean;
    s->variance *= scale * scale;
    s->standard_deviation *= factor;
    s->l2_norm = sqrt(count * (s->variance + s->mean * s->mean));
    s->sum_error *= factor;
    s->mean_error *= factor;
    s->standard_deviation_error *= factor;
    s->l2_norm_error *= factor;
    return code;
}

/* Compares the values. */
static int compare(cvol_context *context, cvol_array_comparison *c, const input in[2])
{
    const cvol_array *of[2] = {in[0].array, in[1].array};
    cvol_array *made[2] = {NULL, NULL};
    int code = CVOL_OK;
    for (int i = 0; i < 2 && !code; i++) {
        const cvol_grid *grid = cvol_array_grid(of[i]);
        if (!is_rescaled(grid))
            continue;
        code = cvol_array_scale(context, &made[i], grid->value_scale, of[i], grid->value_offset);
        of[i] = made[i];
    }
    if (!code)
        code = cvol_array_compare(context, c, of[0], of[1]);
    cvol_array_free(made[0]);
    cvol_array_free(made[1]);
    return code;
}

static int report_statistics(cvol_context *context, const input *in, const char *path, int json)
{
    cvol_array_statistics s;
    int code = compute_statistics(context, &s, in->array);
    if (code)
        return report_context_error(context, code, path);
    if (json)
        return print_json(statistics_json(&s));
    clear_progress();
    print_statistics(path, &s);
    return EXIT_DONE;
}

static int report_comparison(cvol_context *context, const input in[2], const char *const paths[2],
                             int json)
{
    cvol_array_statistics s[2];
    cvol_array_comparison c;
    int code = compare(context, &c, in);
    for (int i = 0; i < 2 && !code; i++)
        code = compute_statistics(context, &s[i], in[i].array);
    if (code)
        return report_context_error(context, code, NULL);
    if (json)
        return print_json(json_pack(
            "{s:o, s:o, s:o, s:o, s:o, s:o, s:o}", "a", statistics_json(&s[0]), "b",
            statistics_json(&s[1]), "inner_product", json_number(c.inner_product),
            "cosine_similarity", json_number(c.cosine_similarity), "distance",
            json_number(c.distance), "inner_product_error", json_number(c.inner_product_error),
            "distance_error", json_number(c.distance_error)));
    clear_progress();
    print_statistics(paths[0], &s[0]);
    print_statistics(paths[1], &s[1]);
    puts("both");
    print_line("inner product", c.inner_product, c.inner_product_error);
    print_line("cosine similarity", c.cosine_similarity, -1);
    print_line("distance", c.distance, c.distance_error);
    return EXIT_DONE;
}

int command_stats(int argc, char **argv)
{
    algebra_arguments a = {.common = COMMON_DEFAULTS};
    const option_spec specs[] = {
        RAW_OPERAND_OPTIONS(a.common),
        COMMON_OPTIONS(a.common),
    };
    command_line line = {.usage = "cvol stats A [B] [options]",
                         .description = description,
                         .examples = examples,
                         .options = specs,
                         .option_count = sizeof specs / sizeof *specs,
                         .positional_count = 2,
                         .optional_count = 1};
    input in[2] = {{0}, {0}};
    int status = parse_command_line(&line, argc, argv);
    if (status >= 0)
        return status;
    cvol_context *context = begin_command(&a.common);
    if (!context)
        return EXIT_FAILED;
    if (line.positionals[1]) {
        status = open_operands(context, in, line.positionals, &a);
        if (!status)
            status = report_comparison(context, in, line.positionals, a.common.json);
    } else {
        status = open_operand(context, &in[0], line.positionals[0], &a);
        if (!status)
            status = report_statistics(context, &in[0], line.positionals[0], a.common.json);
    }
    close_input(&in[0]);
    close_input(&in[1]);
    return end_command(context, status);
}
