/* Common code of tests of files: a temporary folder and bytes in it. */
#include "test.h"

#include "support.h"

#include <dirent.h>
#include <locale.h>
#include <unistd.h>

#include "codec/container/section_pack.h"

int test_verbose(void)
{
    return getenv("CVOL_TEST_VERBOSE") != NULL;
}

char *support_path(const char *folder, const char *name)
{
    char *path = NULL;
    assert_true(asprintf(&path, "%s/%s", folder, name) > 0);
    return path;
}

char *support_locale_with_comma(void)
{
    static const char *const comma[] = {"de_DE.UTF-8", "de_DE.utf8", "fr_FR.UTF-8", "de_DE"};
    char *before = strdup(setlocale(LC_ALL, NULL));
    int found = 0;
    for (int i = 0; i < 4 && !found; i++)
        found = setlocale(LC_ALL, comma[i]) != NULL;
    if (!found)
        print_message("skipped: no locale with a decimal comma\n");
    return before;
}

void support_locale_restore(char *before)
{
    setlocale(LC_ALL, before);
    free(before);
}

char *support_folder_make(void)
{
    const char *root = getenv("TMPDIR");
    char *folder = support_path(root ? root : "/tmp", "cvol-test-XXXXXX");
    assert_non_null(mkdtemp(folder));
    return folder;
}

static int is_entry(const struct dirent *entry)
{
    return strcmp(entry->d_name, ".") && strcmp(entry->d_name, "..");
}

size_t support_folder_count(const char *folder)
{
    DIR *directory = opendir(folder);
    assert_non_null(directory);
    size_t count = 0;
    for (struct dirent *entry; (entry = readdir(directory));)
        count += (size_t)is_entry(entry);
    closedir(directory);
    return count;
}

void support_folder_remove(char *folder)
{
    DIR *directory = opendir(folder);
    assert_non_null(directory);
    for (struct dirent *entry; (entry = readdir(directory));)
        if (is_entry(entry)) {
            char *path = support_path(folder, entry->d_name);
            unlink(path);
            free(path);
        }
    closedir(directory);
    rmdir(folder);
    free(folder);
}

void support_write(const char *path, const void *data, size_t size)
{
    FILE *file = fopen(path, "wb");
    assert_non_null(file);
    assert_int_equal(fwrite(data, 1, size, file), size);
    assert_int_equal(fclose(file), 0);
}

void support_write_text(const char *path, const char *text)
{
    support_write(path, text, strlen(text));
}

unsigned char *support_read(const char *path, size_t *size)
{
    FILE *file = fopen(path, "rb");
    assert_non_null(file);
    assert_int_equal(fseek(file, 0, SEEK_END), 0);
    long length = ftell(file);
    assert_true(length >= 0);
    rewind(file);
    unsigned char *data = malloc((size_t)length + 1);
    assert_non_null(data);
    *size = fread(data, 1, (size_t)length, file);
    assert_int_equal(*size, length);
    fclose(file);
    return data;
}

unsigned char *support_unpack(unsigned char *data, size_t *size)
{
    cvol_context *context = cvol_context_create();
    cvol_unpacked unpacked;
    if (cvol_pack_detect(data, *size)) {
        if (cvol_unpack(context, &unpacked, data, *size, "packed"))
            fail_msg("%s", cvol_context_message(context));
        free(data);
        data = unpacked.plain.data;
        *size = unpacked.plain.size;
    }
    cvol_context_free(context);
    return data;
}
