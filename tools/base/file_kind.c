/* Kinds of input files. A command finds the kinds of all its inputs first, and fails if one cannot
 * be read. Later questions are answered from a table: a file that cannot be read for a moment must
 * not look like one of another kind. */
#define _GNU_SOURCE
#include <errno.h>
#include <fcntl.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#include "tools/base/cli.h"
#include "tools/base/picture.h"

typedef struct known_file {
    char *path;
    cvol_file_kind kind;
    int is_png;
} known_file;

static known_file *known;
static int known_count;

static const known_file *find_known(const char *path)
{
    for (int i = 0; i < known_count; i++)
        if (!strcmp(known[i].path, path))
            return &known[i];
    return NULL;
}

/* Reads the first bytes. Returns at once, even if the path is a pipe without a writer. 0 or an
 * errno. */
static int read_is_png(int *is, const char *path)
{
    static const unsigned char signature[8] = {0x89, 'P', 'N', 'G', '\r', '\n', 0x1A, '\n'};
    unsigned char start[8] = {0};
    int file;
    do
        file = open(path, O_RDONLY | O_CLOEXEC | O_NONBLOCK);
    while (file < 0 && errno == EINTR);
    int reason = file < 0 ? errno : 0;
    for (size_t done = 0; !reason && done < sizeof start;) {
        const ssize_t count = read(file, start + done, sizeof start - done);
        if (count < 0 && errno != EINTR)
            reason = errno;
        if (!count)
            break;
        done += count > 0 ? (size_t)count : 0;
    }
    if (file >= 0)
        close(file);
    *is = !reason && !memcmp(start, signature, sizeof start);
    return reason;
}

static int fail_memory(void)
{
    return report_error(EXIT_FAILED, "not enough memory");
}

int find_kind(const char *path)
{
    struct stat status;
    if (find_known(path))
        return EXIT_DONE;
    if (stat(path, &status))
        return errno == ENOENT || errno == ENOTDIR || errno == ENAMETOOLONG || errno == EACCES ||
                       errno == ELOOP
                   ? EXIT_DONE /* the reader of the file reports it, or it is an output */
                   : report_error(EXIT_FAILED, "%s: %s", path, strerror(errno));
    if (!S_ISREG(status.st_mode) || access(path, R_OK))
        return EXIT_DONE;
    cvol_context *context = cvol_context_create();
    known_file *more = context ? realloc(known, ((size_t)known_count + 1) * sizeof *known) : NULL;
    if (more)
        known = more;
    char *copy = more ? strdup(path) : NULL;
    if (!copy) {
        cvol_context_free(context);
        return fail_memory();
    }
    known_file file = {copy, CVOL_FILE_OTHER, 0};
    const int code = cvol_file_read_kind(context, &file.kind, path);
    const int reason = code ? 0 : read_is_png(&file.is_png, path);
    const int result = code     ? report_context_error(context, code, NULL)
                       : reason ? report_error(EXIT_FAILED, "%s: %s", path, strerror(reason))
                                : EXIT_DONE;
    cvol_context_free(context);
    if (result)
        free(copy);
    else
        known[known_count++] = file;
    return result;
}

void forget_kinds(void)
{
    for (int i = 0; i < known_count; i++)
        free(known[i].path);
    free(known);
    known = NULL;
    known_count = 0;
}

cvol_file_kind kind_of(const char *path)
{
    const known_file *file = find_known(path);
    return file ? file->kind : cvol_file_kind_of(path);
}

int is_cvol(const char *path)
{
    return kind_of(path) != CVOL_FILE_OTHER;
}

int find_has_header(cvol_context *context, int *out, const char *path)
{
    *out = is_cvol(path);
    const int code = *out ? CVOL_OK : cvol_file_read_is_volume(context, out, path);
    return code ? report_context_error(context, code, NULL) : EXIT_DONE;
}

int is_png(const char *path)
{
    const known_file *file = find_known(path);
    int is = 0;
    if (file)
        return file->is_png;
    (void)read_is_png(&is, path);
    return is;
}
