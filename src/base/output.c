/* Outputs: files without a name or under a temporary one, which get their final name when they are
 * complete and on disk. */
#define _GNU_SOURCE
#include "base/file.h"

#include <errno.h>
#include <fcntl.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#include "base/bytes.h"
#include "base/context.h"
#include "base/hidden_name.h"
#include "base/memory.h"

struct cvol_output {
    int fd;
    char *final_name;     /* links resolved */
    char *temporary_name; /* NULL for devices and pipes */
    int in_place;
    cvol_bytes *memory; /* NULL: a file */
    int is_unnamed;     /* the temporary name is still a pattern */
    int is_counted;
    uint64_t counted;
    uint32_t checksum; /* of these bytes */
};

static void output_free(cvol_output *output)
{
    if (output->fd >= 0)
        close(output->fd);
    free(output->final_name);
    free(output->temporary_name);
    free(output);
}

/* A file's folder, as a path that can be opened; NULL without memory. */
static char *folder_of(const char *path)
{
    const char *slash = strrchr(path, '/');
    return slash ? strndup(path, (size_t)(slash + 1 - path)) : strdup(".");
}

/* The path from which an unnamed file can be linked. */
static void link_of(char link[32], int fd)
{
    snprintf(link, 32, "/proc/self/fd/%d", fd);
}

/* Opens a file without a name in the folder of the final one; -1 if the file system has none. */
static int open_unnamed(const char *final_name, unsigned mode)
{
    char link[32], *folder = folder_of(final_name);
    int fd = folder ? cvol_file_open(folder, O_TMPFILE | O_RDWR | O_CLOEXEC, mode) : -1;
    free(folder);
    if (fd < 0)
        return -1;
    link_of(link, fd);
    if (!access(link, F_OK))
        return fd;
    close(fd);
    return -1;
}

/* Gives an unnamed file the final name if that is free and `may_end`, else a temporary one until it
 * is renamed. 0 or an errno. */
static int link_unnamed(cvol_output *output, int may_end)
{
    char link[32];
    link_of(link, output->fd);
    if (may_end && !linkat(AT_FDCWD, link, AT_FDCWD, output->final_name, AT_SYMLINK_FOLLOW))
        return 0;
    if (!may_end)
        errno = EEXIST;
    for (int i = 0; errno == EEXIST && i < CVOL_HIDDEN_TRIES; i++) {
        cvol_hidden_name_next(output->temporary_name);
        if (!linkat(AT_FDCWD, link, AT_FDCWD, output->temporary_name, AT_SYMLINK_FOLLOW)) {
            output->is_unnamed = 0;
            return 0;
        }
    }
    return errno;
}

/* `path`, with a final symbolic link followed if it is one. */
static char *resolve_name(const char *path)
{
    char *resolved = realpath(path, NULL);
    return resolved ? resolved : strdup(path);
}

int cvol_output_open(cvol_context *context, cvol_output **out, const char *path)
{
    *out = NULL;
    cvol_output *output = calloc(1, sizeof *output);
    if (!output)
        return cvol_fail_memory(context, sizeof *output, path);
    output->fd = -1;
    output->final_name = resolve_name(path);
    if (!output->final_name) {
        output_free(output);
        return cvol_fail_memory(context, strlen(path), path);
    }
    int code = CVOL_OK;
    struct stat status;
    int exists = !stat(output->final_name, &status);
    if (!exists && errno == ENAMETOOLONG)
        code = cvol_fail(context, CVOL_ERROR_IO, "%s: cannot be written: %s", path,
                         strerror(errno));
    else if (exists && S_ISDIR(status.st_mode))
        code = cvol_fail(context, CVOL_ERROR_IO, "%s: is a directory", path);
    else if (exists && !S_ISREG(status.st_mode)) {
        output->in_place = 1;
        output->fd = cvol_file_open(output->final_name, O_WRONLY | O_CLOEXEC, 0);
        if (output->fd < 0)
            code = cvol_fail(context, CVOL_ERROR_IO, "%s: %s", path, strerror(errno));
    } else if (exists && (!(status.st_mode & 0222) || access(output->final_name, W_OK)))
        code = cvol_fail(context, CVOL_ERROR_IO, "%s: is read-only", path);
    else {
        output->temporary_name = cvol_hidden_name_for(output->final_name);
        if (!output->temporary_name)
            code = cvol_fail_memory(context, strlen(path), path);
        else {
            /* The umask is the whole process's: only the system can apply it safely. */
            const unsigned mode = exists ? 0600 : 0666;
            output->fd = open_unnamed(output->final_name, mode);
            output->is_unnamed = output->fd >= 0;
            if (output->fd < 0)
                output->fd = cvol_hidden_file(output->temporary_name, mode);
            if (output->fd < 0)
                code = cvol_fail(context, CVOL_ERROR_IO, "%s: cannot be written: %s", path,
                                 strerror(errno));
            else if (exists && fchmod(output->fd, status.st_mode & 0777)) {
                /* Permissions are optional: a file system without them is not an error. */
            }
        }
    }
    if (code) {
        output_free(output);
        return code;
    }
    *out = output;
    return CVOL_OK;
}

int cvol_output_open_memory(cvol_context *context, cvol_output **out, cvol_bytes *bytes,
                            const char *name)
{
    *out = NULL;
    cvol_output *output = calloc(1, sizeof *output);
    char *copy = output ? strdup(name) : NULL;
    if (!copy) {
        free(output);
        return cvol_fail_memory(context, sizeof *output, name);
    }
    *output = (cvol_output){.fd = -1, .final_name = copy, .in_place = 1, .memory = bytes};
    *out = output;
    return CVOL_OK;
}

static int write_memory(cvol_context *context, cvol_output *output, const void *data, size_t size)
{
    cvol_bytes_append(output->memory, data, size);
    return output->memory->failed ? cvol_fail_memory(context, size, output->final_name) : CVOL_OK;
}

int cvol_output_write(cvol_context *context, cvol_output *output, const void *data, size_t size)
{
    const char *next = data;
    if (output->is_counted && size) {
        output->counted += size;
        output->checksum = cvol_crc32c_more(output->checksum, data, size);
    }
    if (output->memory)
        return write_memory(context, output, data, size);
    while (size > 0) {
        size_t chunk = size > (size_t)1 << 30 ? (size_t)1 << 30 : size;
        ssize_t wrote = write(output->fd, next, chunk);
        if (wrote < 0 && errno == EINTR)
            continue;
        if (wrote < 0)
            return cvol_fail(context, CVOL_ERROR_IO, "%s: %s", output->final_name, strerror(errno));
        next += wrote;
        size -= (size_t)wrote;
    }
    return CVOL_OK;
}

void cvol_output_count(cvol_output *output)
{
    output->is_counted = 1;
    output->counted = 0;
    output->checksum = 0;
}

void cvol_output_counted(const cvol_output *output, uint64_t *bytes, uint32_t *checksum)
{
    *bytes = output->counted;
    *checksum = output->checksum;
}

const char *cvol_output_name(const cvol_output *output)
{
    return output->final_name;
}

int cvol_output_scratch(cvol_context *context, const cvol_output *output, int *fd)
{
    const char *root = getenv("TMPDIR");
    char *folder = output->in_place ? strdup(root && *root ? root : "/tmp")
                                    : folder_of(output->final_name);
    char *inside = NULL, *name = NULL;
    if (folder && asprintf(&inside, "%s/", folder) >= 0) {
        name = cvol_hidden_name_for(inside);
        free(inside);
    }
    int code = CVOL_OK;
    *fd = -1;
    if (!name) {
        code = cvol_fail_memory(context, strlen(output->final_name), output->final_name);
    } else {
        *fd = cvol_file_open(folder, O_TMPFILE | O_RDWR | O_CLOEXEC, 0600);
        if (*fd < 0) { /* not available on every file system */
            *fd = cvol_hidden_file(name, 0600);
            if (*fd < 0)
                code = cvol_fail(context, CVOL_ERROR_IO, "%s: cannot be written: %s",
                                 output->final_name, strerror(errno));
            else
                unlink(name);
        }
    }
    free(name);
    free(folder);
    return code;
}

int cvol_output_is_seekable(const cvol_output *output)
{
    return output->memory || lseek(output->fd, 0, SEEK_CUR) >= 0 || errno != ESPIPE;
}

int cvol_output_rewrite(cvol_context *context, cvol_output *output, uint64_t offset,
                        const void *data, size_t size)
{
    const char *next = data;
    if (output->memory) {
        memcpy(output->memory->data + offset, data, size);
        return CVOL_OK;
    }
    while (size > 0) {
        ssize_t wrote = pwrite(output->fd, next, size, (off_t)offset);
        if (wrote < 0 && errno == EINTR)
            continue;
        if (wrote < 0)
            return cvol_fail(context, CVOL_ERROR_IO, "%s: %s", output->final_name, strerror(errno));
        next += wrote;
        offset += (uint64_t)wrote;
        size -= (size_t)wrote;
    }
    return CVOL_OK;
}

/* Makes the rename itself durable, if the file system can. */
static void sync_folder_of(const char *path)
{
    char *folder = folder_of(path);
    if (!folder)
        return;
    int fd = cvol_file_open(folder, O_RDONLY | O_DIRECTORY | O_CLOEXEC, 0);
    free(folder);
    if (fd < 0)
        return;
    (void)fsync(fd);
    close(fd);
}

/* Puts the whole file on disk, under the final name if that is free and `may_end`, else under the
 * temporary one. 0 or an errno. */
static int complete(cvol_output *output, int may_end)
{
    int reason = 0;
    if (!output->in_place && fsync(output->fd))
        reason = errno;
    if (!reason && output->is_unnamed)
        reason = link_unnamed(output, may_end);
    if (output->fd >= 0 && close(output->fd) && !reason && output->in_place)
        reason = errno; /* other files are on disk since fsync */
    output->fd = -1;
    return reason;
}

static int has_temporary_name(const cvol_output *output)
{
    return !output->in_place && !output->is_unnamed && output->temporary_name;
}

static int fail_output(cvol_context *context, const cvol_output *output, int reason)
{
    return cvol_fail(context, CVOL_ERROR_IO, "%s: %s", output->final_name, strerror(reason));
}

/* ---- outputs that belong together ------------------------------------------------------------ */

static int hold(cvol_context *context, cvol_output *output)
{
    const size_t size = (context->held_count + 1) * sizeof(cvol_output *);
    cvol_output **more = realloc(context->held, size);
    int code = more ? CVOL_OK : cvol_fail_memory(context, size, output->final_name);
    if (more)
        context->held = more;
    const int reason = code ? 0 : complete(output, 0);
    if (reason)
        code = fail_output(context, output, reason);
    if (code)
        cvol_output_abandon(output);
    else
        context->held[context->held_count++] = output;
    return code;
}

/* Where the file is that had an output's final name before. Neither: there was none. */
typedef struct old_file {
    int is_exchanged; /* under the output's temporary name */
    char *kept;       /* under this hidden name */
} old_file;

/* Gives a file a second, hidden name, or only that one where the file system has no links. *hidden
 * is NULL if there is no file. 0 or an errno. */
static int keep_file(const char *path, const char *temporary_name, char **hidden)
{
    char *name = strdup(temporary_name);
    int reason = EEXIST;
    *hidden = NULL;
    if (!name)
        return ENOMEM;
    for (int i = 0; reason == EEXIST && i < CVOL_HIDDEN_TRIES; i++) {
        cvol_hidden_name_next(name);
        reason = link(path, name) ? errno : 0;
    }
    if (reason && reason != ENOENT) {
        const int fd = cvol_hidden_file(name, 0600); /* the name is free, so that no file is lost */
        reason = fd < 0 || rename(path, name) ? errno : 0;
        if (fd >= 0)
            close(fd);
        if (fd >= 0 && reason)
            unlink(name);
    }
    if (reason)
        free(name);
    else
        *hidden = name;
    return reason == ENOENT ? 0 : reason;
}

/* Undoes keep_file. */
static void put_back(const char *hidden, const char *path)
{
    if (!rename(hidden, path))
        unlink(hidden); /* both are names of one file: the rename did nothing */
}

/* Names a complete file. 0 or an errno. */
static int give_name(const cvol_output *output, old_file *old)
{
#ifdef RENAME_EXCHANGE
    if (!renameat2(AT_FDCWD, output->temporary_name, AT_FDCWD, output->final_name,
                   RENAME_EXCHANGE)) {
        old->is_exchanged = 1;
        return 0;
    }
    if (errno != ENOENT && errno != EINVAL && errno != ENOSYS && errno != EOPNOTSUPP &&
        errno != EPERM)
        return errno;
#endif
    int reason = keep_file(output->final_name, output->temporary_name, &old->kept);
    if (!reason && rename(output->temporary_name, output->final_name)) {
        reason = errno;
        if (old->kept)
            put_back(old->kept, output->final_name);
    }
    return reason;
}

/* Undoes give_name. */
static void take_name(cvol_output *output, const old_file *old)
{
    if (old->is_exchanged)
        (void)!rename(output->temporary_name, output->final_name);
    else if (old->kept)
        put_back(old->kept, output->final_name);
    else
        unlink(output->final_name);
    output->is_unnamed = 1; /* no file has the temporary name */
}

/* Ends give_name: the output is there to stay. */
static void confirm_name(cvol_output *output, const old_file *old)
{
    output->is_unnamed = !old->is_exchanged; /* nothing has the temporary name */
    if (old->kept)
        unlink(old->kept);
    sync_folder_of(output->final_name);
}

static int name_all(cvol_context *context)
{
    const size_t count = context->held_count;
    old_file *old = calloc(count ? count : 1, sizeof *old);
    if (!old)
        return cvol_fail_memory(context, count * sizeof *old, "the outputs");
    size_t named = 0;
    int reason = 0;
    while (named < count && !(reason = give_name(context->held[named], &old[named])))
        named++;
    const int code = reason ? fail_output(context, context->held[named], reason) : CVOL_OK;
    for (size_t i = named; i-- > 0;) { /* backwards: two outputs may have one name */
        if (code)
            take_name(context->held[i], &old[i]);
        else
            confirm_name(context->held[i], &old[i]);
    }
    for (size_t i = 0; i < count; i++)
        free(old[i].kept);
    free(old);
    return code;
}

void cvol_context_hold_outputs(cvol_context *context)
{
    context->holds_outputs = 1;
}

int cvol_context_release_outputs(cvol_context *context, int code)
{
    if (!code)
        code = name_all(context);
    for (size_t i = 0; i < context->held_count; i++)
        cvol_output_abandon(context->held[i]);
    free(context->held);
    context->held = NULL;
    context->held_count = 0;
    context->holds_outputs = 0;
    return code;
}

/* ---- the end of an output -------------------------------------------------------------------- */

int cvol_output_commit(cvol_context *context, cvol_output *output)
{
    if (context->holds_outputs && !output->in_place)
        return hold(context, output);
    int reason = complete(output, 1);
    if (!reason && has_temporary_name(output) && rename(output->temporary_name, output->final_name))
        reason = errno;
    if (reason) {
        const int code = fail_output(context, output, reason);
        cvol_output_abandon(output);
        return code;
    }
    if (!output->in_place)
        sync_folder_of(output->final_name);
    output_free(output);
    return CVOL_OK;
}

void cvol_output_abandon(cvol_output *output)
{
    if (!output)
        return;
    if (has_temporary_name(output))
        unlink(output->temporary_name);
    output_free(output);
}

int cvol_output_end(cvol_context *context, cvol_output *output, int code)
{
    if (!code)
        return cvol_output_commit(context, output);
    cvol_output_abandon(output);
    return code;
}

int cvol_file_write(cvol_context *context, const void *data, size_t size, const char *path)
{
    cvol_output *output;
    const int code = cvol_output_open(context, &output, path);
    if (code)
        return code;
    return cvol_output_end(context, output, cvol_output_write(context, output, data, size));
}
