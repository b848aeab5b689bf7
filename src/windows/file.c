/* Files by number (posix.h). */
#include <stdarg.h>

#include "windows/wide.h"

#define WIN32_LEAN_AND_MEAN
#include <windows.h>

static HANDLE handle_of(int fd)
{
    return (HANDLE)_get_osfhandle(fd);
}

int cvol_posix_open(const char *path, int flags, ...)
{
    if (flags & O_TMPFILE) {
        errno = ENOTSUP;
        return -1;
    }
    const int way = flags & (O_RDONLY | O_WRONLY | O_RDWR);
    const DWORD access_bits = way == O_RDWR     ? GENERIC_READ | GENERIC_WRITE
                              : way == O_WRONLY ? GENERIC_WRITE
                                                : GENERIC_READ;
    const DWORD how = !(flags & O_CREAT) ? (flags & O_TRUNC ? TRUNCATE_EXISTING : OPEN_EXISTING)
                      : flags & O_EXCL   ? CREATE_NEW
                      : flags & O_TRUNC  ? CREATE_ALWAYS
                                         : OPEN_ALWAYS;
    wchar_t *wide = cvol_wide(path);
    if (!wide)
        return -1;
    const HANDLE file = CreateFileW(wide, access_bits,
                                    FILE_SHARE_READ | FILE_SHARE_WRITE | FILE_SHARE_DELETE, NULL,
                                    how, FILE_ATTRIBUTE_NORMAL | FILE_FLAG_BACKUP_SEMANTICS, NULL);
    free(wide);
    if (file == INVALID_HANDLE_VALUE)
        return cvol_windows_fail();
    struct stat status;
    const int fd = _open_osfhandle((intptr_t)file, flags & O_APPEND);
    if (fd < 0)
        CloseHandle(file);
    else if ((flags & O_DIRECTORY) && (fstat(fd, &status) || !S_ISDIR(status.st_mode))) {
        close(fd);
        errno = ENOTDIR;
        return -1;
    }
    return fd;
}

/* The CRT reads and writes at most an int. */
static unsigned portion(size_t size)
{
    return size < (size_t)1 << 30 ? (unsigned)size : 1U << 30;
}

ssize_t cvol_posix_read(int fd, void *data, size_t size)
{
    return _read(fd, data, portion(size));
}

ssize_t cvol_posix_write(int fd, const void *data, size_t size)
{
    return _write(fd, data, portion(size));
}

static OVERLAPPED place_of(off_t offset)
{
    return (OVERLAPPED){.Offset = (DWORD)offset, .OffsetHigh = (DWORD)((uint64_t)offset >> 32)};
}

ssize_t cvol_posix_pread(int fd, void *data, size_t size, off_t offset)
{
    const off_t before = _lseeki64(fd, 0, SEEK_CUR);
    OVERLAPPED place = place_of(offset);
    DWORD got;
    const int done = ReadFile(handle_of(fd), data, portion(size), &got, &place);
    const int is_end = !done && GetLastError() == ERROR_HANDLE_EOF;
    if (!done && !is_end)
        return cvol_windows_fail();
    _lseeki64(fd, before, SEEK_SET);
    return is_end ? 0 : (ssize_t)got;
}

ssize_t cvol_posix_pwrite(int fd, const void *data, size_t size, off_t offset)
{
    const off_t before = _lseeki64(fd, 0, SEEK_CUR);
    OVERLAPPED place = place_of(offset);
    DWORD put;
    if (!WriteFile(handle_of(fd), data, portion(size), &put, &place))
        return cvol_windows_fail();
    _lseeki64(fd, before, SEEK_SET);
    return (ssize_t)put;
}

int cvol_posix_fsync(int fd)
{
    return _commit(fd);
}

int cvol_posix_fstat(int fd, struct stat *status)
{
    BY_HANDLE_FILE_INFORMATION all;
    const HANDLE file = handle_of(fd);
    *status = (struct stat){0};
    if (file == INVALID_HANDLE_VALUE) {
        errno = EBADF;
        return -1;
    }
    const DWORD type = GetFileType(file);
    if (type != FILE_TYPE_DISK) {
        status->st_mode = type == FILE_TYPE_PIPE ? S_IFIFO : S_IFCHR;
        return 0;
    }
    if (!GetFileInformationByHandle(file, &all))
        return cvol_windows_fail();
    status->st_dev = all.dwVolumeSerialNumber;
    status->st_ino = (uint64_t)all.nFileIndexHigh << 32 | all.nFileIndexLow;
    status->st_size = (off_t)((uint64_t)all.nFileSizeHigh << 32 | all.nFileSizeLow);
    status->st_mode = all.dwFileAttributes & FILE_ATTRIBUTE_DIRECTORY  ? S_IFDIR | 0777
                      : all.dwFileAttributes & FILE_ATTRIBUTE_READONLY ? S_IFREG | 0444
                                                                       : S_IFREG | 0666;
    return 0;
}

int cvol_posix_stat(const char *path, struct stat *status)
{
    wchar_t *wide = cvol_wide(path);
    if (!wide)
        return -1;
    /* The right to read attributes is enough: files that cannot be read have a size too. */
    const HANDLE file = CreateFileW(wide, FILE_READ_ATTRIBUTES,
                                    FILE_SHARE_READ | FILE_SHARE_WRITE | FILE_SHARE_DELETE, NULL,
                                    OPEN_EXISTING, FILE_FLAG_BACKUP_SEMANTICS, NULL);
    free(wide);
    if (file == INVALID_HANDLE_VALUE)
        return cvol_windows_fail();
    const int fd = _open_osfhandle((intptr_t)file, 0);
    if (fd < 0) {
        CloseHandle(file);
        return -1;
    }
    const int result = cvol_posix_fstat(fd, status);
    close(fd);
    return result;
}

int cvol_posix_mkostemp(char *pattern, int flags)
{
    int fd;
    do {
        cvol_randomize(pattern);
        fd = open(pattern, O_RDWR | O_CREAT | O_EXCL | flags, 0600);
    } while (fd < 0 && errno == EEXIST);
    return fd;
}

FILE *cvol_posix_fopen(const char *path, const char *mode)
{
    wchar_t letters[8];
    wchar_t *wide = cvol_wide(path);
    swprintf(letters, sizeof letters / sizeof *letters, L"%hs%hs", mode,
             strchr(mode, 'b') ? "" : "b");
    FILE *file = wide ? _wfopen(wide, letters) : NULL;
    free(wide);
    return file;
}
