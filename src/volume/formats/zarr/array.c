/* Sample types, fill values and sizes of arrays of both formats of Zarr. */
#include "volume/formats/zarr/array.h"

#include <errno.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/byte_order.h"
#include "base/context.h"
#include "base/for_type.h"
#include "base/memory.h"

static const struct {
    const char *name;
    cvol_type type;
    size_t element;
} types[] = {
    {"u1", CVOL_UINT8, 1},   {"b1", CVOL_UINT8, 1},     {"i1", CVOL_INT8, 1},
    {"u2", CVOL_UINT16, 2},  {"i2", CVOL_INT16, 2},     {"u4", CVOL_UINT32, 4},
    {"i4", CVOL_INT32, 4},   {"f2", CVOL_FLOAT32, 2},   {"f4", CVOL_FLOAT32, 4},
    {"f8", CVOL_FLOAT64, 8}, {"i8", CVOL_WIDE_TYPE, 8}, {"u8", CVOL_WIDE_TYPE, 8},
};

int cvol_zarr_set_type(cvol_zarr_array *array, const char *name)
{
    for (size_t i = 0; i < sizeof types / sizeof *types; i++)
        if (!strcmp(name, types[i].name)) {
            array->type = types[i].type;
            array->element = types[i].element;
            array->is_half = array->type == CVOL_FLOAT32 && array->element == 2;
            array->wide = !strcmp(name, "i8")   ? CVOL_WIDE_INT64
                          : !strcmp(name, "u8") ? CVOL_WIDE_UINT64
                                                : CVOL_WIDE_NONE;
            return 1;
        }
    return 0;
}

/* ---- fill values --------------------------------------------------------------------- */

static double float_of(double value)
{
    return (double)(float)value;
}

/* Bits of a float, as in "0x7fc00000". 0: not such a text. */
static int read_bits(cvol_zarr_array *array, const char *text)
{
    char *end;
    const size_t size = cvol_type_size(array->type);
    if (strncmp(text, "0x", 2) || strlen(text) != 2 + 2 * size || array->is_half ||
        cvol_type_is_integer(array->type))
        return 0;
    const uint64_t bits = strtoull(text, &end, 16);
    const uint32_t low = (uint32_t)bits;
    memcpy(array->fill, size == 4 ? (const void *)&low : (const void *)&bits, size);
    return !*end;
}

/* An integer that json.h left as text. 0: it is none, or has more than 64 bits. */
static int read_large(uint64_t *out, const char *text)
{
    char *end;
    if (!text || *text < '0' || *text > '9')
        return 0;
    errno = 0;
    *out = strtoull(text, &end, 10);
    return !*end && errno == 0;
}

/* The number of a fill value; 0: it is none. */
static int read_number(double *out, const json_t *value)
{
    uint64_t large;
    const char *text = json_string_value(value);
    if (json_is_number(value))
        *out = json_number_value(value);
    else if (json_is_boolean(value))
        *out = json_is_true(value);
    else if (!value || json_is_null(value))
        *out = 0;
    else if (read_large(&large, text))
        *out = (double)large;
    else if (text && !strcmp(text, "NaN"))
        *out = NAN;
    else if (text && (!strcmp(text, "Infinity") || !strcmp(text, "-Infinity")))
        *out = *text == '-' ? -INFINITY : INFINITY;
    else
        return 0;
    return 1;
}

int cvol_zarr_set_fill(cvol_zarr_array *array, const cvol_zarr_json *json, const json_t *value)
{
    double number = 0;
    uint64_t large;
    const char *text = json_string_value(value);
    if (text && read_bits(array, text))
        return CVOL_OK;
    if (array->wide == CVOL_WIDE_UINT64 && array->packing != CVOL_ZARR_CVOL &&
        read_large(&large, text)) {
        memcpy(array->fill, &large, sizeof large);
        return CVOL_OK;
    }
    int right = read_number(&number, value);
    if (array->wide && array->packing != CVOL_ZARR_CVOL && json_is_integer(value) &&
        (array->wide == CVOL_WIDE_INT64 || json_integer_value(value) >= 0)) {
        const int64_t exact = json_integer_value(value); /* a double may not hold it */
        memcpy(array->fill, &exact, sizeof exact);
        return CVOL_OK;
    }
    if (right && (cvol_type_is_integer(array->type) || array->wide)) {
        const int bits = 8 * (int)cvol_type_size(array->type);
        const int is_signed = array->type == CVOL_INT8 || array->type == CVOL_INT16 ||
                              array->type == CVOL_INT32 || array->wide == CVOL_WIDE_INT64;
        const double least = is_signed ? -ldexp(1, bits - 1) : 0;
        const double end = ldexp(1, is_signed ? bits - 1 : bits); /* the first that is too large */
        right = number >= least && number < end && !(number < floor(number)) &&
                !(number > floor(number));
    } else if (right && isfinite(number) && array->type == CVOL_FLOAT32)
        right = isfinite(float_of(number));
    if (!right)
        return cvol_zarr_json_fail(json, CVOL_ERROR_FORMAT, "fill_value", value,
                                   "must be a value of the array's type");
    if (array->wide && array->packing != CVOL_ZARR_CVOL) {
        const uint64_t bits = number < 0 ? (uint64_t)(int64_t)number : (uint64_t)number;
        memcpy(array->fill, &bits, sizeof bits);
        return CVOL_OK;
    }
#define STORE(t)                                 \
    {                                            \
        const t sample = (t)number;              \
        memcpy(array->fill, &sample, sizeof(t)); \
    }
    CVOL_FOR_TYPE(array->type, STORE);
#undef STORE
    return CVOL_OK;
}

/* ---- sizes --------------------------------------------------------------------------- */

int cvol_zarr_complete(cvol_zarr_array *array, const cvol_zarr_json *json, const char *field,
                       const json_t *chunks)
{
    const uint64_t limit = json->context->limit_bytes;
    if (array->packing == CVOL_ZARR_CVOL) { /* its decoder converts samples */
        array->is_half = 0;
        array->wide = CVOL_WIDE_NONE;
        array->element = cvol_type_size(array->type);
        array->big_endian = cvol_machine_is_big_endian();
    }
    size_t bytes = array->element;
    int fits = 1;
    for (int a = 0; a < array->rank; a++) {
        if ((size_t)array->shape[a] != array->shape[a]) /* where size_t has 32 bits */
            return cvol_zarr_json_fail(json, CVOL_ERROR_LIMIT, "shape",
                                       json_object_get(json->root, "shape"),
                                       "more samples than this machine can count");
        fits = fits && (size_t)array->chunk[a] == array->chunk[a] &&
               cvol_size_multiply(&bytes, bytes, (size_t)array->chunk[a]);
    }
    if (!fits || bytes > limit || bytes > PTRDIFF_MAX / 4) {
        char must[96];
        snprintf(must, sizeof must, "a chunk of more bytes than the limit of %llu",
                 (unsigned long long)limit);
        return cvol_zarr_json_fail(json, CVOL_ERROR_LIMIT, field, chunks, must);
    }
    array->chunk_bytes = bytes;
    return CVOL_OK;
}
