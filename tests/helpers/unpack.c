/* unpack FILE OUT: writes a packed .cvol file (section PACK) with its sections one after the other;
 * copies other files. */
#include <stdio.h>
#include <stdlib.h>

#include "base/context.h"
#include "base/file.h"
#include "codec/container/section_pack.h"

/* The exit status. */
static int unpack(cvol_context *context, const char *from, const char *to)
{
    uint8_t *data;
    size_t size;
    cvol_unpacked unpacked = {.is_cut = 0};
    int code = cvol_file_read(context, &data, &size, from, 0, SIZE_MAX);
    if (code)
        return 1;
    const int is_packed = cvol_pack_detect(data, size);
    if (is_packed)
        code = cvol_unpack(context, &unpacked, data, size, from);
    if (!code)
        code = is_packed ? cvol_file_write(context, unpacked.plain.data, unpacked.plain.size, to)
                         : cvol_file_write(context, data, size, to);
    cvol_unpacked_free(&unpacked);
    free(data);
    return code != CVOL_OK;
}

int main(int count, char **arguments)
{
    cvol_context *context = cvol_context_create();
    if (!context || count != 3) {
        fprintf(stderr, "usage: unpack FILE OUT\n");
        return 2;
    }
    const int status = unpack(context, arguments[1], arguments[2]);
    if (status)
        fprintf(stderr, "unpack: %s\n", cvol_context_message(context));
    cvol_context_free(context);
    return status;
}
