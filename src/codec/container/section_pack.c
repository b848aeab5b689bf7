/* PACK: codes fields relative to their usual values and other content byte by byte, with the
 * adaptive range coder. */
#include "codec/container/section_pack.h"

#include <stdlib.h>
#include <string.h>

#include "base/context.h"
#include "codec/brick/brick_index.h"
#include "codec/container/header.h"
#include "codec/entropy/range_coder.h"
#include "codec/section/signature.h"

/* ---- usual fronts ----------------------------------------------------------------------- */

/* Integers, then doubles; STEADY fields rarely differ from their usual value. */
typedef enum field_class { USUAL, COUNT, USUAL_REAL, REAL, CLASSES } field_class;

/* Bytes of a field, its class, and its usual value: `usual`, or the value of the previous field. */
typedef struct field {
    uint8_t bytes, class, repeats_previous;
    uint64_t usual;
} field;

#define ONE UINT64_C(0x3FF0000000000000)  /* 1.0 */
#define FOUR UINT64_C(0x4010000000000000) /* 4.0 */

static const field head_fields[] = {
    {8, COUNT, 0, 0},      /* nx */
    {8, COUNT, 1, 0},      /* ny */
    {8, COUNT, 1, 0},      /* nz */
    {4, COUNT, 0, 1},      /* type */
    {4, USUAL, 0, 1},      /* transform */
    {4, USUAL, 0, 3},      /* rank */
    {4, USUAL, 0, 16},     /* block */
    {4, COUNT, 0, 0},      /* lapped */
    {4, USUAL, 0, 1},      /* trellis */
    {8, REAL, 0, FOUR},    /* step */
    {8, REAL, 0, 0},       /* offset */
    {8, USUAL_REAL, 1, 0}, /* value_min */
    {8, REAL, 0, FOUR},    /* value_max */
    {8, COUNT, 0, 0},      /* coefficients */
};
static const field geometry_fields[] = {
    {4, USUAL, 0, 0},                                                          /* space */
    {8, USUAL_REAL, 0, ONE},                                                   /* spacing */
    {8, USUAL_REAL, 1, 0},   {8, USUAL_REAL, 1, 0},   {8, USUAL_REAL, 0, 0},   /* origin */
    {8, USUAL_REAL, 0, 0},   {8, USUAL_REAL, 0, 0},   {8, USUAL_REAL, 0, ONE}, /* directions */
    {8, USUAL_REAL, 0, 0},   {8, USUAL_REAL, 0, 0},   {8, USUAL_REAL, 0, 0},
    {8, USUAL_REAL, 0, ONE}, {8, USUAL_REAL, 0, 0},   {8, USUAL_REAL, 0, 0},
    {8, USUAL_REAL, 0, 0},   {8, USUAL_REAL, 0, ONE}, {8, USUAL, 0, 0}, /* unit */
    {8, USUAL, 0, 0},        {8, USUAL_REAL, 0, ONE},                   /* value_scale */
    {8, USUAL_REAL, 0, 0},                                              /* value_offset */
};
static const field errors_fields[] = {
    {8, REAL, 0, FOUR},                                                        /* PSNR */
    {8, REAL, 0, FOUR},                                                        /* max_error */
    {8, REAL, 0, FOUR},                                                        /* l2_error */
    {8, REAL, 0, FOUR},                                                        /* max_abs */
    {8, USUAL_REAL, 0, 0},                                                     /* threshold */
    {8, REAL, 0, FOUR},                                                        /* subband_norm */
    {8, REAL, 0, 0},       {8, REAL, 0, 0}, {8, REAL, 0, 0}, {4, USUAL, 0, 1}, /* measured */
};
static const field modes_fields[] = {
    {4, COUNT, 0, 0},  /* residual */
    {4, COUNT, 0, 0},  /* fraction */
    {8, REAL, 0, ONE}, /* quantum */
    {4, COUNT, 0, 0},  /* unit */
    {4, COUNT, 0, 0},  /* grain */
    {4, COUNT, 0, 0},  /* fills */
    {4, COUNT, 0, 0},  /* background */
};
static const field bricks_fields[] = {
    {4, COUNT, 0, 64}, {4, COUNT, 1, 0}, {4, COUNT, 1, 0}, {4, COUNT, 0, 1}};
static const field true_length_fields[] = {{4, USUAL, 0, 2}};
static const field neural_fields[] = {{4, USUAL, 0, 1}};
/* The fields of CORR that the index lacks: length and checksum of the content. */
static const field residual_fields[] = {{8, COUNT, 0, 0}, {4, COUNT, 0, 0}};

#define FIELDS(array) array, sizeof array / sizeof *array

/* The sections of a front in order: if they usually exist, and their usual length. */
static const struct front_row {
    cvol_section_kind kind;
    int usually_exists;
    uint32_t length;
    const field *fields;
    size_t count;
} front_rows[] = {{CVOL_HEAD, 1, 88, FIELDS(head_fields)},
                  {CVOL_GEOM, 1, 156, FIELDS(geometry_fields)},
                  {CVOL_ATTR, 0, 0, NULL, 0},
                  {CVOL_ERRS, 1, 76, FIELDS(errors_fields)},
                  {CVOL_MODE, 0, 32, FIELDS(modes_fields)},
                  {CVOL_BRKS, 0, 16, FIELDS(bricks_fields)},
                  {CVOL_TRUE, 1, 4, FIELDS(true_length_fields)},
                  {CVOL_SMAL, 0, 4, FIELDS(neural_fields)},
                  {CVOL_SUMM, 1, 14, NULL, 0},
                  {CVOL_RNGE, 0, 0, NULL, 0},
                  {CVOL_TABL, 1, 9, NULL, 0},
                  {CVOL_INDX, 1, 20, NULL, 0},
                  {CVOL_CORR, 0, 12, FIELDS(residual_fields)}};
enum { ROWS = sizeof front_rows / sizeof *front_rows, RESIDUAL_BYTES = 12 };

/* ---- the coder -------------------------------------------------------------------------- */

enum { BYTES_LOG2 = 3, RARE = 64512, SELDOM = 57344, OFTEN = 16384, EVEN = 32768 };

typedef struct contexts {
    cvol_probability there, length;
    cvol_probability differs[CLASSES];
    cvol_probability bytes[CLASSES][1 << BYTES_LOG2];
    cvol_probability top[CLASSES][256]; /* the byte with sign and exponent, or the highest byte */
    cvol_probability other[2];          /* for a byte 0: context is the previous byte being 0 */
    cvol_probability value[256];
} contexts;

/* Codes fronts; encoder and decoder share it. A coding function returns the value that it codes. */
typedef struct front_coder {
    cvol_range_encoder *encoder; /* one of the two is NULL */
    cvol_range_decoder *decoder;
    contexts contexts;
} front_coder;

static void coder_start(front_coder *coder)
{
    contexts *c = &coder->contexts;
    cvol_probability *all = (cvol_probability *)c;
    for (size_t i = 0; i < sizeof *c / sizeof *all; i++)
        all[i] = (cvol_probability){EVEN, EVEN};
    c->there = c->other[0] = (cvol_probability){SELDOM, SELDOM};
    c->differs[USUAL] = c->differs[USUAL_REAL] = (cvol_probability){RARE, RARE};
    c->differs[REAL] = c->other[1] = (cvol_probability){OFTEN, OFTEN};
}

static unsigned code_bit(front_coder *coder, cvol_probability *p, unsigned bit)
{
    if (coder->decoder)
        return (unsigned)cvol_decode_bit(coder->decoder, p);
    cvol_encode_bit(coder->encoder, p, (int)bit);
    return bit;
}

static uint32_t code_raw(front_coder *coder, uint32_t value, int count)
{
    if (coder->decoder)
        return cvol_decode_raw(coder->decoder, count);
    cvol_encode_raw(coder->encoder, value, count);
    return value;
}

/* Codes a number of `bits` bits, high bits first, in the nodes of a tree. */
static unsigned code_tree(front_coder *coder, cvol_probability *nodes, unsigned value, int bits)
{
    unsigned node = 1;
    for (int b = bits - 1; b >= 0; b--)
        node = node << 1 | code_bit(coder, &nodes[node], value >> b & 1);
    return node - (1u << bits);
}

/* Reads `bytes` little-endian bytes at `at` as a number; store is the inverse. */
static uint64_t load(const uint8_t *at, int bytes)
{
    uint64_t value = 0;
    for (int i = 0; i < bytes; i++)
        value |= (uint64_t)at[i] << 8 * i;
    return value;
}

static void store(uint8_t *at, uint64_t value, int bytes)
{
    for (int i = 0; i < bytes; i++)
        at[i] = (uint8_t)(value >> 8 * i);
}

/* The number of coded bytes of a difference: low bytes, or for a double high bytes. */
static int bytes_of(uint64_t difference, int is_real)
{
    int bytes = 0;
    while (difference && bytes < 8) {
        difference = is_real ? difference << 8 : difference >> 8;
        bytes++;
    }
    return bytes;
}

/* Codes a field as the exclusive or with its usual value. */
static uint64_t code_difference(front_coder *coder, const field *f, uint64_t difference)
{
    contexts *c = &coder->contexts;
    const int is_real = f->class >= USUAL_REAL;
    int bytes = bytes_of(difference, is_real);
    if (!code_bit(coder, &c->differs[f->class], bytes > 0))
        return 0;
    bytes = 1 + (int)code_tree(coder, c->bytes[f->class], (unsigned)(bytes - 1) & 7, BYTES_LOG2);
    int shift = 8 * ((is_real ? 8 : bytes) - 1);
    uint64_t found = (uint64_t)code_tree(coder, c->top[f->class], difference >> shift & 255, 8)
                     << shift;
    for (int i = 1; i < bytes; i++) {
        shift -= 8;
        found |= (uint64_t)code_raw(coder, (uint32_t)(difference >> shift) & 255, 8) << shift;
    }
    return found;
}

static void code_fields(front_coder *coder, const struct front_row *row, uint8_t *content)
{
    uint64_t before = 0;
    for (size_t i = 0; i < row->count; i++) {
        const field *f = &row->fields[i];
        const uint64_t usual = f->repeats_previous ? before : f->usual;
        store(content, usual ^ code_difference(coder, f, load(content, f->bytes) ^ usual),
              f->bytes);
        before = load(content, f->bytes);
        content += f->bytes;
    }
}

static void code_bytes(front_coder *coder, uint8_t *content, size_t size)
{
    contexts *c = &coder->contexts;
    unsigned other = 1;
    for (size_t i = 0; i < size; i++) {
        other = code_bit(coder, &c->other[other], content[i] != 0);
        content[i] = other ? (uint8_t)code_tree(coder, c->value, content[i], 8) : 0;
    }
}

/* Codes a length that may be the usual one; in damaged fronts it may have any value. */
static uint32_t code_length(front_coder *coder, const struct front_row *row, uint32_t length)
{
    if (!code_bit(coder, &coder->contexts.length, length != row->length))
        return row->length;
    int bits = 0;
    while (bits < 31 && (length + UINT64_C(1)) >> (bits + 1))
        bits++;
    bits = (int)code_raw(coder, (uint32_t)bits, 5);
    return (UINT32_C(1) << bits | code_raw(coder, length + 1 - (UINT32_C(1) << bits), bits)) - 1;
}

/* Codes the content of a section of known length. */
static void code_content(front_coder *coder, const struct front_row *row, uint8_t *content,
                         size_t length)
{
    const int has_fields = length >= row->length && row->count;
    if (has_fields)
        code_fields(coder, row, content);
    const size_t begin = has_fields ? row->length : 0;
    code_bytes(coder, content + begin, length - begin);
}

/* ---- packing ---------------------------------------------------------------------------- */

static void encode_section(front_coder *coder, const struct front_row *row, cvol_bytes *content)
{
    code_bit(coder, &coder->contexts.there, !row->usually_exists);
    code_length(coder, row, (uint32_t)content->size);
    code_content(coder, row, content->data, content->size);
}

/* Codes the sections of `plain` that are in front_rows, and the fields of CORR. */
static int encode_front(front_coder *coder, const cvol_bytes *plain, const cvol_bytes *residual)
{
    cvol_cursor file = cvol_cursor_make(plain->data, plain->size);
    cvol_bytes content = {0};
    cvol_cursor_take(&file, CVOL_SECTIONS_AT);
    const uint8_t *header = cvol_cursor_take(&file, CVOL_SECTION_HEADER_BYTES);
    for (int r = 0; r < ROWS; r++) {
        const struct front_row *row = &front_rows[r];
        content.size = 0;
        if (row->kind == CVOL_CORR && residual) {
            cvol_bytes_put_u64(&content, residual->size);
            cvol_bytes_put_u32(&content, cvol_crc32c(residual->data, residual->size));
        } else if (row->kind != CVOL_CORR && header &&
                   !memcmp(header, cvol_section_tag(row->kind), 4)) {
            const size_t length = (size_t)load(header + 8, 8);
            cvol_bytes_append(&content, cvol_cursor_take(&file, length), length);
            header = cvol_cursor_take(&file, CVOL_SECTION_HEADER_BYTES);
        } else {
            code_bit(coder, &coder->contexts.there, (unsigned)row->usually_exists);
            continue;
        }
        if (content.failed)
            break;
        encode_section(coder, row, &content);
    }
    const int done = !content.failed;
    cvol_bytes_free(&content);
    return done;
}

int cvol_pack_put(cvol_context *context, cvol_bytes *out, const cvol_bytes *plain, uint64_t streams,
                  const cvol_bytes *residual)
{
    cvol_range_encoder encoder = {0};
    front_coder coder = {.encoder = &encoder};
    cvol_bytes packed = {0}, front = {0};
    cvol_range_encoder_start(&encoder);
    coder_start(&coder);
    const int done = encode_front(&coder, plain, residual) &&
                     cvol_range_encoder_finish(&encoder, &packed);
    cvol_range_encoder_free(&encoder);
    cvol_bytes_put_varint(&front, packed.size);
    cvol_bytes_append(&front, packed.data, packed.size);
    cvol_bytes_append(out, plain->data, CVOL_SECTIONS_AT);
    cvol_section_put_header(out, CVOL_PACK, front.size + streams,
                            cvol_crc32c(front.data, front.size));
    cvol_bytes_append(out, front.data, front.size);
    const int failed = !done || packed.failed || front.failed || out->failed;
    cvol_bytes_free(&packed);
    cvol_bytes_free(&front);
    return failed ? cvol_fail_memory(context, plain->size, "the file's header") : CVOL_OK;
}

/* ---- unpacking -------------------------------------------------------------------------- */

int cvol_pack_detect(const uint8_t *data, size_t size)
{
    return cvol_container_is(data, size) && size >= CVOL_SECTIONS_AT + 4 &&
           !memcmp(data + CVOL_SECTIONS_AT, cvol_section_tag(CVOL_PACK), 4);
}

void cvol_unpacked_free(cvol_unpacked *unpacked)
{
    cvol_bytes_free(&unpacked->plain);
    *unpacked = (cvol_unpacked){.is_cut = unpacked->is_cut};
}

/* One unpacking. */
typedef struct unpacking {
    cvol_context *context;
    const char *name;
    cvol_unpacked *out;
    size_t at[CVOL_SECTION_KINDS];    /* of a section's header in out->plain; 0: no such section */
    uint8_t residual[RESIDUAL_BYTES]; /* bytes of residual_fields */
} unpacking;

static int fail_front(const unpacking *u, const char *what)
{
    return cvol_fail(u->context, CVOL_ERROR_CORRUPT, "%s: section PACK at byte %llu %s", u->name,
                     (unsigned long long)u->out->pack.offset, what);
}

/* Decodes the next section of the front. */
static int decode_section(unpacking *u, front_coder *coder, const struct front_row *row)
{
    cvol_bytes *plain = &u->out->plain, content = {0};
    if ((int)code_bit(coder, &coder->contexts.there, 0) == row->usually_exists)
        return CVOL_OK;
    const uint32_t length = code_length(coder, row, row->length);
    if (plain->size + length > CVOL_PACK_MAX ||
        (row->kind == CVOL_CORR && length != RESIDUAL_BYTES))
        return fail_front(u, "holds a section that is longer than it may be");
    if (!cvol_bytes_reserve(&content, (size_t)length + 1))
        return cvol_fail_memory(u->context, length, u->name);
    memset(content.data, 0, length);
    content.size = length;
    code_content(coder, row, content.data, length);
    u->at[row->kind] = plain->size;
    if (row->kind == CVOL_CORR)
        memcpy(u->residual, content.data, sizeof u->residual);
    else
        cvol_section_put(plain, row->kind, &content);
    cvol_bytes_free(&content);
    return plain->failed ? cvol_fail_memory(u->context, length, u->name) : CVOL_OK;
}

static int decode_front(unpacking *u, const uint8_t *packed, size_t size, const uint8_t *file)
{
    cvol_range_decoder decoder;
    front_coder coder = {.decoder = &decoder};
    cvol_range_decoder_start(&decoder, packed, size);
    coder_start(&coder);
    cvol_bytes_append(&u->out->plain, file, CVOL_SECTIONS_AT);
    int code = CVOL_OK;
    for (int r = 0; r < ROWS && !code; r++)
        code = decode_section(u, &coder, &front_rows[r]);
    if (!code && cvol_range_decoder_overrun(&decoder))
        code = fail_front(u, "ends within its content");
    if (!code)
        u->out->places.front = u->out->plain.size;
    return code;
}

/* The section in out->plain; its bytes may move when out->plain grows. */
static cvol_section section_of(const unpacking *u, cvol_section_kind kind)
{
    const uint8_t *header = u->out->plain.data + u->at[kind];
    return (cvol_section){
        .kind = kind, .length = load(header + 8, 8), .content = header + CVOL_SECTION_HEADER_BYTES};
}

/* Reads HEAD, MODE and BRKS, and by them the index. */
static int take_index(unpacking *u, cvol_header *header, cvol_brick_index *index)
{
    typedef struct record {
        cvol_section_kind kind;
        int (*take)(cvol_context *, cvol_header *, cvol_cursor *, const char *);
    } record;
    static const record records[] = {
        {CVOL_HEAD, cvol_head_take}, {CVOL_MODE, cvol_modes_take}, {CVOL_BRKS, cvol_bricks_take}};
    if (!u->at[CVOL_HEAD] || !u->at[CVOL_INDX])
        return fail_front(u, "holds no section HEAD, or no INDX");
    for (size_t i = 0; i < sizeof records / sizeof *records; i++) {
        const cvol_section section = section_of(u, records[i].kind);
        cvol_cursor content = cvol_section_cursor(&section);
        const int code = u->at[records[i].kind]
                             ? records[i].take(u->context, header, &content, u->name)
                             : CVOL_OK;
        if (code)
            return code;
    }
    if (!cvol_header_is_volume(header))
        return fail_front(u, "holds an array that is not a volume");
    const cvol_section section = section_of(u, CVOL_INDX);
    return cvol_brick_index_take_streams(u->context, index, &section, cvol_header_bricks(header),
                                         header->brick.run, cvol_header_streams(header), u->name);
}

/* Appends the available part of a stream's section; *at: the position of its bytes in the file. */
static void append_stream(cvol_unpacked *out, cvol_section_kind kind, uint64_t length,
                          uint32_t checksum, const uint8_t *data, size_t size, size_t *at)
{
    cvol_section_places *places = &out->places;
    const size_t left = size - *at, there = length < left ? (size_t)length : left;
    if (out->is_cut)
        return;
    places->streams[places->count].header = out->plain.size;
    places->streams[places->count++].at = *at;
    cvol_section_put_header(&out->plain, kind, length, checksum);
    cvol_bytes_append(&out->plain, data + *at, there);
    out->is_cut = there < length;
    *at += there;
}

/* Appends all streams, whose bytes begin at byte `at`, and ENDS. */
static int append_streams(unpacking *u, const uint8_t *data, size_t size, size_t at)
{
    cvol_unpacked *out = u->out;
    cvol_header header = {.rank = 0};
    cvol_brick_index index = {0};
    int code = take_index(u, &header, &index);
    if (!code && (header.residual == CVOL_RESIDUAL_PACKED) != (u->at[CVOL_CORR] > 0))
        code = fail_front(u, "and section MODE do not agree about section CORR");
    uint64_t total = at - out->pack.content_offset;
    const uint64_t residual = load(u->residual, 8);
    for (int s = 0; !code && s < CVOL_STREAMS; s++)
        total += index.present >> s & 1 ? cvol_brick_index_size(&index, s) : 0;
    if (!code && (residual > out->pack.length || total + residual != out->pack.length))
        code = fail_front(u, "has another length than section INDX gives");
    for (int i = 0; !code && i < CVOL_STREAMS; i++) {
        const cvol_stream_section *row = &cvol_stream_sections[i];
        if (index.present >> row->stream & 1)
            append_stream(out, row->kind, cvol_brick_index_size(&index, row->stream),
                          cvol_brick_index_checksum(&index, row->stream), data, size, &at);
    }
    if (!code && u->at[CVOL_CORR])
        append_stream(out, CVOL_CORR, residual, (uint32_t)load(u->residual + 8, 4), data, size,
                      &at);
    if (!code)
        append_stream(out, CVOL_ENDS, 0, 0, data, size, &at);
    if (!code && out->plain.failed)
        code = cvol_fail_memory(u->context, size, u->name);
    cvol_brick_index_free(&index);
    return code;
}

int cvol_unpack(cvol_context *context, cvol_unpacked *out, const uint8_t *data, size_t size,
                const char *name)
{
    unpacking u = {.context = context, .name = name, .out = out};
    cvol_cursor file = cvol_cursor_make(data, size);
    *out = (cvol_unpacked){.is_cut = 0};
    cvol_cursor_take(&file, CVOL_SECTIONS_AT);
    cvol_section_walk walk = cvol_section_walk_make(file);
    int code = cvol_section_next(context, &out->pack, &walk, name);
    out->is_cut = walk.cut;
    if (code && (!walk.cut || !out->pack.tag[0]))
        return code;
    /* The available part of the content. */
    const uint8_t *content = data + out->pack.content_offset;
    const uint64_t left = size - out->pack.content_offset;
    cvol_cursor front = cvol_cursor_make(
        content, (size_t)(left < out->pack.length ? left : out->pack.length));
    const uint64_t packed_size = cvol_cursor_varint(&front);
    const uint8_t *packed = packed_size <= cvol_cursor_left(&front)
                                ? cvol_cursor_take(&front, (size_t)packed_size)
                                : NULL;
    if (front.failed || !packed)
        return code ? code : fail_front(&u, "is shorter than the front that it holds");
    const uint32_t found = cvol_crc32c(content, front.at);
    if (found != out->pack.checksum)
        return cvol_section_fail_sum(context, &out->pack, found, name);
    out->places.front_at = out->pack.offset;
    out->is_cut = 0;
    code = decode_front(&u, packed, (size_t)packed_size, data);
    const size_t begin = (size_t)out->pack.content_offset;
    return code ? code : append_streams(&u, data, begin + front.size, begin + front.at);
}
