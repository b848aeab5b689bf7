/* zarr.json of Zarr format 3 (zarr-specs.readthedocs.io, "Zarr core specification version 3"). The
 * codecs: transpose, then bytes or cvol, then one of gzip, zstd and blosc, then crc32c; or
 * sharding_indexed with such codecs inside. */
#include <stdlib.h>
#include <string.h>

#include "base/context.h"
#include "volume/formats/zarr/array.h"

/* A codec, or an extension point, may be an object or only a name. */
static const char *name_of(const json_t *part)
{
    const char *name = json_string_value(part);
    return name ? name : json_string_value(json_object_get(part, "name"));
}

static const json_t *configuration_of(const json_t *part)
{
    return json_object_get(part, "configuration");
}

static int read_data_type(cvol_zarr_array *array, const cvol_zarr_json *json)
{
    static const char *const names[][2] = {{"bool", "b1"},    {"uint8", "u1"},   {"int8", "i1"},
                                           {"uint16", "u2"},  {"int16", "i2"},   {"uint32", "u4"},
                                           {"int32", "i4"},   {"float16", "f2"}, {"float32", "f4"},
                                           {"float64", "f8"}, {"int64", "i8"},   {"uint64", "u8"}};
    const json_t *value = json_object_get(json->root, "data_type");
    const char *name = json_string_value(value);
    for (size_t i = 0; name && i < sizeof names / sizeof *names; i++)
        if (!strcmp(name, names[i][0]) && cvol_zarr_set_type(array, names[i][1]))
            return CVOL_OK;
    return cvol_zarr_json_fail(json, value ? CVOL_ERROR_UNSUPPORTED : CVOL_ERROR_FORMAT,
                               "data_type", value,
                               "which is not supported (integers and floats are)");
}

static int read_keys(cvol_zarr_array *array, const cvol_zarr_json *json)
{
    const json_t *keys = json_object_get(json->root, "chunk_key_encoding");
    const json_t *value = json_object_get(configuration_of(keys), "separator");
    const char *name = name_of(keys), *separator = json_string_value(value);
    const int is_default = name && !strcmp(name, "default");
    if (!name || (!is_default && strcmp(name, "v2")) ||
        (value && (!separator || (strcmp(separator, ".") && strcmp(separator, "/")))))
        return cvol_zarr_json_fail(json, CVOL_ERROR_UNSUPPORTED, "chunk_key_encoding", keys,
                                   "must be default or v2 with the separator \".\" or \"/\"");
    array->prefix = is_default ? "c" : "";
    array->separator = separator ? *separator : is_default ? '/' : '.';
    return CVOL_OK;
}

/* ---- codecs -------------------------------------------------------------------------- */

static int fail_codecs(const cvol_zarr_json *json, const json_t *codecs)
{
    return cvol_zarr_json_fail(json, CVOL_ERROR_UNSUPPORTED, "codecs", codecs,
                               "must be transpose, then bytes or cvol, then one of gzip, zstd and "
                               "blosc, then crc32c; or sharding_indexed alone");
}

/* The order after one more transposition; 0: it is none. */
static int transpose(cvol_zarr_array *array, const json_t *order)
{
    int before[CVOL_ZARR_AXES], seen[CVOL_ZARR_AXES] = {0};
    memcpy(before, array->order, sizeof before);
    if (json_array_size(order) != (size_t)array->rank)
        return 0;
    for (int a = 0; a < array->rank; a++) {
        const json_t *entry = json_array_get(order, (size_t)a);
        const json_int_t axis = json_integer_value(entry);
        if (!json_is_integer(entry) || axis < 0 || axis >= array->rank || seen[axis]++)
            return 0;
        array->order[a] = before[axis];
    }
    return 1;
}

static int read_endian(cvol_zarr_array *array, const json_t *codec)
{
    const json_t *value = json_object_get(configuration_of(codec), "endian");
    const char *endian = json_string_value(value);
    array->big_endian = endian && !strcmp(endian, "big");
    return endian ? array->big_endian || !strcmp(endian, "little") : array->element == 1;
}

/* The codecs of chunks that have no parts. */
static int read_codecs(cvol_zarr_array *array, const cvol_zarr_json *json, const json_t *codecs)
{
    enum { BEFORE, SAMPLES, PACKED, CHECKED } state = BEFORE;
    array->packing = CVOL_ZARR_PLAIN;
    for (size_t i = 0; i < json_array_size(codecs); i++) {
        const json_t *codec = json_array_get(codecs, i);
        const char *name = name_of(codec);
        int right = 0;
        if (!name)
            return fail_codecs(json, codecs);
        if (!strcmp(name, "transpose") && state == BEFORE) {
            right = transpose(array, json_object_get(configuration_of(codec), "order"));
        } else if (!strcmp(name, "bytes") && state == BEFORE) {
            right = read_endian(array, codec);
            state = SAMPLES;
        } else if (!strcmp(name, "cvol") && state == BEFORE) {
            array->packing = CVOL_ZARR_CVOL;
            right = 1;
            state = PACKED;
        } else if (!strcmp(name, "crc32c") && (state == SAMPLES || state == PACKED)) {
            right = array->has_checksum = 1;
            state = CHECKED;
        } else if (state == SAMPLES) {
            array->packing = !strcmp(name, "gzip")    ? CVOL_ZARR_DEFLATE
                             : !strcmp(name, "zstd")  ? CVOL_ZARR_ZSTD
                             : !strcmp(name, "blosc") ? CVOL_ZARR_BLOSC
                                                      : CVOL_ZARR_PLAIN;
            right = array->packing != CVOL_ZARR_PLAIN;
            state = PACKED;
        }
        if (!right)
            return fail_codecs(json, codecs);
    }
    return state == BEFORE ? fail_codecs(json, codecs) : CVOL_OK;
}

/* Shards: the chunks inside become the array's chunks. */
static int read_shards(cvol_zarr_array *array, const cvol_zarr_json *json, const json_t *codecs)
{
    const json_t *options = configuration_of(json_array_get(codecs, 0));
    const json_t *sides = json_object_get(options, "chunk_shape");
    const json_t *index = json_object_get(options, "index_codecs");
    const char *place = json_string_value(json_object_get(options, "index_location"));
    uint64_t inner[CVOL_ZARR_AXES] = {0}, count = 1;
    const size_t index_codecs = json_array_size(index);
    const char *first = name_of(json_array_get(index, 0)),
               *last = name_of(json_array_get(index, 1));
    const char *endian = json_string_value(
        json_object_get(configuration_of(json_array_get(index, 0)), "endian"));
    if (index_codecs < 1 || index_codecs > 2 || !first || strcmp(first, "bytes") || !endian ||
        strcmp(endian, "little") || (index_codecs == 2 && (!last || strcmp(last, "crc32c"))))
        return cvol_zarr_json_fail(json, CVOL_ERROR_UNSUPPORTED, "index_codecs", index,
                                   "must be bytes (little), and crc32c");
    int code = cvol_zarr_json_sizes(json, "chunk_shape", sides, 1, inner, &array->rank);
    for (int a = 0; !code && a < array->rank; a++) {
        const uint64_t here = array->chunk[a] / inner[a];
        if (array->chunk[a] % inner[a] || __builtin_mul_overflow(count, here, &count) ||
            count > UINT64_C(1) << 40)
            code = cvol_zarr_json_fail(json, CVOL_ERROR_FORMAT, "chunk_shape", sides,
                                       "must divide the shape of the shards");
        array->shard[a] = here;
        array->chunk[a] = inner[a];
    }
    array->is_sharded = 1;
    array->index_at_start = place && !strcmp(place, "start");
    array->index_checksum = index_codecs == 2 ? 4 : 0;
    array->checked = calloc(CVOL_ZARR_CHECKED, sizeof *array->checked);
    if (!code && !array->checked)
        code = cvol_fail_memory(json->context, sizeof *array->checked, json->path);
    return code ? code : read_codecs(array, json, json_object_get(options, "codecs"));
}

/* ---- the array ----------------------------------------------------------------------- */

static void read_names(cvol_zarr_array *array, const json_t *names)
{
    for (int a = 0; a < array->rank; a++) {
        const char *name = json_string_value(json_array_get(names, (size_t)a));
        array->names[a] = (char)(name && name[0] && !name[1] ? name[0] : 0);
    }
}

int cvol_zarr_array_read_3(cvol_zarr_array *array, const cvol_zarr_json *json)
{
    const json_t *grid = json_object_get(json->root, "chunk_grid");
    const json_t *chunks = json_object_get(configuration_of(grid), "chunk_shape");
    const json_t *codecs = json_object_get(json->root, "codecs");
    const char *kind = name_of(grid), *first = name_of(json_array_get(codecs, 0));
    if (!kind || strcmp(kind, "regular"))
        return cvol_zarr_json_fail(json, CVOL_ERROR_UNSUPPORTED, "chunk_grid", grid,
                                   "must be regular");
    int code = cvol_zarr_json_sizes(json, "shape", json_object_get(json->root, "shape"), 1,
                                    array->shape, &array->rank);
    if (!code)
        code = cvol_zarr_json_sizes(json, "chunk_shape", chunks, 1, array->chunk, &array->rank);
    for (int a = 0; a < array->rank; a++) {
        array->shard[a] = 1;
        array->order[a] = a;
    }
    if (!code)
        code = read_data_type(array, json);
    if (!code)
        code = read_keys(array, json);
    if (!code)
        code = first && !strcmp(first, "sharding_indexed") && json_array_size(codecs) == 1
                   ? read_shards(array, json, codecs)
                   : read_codecs(array, json, codecs);
    if (!code)
        code = cvol_zarr_set_fill(array, json, json_object_get(json->root, "fill_value"));
    read_names(array, json_object_get(json->root, "dimension_names"));
    return code ? code : cvol_zarr_complete(array, json, "chunk_shape", chunks);
}
