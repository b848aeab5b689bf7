/* The colour table of MGH and MGZ files, behind the samples: numbers with the high byte first.
 *
 *     five floats: TR, flip angle, TE, TI, field of view
 *     records of a tag and, but for few tags, a length of 64 bits; tag 1 is a colour table:
 *     version 1 (number of labels > 0): label = number in the list
 *     version 2 (-2): each entry states its label
 */
#define _POSIX_C_SOURCE 200809L
#include <stdlib.h>
#include <string.h>

#include "base/context.h"
#include "volume/formats/label_list.h"
#include "volume/io/inflate.h"

#define HEADER_BYTES 284
/* Records are read up to this size. */
#define RECORDS_MOST ((size_t)16 << 20)

/* Tags that have a length of 32 bits or none (FreeSurfer's tags.c). */
enum { COLOURS = 1, REAL_RAS = 2, SURFACE = 20, TRANSFORM = 30 };

typedef struct records {
    const uint8_t *at;
    size_t size;
    int failed; /* read beyond the end */
} records;

static const uint8_t *take(records *r, uint64_t size)
{
    if (r->failed || size > r->size) {
        r->failed = 1;
        return NULL;
    }
    const uint8_t *at = r->at;
    r->at += size;
    r->size -= (size_t)size;
    return at;
}

static int32_t take_integer(records *r)
{
    const uint8_t *p = take(r, 4);
    const uint32_t v = p ? (uint32_t)p[0] << 24 | (uint32_t)p[1] << 16 | (uint32_t)p[2] << 8 | p[3]
                         : 0;
    int32_t out;
    memcpy(&out, &v, 4);
    return out;
}

/* A length, and so many bytes; NULL after the end. */
static const char *take_text(records *r, size_t *length)
{
    const int32_t size = take_integer(r);
    const char *text = size < 0 ? NULL : (const char *)take(r, (uint64_t)size);
    r->failed = r->failed || !text;
    *length = text ? strnlen(text, (size_t)size) : 0;
    return text;
}

static int list_table(cvol_context *context, cvol_label_list *list, records *r, const char *path)
{
    const int32_t version = take_integer(r);
    size_t length;
    int code = CVOL_OK;
    int32_t count = version;
    if (version < 0)
        (void)take_integer(r); /* the largest label plus one */
    take_text(r, &length);     /* the file of the table */
    if (version < 0)
        count = take_integer(r);
    for (int32_t i = 0; i < count && !r->failed && !code; i++) {
        const int32_t value = version < 0 ? take_integer(r) : i;
        const char *name = take_text(r, &length);
        double rgb[3];
        int is_colour = 1;
        for (int c = 0; c < 3; c++) {
            const int32_t level = take_integer(r);
            is_colour = is_colour && level >= 0 && level <= 255;
            rgb[c] = level / 255.0;
        }
        (void)take_integer(r); /* 255 minus the opacity */
        if (!r->failed)
            code = cvol_label_list_add(context, list, value, name, length, is_colour ? rgb : NULL,
                                       path);
    }
    return code;
}

static int list_records(cvol_context *context, cvol_label_list *list, records *r, const char *path)
{
    take(r, 20);
    int code = CVOL_OK;
    while (!r->failed && !code && !list->count) {
        const int32_t tag = take_integer(r);
        if (tag == 0)
            break;
        if (tag == COLOURS) {
            code = list_table(context, list, r, path);
        } else if (tag == TRANSFORM) {
            take(r, (uint64_t)(uint32_t)take_integer(r));
        } else if (tag != REAL_RAS && tag != SURFACE) {
            const uint64_t high = (uint32_t)take_integer(r);
            take(r, high << 32 | (uint32_t)take_integer(r));
        }
    }
    return code;
}

/* The place of the records, behind the samples; 0: this is no header of MGH. */
static uint64_t end_of_samples(const uint8_t header[HEADER_BYTES])
{
    static const uint8_t sizes[] = {[0] = 1, [1] = 4, [3] = 4, [4] = 2, [10] = 2}; /* by type */
    records r = {header, HEADER_BYTES, 0};
    uint64_t bytes = 1;
    const int32_t version = take_integer(&r);
    for (int i = 0; i < 4; i++) {
        const int32_t size = take_integer(&r);
        if (size < 1 || __builtin_mul_overflow(bytes, (uint64_t)size, &bytes))
            return 0;
    }
    const int32_t type = take_integer(&r);
    if (version != 1 || type < 0 || type >= (int32_t)sizeof sizes || !sizes[type] ||
        __builtin_mul_overflow(bytes, (uint64_t)sizes[type], &bytes) ||
        __builtin_add_overflow(bytes, (uint64_t)HEADER_BYTES, &bytes))
        return 0;
    return bytes;
}

static int read_records(cvol_context *context, cvol_label_list *list, const cvol_input *input,
                        cvol_inflater *inflater, const char *path)
{
    uint8_t header[HEADER_BYTES] = {0};
    uint64_t got = 0;
    size_t size = 0;
    int code = inflater ? cvol_inflater_read(context, inflater, header, sizeof header, &got)
                        : cvol_input_read(context, input, 0, header, sizeof header, &size);
    const uint64_t begin = end_of_samples(header),
                   left = input->size > begin ? input->size - begin : 0;
    if (code || !begin || (!inflater && !left))
        return code;
    const size_t room = inflater || left > RECORDS_MOST ? RECORDS_MOST : (size_t)left;
    uint8_t *bytes = malloc(room);
    if (!bytes)
        return cvol_fail_memory(context, room, path);
    if (inflater) {
        code = cvol_inflater_read(context, inflater, NULL, begin - HEADER_BYTES, &got);
        if (!code && got == begin - HEADER_BYTES)
            code = cvol_inflater_read(context, inflater, bytes, room, &got);
        else
            got = 0;
        size = (size_t)got;
    } else {
        code = cvol_input_read(context, input, begin, bytes, room, &size);
    }
    records r = {bytes, size, 0};
    if (!code)
        code = list_records(context, list, &r, path);
    free(bytes);
    return code;
}

int cvol_mgh_list_labels(cvol_context *context, cvol_label_list *list, const char *path)
{
    cvol_input input;
    cvol_inflater *inflater = NULL;
    uint8_t head[2];
    size_t got = 0;
    int code = cvol_input_open(context, &input, path);
    if (!code)
        code = cvol_input_read(context, &input, 0, head, sizeof head, &got);
    if (!code && got == 2 && head[0] == 0x1f && head[1] == 0x8b)
        code = cvol_inflater_open(context, &inflater, &input, 0, input.size);
    if (!code)
        code = read_records(context, list, &input, inflater, path);
    cvol_inflater_close(inflater);
    cvol_input_close(&input);
    return code;
}
