/* cvol decompress: a .cvol file back into a dense volume. */
#include "cli.h"

static const char description[] =
    "Decodes a .cvol file into a volume of the original sample type and geometry. The output's\n"
    "ending chooses its format. With --box only that part, which stays where it is in the world.";

static const char examples[] =
    "  cvol decompress brain.cvol brain.nii.gz\n"
    "  cvol decompress brain.cvol brain.nrrd\n"
    "  cvol decompress brain.cvol part.nrrd --box 100:200,150:250,90:91\n";

/* Whether the name ends in one of the formats' endings: known before the work is done. */
static int can_be_written(const char *path)
{
    char ending[16];
    int length;
    for (const char *next = cvol_volume_formats(); sscanf(next, "%15s%n", ending, &length) == 1;
         next += length)
        if (has_ending(path, ending))
            return 1;
    return 0;
}

/* Makes in->volume of the box X0 X1 Y0 Y1 Z0 Z1 of a file. Exit status. */
static int open_box(cvol_context *context, input *in, const char *path, const size_t box[6],
                    int level)
{
    const size_t begin[3] = {box[0], box[2], box[4]}, end[3] = {box[1], box[3], box[5]};
    const cvol_file_part part = {.begin = begin, .end = end, .level = level};
    int code = cvol_array_read_part(context, &in->array, NULL, path, &part);
    if (!code) {
        const cvol_grid grid = cvol_grid_box(cvol_array_grid(in->array), begin, end);
        code = cvol_volume_create(context, &in->volume, &grid);
    }
    if (!code)
        code = cvol_array_evaluate_box(context, in->volume->data, in->array, begin, end);
    return code ? complain_context(context, code, NULL) : EXIT_DONE;
}

static int open_all(cvol_context *context, input *in, const char *path, int level)
{
    const cvol_file_part part = {.level = level};
    int code = cvol_array_read_part(context, &in->array, NULL, path, &part);
    return code ? complain_context(context, code, NULL) : need_volume(context, in);
}

static int report_json(const cvol_grid *grid, const size_t *box, const char *out_path)
{
    json_t *object = json_pack("{s:o, s:s, s:I}", "dims", json_dims(grid->dims), "type",
                               cvol_type_name(grid->type), "file_bytes",
                               (json_int_t)file_size(out_path));
    if (box && object) {
        const size_t begin[3] = {box[0], box[2], box[4]}, end[3] = {box[1], box[3], box[5]};
        json_object_set_new(object, "begin", json_dims(begin));
        json_object_set_new(object, "end", json_dims(end));
    }
    return print_json(object);
}

/* box NULL: all of it. */
static int decompress(cvol_context *context, const common_options *common, const size_t *box,
                      const char *in_path, const char *out_path)
{
    input in = {0};
    int code, status = check_output(in_path, out_path);
    if (status)
        return status;
    status = box ? open_box(context, &in, in_path, box, common->level)
                 : open_all(context, &in, in_path, common->level);
    if (!status && (code = cvol_volume_write(context, in.volume, out_path)))
        status = complain_context(context, code, NULL);
    if (!status) {
        clear_progress();
        const cvol_grid *grid = &in.volume->grid;
        if (common->json)
            status = report_json(grid, box, out_path);
        else
            printf("%s: %zu x %zu x %zu samples of %s\n", out_path, grid->dims[0], grid->dims[1],
                   grid->dims[2], cvol_type_name(grid->type));
    }
    close_input(&in);
    return status;
}

int command_decompress(int argc, char **argv)
{
    common_options common = {0};
    size_t box[6];
    int box_given = 0;
    const option_spec specs[] = {
        {NULL, NULL, "What:", OPTION_HEADING, NULL, 0, NULL},
        {"--box", "X0:X1,Y0:Y1,Z0:Z1", "only samples X0 <= x < X1 and so on (default: all)",
         OPTION_BOX, box, 0, &box_given},
        {"--level", "L",
         "0 (default) all frequencies, 1 to 3 the lowest 1/2, 1/4, 1/8 of each axis",
         OPTION_INTEGER, &common.level, 0, NULL},
        COMMON_OPTIONS(common),
    };
    command_line line = {.usage = "cvol decompress IN.cvol OUT [options]",
                         .description = description,
                         .examples = examples,
                         .options = specs,
                         .option_count = sizeof specs / sizeof *specs,
                         .positional_count = 2};
    int status = parse_command_line(&line, argc, argv);
    if (status >= 0)
        return status;
    if (common.level > 3)
        return complain(EXIT_MISUSED, "--level is %d, must be 0 to 3", common.level);
    if (!can_be_written(line.positionals[1]))
        return complain(EXIT_MISUSED,
                        "%s: the name's ending is none of those that can be written (%s)",
                        line.positionals[1], cvol_volume_formats());
    cvol_context *context = begin_command(&common);
    if (!context)
        return EXIT_FAILED;
    return end_command(context, decompress(context, &common, box_given ? box : NULL,
                                           line.positionals[0], line.positionals[1]));
}
