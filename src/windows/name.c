/* Names of files (posix.h). */
#include "windows/wide.h"

#define WIN32_LEAN_AND_MEAN
#include <windows.h>

int cvol_posix_access(const char *path, int how)
{
    struct stat status;
    if (stat(path, &status))
        return -1;
    if (!(how & W_OK) || (status.st_mode & 0222))
        return 0;
    errno = EACCES;
    return -1;
}

/* Calls a function of Windows for two names. */
static int with_names(int (*call)(const wchar_t *, const wchar_t *), const char *from,
                      const char *to)
{
    wchar_t *a = cvol_wide(from), *b = a ? cvol_wide(to) : NULL;
    const int failed = !b || (!call(a, b) && cvol_windows_fail());
    free(a);
    free(b);
    return failed ? -1 : 0;
}

static int move(const wchar_t *from, const wchar_t *to)
{
    return MoveFileExW(from, to, MOVEFILE_REPLACE_EXISTING);
}

/* An open file cannot be replaced, but it can be moved: to a hidden name, which goes when the file
 * is closed. A mapped file can be moved, but not removed: everything stays as it was then. */
static int replace_open(const char *from, const char *to)
{
    const char *slash = strrchr(to, '/');
    char *aside;
    if (asprintf(&aside, "%.*s.cvol-XXXXXX", slash ? (int)(slash + 1 - to) : 0, to) < 0)
        return -1;
    cvol_randomize(aside);
    int failed = with_names(move, to, aside);
    if (!failed) {
        failed = with_names(move, from, to);
        if (!failed && unlink(aside)) {
            failed = -1;
            (void)with_names(move, to, from);
            errno = EACCES;
        }
        const int why = errno;
        if (failed)
            (void)with_names(move, aside, to);
        errno = why;
    }
    free(aside);
    return failed;
}

/* Windows replaces files that are not open, but no folders: POSIX replaces an empty folder by a
 * folder. */
int cvol_posix_rename(const char *from, const char *to)
{
    struct stat a, b;
    if (!stat(to, &b) && S_ISDIR(b.st_mode) && !stat(from, &a) && S_ISDIR(a.st_mode) && rmdir(to))
        return -1;
    if (!with_names(move, from, to))
        return 0;
    return errno == EACCES && !stat(to, &b) && S_ISREG(b.st_mode) ? replace_open(from, to) : -1;
}

static int add_link(const wchar_t *from, const wchar_t *to)
{
    return CreateHardLinkW(to, from, NULL);
}

int cvol_posix_link(const char *from, const char *to)
{
    return with_names(add_link, from, to);
}

int cvol_posix_linkat(int from_folder, const char *from, int to_folder, const char *to, int flags)
{
    (void)from_folder, (void)from, (void)to_folder, (void)to, (void)flags;
    errno = ENOTSUP;
    return -1;
}

/* Calls a function of the CRT for a name. */
static int with_name(int (*call)(const wchar_t *), const char *path)
{
    wchar_t *wide = cvol_wide(path);
    const int result = wide ? call(wide) : -1;
    free(wide);
    return result;
}

int cvol_posix_unlink(const char *path)
{
    return with_name(_wunlink, path);
}

int cvol_posix_rmdir(const char *path)
{
    return with_name(_wrmdir, path);
}

int cvol_posix_remove(const char *path)
{
    struct stat status;
    return !stat(path, &status) && S_ISDIR(status.st_mode) ? rmdir(path) : unlink(path);
}

int cvol_posix_mkdir(const char *path, mode_t mode)
{
    (void)mode;
    return with_name(_wmkdir, path);
}

char *cvol_posix_mkdtemp(char *pattern)
{
    int failed;
    do {
        cvol_randomize(pattern);
        failed = mkdir(pattern, 0700);
    } while (failed && errno == EEXIST);
    return failed ? NULL : pattern;
}

/* The program's file. NULL without memory. */
static char *own_path(void)
{
    wchar_t wide[4096];
    const DWORD length = GetModuleFileNameW(NULL, wide, sizeof wide / sizeof *wide);
    return length < sizeof wide / sizeof *wide ? cvol_narrow(wide) : NULL;
}

static char *real_path(const char *path)
{
    const int fd = open(path, O_RDONLY);
    if (fd < 0)
        return NULL;
    char *real = cvol_path_of((HANDLE)_get_osfhandle(fd));
    close(fd);
    return real;
}

char *cvol_posix_realpath(const char *path, char *out)
{
    (void)out;
    if (strcmp(path, "/proc/self/exe"))
        return real_path(path);
    char *own = own_path(), *real = own ? real_path(own) : NULL;
    free(own);
    return real;
}

mode_t cvol_posix_umask(mode_t mode)
{
    return (mode_t)_umask(mode);
}

int cvol_posix_chmod(const char *path, mode_t mode)
{
    (void)path, (void)mode;
    return 0;
}

int cvol_posix_fchmod(int fd, mode_t mode)
{
    (void)fd, (void)mode;
    return 0;
}
