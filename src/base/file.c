/* Reads and mappings of whole files, and copies in place of mappings. */
#define _GNU_SOURCE
#include "base/file.h"

#include <errno.h>
#include <fcntl.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <unistd.h>

#include "base/context.h"
#include "base/memory.h"

int cvol_file_open(const char *path, int flags, unsigned mode)
{
    int fd;
    do
        fd = open(path, flags, (mode_t)mode);
    while (fd < 0 && errno == EINTR);
    return fd;
}

static int open_regular(cvol_context *context, int *fd, struct stat *status, const char *path)
{
    *fd = cvol_file_open(path, O_RDONLY | O_CLOEXEC | O_NONBLOCK, 0);
    if (*fd < 0)
        return cvol_fail(context, CVOL_ERROR_IO, "%s: %s", path, strerror(errno));
    const char *message = NULL;
    if (fstat(*fd, status))
        message = strerror(errno);
    else if (S_ISDIR(status->st_mode))
        message = "is a directory";
    else if (!S_ISREG(status->st_mode))
        message = "is not a regular file";
    if (!message)
        return CVOL_OK;
    close(*fd);
    return cvol_fail(context, CVOL_ERROR_IO, "%s: %s", path, message);
}

/* Reads until `size` bytes are read or the file ends; 0 or an errno. */
static int read_fully(int fd, uint8_t *data, size_t size, uint64_t offset, size_t *read_size)
{
    *read_size = 0;
    while (*read_size < size) {
        size_t chunk = size - *read_size;
        if (chunk > (size_t)1 << 30)
            chunk = (size_t)1 << 30;
        ssize_t got = pread(fd, data + *read_size, chunk, (off_t)(offset + *read_size));
        if (got < 0 && errno == EINTR)
            continue;
        if (got < 0)
            return errno;
        if (got == 0)
            return 0;
        *read_size += (size_t)got;
    }
    return 0;
}

int cvol_file_read(cvol_context *context, uint8_t **data, size_t *read_size, const char *path,
                   uint64_t offset, size_t size)
{
    *data = NULL;
    *read_size = 0;
    int fd;
    struct stat status;
    int code = open_regular(context, &fd, &status, path);
    if (code)
        return code;
    uint64_t available = (uint64_t)status.st_size > offset ? (uint64_t)status.st_size - offset : 0;
    if (size > available)
        size = (size_t)available;
    uint8_t *buffer = NULL;
    if (size > context->limit_bytes)
        code = cvol_fail(context, CVOL_ERROR_LIMIT, "%s: %zu bytes are more than the limit of %llu",
                         path, size, (unsigned long long)context->limit_bytes);
    else if (!(buffer = cvol_allocate(size, 1)))
        code = cvol_fail_memory(context, size, path);
    else {
        int message = read_fully(fd, buffer, size, offset, read_size);
        if (message)
            code = cvol_fail(context, CVOL_ERROR_IO, "%s: %s", path, strerror(message));
    }
    close(fd);
    if (code)
        free(buffer);
    else
        *data = buffer;
    return code;
}

int cvol_file_peek(cvol_context *context, uint8_t *data, size_t *read_size, size_t size,
                   const char *path)
{
    *read_size = 0;
    int fd;
    struct stat status;
    int code = open_regular(context, &fd, &status, path);
    if (code)
        return code;
    int message = read_fully(fd, data, size, 0, read_size);
    close(fd);
    if (message)
        return cvol_fail(context, CVOL_ERROR_IO, "%s: %s", path, strerror(message));
    if (*read_size == 0)
        return cvol_fail(context, CVOL_ERROR_FORMAT, "%s: is empty", path);
    return CVOL_OK;
}

int cvol_file_may_be_regular(const char *path)
{
    struct stat status;
    return stat(path, &status) ? errno != ENOENT && errno != ENOTDIR : S_ISREG(status.st_mode);
}

int cvol_file_map(cvol_context *context, cvol_map *map, const char *path)
{
    static const uint8_t none = 0;
    *map = (cvol_map){.data = &none};
    int fd;
    struct stat status;
    int code = open_regular(context, &fd, &status, path);
    if (code)
        return code;
    if (status.st_size > 0 && (uint64_t)status.st_size <= SIZE_MAX) {
        map->memory = mmap(NULL, (size_t)status.st_size, PROT_READ, MAP_PRIVATE, fd, 0);
        map->is_mapping = map->memory != MAP_FAILED;
    }
    close(fd);
    if (map->is_mapping) {
        map->data = map->memory;
        map->size = (size_t)status.st_size;
        return CVOL_OK;
    }
    uint8_t *data;
    code = cvol_file_read(context, &data, &map->size, path, 0, SIZE_MAX);
    map->memory = data;
    if (data)
        map->data = data;
    return code;
}

/* A quarter of the machine's memory; 0: unknown. */
static uint64_t bytes_to_copy(void)
{
    const long pages = sysconf(_SC_PHYS_PAGES), page = sysconf(_SC_PAGESIZE);
    return pages > 0 && page > 0 ? (uint64_t)pages * (uint64_t)page / 4 : 0;
}

int cvol_file_copy(cvol_context *context, cvol_map *map, const char *path)
{
    struct stat status;
    *map = (cvol_map){0};
    if (!stat(path, &status) && S_ISREG(status.st_mode) &&
        (uint64_t)status.st_size <= bytes_to_copy()) {
        uint8_t *data;
        const int code = cvol_file_read(context, &data, &map->size, path, 0, SIZE_MAX);
        map->data = map->memory = data;
        if (code != CVOL_ERROR_MEMORY && code != CVOL_ERROR_LIMIT)
            return code;
    }
    return cvol_file_map(context, map, path);
}

void cvol_file_unmap(cvol_map *map)
{
    if (map->is_mapping)
        munmap(map->memory, map->size);
    else
        free(map->memory);
    *map = (cvol_map){0};
}
