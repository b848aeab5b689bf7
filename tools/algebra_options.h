/* What the commands that compute on arrays share: their options, operands and results. */
#ifndef CVOL_TOOLS_ALGEBRA_OPTIONS_H
#define CVOL_TOOLS_ALGEBRA_OPTIONS_H

#include "cli.h"

typedef struct algebra_arguments {
    common_options common;
    const char *output, *result_type_name, *keep_text;
    double step;
    int step_given;
    /* from the texts, by check_result_arguments */
    cvol_type result_type;
    cvol_keep keep;
    int keep_given;
} algebra_arguments;

/* As INPUT_OPTIONS: --type is the result's here, and --time and --channel are of operands that are
 * .cvol files of many volumes. */
#define RAW_OPERAND_OPTIONS(c)                                                            \
    RAW_OPTIONS(c, "Operands of raw samples (x fastest):", "--raw-type"),                 \
        {NULL, NULL, "Operands of many volumes (.cvol):", OPTION_HEADING, NULL, 0, NULL}, \
        PLACE_OPTIONS(c)

#define RESULT_OPTIONS(a)                                                         \
    {"-o", "OUT.cvol", "the result (needed)", OPTION_TEXT, &(a).output, 0, NULL}, \
    {                                                                             \
        "--type", "TYPE", "the result's samples (default float32)", OPTION_TEXT,  \
            &(a).result_type_name, 0, NULL                                        \
    }

#define KEEP_OPTIONS(a)                                                                      \
    {NULL, NULL, "What is kept (default: as coarse as the operands):", OPTION_HEADING, NULL, \
     0,    NULL},                                                                            \
        {"--keep",    "K,S",          "the K lowest frequencies of each axis, S others",     \
         OPTION_TEXT, &(a).keep_text, 0,                                                     \
         NULL},                                                                              \
    {                                                                                        \
        "--step", "STEP", "in blocks: multiples of STEP", OPTION_NUMBER, &(a).step, 0,       \
            &(a).step_given                                                                  \
    }

/* Checks output, type and keep before any work. Exit status. */
int check_result_arguments(algebra_arguments *arguments);
/* What --keep or --step ask for; NULL: neither was given. */
const cvol_keep *chosen_keep(const algebra_arguments *arguments);

/* Opens one operand, and compresses it if it is dense. Exit status. */
int open_operand(cvol_context *context, input *in, const char *path, algebra_arguments *arguments);
/* Opens two; a dense one is compressed as the other is. Refuses such as do not agree. */
int open_operands(cvol_context *context, input in[2], const char *const paths[2],
                  algebra_arguments *arguments);

/* Checks the output against `count` inputs: see check_output. */
int check_result_output(const algebra_arguments *arguments, const char *const paths[], int count);
/* Gives the result its type, writes it and tells about it; `more` (may be NULL, is taken) are
 * further fields of the JSON object. `code` is of the operation: where it failed, that is told.
 * Exit status. */
int finish_result(cvol_context *context, cvol_array *result, int code, const char *subject,
                  const algebra_arguments *arguments, json_t *more);

#endif
