/* Arrays to files and back. */
#include <stdlib.h>
#include <string.h>

#include "base/context.h"
#include "base/file.h"
#include "codec/container.h"
#include "codec/ranges.h"
#include "cvol/codec.h"

static int write_all(cvol_context *context, const cvol_bytes *begin, const cvol_groups *groups,
                     const char *path)
{
    cvol_output *output;
    int code = cvol_output_open(context, &output, path);
    if (code)
        return code;
    code = cvol_output_write(context, output, begin->data, begin->size);
    for (size_t g = 0; g < groups->count && !code; g++)
        code = cvol_output_write(context, output, groups->bytes[g].data, groups->bytes[g].size);
    if (!code)
        return cvol_output_commit(context, output);
    cvol_output_abandon(output);
    return code;
}

int cvol_array_write(cvol_context *context, const cvol_array *array, const char *path,
                     uint64_t *file_bytes)
{
    cvol_groups groups = {0};
    cvol_bytes begin = {0};
    cvol_array *ranged = NULL; /* the same with block ranges, if it has none */
    int code = CVOL_OK;
    if (cvol_array_is_volume(array) && !array->has_ranges) {
        code = cvol_array_share(context, &ranged, array);
        if (!code)
            code = cvol_ranges_find(context, ranged);
        array = ranged;
    }
    if (!code && cvol_array_is_volume(array))
        code = cvol_array_encode(context, &groups, array);
    if (!code)
        code = cvol_container_begin(context, &begin, array, &groups);
    if (!code)
        code = write_all(context, &begin, &groups, path);
    if (!code && file_bytes)
        *file_bytes = begin.size + cvol_groups_size(&groups);
    cvol_bytes_free(&begin);
    cvol_groups_free(&groups);
    cvol_array_free(ranged);
    return code;
}

static int read_file(cvol_context *context, cvol_array **out, const char *path, const cvol_box *box,
                     uint64_t *file_bytes)
{
    *out = NULL;
    uint8_t *data;
    size_t size;
    int code = cvol_file_read(context, &data, &size, path, 0, SIZE_MAX);
    if (code)
        return code;
    code = cvol_container_read_box(context, out, data, size, box, path);
    free(data);
    if (!code && file_bytes)
        *file_bytes = size;
    return code;
}

int cvol_array_read(cvol_context *context, cvol_array **out, const char *path, uint64_t *file_bytes)
{
    return read_file(context, out, path, NULL, file_bytes);
}

int cvol_array_read_box(cvol_context *context, cvol_array **out, const char *path,
                        const size_t begin[3], const size_t end[3], uint64_t *file_bytes)
{
    cvol_box box;
    memcpy(box.begin, begin, sizeof box.begin);
    memcpy(box.end, end, sizeof box.end);
    return read_file(context, out, path, &box, file_bytes);
}

int cvol_file_is_cvol(const char *path)
{
    cvol_context *context = cvol_context_create();
    uint8_t data[CVOL_SIGNATURE_BYTES];
    size_t size;
    int is = context && !cvol_file_peek(context, data, &size, sizeof data, path) &&
             cvol_container_is(data, size);
    cvol_context_destroy(context);
    return is;
}
