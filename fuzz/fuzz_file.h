/* Fuzzed bytes as a file, for readers that take a path: one file per process, in memory. */
#ifndef CVOL_FUZZ_FILE_H
#define CVOL_FUZZ_FILE_H

#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <unistd.h>

#include "cvol/cvol.h"

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size);

/* The largest volume that a fuzzed file may state. */
#define FUZZ_LIMIT_BYTES (UINT64_C(1) << 24)

/* Writes the bytes to a file of this process and returns its name; 0 if that fails. */
static inline int fuzz_write_file(char name[64], const uint8_t *data, size_t size)
{
    snprintf(name, 64, "/dev/shm/cvol-fuzz-%ld", (long)getpid());
    FILE *file = fopen(name, "wb");
    if (!file)
        return 0;
    int written = fwrite(data, 1, size, file) == size;
    return !fclose(file) && written;
}

static inline cvol_context *fuzz_context(void)
{
    cvol_context *context = cvol_context_create();
    if (!context)
        abort();
    cvol_context_set_threads(context, 1);
    cvol_context_set_limit_bytes(context, FUZZ_LIMIT_BYTES);
    return context;
}

#endif
