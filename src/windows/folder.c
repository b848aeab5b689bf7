/* Folders (posix.h), and what is in them. */
#include <ftw.h>

#include "windows/wide.h"

#define WIN32_LEAN_AND_MEAN
#include <windows.h>

struct cvol_posix_directory {
    int fd;
    HANDLE search;
    WIN32_FIND_DATAW next;
    int has_next;
    struct cvol_posix_entry entry;
};

cvol_posix_directory *cvol_posix_opendir(const char *path)
{
    const int fd = open(path, O_RDONLY | O_DIRECTORY);
    cvol_posix_directory *directory = fd >= 0 ? calloc(1, sizeof *directory) : NULL;
    char *pattern = directory ? cvol_path_inside(fd, "*") : NULL;
    wchar_t *wide = pattern ? cvol_wide(pattern) : NULL;
    if (wide) {
        directory->fd = fd;
        directory->search = FindFirstFileW(wide, &directory->next);
        directory->has_next = directory->search != INVALID_HANDLE_VALUE;
    }
    const int opened = directory && directory->has_next;
    if (wide && !opened)
        cvol_windows_fail();
    free(pattern);
    free(wide);
    if (opened)
        return directory;
    free(directory);
    if (fd >= 0)
        close(fd);
    return NULL;
}

struct cvol_posix_entry *cvol_posix_readdir(cvol_posix_directory *directory)
{
    if (!directory->has_next)
        return NULL;
    char *name = cvol_narrow(directory->next.cFileName);
    if (!name)
        return NULL;
    snprintf(directory->entry.d_name, sizeof directory->entry.d_name, "%s", name);
    free(name);
    directory->has_next = FindNextFileW(directory->search, &directory->next);
    return &directory->entry;
}

int cvol_posix_closedir(cvol_posix_directory *directory)
{
    FindClose(directory->search);
    const int result = close(directory->fd);
    free(directory);
    return result;
}

int cvol_posix_dirfd(cvol_posix_directory *directory)
{
    return directory->fd;
}

int cvol_posix_fstatat(int folder, const char *name, struct stat *status, int flags)
{
    (void)flags;
    char *path = cvol_path_inside(folder, name);
    const int result = path ? stat(path, status) : -1;
    free(path);
    return result;
}

int cvol_posix_faccessat(int folder, const char *name, int how, int flags)
{
    (void)flags;
    char *path = cvol_path_inside(folder, name);
    const int result = path ? access(path, how) : -1;
    free(path);
    return result;
}

/* Folders after what is in them, whatever the flags. */
int cvol_posix_nftw(const char *path,
                    int (*visit)(const char *, const struct stat *, int, struct FTW *), int depth,
                    int flags)
{
    struct stat status;
    struct FTW place = {0, 0};
    if (stat(path, &status))
        return -1;
    const int is_folder = S_ISDIR(status.st_mode);
    DIR *folder = is_folder ? opendir(path) : NULL;
    int result = is_folder && !folder ? -1 : 0;
    for (const struct dirent *entry; !result && folder && (entry = readdir(folder));) {
        char *inside;
        if (!strcmp(entry->d_name, ".") || !strcmp(entry->d_name, ".."))
            continue;
        if (asprintf(&inside, "%s/%s", path, entry->d_name) < 0)
            result = -1;
        else {
            result = cvol_posix_nftw(inside, visit, depth, flags);
            free(inside);
        }
    }
    if (folder)
        closedir(folder);
    return result ? result : visit(path, &status, is_folder ? FTW_DP : FTW_F, &place);
}
