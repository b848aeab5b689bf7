/* Volumes of other tools' formats: the parsers, the written files, and damage.
 * tests/cli/test_formats.sh reads files that these tools write. */
#include "test.h"

#include <sys/stat.h>
#include <unistd.h>

#include "cvol/volume.h"
#include "random.h"
#include "support.h"
#include "support_volume.h"
#include "volume/formats/tiff/stack.h"
#include "volume/formats/vtk/vti_data.h"
#include "volume/io/folder.h"
#include "volume/io/input.h"
#include "volume/io/strided.h"
#include "volume/io/unit.h"
#include "volume/io/xml.h"

/* ---- parsers -------------------------------------------------------------------------- */

static void test_natural_order(void **state)
{
    (void)state;
    static const char *const ordered[] = {"a",     "a1", "a1b", "a2", "a10",
                                          "a010b", "b0", "b00", "ba"};
    const int count = sizeof ordered / sizeof *ordered;
    for (int i = 0; i < count; i++)
        for (int j = 0; j < count; j++) {
            int order = cvol_folder_compare(ordered[i], ordered[j]);
            int sign = (order > 0) - (order < 0), wanted = (i > j) - (i < j);
            if (strspn(ordered[i], "b0") == strlen(ordered[i]) &&
                strspn(ordered[j], "b0") == strlen(ordered[j]) && i != j)
                continue; /* equal numbers: any order, but the same in both directions */
            assert_int_equal(sign, wanted);
        }
    assert_int_equal(cvol_folder_compare("b0", "b00"), -cvol_folder_compare("b00", "b0"));
    assert_true(cvol_folder_compare("b0", "b00") != 0);
}

static void test_descriptions(void **state)
{
    (void)state;
    cvol_tiff_stack s;
    cvol_tiff_read_description(&s, NULL, 1);
    assert_false(s.known);
    cvol_tiff_read_description(&s, "{\"shape\": [3, 4]}", 1);
    assert_false(s.known);
    cvol_tiff_read_description(&s,
                               "ImageJ=1.5\nimages=12\nchannels=2\nslices=3\nframes=2\n"
                               "spacing=-1.5\nunit=\\u00B5m\n",
                               1);
    assert_true(s.known && s.slices == 3 && s.channels == 2 && s.times == 2);
    assert_true(s.channel_step == 1 && s.slice_step == 2 && s.time_step == 6);
    assert_true(s.spacing[2] == 1.5);
    assert_string_equal(s.unit[0], "\\u00B5m");
    assert_string_equal(s.unit[2], "\\u00B5m");
    cvol_tiff_read_description(&s, "ImageJ=1.5\nimages=7\nspacing=nan\nslices=-3\n", 1);
    assert_true(s.slices == 7 && s.spacing[2] == 0);
    cvol_tiff_read_description(
        &s,
        "<OME><Image><Pixels DimensionOrder=\"XYCZT\" SizeC=\"6\" SizeT='2' SizeX=\"4\" "
        "SizeY=\"4\" "
        "SizeZ=\"5\" PhysicalSizeX=\"0.5\" PhysicalSizeXUnit=\"nm\" PhysicalSizeZ=\"2\"/></Image>",
        3);
    assert_true(s.slices == 5 && s.channels == 2 && s.times == 2);
    assert_true(s.channel_step == 1 && s.slice_step == 2 && s.time_step == 10);
    assert_true(s.spacing[0] == 0.5 && s.spacing[1] == 0 && s.spacing[2] == 2);
    assert_string_equal(s.unit[0], "nm");
    assert_string_equal(s.unit[2], "um"); /* the default */
    cvol_tiff_read_description(&s, "ImageJ=1.5\nimages=2\nunit=mm\nzunit=micron\n", 1);
    assert_string_equal(s.unit[1], "mm");
    assert_string_equal(s.unit[2], "micron");
    cvol_tiff_read_description(
        &s, "<OME><Pixels DimensionOrder=\"XYZZZ\" SizeC=\"2\" SizeT=\"3\" SizeZ=\"5\">", 1);
    assert_true(s.slice_step == 1 && s.channel_step == 5 && s.time_step == 10);
}

/* Factors of three units, and the common one. */
static void check_units(const char *x, const char *y, const char *z, const char *common,
                        double of_y, double of_z)
{
    const char *const unit[3] = {x, y, z};
    double factor[3];
    char found[16];
    assert_true(cvol_unit_factors(factor, found, unit));
    assert_string_equal(found, common);
    assert_true(factor[0] == 1 && factor[1] == of_y && factor[2] == of_z);
}

static void test_units(void **state)
{
    (void)state;
    check_units("um", "\xc2\xb5m", "mm", "um", 1, 1000);
    check_units("millimeter", "um", "nm", "mm", 1e-3, 1e-6);
    check_units("in", "cm", "", "inch", 1e10 / 2.54e10, 1);
    check_units("", "mm", "um", "mm", 1, 1e-3);
    check_units("s", "s", "", "s", 1, 1);
    check_units("", "", "", "", 1, 1);
    double factor[3];
    char found[16];
    assert_false(cvol_unit_factors(factor, found, (const char *const[3]){"mm", "mm", "s"}));
    assert_false(cvol_unit_factors(factor, found, (const char *const[3]){"s", "ms", "s"}));
    assert_true(cvol_unit_metres("cm") == 1e-2 && cvol_unit_metres("micron") == 1e-6);
    assert_true(cvol_unit_metres("") == 0 && cvol_unit_metres("mmm") == 0);
}

/* One channel, whose element gives its name and colour. */
static cvol_channel_label label_of(const char *attributes)
{
    char text[400];
    snprintf(text, sizeof text,
             "<?xml version=\"1.0\"?><!-- > --><OME><Image Name=\"no\"><Pixels SizeC=\"1\" "
             "TimeIncrement=\"nan\"><Channel ID=\"a>b\" %s><Name/></Channel><Channel "
             "Name=\"second\"/></Pixels><Pixels><Channel Name=\"third\"/></Pixels></Image></OME>",
             attributes);
    cvol_labels labels = {.channels = 0};
    assert_true(cvol_tiff_read_labels(&labels, text, 1, 1));
    assert_true(labels.channels == 1 && labels.time_step == 0);
    const cvol_channel_label label = labels.channel[0];
    free(labels.channel);
    return label;
}

static void test_labels(void **state)
{
    (void)state;
    assert_string_equal(label_of("").name, "");
    assert_string_equal(label_of("Name='&lt;&amp;lt;&gt;'").name, "<&lt;>");
    assert_string_equal(label_of("Name=\"a\nb\"").name, ""); /* does not take a line */
    assert_string_equal(label_of("Name=\"\xff\"").name, "");
    assert_string_equal(label_of("Name=\"\xed\xa0\x80\"").name, "");
    assert_string_equal(label_of("Name=\"\xce\"").name, "");
    char name[64 + 3 * 30] = "Name=\"x";
    for (int i = 0; i < 30; i++)
        strcat(name, "\xe2\x82\xac");
    assert_int_equal(strlen(label_of(strcat(name, "\"")).name), 61); /* 20 of three bytes */
    const cvol_channel_label red = label_of("Color=\"-16776961\"");
    assert_true(red.has_colour && red.colour[0] == 1 && red.colour[1] == 0 && red.colour[2] == 0);
    assert_false(label_of("Color=\"99999999999\"").has_colour);
    cvol_labels labels = {.channels = 0};
    assert_true(cvol_tiff_read_labels(&labels, "ImageJ=1\nfinterval=2\ntunit=min\n", 3, 1));
    assert_true(labels.time_step == 2 && labels.channels == 0);
    assert_string_equal(labels.time_unit, "min");
}

static void test_base64(void **state)
{
    (void)state;
    const struct {
        const char *text, *bytes;
    } cases[] = {
        {"", ""},
        {"TQ==", "M"},
        {"TWE=", "Ma"},
        {"TWFu", "Man"},
        {"TQ==TWFu", "MMan"},
        {"T W\nFu<TWFu", "Man"},
        {"TWE=TWE=", "MaMa"},
        {"TWFuT", "Man"},
    };
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        uint8_t text[32];
        memcpy(text, cases[i].text, strlen(cases[i].text));
        assert_int_equal(cvol_vti_base64(text, strlen(cases[i].text)), strlen(cases[i].bytes));
        assert_memory_equal(text, cases[i].bytes, strlen(cases[i].bytes));
    }
}

static void test_xml(void **state)
{
    (void)state;
    cvol_xml_tag tag;
    size_t length;
    const char *text = "<?xml v?><!-- <a> --><b c=\"1>2\" d = 'e'/></b><open";
    assert_true(cvol_xml_next(&tag, text));
    assert_true(cvol_xml_is(&tag, "b") && tag.is_empty && !tag.closes);
    const char *value = cvol_xml_attribute(&tag, "c", &length);
    assert_true(value && length == 3 && !memcmp(value, "1>2", 3));
    value = cvol_xml_attribute(&tag, "d", &length);
    assert_true(value && length == 1 && *value == 'e');
    assert_null(cvol_xml_attribute(&tag, "e", &length));
    assert_true(cvol_xml_next(&tag, tag.end + 1) && tag.closes);
    assert_false(cvol_xml_next(&tag, tag.end + 1));
}

/* Half floats against their definition. */
static void test_half(void **state)
{
    (void)state;
    const struct {
        uint16_t half;
        float value;
    } cases[] = {{0x3c00, 1},           {0xc000, -2},       {0x7bff, 65504},   {0x0001, 0x1p-24f},
                 {0x83ff, -0x3ffp-24f}, {0x0400, 0x1p-14f}, {0x7c00, INFINITY}};
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++)
        for (int big = 0; big < 2; big++) {
            cvol_grid grid = cvol_grid_make(1, 1, 1, CVOL_FLOAT32);
            cvol_strided strided = {.size = 2, .big_endian = big, .is_half = 1};
            cvol_stored stored = {.offset = 0};
            strided.data = malloc(2);
            assert_non_null(strided.data);
            strided.data[big] = (uint8_t)cases[i].half;
            strided.data[!big] = (uint8_t)(cases[i].half >> 8);
            check_ok(cvol_strided_take(context, &stored, &strided, &grid, "half"));
            float value;
            check_ok(stored.slices.read(context, stored.slices.state, &value, 0, 1));
            assert_true(value == cases[i].value);
            stored.slices.close(stored.slices.state);
        }
    cvol_grid grid = cvol_grid_make(2, 1, 1, CVOL_FLOAT32);
    cvol_strided strided = {.data = malloc(8), .size = 8, .first = 1, .stride = {1, 1, 1}};
    cvol_stored stored = {.offset = 0};
    assert_int_equal(cvol_strided_take(context, &stored, &strided, &grid, "x"), CVOL_ERROR_FORMAT);
    stored.slices.close(stored.slices.state);
}

static void test_names_inside(void **state)
{
    (void)state;
    char name[512];
    const char *path = write_bytes("f.h5", "x", 1);
    assert_int_equal(cvol_input_file_length(path), strlen(path));
    snprintf(name, sizeof name, "%s:/a:b", path);
    assert_int_equal(cvol_input_file_length(name), strlen(path));
    read_fails(name, CVOL_ERROR_IO, "no such file", "before the colon");
    assert_int_equal(cvol_input_file_length("no:such/file"), strlen("no:such/file"));
    remove(path);
}

/* ---- written files -------------------------------------------------------------------- */

static const char *const written[] = {"w.tif", "w.npy", "w.vti"};
#define WRITTEN (sizeof written / sizeof *written)

static int reads(const char *ending)
{
    return strstr(cvol_volume_readers(), ending) != NULL;
}

static void test_round_trip(void **state)
{
    (void)state;
    for (size_t f = 0; f < WRITTEN; f++)
        for (int type = CVOL_UINT8; type <= CVOL_FLOAT64; type++) {
            if (!reads(strrchr(written[f], '.')))
                continue;
            cvol_grid grid = odd_grid((cvol_type)type, type % 2);
            cvol_volume *volume = make_volume(&grid, (uint64_t)type), *back;
            check_ok(cvol_volume_write(context, volume, in_folder(written[f])));
            back = read_ok(in_folder(written[f]));
            same_samples(volume, back);
            for (int a = 0; a < 3 && f != 1; a++)
                near(back->grid.spacing[a], grid.spacing[a], 1e-6);
            if (f == 2)
                for (int i = 0; i < 9; i++)
                    near(back->grid.direction[i / 3][i % 3] + 2, grid.direction[i / 3][i % 3] + 2,
                         1e-12);
            cvol_volume_free(volume);
            cvol_volume_free(back);
        }
}

/* Most spacings have no short fraction. */
static void test_tiff_spacing(void **state)
{
    (void)state;
    if (!reads(".tif"))
        skip();
    const double spacings[] = {1, 1e-4, 0.123456789, 40, 3333.3, 3.14159265358979, 1e6};
    for (size_t i = 0; i < sizeof spacings / sizeof *spacings; i++) {
        cvol_grid grid = cvol_grid_make(3, 2, 1, CVOL_UINT8);
        grid.spacing[0] = spacings[i];
        cvol_volume *volume = make_volume(&grid, 3);
        check_ok(cvol_volume_write(context, volume, in_folder("s.tif")));
        cvol_volume *back = read_ok(in_folder("s.tif"));
        near(back->grid.spacing[0], spacings[i], 1e-6);
        cvol_volume_free(volume);
        cvol_volume_free(back);
    }
}

/* ---- damage --------------------------------------------------------------------------- */

/* No prefix is readable, except one that lacks only VTK's closing tags; a changed byte never does
 * more than fail. */
static void test_damage(void **state)
{
    (void)state;
    random_state r = {78};
    for (size_t f = 0; f < WRITTEN; f++) {
        if (!reads(strrchr(written[f], '.')))
            continue;
        size_t size;
        cvol_grid grid = cvol_grid_make(4, 3, 2, CVOL_INT16);
        cvol_volume *volume = make_volume(&grid, 9), *back;
        check_ok(cvol_volume_write(context, volume, in_folder(written[f])));
        uint8_t *bytes = support_read(in_folder(written[f]), &size);
        static const size_t spare[WRITTEN] = {0, 0, sizeof "\n  </AppendedData>\n</VTKFile>\n" - 1};
        const size_t needed = size - spare[f];
        for (size_t cut = 1; cut < needed; cut += 1 + cut % SUPPORT_STRIDE) {
            write_bytes(written[f], bytes, cut);
            if (cvol_volume_read(context, &back, in_folder(written[f]), NULL) >= 0)
                fail_msg("%s: %zu of %zu bytes are read", written[f], cut, size);
            assert_true(strlen(cvol_context_message(context)) > 0);
        }
        for (int i = 0; i < 1500 / SUPPORT_STRIDE; i++) {
            size_t at = random_below(&r, (uint32_t)size);
            uint8_t before = bytes[at];
            bytes[at] = (uint8_t)random_u64(&r);
            write_bytes(written[f], bytes, size);
            if (cvol_volume_read(context, &back, in_folder(written[f]), NULL) == CVOL_OK)
                cvol_volume_free(back);
            bytes[at] = before;
        }
        free(bytes);
        cvol_volume_free(volume);
    }
}

/* Headers with false sizes are detected before memory is allocated. */
static void test_lies(void **state)
{
    (void)state;
    read_fails(write_text("l.npy", "",
                          "\x93NUMPY\1\0\x4b\0{'descr': '<f4', 'fortran_order': False, "
                          "'shape': (99999, 99999, 99999), }\n",
                          85),
               CVOL_ERROR_FORMAT, "99999, 99999", "bytes of samples");
    read_fails(write_text("l.npy", "",
                          "\x93NUMPY\1\0\x4b\0{'descr': '<f4', 'fortran_order': False, "
                          "'shape': (0, 99999, 99999), }    \n",
                          85),
               CVOL_ERROR_FORMAT, "'shape' is (0", "no samples");
    uint8_t mrc[1024] = {0};
    memcpy(mrc + 208, "MAP \x44\x44", 6);
    for (int i = 0; i < 3; i++)
        mrc[4 * i + 1] = 0x40;
    mrc[12] = 2;
    read_fails(write_bytes("l.mrc", mrc, sizeof mrc), CVOL_ERROR_FORMAT, "1024 bytes",
               "16384 x 16384");
    mrc[3] = 0x80;
    read_fails(write_bytes("l.mrc", mrc, sizeof mrc), CVOL_ERROR_FORMAT, "NC is -", "positive");
    mrc[3] = 0;
    mrc[64] = 7;
    read_fails(write_bytes("l.mrc", mrc, sizeof mrc), CVOL_ERROR_FORMAT, "MAPC, MAPR, MAPS are 7",
               "");
    memcpy(mrc + 64, "\1\0\0\0\2\0\0\0\3\0\0\0", 12);
    memcpy(mrc + 40, "\0\0\xc0\x7f", 4); /* NaN */
    read_fails(write_bytes("l.mrc", mrc, sizeof mrc), CVOL_ERROR_FORMAT, "CELLA X is nan", "");
    read_fails(write_text("l.vtk",
                          "# vtk DataFile Version 3.0\nt\nBINARY\nDATASET STRUCTURED_POINTS\n"
                          "DIMENSIONS 4000000000 4000000000 4000000000\nPOINT_DATA 8\n",
                          "", 0),
               CVOL_ERROR_LIMIT, "4000000000", "");
    read_fails(write_text("l.vtk",
                          "# vtk DataFile Version 3.0\nt\nBINARY\nDATASET STRUCTURED_POINTS\n"
                          "DIMENSIONS 2 2 2\nSPACING 1 nan 1\nPOINT_DATA 8\nSCALARS a int\n",
                          counting, 32),
               CVOL_ERROR_FORMAT, "spacing of axis y is nan", "");
    read_fails(write_text("l.vti",
                          "<VTKFile type=\"ImageData\"><ImageData WholeExtent=\"0 1 0 1 0 -1\">",
                          "", 0),
               CVOL_ERROR_FORMAT, "WholeExtent", "0 -1");
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_natural_order), cmocka_unit_test(test_descriptions),
        cmocka_unit_test(test_units),         cmocka_unit_test(test_labels),
        cmocka_unit_test(test_base64),        cmocka_unit_test(test_xml),
        cmocka_unit_test(test_half),          cmocka_unit_test(test_names_inside),
        cmocka_unit_test(test_round_trip),    cmocka_unit_test(test_tiff_spacing),
        cmocka_unit_test(test_damage),        cmocka_unit_test(test_lies),
    };
    return cmocka_run_group_tests(tests, files_setup, files_teardown);
}
