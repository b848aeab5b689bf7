/* The values of a node of OpenVDB.
 *
 * A byte states how inactive values are stored. If the grid has the compression ACTIVE_MASK, and
 * this byte is not ALL_VALUES, then only active values follow: each inactive one is one of two
 * values, and a mask selects which. The values are packed by zlib or blosc, or neither. */
#include "volume/formats/vdb/values.h"

#include <string.h>
#include <zlib.h>

#include "base/byte_order.h"
#include "base/context.h"
#include "volume/io/strided.h"
#include "volume/io/unpack_blosc.h"
#include "volume/io/wide.h"

/* The byte in front of values: the two inactive values, and whether a mask selects. */
enum {
    BACKGROUND,               /* both are the background */
    MINUS_BACKGROUND,         /* its negative */
    ONE_VALUE,                /* a value follows */
    MASK_BACKGROUNDS,         /* a mask selects between minus background and background, */
    MASK_VALUE_OR_BACKGROUND, /* between a value that follows and the background, */
    MASK_TWO_VALUES,          /* between two values that follow */
    ALL_VALUES                /* inactive values are stored as active ones are */
};

/* Where a node has its values. */
typedef struct place {
    const uint8_t *inactive[2]; /* values of the file; NULL: the background */
    int is_minus;               /* the first one is minus the background */
    const uint8_t *selection;   /* a mask that selects the second one; NULL: none */
    size_t stored;              /* the number of values in the file */
    size_t width;               /* bytes of each */
    const uint8_t *bytes;       /* NULL: the file is cut off */
    uint64_t size;
    int is_packed;
} place;

int cvol_vdb_is_set(const uint8_t *mask, size_t i)
{
    return mask[i / 8] >> i % 8 & 1;
}

static size_t count_set(const uint8_t *mask, size_t count)
{
    size_t set = 0;
    for (size_t i = 0; i < count / 8; i++)
        set += (size_t)__builtin_popcount(mask[i]);
    return set;
}

static int is_real(const cvol_vdb_type *type)
{
    return !strcmp(type->name, "float") || !strcmp(type->name, "double");
}

/* ---- places --------------------------------------------------------------------------- */

/* Negative sizes are those of bytes that are not packed. */
static void find_bytes(place *p, cvol_cursor *cursor, const cvol_vdb_source *source)
{
    const int may_pack = (source->compression & (CVOL_VDB_ZIP | CVOL_VDB_BLOSC)) != 0;
    const int is_half = source->is_half && is_real(source->type);
    p->width = is_half ? 2 : source->type->bytes;
    p->size = p->stored * p->width;
    if (may_pack && !(is_half && !p->stored)) {
        const int64_t size = (int64_t)cvol_cursor_u64(cursor);
        p->is_packed = size > 0;
        if (p->is_packed)
            p->size = (uint64_t)size;
        else if (0 - (uint64_t)size != p->size)
            cursor->failed = 1;
    }
    if (p->size > cvol_cursor_left(cursor))
        cursor->failed = 1;
    p->bytes = cursor->failed ? NULL : cvol_cursor_take(cursor, (size_t)p->size);
}

static place find_place(cvol_cursor *cursor, const cvol_vdb_source *source, size_t count,
                        const uint8_t *active)
{
    place p = {0};
    const uint8_t kind = cvol_cursor_u8(cursor);
    p.is_minus = kind != BACKGROUND;
    if (kind == ONE_VALUE || kind == MASK_VALUE_OR_BACKGROUND || kind == MASK_TWO_VALUES)
        p.inactive[0] = cvol_cursor_take(cursor, source->type->bytes);
    if (kind == MASK_TWO_VALUES)
        p.inactive[1] = cvol_cursor_take(cursor, source->type->bytes);
    if (kind == MASK_BACKGROUNDS || kind == MASK_VALUE_OR_BACKGROUND || kind == MASK_TWO_VALUES)
        p.selection = cvol_cursor_take(cursor, count / 8);
    if (kind > ALL_VALUES)
        cursor->failed = 1;
    const int is_masked = source->compression & CVOL_VDB_ACTIVE_MASK && kind != ALL_VALUES;
    p.stored = is_masked ? count_set(active, count) : count;
    find_bytes(&p, cursor, source);
    return p;
}

void cvol_vdb_values_skip(cvol_cursor *cursor, const cvol_vdb_source *source, size_t count,
                          const uint8_t *active)
{
    find_place(cursor, source, count, active);
}

/* ---- samples -------------------------------------------------------------------------- */

void cvol_vdb_to_samples(void *out, const uint8_t *values, size_t count, const cvol_vdb_type *type,
                         int half)
{
    const size_t width = half ? 2 : type->bytes;
    if (type->sample == CVOL_UINT8) {
        for (size_t i = 0; i < count; i++)
            ((uint8_t *)out)[i] = values[i] != 0;
        return;
    }
    if (width != 2) {
        memcpy(out, values, count * width);
        if (cvol_machine_is_big_endian())
            cvol_swap_bytes(out, count, width);
        return;
    }
    for (size_t i = 0; i < count; i++) {
        const uint16_t bits = (uint16_t)(values[2 * i] | values[2 * i + 1] << 8);
        float value;
        cvol_strided_gather(&value, &bits, 1, 2, 2, 1);
        const double wide = (double)value;
        if (type->sample == CVOL_FLOAT64)
            memcpy((uint8_t *)out + 8 * i, &wide, 8);
        else
            memcpy((uint8_t *)out + 4 * i, &value, 4);
    }
}

static void negate(uint8_t sample[8], const cvol_vdb_type *type)
{
    float f;
    double d;
    uint32_t i;
    uint64_t l;
    switch (type->sample) {
    case CVOL_UINT8:
        sample[0] = !sample[0];
        break;
    case CVOL_FLOAT32:
        memcpy(&f, sample, 4);
        f = -f;
        memcpy(sample, &f, 4);
        break;
    case CVOL_INT32:
        memcpy(&i, sample, 4);
        i = 0 - i;
        memcpy(sample, &i, 4);
        break;
    default:
        if (is_real(type)) {
            memcpy(&d, sample, 8);
            d = -d;
            memcpy(sample, &d, 8);
        } else {
            memcpy(&l, sample, 8);
            l = 0 - l;
            memcpy(sample, &l, 8);
        }
    }
}

static void find_inactive(uint8_t samples[2][8], const place *p, const cvol_vdb_source *source)
{
    for (int i = 0; i < 2; i++) {
        memcpy(samples[i], source->background, 8);
        if (p->inactive[i])
            cvol_vdb_to_samples(samples[i], p->inactive[i], 1, source->type, 0);
    }
    if (p->is_minus && !p->inactive[0])
        negate(samples[0], source->type);
}

static int unpack(cvol_context *context, void *out, const place *p, const cvol_vdb_source *source,
                  const char *name)
{
    const size_t bytes = p->stored * p->width;
    uLongf length = (uLongf)bytes;
    if (source->compression & CVOL_VDB_BLOSC)
        return cvol_unpack_blosc(context, out, bytes, p->bytes, (size_t)p->size, name);
    if (uncompress(out, &length, p->bytes, (uLong)p->size) == Z_OK && length == bytes)
        return CVOL_OK;
    return cvol_fail(context, CVOL_ERROR_FORMAT, "%s: its compressed values are damaged", name);
}

/* Puts stored samples, in place, to where they are active, from the last one on. */
static void spread(uint8_t *samples, const place *p, const cvol_vdb_source *source, size_t count,
                   const uint8_t *active)
{
    const size_t bytes = cvol_type_size(source->type->sample);
    uint8_t inactive[2][8];
    size_t from = p->stored;
    find_inactive(inactive, p, source);
    for (size_t i = count; i-- > 0;) {
        const int second = p->selection && cvol_vdb_is_set(p->selection, i);
        const uint8_t *sample = cvol_vdb_is_set(active, i) ? samples + --from * bytes
                                                           : inactive[second];
        memmove(samples + i * bytes, sample, bytes);
    }
}

int cvol_vdb_values_read(cvol_context *context, void *out, void *room,
                         const cvol_vdb_source *source, size_t offset, size_t count,
                         const uint8_t *active, const char *name)
{
    cvol_cursor cursor = cvol_cursor_make(source->data, source->size);
    cursor.at = offset;
    const place p = find_place(&cursor, source, count, active);
    const uint8_t *values = p.bytes;
    if (!values)
        return cvol_fail(context, CVOL_ERROR_FORMAT, "%s: is cut off or damaged in its values",
                         name);
    if (p.is_packed) {
        const int code = unpack(context, room, &p, source, name);
        if (code)
            return code;
        values = room;
    }
    cvol_vdb_to_samples(out, values, p.stored, source->type, p.width == 2);
    if (p.stored < count)
        spread(out, &p, source, count, active);
    return CVOL_OK;
}
