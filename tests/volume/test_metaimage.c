/* MetaImage: the reader on hand-made headers, valid ones and every kind of invalid one. */
#include "test.h"

#include "cvol/volume.h"
#include "support_volume.h"

#define META "ObjectType = Image\nNDims = 3\n"

static const char *meta(const char *text, size_t size)
{
    return write_text("m.mha", text, counting, size);
}

static void test_meta_plain(void **state)
{
    (void)state;
    cvol_volume *v = read_ok(meta(META "DimSize = 2 3 2\nElementType = MET_UCHAR\n"
                                       "ElementSize = 2 3 4\nElementDataFile = LOCAL\n",
                                  12));
    assert_memory_equal(v->data, counting, 12);
    assert_true(v->grid.spacing[2] == 4 && v->grid.space == CVOL_SPACE_UNKNOWN);
    cvol_volume_free(v);
    v = read_ok(meta("NDims = 3\r\nComment = x = y\r\nBinaryData = True\r\n"
                     "BinaryDataByteOrderMSB = True\r\nDimSize = 2 3 2\r\n"
                     "TransformMatrix = 0 2 0 -1 0 0 0 0 1\r\nOffset = 1 2.5 -3\r\n"
                     "ElementSpacing = 0.5 1 2\r\nElementSize = 9 9 9\r\nDistanceUnits = um\r\n"
                     "ElementType = MET_SHORT\r\nElementDataFile = LOCAL\r\n",
                     24));
    assert_int_equal(((int16_t *)v->data)[11], 23 << 8 | 24);
    assert_true(v->grid.direction[0][1] == 1 && v->grid.direction[1][0] == -1);
    assert_true(v->grid.spacing[0] == 0.5 && v->grid.origin[1] == 2.5);
    assert_int_equal(v->grid.space, CVOL_SPACE_LPS);
    assert_string_equal(v->grid.unit, "um");
    cvol_volume_free(v);
    v = read_ok(meta("ObjectType = Image\nNDims = 2\nDimSize = 4 3\nElementSpacing = 2 3\n"
                     "Position = 5 6\nOrientation = 0 1 -1 0\nElementType = MET_CHAR\n"
                     "ElementDataFile = LOCAL\n",
                     12));
    assert_true(v->grid.dims[2] == 1 && v->grid.spacing[1] == 3 && v->grid.origin[1] == 6);
    assert_true(v->grid.direction[1][0] == -1 && v->grid.direction[2][2] == 1);
    cvol_volume_free(v);
    v = read_ok(meta(META "DimSize = 1 3 1\nBinaryData = False\nElementType = MET_FLOAT\n"
                          "ElementDataFile = LOCAL\n1 2.5\n-3",
                     0));
    assert_true(((float *)v->data)[1] == 2.5f);
    cvol_volume_free(v);
}

static void test_meta_types(void **state)
{
    (void)state;
    static const struct {
        const char *name;
        cvol_type type;
    } names[] = {
        {"MET_CHAR", CVOL_INT8},      {"MET_UCHAR", CVOL_UINT8},  {"MET_SHORT", CVOL_INT16},
        {"MET_USHORT", CVOL_UINT16},  {"MET_INT", CVOL_INT32},    {"MET_UINT", CVOL_UINT32},
        {"MET_LONG", CVOL_INT32},     {"MET_ULONG", CVOL_UINT32}, {"MET_FLOAT", CVOL_FLOAT32},
        {"MET_DOUBLE", CVOL_FLOAT64},
    };
    for (size_t i = 0; i < sizeof names / sizeof names[0]; i++) {
        char text[200];
        snprintf(text, sizeof text,
                 META "DimSize = 1 2 1\nElementType = %s\nElementDataFile = LOCAL\n",
                 names[i].name);
        cvol_volume *v = read_ok(meta(text, 2 * cvol_type_size(names[i].type)));
        assert_int_equal(v->grid.type, names[i].type);
        cvol_volume_free(v);
    }
}

static void check_scale(const char *lines, double scale, double offset)
{
    char text[300];
    snprintf(text, sizeof text, META "DimSize = 2 3 2\nElementType = MET_UCHAR\n%s%s", lines,
             "ElementDataFile = LOCAL\n");
    cvol_volume *v = read_ok(meta(text, 12));
    assert_true(v->grid.value_scale == scale && v->grid.value_offset == offset);
    cvol_volume_free(v);
}

/* A slope of 0 means samples without scaling, as in NIfTI. */
static void test_meta_scales(void **state)
{
    (void)state;
#define SLOPE "ElementToIntensityFunctionSlope = "
#define INTERCEPT "ElementToIntensityFunctionOffset = "
    check_scale("", 1, 0);
    check_scale(SLOPE "0.5\n" INTERCEPT "-1024\n", 0.5, -1024);
    check_scale(INTERCEPT "3\n" SLOPE "-2\n", -2, 3);
    check_scale(INTERCEPT "3\n", 1, 3);
    check_scale(SLOPE "0\n" INTERCEPT "-1024\n", 1, 0);
    check_scale(SLOPE "-0.0\n", 1, 0);
}

static void test_meta_detached(void **state)
{
    (void)state;
    write_bytes("m.raw", counting, 24);
#define MHD(text) \
    write_text("m.mhd", META "DimSize = 2 3 2\nElementType = MET_UCHAR\n" text, NULL, 0)
    cvol_volume *v = read_ok(MHD("HeaderSize = 3\nElementDataFile = m.raw\nIgnored\n"));
    assert_memory_equal(v->data, counting + 3, 12);
    cvol_volume_free(v);
    v = read_ok(MHD("HeaderSize = -1\nElementDataFile = m.raw"));
    assert_memory_equal(v->data, counting + 12, 12);
    cvol_volume_free(v);
    uint8_t packed[128];
    size_t size = gzip(packed, sizeof packed, counting, 12, 15);
    memcpy(packed + size, "tail", 4);
    write_bytes("m.zraw", packed, size);
    v = read_ok(MHD("CompressedData = True\nElementDataFile = m.zraw\n"));
    assert_memory_equal(v->data, counting, 12);
    cvol_volume_free(v);
    write_bytes("m.zraw", packed, size + 4);
    char text[200];
    snprintf(text, sizeof text,
             META "DimSize = 2 3 2\nElementType = MET_UCHAR\nCompressedData = True\n"
                  "CompressedDataSize = %zu\nElementDataFile = m.zraw\n",
             size);
    v = read_ok(write_text("m.mhd", text, NULL, 0));
    assert_memory_equal(v->data, counting, 12);
    cvol_volume_free(v);
    cvol_volume *none;
    const char *path = MHD("CompressedData = True\nCompressedDataSize = 10000\n"
                           "ElementDataFile = m.zraw\n");
    assert_int_equal(cvol_volume_read(context, &none, path, NULL), CVOL_ERROR_FORMAT);
    assert_non_null(strstr(cvol_context_message(context), "of the 10000 compressed bytes"));
    read_fails(MHD("ElementDataFile = gone.raw\n"), CVOL_ERROR_IO, "gone.raw", "No such file");
    read_fails(MHD("ElementDataFile = LIST\na.raw\n"), CVOL_ERROR_UNSUPPORTED, "ElementDataFile",
               "LIST");
    read_fails(MHD("ElementDataFile = a%02d.raw 0 1 1\n"), CVOL_ERROR_UNSUPPORTED, "a%02d", "");
    read_fails(MHD("HeaderSize = -2\nElementDataFile = m.raw\n"), CVOL_ERROR_FORMAT, "HeaderSize",
               "-2");
    read_fails(MHD("CompressedData = True\nHeaderSize = -1\nElementDataFile = m.zraw\n"),
               CVOL_ERROR_FORMAT, "HeaderSize", "-1");
    read_fails(MHD("ElementDataFile = \n"), CVOL_ERROR_FORMAT, "ElementDataFile", "");
}

static void test_meta_lies(void **state)
{
    (void)state;
#define MHA(size, dims, type, more) \
    meta(META "DimSize = " dims "\nElementType = " type "\n" more "ElementDataFile = LOCAL\n", size)
    read_fails(MHA(12, "2 0 2", "MET_UCHAR", ""), CVOL_ERROR_FORMAT, "DimSize", "'0'");
    read_fails(MHA(12, "2 -3 2", "MET_UCHAR", ""), CVOL_ERROR_FORMAT, "DimSize", "'-3'");
    read_fails(MHA(12, "2 3", "MET_UCHAR", ""), CVOL_ERROR_FORMAT,
               "DimSize has 2 values, NDims is 3", "");
    read_fails(MHA(12, "2 3 2k", "MET_UCHAR", ""), CVOL_ERROR_FORMAT, "DimSize", "2k");
    read_fails_large(MHA(12, "2147483648 2 2", "MET_UCHAR", ""), CVOL_ERROR_FORMAT,
                     "12 of the 8589934592");
    read_fails(MHA(12, "2147483648 2147483648 2147483648", "MET_UCHAR", ""), CVOL_ERROR_LIMIT,
               "2147483648", "");
    read_fails(MHA(11, "2 3 2", "MET_UCHAR", ""), CVOL_ERROR_FORMAT, "11 of the 12 bytes", "");
    read_fails(MHA(14, "2 3 2", "MET_UCHAR", ""), CVOL_ERROR_FORMAT, "2 bytes more", "");
    read_fails(MHA(12, "2 3 2", "MET_STRING", ""), CVOL_ERROR_UNSUPPORTED, "ElementType",
               "MET_STRING");
    read_fails(MHA(12, "2 3 2", "MET_LONG_LONG", ""), CVOL_ERROR_FORMAT, "12 of the 96 bytes", "");
    read_fails(MHA(12, "2 3 2", "int", ""), CVOL_ERROR_FORMAT, "ElementType", "int");
    read_fails(MHA(12, "2 3 2", "MET_UCHAR", "ElementNumberOfChannels = 3\n"),
               CVOL_ERROR_UNSUPPORTED, "ElementNumberOfChannels '3'",
               "each channel into a file of its own");
    read_fails(MHA(12, "2 3 2", "MET_UCHAR", "CompressedData = True\n"), CVOL_ERROR_FORMAT,
               "damaged", "");
    read_fails(MHA(12, "900 900 900", "MET_UCHAR", "CompressedData = True\n"), CVOL_ERROR_FORMAT,
               "cannot hold", "729000000");
    read_fails(MHA(12, "2 3 2", "MET_UCHAR", "CompressedData = Maybe\n"), CVOL_ERROR_FORMAT,
               "CompressedData", "Maybe");
    read_fails(MHA(12, "2 3 2", "MET_UCHAR", "ElementSpacing = 1 1 -1\n"), CVOL_ERROR_FORMAT,
               "spacing of axis z", "-1");
    read_fails(MHA(12, "2 3 2", "MET_UCHAR", "ElementSpacing = 1 nan 1\n"), CVOL_ERROR_FORMAT,
               "spacing of axis y", "nan");
    read_fails(MHA(12, "2 3 2", "MET_UCHAR", "Offset = 1 inf 1\n"), CVOL_ERROR_FORMAT, "origin",
               "inf");
    read_fails(MHA(12, "2 3 2", "MET_UCHAR", "TransformMatrix = 1 0 0 0 1 0 0 0\n"),
               CVOL_ERROR_FORMAT, "TransformMatrix has 8 values", "9");
    read_fails(MHA(12, "2 3 2", "MET_UCHAR", "TransformMatrix = 1 0 0 0 1 0 0 0 0\n"),
               CVOL_ERROR_FORMAT, "TransformMatrix", "length");
    read_fails(MHA(12, "2 3 2", "MET_UCHAR", SLOPE "1 2\n"), CVOL_ERROR_FORMAT,
               "Slope has 2 values, the needed number is 1", "");
    read_fails(MHA(12, "2 3 2", "MET_UCHAR", SLOPE "inf\n"), CVOL_ERROR_FORMAT, "value scale inf",
               "not finite");
    read_fails(MHA(12, "2 3 2", "MET_UCHAR", "DimSize = 2 3 2\n"), CVOL_ERROR_FORMAT,
               "'DimSize' twice", "");
    read_fails(MHA(12, "2 3 2", "MET_UCHAR", "nonsense\n"), CVOL_ERROR_FORMAT, "line 5",
               "nonsense");
    read_fails(MHA(12, "2 3 2", "MET_UCHAR", "HeaderSize = 4\n"), CVOL_ERROR_FORMAT, "HeaderSize",
               "4");
    read_fails(meta("ObjectType = Image\nNDims = 4\nDimSize = 2 3 2 1\nElementType = MET_UCHAR\n"
                    "ElementDataFile = LOCAL\n",
                    12),
               CVOL_ERROR_UNSUPPORTED, "NDims '4'", "");
    read_fails(meta("ObjectType = Tube\nNDims = 3\nDimSize = 2 3 2\nElementType = MET_UCHAR\n"
                    "ElementDataFile = LOCAL\n",
                    12),
               CVOL_ERROR_UNSUPPORTED, "ObjectType 'Tube'", "");
    read_fails(meta(META "DimSize = 2 3 2\nElementType = MET_UCHAR\n", 0), CVOL_ERROR_FORMAT,
               "no 'ElementDataFile'", "");
    read_fails(meta("rubbish", 30), CVOL_ERROR_FORMAT, "line 1", "rubbish");
}

int main(void)
{
    const struct CMUnitTest reading[] = {
        cmocka_unit_test(test_meta_plain),  cmocka_unit_test(test_meta_types),
        cmocka_unit_test(test_meta_scales), cmocka_unit_test(test_meta_detached),
        cmocka_unit_test(test_meta_lies),
    };
    return cmocka_run_group_tests(reading, files_setup, files_teardown) != 0;
}
