/* Files: names in UTF-8, outputs that replace files, bytes that are replaced, mappings, folders. */
#include "test.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include "base/file.h"
#include "support.h"
#include "support_volume.h"
#include "volume/io/folder.h"

static const char name[] = "gr\xc3\xbc\xc3\x9f\x65 \xe4\xbd\x93\xe7\xa7\xaf \xf0\x9f\xa7\xa0.bin";

static void expect_bytes(const char *path, const char *expected)
{
    uint8_t *data;
    size_t size;
    check_ok(cvol_file_read(context, &data, &size, path, 0, SIZE_MAX));
    assert_int_equal(size, strlen(expected));
    assert_memory_equal(data, expected, size);
    free(data);
}

/* No byte changes on the way, also those that text files have at ends of lines. */
static void test_name(void **state)
{
    (void)state;
    static const char text[] = "1\n2\r\n3\x1a\n";
    const char *path = in_folder(name);
    cvol_folder list;
    check_ok(cvol_file_write(context, text, sizeof text - 1, path));
    expect_bytes(path, text);
    FILE *file = fopen(path, "r");
    assert_non_null(file);
    fclose(file);
    check_ok(cvol_folder_open(context, &list, folder));
    assert_int_equal(list.count, 1);
    assert_string_equal(list.paths[0], path);
    cvol_folder_close(&list);
    assert_int_equal(unlink(path), 0);
    assert_int_equal(support_folder_count(folder), 0);
}

/* Files of two names are two files, and of one name one. */
static void test_identity(void **state)
{
    (void)state;
    struct stat a, b, again;
    check_ok(cvol_file_write(context, "a", 1, in_folder("a")));
    check_ok(cvol_file_write(context, "bc", 2, in_folder("b")));
    assert_int_equal(stat(in_folder("a"), &a), 0);
    assert_int_equal(stat(in_folder("b"), &b), 0);
    assert_int_equal(stat(in_folder("a"), &again), 0);
    assert_true(a.st_dev == b.st_dev && a.st_ino != b.st_ino && a.st_ino == again.st_ino);
    assert_true(a.st_size == 1 && b.st_size == 2 && S_ISREG(a.st_mode));
    assert_int_equal(stat(folder, &a), 0);
    assert_true(S_ISDIR(a.st_mode));
    unlink(in_folder("a"));
    unlink(in_folder("b"));
}

/* The old file stays until the end, and an open one can be replaced. */
static void test_replacing(void **state)
{
    (void)state;
    const char *path = in_folder(name);
    cvol_output *output;
    check_ok(cvol_file_write(context, "old", 3, path));
    check_ok(cvol_output_open(context, &output, path));
    check_ok(cvol_output_write(context, output, "new", 3));
    expect_bytes(path, "old");
    cvol_output_abandon(output);
    expect_bytes(path, "old");
    assert_int_equal(support_folder_count(folder), 1);

    const int reader = cvol_file_open(path, O_RDONLY, 0);
    assert_true(reader >= 0);
    check_ok(cvol_output_open(context, &output, path));
    check_ok(cvol_output_write(context, output, "012345", 6));
    check_ok(cvol_output_rewrite(context, output, 1, "ab", 2));
    check_ok(cvol_output_write(context, output, "6", 1)); /* at the end, not behind "ab" */
    check_ok(cvol_output_commit(context, output));
    close(reader);
    expect_bytes(path, "0ab3456");
    assert_int_equal(support_folder_count(folder), 1);
    unlink(path);
}

static void test_scratch(void **state)
{
    (void)state;
    cvol_output *output;
    int fd;
    char read_back[3] = "";
    check_ok(cvol_output_open(context, &output, in_folder("o")));
    check_ok(cvol_output_scratch(context, output, &fd));
    assert_int_equal(write(fd, "abcdef", 6), 6);
    assert_int_equal(pread(fd, read_back, 2, 3), 2);
    assert_string_equal(read_back, "de");
    assert_int_equal(write(fd, "g", 1), 1); /* pread moves nothing */
    assert_int_equal(pread(fd, read_back, 2, 5), 2);
    assert_string_equal(read_back, "fg");
    assert_int_equal(pread(fd, read_back, 2, 7), 0);
    close(fd);
    cvol_output_abandon(output);
    assert_int_equal(support_folder_count(folder), 0);
}

/* Where a mapped file cannot be replaced, it stays as it was. */
static void test_replacing_mapped(void **state)
{
    (void)state;
    const char *path = in_folder(name);
    cvol_output *output;
    cvol_map map;
    check_ok(cvol_file_write(context, "old", 3, path));
    check_ok(cvol_file_map(context, &map, path));
    check_ok(cvol_output_open(context, &output, path));
    check_ok(cvol_output_write(context, output, "new", 3));
    const int code = cvol_output_commit(context, output);
    assert_memory_equal(map.data, "old", 3);
    cvol_file_unmap(&map);
    expect_bytes(path, code ? "old" : "new");
    assert_int_equal(support_folder_count(folder), 1);
    unlink(path);
#ifndef _WIN32
    assert_int_equal(code, CVOL_OK);
#endif
}

static void test_mapping(void **state)
{
    (void)state;
    cvol_map map;
    uint8_t *data;
    size_t size;
    check_ok(cvol_file_write(context, "bytes", 5, in_folder(name)));
    check_ok(cvol_file_map(context, &map, in_folder(name)));
    assert_true(map.is_mapping);
    assert_int_equal(map.size, 5);
    assert_memory_equal(map.data, "bytes", 5);
    cvol_file_unmap(&map);
    unlink(in_folder(name));
    assert_int_equal(cvol_file_map(context, &map, folder), CVOL_ERROR_IO);
    assert_non_null(strstr(cvol_context_message(context), "is a directory"));
    assert_int_equal(cvol_file_read(context, &data, &size, in_folder("none"), 0, 1), CVOL_ERROR_IO);
    assert_non_null(strstr(cvol_context_message(context), "No such file or directory"));
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_name),
        cmocka_unit_test(test_identity),
        cmocka_unit_test(test_replacing_mapped),
        cmocka_unit_test(test_replacing),
        cmocka_unit_test(test_scratch),
        cmocka_unit_test(test_mapping),
    };
    return cmocka_run_group_tests(tests, files_setup, files_teardown);
}
