/* cvol decompress: a .cvol file back into a dense volume. */
#include "cli.h"

static const char description[] =
    "Decodes a .cvol file into a volume of the original sample type and geometry. The output's\n"
    "ending chooses its format.";

static const char examples[] = "  cvol decompress brain.cvol brain.nii.gz\n"
                               "  cvol decompress brain.cvol brain.nrrd\n";

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

static int decompress(cvol_context *context, common_options *common, const char *in_path,
                      const char *out_path)
{
    input in = {0};
    int status = check_output(in_path, out_path);
    if (status)
        return status;
    int code = cvol_array_read(context, &in.array, in_path, &in.file_bytes);
    status = code ? complain_context(context, code, NULL) : need_volume(context, &in);
    if (!status && (code = cvol_volume_write(context, in.volume, out_path)))
        status = complain_context(context, code, NULL);
    if (!status) {
        clear_progress();
        const cvol_grid *grid = &in.volume->grid;
        if (common->json)
            status = print_json(json_pack("{s:o, s:s, s:I}", "dims", json_dims(grid->dims), "type",
                                          cvol_type_name(grid->type), "file_bytes",
                                          (json_int_t)file_size(out_path)));
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
    const option_spec specs[] = {COMMON_OPTIONS(common)};
    command_line line = {.usage = "cvol decompress IN.cvol OUT [options]",
                         .description = description,
                         .examples = examples,
                         .options = specs,
                         .option_count = sizeof specs / sizeof *specs,
                         .positional_count = 2};
    int status = parse_command_line(&line, argc, argv);
    if (status >= 0)
        return status;
    if (!can_be_written(line.positionals[1]))
        return complain(EXIT_MISUSED,
                        "%s: the name's ending is none of those that can be written (%s)",
                        line.positionals[1], cvol_volume_formats());
    cvol_context *context = begin_command(&common);
    if (!context)
        return EXIT_FAILED;
    return end_command(context,
                       decompress(context, &common, line.positionals[0], line.positionals[1]));
}
