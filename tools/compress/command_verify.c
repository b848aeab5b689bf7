/* cvol verify: checks .cvol files for damage. */
#include <stdlib.h>

#include "tools/base/cli.h"
#include "tools/base/processes.h"

static const char description[] =
    "Checks every checksum of .cvol files (headers, sections, runs of bricks), compares\n"
    "lengths with the index, and decodes everything. It checks all files; if one is damaged\n"
    "it prints where, and the exit status is 1.";

static const char examples[] = "  cvol verify brain.cvol\n"
                               "  cvol verify *.cvol --json\n";

/* Checks one file: adds its entry to `files`, or prints its line if that is NULL. EXIT_DONE, or
 * EXIT_FAILED after a message about the first damage. */
static int verify(cvol_context *context, json_t *files, const char *path)
{
    cvol_file_layout layout;
    int code = cvol_file_verify(context, &layout, path);
    clear_progress();
    if (files)
        json_array_append_new(
            files,
            json_pack("{s:o, s:b, s:i, s:I, s:o}", "file", json_text(path), "whole", !code,
                      "sections", layout.section_count, "file_bytes", (json_int_t)layout.file_bytes,
                      "damage", code ? json_text(cvol_context_message(context)) : json_null()));
    else if (!code)
        printf("%s: whole, %d sections, %llu bytes\n", path, layout.section_count,
               (unsigned long long)layout.file_bytes);
    if (code)
        report_context_error(context, code, NULL);
    return code == CVOL_ERROR_CANCELLED ? -1 : code ? EXIT_FAILED : EXIT_DONE;
}

static int verify_all(cvol_context *context, int json, const char *const *paths, int count)
{
    json_t *files = json ? json_array() : NULL;
    int damaged = 0, cancelled = 0;
    if (json && !files)
        return report_error(EXIT_FAILED, "not enough memory for the JSON output");
    for (int i = 0; i < count && !cancelled && processes_can_go_on(); i++) {
        int status = verify(context, files, paths[i]);
        damaged += status == EXIT_FAILED;
        cancelled = status < 0;
    }
    if (cancelled) {
        json_decref(files);
        return EXIT_FAILED;
    }
    int status = EXIT_DONE;
    if (json)
        status = print_json(json_pack("{s:b, s:i, s:o}", "whole", !damaged, "damaged_files",
                                      damaged, "files", files));
    return damaged ? EXIT_FAILED : status;
}

int command_verify(int argc, char **argv)
{
    common_options common = COMMON_DEFAULTS;
    const option_spec specs[] = {COMMON_OPTIONS(common)};
    command_line line = {.usage = "cvol verify FILE.cvol... [options]",
                         .description = description,
                         .examples = examples,
                         .options = specs,
                         .option_count = sizeof specs / sizeof *specs,
                         .positional_count = 1,
                         .all = malloc((size_t)argc * sizeof *line.all)};
    if (!line.all)
        return report_error(EXIT_FAILED, "not enough memory");
    int status = parse_command_line(&line, argc, argv);
    if (status < 0) {
        cvol_context *context = begin_command(&common);
        status = EXIT_FAILED;
        if (context)
            status = end_command(context,
                                 verify_all(context, common.json, line.all, line.all_count));
    }
    free(line.all);
    return status;
}
