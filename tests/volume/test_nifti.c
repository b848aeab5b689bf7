/* NIfTI: the reader on hand-made headers, valid ones and every kind of invalid one; writing wide
 * volumes. */
#include "test.h"

#include "cvol/volume.h"
#include "support_volume.h"

/* The header and `size` counting bytes behind it. */
static const char *nifti(const header *h, size_t size)
{
    uint8_t bytes[1000];
    size_t length = h->version == 1 ? 352 : 544;
    memcpy(bytes, h->bytes, length);
    memcpy(bytes + length, counting, size);
    return write_bytes("n.nii", bytes, length + size);
}

static void test_nifti_plain(void **state)
{
    (void)state;
    for (int version = 1; version <= 2; version++)
        for (int swapped = 0; swapped < 2; swapped++) {
            header h = version == 1 ? nifti1(swapped) : nifti2(swapped);
            set16(&h, version == 1 ? 70 : 12, 512);
            cvol_volume *v = read_ok(nifti(&h, 24));
            assert_int_equal(v->grid.type, CVOL_UINT16);
            uint16_t expected = swapped ? 1 << 8 | 2 : 2 << 8 | 1;
            assert_int_equal(((uint16_t *)v->data)[0], expected);
            assert_true(v->grid.spacing[0] == 2 && v->grid.spacing[2] == 4);
            assert_int_equal(v->grid.space, CVOL_SPACE_RAS);
            assert_true(v->grid.value_scale == 1 && v->grid.value_offset == 0);
            cvol_volume_free(v);
        }
    header h = nifti1(0);
    set_dims(&h, 2, 4, 3, 9, 9);
    set_float(&h, 108, 0); /* "right behind the header" */
    set_float(&h, 88, 0);  /* pixdim[3] */
    cvol_volume *v = read_ok(nifti(&h, 12));
    assert_true(v->grid.dims[2] == 1 && v->grid.spacing[2] == 1);
    cvol_volume_free(v);
}

static void test_nifti_affine(void **state)
{
    (void)state;
    header h = nifti1(1);
    /* a qform: half a turn about y, mirrored z, then scl and units */
    set16(&h, 252, 1);
    set_float(&h, 76, -1);
    set_float(&h, 260, 1);
    set_float(&h, 268, 10);
    set_float(&h, 112, 2);
    set_float(&h, 116, -5);
    h.bytes[123] = 2 | 8;
    cvol_volume *v = read_ok(nifti(&h, 12));
    assert_true(v->grid.direction[0][0] == -1 && v->grid.direction[1][1] == 1);
    assert_true(v->grid.direction[2][2] == 1 && v->grid.origin[0] == 10);
    assert_true(v->grid.value_scale == 2 && v->grid.value_offset == -5);
    assert_string_equal(v->grid.unit, "mm");
    cvol_volume_free(v);
    /* an sform has precedence */
    set16(&h, 254, 1);
    const float rows[12] = {0, 0, 3, 7, 2, 0, 0, 8, 0, 5, 0, 9};
    for (size_t i = 0; i < 12; i++)
        set_float(&h, 280 + 4 * i, rows[i]);
    v = read_ok(nifti(&h, 12));
    assert_true(v->grid.direction[0][1] == 1 && v->grid.direction[1][2] == 1 &&
                v->grid.direction[2][0] == 1);
    assert_true(v->grid.spacing[0] == 2 && v->grid.spacing[1] == 5 && v->grid.spacing[2] == 3);
    assert_true(v->grid.origin[2] == 9);
    cvol_volume_free(v);
    set_float(&h, 288, 0);
    read_fails(nifti(&h, 12), CVOL_ERROR_FORMAT, "sform", "axis z");
    set_float(&h, 288, NAN);
    read_fails(nifti(&h, 12), CVOL_ERROR_FORMAT, "sform", "nan");
    set_float(&h, 288, 3);
    set_float(&h, 292, INFINITY);
    read_fails(nifti(&h, 12), CVOL_ERROR_FORMAT, "origin", "inf");
}

/* NIfTI-2 is written if NIfTI-1 is too narrow. */
static void test_nifti_wide(void **state)
{
    (void)state;
    cvol_grid grid = cvol_grid_make(2, 40000, 1, CVOL_INT8);
    grid.spacing[1] = 0.1;
    cvol_volume *volume = make_volume(&grid, 2);
    check_ok(cvol_volume_write(context, volume, in_folder("w.nii")));
    cvol_volume *back = read_ok(in_folder("w.nii"));
    same_samples(volume, back);
    near(back->grid.spacing[1], 0.1, 1e-15);
    cvol_volume_free(back);
    cvol_volume_free(volume);
}

/* Units that NIfTI and MetaImage do not have are converted. */
static void test_written_units(void **state)
{
    (void)state;
    static const struct {
        const char *unit, *nifti, *meta;
        double nifti_factor, meta_factor;
    } cases[] = {{"nm", "um", "um", 1e-3, 1e-3},   {"A", "um", "um", 1e-4, 1e-4},
                 {"cm", "mm", "cm", 10, 1},        {"m", "m", "mm", 1, 1000},
                 {"inch", "mm", "mm", 25.4, 25.4}, {"um", "um", "um", 1, 1},
                 {"second", "", "", 1, 1}};
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++)
        for (int k = 0; k < 2; k++) {
            const char *name = in_folder(k ? "u.mha" : "u.nii");
            const double factor = k ? cases[i].meta_factor : cases[i].nifti_factor;
            cvol_grid grid = cvol_grid_make(2, 3, 2, CVOL_INT8);
            snprintf(grid.unit, sizeof grid.unit, "%s", cases[i].unit);
            grid.spacing[1] = 4;
            grid.origin[2] = -8;
            cvol_volume *volume = make_volume(&grid, 2);
            check_ok(cvol_volume_write(context, volume, name));
            cvol_volume *back = read_ok(name);
            assert_string_equal(back->grid.unit, k ? cases[i].meta : cases[i].nifti);
            near(back->grid.spacing[0], factor, 1e-6 * factor);
            near(back->grid.spacing[1], 4 * factor, 1e-6 * factor);
            near(back->grid.origin[2], -8 * factor, 1e-6 * factor);
            cvol_volume_free(back);
            cvol_volume_free(volume);
        }
}

static void test_nifti_pair(void **state)
{
    (void)state;
    header h = nifti1(0);
    memcpy(h.bytes + 344, "ni1", 4);
    set_float(&h, 108, 2);
    write_bytes("p.img", counting, 14);
    const char *path = write_bytes("p.hdr", h.bytes, 348);
    cvol_volume *v = read_ok(path);
    assert_memory_equal(v->data, counting + 2, 12);
    cvol_volume_free(v);
    uint8_t packed[128];
    size_t size = gzip(packed, sizeof packed, counting, 14, 15 + 16);
    remove(in_folder("p.img"));
    read_fails(path, CVOL_ERROR_IO, "p.img", "No such file");
    write_bytes("p.img.gz", packed, size);
    v = read_ok(path);
    assert_memory_equal(v->data, counting + 2, 12);
    cvol_volume_free(v);
    read_fails(nifti(&h, 12), CVOL_ERROR_FORMAT, ".hdr", "");
}

/* One volume of a time series, packed or not. */
static void test_nifti_series(void **state)
{
    (void)state;
    uint8_t bytes[352 + 36], packed[600];
    header h = nifti1(0);
    set_dims(&h, 4, 2, 3, 2, 3);
    memcpy(bytes, h.bytes, 352);
    memcpy(bytes + 352, counting, 36);
    size_t size = gzip(packed, sizeof packed, bytes, sizeof bytes, 15 + 16);
    const char *paths[] = {write_bytes("s.nii", bytes, sizeof bytes),
                           write_bytes("s.nii.gz", packed, size)};
    for (int p = 0; p < 2; p++) {
        for (int index = 0; index < 3; index++) {
            const cvol_read_options options = {
                .size = sizeof(cvol_read_options), .has_index = 1, .index = index};
            cvol_volume *v;
            check_ok(cvol_volume_read(context, &v, paths[p], &options));
            assert_int_equal(v->grid.dims[2], 2);
            assert_memory_equal(v->data, counting + 12 * index, 12);
            cvol_volume_free(v);
        }
        const cvol_read_options options = {
            .size = sizeof(cvol_read_options), .has_index = 1, .index = 3};
        read_fails_with(paths[p], &options, CVOL_ERROR_ARGUMENT, "has 3 volumes, 0 to 2;",
                        "number 3 was requested");
    }
    const cvol_read_options last = {.size = sizeof(cvol_read_options), .has_index = 1, .index = 2};
    read_fails_with(write_bytes("s.nii", bytes, sizeof bytes - 1), &last, CVOL_ERROR_FORMAT,
                    "11 of the 12 bytes", "");
}

/* The time step of a series, if the header states it and if not. */
static void expect_step(const header *h, const char *file, size_t length, double step,
                        const char *unit)
{
    uint8_t bytes[544 + 36];
    memcpy(bytes, h->bytes, length);
    memcpy(bytes + length, counting, 36);
    const cvol_read_options first = {.size = sizeof(cvol_read_options), .has_index = 1};
    cvol_volume_stream *s;
    check_ok(cvol_volume_stream_open(context, &s, write_bytes(file, bytes, length + 36), &first));
    const char *found;
    assert_true(cvol_volume_stream_time_step(s, &found) == step);
    assert_string_equal(found, unit);
    assert_string_equal(cvol_volume_stream_channel_name(s, 0), "");
    double rgb[3];
    assert_int_equal(cvol_volume_stream_get_channel_colour(rgb, s, 0), 0);
    cvol_volume_stream_free(s);
}

static void test_nifti_time_step(void **state)
{
    (void)state;
    for (int swapped = 0; swapped < 2; swapped++) {
        header h = nifti1(swapped);
        set_dims(&h, 4, 2, 3, 2, 3);
        set_float(&h, 76 + 16, 2.5);
        h.bytes[123] = 2 | 8; /* mm, s */
        expect_step(&h, "t.nii", 352, 2.5, "s");
        h.bytes[123] = 2 | 16;
        expect_step(&h, "t.nii", 352, 2.5, "ms");
        h.bytes[123] = 32;
        expect_step(&h, "t.nii", 352, 2.5, "Hz");
        h.bytes[123] = 2;
        expect_step(&h, "t.nii", 352, 2.5, "");
        h.bytes[123] = 2 | 8;
        set_float(&h, 76 + 16, 0);
        expect_step(&h, "t.nii", 352, 0, "");
        set_float(&h, 76 + 16, -1);
        expect_step(&h, "t.nii", 352, 0, "");
    }
}

/* Reads `paths`, one packed, and compares sample i with the counting byte first + i step. */
static void expect_channel(const char *const paths[2], int index, int channel, int first, int step)
{
    const cvol_read_options options = {.size = sizeof(cvol_read_options),
                                       .has_index = 1,
                                       .index = index,
                                       .has_channel = 1,
                                       .channel = channel};
    for (int p = 0; p < 2; p++) {
        cvol_volume *v;
        check_ok(cvol_volume_read(context, &v, paths[p], &options));
        assert_int_equal(v->grid.dims[0] * v->grid.dims[1] * v->grid.dims[2], 6);
        assert_int_equal(v->grid.type, CVOL_UINT8);
        for (int i = 0; i < 6; i++)
            assert_int_equal(((const uint8_t *)v->data)[i], counting[first + i * step]);
        cvol_volume_free(v);
    }
}

/* Vectors, whose components are separate volumes, and colours, whose bytes are interleaved. */
static void test_nifti_channels(void **state)
{
    (void)state;
    uint8_t bytes[352 + 36], packed[600];
    for (int colours = 0; colours < 2; colours++) {
        header h = nifti1(0);
        set_dims(&h, colours ? 4 : 5, 3, 2, 1, 2);
        set16(&h, 50, 3); /* dim[5] */
        set16(&h, 70, colours ? 128 : 2);
        memcpy(bytes, h.bytes, 352);
        memcpy(bytes + 352, counting, 36);
        size_t size = gzip(packed, sizeof packed, bytes, sizeof bytes, 15 + 16);
        const char *paths[] = {write_bytes("c.nii", bytes, sizeof bytes),
                               write_bytes("c.nii.gz", packed, size)};
        for (int index = 0; index < 2; index++)
            for (int channel = 0; channel < 3; channel++)
                expect_channel(paths, index, channel,
                               colours ? 18 * index + channel : 6 * (2 * channel + index),
                               colours ? 3 : 1);
        const cvol_read_options none = {.size = sizeof(cvol_read_options), .has_index = 1};
        read_fails_with(paths[1], &none, CVOL_ERROR_ARGUMENT, "has 3 channels", "--channel 0 to 2");
        const cvol_read_options end = {.size = sizeof(cvol_read_options),
                                       .has_index = 1,
                                       .index = 1,
                                       .has_channel = 1,
                                       .channel = 2};
        read_fails_with(write_bytes("c.nii", bytes, sizeof bytes - 1), &end, CVOL_ERROR_FORMAT,
                        colours ? "17 of the 18 bytes" : "5 of the 6 bytes", "");
        size = gzip(packed, sizeof packed, bytes, sizeof bytes - 1, 15 + 16);
        read_fails_with(write_bytes("c.nii.gz", packed, size), &end, CVOL_ERROR_FORMAT, "of the",
                        "bytes");
    }
}

static void test_nifti_dims(void **state)
{
    (void)state;
    for (int version = 1; version <= 2; version++) {
        header h = version == 1 ? nifti1(0) : nifti2(0);
#define DIMS(n, x, y, z, t) (set_dims(&h, n, x, y, z, t), nifti(&h, 12))
        read_fails(DIMS(0, 2, 3, 2, 1), CVOL_ERROR_FORMAT, "dim[0] is 0", "");
        read_fails(DIMS(8, 2, 3, 2, 1), CVOL_ERROR_FORMAT, "dim[0] is 8", "");
        read_fails(DIMS(-3, 2, 3, 2, 1), CVOL_ERROR_FORMAT, "dim[0] is -3", "");
        read_fails(DIMS(3, 2, 0, 2, 1), CVOL_ERROR_FORMAT, "dim[2] is 0", "");
        read_fails(DIMS(3, 2, 3, -2, 1), CVOL_ERROR_FORMAT, "dim[3] is -2", "");
        read_fails(DIMS(4, 2, 3, 2, 7), CVOL_ERROR_ARGUMENT, "has 7 volumes", "--time 0 to 6");
        read_fails(DIMS(3, 2, 3, 3, 1), CVOL_ERROR_FORMAT, "12 of the 18 bytes", "");
        read_fails(DIMS(3, 2, 3, 1, 1), CVOL_ERROR_FORMAT, "6 bytes more", "");
        read_fails_large(DIMS(3, 30000, 30000, 70, 1), CVOL_ERROR_FORMAT, "12 of the 63000000000");
        read_fails(DIMS(3, 30000, 30000, 30000, 1), CVOL_ERROR_LIMIT, "30000", "limit");
    }
    header h = nifti2(0);
    read_fails(DIMS(3, INT64_C(1) << 31, 1, 1, 1), CVOL_ERROR_FORMAT, "12 of the 2147483648", "");
    read_fails(DIMS(3, INT64_C(1) << 62, 4, 2, 1), CVOL_ERROR_LIMIT, "4611686018427387904", "");
    read_fails(DIMS(3, INT64_MIN, 4, 2, 1), CVOL_ERROR_FORMAT, "dim[1] is -9223372036854775808",
               "");
}

static void test_nifti_lies(void **state)
{
    (void)state;
    header h = nifti1(0);
    set16(&h, 70, 1024);
    read_fails(nifti(&h, 12), CVOL_ERROR_FORMAT, "12 of the 96 bytes", "");
    set16(&h, 70, 1536);
    read_fails(nifti(&h, 12), CVOL_ERROR_UNSUPPORTED, "datatype 1536", "FLOAT128");
    set16(&h, 70, 1792);
    read_fails(nifti(&h, 12), CVOL_ERROR_UNSUPPORTED, "datatype 1792", "COMPLEX128");
    set16(&h, 70, 77);
    read_fails(nifti(&h, 12), CVOL_ERROR_FORMAT, "datatype is 77", "");
    set16(&h, 70, 0);
    read_fails(nifti(&h, 12), CVOL_ERROR_FORMAT, "datatype is 0", "");
    h = nifti1(0);
    const float offsets[] = {1, -352, 352.5f, 1e30f, INFINITY, NAN};
    const char *shown[] = {"1", "-352", "352.5", "1e+30", "inf", "nan"};
    for (int i = 0; i < 6; i++) {
        set_float(&h, 108, offsets[i]);
        read_fails(nifti(&h, 12), CVOL_ERROR_FORMAT, "vox_offset is", shown[i]);
    }
    set_float(&h, 108, 1000000);
    read_fails(nifti(&h, 12), CVOL_ERROR_FORMAT, "0 of the 12 bytes", "");
    h = nifti1(0);
    memcpy(h.bytes + 344, "abcd", 4);
    read_fails(nifti(&h, 12), CVOL_ERROR_FORMAT, "magic is 'abcd'", "n+1");
    set32(&h, 0, 347);
    read_fails(nifti(&h, 12), CVOL_ERROR_FORMAT, "sizeof_hdr is 347", "");
    h = nifti1(0);
    read_fails(write_bytes("n.nii", h.bytes, 200), CVOL_ERROR_FORMAT, "200 of the 348 bytes", "");
    read_fails(write_bytes("n.nii", h.bytes, 2), CVOL_ERROR_FORMAT, "sizeof_hdr", "");
    set_float(&h, 84, INFINITY);
    read_fails(nifti(&h, 12), CVOL_ERROR_FORMAT, "spacing of axis y is inf", "");
}

static void test_nifti_gzip(void **state)
{
    (void)state;
    header h = nifti1(1);
    uint8_t plain[400], packed[600];
    memcpy(plain, h.bytes, 352);
    memcpy(plain + 352, counting, 20);
    size_t size = gzip(packed, sizeof packed, plain, 364, 15 + 16);
    cvol_volume *v = read_ok(write_bytes("n.nii.gz", packed, size));
    assert_memory_equal(v->data, counting, 12);
    cvol_volume_free(v);
    v = read_ok(write_bytes("nameless", packed, size)); /* recognised by content alone */
    assert_memory_equal(v->data, counting, 12);
    cvol_volume_free(v);
    read_fails(write_bytes("n.nii.gz", packed, size - 20), CVOL_ERROR_FORMAT, "12 bytes", "");
    read_fails(write_bytes("n.nii.gz", packed, 20), CVOL_ERROR_FORMAT, "header", "");
    read_fails(write_bytes("n.nii.gz", "\x1f\x8bnonsense", 10), CVOL_ERROR_FORMAT, "damaged", "");
    size = gzip(packed, sizeof packed, plain, 366, 15 + 16);
    read_fails(write_bytes("n.nii.gz", packed, size), CVOL_ERROR_FORMAT, "more than", "12 bytes");
    set_dims(&h, 3, 2000, 2000, 1000, 1);
    memcpy(plain, h.bytes, 352);
    size = gzip(packed, sizeof packed, plain, 364, 15 + 16);
    read_fails(write_bytes("n.nii.gz", packed, size), CVOL_ERROR_FORMAT, "cannot hold",
               "4000000000");
    set_dims(&h, 3, 2, 3, 2, 1);
    set_float(&h, 108, 0x1p61f);
    memcpy(plain, h.bytes, 352);
    size = gzip(packed, sizeof packed, plain, 364, 15 + 16);
    read_fails(write_bytes("n.nii.gz", packed, size), CVOL_ERROR_FORMAT, "cannot hold", "12");
}

int main(void)
{
    const struct CMUnitTest reading[] = {
        cmocka_unit_test(test_nifti_plain),    cmocka_unit_test(test_nifti_affine),
        cmocka_unit_test(test_nifti_wide),     cmocka_unit_test(test_written_units),
        cmocka_unit_test(test_nifti_pair),     cmocka_unit_test(test_nifti_dims),
        cmocka_unit_test(test_nifti_series),   cmocka_unit_test(test_nifti_time_step),
        cmocka_unit_test(test_nifti_lies),     cmocka_unit_test(test_nifti_gzip),
        cmocka_unit_test(test_nifti_channels),
    };
    return cmocka_run_group_tests(reading, files_setup, files_teardown) != 0;
}
