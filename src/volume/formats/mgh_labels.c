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

#include "base/byte_order.h"
#include "base/context.h"
#include "volume/formats/label_list.h"
#include "volume/io/packed.h"

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
    const uint8_t *bytes = take(r, 4);
    const uint32_t v = bytes ? cvol_high_first(bytes) : 0;
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

static int read_records(cvol_context *context, cvol_label_list *list, cvol_packed *file,
                        const char *path)
{
    uint8_t header[HEADER_BYTES] = {0};
    uint64_t got = 0, size = 0;
    int code = cvol_packed_read(context, file, header, sizeof header, &got);
    const uint64_t begin = end_of_samples(header);
    if (!code && begin)
        code = cvol_packed_read(context, file, NULL, begin - HEADER_BYTES, &got);
    if (code || !begin || got < begin - HEADER_BYTES)
        return code;
    uint8_t *bytes = malloc(RECORDS_MOST);
    if (!bytes)
        return cvol_fail_memory(context, RECORDS_MOST, path);
    code = cvol_packed_read(context, file, bytes, RECORDS_MOST, &size);
    records r = {bytes, (size_t)size, 0};
    if (!code)
        code = list_records(context, list, &r, path);
    free(bytes);
    return code;
}

int cvol_mgh_list_labels(cvol_context *context, cvol_label_list *list, const char *path)
{
    cvol_packed file;
    int code = cvol_packed_open(context, &file, path);
    if (!code)
        code = read_records(context, list, &file, path);
    cvol_packed_close(&file);
    return code;
}
