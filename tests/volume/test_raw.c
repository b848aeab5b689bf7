/* Raw samples: the caller's description of them, and the written bytes. */
#include "test.h"

#include "cvol/volume.h"
#include "support.h"
#include "support_volume.h"

static void test_raw(void **state)
{
    (void)state;
    const char *path = write_bytes("r.raw", counting, 24);
    cvol_read_options options = cvol_read_options_defaults();
    read_fails(path, CVOL_ERROR_ARGUMENT, "raw samples need --dims NXxNYxNZ and --type", "");
    options.type = CVOL_UINT16;
    read_fails_with(path, &options, CVOL_ERROR_ARGUMENT, "need --dims NXxNYxNZ", "");
    options = (cvol_read_options){.size = sizeof(cvol_read_options), .dims = {2, 3, 2}};
    read_fails_with(path, &options, CVOL_ERROR_ARGUMENT, "need --type", "");
    options.type = CVOL_UINT16;
    options.big_endian = 1;
    options.spacing[1] = 2.5;
    cvol_volume *v;
    check_ok(cvol_volume_read(context, &v, path, &options));
    assert_int_equal(((uint16_t *)v->data)[1], 3 << 8 | 4);
    assert_true(v->grid.spacing[0] == 1 && v->grid.spacing[1] == 2.5);
    cvol_volume_free(v);
    options.dims[2] = 3;
    read_fails_with(path, &options, CVOL_ERROR_FORMAT, "24 bytes", "36 bytes");
    options.dims[2] = 1;
    read_fails_with(path, &options, CVOL_ERROR_FORMAT, "24 bytes", "12 bytes");
    options.dims[2] = SIZE_MAX;
    read_fails_with(path, &options, CVOL_ERROR_LIMIT, "limit", "");
    options.dims[2] = 2;
    options.spacing[0] = -1;
    read_fails_with(path, &options, CVOL_ERROR_ARGUMENT, "spacing of axis x is -1", "");
    options.spacing[0] = 0;
    path = write_bytes("r.unknown", counting, 24);
    check_ok(cvol_volume_read(context, &v, path, &options));
    cvol_volume_free(v);
    read_fails(path, CVOL_ERROR_UNSUPPORTED, ".nii.gz", "--dims NXxNYxNZ and --type");
    path = write_text("h.nrrd",
                      "NRRD0004\ntype: uint8\ndimension: 3\nsizes: 2 3 2\nencoding: raw\n\n",
                      counting, 12);
    read_fails_with(path, &options, CVOL_ERROR_ARGUMENT, "NRRD", "raw samples");
    /* raw files are little-endian */
    cvol_grid grid = cvol_grid_make(1, 2, 1, CVOL_UINT16);
    check_ok(cvol_volume_create(context, &v, &grid));
    ((uint16_t *)v->data)[1] = 0x1234;
    path = in_folder("r.raw");
    check_ok(cvol_volume_write(context, v, path));
    size_t size;
    uint8_t *bytes = support_read(path, &size);
    assert_int_equal(size, 4);
    assert_memory_equal(bytes, "\0\0\x34\x12", 4);
    free(bytes);
    cvol_volume_free(v);
}

/* Only raw samples have no header; a file that cannot be read is an error, and no raw file. */
static void test_whether_files_have_headers(void **state)
{
    (void)state;
    int is = -1;
    check_ok(cvol_file_read_is_volume(context, &is, write_bytes("some.bin", counting, 12)));
    assert_int_equal(is, 0);
    const char *path = write_text("h.nrrd", "NRRD0004\ntype: uint8\ndimension: 3\n", counting, 12);
    check_ok(cvol_file_read_is_volume(context, &is, path));
    assert_int_equal(is, 1);
    path = in_folder("none.nrrd");
    assert_int_equal(cvol_file_read_is_volume(context, &is, path), CVOL_ERROR_IO);
    assert_int_equal(is, 0);
    assert_non_null(strstr(cvol_context_message(context), "none.nrrd: No such file"));
    assert_int_equal(cvol_file_is_volume(path), 0);
}

int main(void)
{
    const struct CMUnitTest reading[] = {
        cmocka_unit_test(test_raw),
        cmocka_unit_test(test_whether_files_have_headers),
    };
    return cmocka_run_group_tests(reading, files_setup, files_teardown) != 0;
}
