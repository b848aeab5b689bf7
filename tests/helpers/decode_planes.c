/* decode_planes FILE OUT.raw: decodes a compressed picture or a baked volume. Writes what
 * doc/decoder_ref.py writes: bytes R G B A of the pixels; or the planes of all slices as
 * little-endian float32, in each slice opacity, then its colours, 0 if the slice is invisible. */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/context.h"
#include "base/file.h"
#include "codec/container/baked.h"
#include "codec/container/plane_file.h"
#include "cvol/picture.h"

static int decode_picture(cvol_context *context, const char *from, const char *to)
{
    cvol_picture *picture;
    cvol_image *image = NULL;
    int code = cvol_picture_read(context, &picture, from);
    if (!code)
        code = cvol_picture_evaluate(context, &image, picture);
    if (!code)
        code = cvol_file_write(context, image->rgba,
                               4 * (size_t)image->width * (size_t)image->height, to);
    cvol_image_free(image);
    cvol_picture_free(picture);
    return code;
}

static int append_plane(cvol_context *context, cvol_bytes *out, const cvol_array *plane,
                        const size_t samples[2])
{
    const size_t zero[3] = {0, 0, 0}, end[3] = {samples[0], samples[1], 1};
    const size_t count = samples[0] * samples[1];
    float *values = calloc(count, sizeof *values);
    if (!values)
        return cvol_fail_memory(context, count * sizeof *values, "a plane");
    const int code = plane ? cvol_array_evaluate_real(context, values, plane, zero, end) : CVOL_OK;
    for (size_t i = 0; i < count; i++) {
        uint32_t bits;
        memcpy(&bits, &values[i], sizeof bits);
        cvol_bytes_put_u32(out, bits);
    }
    free(values);
    return code;
}

static int decode_baked(cvol_context *context, const char *from, const char *to)
{
    uint8_t *data;
    size_t size, samples[2];
    cvol_baked_file file = {0};
    cvol_bytes out = {0};
    int code = cvol_file_read(context, &data, &size, from, 0, SIZE_MAX);
    if (code)
        return code;
    code = cvol_baked_file_take(context, &file, data, size, from);
    if (!code)
        cvol_baked_file_samples(samples, &file);
    for (size_t k = 0; k < file.slices && !code; k++) {
        code = append_plane(context, &out, file.planes[k][CVOL_BAKED_OPACITY], samples);
        for (int c = 0; c < file.channels && !code; c++)
            code = append_plane(context, &out, file.planes[k][c], samples);
    }
    if (!code && out.failed)
        code = cvol_fail_memory(context, out.size, "the planes");
    if (!code)
        code = cvol_file_write(context, out.data, out.size, to);
    cvol_baked_file_free(&file);
    cvol_bytes_free(&out);
    free(data);
    return code;
}

int main(int count, char **arguments)
{
    cvol_context *context = cvol_context_create();
    if (!context || count != 3) {
        fputs("usage: decode_planes FILE OUT.raw\n", stderr);
        return 2;
    }
    const int code = cvol_file_kind_of(arguments[1]) == CVOL_FILE_BAKED
                         ? decode_baked(context, arguments[1], arguments[2])
                         : decode_picture(context, arguments[1], arguments[2]);
    if (code)
        fprintf(stderr, "decode_planes: %s\n", cvol_context_message(context));
    cvol_context_free(context);
    return code ? 1 : 0;
}
