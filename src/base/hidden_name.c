#define _GNU_SOURCE
#include "base/hidden_name.h"

#include <errno.h>
#include <fcntl.h>
#include <stdatomic.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#include "base/file.h"

#define PATTERN ".cvol-XXXXXX"

char *cvol_hidden_name_for(const char *path)
{
    const char *slash = strrchr(path, '/');
    const size_t folder_length = slash ? (size_t)(slash + 1 - path) : 0;
    char *name = malloc(folder_length + sizeof PATTERN);
    if (name) {
        memcpy(name, path, folder_length);
        memcpy(name + folder_length, PATTERN, sizeof PATTERN);
    }
    return name;
}

void cvol_hidden_name_next(char *name)
{
    static atomic_uint used;
    char digits[9];
    snprintf(digits, sizeof digits, "%06x",
             ((unsigned)getpid() + 0x10001 * atomic_fetch_add(&used, 1)) & 0xffffff);
    memcpy(name + strlen(name) - 6, digits, 6);
}

int cvol_hidden_file(char *name, unsigned mode)
{
    int fd = -1;
    errno = EEXIST;
    for (int i = 0; fd < 0 && errno == EEXIST && i < CVOL_HIDDEN_TRIES; i++) {
        cvol_hidden_name_next(name);
        fd = cvol_file_open(name, O_RDWR | O_CREAT | O_EXCL | O_CLOEXEC, mode);
    }
    return fd;
}

int cvol_hidden_folder(char *name, unsigned mode)
{
    int failed = -1;
    errno = EEXIST;
    for (int i = 0; failed && errno == EEXIST && i < CVOL_HIDDEN_TRIES; i++) {
        cvol_hidden_name_next(name);
        failed = mkdir(name, (mode_t)mode);
    }
    return failed;
}
