/* VTK: the readers of legacy files and of .vti on hand-made files, valid ones and every kind of
 * invalid one. tests/cli reads those of VTK's own writers. */
#include "test.h"

#include <zlib.h>

#include "cvol/volume.h"
#include "support_volume.h"

/* ---- legacy files ----------------------------------------------------------------------- */

#define LEGACY "# vtk DataFile Version 3.0\na title\n"
#define POINTS                                                                        \
    "DATASET STRUCTURED_POINTS\nDIMENSIONS 2 3 2\nORIGIN 1 2.5 -3\nSPACING 0.5 1 2\n" \
    "POINT_DATA 12\n"

static const char *legacy(const char *text, size_t size)
{
    return write_text("a.vtk", text, counting, size);
}

static void test_legacy(void **state)
{
    (void)state;
    cvol_volume *v = read_ok(legacy(LEGACY "BINARY\n" POINTS "SCALARS s short\n"
                                           "LOOKUP_TABLE default\n",
                                    24));
    assert_int_equal(((int16_t *)v->data)[11], 23 << 8 | 24);
    assert_true(v->grid.spacing[0] == 0.5 && v->grid.origin[1] == 2.5);
    cvol_volume_free(v);
    v = read_ok(legacy(LEGACY "ASCII\n" POINTS "scalars s unsigned_char 1\nlookup_table default\n"
                              "1 2 3 4 5 6\n7 8 9 10 11 12\n",
                       0));
    assert_memory_equal(v->data, counting, 12);
    cvol_volume_free(v);
    v = read_ok(
        legacy(LEGACY "BINARY\n" POINTS "FIELD FieldData 2\nfirst 1 12 unsigned_short\n", 24));
    assert_int_equal(v->grid.type, CVOL_UINT16);
    assert_int_equal(((uint16_t *)v->data)[1], 3 << 8 | 4);
    cvol_volume_free(v);
}

static void test_legacy_components(void **state)
{
    (void)state;
    static const char *const arrays[] = {"FIELD FieldData 1\nv 3 12 char\n",
                                         "SCALARS v char 3\nLOOKUP_TABLE default\n",
                                         "COLOR_SCALARS v 3\n"};
    for (size_t i = 0; i < sizeof arrays / sizeof *arrays; i++)
        for (int channel = 0; channel < 3; channel++) {
            const cvol_read_options options = {
                .size = sizeof options, .has_channel = 1, .channel = channel};
            char text[400];
            cvol_volume *v;
            snprintf(text, sizeof text, LEGACY "BINARY\n" POINTS "%s", arrays[i]);
            check_ok(cvol_volume_read(context, &v, legacy(text, 36), &options));
            for (int k = 0; k < 12; k++)
                assert_int_equal(((int8_t *)v->data)[k], counting[3 * k + channel]);
            cvol_volume_free(v);
        }
}

static void test_bad_legacy(void **state)
{
    (void)state;
    static const struct {
        const char *text;
        int code;
        const char *words;
    } bad[] = {
        {LEGACY "TEXT\n", CVOL_ERROR_FORMAT, "its third line is neither BINARY nor ASCII"},
        {LEGACY "BINARY\n" POINTS, CVOL_ERROR_FORMAT, "ends without an array of point data"},
        {LEGACY "BINARY\nDATASET POLYDATA\n", CVOL_ERROR_UNSUPPORTED, "only STRUCTURED_POINTS"},
        {LEGACY "BINARY\nDATASET\n", CVOL_ERROR_UNSUPPORTED, "only STRUCTURED_POINTS"},
        {LEGACY "BINARY\nDATASET STRUCTURED_POINTS\nDIMENSIONS 2 3 2\nPOINT_DATA 13\n",
         CVOL_ERROR_FORMAT, "DIMENSIONS do not match the points of 'POINT_DATA 13'"},
        {LEGACY "BINARY\nDATASET STRUCTURED_POINTS\nPOINT_DATA 1\n", CVOL_ERROR_FORMAT,
         "DIMENSIONS do not match"},
        {LEGACY "BINARY\nDATASET STRUCTURED_POINTS\nDIMENSIONS 2 3\n", CVOL_ERROR_FORMAT,
         "DIMENSIONS"},
        {LEGACY "BINARY\nDATASET STRUCTURED_POINTS\nORIGIN 2 x 3\n", CVOL_ERROR_FORMAT, "ORIGIN"},
        {LEGACY "BINARY\nDATASET STRUCTURED_POINTS\nSCALARS s char\n", CVOL_ERROR_FORMAT,
         "an unknown line in its header: 'SCALARS s char'"},
        {LEGACY "BINARY\nDATASET STRUCTURED_POINTS\nCELL_DATA 4\n", CVOL_ERROR_UNSUPPORTED,
         "only SCALARS of POINT_DATA can be read, not 'CELL_DATA 4'"},
        {LEGACY "BINARY\n" POINTS "VECTORS v float\n", CVOL_ERROR_UNSUPPORTED, "'VECTORS v float'"},
        {LEGACY "BINARY\n" POINTS "SCALARS s bit\n", CVOL_ERROR_FORMAT,
         "SCALARS of a type that is not supported"},
        {LEGACY "BINARY\n" POINTS "SCALARS s char 5\n", CVOL_ERROR_FORMAT,
         "SCALARS with an unsupported number of components"},
        {LEGACY "BINARY\n" POINTS "COLOR_SCALARS s 5\n", CVOL_ERROR_FORMAT,
         "colours that are not supported"},
        {LEGACY "ASCII\n" POINTS "COLOR_SCALARS s 3\n", CVOL_ERROR_FORMAT,
         "colours that are not supported"},
        {LEGACY "BINARY\n" POINTS "FIELD f 1\n", CVOL_ERROR_FORMAT, "without an array"},
        {LEGACY "BINARY\n" POINTS "FIELD f 1\na 1 11 float\n", CVOL_ERROR_FORMAT,
         "the first array of a FIELD does not have one sample per point: 'a 1 11 float'"},
        {LEGACY "BINARY\n" POINTS "FIELD f 1\na 65 12 float\n", CVOL_ERROR_FORMAT, "of a FIELD"},
        {LEGACY "BINARY\n" POINTS "FIELD f 1\na 1 12\n", CVOL_ERROR_FORMAT, "of a FIELD"},
    };
    for (size_t i = 0; i < sizeof bad / sizeof *bad; i++)
        read_fails(legacy(bad[i].text, 0), bad[i].code, bad[i].words, "");
    const cvol_read_options options = {.size = sizeof options, .has_channel = 1, .channel = 1};
    read_fails_with(
        legacy(LEGACY "ASCII\n" POINTS "SCALARS s char 2\nLOOKUP_TABLE default\n1 2", 0), &options,
        CVOL_ERROR_UNSUPPORTED, "2 components as text", "");
    read_fails(legacy(LEGACY "BINARY\n" POINTS "SCALARS s char\nLOOKUP_TABLE default\n", 11),
               CVOL_ERROR_FORMAT, "", "");
}

/* ---- .vti ------------------------------------------------------------------------------- */

#define FILE_TAG "<?xml version=\"1.0\"?>\n<VTKFile type=\"ImageData\" version=\"0.1\""
#define IMAGE "><ImageData WholeExtent=\"1 2 0 2 0 1\" Origin=\"1 2 3\" Spacing=\"0.5 1 2\">"
#define PIECE "<Piece Extent=\"1 2 0 2 0 1\"><PointData Scalars=\"s\">"
#define LAST "</PointData></Piece></ImageData>"
#define LITTLE " byte_order=\"LittleEndian\" header_type=\"UInt64\""
#define ZLIB LITTLE " compressor=\"vtkZLibDataCompressor\""
#define APPENDED(type)                                                                \
    "<DataArray type=\"" type "\" Name=\"s\" format=\"appended\" offset=\"0\"/>" LAST \
    "<AppendedData encoding=\"raw\">_"

static uint8_t data[1024];
static size_t data_size;

static void put_word(uint64_t value)
{
    for (int i = 0; i < 8; i++)
        data[data_size++] = (uint8_t)(value >> 8 * i);
}

static const char *vti(const char *text)
{
    return write_text("a.vti", text, data, data_size);
}

static void test_vti(void **state)
{
    (void)state;
    data_size = 0;
    cvol_volume *v = read_ok(
        vti(FILE_TAG LITTLE IMAGE PIECE
            "<DataArray type=\"Int8\" Name=\"other\" format=\"ascii\">9 9</DataArray>"
            "<DataArray type=\"UInt8\" Name=\"s\" format=\"ascii\">1 2 3 4 5 6 7 8 9 10 11 12"
            "</DataArray>" LAST "</VTKFile>"));
    assert_memory_equal(v->data, counting, 12);
    assert_true(v->grid.origin[0] == 1.5 && v->grid.spacing[2] == 2); /* that of index 1 */
    cvol_volume_free(v);
    v = read_ok(vti(FILE_TAG LITTLE IMAGE PIECE
                    "<DataArray type=\"UInt8\" format=\"binary\">DAAAAAAAAAABAgMEBQYHCAkKCww="
                    "</DataArray>" LAST));
    assert_memory_equal(v->data, counting, 12);
    cvol_volume_free(v);
    put_word(24);
    memcpy(data + data_size, counting, 24);
    data_size += 24;
    v = read_ok(vti(FILE_TAG LITTLE IMAGE PIECE APPENDED("UInt16")));
    assert_int_equal(((uint16_t *)v->data)[11], 24 << 8 | 23);
    cvol_volume_free(v);
    /* More than the MiB that is read first stands before the appended data. */
    const size_t longer = (size_t)1 << 20;
    const char *const begin = FILE_TAG LITTLE IMAGE, *const end = PIECE APPENDED("UInt16");
    char *text = calloc(1, longer + strlen(begin) + strlen(end) + 1);
    assert_non_null(text);
    memset(stpcpy(text, begin), ' ', longer);
    strcat(text, end);
    v = read_ok(vti(text));
    assert_int_equal(((uint16_t *)v->data)[11], 24 << 8 | 23);
    cvol_volume_free(v);
    free(text);
}

/* Blocks of 8 bytes and one of 4. */
static void put_blocks(void)
{
    data_size = 0;
    put_word(2);
    put_word(8);
    put_word(4);
    const size_t sizes_at = data_size;
    data_size += 16;
    size_t ends[2];
    for (size_t b = 0; b < 2; b++) {
        uLongf length = sizeof data - data_size;
        assert_int_equal(compress(data + data_size, &length, counting + 8 * b, b ? 4 : 8), Z_OK);
        data_size += length;
        ends[b] = length;
    }
    const size_t end = data_size;
    data_size = sizes_at;
    put_word(ends[0]);
    put_word(ends[1]);
    data_size = end;
}

static void test_packed_vti(void **state)
{
    (void)state;
    const char *text = FILE_TAG ZLIB IMAGE PIECE APPENDED("UInt8");
    put_blocks();
    cvol_volume *v = read_ok(vti(text));
    assert_memory_equal(v->data, counting, 12);
    cvol_volume_free(v);
    static const struct {
        size_t at;
        uint8_t byte;
        const char *words;
    } bad[] = {
        {0, 3, "its array has 20 bytes, not 12"}, {7, 1, "its array has blocks of 8 bytes"},
        {8, 7, "its array has 11 bytes, not 12"}, {16, 9, "its array has blocks of 8 bytes"},
        {24, 3, "is damaged or cut off"},         {24, 250, "is damaged or cut off"},
        {48, 77, "is damaged or cut off"},
    };
    for (size_t i = 0; i < sizeof bad / sizeof *bad; i++) {
        put_blocks();
        data[bad[i].at] = bad[i].byte;
        read_fails(vti(text), CVOL_ERROR_FORMAT, bad[i].words, "");
    }
    put_blocks();
    data_size = 23;
    read_fails(vti(text), CVOL_ERROR_FORMAT, "has a header cut off at 23 bytes, not 24", "");
}

static void test_bad_vti(void **state)
{
    (void)state;
    static const struct {
        const char *text;
        int code;
        const char *words;
    } bad[] = {
        {"<VTKFile type=\"PolyData\" ImageData=\"\">", CVOL_ERROR_UNSUPPORTED, "'PolyData'"},
        {FILE_TAG " compressor=\"vtkLZ4DataCompressor\"" IMAGE, CVOL_ERROR_UNSUPPORTED,
         "compressor 'vtkLZ4DataCompressor' is not supported"},
        {FILE_TAG ">", CVOL_ERROR_FORMAT, "has no ImageData element"},
        {FILE_TAG IMAGE PIECE LAST, CVOL_ERROR_FORMAT, "has no array of point data"},
        {FILE_TAG "><ImageData WholeExtent=\"1 0 0 2 0 1\">", CVOL_ERROR_FORMAT,
         "WholeExtent is '1 0 0 2 0 1'"},
        {FILE_TAG "><ImageData WholeExtent=\"0 1 0 1 0 1\" Direction=\"0 0 0 0 1 0 0 0 1\">",
         CVOL_ERROR_FORMAT, "Direction is '0 0 0 0 1 0 0 0 1'"},
        {FILE_TAG "><ImageData WholeExtent=\"0 1 0 1\">", CVOL_ERROR_FORMAT, "WholeExtent"},
        {FILE_TAG IMAGE PIECE LAST "<Piece>", CVOL_ERROR_UNSUPPORTED, "has several pieces"},
        {FILE_TAG IMAGE PIECE "<DataArray type=\"Int64\">", CVOL_ERROR_UNSUPPORTED, "'Int64'"},
        {FILE_TAG IMAGE PIECE "<DataArray type=\"Int8\" NumberOfComponents=\"0\">",
         CVOL_ERROR_FORMAT, "NumberOfComponents is '0'"},
        {FILE_TAG IMAGE PIECE "<DataArray type=\"Int8\" offset=\"-1\">", CVOL_ERROR_FORMAT,
         "offset is '-1'"},
        {FILE_TAG IMAGE PIECE "<DataArray type=\"Int8\" format=\"hex\">", CVOL_ERROR_FORMAT,
         "format of its array is 'hex'"},
        {FILE_TAG IMAGE PIECE "<DataArray type=\"Int8\" format=\"appended\">", CVOL_ERROR_FORMAT,
         "has no appended data"},
        {FILE_TAG IMAGE PIECE "<DataArray type=\"Int8\" format=\"binary\">DAAAAAEC</DataArray>",
         CVOL_ERROR_FORMAT, "its array has"},
        {FILE_TAG LITTLE IMAGE PIECE APPENDED("Int8"), CVOL_ERROR_FORMAT,
         "its array has 0 bytes, but WholeExtent has 12"},
    };
    data_size = 0;
    for (size_t i = 0; i < sizeof bad / sizeof *bad; i++)
        read_fails(vti(bad[i].text), bad[i].code, bad[i].words, "");
    data[0] = 0;
    data_size = 1;
    read_fails(vti(FILE_TAG IMAGE), CVOL_ERROR_FORMAT, "has a NUL byte at byte", "");
    const cvol_read_options options = {.size = sizeof options, .has_channel = 1, .channel = 1};
    data_size = 0;
    read_fails_with(vti(FILE_TAG IMAGE PIECE
                        "<DataArray type=\"Int8\" NumberOfComponents=\"2\" format=\"ascii\">1 2"),
                    &options, CVOL_ERROR_UNSUPPORTED, "2 components as text", "");
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_legacy),     cmocka_unit_test(test_legacy_components),
        cmocka_unit_test(test_bad_legacy), cmocka_unit_test(test_vti),
        cmocka_unit_test(test_packed_vti), cmocka_unit_test(test_bad_vti),
    };
    return cmocka_run_group_tests(tests, files_setup, files_teardown);
}
