/* NRRD: the reader on hand-made headers, valid ones and every kind of invalid one. */
#include "test.h"

#include "base/byte_order.h"
#include "cvol/volume.h"
#include "support_context.h"
#include "support_volume.h"

#define NRRD_START "NRRD0004\n# a comment: with a colon\n"
/* 2 x 3 x 2 samples, as bytes 1 .. 24 */
#define SIZES "dimension: 3\nsizes: 2 3 2\n"

static const char *nrrd(const char *text, size_t size)
{
    return write_text("h.nrrd", text, counting, size);
}

static void test_nrrd_plain(void **state)
{
    (void)state;
    cvol_volume *v = read_ok(nrrd(NRRD_START "key:=value\ncontent: a thing\ntype: unsigned char\n"
                                             "dimension: 3\nsizes: 2 3 2\nspacings: 2 nan 0.5\n"
                                             "units: \"um\" \"um\" \"um\"\nencoding: raw\n\n",
                                  12));
    assert_int_equal(v->grid.dims[1], 3);
    assert_true(v->grid.spacing[0] == 2 && v->grid.spacing[1] == 1 && v->grid.spacing[2] == 0.5);
    assert_string_equal(v->grid.unit, "um");
    assert_int_equal(v->grid.space, CVOL_SPACE_UNKNOWN);
    assert_memory_equal(v->data, counting, 12);
    cvol_volume_free(v);
    /* carriage returns, other cases, version 1 */
    v = read_ok(nrrd("NRRD0001\r\nType: UINT8\r\ndimension: 3\r\nsizes: 2 3 2\r\n"
                     "encoding: RAW\r\n\r\n",
                     12));
    assert_memory_equal(v->data, counting, 12);
    cvol_volume_free(v);
}

static void check_unit(const char *stated, const char *expected)
{
    char text[256];
    snprintf(text, sizeof text,
             NRRD_START "type: uint8\n" SIZES "units: \"%s\" \"%s\" \"%s\"\nencoding: raw\n\n",
             stated, stated, stated);
    cvol_volume *v = read_ok(nrrd(text, 12));
    assert_string_equal(v->grid.unit, expected);
    cvol_volume_free(v);
}

/* Units of length have one name, and others are UTF-8 whatever the file has. */
static void test_nrrd_unit_names(void **state)
{
    (void)state;
    check_unit("\xc2\xb5m", "um");
    check_unit("\xb5m", "um"); /* Latin-1 */
    check_unit("\xc5", "A");
    check_unit("\xb5V", "\xc2\xb5V");
    check_unit("\xb5\xb5\xb5\xb5\xb5\xb5\xb5\xb5\xb5",
               "\xc2\xb5\xc2\xb5\xc2\xb5\xc2\xb5\xc2\xb5\xc2\xb5\xc2\xb5");
    check_unit("a\x9f\xff", "a?\xc3\xbf");
    check_unit("half a degree \xc2\xb0", "half a degree "); /* cut inside a character */
    check_unit("a third of \xf0\x9f\x8d\xb0\xf0\x9f\x8d\xb0", "a third of \xf0\x9f\x8d\xb0");
    check_unit("a fourth of \xf0\x9f\x8d\xb0", "a fourth of ");
}

static void test_nrrd_endian(void **state)
{
    (void)state;
    cvol_volume *v = read_ok(
        nrrd(NRRD_START "type: ushort\n" SIZES "endian: big\nencoding: raw\n\n", 24));
    for (int i = 0; i < 12; i++)
        assert_int_equal(((uint16_t *)v->data)[i], (2 * i + 1) << 8 | (2 * i + 2));
    cvol_volume_free(v);
    v = read_ok(nrrd(NRRD_START "type: uint32\ndimension: 3\nsizes: 1 3 2\nendian: little\n"
                                "encoding: raw\n\n",
                     24));
    assert_int_equal(((uint32_t *)v->data)[1], 0x08070605);
    cvol_volume_free(v);
    double value = 0.1;
    uint8_t big[8];
    for (int i = 0; i < 8; i++)
        big[cvol_machine_is_big_endian() ? i : 7 - i] = ((uint8_t *)&value)[i];
    v = read_ok(write_text("h.nrrd",
                           NRRD_START "type: double\ndimension: 3\nsizes: 1 1 1\n"
                                      "endian: big\nencoding: raw\n\n",
                           big, 8));
    assert_true(*(double *)v->data == 0.1);
    cvol_volume_free(v);
    read_fails(nrrd(NRRD_START "type: short\n" SIZES "encoding: raw\n\n", 24), CVOL_ERROR_FORMAT,
               "endian", "short");
    read_fails(nrrd(NRRD_START "type: short\n" SIZES "endian: middle\nencoding: raw\n\n", 24),
               CVOL_ERROR_FORMAT, "endian", "middle");
}

static void test_nrrd_types(void **state)
{
    (void)state;
    static const struct {
        const char *name;
        cvol_type type;
    } names[] = {
        {"uchar", CVOL_UINT8},      {"uint8_t", CVOL_UINT8},
        {"signed char", CVOL_INT8}, {"int8", CVOL_INT8},
        {"short int", CVOL_INT16},  {"signed short int", CVOL_INT16},
        {"int16_t", CVOL_INT16},    {"unsigned short int", CVOL_UINT16},
        {"uint16", CVOL_UINT16},    {"signed int", CVOL_INT32},
        {"int", CVOL_INT32},        {"unsigned int", CVOL_UINT32},
        {"uint", CVOL_UINT32},      {"float", CVOL_FLOAT32},
        {"double", CVOL_FLOAT64},
    };
    for (size_t i = 0; i < sizeof names / sizeof names[0]; i++) {
        char text[200];
        snprintf(text, sizeof text,
                 "NRRD0005\ntype: %s\ndimension: 3\nsizes: 1 2 1\nendian: little\n"
                 "encoding: raw\n\n",
                 names[i].name);
        cvol_volume *v = read_ok(nrrd(text, 2 * cvol_type_size(names[i].type)));
        assert_int_equal(v->grid.type, names[i].type);
        cvol_volume_free(v);
    }
}

static void test_nrrd_text(void **state)
{
    (void)state;
    cvol_volume *v = read_ok(nrrd(NRRD_START "type: short\n" SIZES "encoding: ascii\n\n"
                                             "-32768 32767 3\n4,5, 6\r\n7\t8 9 10 11 12\n",
                                  0));
    assert_int_equal(((int16_t *)v->data)[0], -32768);
    assert_int_equal(((int16_t *)v->data)[11], 12);
    cvol_volume_free(v);
    v = read_ok(nrrd("NRRD0004\ntype: float\ndimension: 3\nsizes: 1 1 3\nencoding: txt\n\n"
                     "-1.5e3 nan .25",
                     0));
    assert_true(((float *)v->data)[0] == -1500 && isnan(((float *)v->data)[1]));
    cvol_volume_free(v);
#define TEXT(type) "NRRD0004\ntype: " type "\ndimension: 3\nsizes: 1 1 3\nencoding: text\n\n"
    read_fails(nrrd(TEXT("uint8") "1 2", 0), CVOL_ERROR_FORMAT, "2 of the 3 samples", "");
    read_fails(nrrd(TEXT("uint8") "1 2 3 4", 0), CVOL_ERROR_FORMAT, "4 of the 3 samples", "");
    read_fails(nrrd(TEXT("uint8") "1 256 3", 0), CVOL_ERROR_FORMAT, "'256'", "uint8");
    read_fails(nrrd(TEXT("uint8") "1 -1 3", 0), CVOL_ERROR_FORMAT, "'-1'", "sample 1");
    read_fails(nrrd(TEXT("int32") "1 2 12abc", 0), CVOL_ERROR_FORMAT, "'12abc'", "sample 2");
    read_fails(nrrd(TEXT("int32") "1 2 1.5", 0), CVOL_ERROR_FORMAT, "'1.5'", "int32");
    read_fails(nrrd(TEXT("uint32") "1 2 4294967296", 0), CVOL_ERROR_FORMAT, "4294967296", "");
    read_fails(nrrd(TEXT("float") "1 2 x", 0), CVOL_ERROR_FORMAT, "'x'", "float32");
    read_fails(nrrd(TEXT("float") "1 2 1e999999", 0), CVOL_ERROR_FORMAT, "1e999999", "");
}

static void test_nrrd_axes(void **state)
{
    (void)state;
#define TYPE8 "NRRD0004\ntype: uint8\n"
#define RAW "encoding: raw\n\n"
    cvol_volume *v = read_ok(nrrd(TYPE8 "dimension: 2\nsizes: 4 3\nspacings: 2 3\n" RAW, 12));
    assert_true(v->grid.dims[2] == 1 && v->grid.spacing[1] == 3 && v->grid.spacing[2] == 1);
    cvol_volume_free(v);
    v = read_ok(nrrd(TYPE8 "dimension: 4\nsizes: 1 4 3 1\nspacings: nan 2 3 4\n" RAW, 12));
    assert_true(v->grid.dims[0] == 1 && v->grid.dims[2] == 3 && v->grid.spacing[2] == 3);
    cvol_volume_free(v);
    v = read_ok(nrrd(TYPE8 "dimension: 4\nspace: LPS\nsizes: 1 4 3 1\n"
                           "space directions: none (2,0,0) (0,3,0) (0, 0, 4)\n" RAW,
                     12));
    assert_true(v->grid.dims[0] == 4 && v->grid.dims[2] == 1 && v->grid.spacing[2] == 4);
    cvol_volume_free(v);
    read_fails(nrrd(TYPE8 "dimension: 3\nsizes: 2 2 4\nkinds: domain space 4-COLOR\n" RAW, 16),
               CVOL_ERROR_UNSUPPORTED, "kinds 'domain space 4-COLOR'", "colours");
    v = read_ok(nrrd(TYPE8 "dimension: 3\nsizes: 2 3 2\nkinds: domain domain -color\n" RAW, 12));
    cvol_volume_free(v);
    read_fails(nrrd(TYPE8 "dimension: 5\nsizes: 1 1 2 3 2\n" RAW, 12), CVOL_ERROR_UNSUPPORTED,
               "dimension '5'", "");
    read_fails(nrrd(TYPE8 "dimension: 1\nsizes: 12\n" RAW, 12), CVOL_ERROR_UNSUPPORTED,
               "dimension '1'", "");
    read_fails(nrrd(TYPE8 "dimension: 17\nsizes: 12\n" RAW, 12), CVOL_ERROR_FORMAT,
               "dimension is 17", "");
    read_fails(nrrd(TYPE8 "dimension: 3\nspace: LPS\nsizes: 3 2 2\n"
                          "space directions: none (1,0,0) (0,1,0)\n" RAW,
                    12),
               CVOL_ERROR_UNSUPPORTED, "space directions", "none");
}

/* Reads the volume of a time or channel, 2 x 3 x 2 bytes. */
static cvol_volume *read_one(const char *path, int channel, int time)
{
    cvol_read_options options = cvol_read_options_defaults();
    cvol_volume *v;
    options.has_channel = channel >= 0;
    options.channel = channel;
    options.has_index = time >= 0;
    options.index = time;
    check_ok(cvol_volume_read(context, &v, path, &options));
    assert_true(v->grid.dims[0] == 2 && v->grid.dims[1] == 3 && v->grid.dims[2] == 2);
    return v;
}

static void check_counts(const char *path, int times, int channels)
{
    int found[2];
    check_ok(cvol_file_count_volumes(context, &found[0], &found[1], path, NULL));
    assert_int_equal(found[0], times);
    assert_int_equal(found[1], channels);
}

/* A volume of these bytes: first, first + step, ... */
static void check_bytes(cvol_volume *v, int first, int step)
{
    for (int i = 0; i < 12; i++)
        assert_int_equal(((const uint8_t *)v->data)[i], first + i * step);
    cvol_volume_free(v);
}

static void test_nrrd_volumes(void **state)
{
    (void)state;
    uint8_t packed[256];
    static const char *const colours[] = {"kinds: RGB-color domain domain domain\n",
                                          "kinds: 2-vector space space space\n", "",
                                          ("space: LPS\nspace directions: none (1,0,0) (0,1,0) "
                                           "(0,0,1)\n")};
    for (int k = 0; k < 4; k++) { /* mixed sample by sample */
        char text[300];
        const int channels = k ? 2 : 3;
        snprintf(text, sizeof text, TYPE8 "dimension: 4\nsizes: %d 2 3 2\n%s" RAW, channels,
                 colours[k]);
        const char *path = nrrd(text, 12 * (size_t)channels);
        check_counts(path, 1, channels);
        for (int c = 0; c < channels; c++)
            check_bytes(read_one(path, c, -1), 1 + c, channels);
    }
    const char *path = nrrd(TYPE8 "dimension: 4\nsizes: 2 3 2 3\nspacings: 1 1 1 0.5\n"
                                  "kinds: domain domain domain time\n" RAW,
                            36);
    check_counts(path, 3, 1);
    for (int t = 0; t < 3; t++)
        check_bytes(read_one(path, -1, t), 1 + 12 * t, 1);
    read_fails(path, CVOL_ERROR_ARGUMENT, "has 3 volumes", "--time 0 to 2");
    cvol_read_options one = cvol_read_options_defaults();
    cvol_volume_stream *stream;
    const char *unit;
    one.has_index = 1;
    check_ok(cvol_volume_stream_open(context, &stream, path, &one));
    assert_true(cvol_volume_stream_time_step(stream, &unit) == 0.5);
    cvol_volume_stream_free(stream);

    /* Packed: times behind each other, and channels of sequences, which are mixed. */
    size_t size = gzip(packed, sizeof packed, counting, 24, 15 + 16);
    path = write_text("g.nrrd",
                      TYPE8 "dimension: 4\nsizes: 2 3 2 2\nencoding: gzip\n"
                            "kinds: space space space list\n\n",
                      packed, size);
    check_counts(path, 2, 1);
    check_bytes(read_one(path, -1, 1), 13, 1);
    path = write_text("g.nrrd",
                      TYPE8 "dimension: 4\nsizes: 2 2 3 2\nencoding: gzip\n"
                            "kinds: list domain domain domain\n\n",
                      packed, size);
    check_counts(path, 2, 1);
    check_bytes(read_one(path, -1, 1), 2, 2);
    one.index = 0;
    read_fails_with(
        nrrd(TYPE8 "dimension: 4\nsizes: 2 2 3 2\nkinds: list domain domain domain\n" RAW, 23),
        &one, CVOL_ERROR_FORMAT, "23 of the 24 bytes", "");
    /* an axis of volumes that the header states, next to another one of size 1 */
    static const char *const facts[] = {
        "kinds: space space space time\n",
        "space: LPS\nspace directions: (1,0,0) (0,1,0) (0,0,1) none\n"};
    for (int i = 0; i < 2; i++) {
        char text[200];
        snprintf(text, sizeof text, TYPE8 "dimension: 4\nsizes: 3 1 4 2\n%s" RAW, facts[i]);
        path = nrrd(text, 24);
        check_counts(path, 2, 1);
        cvol_volume *v;
        one.index = 1;
        check_ok(cvol_volume_read(context, &v, path, &one));
        assert_true(v->grid.dims[0] == 3 && v->grid.dims[1] == 1 && v->grid.dims[2] == 4);
        check_bytes(v, 13, 1);
    }
    one.index = 0;
    read_fails_with(nrrd(TYPE8 "dimension: 4\nsizes: 2 3 2 2\nencoding: ascii\n"
                               "kinds: space space space list\n\n1 2 3",
                         0),
                    &one, CVOL_ERROR_UNSUPPORTED, "fourth axis", "");
}

static void test_nrrd_space(void **state)
{
    (void)state;
    cvol_volume *v = read_ok(nrrd(TYPE8 SIZES
                                  "space: left-anterior-superior\nspace origin: (1,2,3)\n"
                                  "space directions: (0,2,0) (-3,0,0) (0,0,0.25)\n"
                                  "space units: \"mm\" \"mm\" \"mm\"\n" RAW,
                                  12));
    assert_int_equal(v->grid.space, CVOL_SPACE_LPS); /* LAS, with the opposite second axis */
    assert_true(v->grid.origin[0] == 1 && v->grid.origin[1] == -2 && v->grid.origin[2] == 3);
    assert_true(v->grid.direction[0][1] == -1 && v->grid.direction[1][0] == -1);
    assert_true(v->grid.spacing[0] == 2 && v->grid.spacing[1] == 3 && v->grid.spacing[2] == 0.25);
    assert_string_equal(v->grid.unit, "mm");
    cvol_volume_free(v);
    /* an image in space gets its normal */
    v = read_ok(nrrd(TYPE8 "dimension: 2\nsizes: 4 3\nspace dimension: 3\n"
                           "space directions: (0,1,0) (0,0,1)\n" RAW,
                     12));
    assert_true(v->grid.direction[2][0] == 1 && v->grid.space == CVOL_SPACE_UNKNOWN);
    cvol_volume_free(v);
#define DIRECTIONS(text) nrrd(TYPE8 SIZES "space: RAS\nspace directions: " text "\n" RAW, 12)
    read_fails(DIRECTIONS("(1,0,0) (0,1,0)"), CVOL_ERROR_FORMAT, "space directions", "3 vectors");
    read_fails(DIRECTIONS("(1,0,0) (0,1,0) (0,0,1) (0,0,1)"), CVOL_ERROR_FORMAT, "more", "");
    read_fails(DIRECTIONS("(1,0,0) (0,1) (0,0,1)"), CVOL_ERROR_FORMAT, "of 3 numbers", "");
    read_fails(DIRECTIONS("(1,0,0) (0,1,0) (0,0,1"), CVOL_ERROR_FORMAT, "space directions", "");
    read_fails(DIRECTIONS("(1,0,0) (0,1x,0) (0,0,1)"), CVOL_ERROR_FORMAT, "1x", "");
    read_fails(DIRECTIONS("(1,0,0) (0,1,0) (0,0,0)"), CVOL_ERROR_FORMAT, "without a length", "");
    read_fails(DIRECTIONS("(1,0,0) (0,1,0) (nan,0,1)"), CVOL_ERROR_FORMAT, "length", "");
    read_fails(DIRECTIONS("(1,0,0) (0,1,0) (1,1,0)"), CVOL_ERROR_FORMAT, "span", "");
    read_fails(nrrd(TYPE8 SIZES "space: right-up\n" RAW, 12), CVOL_ERROR_UNSUPPORTED,
               "space 'right-up'", "");
    read_fails(nrrd(TYPE8 SIZES "space: RAS\nspace origin: (1,2)\n" RAW, 12), CVOL_ERROR_FORMAT,
               "space origin '(1,2)'", "");
    read_fails(nrrd(TYPE8 SIZES "spacings: 1 0 1\n" RAW, 12), CVOL_ERROR_FORMAT,
               "spacing of axis y is 0", "");
    read_fails(nrrd(TYPE8 SIZES "spacings: 1 1 1mm\n" RAW, 12), CVOL_ERROR_FORMAT,
               "spacings has the value '1mm'", "");
}

/* Axes of different units are converted to that of x. */
static void test_nrrd_units(void **state)
{
    (void)state;
#define SPACED TYPE8 SIZES "spacings: 1 2 3000\n"
    cvol_volume *v = read_ok(nrrd(SPACED "units: \"mm\" \"mm\" \"um\"\n" RAW, 12));
    assert_true(v->grid.spacing[0] == 1 && v->grid.spacing[1] == 2 && v->grid.spacing[2] == 3);
    assert_string_equal(v->grid.unit, "mm");
    cvol_volume_free(v);
    v = read_ok(nrrd(SPACED "units: \"???\" \"microns\" \"\"\n" RAW, 12));
    assert_true(v->grid.spacing[2] == 3000);
    assert_string_equal(v->grid.unit, "um");
    cvol_volume_free(v);
    /* The units of channels are not those of the volume. */
    v = read_ok(nrrd(TYPE8 "dimension: 4\nsizes: 1 2 3 2\nspacings: nan 1 1 1000\n"
                           "units: \"s\" \"mm\" \"mm\" \"um\"\n" RAW,
                     12));
    assert_true(v->grid.spacing[0] == 1 && v->grid.spacing[2] == 1);
    assert_string_equal(v->grid.unit, "mm");
    cvol_volume_free(v);
    /* Units of the space belong to the components of vectors. */
    v = read_ok(nrrd(TYPE8 SIZES "space: RAS\nspace origin: (1,2,3000)\n"
                                 "space directions: (0,0,4000) (0,5,0) (6,0,0)\n"
                                 "space units: \"mm\" \"mm\" \"um\"\n" RAW,
                     12));
    assert_true(v->grid.spacing[0] == 4 && v->grid.spacing[1] == 5 && v->grid.spacing[2] == 6);
    assert_true(v->grid.origin[2] == 3 && v->grid.direction[0][2] == 1);
    cvol_volume_free(v);
    read_fails(nrrd(SPACED "units: \"mm\" \"mm\" \"s\"\n" RAW, 12), CVOL_ERROR_UNSUPPORTED,
               "units '\"mm\" \"mm\" \"s\"' do not convert", "");
    v = read_ok(nrrd(TYPE8 "dimension: 3\nsizes: 4 3 1\nunits: \"mm\" \"mm\" \"s\"\n" RAW, 12));
    assert_string_equal(v->grid.unit, "mm"); /* one sample has no distance */
    cvol_volume_free(v);
}

/* Ends of axes instead of spacings; each sample is a node, or the middle of a cell. */
static void test_nrrd_extents(void **state)
{
    (void)state;
#define ENDS "axis mins: 1 2 3\naxis maxs: 4 5 6\n"
    for (int node = 0; node < 2; node++) {
        cvol_volume *v = read_ok(
            nrrd(node ? TYPE8 "dimension: 3\nsizes: 7 6 5\n" ENDS "centers: node node node\n" RAW
                      : TYPE8 "dimension: 3\nsizes: 6 5 4\n" ENDS "centers: cell CELL ???\n" RAW,
                 node ? 210 : 120));
        const double spacing[3] = {0.5, 0.6, 0.75};
        for (int a = 0; a < 3; a++) {
            assert_true(v->grid.spacing[a] == spacing[a]);
            assert_true(v->grid.origin[a] == 1 + a + (node ? 0 : spacing[a] / 2));
            assert_true(v->grid.direction[a][a] == 1);
        }
        cvol_volume_free(v);
    }
    /* Spacings take precedence; an axis may run backwards; one node has no distance. */
    cvol_volume *v = read_ok(nrrd(TYPE8 "dimension: 3\nsizes: 2 3 1\nspacings: 4 nan nan\n"
                                        "axismins: 1 6 7\naxismaxs: 9 2 7\n"
                                        "centerings: cell node node\n"
                                        "units: \"mm\" \"um\" \"mm\"\n" RAW,
                                  6));
    assert_true(v->grid.spacing[0] == 4 && v->grid.spacing[1] == 2e-3 && v->grid.spacing[2] == 1);
    assert_true(v->grid.origin[0] == 3 && v->grid.origin[1] == 6e-3 && v->grid.origin[2] == 7);
    assert_true(v->grid.direction[0][0] == 1 && v->grid.direction[1][1] == -1);
    cvol_volume_free(v);
    /* Positions in space replace them. */
    v = read_ok(nrrd(TYPE8 SIZES ENDS "space: RAS\nspace origin: (7,8,9)\n"
                                      "space directions: (2,0,0) (0,2,0) (0,0,2)\n" RAW,
                     12));
    assert_true(v->grid.spacing[1] == 2 && v->grid.origin[0] == 7);
    cvol_volume_free(v);
    read_fails(nrrd(TYPE8 SIZES "axis mins: 1 2 3\naxis maxs: 4 2 6\n" RAW, 12), CVOL_ERROR_FORMAT,
               "axis maxs '4 2 6' are those of axis mins", "");
    read_fails(nrrd(TYPE8 SIZES "axis mins: 1 2\n" RAW, 12), CVOL_ERROR_FORMAT, "axis mins has 2",
               "");
}

static void test_nrrd_detached(void **state)
{
    (void)state;
    write_bytes("d.bin", counting, 30);
    const char *path = write_text(
        "d.nhdr", TYPE8 SIZES "encoding: raw\nbyte skip: 5\ndata file: d.bin\n", NULL, 0);
    cvol_volume *v = read_ok(path);
    assert_memory_equal(v->data, counting + 5, 12);
    cvol_volume_free(v);
    path = write_text("d.nhdr", TYPE8 SIZES "encoding: raw\nbyteskip: -1\ndatafile: ./d.bin\n\n",
                      NULL, 0);
    v = read_ok(path);
    assert_memory_equal(v->data, counting + 18, 12);
    cvol_volume_free(v);
    write_text("d.txt", "one\ntwo\n", counting, 13);
    v = read_ok(write_text(
        "d.nhdr", TYPE8 SIZES "encoding: raw\nline skip: 2\nbyte skip: 1\ndata file: d.txt\n\n",
        NULL, 0));
    assert_memory_equal(v->data, counting + 1, 12);
    cvol_volume_free(v);
    char absolute[700];
    snprintf(absolute, sizeof absolute, "%sencoding: raw\ndata file: %s\n", TYPE8 SIZES,
             in_folder("d.bin"));
    v = read_ok(write_text("d.nhdr", absolute, NULL, 0));
    assert_memory_equal(v->data, counting, 12);
    cvol_volume_free(v);
#define DETACHED(text) write_text("d.nhdr", TYPE8 SIZES "encoding: raw\n" text, NULL, 0)
    read_fails(DETACHED("data file: gone.bin\n"), CVOL_ERROR_IO, "gone.bin", "No such file");
    read_fails(DETACHED("data file: LIST\nd.bin\n"), CVOL_ERROR_UNSUPPORTED, "'LIST'", "one file");
    read_fails(DETACHED("data file: d%02d.bin 1 3 1\n"), CVOL_ERROR_UNSUPPORTED, "d%02d.bin", "");
    read_fails(DETACHED("data file: \n"), CVOL_ERROR_FORMAT, "data file", "");
    read_fails(DETACHED("line skip: 2x\ndata file: d.txt\n"), CVOL_ERROR_FORMAT, "line skip", "2x");
    read_fails(DETACHED("byte skip: -2\ndata file: d.txt\n"), CVOL_ERROR_FORMAT, "byte skip", "-2");
    cvol_volume *none;
    path = DETACHED("byte skip: 9223372036854775807\ndata file: d.bin\n");
    assert_int_equal(cvol_volume_read(context, &none, path, NULL), CVOL_ERROR_FORMAT);
    path = DETACHED("line skip: 70\ndata file: d.txt\n");
    assert_int_equal(cvol_volume_read(context, &none, path, NULL), CVOL_ERROR_FORMAT);
    assert_non_null(strstr(cvol_context_message(context), "3 of the 70 lines"));
    path = DETACHED("byte skip: 20\ndata file: d.bin\n");
    assert_int_equal(cvol_volume_read(context, &none, path, NULL), CVOL_ERROR_FORMAT);
    assert_non_null(strstr(cvol_context_message(context), "d.bin: holds 10 of the 12 bytes"));
}

static void test_nrrd_gzip(void **state)
{
    (void)state;
    uint8_t packed[256];
#define GZIP(extra) TYPE8 SIZES "encoding: gzip\n" extra "\n"
    size_t size = gzip(packed, sizeof packed, counting, 12, 15 + 16);
    cvol_volume *v = read_ok(write_text("g.nrrd", GZIP(""), packed, size));
    assert_memory_equal(v->data, counting, 12);
    cvol_volume_free(v);
    /* two members and padding */
    size_t first = gzip(packed, sizeof packed, counting, 5, 15 + 16);
    size_t second = gzip(packed + first, sizeof packed - first, counting + 5, 7, 15 + 16);
    memset(packed + first + second, 0, 9);
    v = read_ok(write_text("g.nrrd", GZIP(""), packed, first + second + 9));
    assert_memory_equal(v->data, counting, 12);
    cvol_volume_free(v);
    /* bytes are skipped after inflating */
    size = gzip(packed, sizeof packed, counting, 16, 15 + 16);
    v = read_ok(write_text("g.nrrd", GZIP("byte skip: 4\n"), packed, size));
    assert_memory_equal(v->data, counting + 4, 12);
    cvol_volume_free(v);
    read_fails(write_text("g.nrrd", GZIP("byte skip: -1\n"), packed, size), CVOL_ERROR_FORMAT,
               "byte skip", "-1");
    read_fails(write_text("g.nrrd", GZIP(""), packed, size), CVOL_ERROR_FORMAT, "more than",
               "12 bytes");
    size = gzip(packed, sizeof packed, counting, 10, 15 + 16);
    read_fails(write_text("g.nrrd", GZIP(""), packed, size), CVOL_ERROR_FORMAT,
               "10 of the 12 bytes", "");
    size = gzip(packed, sizeof packed, counting, 12, 15 + 16);
    read_fails(write_text("g.nrrd", GZIP(""), packed, size - 1), CVOL_ERROR_FORMAT, "check sum",
               "");
    memcpy(packed + size, "garbage", 7);
    read_fails(write_text("g.nrrd", GZIP(""), packed, size + 7), CVOL_ERROR_FORMAT, "follow", "");
    packed[size - 5] ^= 1; /* the check sum */
    read_fails(write_text("g.nrrd", GZIP(""), packed, size), CVOL_ERROR_FORMAT, "damaged", "");
    read_fails(nrrd(GZIP(""), 20), CVOL_ERROR_FORMAT, "damaged", "");
    read_fails(nrrd(GZIP(""), 0), CVOL_ERROR_FORMAT, "0 of the 12", "");
    /* a small file cannot state gigabytes */
    read_fails(write_text("g.nrrd", TYPE8 "dimension: 3\nsizes: 1000 1000 1000\nencoding: gz\n\n",
                          packed, size),
               CVOL_ERROR_FORMAT, "cannot hold", "1000000000");
}

static void test_nrrd_lies(void **state)
{
    (void)state;
#define LIE(type, dimension, sizes, encoding, size)                          \
    nrrd("NRRD0004\ntype: " type "\ndimension: " dimension "\nsizes: " sizes \
         "\nendian: little\nencoding: " encoding "\n\n",                     \
         size)
    read_fails(LIE("uint8", "3", "2 0 2", "raw", 12), CVOL_ERROR_FORMAT, "sizes", "'0'");
    read_fails(LIE("uint8", "3", "2 -3 2", "raw", 12), CVOL_ERROR_FORMAT, "sizes", "'-3'");
    read_fails(LIE("uint8", "3", "2 3", "raw", 12), CVOL_ERROR_FORMAT,
               "sizes has 2 values, dimension is 3", "");
    read_fails(LIE("uint8", "3", "2 3 2 1", "raw", 12), CVOL_ERROR_FORMAT, "sizes has 4 values",
               "");
    read_fails(LIE("uint8", "3", "2 3.0 2", "raw", 12), CVOL_ERROR_FORMAT, "sizes", "'3.0'");
    read_fails(LIE("uint8", "3", "2 12abc 2", "raw", 12), CVOL_ERROR_FORMAT, "sizes", "'12abc'");
    read_fails(LIE("uint8", "3", "2147483648 1 1", "raw", 12), CVOL_ERROR_FORMAT,
               "12 of the 2147483648 bytes", "");
    read_fails(LIE("uint8", "3", "2147483648 2147483648 1", "raw", 12), CVOL_ERROR_LIMIT,
               "2147483648", "limit");
    read_fails(LIE("double", "3", "4294967296 4294967296 4294967296", "raw", 12), CVOL_ERROR_LIMIT,
               "4294967296", "");
    read_fails(LIE("double", "3", "4611686018427387904 4 1", "raw", 12), CVOL_ERROR_LIMIT,
               "4611686018427387904", "");
    read_fails(LIE("uint8", "3", "99999999999999999999 1 1", "raw", 12), CVOL_ERROR_FORMAT, "sizes",
               "99999999999999999999");
    read_fails(LIE("uint8", "three", "2 3 2", "raw", 12), CVOL_ERROR_FORMAT, "dimension", "three");
    /* no room for so many axes, in which units would be converted */
    read_fails(nrrd(TYPE8 "dimension: 16\nsizes: 2 3 2\nspace: RAS\n"
                          "space units: \"mm\" \"mm\" \"mm\"\n" RAW,
                    12),
               CVOL_ERROR_UNSUPPORTED, "dimension", "volumes have three axes");
    read_fails(LIE("int128", "3", "2 3 2", "raw", 12), CVOL_ERROR_FORMAT, "type", "int128");
    read_fails(LIE("block", "3", "2 3 2", "raw", 12), CVOL_ERROR_UNSUPPORTED, "type", "block");
    read_fails(LIE("int64", "3", "2 3 2", "raw", 12), CVOL_ERROR_FORMAT, "12 of the 96 bytes", "");
    read_fails(LIE("uint8", "3", "2 3 2", "zip", 12), CVOL_ERROR_FORMAT, "encoding", "zip");
    read_fails(LIE("uint8", "3", "2 3 2", "hex", 12), CVOL_ERROR_UNSUPPORTED, "encoding", "hex");
    read_fails(LIE("uint8", "3", "2 3 2", "bzip2", 12), CVOL_ERROR_UNSUPPORTED, "bzip2", "");
    read_fails(LIE("uint8", "3", "2 3 2", "raw", 11), CVOL_ERROR_FORMAT,
               "holds 11 of the 12 bytes of samples that its header announces", "");
    read_fails(LIE("uint8", "3", "2 3 2", "raw", 0), CVOL_ERROR_FORMAT, "0 of the 12", "");
    read_fails(LIE("uint8", "3", "2 3 2", "raw", 15), CVOL_ERROR_FORMAT, "holds 3 bytes more",
               "12 bytes");
    cvol_context_set_limit_bytes(context, 11);
    read_fails(LIE("uint8", "3", "2 3 2", "raw", 12), CVOL_ERROR_LIMIT, "2 x 3 x 2", "11");
    cvol_context_set_limit_bytes(context, UINT64_C(64) << 30);
}

static void test_nrrd_headers(void **state)
{
    (void)state;
    read_fails(nrrd("NRRD0006\n\n", 0), CVOL_ERROR_UNSUPPORTED, "NRRD0006", "");
    read_fails(nrrd("Hello\n\n", 0), CVOL_ERROR_FORMAT, "does not begin with 'NRRD'", "");
    read_fails(nrrd(TYPE8 SIZES "\n", 12), CVOL_ERROR_FORMAT, "no 'encoding'", "");
    read_fails(nrrd(TYPE8 "sizes: 2 3 2\nencoding: raw\n\n", 12), CVOL_ERROR_FORMAT,
               "no 'dimension'", "");
    read_fails(nrrd("NRRD0001\n" SIZES "encoding: raw\n\n", 12), CVOL_ERROR_FORMAT, "no 'type'",
               "");
    read_fails(nrrd(TYPE8 SIZES "sizes: 2 3 2\n" RAW, 12), CVOL_ERROR_FORMAT, "'sizes' twice", "");
    read_fails(nrrd(TYPE8 SIZES "encoding: raw\n", 0), CVOL_ERROR_FORMAT, "empty line", "");
    read_fails(nrrd(TYPE8 SIZES "no field\n" RAW, 12), CVOL_ERROR_FORMAT, "line 5", "no field");
    static const char with_nul[] = "NRRD0004\ntype: ui\0nt8\ndimension: 3\n";
    read_fails(write_bytes("n.nrrd", with_nul, sizeof with_nul - 1), CVOL_ERROR_FORMAT, "line 2",
               "NUL");
    read_fails(nrrd("NRRD0004\ntype: \033[2J\n" SIZES RAW, 12), CVOL_ERROR_FORMAT, "type",
               "?[2J"); /* no escapes in messages */
    read_fails(write_bytes("e.nrrd", "", 0), CVOL_ERROR_FORMAT, "is empty", "");
    read_fails(in_folder("gone.nrrd"), CVOL_ERROR_IO, "No such file", "");
    read_fails(in_folder(""), CVOL_ERROR_IO, "is a directory", "");
    size_t size = (size_t)3 << 20;
    char *endless = malloc(size);
    memset(endless, 'x', size);
    memcpy(endless, "NRRD0004\n", 9);
    read_fails(write_bytes("x.nrrd", endless, size), CVOL_ERROR_FORMAT, "1048576", "header");
    free(endless);
    remove(in_folder("x.nrrd"));
}

int main(void)
{
    const struct CMUnitTest reading[] = {
        cmocka_unit_test(test_nrrd_plain),    cmocka_unit_test(test_nrrd_unit_names),
        cmocka_unit_test(test_nrrd_endian),   cmocka_unit_test(test_nrrd_types),
        cmocka_unit_test(test_nrrd_text),     cmocka_unit_test(test_nrrd_axes),
        cmocka_unit_test(test_nrrd_volumes),  cmocka_unit_test(test_nrrd_space),
        cmocka_unit_test(test_nrrd_units),    cmocka_unit_test(test_nrrd_extents),
        cmocka_unit_test(test_nrrd_detached), cmocka_unit_test(test_nrrd_gzip),
        cmocka_unit_test(test_nrrd_lies),     cmocka_unit_test(test_nrrd_headers),
    };
    return cmocka_run_group_tests(reading, files_setup, files_teardown) != 0;
}
