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

/* 1 for errors of stat() by which a path certainly leads to no file that can be read. */
static int means_no_file(int reason)
{
    return reason == ENOENT || reason == ENOTDIR || reason == ENAMETOOLONG || reason == EACCES ||
           reason == ELOOP;
}

int cvol_folder_check(cvol_context *context, int *is, const char *path)
{
    struct stat status;
    *is = 0;
    if (!stat(path, &status)) {
        *is = S_ISDIR(status.st_mode);
        return CVOL_OK;
    }
    return means_no_file(errno)
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

/* Adds FOLDER/NAME if it is a regular file. 0, or an errno. */
static int add_file(cvol_folder *folder, const char *path, const char *name)
{
    size_t length = strlen(path) + strlen(name) + 2;
    char *file = malloc(length);
    if (!file)
        return ENOMEM;
    snprintf(file, length, "%s%s%s", path, path[strlen(path) - 1] == '/' ? "" : "/", name);
    struct stat status;
    const int reason = stat(file, &status) ? errno : 0;
    if (reason || !S_ISREG(status.st_mode)) {
        free(file);
        return means_no_file(reason) ? 0 : reason;
    }
    if ((folder->count & (folder->count - 1)) == 0) { /* powers of two: twice as much room */
        size_t room = folder->count ? 2 * folder->count : 1;
        char **paths = realloc(folder->paths, room * sizeof *paths);
        if (!paths) {
            free(file);
            return ENOMEM;
        }
        folder->paths = paths;
    }
    folder->paths[folder->count++] = file;
    return 0;
}

int cvol_folder_open(cvol_context *context, cvol_folder *folder, const char *path)
{
    *folder = (cvol_folder){.count = 0};
    DIR *directory = opendir(path);
    if (!directory)
        return cvol_fail(context, CVOL_ERROR_IO, "%s: %s", path, strerror(errno));
    const struct dirent *entry = NULL;
    int reason = 0;
    do {
        errno = 0;
        entry = readdir(directory);
        if (!entry)
            reason = errno;
        else if (entry->d_name[0] != '.')
            reason = add_file(folder, path, entry->d_name);
    } while (entry && !reason);
    closedir(directory);
    if (reason == ENOMEM)
        return cvol_fail_memory(context, folder->count * sizeof *folder->paths, path);
    if (reason) /* without the file a volume would lack slices */
        return cvol_fail(context, CVOL_ERROR_IO, "%s: %s", path, strerror(reason));
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
