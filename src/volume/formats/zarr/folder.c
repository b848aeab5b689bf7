/* Folders under a temporary name, until they are complete and on disk. */
#define _GNU_SOURCE
#include "volume/formats/zarr/folder.h"

#include <dirent.h>
#include <errno.h>
#include <fcntl.h>
#include <ftw.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#include "base/context.h"
#include "base/file.h"
#include "base/hidden_name.h"
#include "volume/formats/zarr/json.h"

/* Open files of nftw. */
enum { DEPTH = 16 };

static int fail(cvol_context *context, const cvol_zarr_folder *folder)
{
    return cvol_fail(context, CVOL_ERROR_IO, "%s: cannot be written: %s", folder->name,
                     strerror(errno));
}

/* ---- removing ------------------------------------------------------------------------- */

static int remove_one(const char *path, const struct stat *status, int kind, struct FTW *place)
{
    (void)status, (void)kind, (void)place;
    return remove(path) && errno != ENOENT;
}

#ifdef __linux__
static void remove_entries(int folder);

/* 1 if the entry is removed. */
static int remove_entry(int folder, const char *name)
{
    if (!unlinkat(folder, name, 0))
        return 1;
    const int inner = openat(folder, name, O_RDONLY | O_DIRECTORY | O_NOFOLLOW | O_CLOEXEC);
    if (inner < 0)
        return 0;
    remove_entries(inner);
    close(inner);
    return !unlinkat(folder, name, AT_REMOVEDIR);
}

static void remove_entries(int folder)
{
    _Alignas(struct dirent64) char buffer[2048];
    for (int removed = 1; removed;) {
        removed = 0;
        const ssize_t size = lseek(folder, 0, SEEK_SET) ? 0
                                                        : getdents64(folder, buffer, sizeof buffer);
        for (ssize_t at = 0; at < size;) {
            const struct dirent64 *entry = (const void *)(buffer + at);
            at += entry->d_reclen;
            if (strcmp(entry->d_name, ".") && strcmp(entry->d_name, ".."))
                removed += remove_entry(folder, entry->d_name);
        }
    }
}

/* The same as nftw, which needs memory. */
static void remove_without_memory(const char *path)
{
    const int folder = cvol_file_open(path, O_RDONLY | O_DIRECTORY | O_NOFOLLOW | O_CLOEXEC, 0);
    if (folder >= 0) {
        remove_entries(folder);
        close(folder);
    }
    rmdir(path);
}
#else
static void remove_without_memory(const char *path)
{
    rmdir(path);
}
#endif

static void remove_tree(const char *path)
{
    if (nftw(path, remove_one, DEPTH, FTW_DEPTH | FTW_PHYS))
        remove_without_memory(path);
}

/* 1 if cvol writes entries of this name. */
static int is_own(const char *name)
{
    static const char *const own[] = {".", "..", ".zgroup", ".zattrs", "zarr.json"};
    int is = name[0] >= '0' && name[0] <= '9' && !name[1];
    for (size_t i = 0; i < sizeof own / sizeof *own; i++)
        is = is || !strcmp(name, own[i]);
    return is;
}

/* Fails if the folder has an entry that cvol does not write, or cannot be listed. */
static int check_entries(cvol_context *context, const cvol_zarr_folder *folder)
{
    int code = CVOL_OK;
    const struct dirent *entry = NULL;
    DIR *directory = opendir(folder->final);
    if (!directory && errno == ENOMEM)
        return cvol_fail_memory(context, strlen(folder->final), folder->name);
    if (!directory)
        return cvol_fail(context, CVOL_ERROR_IO, "%s: %s", folder->name, strerror(errno));
    do {
        errno = 0;
        entry = readdir(directory);
    } while (entry && is_own(entry->d_name));
    if (entry)
        code = cvol_fail(context, CVOL_ERROR_IO,
                         "%s: exists and has '%.80s', which cvol does not write: remove it first",
                         folder->name, entry->d_name);
    else if (errno)
        code = cvol_fail(context, CVOL_ERROR_IO, "%s: %s", folder->name, strerror(errno));
    closedir(directory);
    return code;
}

/* *is_group: the file of this name describes a group. */
static int find_group(cvol_context *context, int *is_group, const cvol_zarr_folder *folder,
                      const char *name)
{
    cvol_zarr_json group;
    const int code = cvol_zarr_json_open(context, &group, folder->final, name);
    const char *kind = json_string_value(json_object_get(group.root, "node_type"));
    *is_group = !code && group.root && (name[0] == '.' || (kind && !strcmp(kind, "group")));
    cvol_zarr_json_close(&group);
    return code == CVOL_ERROR_MEMORY || code == CVOL_ERROR_IO ? code : CVOL_OK;
}

/* An existing folder must be an image as cvol writes it. */
static int check_existing(cvol_context *context, const cvol_zarr_folder *folder)
{
    struct stat status;
    int code = CVOL_OK;
    if (lstat(folder->final, &status))
        return errno == ENOENT || errno == ENOTDIR
                   ? CVOL_OK /* the output is new, or cannot be made */
                   : cvol_fail(context, CVOL_ERROR_IO, "%s: %s", folder->name, strerror(errno));
    if (!S_ISDIR(status.st_mode))
        return cvol_fail(context, CVOL_ERROR_IO, "%s: is a file, not a folder: remove it first",
                         folder->name);
    int is_group = 0;
    code = find_group(context, &is_group, folder, ".zgroup");
    if (!code && !is_group)
        code = find_group(context, &is_group, folder, "zarr.json");
    if (code)
        return code;
    if (!is_group)
        return cvol_fail(
            context, CVOL_ERROR_IO,
            "%s: is a directory that is not an image of OME-Zarr, so it is not replaced",
            folder->name);
    return check_entries(context, folder);
}

/* ---- writing -------------------------------------------------------------------------- */

int cvol_zarr_folder_open(cvol_context *context, cvol_zarr_folder *folder, const char *path)
{
    *folder = (cvol_zarr_folder){.name = strdup(path), .final = realpath(path, NULL)};
    if (!folder->final && errno != ENOMEM)
        folder->final = strdup(path);
    if (!folder->name || !folder->final)
        return cvol_fail_memory(context, strlen(path), path);
    int code = check_existing(context, folder);
    if (code)
        return code;
    folder->temporary = cvol_hidden_name_for(folder->final);
    if (!folder->temporary)
        return cvol_fail_memory(context, strlen(path), path);
    if (cvol_hidden_folder(folder->temporary, 0777)) {
        code = fail(context, folder);
        free(folder->temporary);
        folder->temporary = NULL;
    }
    return code;
}

/* Makes the folders of a path behind its first `start` bytes. 0 after a failure. */
static int make_folders(char *path, size_t start)
{
    for (char *slash = strchr(path + start, '/'); slash; slash = strchr(slash + 1, '/')) {
        *slash = '\0';
        const int failed = mkdir(path, 0777) && errno != EEXIST;
        *slash = '/';
        if (failed)
            return 0;
    }
    return 1;
}

int cvol_zarr_folder_write(cvol_context *context, const cvol_zarr_folder *folder, const char *name,
                           const void *data, size_t size)
{
    char *path = cvol_zarr_join(folder->temporary, name);
    if (!path)
        return cvol_fail_memory(context, strlen(name), folder->name);
    const int flags = O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC;
    int fd = cvol_file_open(path, flags, 0666);
    if (fd < 0 && errno == ENOENT && make_folders(path, strlen(folder->temporary) + 1))
        fd = cvol_file_open(path, flags, 0666);
    const uint8_t *at = data;
    int code = fd < 0 ? fail(context, folder) : CVOL_OK;
    while (!code && size) {
        const ssize_t put = write(fd, at, size);
        if (put < 0 && errno != EINTR)
            code = fail(context, folder);
        else if (put > 0) {
            at += put;
            size -= (size_t)put;
        }
    }
    if (fd >= 0 && close(fd) && !code)
        code = fail(context, folder);
    free(path);
    return code;
}

/* ---- ending --------------------------------------------------------------------------- */

/* Waits until the files are on disk. 0 after a failure. */
static int sync_all(const char *path)
{
#ifdef __linux__
    const int fd = cvol_file_open(path, O_RDONLY | O_DIRECTORY | O_CLOEXEC, 0);
    const int done = fd >= 0 && !syncfs(fd);
    if (fd >= 0)
        close(fd);
    return done;
#else
    (void)path;
    sync();
    return 1;
#endif
}

/* Exchanges the folder with an older one; 0 after a failure. Then the older one has the temporary
 * name. */
static int exchange(const cvol_zarr_folder *folder)
{
#ifdef RENAME_EXCHANGE
    if (!renameat2(AT_FDCWD, folder->temporary, AT_FDCWD, folder->final, RENAME_EXCHANGE))
        return 1;
#endif
    char *aside = cvol_hidden_name_for(folder->final);
    int done = 0;
    if (!aside)
        errno = ENOMEM;
    if (aside && !cvol_hidden_folder(aside, 0700)) {
        if (rename(folder->final, aside)) {
            const int reason = errno;
            rmdir(aside);
            errno = reason;
        } else if (rename(folder->temporary, folder->final)) {
            const int reason = errno;
            rename(aside, folder->final);
            errno = reason;
        } else {
            done = 1;
            if (rename(aside, folder->temporary))
                remove_tree(aside);
        }
    }
    free(aside);
    return done;
}

int cvol_zarr_folder_commit(cvol_context *context, cvol_zarr_folder *folder)
{
    struct stat status;
    int code = check_existing(context, folder);
    const int exists = !lstat(folder->final, &status);
    if (!code && (!sync_all(folder->temporary) ||
                  (exists ? !exchange(folder) : rename(folder->temporary, folder->final))))
        code = fail(context, folder);
    if (!code && !exists) {
        free(folder->temporary);
        folder->temporary = NULL;
    }
    cvol_zarr_folder_abandon(folder);
    return code;
}

void cvol_zarr_folder_abandon(cvol_zarr_folder *folder)
{
    if (folder->temporary)
        remove_tree(folder->temporary);
    free(folder->temporary);
    free(folder->name);
    free(folder->final);
    *folder = (cvol_zarr_folder){0};
}
