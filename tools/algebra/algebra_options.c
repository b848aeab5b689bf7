/* Operands and results of the commands that compute on arrays. */
#include "tools/algebra/algebra_options.h"
#include <stdio.h>
#include <stdlib.h>

#include <math.h>
#include <string.h>

/* ---- options ----------------------------------------------------------------------------------
 */

int check_result_arguments(algebra_arguments *a)
{
    if (!a->output)
        return report_error(EXIT_MISUSED, "no result to write: give -o OUT.cvol");
    if (!has_ending(a->output, ".cvol"))
        return report_error(EXIT_MISUSED, "%s: the result's name must end in .cvol", a->output);
    int type = (int)a->result_type;
    if (a->result_type_name && parse_word(&type, &type_words, "--type", a->result_type_name))
        return EXIT_MISUSED;
    a->result_type = (cvol_type)type;
    if (!!a->keep_text + a->step_given + a->rms_given + a->all_terms > 1)
        return report_error(EXIT_MISUSED,
                            "give only one of --keep, --rms, --lossless-algebra and --step");
    a->keep_given = a->keep_text || a->step_given || a->rms_given || a->all_terms;
    if (a->keep_text)
        return parse_keep(&a->keep, a->keep_text);
    if (a->step_given && !(a->step > 0))
        return report_error(EXIT_MISUSED, "--step is %g, must be above 0", a->step);
    if (a->rms_given && !(a->rms > 0))
        return report_error(EXIT_MISUSED, "--rms is %g, must be above 0", a->rms);
    a->keep = a->all_terms ? cvol_keep_all() : cvol_keep_step(a->step);
    return EXIT_DONE;
}

const cvol_keep *chosen_keep(algebra_arguments *arguments, const cvol_array *shape)
{
    if (arguments->rms_given) {
        cvol_array_info info;
        cvol_array_get_info(&info, shape);
        const double loss = arguments->rms *
                            sqrt((double)(cvol_grid_samples(cvol_array_grid(shape)) -
                                          info.missing_samples));
        arguments->keep = info.block ? cvol_keep_loss(loss) : cvol_keep_l2(loss);
    }
    return arguments->keep_given ? &arguments->keep : NULL;
}

/* ---- operands ---------------------------------------------------------------------------------
 */

/* Opens a file as it is. `chosen`: its volume, if there is another operand, which may need the raw
 * options; a file with a header then ignores them. */
static int open_one(cvol_context *context, input *in, const char *path, common_options *common,
                    const cvol_read_options *chosen)
{
    common_options plain = *common;
    int has_header;
    if (find_has_header(context, &has_header, path))
        return EXIT_FAILED;
    const int raw = !has_header;
    if (raw && file_size(path) && (!common->read.dims[0] || !common->type_name))
        return report_error(EXIT_MISUSED, "%s: raw samples need --dims NXxNYxNZ and --raw-type",
                            path);
    int type;
    if (raw && common->type_name && parse_word(&type, &type_words, "--raw-type", common->type_name))
        return EXIT_MISUSED;
    if (!raw && chosen) {
        plain.read = cvol_read_options_defaults();
        plain.type_name = NULL;
    }
    if (chosen) {
        plain.read.has_index = chosen->has_index;
        plain.read.index = chosen->index;
        plain.read.has_channel = chosen->has_channel;
        plain.read.channel = chosen->channel;
    }
    return open_input(context, in, path, &plain);
}

/* 1 if arrays like this can have missing samples: volumes in DCT blocks. NULL: a new one. */
static int can_lack_samples(const cvol_array *like)
{
    cvol_array_info info;
    if (!like)
        return 1;
    cvol_array_get_info(&info, like);
    return info.rank == 3 && info.transform == CVOL_DCT && info.block;
}

/* Treats samples of a value far from all others, such as 1e35, as missing, as cvol compress does:
 * they would degrade all others. like: the other operand, or NULL. Exit status. */
static int find_mark(cvol_context *context, input *in, const char *path, const cvol_array *like)
{
    cvol_histogram histogram;
    int are_labels = 0;
    if (in->array)
        return EXIT_DONE;
    int code = cvol_volume_compute_histogram(context, &histogram, in->volume);
    if (!code && histogram.mark_count)
        code = cvol_volume_compute_is_labels(context, &are_labels, in->volume, path);
    if (code)
        return report_context_error(context, code, code == CVOL_ERROR_MEMORY ? path : NULL);
    if (!histogram.mark_count || are_labels)
        return EXIT_DONE;
    in->has_fill = can_lack_samples(like);
    in->fill = histogram.mark;
    clear_progress();
    fprintf(stderr,
            in->has_fill ? "cvol: %s: samples of %g, far from all others, are treated as missing; "
                           "cvol compress --fill nan keeps them as values\n"
                         : "cvol: %s: some samples are %g, far from all others, and degrade those; "
                           "only volumes in DCT blocks can have missing values\n",
            path, histogram.mark);
    return EXIT_DONE;
}

/* Compresses a dense operand like another array. */
static int compress_like(cvol_context *context, input *in, const char *path, const cvol_array *like)
{
    cvol_array_info info;
    cvol_array_get_info(&info, like);
    const cvol_keep keep = cvol_keep_ratio(30);
    if (can_lack_samples(like))
        return need_array(context, in, path, info.block, CVOL_BACKGROUND_NONE);
    int code = cvol_array_compress(context, &in->array, in->volume->data, &in->volume->grid,
                                   info.rank, info.transform, info.block, &keep);
    if (code)
        return report_context_error(context, code, path);
    clear_progress();
    fprintf(stderr,
            "cvol: %s: was compressed in memory first; run cvol compress once to avoid this step\n",
            path);
    return EXIT_DONE;
}

int open_operand(cvol_context *context, input *in, const char *path, algebra_arguments *arguments)
{
    int status = open_one(context, in, path, &arguments->common, NULL);
    if (!status)
        status = find_mark(context, in, path, NULL);
    if (status || arguments->takes_samples)
        return status;
    return need_array(context, in, path, 0, CVOL_BACKGROUND_NONE);
}

/* Compares shapes before it compresses anything. */
static int check_dims(const input in[2], const char *const paths[2])
{
    const size_t *m = input_grid(&in[0])->dims, *n = input_grid(&in[1])->dims;
    if (m[0] == n[0] && m[1] == n[1] && m[2] == n[2])
        return EXIT_DONE;
    return report_error(
        EXIT_FAILED,
        "%s and %s: dims are %zux%zux%zu in one array and %zux%zux%zu in the other; "
        "resample or crop one before compressing",
        paths[0], paths[1], m[0], m[1], m[2], n[0], n[1], n[2]);
}

/* The volume of each operand: --time and --channel choose it in those that hold several. */
static int choose_volumes(cvol_context *context, cvol_read_options chosen[2],
                          const char *const paths[2], const cvol_read_options *requested)
{
    for (int i = 0; i < 2; i++) {
        chosen[i] = cvol_read_options_defaults();
        if (requested->has_index || requested->has_channel)
            choose_of_several(context, &chosen[i], requested, paths[i]);
    }
    const int no_time = requested->has_index && !chosen[0].has_index && !chosen[1].has_index;
    const int no_channel = requested->has_channel && !chosen[0].has_channel &&
                           !chosen[1].has_channel;
    if (!no_time && !no_channel)
        return EXIT_DONE;
    const char *const what = no_time && no_channel ? "volume" : no_time ? "time" : "channel";
    const char *const options = no_time && no_channel ? "--time and --channel"
                                : no_time             ? "--time"
                                                      : "--channel";
    return report_error(EXIT_MISUSED, "%s and %s hold one %s each: leave out %s", paths[0],
                        paths[1], what, options);
}

int open_operands(cvol_context *context, input in[2], const char *const paths[2],
                  algebra_arguments *arguments)
{
    int have_headers[2], status = EXIT_DONE;
    for (int i = 0; i < 2 && !status; i++)
        status = find_has_header(context, &have_headers[i], paths[i]);
    if (status)
        return status;
    if (have_headers[0] && have_headers[1] && has_raw_options(&arguments->common))
        return report_error(
            EXIT_MISUSED,
            "%s and %s have headers: --dims, --raw-type and --big-endian are for raw samples, "
            "--spacing also for formats without it",
            paths[0], paths[1]);
    cvol_read_options chosen[2];
    status = choose_volumes(context, chosen, paths, &arguments->common.read);
    for (int i = 0; i < 2 && !status; i++)
        status = open_one(context, &in[i], paths[i], &arguments->common, &chosen[i]);
    if (!status)
        status = check_dims(in, paths);
    for (int i = 0; i < 2 && !status; i++)
        status = find_mark(context, &in[i], paths[i], in[1 - i].array);
    for (int i = 0; i < 2 && !status; i++)
        if (!in[i].array)
            status = in[1 - i].array
                         ? compress_like(context, &in[i], paths[i], in[1 - i].array)
                         : need_array(context, &in[i], paths[i], 0, CVOL_BACKGROUND_NONE);
    if (!status && cvol_array_compatible(context, in[0].array, in[1].array))
        status = report_error(EXIT_FAILED, "%s and %s: %s", paths[0], paths[1],
                              cvol_context_message(context));
    if (!status)
        note_places(paths, cvol_array_grid(in[0].array), cvol_array_grid(in[1].array));
    return status;
}

/* ---- results ----------------------------------------------------------------------------------
 */

int check_result_output(const algebra_arguments *arguments, const char *const paths[], int count)
{
    int status = EXIT_DONE;
    for (int i = 0; i < count && !status; i++)
        status = check_output(paths[i], arguments->output);
    return status;
}

static int report_result(const cvol_array *result, uint64_t file_bytes,
                         const algebra_arguments *arguments, json_t *more)
{
    cvol_array_info info;
    cvol_array_get_info(&info, result);
    const cvol_grid *grid = cvol_array_grid(result);
    const double ratio = (double)cvol_grid_bytes(grid) / (double)file_bytes;
    const double rms = rms_bound(&info, grid);
    char share[SHARE_TEXT];
    clear_progress();
    if (!arguments->common.json) {
        printf("%s: %zu x %zu x %zu, %llu terms, %llu bytes, %s; "
               "error bound: RMS <= %.3g (L2 %.4g), every sample <= %.3g\n",
               arguments->output, grid->dims[0], grid->dims[1], grid->dims[2],
               (unsigned long long)info.coefficients, (unsigned long long)file_bytes,
               share_text(share, ratio), rms, info.l2_error, info.point_error);
        return EXIT_DONE;
    }
    json_t *object = json_pack(
        "{s:o, s:o, s:s, s:i, s:s, s:i, s:I, s:I, s:f, s:o, s:o, s:o, s:o, s:o, s:o}", "output",
        json_text(arguments->output), "dims", json_dims(grid->dims), "type",
        cvol_type_name(grid->type), "rank", info.rank, "transform",
        cvol_transform_name(info.transform), "block", info.block, "terms",
        (json_int_t)info.coefficients, "file_bytes", (json_int_t)file_bytes, "ratio", ratio,
        "l2_error", json_number(info.l2_error), "rms_bound", json_number(rms), "point_error",
        json_number(info.point_error), "max_abs", json_number(info.max_abs), "value_min",
        json_number(info.value_min), "value_max", json_number(info.value_max));
    if (object && more)
        json_object_update(object, more);
    return print_json(object);
}

int finish_result(cvol_context *context, cvol_array *result, int code, const char *subject,
                  const algebra_arguments *arguments, json_t *more)
{
    uint64_t file_bytes = 0;
    int status = EXIT_DONE;
    if (code)
        status = report_context_error(context, code, subject);
    if (!status && arguments->result_type &&
        (code = cvol_array_set_type(context, result, arguments->result_type)))
        status = report_context_error(context, code, subject);
    if (!status && (code = cvol_array_write(context, result, arguments->output, &file_bytes)))
        status = report_context_error(context, code, NULL);
    if (!status)
        status = report_result(result, file_bytes, arguments, more);
    json_decref(more);
    cvol_array_free(result);
    return status;
}

void print_bounded(const char *name, double value, double error)
{
    char text[40];
    for (int digits = 8; digits <= 15; digits++) {
        snprintf(text, sizeof text, "%.*g", digits, value);
        if (fabs(strtod(text, NULL) - value) <= 0.05 * error)
            break;
    }
    printf("  %-20s %s  +- %.3g\n", name, text, error);
}
