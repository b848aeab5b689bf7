/* cvol multiply: the product of two compressed volumes, sample by sample. */
#include <math.h>
#include <string.h>

#include "tools/algebra/algebra_options.h"

static const char description[] =
    "Computes A B, sample by sample: a mask times a volume, for example. The result has a\n"
    "certified bound of its distance from the product of the original samples. A and B must\n"
    "have the same shape, spacing, transform and block size. An operand that is not\n"
    "compressed is compressed first, at ratio 30. Whole arrays (block 0) are multiplied by\n"
    "the cheapest of several plans; --explain prints which.";

static const char examples[] = "  cvol multiply scan.cvol mask.cvol -o masked.cvol\n"
                               "  cvol multiply a.cvol b.cvol -o ab.cvol --explain\n";

static json_t *plan_json(const cvol_multiply_report *report)
{
    json_t *costs = json_object();
    for (size_t i = 0; i < plan_words.count && costs; i++)
        if (plan_words.words[i].value != CVOL_PLAN_AUTO)
            json_object_set_new(costs, plan_words.words[i].word,
                                json_number(report->cost_ms[plan_words.words[i].value]));
    return json_pack("{s:s, s:o, s:o, s:o, s:b, s:f, s:I, s:I}", "plan",
                     word_of(&plan_words, (int)report->plan), "reason", json_text(report->reason),
                     "cost_ms", costs, "points", json_dims(report->points), "sparse_failed",
                     report->sparse_failed, "left_out", report->left_out, "terms_a",
                     (json_int_t)report->terms_a, "terms_b", (json_int_t)report->terms_b);
}

static void explain(const cvol_multiply_report *report)
{
    clear_progress();
    printf("plan %s: %s\n", word_of(&plan_words, (int)report->plan), report->reason);
    printf("terms: %llu times %llu gave %llu\n", (unsigned long long)report->terms_a,
           (unsigned long long)report->terms_b, (unsigned long long)report->terms_out);
    for (size_t i = 0; i < plan_words.count; i++) {
        const word_value *plan = &plan_words.words[i];
        if (plan->value != CVOL_PLAN_AUTO && isfinite(report->cost_ms[plan->value]))
            printf("  %-8s %10.3f ms estimated, on one thread\n", plan->word,
                   report->cost_ms[plan->value]);
    }
    if (report->plan == CVOL_PLAN_GRID || report->plan == CVOL_PLAN_FULL ||
        report->plan == CVOL_PLAN_LOW)
        printf("evaluated at %zu x %zu x %zu points\n", report->points[0], report->points[1],
               report->points[2]);
    if (report->plan == CVOL_PLAN_LOW)
        printf("the terms left out change the product by at most %.4g (L2 norm)\n",
               report->left_out);
    if (report->sparse_failed)
        puts("(the sparse plan was tried; its result failed verification)");
}

int command_multiply(int argc, char **argv)
{
    algebra_arguments a = {.common = COMMON_DEFAULTS};
    const char *plan_name = "auto";
    int explained = 0;
    const option_spec specs[] = {
        RESULT_OPTIONS(a),
        {"--plan", "PLAN",
         "method: auto (default), blocks; of whole arrays: direct, grid, full, sparse or low",
         OPTION_TEXT, &plan_name, 0, NULL},
        {"--explain", NULL, "print the chosen plan and the reason", OPTION_FLAG, &explained, 0,
         NULL},
        KEEP_OPTIONS(a),
        RAW_OPERAND_OPTIONS(a.common),
        COMMON_OPTIONS(a.common),
    };
    command_line line = {.usage = "cvol multiply A B -o OUT.cvol [options]",
                         .description = description,
                         .examples = examples,
                         .options = specs,
                         .option_count = sizeof specs / sizeof *specs,
                         .positional_count = 2};
    input in[2] = {{0}, {0}};
    int plan = CVOL_PLAN_AUTO;
    cvol_array *result = NULL;
    cvol_multiply_report report;
    memset(&report, 0, sizeof report);
    int status = parse_command_line(&line, argc, argv);
    if (status >= 0 || (status = check_result_arguments(&a)) ||
        (status = parse_word(&plan, &plan_words, "--plan", plan_name)) ||
        (status = check_result_output(&a, line.positionals, 2)))
        return status;
    cvol_context *context = begin_command(&a.common);
    if (!context)
        return EXIT_FAILED;
    status = open_operands(context, in, line.positionals, &a);
    if (!status) {
        int code = cvol_array_multiply(context, &result, in[0].array, in[1].array,
                                       chosen_keep(&a, in[0].array), (cvol_plan)plan, &report);
        status = finish_result(context, result, code, NULL, &a,
                               code || !a.common.json ? NULL : plan_json(&report));
    }
    if (!status && explained && !a.common.json)
        explain(&report);
    close_input(&in[0]);
    close_input(&in[1]);
    return end_command(context, status);
}
