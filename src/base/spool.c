/* Spools: a growing buffer and a file behind it. */
#define _GNU_SOURCE
#include "base/spool.h"

#include <errno.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "base/context.h"

enum { COPY_BYTES = 1 << 20 };

static int fail_io(cvol_context *context, const cvol_output *output, int reason)
{
    return cvol_fail(context, CVOL_ERROR_IO, "%s: %s", cvol_output_name(output), strerror(reason));
}

int cvol_spool_append(cvol_context *context, cvol_spool *spool, const void *data, size_t size)
{
    cvol_bytes_append(&spool->held, data, size);
    return spool->held.failed ? cvol_fail_memory(context, spool->held.size + size, "the file")
                              : CVOL_OK;
}

int cvol_spool_spill(cvol_context *context, cvol_spool *spool, const cvol_output *output)
{
    if (!spool->has_file) {
        int code = cvol_output_scratch(context, output, &spool->fd);
        if (code)
            return code;
        spool->has_file = 1;
    }
    for (size_t done = 0; done < spool->held.size;) {
        const size_t left = spool->held.size - done;
        const ssize_t wrote = write(spool->fd, spool->held.data + done,
                                    left < COPY_BYTES ? left : COPY_BYTES);
        if (wrote < 0 && errno == EINTR)
            continue;
        if (wrote < 0)
            return fail_io(context, output, errno);
        done += (size_t)wrote;
    }
    spool->filed += spool->held.size;
    cvol_bytes_free(&spool->held);
    return CVOL_OK;
}

static int copy_file(cvol_context *context, const cvol_spool *spool, cvol_output *output,
                     uint8_t *buffer)
{
    for (uint64_t done = 0; done < spool->filed;) {
        const uint64_t left = spool->filed - done;
        const ssize_t got = pread(spool->fd, buffer, left < COPY_BYTES ? (size_t)left : COPY_BYTES,
                                  (off_t)done);
        if (got < 0 && errno == EINTR)
            continue;
        if (got <= 0)
            return fail_io(context, output, got ? errno : EIO);
        int code = cvol_output_write(context, output, buffer, (size_t)got);
        if (code)
            return code;
        done += (uint64_t)got;
    }
    return CVOL_OK;
}

int cvol_spool_copy(cvol_context *context, const cvol_spool *spool, cvol_output *output)
{
    int code = CVOL_OK;
    if (spool->has_file) {
        uint8_t *buffer = malloc(COPY_BYTES);
        code = buffer ? copy_file(context, spool, output, buffer)
                      : cvol_fail_memory(context, COPY_BYTES, cvol_output_name(output));
        free(buffer);
    }
    if (!code)
        code = cvol_output_write(context, output, spool->held.data, spool->held.size);
    return code;
}

void cvol_spool_free(cvol_spool *spool)
{
    cvol_bytes_free(&spool->held);
    if (spool->has_file)
        close(spool->fd);
    *spool = (cvol_spool){0};
}
