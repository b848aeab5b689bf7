/* Wide names and errors of Windows (wide.h). */
#include "windows/wide.h"

#define WIN32_LEAN_AND_MEAN
#include <windows.h>

static int fail_text(void)
{
    errno = EILSEQ;
    return 0;
}

wchar_t *cvol_wide(const char *text)
{
    const int length = MultiByteToWideChar(CP_UTF8, MB_ERR_INVALID_CHARS, text, -1, NULL, 0);
    wchar_t *wide = length || fail_text() ? malloc((size_t)length * sizeof *wide) : NULL;
    if (wide)
        MultiByteToWideChar(CP_UTF8, MB_ERR_INVALID_CHARS, text, -1, wide, length);
    return wide;
}

char *cvol_narrow(const wchar_t *text)
{
    const int length = WideCharToMultiByte(CP_UTF8, 0, text, -1, NULL, 0, NULL, NULL);
    char *narrow = length || fail_text() ? malloc((size_t)length) : NULL;
    if (narrow)
        WideCharToMultiByte(CP_UTF8, 0, text, -1, narrow, length, NULL, NULL);
    return narrow;
}

int cvol_windows_fail(void)
{
    static const struct {
        DWORD windows;
        int posix;
    } errors[] = {
        {ERROR_FILE_NOT_FOUND, ENOENT},
        {ERROR_PATH_NOT_FOUND, ENOENT},
        {ERROR_INVALID_NAME, ENOENT},
        {ERROR_BAD_NETPATH, ENOENT},
        {ERROR_INVALID_DRIVE, ENOENT},
        {ERROR_DIRECTORY, ENOTDIR},
        {ERROR_ACCESS_DENIED, EACCES},
        {ERROR_SHARING_VIOLATION, EACCES},
        {ERROR_USER_MAPPED_FILE, EACCES},
        {ERROR_WRITE_PROTECT, EROFS},
        {ERROR_FILE_EXISTS, EEXIST},
        {ERROR_ALREADY_EXISTS, EEXIST},
        {ERROR_DIR_NOT_EMPTY, ENOTEMPTY},
        {ERROR_NOT_SAME_DEVICE, EXDEV},
        {ERROR_DISK_FULL, ENOSPC},
        {ERROR_HANDLE_DISK_FULL, ENOSPC},
        {ERROR_BROKEN_PIPE, EPIPE},
        {ERROR_NO_DATA, EPIPE},
        {ERROR_NOT_ENOUGH_MEMORY, ENOMEM},
        {ERROR_OUTOFMEMORY, ENOMEM},
        {ERROR_TOO_MANY_OPEN_FILES, EMFILE},
        {ERROR_INVALID_HANDLE, EBADF},
        {ERROR_FILENAME_EXCED_RANGE, ENAMETOOLONG},
    };
    const DWORD reason = GetLastError();
    errno = EIO;
    for (size_t i = 0; i < sizeof errors / sizeof *errors; i++)
        if (errors[i].windows == reason)
            errno = errors[i].posix;
    return -1;
}

char *cvol_path_of(void *handle)
{
    const DWORD most = GetFinalPathNameByHandleW(handle, NULL, 0, FILE_NAME_NORMALIZED);
    wchar_t *wide = most ? malloc((size_t)most * sizeof *wide) : NULL;
    if (!most)
        cvol_windows_fail();
    if (!wide)
        return NULL;
    const DWORD length = GetFinalPathNameByHandleW(handle, wide, most, FILE_NAME_NORMALIZED);
    char *path = NULL;
    if (!length || length >= most)
        cvol_windows_fail();
    else if (!wcsncmp(wide, L"\\\\?\\UNC\\", 8)) { /* \\?\UNC\SERVER: //SERVER */
        wide[6] = L'\\';
        path = cvol_narrow(wide + 6);
    } else
        path = cvol_narrow(wide + (wcsncmp(wide, L"\\\\?\\", 4) ? 0 : 4));
    for (char *c = path; c && *c; c++)
        if (*c == '\\')
            *c = '/';
    free(wide);
    return path;
}

char *cvol_path_inside(int folder, const char *name)
{
    char *path = cvol_path_of((HANDLE)_get_osfhandle(folder)), *inside = NULL;
    if (path && asprintf(&inside, "%s/%s", path, name) < 0)
        inside = NULL;
    free(path);
    return inside;
}

void cvol_randomize(char *pattern)
{
    static const char letters[] = "abcdefghijklmnopqrstuvwxyz0123456789";
    unsigned random;
    for (char *c = pattern + strlen(pattern) - 6; *c; c++) {
        rand_s(&random);
        *c = letters[random % (sizeof letters - 1)];
    }
}
