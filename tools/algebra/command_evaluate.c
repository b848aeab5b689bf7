/* cvol evaluate: values of a compressed volume between its samples. */
#include <errno.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "tools/algebra/algebra_options.h"

static const char description[] =
    "Evaluates a volume between its samples: as the sum of its functions, without decompressing\n"
    "it. -o writes a new grid of samples; --points prints the values at single points. Places\n"
    "count in samples: sample i lies at i, and the volume reaches from -1/2 to N - 1/2. Whole\n"
    "arrays under dft and dht repeat beyond that. Of files made by --lossless or --max-error,\n"
    "values at samples are not exact.";

static const char examples[] = "  cvol evaluate ct.cvol -o fine.nii --count 512x512x400\n"
                               "  cvol evaluate ct.cvol -o part.nrrd --start 80,95.5,40 --step "
                               "0.25,0.25,0.25 --count 200x200x1\n"
                               "  echo 90.5 108 90 | cvol evaluate brain.cvol --points -\n";

typedef struct evaluate_arguments {
    algebra_arguments operand;
    const char *output, *points;
    double start[3], step[3];
    int start_given, step_given;
    size_t count[3];
} evaluate_arguments;

static int check_arguments(const evaluate_arguments *a)
{
    if (!a->output == !a->points)
        return report_error(EXIT_MISUSED, "give either -o OUT or --points FILE");
    if (a->points && (a->count[0] || a->start_given || a->step_given))
        return report_error(EXIT_MISUSED, "--start, --step and --count are for -o OUT");
    if (a->output && !a->count[0])
        return report_error(EXIT_MISUSED, "-o OUT needs --count NXxNYxNZ");
    for (int i = 0; i < 3; i++)
        if (a->step_given && !(a->step[i] > 0))
            return report_error(EXIT_MISUSED, "--step is %g along %c, must be above 0", a->step[i],
                                "xyz"[i]);
    return EXIT_DONE;
}

/* 1 if the place is within the volume, or if the volume repeats. */
static int is_inside(const cvol_array_info *info, const cvol_grid *grid, int axis, double at)
{
    return info->transform != CVOL_DCT || (at >= -0.5 && at <= (double)grid->dims[axis] - 0.5);
}

static int refuse_outside(const char *path, const char *what, const cvol_grid *grid, int axis,
                          double at)
{
    return report_error(EXIT_FAILED, "%s: %s at %c = %g, outside of -0.5 to %g", path, what,
                        "xyz"[axis], at, (double)grid -> dims[axis] - 0.5);
}

/* ---- a new grid ------------------------------------------------------------------------------ */

/* Sets start and step to those given, or to the centres of equal cells that fill the volume. Exit
 * status. */
static int choose_places(evaluate_arguments *a, const cvol_array_info *info, const cvol_grid *grid,
                         const char *path)
{
    for (int i = 0; i < 3; i++) {
        const double share = (double)grid->dims[i] / (double)a->count[i];
        a->step[i] = a->step_given ? a->step[i] : share;
        a->start[i] = a->start_given ? a->start[i] : a->step_given ? 0 : (share - 1) / 2;
        const double last = a->start[i] + (double)(a->count[i] - 1) * a->step[i];
        if (!is_inside(info, grid, i, a->start[i]))
            return refuse_outside(path, "the first place is", grid, i, a->start[i]);
        if (!is_inside(info, grid, i, last * (1 - 1e-12)))
            return refuse_outside(path, "the last place is", grid, i, last);
    }
    return EXIT_DONE;
}

static cvol_grid place_grid(const cvol_grid *grid, const evaluate_arguments *a)
{
    cvol_grid out = *grid;
    out.type = CVOL_FLOAT32;
    for (int i = 0; i < 3; i++) {
        out.dims[i] = a->count[i];
        out.spacing[i] = grid->spacing[i] * a->step[i];
        for (int b = 0; b < 3; b++)
            out.origin[b] += a->start[i] * grid->spacing[i] * grid->direction[i][b];
    }
    return out;
}

/* Arrays in blocks: a layer of points at a time. */
static int evaluate_layers(cvol_context *context, float *samples, const cvol_array *array, int rank,
                           const evaluate_arguments *a)
{
    const size_t layer = a->count[0] * a->count[1];
    double *points = malloc(layer * (size_t)rank * sizeof *points);
    int code = CVOL_OK;
    if (!points)
        return CVOL_ERROR_MEMORY;
    for (size_t z = 0; z < a->count[2] && !code; z++) {
        for (size_t i = 0; i < layer; i++) {
            const size_t at[3] = {i % a->count[0], i / a->count[0], z};
            for (int axis = 0; axis < rank; axis++)
                points[(size_t)rank * i + (size_t)axis] = a->start[axis] +
                                                          (double)at[axis] * a->step[axis];
        }
        code = cvol_array_evaluate_points(context, samples + z * layer, array, points, layer);
    }
    free(points);
    return code;
}

static int write_grid(cvol_context *context, const input *in, const cvol_array_info *info,
                      const evaluate_arguments *a, const char *path)
{
    const cvol_grid grid = place_grid(input_grid(in), a);
    cvol_volume *volume;
    int code = cvol_volume_create(context, &volume, &grid);
    if (!code && info->block)
        code = evaluate_layers(context, volume->data, in->array, info->rank, a);
    else if (!code)
        code = cvol_array_evaluate_chirp(context, volume->data, in->array, a->start, a->step,
                                         a->count);
    if (code) {
        cvol_volume_free(volume);
        return report_context_error(context, code, path);
    }
    code = cvol_volume_write(context, volume, a->output);
    cvol_volume_free(volume);
    if (code)
        return report_context_error(context, code, NULL);
    if (a->operand.common.json)
        return print_json(json_pack("{s:o, s:o, s:o, s:o}", "output", json_text(a->output), "dims",
                                    json_dims(grid.dims), "start", json_triple(a->start), "step",
                                    json_triple(a->step)));
    clear_progress();
    printf("%s: %zu x %zu x %zu samples of float32\n", a->output, grid.dims[0], grid.dims[1],
           grid.dims[2]);
    return EXIT_DONE;
}

/* ---- single points --------------------------------------------------------------------------- */

typedef struct point_list {
    double *places; /* rank numbers each */
    size_t count, room;
} point_list;

/* Adds the numbers of a line. Exit status. */
static int add_point(point_list *list, char *line, const cvol_array_info *info,
                     const cvol_grid *grid, size_t number, const char *name)
{
    const int rank = info->rank;
    char *at = line;
    if (list->count == list->room) {
        const size_t room = list->room ? 2 * list->room : 256;
        double *more = realloc(list->places, room * (size_t)rank * sizeof *more);
        if (!more)
            return report_error(EXIT_FAILED, "%s: not enough memory for its points", name);
        list->places = more;
        list->room = room;
    }
    for (int axis = 0; axis < rank; axis++) {
        char *end;
        const double place = strtod(at, &end);
        if (end == at || !isfinite(place))
            return report_error(EXIT_FAILED, "%s: line %zu must have %d numbers", name, number,
                                rank);
        char what[40];
        snprintf(what, sizeof what, "line %zu is", number);
        if (!is_inside(info, grid, axis, place))
            return refuse_outside(name, what, grid, axis, place);
        list->places[(size_t)rank * list->count + (size_t)axis] = place;
        at = end + strspn(end, " \t,;");
    }
    if (at[strspn(at, " \t\r\n")])
        return report_error(EXIT_FAILED, "%s: line %zu has more than %d numbers", name, number,
                            rank);
    list->count++;
    return EXIT_DONE;
}

/* Reads a line a point; empty lines and those that begin with # do not count. Exit status. */
static int read_points(point_list *list, const char *path, const cvol_array_info *info,
                       const cvol_grid *grid)
{
    const int is_input = strcmp(path, "-") == 0;
    FILE *file = is_input ? stdin : fopen(path, "r");
    const char *name = is_input ? "standard input" : path;
    char line[512];
    int status = EXIT_DONE;
    if (!file)
        return report_error(EXIT_FAILED, "%s: cannot be opened: %s", path, strerror(errno));
    for (size_t number = 1; !status && fgets(line, sizeof line, file); number++) {
        const char first = line[strspn(line, " \t\r\n")];
        if (!strchr(line, '\n') && strlen(line) == sizeof line - 1)
            status = report_error(EXIT_FAILED, "%s: line %zu is longer than %zu bytes", name,
                                  number, sizeof line - 2);
        else if (first && first != '#')
            status = add_point(list, line, info, grid, number, name);
    }
    if (!status && ferror(file))
        status = report_error(EXIT_FAILED, "%s: cannot be read", name);
    if (!is_input)
        fclose(file);
    return status;
}

static int print_values(const point_list *list, const float *values, const cvol_grid *grid,
                        int rank, int json)
{
    json_t *array = json ? json_array() : NULL;
    for (size_t i = 0; i < list->count; i++) {
        const double value = grid->value_scale * (double)values[i] + grid->value_offset;
        if (json) {
            json_array_append_new(array, json_number(value));
            continue;
        }
        for (int axis = 0; axis < rank; axis++)
            printf("%.10g ", list->places[(size_t)rank * i + (size_t)axis]);
        printf("%.8g\n", value);
    }
    return json ? print_json(json_pack("{s:o}", "values", array)) : EXIT_DONE;
}

static int evaluate_list(cvol_context *context, const input *in, const cvol_array_info *info,
                         const evaluate_arguments *a, const char *path)
{
    const cvol_grid *grid = input_grid(in);
    point_list list = {0};
    int status = read_points(&list, a->points, info, grid);
    float *values = malloc((list.count + 1) * sizeof *values);
    if (!status && !values)
        status = report_error(EXIT_FAILED, "%s: not enough memory for values", path);
    if (!status && list.count) {
        const int code = cvol_array_evaluate_points(context, values, in->array, list.places,
                                                    list.count);
        if (code)
            status = report_context_error(context, code, path);
    }
    clear_progress();
    if (!status)
        status = print_values(&list, values, grid, info->rank, a->operand.common.json);
    free(values);
    free(list.places);
    return status;
}

int command_evaluate(int argc, char **argv)
{
    evaluate_arguments a = {.operand = {.common = COMMON_DEFAULTS}};
    const option_spec specs[] = {
        {"-o", "OUT", "write a grid of samples, float32: .nii, .nrrd, .npy and others", OPTION_TEXT,
         &a.output, 0, NULL},
        {"--count", "NXxNYxNZ", "number of places of the grid along each axis", OPTION_DIMS,
         a.count, 0, NULL},
        {"--start", "X,Y,Z", "first place, in samples (default: the grid fills the volume)",
         OPTION_NUMBERS3, a.start, 0, &a.start_given},
        {"--step", "X,Y,Z", "distance of places, in samples (default: the same)", OPTION_NUMBERS3,
         a.step, 0, &a.step_given},
        {"--points", "FILE", "print values at the points of a text: X Y Z on a line; -: from input",
         OPTION_TEXT, &a.points, 0, NULL},
        RAW_OPERAND_OPTIONS(a.operand.common),
        COMMON_OPTIONS(a.operand.common),
    };
    command_line line = {.usage = "cvol evaluate A -o OUT --count NXxNYxNZ [options]\n"
                                  "       cvol evaluate A --points FILE [options]",
                         .description = description,
                         .examples = examples,
                         .options = specs,
                         .option_count = sizeof specs / sizeof *specs,
                         .positional_count = 1};
    input in = {0};
    int status = parse_command_line(&line, argc, argv);
    if (status >= 0 || (status = check_arguments(&a)) ||
        (a.output && (status = check_output(line.positionals[0], a.output))))
        return status;
    cvol_context *context = begin_command(&a.operand.common);
    if (!context)
        return EXIT_FAILED;
    status = open_operand(context, &in, line.positionals[0], &a.operand);
    if (!status) {
        cvol_array_info info;
        cvol_array_get_info(&info, in.array);
        status = a.points ? evaluate_list(context, &in, &info, &a, line.positionals[0])
                          : choose_places(&a, &info, input_grid(&in), line.positionals[0]);
        if (!status && a.output)
            status = write_grid(context, &in, &info, &a, line.positionals[0]);
    }
    close_input(&in);
    return end_command(context, status);
}
