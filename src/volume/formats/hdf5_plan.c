/* Writing HDF5, which needs no library: one contiguous dataset, FILE.h5:/a/name or else /data, with
 * axes z, y, x, in a file
 * of the format's second generation (libhdf5 1.8 and later; "HDF5 File Format Specification",
 * version 2.0). Spacing in a unit of length is Fiji's attribute element_size_um. */
#include "volume/formats/hdf5.h"

#include <string.h>

#include "base/context.h"
#include "volume/io/unit.h"

enum { ALIGNMENT = 512, SUPERBLOCK_BYTES = 48, NAME_MOST = 255 };
enum {
    DATASPACE = 1,
    LINK_INFO = 2,
    DATATYPE = 3,
    FILL = 5,
    LINK = 6,
    LAYOUT = 8,
    GROUP_INFO = 10,
    ATTRIBUTE = 12
};

static const char spacing_name[] = "element_size_um";

/* ---- check sums ----------------------------------------------------------------------- */

static uint32_t rotate(uint32_t x, int bits)
{
    return x << bits | x >> (32 - bits);
}

static uint32_t word(const uint8_t *data, size_t size, size_t at)
{
    uint32_t w = 0;
    for (size_t i = 0; i < 4 && at + i < size; i++)
        w |= (uint32_t)data[at + i] << (8 * i);
    return w;
}

/* Jenkins' lookup3, hashlittle (burtleburtle.net/bob/c/lookup3.c, public domain), of size > 0. */
static uint32_t lookup3(const uint8_t *data, size_t size)
{
    uint32_t a = 0xdeadbeef + (uint32_t)size, b = a, c = a;
    size_t at = 0;
    for (; size - at > 12; at += 12) {
        a += word(data, size, at);
        b += word(data, size, at + 4);
        c += word(data, size, at + 8);
        a = (a - c) ^ rotate(c, 4), c += b;
        b = (b - a) ^ rotate(a, 6), a += c;
        c = (c - b) ^ rotate(b, 8), b += a;
        a = (a - c) ^ rotate(c, 16), c += b;
        b = (b - a) ^ rotate(a, 19), a += c;
        c = (c - b) ^ rotate(b, 4), b += a;
    }
    a += word(data, size, at);
    b += word(data, size, at + 4);
    c += word(data, size, at + 8);
    c = (c ^ b) - rotate(b, 14);
    a = (a ^ c) - rotate(c, 11);
    b = (b ^ a) - rotate(a, 25);
    c = (c ^ b) - rotate(b, 16);
    a = (a ^ c) - rotate(c, 4);
    b = (b ^ a) - rotate(a, 14);
    return (c ^ b) - rotate(b, 24);
}

/* Appends the check sum of the bytes from `first` on. */
static void put_checksum(cvol_bytes *out, size_t first)
{
    if (!out->failed)
        cvol_bytes_put_u32(out, lookup3(out->data + first, out->size - first));
}

/* ---- messages ------------------------------------------------------------------------- */

static void put_message(cvol_bytes *out, int type, cvol_bytes *data)
{
    cvol_bytes_put_u8(out, (uint8_t)type);
    cvol_bytes_put_u16(out, (uint16_t)data->size);
    cvol_bytes_put_u8(out, 0);
    cvol_bytes_append(out, data->data, data->size);
    out->failed = out->failed || data->failed;
    cvol_bytes_free(data);
}

static void put_dataspace(cvol_bytes *out, const size_t *dims, int rank)
{
    cvol_bytes_put_u8(out, 2);
    cvol_bytes_put_u8(out, (uint8_t)rank);
    cvol_bytes_put_u8(out, 0); /* no largest sizes */
    cvol_bytes_put_u8(out, 1); /* simple */
    for (int i = 0; i < rank; i++)
        cvol_bytes_put_u64(out, dims[i]);
}

static int is_signed(cvol_type type)
{
    return type == CVOL_INT8 || type == CVOL_INT16 || type == CVOL_INT32;
}

static void put_datatype(cvol_bytes *out, cvol_type type)
{
    const uint16_t bits = (uint16_t)(8 * cvol_type_size(type));
    const int is_float = !cvol_type_is_integer(type), is_double = type == CVOL_FLOAT64;
    cvol_bytes_put_u8(out, is_float ? 0x11 : 0x10);
    /* Little-endian; integers of two's complement, or floats with an implied first bit. */
    cvol_bytes_put_u8(out, is_float ? 0x20 : is_signed(type) ? 8 : 0);
    cvol_bytes_put_u8(out, is_float ? (uint8_t)(bits - 1) : 0); /* the place of the sign */
    cvol_bytes_put_u8(out, 0);
    cvol_bytes_put_u32(out, bits / 8);
    cvol_bytes_put_u16(out, 0);
    cvol_bytes_put_u16(out, bits);
    if (!is_float)
        return;
    cvol_bytes_put_u8(out, is_double ? 52 : 23); /* place and size of the exponent */
    cvol_bytes_put_u8(out, is_double ? 11 : 8);
    cvol_bytes_put_u8(out, 0); /* place and size of the mantissa */
    cvol_bytes_put_u8(out, is_double ? 52 : 23);
    cvol_bytes_put_u32(out, is_double ? 1023 : 127);
}

static void put_spacing(cvol_bytes *out, const cvol_grid *grid)
{
    static const size_t three = 3;
    const double micrometres = cvol_unit_metres(grid->unit) * 1e6;
    cvol_bytes type = {0}, space = {0}, data = {0};
    put_datatype(&type, CVOL_FLOAT64);
    put_dataspace(&space, &three, 1);
    cvol_bytes_put_u8(&data, 3);
    cvol_bytes_put_u8(&data, 0);
    cvol_bytes_put_u16(&data, sizeof spacing_name);
    cvol_bytes_put_u16(&data, (uint16_t)type.size);
    cvol_bytes_put_u16(&data, (uint16_t)space.size);
    cvol_bytes_put_u8(&data, 0); /* the name is ASCII */
    cvol_bytes_append(&data, spacing_name, sizeof spacing_name);
    cvol_bytes_append(&data, type.data, type.size);
    cvol_bytes_append(&data, space.data, space.size);
    for (int a = 2; a >= 0; a--)
        cvol_bytes_put_f64(&data, grid->spacing[a] * micrometres);
    data.failed = data.failed || type.failed || space.failed;
    cvol_bytes_free(&type);
    cvol_bytes_free(&space);
    put_message(out, ATTRIBUTE, &data);
}

/* ---- objects -------------------------------------------------------------------------- */

static void put_object(cvol_bytes *out, cvol_bytes *messages)
{
    const size_t first = out->size;
    cvol_bytes_append(out, "OHDR\2\1", 6); /* the size has two bytes */
    cvol_bytes_put_u16(out, (uint16_t)messages->size);
    cvol_bytes_append(out, messages->data, messages->size);
    out->failed = out->failed || messages->failed;
    put_checksum(out, first);
    cvol_bytes_free(messages);
}

/* A group with its one link, to the object that follows it. */
static void put_group(cvol_bytes *out, const char *name, size_t length)
{
    enum { HEAD_BYTES = 8, TAIL_BYTES = 4, MESSAGE_BYTES = 4, PLACE_BYTES = 8 };
    cvol_bytes info = {0}, group = {0}, link = {0}, messages = {0};
    cvol_bytes_put_u16(&info, 0);
    cvol_bytes_put_u64(&info, UINT64_MAX); /* links are messages */
    cvol_bytes_put_u64(&info, UINT64_MAX);
    put_message(&messages, LINK_INFO, &info);
    cvol_bytes_put_u16(&group, 0);
    put_message(&messages, GROUP_INFO, &group);
    cvol_bytes_put_u8(&link, 1);
    cvol_bytes_put_u8(&link, 0x10); /* a hard link with a set of characters: */
    cvol_bytes_put_u8(&link, 1);    /* UTF-8 */
    cvol_bytes_put_u8(&link, (uint8_t)length);
    cvol_bytes_append(&link, name, length);
    cvol_bytes_put_u64(&link, out->size + HEAD_BYTES + messages.size + MESSAGE_BYTES + link.size +
                                  PLACE_BYTES + TAIL_BYTES);
    put_message(&messages, LINK, &link);
    put_object(out, &messages);
}

/* The groups of a dataset's path, from the root on. A slash at the beginning is left out. */
static int put_groups(cvol_context *context, cvol_bytes *out, const char *name, const char *path)
{
    for (const char *part = name + (*name == '/');; part++) {
        const size_t length = strcspn(part, "/");
        if (!length || length > NAME_MOST || (length == 1 && *part == '.'))
            return cvol_fail(
                context, CVOL_ERROR_ARGUMENT,
                "%s: behind the colon must be a dataset's name, as in out.h5:/scan/ct, "
                "of parts of 1 to %d bytes",
                path, (int)NAME_MOST);
        put_group(out, part, length);
        part += length;
        if (!*part)
            return CVOL_OK;
    }
}

static void put_dataset(cvol_bytes *out, const cvol_grid *grid, uint64_t samples)
{
    const size_t dims[3] = {grid->dims[2], grid->dims[1], grid->dims[0]};
    cvol_bytes space = {0}, type = {0}, fill = {0}, layout = {0}, messages = {0};
    put_dataspace(&space, dims, 3);
    put_message(&messages, DATASPACE, &space);
    put_datatype(&type, grid->type);
    put_message(&messages, DATATYPE, &type);
    cvol_bytes_put_u8(&fill, 3);
    cvol_bytes_put_u8(&fill, 0x0a); /* none, and space is allocated late */
    put_message(&messages, FILL, &fill);
    cvol_bytes_put_u8(&layout, 3);
    cvol_bytes_put_u8(&layout, 1); /* contiguous */
    cvol_bytes_put_u64(&layout, samples);
    cvol_bytes_put_u64(&layout, cvol_grid_bytes(grid));
    put_message(&messages, LAYOUT, &layout);
    if (cvol_unit_metres(grid->unit) > 0)
        put_spacing(&messages, grid);
    put_object(out, &messages);
}

/* All objects, for samples at byte `samples` of the file. The caller frees them; after a failure
 * there are none. */
static int put_objects(cvol_context *context, cvol_bytes *out, const cvol_grid *grid,
                       const char *path, uint64_t samples)
{
    static const uint8_t blank[SUPERBLOCK_BYTES];
    const size_t length = cvol_volume_writer_file_length(path);
    *out = (cvol_bytes){0};
    cvol_bytes_append(out, blank, sizeof blank); /* so that places are those of the file */
    const int code = put_groups(context, out, path[length] ? path + length + 1 : "data", path);
    if (code)
        cvol_bytes_free(out);
    else
        put_dataset(out, grid, samples);
    return code;
}

int cvol_hdf5_plan(cvol_context *context, cvol_write_plan *plan, const cvol_grid *grid,
                   const char *path)
{
    cvol_bytes *out = &plan->header, objects;
    int code = put_objects(context, &objects, grid, path, 0); /* for their size */
    const size_t samples = (objects.size + ALIGNMENT - 1) / ALIGNMENT * ALIGNMENT;
    const int has_failed = objects.failed;
    cvol_bytes_free(&objects);
    if (!code)
        code = put_objects(context, &objects, grid, path, samples);
    if (code)
        return code;
    cvol_bytes_append(out, "\x89HDF\r\n\x1a\n\2\10\10", 12); /* version 2, offsets of 8 bytes */
    cvol_bytes_put_u64(out, 0);
    cvol_bytes_put_u64(out, UINT64_MAX); /* no extension */
    cvol_bytes_put_u64(out, samples + cvol_grid_bytes(grid));
    cvol_bytes_put_u64(out, SUPERBLOCK_BYTES);
    put_checksum(out, 0);
    if (!objects.failed)
        cvol_bytes_append(out, objects.data + SUPERBLOCK_BYTES, objects.size - SUPERBLOCK_BYTES);
    out->failed = out->failed || has_failed || objects.failed;
    while (!out->failed && out->size < samples)
        cvol_bytes_put_u8(out, 0);
    cvol_bytes_free(&objects);
    plan->encoding = CVOL_ENCODING_RAW;
    return CVOL_OK;
}
