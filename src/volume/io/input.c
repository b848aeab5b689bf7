/* Input files that are read in parts. */
#define _GNU_SOURCE
#include "volume/io/input.h"

#include <errno.h>
#include <fcntl.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#include "base/context.h"
#include "base/file.h"

int cvol_input_open(cvol_context *context, cvol_input *input, const char *path)
{
    input->path = path;
    input->size = 0;
    input->fd = -1;
    /* cvol_file_peek has messages for folders, pipes and empty files. */
    uint8_t byte;
    size_t got;
    int code = cvol_file_peek(context, &byte, &got, 1, path);
    if (code)
        return code;
    struct stat status;
    input->fd = cvol_file_open(path, O_RDONLY | O_CLOEXEC | O_NONBLOCK, 0);
    if (input->fd < 0 || fstat(input->fd, &status))
        return cvol_fail(context, CVOL_ERROR_IO, "%s: %s", path, strerror(errno));
    input->size = (uint64_t)status.st_size;
    return CVOL_OK;
}

void cvol_input_close(cvol_input *input)
{
    if (input->fd >= 0)
        close(input->fd);
    input->fd = -1;
}

int cvol_input_read(cvol_context *context, const cvol_input *input, uint64_t offset, void *data,
                    size_t size, size_t *got)
{
    uint8_t *next = data;
    *got = 0;
    if (offset >= input->size)
        return CVOL_OK;
    if (size > input->size - offset)
        size = (size_t)(input->size - offset);
    while (*got < size) {
        ssize_t count = pread(input->fd, next + *got, size - *got, (off_t)(offset + *got));
        if (count < 0 && errno == EINTR)
            continue;
        if (count < 0)
            return cvol_fail(context, CVOL_ERROR_IO, "%s: %s", input->path, strerror(errno));
        if (count == 0) /* the file was truncated meanwhile */
            break;
        *got += (size_t)count;
    }
    return CVOL_OK;
}

int cvol_input_skip_lines(cvol_context *context, const cvol_input *input, uint64_t *offset,
                          uint64_t lines)
{
    char buffer[4096];
    uint64_t skipped = 0;
    while (skipped < lines) {
        size_t got;
        int code = cvol_input_read(context, input, *offset, buffer, sizeof buffer, &got);
        if (code)
            return code;
        if (got == 0)
            return cvol_fail(context, CVOL_ERROR_FORMAT,
                             "%s: ends after %llu of the %llu lines to skip", input->path,
                             (unsigned long long)skipped, (unsigned long long)lines);
        size_t at = 0;
        while (at < got && skipped < lines)
            skipped += buffer[at++] == '\n';
        *offset += at;
    }
    return CVOL_OK;
}

const char *cvol_input_name(const char *path)
{
    const char *slash = strrchr(path, '/');
    return slash ? slash + 1 : path;
}

static int is_file(const char *path)
{
    struct stat status;
    return !stat(path, &status) && S_ISREG(status.st_mode);
}

size_t cvol_input_file_length(const char *path)
{
    struct stat status;
    const size_t all = strlen(path);
    size_t length = all;
    char *copy = stat(path, &status) ? strdup(path) : NULL;
    for (const char *colon = copy ? strchr(path, ':') : NULL; colon && length == all;
         colon = strchr(colon + 1, ':')) {
        copy[colon - path] = '\0';
        if (is_file(copy))
            length = (size_t)(colon - path);
        copy[colon - path] = ':';
    }
    free(copy);
    return length;
}

char *cvol_input_relative_path(const char *header, const char *name)
{
    size_t folder = name[0] != '/' ? (size_t)(cvol_input_name(header) - header) : 0;
    size_t length = strlen(name) + 1;
    char *path = malloc(folder + length);
    if (!path)
        return NULL;
    memcpy(path, header, folder);
    memcpy(path + folder, name, length);
    return path;
}
