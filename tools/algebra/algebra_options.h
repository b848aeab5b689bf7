/* Options, operands and results of the commands that compute on arrays. */
#ifndef CVOL_TOOLS_ALGEBRA_OPTIONS_H
#define CVOL_TOOLS_ALGEBRA_OPTIONS_H

#include "tools/base/cli.h"

typedef struct algebra_arguments {
    common_options common;
    const char *output, *result_type_name, *keep_text;
    double step, rms;
    int step_given, rms_given, all_terms;
    /* from the texts, by check_result_arguments */
    cvol_type result_type;
    cvol_keep keep;
    int keep_given;
    int takes_samples; /* open_operand leaves a volume that is not compressed as it is */
} algebra_arguments;

/* Like INPUT_OPTIONS. Here --type is the type of the result; --time and --channel choose from
 * operands with several volumes. */
#define RAW_OPERAND_OPTIONS(c)                                                         \
    RAW_OPTIONS(c, "Operands that are raw samples (x fastest):", "--raw-type"),        \
        {NULL, NULL, "Operands with several volumes:", OPTION_HEADING, NULL, 0, NULL}, \
        PLACE_OPTIONS(c)

#define RESULT_OPTIONS(a)                                                             \
    {"-o", "OUT.cvol", "the result (required)", OPTION_TEXT, &(a).output, 0, NULL},   \
    {                                                                                 \
        "--type", "TYPE", "sample type of the result (default float32)", OPTION_TEXT, \
            &(a).result_type_name, 0, NULL                                            \
    }

#define KEEP_OPTIONS(a)                                                                          \
    {NULL,                                                                                       \
     NULL,                                                                                       \
     "Truncation of the result (default: a fifth of the bound that the operands carry):",        \
     OPTION_HEADING,                                                                             \
     NULL,                                                                                       \
     0,                                                                                          \
     NULL},                                                                                      \
        {"--keep",    "K,S",          "keep the K lowest frequencies of each axis and S others", \
         OPTION_TEXT, &(a).keep_text, 0,                                                         \
         NULL},                                                                                  \
        {"--rms",       "E",      "lose at most E per sample (root mean square)",                \
         OPTION_NUMBER, &(a).rms, 0,                                                             \
         &(a).rms_given},                                                                        \
        {"--lossless-algebra",                                                                   \
         NULL,                                                                                   \
         "lose nothing but rounding: the result may be large",                                   \
         OPTION_FLAG,                                                                            \
         &(a).all_terms,                                                                         \
         0,                                                                                      \
         NULL},                                                                                  \
    {                                                                                            \
        "--step", "STEP", "arrays in blocks: quantize with this step", OPTION_NUMBER, &(a).step, \
            0, &(a).step_given                                                                   \
    }

/* Checks output, type and keep before any work. Exit status. */
int check_result_arguments(algebra_arguments *arguments);
/* The rule that the options choose for a result of this shape; NULL: none does. */
const cvol_keep *chosen_keep(algebra_arguments *arguments, const cvol_array *shape);

/* Opens one operand, and compresses it if it is dense. Exit status. */
int open_operand(cvol_context *context, input *in, const char *path, algebra_arguments *arguments);
/* Opens two operands and compresses a dense one like the other. Refuses arrays that are not
 * compatible. */
int open_operands(cvol_context *context, input in[2], const char *const paths[2],
                  algebra_arguments *arguments);

/* Prints a line with a figure and its bound, with so many digits that rounding it is far below the
 * bound. */
void print_bounded(const char *name, double value, double error);

/* Checks the output against `count` inputs: see check_output. */
int check_result_output(const algebra_arguments *arguments, const char *const paths[], int count);
/* Gives the result its type, writes it and reports it. `more`: further fields of the JSON object,
 * or NULL; the function frees it. `code`: what the operation returned; if it failed, the function
 * only reports that. Exit status. */
int finish_result(cvol_context *context, cvol_array *result, int code, const char *subject,
                  const algebra_arguments *arguments, json_t *more);

#endif
