/* Files of a folder in natural order. */
#define _GNU_SOURCE
#include "volume/io/folder.h"

#include <dirent.h>
#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>
#include <sys/stat.h>

#include "base/context.h"

int cvol_folder_check(cvol_context *context, int *is, const char *path)
{
    struct stat status;
    *is = 0;
    if (!stat(path, &status)) {
        *is = S_ISDIR(status.st_mode);
        return CVOL_OK;
    }
    return errno == ENOENT || errno == ENOTDIR || errno == ENAMETOOLONG || errno == EACCES ||
                   errno == ELOOP
               ? CVOL_OK /* the caller reads it as a file, which fails */
               : cvol_fail(context, CVOL_ERROR_IO, "%s: %s", path, strerror(errno));
}

static int is_digit(char c)
{
    return c >= '0' && c <= '9';
}

/* The longer of two numbers without leading zeros is larger; 0 for equal numbers. */
static int compare_numbers(const char **a, const char **b)
{
    while (**a == '0')
        ++*a;
    while (**b == '0')
        ++*b;
    size_t m = strspn(*a, "0123456789"), n = strspn(*b, "0123456789");
    int order = m != n ? (m < n ? -1 : 1) : strncmp(*a, *b, m);
    *a += m;
    *b += n;
    return order;
}

int cvol_folder_compare(const char *a, const char *b)
{
    const char *p = a, *q = b;
    while (*p && *q) {
        if (is_digit(*p) && is_digit(*q)) {
            int order = compare_numbers(&p, &q);
            if (order)
                return order;
        } else if (*p != *q)
            return (unsigned char)*p < (unsigned char)*q ? -1 : 1;
        else {
            p++;
            q++;
        }
    }
    return *p ? 1 : *q ? -1 : strcmp(a, b); /* 01 and 1 are the same number but different names */
}

int cvol_folder_name_ends(const char *path, const char *ending)
{
    const size_t length = strlen(path), n = strlen(ending);
    return length > n && !strcasecmp(path + length - n, ending);
}

static int compare_paths(const void *a, const void *b)
{
    return cvol_folder_compare(*(char *const *)a, *(char *const *)b);
}

/* Adds FOLDER/NAME if it is a regular file; 0 without memory. */
static int add_file(cvol_folder *folder, const char *path, const char *name)
{
    size_t length = strlen(path) + strlen(name) + 2;
    char *file = malloc(length);
    if (!file)
        return 0;
    snprintf(file, length, "%s%s%s", path, path[strlen(path) - 1] == '/' ? "" : "/", name);
    struct stat status;
    if (stat(file, &status) || !S_ISREG(status.st_mode)) {
        free(file);
        return 1;
    }
    if ((folder->count & (folder->count - 1)) == 0) { /* powers of two: twice as much room */
        size_t room = folder->count ? 2 * folder->count : 1;
        char **paths = realloc(folder->paths, room * sizeof *paths);
        if (!paths) {
            free(file);
            return 0;
        }
        folder->paths = paths;
    }
    folder->paths[folder->count++] = file;
    return 1;
}

int cvol_folder_open(cvol_context *context, cvol_folder *folder, const char *path)
{
    *folder = (cvol_folder){.count = 0};
    DIR *directory = opendir(path);
    if (!directory)
        return cvol_fail(context, CVOL_ERROR_IO, "%s: %s", path, strerror(errno));
    int enough = 1;
    for (const struct dirent *entry; enough && (entry = readdir(directory));)
        if (entry->d_name[0] != '.')
            enough = add_file(folder, path, entry->d_name);
    closedir(directory);
    if (!enough)
        return cvol_fail_memory(context, folder->count * sizeof *folder->paths, path);
    if (folder->count)
        qsort(folder->paths, folder->count, sizeof *folder->paths, compare_paths);
    return CVOL_OK;
}

void cvol_folder_close(cvol_folder *folder)
{
    for (size_t i = 0; i < folder->count; i++)
        free(folder->paths[i]);
    free(folder->paths);
    *folder = (cvol_folder){.count = 0};
}
