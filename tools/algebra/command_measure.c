/* cvol measure: the volume that has values in a range, and the mean of a box, with proven errors.
 */
#include <math.h>
#include <string.h>

#include "tools/algebra/algebra_options.h"
#include "tools/algebra/measure_samples.h"

static const char description[] =
    "Measures the volume of the samples with values in a range, and mean, standard deviation,\n"
    "least and largest of all samples, in a box or the whole. Values are those that the file\n"
    "states, such as Hounsfield units. The number after +- is a proved bound of the difference\n"
    "from the figure of the original samples; that figure lies in the range in parentheses.\n"
    "Samples of lossy files are evaluated in single precision.\n"
    "Samples without a value do not count. The figures of volumes that are not compressed are\n"
    "exact; there NaN, infinity and a value far from all others, such as 1e35, mark no value.";

static const char examples[] =
    "  cvol measure ct.cvol --above 300\n"
    "  cvol measure ct.cvol --above -50 --below 150 --box 100:200,80:180,40:60\n"
    "  cvol measure ct.cvol --ellipsoid --box 100:141,80:121,50:51\n"
    "  cvol measure brain.cvol --above 60 --json\n";

typedef struct measure_arguments {
    algebra_arguments operand;
    double above, below;
    int above_given, below_given, box_given, is_ellipsoid;
    size_t box[6];
} measure_arguments;

/* Figures in the units of the file. */
typedef struct measured {
    cvol_region region; /* counts in the range */
    cvol_region_statistics statistics;
    double cell;      /* the volume of a sample */
    const char *unit; /* of cell; "": unknown */
    int is_assumed;   /* the unit is */
} measured;

/* Converts a range of values to one of stored samples. */
static void store_range(double *least, double *largest, const measure_arguments *a,
                        const cvol_grid *grid)
{
    const double scale = grid->value_scale;
    const double from = a->above_given ? (a->above - grid->value_offset) / scale
                        : scale > 0    ? -(double)INFINITY
                                       : (double)INFINITY,
                 to = a->below_given ? (a->below - grid->value_offset) / scale
                      : scale > 0    ? (double)INFINITY
                                     : -(double)INFINITY;
    *least = fmin(from, to);
    *largest = fmax(from, to);
}

/* Checks the box against the volume. Exit status. */
static int find_box(size_t begin[3], size_t end[3], const measure_arguments *a,
                    const cvol_grid *grid, const char *path)
{
    for (int i = 0; i < 3; i++) {
        begin[i] = a->box_given ? a->box[2 * i] : 0;
        end[i] = a->box_given ? a->box[2 * i + 1] : grid->dims[i];
        if (begin[i] >= end[i] || end[i] > grid->dims[i])
            return report_error(EXIT_FAILED,
                                "%s: --box has %zu:%zu along %c, where the volume has 0:%zu", path,
                                begin[i], end[i], "xyz"[i], grid -> dims[i]);
    }
    return EXIT_DONE;
}

static void convert(measured *m, const cvol_grid *grid)
{
    const cvol_region_statistics s = m->statistics;
    const double scale = grid->value_scale;
    m->cell = grid->spacing[0] * grid->spacing[1] * grid->spacing[2];
    m->is_assumed = !*grid->unit && grid->space != CVOL_SPACE_UNKNOWN;
    m->unit = m->is_assumed ? "mm" : grid->unit;
    m->statistics.mean = scale * s.mean + grid->value_offset;
    m->statistics.standard_deviation = fabs(scale) * s.standard_deviation;
    m->statistics.least = scale * (scale > 0 ? s.least : s.largest) + grid->value_offset;
    m->statistics.largest = scale * (scale > 0 ? s.largest : s.least) + grid->value_offset;
    m->statistics.mean_error = fabs(scale) * s.mean_error;
    m->statistics.standard_deviation_error = fabs(scale) * s.standard_deviation_error;
    m->statistics.least_error = fabs(scale) * (scale > 0 ? s.least_error : s.largest_error);
    m->statistics.largest_error = fabs(scale) * (scale > 0 ? s.largest_error : s.least_error);
}

static json_t *measured_json(const measured *m, const size_t begin[3], const size_t end[3])
{
    const cvol_region *r = &m->region;
    const cvol_region_statistics *s = &m->statistics;
    char unit[24];
    snprintf(unit, sizeof unit, "%s%s", m->unit, *m->unit ? "3" : "");
    return json_pack(
        "{s:[o, o], s:I, s:I, s:I, s:I, s:o, s:o, s:o, s:s, s:b, s:o, s:o, s:o, s:o, s:o, s:o, "
        "s:o, "
        "s:o}",
        "box", json_dims(begin), json_dims(end), "samples", (json_int_t)r->samples, "inside",
        (json_int_t)r->inside, "inside_least", (json_int_t)r->inside_least, "inside_most",
        (json_int_t)r->inside_most, "volume", json_number(m->cell * (double)r->inside),
        "volume_least", json_number(m->cell * (double)r->inside_least), "volume_most",
        json_number(m->cell * (double)r->inside_most), "unit", unit, "unit_assumed", m->is_assumed,
        "mean", json_number(s->mean), "mean_error", json_number(s->mean_error),
        "standard_deviation", json_number(s->standard_deviation), "standard_deviation_error",
        json_number(s->standard_deviation_error), "least", json_number(s->least), "least_error",
        json_number(s->least_error), "largest", json_number(s->largest), "largest_error",
        json_number(s->largest_error));
}

static void print_measured(const char *path, const measured *m, int has_range)
{
    const cvol_region *r = &m->region;
    const cvol_region_statistics *s = &m->statistics;
    const int is_millimetres = strcmp(m->unit, "mm") == 0;
    const double cell = m->cell / (is_millimetres ? 1000 : 1);
    char unit[40];
    snprintf(unit, sizeof unit, "%s%s%s%s", *m->unit ? " " : "", is_millimetres ? "ml" : m->unit,
             is_millimetres || !*m->unit ? "" : "^3", m->is_assumed ? " (mm assumed)" : "");
    printf("%s\n", path);
    printf("  %-20s %llu\n", "samples", (unsigned long long)r->samples);
    print_bounded("mean", s->mean, s->mean_error);
    print_bounded("standard deviation", s->standard_deviation, s->standard_deviation_error);
    print_bounded("least", s->least, s->least_error);
    print_bounded("largest", s->largest, s->largest_error);
    if (!has_range)
        return;
    printf("  %-20s %llu  (%llu to %llu)\n", "samples in range", (unsigned long long)r->inside,
           (unsigned long long)r->inside_least, (unsigned long long)r->inside_most);
    printf("  %-20s %.6g%s  (%.6g to %.6g)\n", "volume in range", cell * (double)r->inside, unit,
           cell * (double)r->inside_least, cell * (double)r->inside_most);
}

/* Without a range, all samples are inside. */
static int measure_array(cvol_context *context, measured *m, const cvol_array *array,
                         const size_t begin[3], const size_t end[3], cvol_region_shape shape,
                         double least, double largest)
{
    const int code = cvol_array_compute_region_statistics(context, &m->statistics, array, begin,
                                                          end, shape);
    if (code)
        return code;
    if (isfinite(least) || isfinite(largest))
        return cvol_array_compute_region(context, &m->region, array, begin, end, least, largest);
    m->region.samples = m->region.inside = m->region.inside_least = m->region.inside_most =
        m->statistics.samples;
    return CVOL_OK;
}

static int measure(cvol_context *context, const input *in, const measure_arguments *a,
                   const char *path)
{
    const cvol_grid *grid = input_grid(in);
    size_t begin[3], end[3];
    double least, largest;
    measured m = {.cell = 0};
    const int has_range = a->above_given || a->below_given;
    const cvol_region_shape shape = a->is_ellipsoid ? CVOL_REGION_ELLIPSOID : CVOL_REGION_BOX;
    int code = CVOL_OK;
    const int status = find_box(begin, end, a, grid, path);
    if (status)
        return status;
    store_range(&least, &largest, a, grid);
    if (in->array)
        code = measure_array(context, &m, in->array, begin, end, shape, least, largest);
    if (code)
        return report_context_error(context, code, path);
    if (!in->array &&
        measure_samples(&m.statistics, &m.region, in, begin, end, shape, least, largest))
        return EXIT_FAILED;
    convert(&m, grid);
    if (a->operand.common.json)
        return print_json(measured_json(&m, begin, end));
    clear_progress();
    print_measured(path, &m, has_range);
    return EXIT_DONE;
}

int command_measure(int argc, char **argv)
{
    measure_arguments a = {.operand = {.common = COMMON_DEFAULTS, .takes_samples = 1}};
    const option_spec specs[] = {
        {"--above", "X", "only values of X and above", OPTION_NUMBER, &a.above, 0, &a.above_given},
        {"--below", "Y", "only values of Y and below", OPTION_NUMBER, &a.below, 0, &a.below_given},
        {"--box", "X0:X1,Y0:Y1,Z0:Z1", "only samples with X0 <= x < X1, and so on (default: all)",
         OPTION_BOX, a.box, 0, &a.box_given},
        {"--ellipsoid", NULL, "only samples in the ellipsoid that touches the faces of the box",
         OPTION_FLAG, &a.is_ellipsoid, 0, NULL},
        RAW_OPERAND_OPTIONS(a.operand.common),
        COMMON_OPTIONS(a.operand.common),
    };
    command_line line = {.usage = "cvol measure A [options]",
                         .description = description,
                         .examples = examples,
                         .options = specs,
                         .option_count = sizeof specs / sizeof *specs,
                         .positional_count = 1};
    input in = {0};
    int status = parse_command_line(&line, argc, argv);
    if (status >= 0)
        return status;
    if (a.above_given && a.below_given && a.above > a.below)
        return report_error(EXIT_MISUSED, "--above is %g, more than --below, %g", a.above, a.below);
    if (a.is_ellipsoid && (a.above_given || a.below_given))
        return report_error(EXIT_MISUSED, "--ellipsoid cannot be combined with --above or --below");
    cvol_context *context = begin_command(&a.operand.common);
    if (!context)
        return EXIT_FAILED;
    status = open_operand(context, &in, line.positionals[0], &a.operand);
    if (!status)
        status = measure(context, &in, &a, line.positionals[0]);
    close_input(&in);
    return end_command(context, status);
}
