/* The command line: one table gives options and help; one message for an error. */
#include <ctype.h>
#include <errno.h>
#include <limits.h>
#include <math.h>
#include <stdarg.h>
#include <stdlib.h>
#include <string.h>

#include "tools/base/cli.h"

int report_error(int status, const char *format, ...)
{
    va_list args;
    clear_progress();
    va_start(args, format);
    fputs("cvol: ", stderr);
    vfprintf(stderr, format, args);
    fputc('\n', stderr);
    va_end(args);
    return status;
}

int report_context_error(const cvol_context *context, int code, const char *path)
{
    return report_error(code == CVOL_ERROR_ARGUMENT ? EXIT_MISUSED : EXIT_FAILED, "%s%s%s",
                        path ? path : "", path ? ": " : "", cvol_context_message(context));
}

/* ---- values --------------------------------------------------------------------------------- */

int parse_word(int *out, const word_table *table, const char *option, const char *word)
{
    char list[WORD_LIST];
    if (find_word(out, table, word))
        return EXIT_DONE;
    return report_error(EXIT_MISUSED, "%s is '%s', must be %s", option, word,
                        list_words(list, table, ", ", " or "));
}

static int parse_number(double *out, const char *text, const char **end)
{
    char *stop;
    errno = 0;
    *out = strtod(text, &stop);
    *end = stop;
    return stop != text && !isspace((unsigned char)*text) && isfinite(*out);
}

static int parse_integer(int *out, const char *text, const char **end)
{
    char *stop;
    errno = 0;
    long value = strtol(text, &stop, 10);
    *end = stop;
    *out = (int)value;
    return stop != text && !isspace((unsigned char)*text) && !errno && value >= INT_MIN &&
           value <= INT_MAX;
}

static int parse_dims(size_t dims[3], const char *text)
{
    for (int a = 0; a < 3; a++) {
        char *stop;
        errno = 0;
        if (!isdigit((unsigned char)*text))
            return 0;
        unsigned long long value = strtoull(text, &stop, 10);
        if (errno || value == 0 || value > SIZE_MAX || *stop != (a < 2 ? 'x' : '\0'))
            return 0;
        dims[a] = (size_t)value;
        text = stop + 1;
    }
    return 1;
}

int parse_numbers(double *out, int count, const char *text)
{
    for (int a = 0; a < count; a++) {
        const char *end;
        if (!parse_number(&out[a], text, &end) || *end != (a < count - 1 ? ',' : '\0'))
            return 0;
        text = end + 1;
    }
    return 1;
}

/* X0:X1,Y0:Y1,Z0:Z1; not checked against the volume, which is not open yet. */
static int parse_box(size_t box[6], const char *text)
{
    for (int i = 0; i < 6; i++) {
        char *stop;
        errno = 0;
        if (!isdigit((unsigned char)*text))
            return 0;
        unsigned long long value = strtoull(text, &stop, 10);
        if (errno || value > SIZE_MAX || *stop != (i == 5 ? '\0' : i % 2 ? ',' : ':'))
            return 0;
        box[i] = (size_t)value;
        text = stop + 1;
    }
    return 1;
}

/* W or WxH. */
static int parse_size(int out[2], const char *text)
{
    const char *end;
    if (!parse_integer(&out[0], text, &end) || out[0] < 1)
        return 0;
    out[1] = out[0];
    if (*end == '\0')
        return 1;
    return *end == 'x' && parse_integer(&out[1], end + 1, &end) && *end == '\0' && out[1] >= 1;
}

/* The sides that some block size allows; the library checks the rest. */
static int is_side(int side)
{
    return side >= 16 && side <= 64 && side % 16 == 0;
}

int parse_bricks(int side[3], const char *text)
{
    const char *at = text, *end;
    int count = 0, sound = 1;
    memset(side, 0, 3 * sizeof *side);
    if (!text)
        return EXIT_DONE;
    for (; sound && count < 3; at = end + 1) {
        sound = parse_integer(&side[count], at, &end) && is_side(side[count]) &&
                (*end == ',' || !*end);
        if (sound && ++count && !*end)
            break;
    }
    sound = sound && !*end && count != 2;
    if (count == 1)
        side[1] = side[2] = side[0];
    return sound ? EXIT_DONE
                 : report_error(
                       EXIT_MISUSED,
                       "--bricks is '%s', must be B or X,Y,Z, each 16, 32, 48 or 64 samples, as "
                       "in 32,32,16",
                       text);
}

int parse_keep(cvol_keep *keep, const char *text)
{
    char *end = NULL;
    unsigned long long k = 0, s = 0;
    int sound = isdigit((unsigned char)text[0]);
    if (sound) {
        k = strtoull(text, &end, 10);
        sound = *end == ',' && isdigit((unsigned char)end[1]);
    }
    if (sound) {
        s = strtoull(end + 1, &end, 10);
        sound = !*end && k <= SIZE_MAX / 2 && s <= SIZE_MAX / 2;
    }
    if (!sound)
        return report_error(EXIT_MISUSED, "--keep is '%s', must be K,S, as in 16,1000", text);
    if (!k && !s)
        return report_error(EXIT_MISUSED, "--keep is '%s', must keep at least one coefficient",
                            text);
    *keep = cvol_keep_terms((size_t)k, s);
    return EXIT_DONE;
}

/* The readers would take 0 for a spacing that was not given. */
static int check_spacing(const option_spec *option, const char *text)
{
    const double *spacing = option->value;
    for (int a = 0; a < 3; a++)
        if (!(spacing[a] > 0))
            return report_error(EXIT_MISUSED, "%s is '%s': spacing of axis %c must be above 0",
                                option->name, text, "xyz"[a]);
    return EXIT_DONE;
}

/* Stores the value of an option; EXIT_DONE or, after a message, EXIT_MISUSED. */
static int store_value(const option_spec *option, const char *text)
{
    const char *end = "";
    switch (option->kind) {
    case OPTION_TEXT:
        *(const char **)option->value = text;
        return EXIT_DONE;
    case OPTION_TEXTS: {
        text_list *list = option->value;
        if (list->count == option->least)
            return report_error(EXIT_MISUSED, "%s is given more than %d times", option->name,
                                option->least);
        list->texts[list->count++] = text;
        return EXIT_DONE;
    }
    case OPTION_OF_LAST: {
        texts_of *of = option->value;
        if (!of->list->count)
            return report_error(EXIT_MISUSED, "%s needs %s before it", option->name,
                                of->list_option);
        of->texts[of->list->count - 1] = text;
        return EXIT_DONE;
    }
    case OPTION_INTEGER:
        if (!parse_integer(option->value, text, &end) || *end ||
            *(int *)option->value < option->least)
            return report_error(EXIT_MISUSED, "%s is '%s', must be a whole number, at least %d",
                                option->name, text, option->least);
        return EXIT_DONE;
    case OPTION_THREADS:
        if (!parse_integer(option->value, text, &end) || *end || *(int *)option->value < 1 ||
            *(int *)option->value > THREADS_MAX)
            return report_error(EXIT_MISUSED, "%s is '%s', must be a whole number from 1 to %d",
                                option->name, text, THREADS_MAX);
        return EXIT_DONE;
    case OPTION_NUMBER:
        if (!parse_number(option->value, text, &end) || *end)
            return report_error(EXIT_MISUSED, "%s is '%s', must be a number", option->name, text);
        return EXIT_DONE;
    case OPTION_POSITIVE:
        if (!parse_number(option->value, text, &end) || *end || !(*(double *)option->value > 0))
            return report_error(EXIT_MISUSED, "%s is '%s', must be a number above 0", option->name,
                                text);
        return EXIT_DONE;
    case OPTION_DIMS:
        if (!parse_dims(option->value, text))
            return report_error(EXIT_MISUSED, "%s is '%s', must be NXxNYxNZ, as in 256x256x128",
                                option->name, text);
        return EXIT_DONE;
    case OPTION_SIZE:
        if (!parse_size(option->value, text))
            return report_error(EXIT_MISUSED, "%s is '%s', must be W or WxH, as in 512x384",
                                option->name, text);
        return EXIT_DONE;
    case OPTION_NUMBERS3:
    case OPTION_SPACING:
        if (!parse_numbers(option->value, 3, text))
            return report_error(EXIT_MISUSED, "%s is '%s', must be three numbers, as in 1,0.5,0.5",
                                option->name, text);
        return option->kind == OPTION_SPACING ? check_spacing(option, text) : EXIT_DONE;
    case OPTION_BOX:
        if (!parse_box(option->value, text))
            return report_error(EXIT_MISUSED,
                                "%s is '%s', must be X0:X1,Y0:Y1,Z0:Z1, as in 0:64,0:64,10:20",
                                option->name, text);
        return EXIT_DONE;
    case OPTION_FLAG:
    case OPTION_HEADING:
        break;
    }
    return EXIT_DONE;
}

/* ---- help ------------------------------------------------------------------------------------ */

static void print_help(const command_line *line)
{
    printf("usage: %s\n\n%s\n", line->usage, line->description);
    for (size_t i = 0; i < line->option_count; i++) {
        const option_spec *option = &line->options[i];
        char left[64];
        if (option->kind == OPTION_HEADING) {
            printf("\n%s\n", option->help);
            continue;
        }
        snprintf(left, sizeof left, "%s%s%s", option->name, option->argument ? " " : "",
                 option->argument ? option->argument : "");
        printf("  %-24s  %s\n", left, option->help);
    }
    printf("  %-24s  %s\n", "--help", "print this text");
    if (line->examples)
        printf("\nExamples:\n%s", line->examples);
}

/* ---- parsing --------------------------------------------------------------------------------- */

/* The option that `argument` names; *value: the text after '=', or NULL. */
static const option_spec *find_option(const command_line *line, const char *argument,
                                      const char **value)
{
    const char *equals = strncmp(argument, "--", 2) ? NULL : strchr(argument, '=');
    size_t length = equals ? (size_t)(equals - argument) : strlen(argument);
    *value = equals ? equals + 1 : NULL;
    for (size_t i = 0; i < line->option_count; i++) {
        const option_spec *option = &line->options[i];
        if (option->name && strlen(option->name) == length &&
            !strncmp(option->name, argument, length))
            return option;
    }
    return NULL;
}

/* Reports an unknown option and suggests one of similar spelling, or the only one that begins with
 * it. Exit status. */
static int report_option_error(const command_line *line, const char *argument, const char *command)
{
    const size_t length = strcspn(argument, "=");
    const char *meant = NULL, *longer = NULL;
    size_t nearest = spelling_near(length) + 1, begun = 0;
    for (size_t i = 0; i < line->option_count && length > 3; i++) {
        const char *name = line->options[i].name;
        const size_t distance = name ? spelling_distance(argument, length, name) : SPELLING_FAR;
        if (distance < nearest) {
            nearest = distance;
            meant = name;
        }
        if (name && !strncmp(name, argument, length)) {
            longer = name;
            begun++;
        }
    }
    if (begun == 1)
        meant = longer;
    return report_error(EXIT_MISUSED, "unknown option %s%s%s%s; see %s --help", argument,
                        meant ? " (did you mean " : "", meant ? meant : "", meant ? "?)" : "",
                        command);
}

static int take_option(const command_line *line, int *index, int argc, char **argv)
{
    const char *value;
    const option_spec *option = find_option(line, argv[*index], &value);
    if (!option)
        return report_option_error(line, argv[*index], argv[0]);
    if (option->given)
        *option->given = 1;
    if (option->kind == OPTION_FLAG) {
        if (value)
            return report_error(EXIT_MISUSED, "%s takes no value", option->name);
        *(int *)option->value = 1;
        return EXIT_DONE;
    }
    if (!value) {
        if (*index + 1 >= argc)
            return report_error(EXIT_MISUSED, "%s needs a value: %s", option->name,
                                option->argument);
        value = argv[++*index];
    }
    return store_value(option, value);
}

int parse_command_line(command_line *line, int argc, char **argv)
{
    int positionals = 0, only_names = 0;
    for (int i = 1; i < argc; i++) {
        if (!only_names && (!strcmp(argv[i], "--help") || !strcmp(argv[i], "-h"))) {
            print_help(line);
            return EXIT_DONE;
        }
        if (!only_names && !strcmp(argv[i], "--")) {
            only_names = 1;
        } else if (!only_names && argv[i][0] == '-' && argv[i][1] != '\0') {
            int status = take_option(line, &i, argc, argv);
            if (status != EXIT_DONE)
                return status;
        } else if (line->all)
            line->all[positionals++] = argv[i];
        else if (positionals == line->positional_count)
            return report_error(EXIT_MISUSED, "too many arguments: '%s'; usage: %s", argv[i],
                                line->usage);
        else
            line->positionals[positionals++] = argv[i];
    }
    if (positionals < line->positional_count - line->optional_count)
        return report_error(EXIT_MISUSED, "%d of %d arguments given; usage: %s", positionals,
                            line->positional_count, line->usage);
    line->all_count = positionals;
    for (int i = 0; i < positionals; i++)
        if (find_kind(line->all ? line->all[i] : line->positionals[i]))
            return EXIT_FAILED;
    return -1;
}
