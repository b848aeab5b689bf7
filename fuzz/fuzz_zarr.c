/* Fuzzing of the reader of Zarr folders. The bytes are the files of a folder, one after the other:
 *
 *     %%NAME
 *     BYTES
 *
 * up to the next %% or the end. Names are relative, and stay inside of the folder. Any bytes must
 * give a volume or an error with a message. */
#define _GNU_SOURCE
#include <ftw.h>
#include <string.h>
#include <sys/stat.h>

#include "fuzz_file.h"

enum { FILES_MAX = 16, NAME_MAX_BYTES = 40 };

static int remove_one(const char *path, const struct stat *status, int kind, struct FTW *place)
{
    (void)status, (void)kind, (void)place;
    return remove(path);
}

/* 1 for letters, digits, points and single slashes that do not leave the folder. */
static int is_name(const char *name, size_t size)
{
    if (!size || size > NAME_MAX_BYTES || name[0] == '/' || name[size - 1] == '/' ||
        memmem(name, size, "..", 2) || memmem(name, size, "//", 2))
        return 0;
    for (size_t i = 0; i < size; i++)
        if (!strchr("abcdefghijklmnopqrstuvwxyz0123456789./", name[i]) || !name[i])
            return 0;
    return 1;
}

static void write_file(const char *folder, const char *name, size_t length, const uint8_t *data,
                       size_t size)
{
    char path[160];
    snprintf(path, sizeof path, "%s/%.*s", folder, (int)length, name);
    for (char *slash = strchr(path + strlen(folder) + 1, '/'); slash;
         slash = strchr(slash + 1, '/')) {
        *slash = '\0';
        mkdir(path, 0700);
        *slash = '/';
    }
    FILE *file = fopen(path, "wb");
    if (!file)
        return;
    fwrite(data, 1, size, file);
    fclose(file);
}

static void write_files(const char *folder, const uint8_t *data, size_t size)
{
    const uint8_t *end = data + size, *at = data;
    for (int i = 0; i < FILES_MAX && end - at > 2 && !memcmp(at, "%%", 2); i++) {
        const char *name = (const char *)at + 2;
        const uint8_t *line = memchr(name, '\n', (size_t)(end - at - 2));
        if (!line)
            return;
        const uint8_t *next = memmem(line, (size_t)(end - line), "%%", 2);
        next = next ? next : end;
        const size_t length = (size_t)((const char *)line - name);
        if (is_name(name, length))
            write_file(folder, name, length, line + 1, (size_t)(next - line - 1));
        at = next;
    }
}

static int read_volume(cvol_context *context, cvol_volume **volume, const char *path)
{
    int code = cvol_volume_read(context, volume, path, NULL);
    if (code == CVOL_ERROR_ARGUMENT) { /* there are several */
        const cvol_read_options first = {
            .size = sizeof(cvol_read_options), .has_channel = 1, .has_index = 1};
        code = cvol_volume_read(context, volume, path, &first);
    }
    return code;
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    char folder[64], level[80];
    snprintf(folder, sizeof folder, "/dev/shm/cvol-fuzz-zarr-%ld", (long)getpid());
    if (mkdir(folder, 0700))
        return 0;
    write_files(folder, data, size);
    snprintf(level, sizeof level, "%s/0", folder);
    cvol_context *context = fuzz_context();
    const char *const paths[] = {folder, level};
    for (int i = 0; i < 2; i++) {
        cvol_volume *volume = NULL;
        const int code = read_volume(context, &volume, paths[i]);
        cvol_volume_statistics stats;
        if (code ? !cvol_context_message(context)[0]
                 : cvol_volume_compute_statistics(context, &stats, volume))
            abort();
        if (!code)
            (void)cvol_volume_is_labels(volume, paths[i]);
        cvol_volume_free(volume);
    }
    cvol_context_free(context);
    nftw(folder, remove_one, 8, FTW_DEPTH | FTW_PHYS);
    return 0;
}
