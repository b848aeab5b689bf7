/* cvol export: volumes as a page that needs no server, or a page that opens volumes. */
#include <stdlib.h>
#include <string.h>

#include "tools/view/html_page.h"

static const char description[] =
    "Writes volumes and their viewer to one HTML file. It opens in any browser, also from a\n"
    "disk, a mail or a web page, without cvol, without a server and without a network; the\n"
    "page draws the pictures itself. The files must be .cvol files, of at most 200 MB together.\n"
    "With --site it writes a folder for a web server instead: a page without volumes, which\n"
    "opens files that are dropped on it, and FILE.cvol of its server by ?url=FILE.cvol.";
static const char examples[] =
    "  cvol export --html brain.cvol -o brain.html\n"
    "  cvol export --html a.cvol b.cvol -o ab.html --title 'Before and after'\n"
    "  cvol export --site public\n";

typedef struct export_arguments {
    common_options common;
    int html;
    const char *output, *site;
    html_texts texts;
} export_arguments;

static int check_arguments(const export_arguments *a, int files)
{
    if (a->site)
        return a->html || a->output || files
                   ? report_error(EXIT_MISUSED, "--site FOLDER takes no file, --html or -o")
                   : EXIT_DONE;
    if (!a->html)
        return report_error(EXIT_MISUSED, "no form of the page: give --html or --site FOLDER");
    if (!files)
        return report_error(EXIT_MISUSED, "no volume: give a .cvol file");
    if (!a->output)
        return report_error(EXIT_MISUSED, "no file to write: give -o OUT.html");
    if (!has_ending(a->output, ".html") && !has_ending(a->output, ".htm"))
        return report_error(EXIT_MISUSED, "%s: the output's name must end in .html", a->output);
    return EXIT_DONE;
}

static int export_volumes(cvol_context *context, export_arguments *a, const command_line *line)
{
    view_list list = {0};
    int status = EXIT_DONE;
    for (int i = 0; i < line->all_count && !status; i++) {
        status = check_output(line->all[i], a->output);
        if (!status && kind_of(line->all[i]) == CVOL_FILE_OTHER && file_size(line->all[i]))
            status = report_error(EXIT_FAILED,
                                  "%s: is not a compressed volume: make one by cvol compress",
                                  line->all[i]);
    }
    if (!status)
        status = list_views(context, &list, &a->common, NULL, line->all, line->all_count);
    if (!status)
        status = write_html_page(context, a->output, &list, &a->texts);
    const int count = list.count;
    free_views(&list);
    if (status)
        return status;
    const double bytes = (double)file_size(a->output);
    clear_progress();
    if (a->common.json)
        return print_json(json_pack("{s:o, s:i, s:f}", "output", json_text(a->output), "volumes",
                                    count, "file_bytes", bytes));
    printf("%s: %d volume%s, %.2f MB\n", a->output, count, count > 1 ? "s" : "", bytes / 1e6);
    return EXIT_DONE;
}

static int export_site(cvol_context *context, const export_arguments *a)
{
    const int status = write_site(context, a->site);
    if (status)
        return status;
    if (a->common.json)
        return print_json(json_pack("{s:o}", "output", json_text(a->site)));
    printf("%s: index.html and convert.js, for a web server\n", a->site);
    return EXIT_DONE;
}

int command_export(int argc, char **argv)
{
    export_arguments a = {.common = COMMON_DEFAULTS, .texts = {"", "", ""}};
    const option_spec specs[] = {
        {"--html", NULL, "one HTML file", OPTION_FLAG, &a.html, 0, NULL},
        {"-o", "OUT.html", "the page of --html (required)", OPTION_TEXT, &a.output, 0, NULL},
        {"--site", "FOLDER", "a folder for a web server, with a page that opens files", OPTION_TEXT,
         &a.site, 0, NULL},
        {"--title", "TEXT", "title of the page (default: the name of the first file)", OPTION_TEXT,
         &a.texts.title, 0, NULL},
        {"--caption", "TEXT", "a line of text below the picture", OPTION_TEXT, &a.texts.caption, 0,
         NULL},
        {"--link", "TEXT", "the view at first: a link of the viewer, from its #", OPTION_TEXT,
         &a.texts.link, 0, NULL},
        {NULL, NULL, "Files with several volumes:", OPTION_HEADING, NULL, 0, NULL},
        PLACE_OPTIONS(a.common),
        COMMON_OPTIONS(a.common),
    };
    const char **paths = malloc((size_t)argc * sizeof *paths);
    if (!paths)
        return report_error(EXIT_FAILED, "not enough memory");
    command_line line = {
        .usage = "cvol export --html IN.cvol... -o OUT.html | --site FOLDER [options]",
        .description = description,
        .examples = examples,
        .options = specs,
        .option_count = sizeof specs / sizeof *specs,
        .positional_count = 0,
        .all = paths};
    int status = parse_command_line(&line, argc, argv);
    if (status < 0 && !(status = check_arguments(&a, line.all_count))) {
        cvol_context *context = begin_command(&a.common);
        status = EXIT_FAILED;
        if (context)
            status = end_command(context, a.site ? export_site(context, &a)
                                                 : export_volumes(context, &a, &line));
    }
    free(paths);
    return status;
}
