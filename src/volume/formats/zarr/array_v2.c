/* .zarray of Zarr format 2 (zarr-specs.readthedocs.io, "Zarr storage specification version 2"). */
#include <string.h>

#include "base/context.h"
#include "volume/formats/zarr/array.h"

static int read_dtype(cvol_zarr_array *array, const cvol_zarr_json *json)
{
    const json_t *value = json_object_get(json->root, "dtype");
    const char *text = json_string_value(value);
    if (!text || !*text || !strchr("<>|", *text))
        return cvol_zarr_json_fail(json, text ? CVOL_ERROR_FORMAT : CVOL_ERROR_UNSUPPORTED, "dtype",
                                   value, "must be a type as in \"<f4\"");
    array->big_endian = *text == '>';
    return cvol_zarr_set_type(array, text + 1)
               ? CVOL_OK
               : cvol_zarr_json_fail(json, CVOL_ERROR_UNSUPPORTED, "dtype", value,
                                     "which is not supported (integers and floats are)");
}

static int read_compressor(cvol_zarr_array *array, const cvol_zarr_json *json)
{
    static const struct {
        const char *id;
        cvol_zarr_packing packing;
    } known[] = {{"zlib", CVOL_ZARR_DEFLATE},
                 {"gzip", CVOL_ZARR_DEFLATE},
                 {"zstd", CVOL_ZARR_ZSTD},
                 {"blosc", CVOL_ZARR_BLOSC},
                 {"cvol", CVOL_ZARR_CVOL}};
    const json_t *value = json_object_get(json->root, "compressor");
    const json_t *filters = json_object_get(json->root, "filters");
    const char *id = json_string_value(json_object_get(value, "id"));
    if (filters && !json_is_null(filters) && json_array_size(filters))
        return cvol_zarr_json_fail(json, CVOL_ERROR_UNSUPPORTED, "filters", filters,
                                   "which are not supported");
    array->packing = CVOL_ZARR_PLAIN;
    if (!value || json_is_null(value))
        return CVOL_OK;
    for (size_t i = 0; id && i < sizeof known / sizeof *known; i++)
        if (!strcmp(id, known[i].id)) {
            array->packing = known[i].packing;
            return CVOL_OK;
        }
    return cvol_zarr_json_fail(json, CVOL_ERROR_UNSUPPORTED, "compressor", value,
                               "must be one of zlib, gzip, zstd, blosc, cvol, or null");
}

/* The order of axes, and the separator in names of chunks. */
static int read_layout(cvol_zarr_array *array, const cvol_zarr_json *json)
{
    const json_t *value = json_object_get(json->root, "order");
    const char *order = json_string_value(value);
    if (!order || (strcmp(order, "C") && strcmp(order, "F")))
        return cvol_zarr_json_fail(json, CVOL_ERROR_FORMAT, "order", value,
                                   "must be \"C\" or \"F\"");
    /* Codec cvol keeps the order of axes by itself. */
    const int is_reversed = *order == 'F' && array->packing != CVOL_ZARR_CVOL;
    for (int a = 0; a < array->rank; a++)
        array->order[a] = is_reversed ? array->rank - 1 - a : a;
    array->prefix = "";
    array->separator = '.';
    value = json_object_get(json->root, "dimension_separator");
    const char *separator = json_string_value(value);
    if (value && (!separator || (strcmp(separator, ".") && strcmp(separator, "/"))))
        return cvol_zarr_json_fail(json, CVOL_ERROR_FORMAT, "dimension_separator", value,
                                   "must be \".\" or \"/\"");
    if (separator)
        array->separator = *separator;
    return CVOL_OK;
}

int cvol_zarr_array_read_2(cvol_zarr_array *array, const cvol_zarr_json *json)
{
    const json_t *format = json_object_get(json->root, "zarr_format");
    const json_t *chunks = json_object_get(json->root, "chunks");
    if (json_integer_value(format) != 2)
        return cvol_zarr_json_fail(json, CVOL_ERROR_UNSUPPORTED, "zarr_format", format,
                                   "must be 2 in .zarray");
    int code = cvol_zarr_json_sizes(json, "shape", json_object_get(json->root, "shape"), 1,
                                    array->shape, &array->rank);
    if (!code)
        code = cvol_zarr_json_sizes(json, "chunks", chunks, 1, array->chunk, &array->rank);
    for (int a = 0; a < array->rank; a++)
        array->shard[a] = 1;
    if (!code)
        code = read_dtype(array, json);
    if (!code)
        code = read_compressor(array, json);
    if (!code)
        code = read_layout(array, json);
    if (!code)
        code = cvol_zarr_set_fill(array, json, json_object_get(json->root, "fill_value"));
    return code ? code : cvol_zarr_complete(array, json, "chunks", chunks);
}
