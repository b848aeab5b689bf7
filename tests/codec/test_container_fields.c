/* Fields of sections that no writer gives such values, behind valid checksums: each is refused by
 * a sentence that names the section and the field. */
#include "test.h"

#include <float.h>
#include <zstd.h>

#include "array/block/exact.h"
#include "base/context.h"
#include "codec/container/container.h"
#include "codec/container/layout.h"
#include "codec/container/section_pack.h"
#include "codec/residual/residual_array.h"
#include "codec/section/packed.h"
#include "fuzz/fuzz_cvol.c"
#include "random.h"
#include "support.h"
#include "support_container.h"
#include "support_terms.h"

enum { WORDS_MAX = 16 };

/* The kinds of files that sections are put into. */
typedef enum file_kind {
    VOLUME,  /* dct blocks of 16, without trellis quantization */
    TRELLIS, /* the same, with it: its terms are not decoded */
    HARTLEY, /* the same, but its header says dht: no volume */
    WHOLE,   /* without blocks */
    KINDS
} file_kind;

static uint8_t *files[KINDS];
static size_t sizes[KINDS];

/* A small array without blocks. */
static uint8_t *whole_file(size_t *size)
{
    const cvol_grid grid = cvol_grid_make(20, 9, 1, CVOL_FLOAT32);
    const cvol_keep keep = cvol_keep_threshold(0.5);
    float samples[180];
    cvol_array *array;
    for (int i = 0; i < 180; i++)
        samples[i] = (float)(10 * sin(i * 0.1));
    check_ok(cvol_array_compress(context, &array, samples, &grid, 2, CVOL_DCT, 0, &keep));
    uint8_t *data = container_file_of(array, size);
    cvol_array_free(array);
    return data;
}

static int setup(void **state)
{
    static const uint32_t trellis = 1, dht[4] = {CVOL_DHT, 3, 16, 0}; /* not lapped */
    if (files_setup(state))
        return -1;
    cvol_array *array = container_small_array();
    files[VOLUME] = container_file_of(array, &sizes[VOLUME]);
    cvol_array_free(array);
    sizes[TRELLIS] = sizes[VOLUME];
    files[TRELLIS] = container_with_field(files[VOLUME], &sizes[TRELLIS], "HEAD", 44, &trellis, 4);
    sizes[HARTLEY] = sizes[VOLUME];
    files[HARTLEY] = container_with_field(files[VOLUME], &sizes[HARTLEY], "HEAD", 28, dht,
                                          sizeof dht);
    files[WHOLE] = whole_file(&sizes[WHOLE]);
    return 0;
}

static int teardown(void **state)
{
    for (int kind = 0; kind < KINDS; kind++)
        free(files[kind]);
    return files_teardown(state);
}

/* Frees the file, which the reader must refuse by this sentence. */
static void expect_refused(uint8_t *data, size_t size, int code, const char *sentence)
{
    cvol_file_layout layout;
    if (container_read_code(data, size) != code || !strstr(cvol_context_message(context), sentence))
        fail_msg("must be '%s': '%s'", sentence, cvol_context_message(context));
    assert_int_equal(cvol_layout_verify(context, &layout, data, size, "f"), code);
    free(data);
}

/* ---- records of integers ---------------------------------------------------------------- */

/* A quantum of one: its upper half. */
#define ONE 0x3FF00000u

typedef struct record_case {
    file_kind kind;
    const char *tag;
    int count;
    uint32_t words[WORDS_MAX];
    int code; /* 0: CORRUPT */
    const char *sentence;
} record_case;

/* MODE: residual, fraction, quantum (two words), unit, grain, number of fills, background, fills
 * of two words. BRKS: three sides, bricks in a run. */
static const record_case records[] = {
    {VOLUME, "MODE", 7, {0}, 0, "section MODE is too short, 28 bytes"},
    {VOLUME, "MODE", 8, {5}, CVOL_ERROR_UNSUPPORTED, "residual kind is 5"},
    {VOLUME, "MODE", 8, {0, 0, 0, 0, 0, 0, 8}, 0, "the number of fills is 8, must be at most 7"},
    {VOLUME, "MODE", 8, {0, 0, 0, 0, 0, 0, 0, 1}, 0, "background is 1, must be 0, or 1 if"},
    {VOLUME, "MODE", 10, {0, 0, 0, 0, 0, 0, 1, 0, 5, 1}, 0, "fill is 0, must be a bit pattern"},
    {VOLUME, "MODE", 12, {0, 0, 0, 0, 0, 0, 2, 0, 5, 0, 5, 0}, 0, "fill is 1, must be a bit"},
    {VOLUME, "MODE", 9, {0, 0, 0, 0, 0, 0, 1, 0, 5}, 0, "section MODE is too short, 36 bytes"},
    {VOLUME,
     "MODE",
     10,
     {0, 0, 0, 0, 0, 0, 1, 1, 0x7F000000, 0},
     0,
     "the background's fill is 1.7"},
    {VOLUME, "MODE", 8, {1, 11, 0, ONE}, 0, "fraction is 11, must be at most 10"},
    {VOLUME, "MODE", 10, {4, 0, 0, 0, 0, 0, 1, 0, 5, 0}, 0, "fills is 1, must be 0 for labels"},
    {VOLUME, "MODE", 8, {4, 0, 0, ONE}, 0, "quantum is 1, must be a label of an integer type"},
    {VOLUME, "MODE", 8, {1}, 0, "quantum is 0, must be a quantum that the sample type allows"},
    {HARTLEY, "MODE", 8, {1, 0, 0, ONE}, 0, "residual is 1, must be 0 for arrays that are not"},
    {VOLUME, "BRKS", 3, {16, 16, 16}, 0, "section BRKS is too short, 12 bytes"},
    {HARTLEY, "BRKS", 4, {16, 16, 16, 1}, 0, "section BRKS is for volumes in dct blocks"},
    {VOLUME, "BRKS", 4, {16, 24, 16, 1}, 0, "side y is 24, must be 16, 32, 48 or 64"},
    {VOLUME, "BRKS", 4, {16, 16, 16, 3}, 0, "bricks in a run is 3, must be 1, 2, 4, 8 or 16"},
    {VOLUME, "BRKS", 4, {16, 16, 16, 0}, 0, "bricks in a run is 0"},
    {VOLUME, "BRKS", 4, {16, 16, 16, 32}, 0, "bricks in a run is 32"},
    {VOLUME, "TRUE", 0, {0}, 0, "section TRUE is too short, 0 bytes"},
    {HARTLEY, "TRUE", 1, {1}, 0, "section TRUE is for volumes in dct blocks of 16"},
    {VOLUME, "TRUE", 1, {0}, 0, "bits is 0, must be 1 to 8"},
    {VOLUME, "TRUE", 1, {9}, 0, "bits is 9, must be 1 to 8"},
    {VOLUME, "SMAL", 0, {0}, 0, "section SMAL is too short, 0 bytes"},
    {VOLUME, "SMAL", 1, {1}, 0, "section SMAL is for volumes with trellis quantization"},
    {TRELLIS, "SMAL", 1, {2}, CVOL_ERROR_UNSUPPORTED, "networks 2, only 1 is known"},
    {VOLUME, "HEAD", 21, {0}, 0, "section HEAD is too short, 84 bytes"},
    {VOLUME, "GEOM", 38, {0}, 0, "section GEOM is too short, 152 bytes"},
    {VOLUME, "ERRS", 18, {0}, 0, "section ERRS is too short, 72 bytes"},
    {VOLUME, "INDX", 1, {0}, 0, "bricks are more than it can hold"},
};

static void records_are_checked(void **state)
{
    (void)state;
    for (size_t i = 0; i < sizeof records / sizeof *records; i++) {
        const record_case *r = &records[i];
        size_t size = sizes[r->kind];
        uint8_t *data = container_with_section(files[r->kind], &size, r->tag, r->words,
                                               4 * (size_t)r->count);
        expect_refused(data, size, r->code ? r->code : CVOL_ERROR_CORRUPT, r->sentence);
    }
}

/* True length is for terms alone. */
static void true_length_excludes_a_residual(void **state)
{
    (void)state;
    static const uint32_t mode[8] = {1, 0, 0, ONE}, bits = 1;
    size_t size = sizes[VOLUME];
    uint8_t *with = container_with_section(files[VOLUME], &size, "MODE", mode, sizeof mode);
    uint8_t *both = container_with_section(with, &size, "TRUE", &bits, 4);
    free(with);
    expect_refused(both, size, CVOL_ERROR_CORRUPT, "TRUE is for volumes without a residual");
}

/* ---- SUMM ------------------------------------------------------------------------------- */

/* Fields of the section: flags and bins, distinct values, then doubles as given. */
typedef struct summary_case {
    uint8_t flags, distinct_low, distinct_high;
    int doubles;
    double values[3];
    int count; /* a last byte: the number of marks; -1: none */
    const char *sentence;
} summary_case;

static void summaries_are_checked(void **state)
{
    (void)state;
    static const summary_case cases[] = {
        {2, 1, 0, 1, {0}, -1, "section SUMM ends within its fields"},
        {0x08, 1, 0, 0, {0}, -1, "section SUMM has unknown flags, or more than 256 bins"},
        {0xF0, 1, 0, 0, {0}, -1, "section SUMM has unknown flags, or more than 256 bins"},
        {0, 0x81, 2, 0, {0}, -1, "section SUMM states more than 256 distinct values"},
        {2, 1, 0, 2, {2, 1}, -1, "section SUMM has an invalid range"},
        {2, 1, 0, 2, {0, (double)INFINITY}, -1, "section SUMM has an invalid range"},
        {4, 1, 0, 1, {(double)NAN}, 5, "section SUMM has an invalid mark"},
        {4, 1, 0, 1, {0}, 0, "section SUMM has an invalid mark"},
    };
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        const summary_case *c = &cases[i];
        cvol_bytes content = {0};
        size_t size = sizes[VOLUME];
        cvol_bytes_put_u8(&content, c->flags);
        cvol_bytes_put_u8(&content, c->distinct_low);
        if (c->distinct_low & 0x80)
            cvol_bytes_put_u8(&content, c->distinct_high);
        for (int k = 0; k < c->doubles; k++)
            cvol_bytes_put_f64(&content, c->values[k]);
        if (c->count >= 0)
            cvol_bytes_put_u8(&content, (uint8_t)c->count);
        uint8_t *data = container_with_section(files[VOLUME], &size, "SUMM", content.data,
                                               content.size);
        expect_refused(data, size, CVOL_ERROR_CORRUPT, c->sentence);
        cvol_bytes_free(&content);
    }
}

/* Any bytes in place of the counts: levels, a level that none can be, or the end of the section.
 * All three occur. */
static void any_counts_of_a_summary(void **state)
{
    (void)state;
    int invalid = 0, accepted = 0, ended = 0;
    random_state r = {5};
    for (int i = 0; i < 600; i++) {
        uint8_t content[24] = {0, 1};
        size_t size = sizes[VOLUME], length = 2 + (size_t)(i % 22);
        for (size_t k = 2; k < length; k++)
            content[k] = i % 3 ? (uint8_t)random_u64(&r) : 0xFF;
        uint8_t *data = container_with_section(files[VOLUME], &size, "SUMM", content, length);
        accepted += container_read_code(data, size) == CVOL_OK;
        invalid += strstr(cvol_context_message(context), "SUMM has an invalid count") != NULL;
        ended += strstr(cvol_context_message(context), "SUMM ends within its counts") != NULL;
        free(data);
    }
    assert_true(invalid > 0 && accepted > 0 && ended > 0);
}

/* ---- RNGE ------------------------------------------------------------------------------- */

/* The section with these ends, and the codes of all cells: lower, then upper less lower. */
static void expect_ranges_refused(double lo, double hi, int lower, int width, size_t cells,
                                  const char *sentence)
{
    uint8_t codes[64], frame[256];
    cvol_bytes content = {0};
    size_t size = sizes[VOLUME];
    memset(codes, lower, cells);
    memset(codes + cells, width, cells);
    const size_t packed = ZSTD_compress(frame, sizeof frame, codes, 2 * cells, 1);
    cvol_bytes_put_f64(&content, lo);
    cvol_bytes_put_f64(&content, hi);
    cvol_bytes_append(&content, frame, packed);
    uint8_t *data = container_with_section(files[VOLUME], &size, "RNGE", content.data,
                                           content.size);
    cvol_bytes_free(&content);
    if (sentence)
        expect_refused(data, size, CVOL_ERROR_CORRUPT, sentence);
    else {
        assert_int_equal(container_read_code(data, size), CVOL_OK);
        free(data);
    }
}

static void ranges_are_checked(void **state)
{
    (void)state;
    size_t size = sizes[VOLUME];
    const size_t cells = 5 * 2 * 1; /* of 16 samples a side, in 70 x 20 x 16 */
    uint8_t *data = container_with_section(files[VOLUME], &size, "RNGE", "", 0);
    expect_refused(data, size, CVOL_ERROR_CORRUPT, "section RNGE: range_min is 0 and range_max 0");
    expect_ranges_refused(-1, 1, 100, 155, cells, NULL);
    expect_ranges_refused((double)NAN, 1, 0, 0, cells, "range_min is nan and range_max 1");
    expect_ranges_refused(2, 1, 0, 0, cells, "range_min is 2 and range_max 1");
    expect_ranges_refused(-1.5e308, 1.5e308, 0, 0, cells, "must be finite and in order");
    expect_ranges_refused(-1, 1, 100, 156, cells, "does not hold the ranges of 10 cells");
    expect_ranges_refused(-1, 1, 100, 1, cells - 1, "does not hold the ranges of 10 cells");
}

/* ---- SPEC ------------------------------------------------------------------------------- */

/* The section with a low box of one value, and this sparse term. */
static void expect_spectrum_refused(uint32_t distance, float value, const char *sentence)
{
    cvol_bytes content = {0}, raw = {0};
    uint8_t frame[64];
    const float low = 1;
    size_t size = sizes[WHOLE];
    cvol_planes_put(&raw, &low, 1, 4);
    cvol_planes_put(&raw, &distance, 1, 4);
    cvol_planes_put(&raw, &value, 1, 4);
    for (int k = 0; k < 4; k++)
        cvol_bytes_put_u64(&content, 1);
    cvol_bytes_append(&content, frame, ZSTD_compress(frame, sizeof frame, raw.data, raw.size, 1));
    uint8_t *data = container_with_section(files[WHOLE], &size, "SPEC", content.data, content.size);
    cvol_bytes_free(&content);
    cvol_bytes_free(&raw);
    expect_refused(data, size, CVOL_ERROR_CORRUPT, sentence);
}

static void spectra_are_checked(void **state)
{
    (void)state;
    size_t size = sizes[WHOLE];
    uint8_t *data = container_with_section(files[WHOLE], &size, "SPEC", "short", 5);
    expect_refused(data, size, CVOL_ERROR_CORRUPT, "section SPEC: is too short");
    expect_spectrum_refused(180, 1, "section SPEC: a place is beyond the array");
    expect_spectrum_refused(0, 1, "section SPEC: a place is within the low box");
    expect_spectrum_refused(5, (float)INFINITY, "section SPEC: terms are not finite");
    expect_spectrum_refused(5, FLT_MAX, "section SPEC: terms are not finite, or too large");
    expect_spectrum_refused(5, 1, "there are 2 coefficients, section HEAD says");
}

/* ---- PACK ------------------------------------------------------------------------------- */

/* A packed file of the sections in front of `end`, without streams. */
static void expect_pack_refused(const uint8_t *data, size_t size, const char *end,
                                const char *sentence)
{
    cvol_file_layout layout;
    cvol_bytes out = {0};
    size_t front = 0;
    check_ok(cvol_layout_walk(context, &layout, data, size, "f"));
    for (int i = 0; i < layout.section_count && !front; i++)
        if (!strcmp(layout.sections[i].tag, end))
            front = (size_t)layout.sections[i].offset;
    assert_int_not_equal(front, 0);
    check_ok(cvol_pack_put(context, &out, &(cvol_bytes){.data = (uint8_t *)data, .size = front}, 0,
                           NULL));
    expect_refused(out.data, out.size, CVOL_ERROR_CORRUPT, sentence);
}

static void fronts_of_packed_files_are_checked(void **state)
{
    (void)state;
    static const uint32_t packed[8] = {CVOL_RESIDUAL_PACKED, 0, 0, ONE};
    expect_pack_refused(files[VOLUME], sizes[VOLUME], "TABL", "holds no section HEAD, or no INDX");
    expect_pack_refused(files[HARTLEY], sizes[HARTLEY], "SHL0", "holds an array that is not a");
    size_t size = sizes[VOLUME];
    uint8_t *mode = container_with_section(files[VOLUME], &size, "MODE", packed, sizeof packed);
    expect_pack_refused(mode, size, "SHL0", "do not agree about section CORR");
    free(mode);
}

/* ---- streams ---------------------------------------------------------------------------- */

enum { NX = 30, NY = 20, NZ = 17 };

static uint8_t *compressed(const void *samples, cvol_type type,
                           const cvol_compress_options *options, size_t *size)
{
    const cvol_grid grid = cvol_grid_make(NX, NY, NZ, type);
    cvol_array *array;
    check_ok(cvol_compress(context, &array, NULL, samples, &grid, options));
    uint8_t *data = container_file_of(array, size);
    cvol_array_free(array);
    return data;
}

/* A residual in bricks, of waves within an error of 2. */
static uint8_t *bounded_file(size_t *size)
{
    cvol_compress_options options = cvol_compress_options_defaults();
    int16_t samples[NX * NY * NZ];
    options.target = CVOL_TARGET_MAX_ERROR;
    options.target_value = 2;
    for (int i = 0; i < NX * NY * NZ; i++)
        samples[i] = (int16_t)(900 * sin(0.07 * i) + i % 7);
    return compressed(samples, CVOL_INT16, &options, size);
}

static void residuals_are_checked(void **state)
{
    (void)state;
    size_t size;
    uint8_t *data = bounded_file(&size);
    size_t other = size;
    uint8_t *without = container_with_section(data, &other, "CORR", NULL, 0);
    expect_refused(without, other, CVOL_ERROR_CORRUPT,
                   "section CORR is missing, but section MODE needs it");
    free(data);
    /* Packed samples. */
    static const uint32_t packed[8] = {CVOL_RESIDUAL_PACKED, 0, 0, ONE};
    size = sizes[VOLUME];
    uint8_t *mode = container_with_section(files[VOLUME], &size, "MODE", packed, sizeof packed);
    uint8_t *both = container_with_section(mode, &size, "CORR", "no frame", 8);
    free(mode);
    expect_refused(both, size, CVOL_ERROR_CORRUPT, "section CORR does not unpack");
}

/* More samples than may be packed, all 0. */
static void packed_samples_have_a_limit(void **state)
{
    (void)state;
    static const uint32_t packed[8] = {CVOL_RESIDUAL_PACKED, 0, 0, ONE};
    const cvol_grid grid = cvol_grid_make(512, 512, 257, CVOL_UINT8);
    cvol_array *array;
    size_t size;
    assert_true(cvol_grid_bytes(&grid) > CVOL_PACKED_MAX);
    check_ok(cvol_array_create(context, &array, &grid, 16));
    array->step = 1;
    uint8_t *data = container_file_of(array, &size);
    cvol_array_free(array);
    uint8_t *mode = container_with_section(data, &size, "MODE", packed, sizeof packed);
    uint8_t *both = container_with_section(mode, &size, "CORR", "any", 3);
    free(data);
    free(mode);
    expect_refused(both, size, CVOL_ERROR_LIMIT,
                   "section CORR packs 67371008 bytes of samples, it may be 67108864");
}

/* Large coefficients leave fewer fraction bits for the sums of the exact base. */
static void sums_of_the_base_have_a_limit(void **state)
{
    (void)state;
    enum { BRICKS = 2, RUNS = 1, MORE = BRICKS + 4 * RUNS };
    static const uint32_t bounded[8] = {CVOL_RESIDUAL_BOUNDED, 10, 0, ONE};
    size_t size;
    cvol_file_layout layout;
    cvol_array *array = support_terms_make(
        context, &(support_terms){.dims = {70, 20, 16}, .block = 16, .split = 1, .seed = 9});
    assert_true(cvol_exact_fraction(cvol_exact_largest_sum(array)) < 10);
    uint8_t *data = container_file_of(array, &size);
    uint8_t *mode = container_with_section(data, &size, "MODE", bounded, sizeof bounded);
    cvol_array_free(array);
    free(data);
    check_ok(cvol_layout_walk(context, &layout, mode, size, "f"));
    const cvol_file_section *index = layout.sections;
    while (strcmp(index->tag, "INDX"))
        index++;
    /* CORR without bytes: lengths and checksums of 0. */
    uint8_t *content = calloc(1, (size_t)index->length + MORE);
    assert_non_null(content);
    memcpy(content, mode + index->offset + CVOL_SECTION_HEADER_BYTES, (size_t)index->length);
    uint8_t *more = container_with_section(mode, &size, "INDX", content,
                                           (size_t)index->length + MORE);
    uint8_t *both = container_with_section(more, &size, "CORR", "", 0);
    fuzz_repair(both, size);
    free(mode);
    free(content);
    free(more);
    expect_refused(both, size, CVOL_ERROR_CORRUPT,
                   "section MODE: 10 fraction bits are too many for the coefficients");
}

/* Masks of three kinds of samples without a value, with random bytes: a brick is damaged, or
 * something is masked. Both occur. */
static void any_bytes_of_a_mask(void **state)
{
    (void)state;
    static const float fills[3] = {(float)NAN, (float)INFINITY, -(float)INFINITY};
    cvol_compress_options options = cvol_compress_options_defaults();
    random_state r = {77};
    float samples[NX * NY * NZ];
    int accepted = 0, refused = 0;
    size_t size;
    options.has_fill = 1;
    options.fill = (double)NAN;
    for (int i = 0; i < NX * NY * NZ; i++)
        samples[i] = i % 30 < 9 || i / 600 < 5 ? fills[i / 7 % 3] : (float)sin(0.01 * i);
    uint8_t *data = compressed(samples, CVOL_FLOAT32, &options, &size), *copy = malloc(size);
    cvol_file_layout layout;
    const cvol_file_section *mask = NULL;
    check_ok(cvol_layout_walk(context, &layout, data, size, "f"));
    for (int i = 0; i < layout.section_count; i++)
        if (!strcmp(layout.sections[i].tag, "MASK"))
            mask = &layout.sections[i];
    assert_true(copy && mask && mask->length > 20);
    for (int i = 0; i < 200; i++) {
        memcpy(copy, data, size);
        for (int k = 0; k < 1 + i % 3; k++)
            copy[mask->offset + 24 + random_below(&r, (uint32_t)mask->length)] = (uint8_t)
                random_u64(&r);
        fuzz_repair(copy, size);
        const int code = container_read_code(copy, size);
        accepted += code == CVOL_OK;
        refused += code != CVOL_OK;
        if (code && !strstr(cvol_context_message(context), "section MASK: brick 0 of 1 is damaged"))
            fail_msg("%s", cvol_context_message(context));
    }
    assert_true(accepted > 0 && refused > 0);
    free(copy);
    free(data);
}

static void states_have_names(void **state)
{
    (void)state;
    assert_string_equal(cvol_section_state_name(CVOL_SECTION_SOUND), "sound");
    assert_string_equal(cvol_section_state_name(CVOL_SECTION_DAMAGED), "damaged");
    assert_string_equal(cvol_section_state_name(CVOL_SECTION_TRUNCATED), "truncated");
    assert_string_equal(cvol_section_state_name(CVOL_SECTION_UNCHECKED), "not checked");
    assert_null(cvol_section_state_name((cvol_section_state)99));
}

/* ---- ATTR, signature -------------------------------------------------------------------- */

static void attributes_have_a_limit(void **state)
{
    (void)state;
    size_t size = sizes[VOLUME];
    char *text = malloc(CVOL_ATTRIBUTES_MAX + 1);
    assert_non_null(text);
    memset(text, ' ', CVOL_ATTRIBUTES_MAX + 1);
    uint8_t *data = container_with_section(files[VOLUME], &size, "ATTR", text,
                                           CVOL_ATTRIBUTES_MAX + 1);
    expect_refused(data, size, CVOL_ERROR_LIMIT, "section ATTR has ");
    free(text);
}

/* Files that end within signature and version, and other kinds of files. */
static void starts_are_checked(void **state)
{
    (void)state;
    for (size_t size = 8; size < 12; size++) {
        assert_int_equal(container_read_code(files[VOLUME], size), CVOL_ERROR_CORRUPT);
        assert_non_null(strstr(cvol_context_message(context), "truncated: within its version"));
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(records_are_checked),
        cmocka_unit_test(true_length_excludes_a_residual),
        cmocka_unit_test(summaries_are_checked),
        cmocka_unit_test(any_counts_of_a_summary),
        cmocka_unit_test(ranges_are_checked),
        cmocka_unit_test(spectra_are_checked),
        cmocka_unit_test(fronts_of_packed_files_are_checked),
        cmocka_unit_test(residuals_are_checked),
        cmocka_unit_test(packed_samples_have_a_limit),
        cmocka_unit_test(sums_of_the_base_have_a_limit),
        cmocka_unit_test(any_bytes_of_a_mask),
        cmocka_unit_test(states_have_names),
        cmocka_unit_test(attributes_have_a_limit),
        cmocka_unit_test(starts_are_checked),
    };
    return cmocka_run_group_tests(tests, setup, teardown);
}
