/* DICOM: the reader on hand-made files, valid ones and every kind of invalid one. tests/cli reads
 * those of pydicom and GDCM. */
#include "test.h"

#include <sys/stat.h>

#include "cvol/volume.h"
#include "support_volume.h"

#define EXPLICIT "1.2.840.10008.1.2.1"
#define IMPLICIT "1.2.840.10008.1.2"
#define RUNS "1.2.840.10008.1.2.5"

/* ---- files ------------------------------------------------------------------------------ */

/* One file; a text that is NULL, and a number below 0: no such element. */
typedef struct slice {
    const char *syntax, *series, *instance, *position, *orientation, *spacing, *detector, *between,
        *frames, *slope, *intercept;
    int rows, columns, bits, stored, high, is_signed, samples, planar;
    const void *pixels; /* NULL: none */
    size_t bytes;
    int is_packed, lacks_header;
    const char *extra; /* bytes in front of the pixels */
    size_t extra_bytes;
} slice;

static const slice usual = {
    .syntax = EXPLICIT,
    .series = "1.2.3",
    .instance = "1",
    .position = "0\\0\\0",
    .orientation = "1\\0\\0\\0\\1\\0",
    .spacing = "0.5\\0.25",
    .rows = 2,
    .columns = 3,
    .bits = 8,
    .stored = 8,
    .high = 7,
    .is_signed = 0,
    .samples = 1,
    .planar = -1,
    .pixels = counting,
    .bytes = 6,
};

static uint8_t file[4096];
static size_t file_size;
static int file_is_implicit;

static void put(const void *data, size_t size)
{
    assert_true(file_size + size <= sizeof file);
    memcpy(file + file_size, data, size);
    file_size += size;
}

static void put_number(uint32_t value, int bytes)
{
    for (int i = 0; i < bytes; i++)
        put(&(uint8_t){(uint8_t)(value >> 8 * i)}, 1);
}

/* An element's tag, representation and length. */
static void put_head(uint32_t tag, const char *representation, uint32_t length)
{
    const int is_long = !strcmp(representation, "OB") || !strcmp(representation, "OW") ||
                        !strcmp(representation, "SQ") || !strcmp(representation, "UN");
    put_number(tag >> 16, 2);
    put_number(tag & 0xffff, 2);
    if (file_is_implicit) {
        put_number(length, 4);
        return;
    }
    put(representation, 2);
    if (is_long)
        put_number(0, 2);
    put_number(length, is_long ? 4 : 2);
}

static void put_text(uint32_t tag, const char *representation, const char *text)
{
    const size_t size = text ? strlen(text) : 0;
    if (!text)
        return;
    put_head(tag, representation, (uint32_t)(size + size % 2));
    put(text, size);
    put(" ", size % 2);
}

static void put_short(uint32_t tag, int value)
{
    if (value < 0)
        return;
    put_head(tag, "US", 2);
    put_number((uint32_t)value, 2);
}

static const char *write_slice(const char *name, const slice *s)
{
    file_size = 0;
    file_is_implicit = 0;
    if (!s->lacks_header) {
        const uint8_t preamble[128] = {0};
        put(preamble, sizeof preamble);
        put("DICM", 4);
        put_text(0x00020010, "UI", s->syntax);
    }
    file_is_implicit = !strcmp(s->syntax, IMPLICIT);
    put_text(0x00080060, "CS", "CT");
    put_text(0x00180088, "DS", s->between);
    put_text(0x00181164, "DS", s->detector);
    put_text(0x0020000e, "UI", s->series);
    put_text(0x00200013, "IS", s->instance);
    put_text(0x00200032, "DS", s->position);
    put_text(0x00200037, "DS", s->orientation);
    put_short(0x00280002, s->samples);
    put_short(0x00280006, s->planar);
    put_text(0x00280008, "IS", s->frames);
    put_short(0x00280010, s->rows);
    put_short(0x00280011, s->columns);
    put_text(0x00280030, "DS", s->spacing);
    put_short(0x00280100, s->bits);
    put_short(0x00280101, s->stored);
    put_short(0x00280102, s->high);
    put_short(0x00280103, s->is_signed);
    put_text(0x00281052, "DS", s->intercept);
    put_text(0x00281053, "DS", s->slope);
    if (s->extra)
        put(s->extra, s->extra_bytes);
    if (s->pixels) {
        put_head(0x7fe00010, "OW", s->is_packed ? UINT32_MAX : (uint32_t)s->bytes);
        put(s->pixels, s->bytes);
    }
    return write_bytes(name, file, file_size);
}

static int folder_number; /* of the latest folder of slices */

static void remove_slices(void)
{
    static const char *const names[] = {"/a.dcm", "/b.dcm", "/c.dcm", ""};
    char name[32];
    for (int i = 0; folder_number && i < 4; i++) {
        snprintf(name, sizeof name, "d%d%s", folder_number, names[i]);
        (void)remove(in_folder(name));
    }
}

/* An empty folder; the one before is removed. */
static const char *fresh(void)
{
    static char path[4096];
    char name[32];
    remove_slices();
    snprintf(name, sizeof name, "d%d", ++folder_number);
    snprintf(path, sizeof path, "%s", in_folder(name));
    assert_int_equal(mkdir(path, 0700), 0);
    return path;
}

static int teardown(void **state)
{
    remove_slices();
    return files_teardown(state);
}

/* The name of a file in such a folder. */
static const char *within(const char *of, const char *name)
{
    static char path[64];
    snprintf(path, sizeof path, "%s/%s", strrchr(of, '/') + 1, name);
    return path;
}

static void fails(const slice *s, int code, const char *words)
{
    const char *where = fresh();
    read_fails(write_slice(within(where, "a.dcm"), s), code, words, "");
}

/* ---- samples ---------------------------------------------------------------------------- */

/* Slices with scales of their own become float32. */
static void test_scaled_slices(void **state)
{
    static const uint8_t low[24] = {1,    0xff, 3,  4,    5,  0x86, 7,  8,    0xf9, 10, 11,   12,
                                    0x8d, 14,   15, 0xf0, 17, 18,   19, 0xa0, 21,   22, 0xe3, 24};
    static const struct {
        int bits, is_signed;
    } types[] = {{8, 0}, {8, 1}, {16, 0}, {16, 1}, {32, 0}, {32, 1}};
    (void)state;
    for (size_t i = 0; i < sizeof types / sizeof *types; i++) {
        const char *where = fresh();
        slice s = usual;
        const size_t each = (size_t)types[i].bits / 8;
        s.bits = s.stored = types[i].bits;
        s.high = s.bits - 1;
        s.is_signed = types[i].is_signed;
        s.pixels = low;
        s.bytes = 6 * each;
        s.slope = "2";
        s.intercept = "-3";
        (void)write_slice(within(where, "a.dcm"), &s);
        s.position = "0\\0\\2";
        s.slope = "0.5";
        (void)write_slice(within(where, "b.dcm"), &s);
        cvol_volume *v = read_ok(where);
        assert_int_equal(v->grid.type, CVOL_FLOAT32);
        assert_true(v->grid.spacing[0] == 0.25 && v->grid.spacing[1] == 0.5 &&
                    v->grid.spacing[2] == 2);
        for (size_t k = 0; k < 6; k++) {
            uint32_t bits = 0;
            for (size_t b = 0; b < each; b++)
                bits |= (uint32_t)low[k * each + b] << 8 * b;
            double value = bits;
            if (types[i].is_signed && bits >> (types[i].bits - 1))
                value -= ldexp(1, types[i].bits);
            assert_true(((float *)v->data)[k] == (float)(2 * value - 3));
            assert_true(((float *)v->data)[6 + k] == (float)(0.5 * value - 3));
        }
        cvol_volume_free(v);
    }
}

/* Bits beyond those of the samples do not count. */
static void test_stored_bits(void **state)
{
    static const uint32_t words[6] = {0xabc12345, 0xfff00001, 0x000fffff,
                                      0x12380000, 0x0007ffff, 0x99900000};
    (void)state;
    for (int is_signed = 0; is_signed <= 1; is_signed++) {
        uint8_t bytes[24];
        slice s = usual;
        for (size_t i = 0; i < 24; i++)
            bytes[i] = (uint8_t)(words[i / 4] >> 8 * (i % 4));
        s.bits = 32;
        s.stored = 20;
        s.high = 19;
        s.is_signed = is_signed;
        s.pixels = bytes;
        s.bytes = sizeof bytes;
        const char *where = fresh();
        cvol_volume *v = read_ok(write_slice(within(where, "a.dcm"), &s));
        for (int i = 0; i < 6; i++) {
            const int32_t value = (int32_t)(words[i] & 0xfffff);
            assert_int_equal(((int32_t *)v->data)[i],
                             is_signed && value >> 19 ? value - (1 << 20) : value);
        }
        cvol_volume_free(v);
    }
}

/* Colours one after the other, or plane by plane. */
static void test_channels(void **state)
{
    (void)state;
    for (int planar = 0; planar <= 1; planar++)
        for (int channel = 0; channel < 3; channel++) {
            const cvol_read_options options = {
                .size = sizeof options, .has_channel = 1, .channel = channel};
            slice s = usual;
            s.samples = 3;
            s.planar = planar;
            s.bytes = 18;
            cvol_volume *v;
            const char *where = fresh();
            const char *path = write_slice(within(where, "a.dcm"), &s);
            check_ok(cvol_volume_read(context, &v, path, &options));
            for (int i = 0; i < 6; i++)
                assert_int_equal(((uint8_t *)v->data)[i],
                                 counting[planar ? 6 * channel + i : 3 * i + channel]);
            cvol_volume_free(v);
        }
}

/* ---- order and place -------------------------------------------------------------------- */

/* Without positions the instance numbers order slices, and then their names. */
static void test_order_without_positions(void **state)
{
    (void)state;
    static const char *const names[3] = {"a.dcm", "b.dcm", "c.dcm"};
    for (int kind = 0; kind < 3; kind++) {
        static const char *const instances[3][3] = {
            {"30", "4", "5"}, {"7", "7", "7"}, {NULL, NULL, NULL}};
        const char *where = fresh();
        for (int i = 0; i < 3; i++) {
            slice s = usual;
            s.position = s.orientation = NULL;
            s.instance = instances[kind][i];
            s.between = "1.5";
            s.pixels = counting + 6 * i;
            (void)write_slice(within(where, names[i]), &s);
        }
        for (int of_file = 0; of_file <= 1; of_file++) {
            cvol_volume *v = read_ok(of_file ? in_folder(within(where, "b.dcm")) : where);
            assert_int_equal(v->grid.dims[2], 3);
            assert_true(v->grid.spacing[2] == 1.5);
            for (int z = 0; z < 3; z++)
                assert_memory_equal((uint8_t *)v->data + 6 * z,
                                    counting + 6 * (kind == 0 ? (z + 1) % 3 : z), 6);
            cvol_volume_free(v);
        }
    }
}

/* Files without a header of their own: the first element tells the syntax. */
static void test_syntax_without_a_header(void **state)
{
    (void)state;
    static const char *const syntaxes[] = {EXPLICIT, IMPLICIT};
    for (int i = 0; i < 2; i++) {
        slice s = usual;
        s.syntax = syntaxes[i];
        s.lacks_header = 1;
        s.spacing = NULL;
        s.detector = "3\\2";
        const char *where = fresh();
        cvol_volume *v = read_ok(write_slice(within(where, "a.dcm"), &s));
        assert_memory_equal(v->data, counting, 6);
        assert_true(v->grid.spacing[0] == 2 && v->grid.spacing[1] == 3);
        cvol_volume_free(v);
    }
}

static void two_slices_fail(slice second, const char *words)
{
    const char *where = fresh();
    (void)write_slice(within(where, "a.dcm"), &usual);
    (void)write_slice(within(where, "b.dcm"), &second);
    read_fails(where, CVOL_ERROR_FORMAT, words, "");
}

static void test_slices_that_do_not_fit(void **state)
{
    (void)state;
    slice s = usual;
    s.position = "0\\0\\1";
    s.orientation = "0\\1\\0\\1\\0\\0";
    two_slices_fail(s, "b.dcm: its slice is turned against that of a.dcm");
    s.orientation = NULL;
    two_slices_fail(s, "turned against");
    s.orientation = usual.orientation;
    s.rows = 3;
    s.columns = 2;
    two_slices_fail(s, "b.dcm: has 2 x 3 pixels of 8 bits, 0.25 x 0.5 apart; a.dcm, of the same");
    s = usual;
    s.position = "0\\0\\1";
    s.spacing = "0.5\\0.26";
    two_slices_fail(s, "0.26 x 0.5 apart");
    static const char *const apart[][3] = {
        {"0\\0\\1", "0\\0\\2.4", "not evenly spaced, from 1 to"},
        {"3\\0\\1", "0\\0\\2", "do not lie on a line"},
        {"0\\0\\0", "0\\0\\2", "slices are missing or repeated: 2 are at"}};
    for (size_t i = 0; i < sizeof apart / sizeof *apart; i++) {
        const char *where = fresh();
        (void)write_slice(within(where, "a.dcm"), &usual);
        s = usual;
        s.position = apart[i][0];
        (void)write_slice(within(where, "b.dcm"), &s);
        s.position = apart[i][1];
        (void)write_slice(within(where, "c.dcm"), &s);
        read_fails(where, CVOL_ERROR_FORMAT, apart[i][2], "");
    }
    const char *where = fresh();
    s = usual;
    s.pixels = NULL;
    (void)write_slice(within(where, "a.dcm"), &s);
    read_fails(where, CVOL_ERROR_FORMAT, "holds no DICOM file with an image", "");
}

/* ---- packed pixels ---------------------------------------------------------------------- */

static uint8_t pack[1024];
static size_t pack_size;

static void put_item(const void *data, size_t size)
{
    const uint8_t head[8] = {0xfe, 0xff, 0, 0xe0, (uint8_t)size, (uint8_t)(size >> 8)};
    memcpy(pack + pack_size, head, 8);
    if (size)
        memcpy(pack + pack_size + 8, data, size);
    pack_size += 8 + size;
}

/* Runs of a frame of six bytes: three literal bytes, nothing, and one byte three times. */
static size_t put_runs(uint8_t *out, const uint8_t *pixels)
{
    memset(out, 0, 64);
    out[0] = 1;
    out[4] = 64;
    const uint8_t runs[] = {2, pixels[0], pixels[1], pixels[2], 128, 254, pixels[3]};
    memcpy(out + 64, runs, sizeof runs);
    out[64 + sizeof runs] = 0; /* of even length */
    return 64 + sizeof runs + 1;
}

/* Two frames, with a table of their offsets or without one, the second one in two fragments. */
static slice packed_frames(int has_table, int is_split)
{
    uint8_t runs[2][80];
    uint8_t table[8] = {0};
    slice s = usual;
    pack_size = 0;
    const size_t sizes[2] = {put_runs(runs[0], counting), put_runs(runs[1], counting + 20)};
    table[4] = (uint8_t)(8 + sizes[0]);
    put_item(table, has_table ? 8 : 0);
    put_item(runs[0], sizes[0]);
    put_item(runs[1], is_split ? 66 : sizes[1]);
    if (is_split)
        put_item(runs[1] + 66, sizes[1] - 66);
    memcpy(pack + pack_size, "\xfe\xff\xdd\xe0\0\0\0", 8);
    pack_size += 8;
    s.syntax = RUNS;
    s.frames = "2";
    s.orientation = s.position = NULL;
    s.pixels = pack;
    s.bytes = pack_size;
    s.is_packed = 1;
    return s;
}

static void test_fragments(void **state)
{
    (void)state;
    for (int kind = 0; kind < 3; kind++) {
        const slice s = packed_frames(kind > 0, kind > 1);
        const char *where = fresh();
        cvol_volume *v = read_ok(write_slice(within(where, "a.dcm"), &s));
        for (int i = 0; i < 12; i++)
            assert_int_equal(((uint8_t *)v->data)[i],
                             counting[20 * (i / 6) + (i % 6 < 3 ? i % 6 : 3)]);
        cvol_volume_free(v);
    }
}

/* A sequence of icons, of undefined length: `pixels` are the fragments of its only one. */
static slice with_icon(const char *representation, const void *pixels, size_t size)
{
    static char icon[512];
    slice s = usual;
    file_size = 0;
    file_is_implicit = 0;
    put_head(0x00880200, representation, UINT32_MAX);
    file_is_implicit = !strcmp(representation, "UN");
    put_number(0xe000fffe, 4);
    put_number(UINT32_MAX, 4);
    put_short(0x00280010, 64); /* rows of the icon */
    put_head(0x7fe00010, "OB", UINT32_MAX);
    put(pixels, size);
    put("\xfe\xff\x0d\xe0\0\0\0\0\xfe\xff\xdd\xe0\0\0\0", 16);
    memcpy(icon, file, file_size);
    s.extra = icon;
    s.extra_bytes = file_size;
    return s;
}

/* Fragments of icons are no items of elements, whatever bytes they have. */
static void test_packed_icons(void **state)
{
    static const char *const representations[] = {"SQ", "UN"};
    (void)state;
    for (size_t i = 0; i < 2; i++) {
        pack_size = 0;
        put_item(NULL, 0);
        put_item("\xff\xd8\xff\xe0\0\x10JFIF\0\1", 12);
        put_item(counting, 60);
        memcpy(pack + pack_size, "\xfe\xff\xdd\xe0\0\0\0", 8);
        slice s = with_icon(representations[i], pack, pack_size + 8);
        const char *where = fresh();
        cvol_volume *v = read_ok(write_slice(within(where, "a.dcm"), &s));
        assert_int_equal(v->grid.dims[1], 2);
        assert_memory_equal(v->data, counting, 6);
        cvol_volume_free(v);
        pack[8 + 4] = 0xff; /* a fragment longer than the file */
        pack[8 + 5] = 0xff;
        s = with_icon(representations[i], pack, pack_size + 8);
        fails(&s, CVOL_ERROR_FORMAT, "its compressed icon is cut off or damaged at byte");
    }
}

static void test_damaged_fragments(void **state)
{
    (void)state;
    slice s = packed_frames(0, 0);
    s.frames = "3";
    fails(&s, CVOL_ERROR_FORMAT, "has no compressed pixels of frame 2");
    s = packed_frames(0, 0);
    s.bytes -= 9; /* within the last fragment */
    fails(&s, CVOL_ERROR_FORMAT, "its compressed pixels are cut off or damaged at byte");
    s = packed_frames(0, 0);
    pack[8] = 0xfd;
    fails(&s, CVOL_ERROR_FORMAT, "its compressed pixels are cut off or damaged at byte");
    s = packed_frames(0, 0);
    pack[16] = 2; /* segments */
    fails(&s, CVOL_ERROR_FORMAT, "frame 0 (transfer syntax " RUNS ") cannot be decoded");
    s = packed_frames(0, 0);
    pack[16 + 64] = 120; /* more literal bytes than there are */
    fails(&s, CVOL_ERROR_FORMAT, "cannot be decoded as 3 x 2");
    s.frames = "1";
    s.pixels = "\xfe\xff\xdd\xe0\0\0\0";
    s.bytes = 8;
    fails(&s, CVOL_ERROR_FORMAT, "has no compressed pixels");
    s.is_packed = 0;
    fails(&s, CVOL_ERROR_FORMAT, "its pixels are raw, which contradicts its transfer syntax");
    s.syntax = EXPLICIT;
    s.is_packed = 1;
    fails(&s, CVOL_ERROR_FORMAT, "its pixels are fragments, which contradicts");
    s.syntax = "1.2.3";
    fails(&s, CVOL_ERROR_UNSUPPORTED, "transfer syntax 1.2.3 is not supported");
    s.syntax = "1.2.840.10008.1.2.1.99";
    fails(&s, CVOL_ERROR_UNSUPPORTED, "(deflated) is not supported");
}

/* ---- headers ---------------------------------------------------------------------------- */

static void test_bad_values(void **state)
{
    (void)state;
    static const struct {
        int code;
        const char *words;
        slice change; /* elements that are not 0 or NULL take the place of the usual ones */
    } bad[] = {
        {CVOL_ERROR_UNSUPPORTED, "BitsAllocated is 12; 8, 16 and 32", {.bits = 12}},
        {CVOL_ERROR_FORMAT, "BitsStored is 9 and HighBit 7, of 8", {.stored = 9}},
        {CVOL_ERROR_FORMAT, "BitsStored is 8 and HighBit 6, of 8", {.high = 6}},
        {CVOL_ERROR_FORMAT, "PixelRepresentation is 2, SamplesPerPixel 1", {.is_signed = 2}},
        {CVOL_ERROR_FORMAT, "SamplesPerPixel 5", {.samples = 5}},
        {CVOL_ERROR_FORMAT, "PlanarConfiguration 2", {.planar = 2}},
        {CVOL_ERROR_FORMAT, "holds 6 bytes of pixels; 1 frames of 3 x 9 need 27", {.rows = 9}},
        {CVOL_ERROR_FORMAT, "holds 6 bytes of pixels; 2 frames", {.frames = "2"}},
        {CVOL_ERROR_FORMAT, "NumberOfFrames is 0", {.frames = "0"}},
        {CVOL_ERROR_FORMAT, "NumberOfFrames is 1e+09", {.frames = "1e9"}},
        {CVOL_ERROR_FORMAT, "NumberOfFrames is 1.5", {.frames = "1.5"}},
        {CVOL_ERROR_FORMAT, "element (0028,0008) is 'two', not numbers", {.frames = "two"}},
        {CVOL_ERROR_FORMAT, "element (0028,0030) has 1 of 2 numbers", {.spacing = "1"}},
        {CVOL_ERROR_FORMAT, "element (0020,0032) has 2 of 3 numbers", {.position = "1\\2"}},
        {CVOL_ERROR_FORMAT, "element (0020,0013) is 'x', not numbers", {.instance = "x"}},
        {CVOL_ERROR_FORMAT,
         "ImageOrientationPatient is (0, 0, 0, 0, 1, 0)",
         {.orientation = "0\\0\\0\\0\\1\\0"}},
        {CVOL_ERROR_FORMAT,
         "element (0028,0106) at byte",
         {.extra = "\x28\0\x06\1\0\0\0\0", .extra_bytes = 8}},
        {CVOL_ERROR_FORMAT,
         "element (0028,0106) has 4000 bytes, but only",
         {.extra = "\x28\0\x06\1SS\xa0\x0f", .extra_bytes = 8}},
        {CVOL_ERROR_FORMAT,
         "sequence (0028,3000) has no item at byte",
         {.extra = "\x28\0\0\x30SQ\0\0\x08\0\0\0\x28\0\x02\0US\2\0", .extra_bytes = 20}},
    };
    for (size_t i = 0; i < sizeof bad / sizeof *bad; i++) {
        const slice *c = &bad[i].change;
        slice s = usual;
#define TAKE(field) s.field = c->field ? c->field : s.field
        TAKE(bits);
        TAKE(stored);
        TAKE(high);
        TAKE(is_signed);
        TAKE(samples);
        TAKE(planar);
        TAKE(rows);
        TAKE(frames);
        TAKE(spacing);
        TAKE(position);
        TAKE(instance);
        TAKE(orientation);
        TAKE(extra);
        TAKE(extra_bytes);
#undef TAKE
        fails(&s, bad[i].code, bad[i].words);
    }
    slice s = usual;
    s.pixels = NULL;
    fails(&s, CVOL_ERROR_UNSUPPORTED, "is a DICOM file without an image");
    const char *where = fresh();
    (void)write_slice(within(where, "a.dcm"), &usual);
    const size_t size = file_size;
    for (size_t cut = 133; cut < size; cut++) { /* at any byte */
        (void)write_bytes(within(where, "a.dcm"), file, cut);
        cvol_volume *volume;
        const int code = cvol_volume_read(context, &volume, in_folder(within(where, "a.dcm")),
                                          NULL);
        assert_true(code == CVOL_ERROR_FORMAT || code == CVOL_ERROR_UNSUPPORTED);
        assert_null(volume);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_scaled_slices),
        cmocka_unit_test(test_stored_bits),
        cmocka_unit_test(test_channels),
        cmocka_unit_test(test_order_without_positions),
        cmocka_unit_test(test_syntax_without_a_header),
        cmocka_unit_test(test_slices_that_do_not_fit),
        cmocka_unit_test(test_fragments),
        cmocka_unit_test(test_packed_icons),
        cmocka_unit_test(test_damaged_fragments),
        cmocka_unit_test(test_bad_values),
    };
    return cmocka_run_group_tests(tests, files_setup, teardown);
}
