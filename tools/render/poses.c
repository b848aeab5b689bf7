/* Reads lists of camera poses from text. */
#define _GNU_SOURCE
#include "tools/render/poses.h"

#include <ctype.h>
#include <errno.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#define POSES_MAX ((size_t)10000000)
#define NUMBERS_MAX 4

static int is_gap(char c)
{
    return c == ',' || c == ';' || c == ' ' || c == '\t' || c == '\r' || c == '\n';
}

/* 1 if the line has column names: it begins with a letter, and not with a number such as nan. */
static int is_header(const char *text)
{
    while (is_gap(*text) || *text == '"')
        text++;
    char *end;
    strtod(text, &end);
    return isalpha((unsigned char)*text) && end == text;
}

/* Reads the numbers of a line and stores the first four. Returns how many there are, or -1 after a
 * message. */
static int read_values(double values[NUMBERS_MAX], char *text, const char *path, int line)
{
    int count = 0;
    for (char *at = text; *at;) {
        if (is_gap(*at)) {
            at++;
            continue;
        }
        char *end = at, *stop;
        while (*end && !is_gap(*end))
            end++;
        const char after = *end;
        *end = '\0';
        const double value = strtod(at, &stop);
        if (*stop || !isfinite(value)) {
            report_error(EXIT_FAILED, "%s: line %d: '%.40s' is not a number", path, line, at);
            return -1;
        }
        if (count < NUMBERS_MAX)
            values[count] = value;
        count++;
        *end = after;
        at = end;
    }
    return count;
}

static int check_pose(const pose_list *list, const pose *p, int count, const char *path)
{
    if (count != 3 && count != 4)
        return report_error(EXIT_FAILED,
                            "%s: line %d has %d numbers, must have 4 (a quaternion w,x,y,z) or 3 "
                            "(azimuth, elevation and roll)",
                            path, p->line, count);
    if (list->numbers && count != list->numbers)
        return report_error(EXIT_FAILED, "%s: line %d has %d numbers, the lines before have %d",
                            path, p->line, count, list->numbers);
    const double *q = p->numbers;
    if (count == 4 && !(fabs(q[0]) > 0 || fabs(q[1]) > 0 || fabs(q[2]) > 0 || fabs(q[3]) > 0))
        return report_error(EXIT_FAILED, "%s: line %d: 0,0,0,0 is not a rotation", path, p->line);
    return EXIT_DONE;
}

static int add_pose(pose_list *list, size_t *capacity, const pose *p, const char *path)
{
    if (list->count == POSES_MAX)
        return report_error(EXIT_FAILED, "%s: has more than %zu poses", path, POSES_MAX);
    if (list->count == *capacity) {
        const size_t more = *capacity ? 2 * *capacity : 256;
        pose *grown = realloc(list->poses, more * sizeof *grown);
        if (!grown)
            return report_error(EXIT_FAILED, "%s: not enough memory for %zu poses", path, more);
        list->poses = grown;
        *capacity = more;
    }
    list->poses[list->count++] = *p;
    return EXIT_DONE;
}

static int read_lines(pose_list *out, FILE *file, const char *path)
{
    char *text = NULL;
    size_t bytes = 0, capacity = 0;
    int status = EXIT_DONE, line = 0, may_be_header = 1;
    for (ssize_t length; !status && (length = getline(&text, &bytes, file)) >= 0;) {
        pose p = {.line = ++line};
        if (strlen(text) != (size_t)length) {
            status = report_error(
                EXIT_FAILED, "%s: line %d has a zero byte: this is not a text file", path, line);
            break;
        }
        text[strcspn(text, "#")] = '\0';
        if (text[strspn(text, ",; \t\r\n")] == '\0')
            continue;
        const int passed = may_be_header && is_header(text);
        may_be_header = 0;
        if (passed)
            continue;
        const int count = read_values(p.numbers, text, path, line);
        status = count < 0 ? EXIT_FAILED : check_pose(out, &p, count, path);
        if (!status) {
            out->numbers = count;
            status = add_pose(out, &capacity, &p, path);
        }
    }
    free(text);
    if (!status && !feof(file))
        status = report_error(EXIT_FAILED, "%s: cannot read: %s", path, strerror(errno));
    if (!status && !out->count)
        status = report_error(EXIT_FAILED, "%s: has no poses", path);
    return status;
}

int read_poses(pose_list *out, const char *path)
{
    *out = (pose_list){0};
    FILE *file = fopen(path, "r");
    if (!file)
        return report_error(EXIT_FAILED, "%s: cannot read: %s", path, strerror(errno));
    const int status = read_lines(out, file, path);
    fclose(file);
    if (status)
        free_poses(out);
    return status;
}

void free_poses(pose_list *list)
{
    free(list->poses);
    *list = (pose_list){0};
}
