/* Files that may be packed by gzip. */
#include "volume/io/packed.h"

int cvol_packed_is(const uint8_t *head, size_t size)
{
    return size >= 2 && head[0] == 0x1f && head[1] == 0x8b;
}

int cvol_packed_open(cvol_context *context, cvol_packed *file, const char *path)
{
    uint8_t head[2];
    size_t got = 0;
    *file = (cvol_packed){.input = {.fd = -1}};
    int code = cvol_input_open(context, &file->input, path);
    if (!code)
        code = cvol_input_read(context, &file->input, 0, head, sizeof head, &got);
    if (!code && cvol_packed_is(head, got))
        code = cvol_inflater_open(context, &file->inflater, &file->input, 0, file->input.size);
    return code;
}

void cvol_packed_close(cvol_packed *file)
{
    cvol_inflater_close(file->inflater);
    cvol_input_close(&file->input);
}

int cvol_packed_read(cvol_context *context, cvol_packed *file, void *out, uint64_t size,
                     uint64_t *got)
{
    const uint64_t left = file->input.size > file->at ? file->input.size - file->at : 0;
    size_t count = 0;
    int code = CVOL_OK;
    *got = 0;
    if (file->inflater) {
        code = cvol_inflater_read(context, file->inflater, out, size, got);
    } else if (!out) {
        *got = size < left ? size : left;
    } else {
        code = cvol_input_read(context, &file->input, file->at, out,
                               (size_t)(size < left ? size : left), &count);
        *got = count;
    }
    file->at += *got;
    return code;
}
