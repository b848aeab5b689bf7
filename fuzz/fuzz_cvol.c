/* Fuzzing of the .cvol reader: any bytes must give an array that evaluates, or an error; and
 * verifying them must tell which.
 *
 * With libFuzzer:  clang -fsanitize=fuzzer,address,undefined ... fuzz/fuzz_cvol.c
 * Without:         -DCVOL_FUZZ_MAIN reads the files named on the command line.
 * tests/test_container.c includes this file and feeds it mutations.
 *
 * Mutations rarely keep the checksums: fuzz_repair() sets all of them right, so that what lies
 * behind is reached as well.
 */
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include "base/bytes.h"
#include "codec/container.h"
#include "codec/layout.h"
#include "cvol/codec.h"

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size);

/* The largest volume that a fuzzed file may claim. */
#define FUZZ_LIMIT_BYTES (UINT64_C(1) << 24)

static void fuzz_put_u32(uint8_t *at, uint32_t value)
{
    for (int i = 0; i < 4; i++)
        at[i] = (uint8_t)(value >> 8 * i);
}

/* Sets the checksums of the groups: INDX has one per group of DATA, whose own is theirs. */
static void fuzz_repair_groups(uint8_t *index, size_t index_size, uint8_t *data, size_t data_size)
{
    cvol_cursor left = cvol_cursor_make(data, data_size);
    cvol_bytes checksums = {0};
    for (size_t i = 0; i + 12 <= index_size; i += 12) {
        cvol_cursor entry = cvol_cursor_make(index + i, 8);
        uint64_t size = cvol_cursor_u64(&entry);
        const uint8_t *group = size <= data_size ? cvol_cursor_take(&left, (size_t)size) : NULL;
        if (group)
            fuzz_put_u32(index + i + 8, cvol_crc32c(group, (size_t)size));
        cvol_cursor stored = cvol_cursor_make(index + i + 8, 4);
        cvol_bytes_put_u32(&checksums, cvol_cursor_u32(&stored));
    }
    fuzz_put_u32(data - 8, cvol_crc32c(checksums.data, checksums.size));
    cvol_bytes_free(&checksums);
}

static void fuzz_repair(uint8_t *file, size_t size)
{
    uint8_t *sections[4] = {0};
    size_t sizes[4] = {0}, at = 12;
    for (int i = 0; i < 4 && at + 20 <= size; i++) {
        cvol_cursor header = cvol_cursor_make(file + at + 4, 8);
        uint64_t length = cvol_cursor_u64(&header);
        if (length > size - at - 20)
            break;
        sections[i] = file + at + 20;
        sizes[i] = (size_t)length;
        at += 20 + (size_t)length;
    }
    if (sections[3])
        fuzz_repair_groups(sections[2], sizes[2], sections[3], sizes[3]);
    for (int i = 0; i < 4 && sections[i]; i++) {
        if (i < 3)
            fuzz_put_u32(sections[i] - 8, cvol_crc32c(sections[i], sizes[i]));
        fuzz_put_u32(sections[i] - 4, cvol_crc32c(sections[i] - 20, 16));
    }
}

/* The first sample alone, of a file that may be damaged elsewhere. */
static void fuzz_read_corner(cvol_context *context, const uint8_t *data, size_t size)
{
    const cvol_box corner = {{0, 0, 0}, {1, 1, 1}};
    uint8_t sample[8];
    cvol_array *array;
    if (!cvol_container_read_box(context, &array, data, size, &corner, "fuzz"))
        (void)cvol_array_evaluate_box(context, sample, array, corner.begin, corner.end);
    cvol_array_free(array);
}

static void fuzz_read(const uint8_t *data, size_t size)
{
    cvol_context *context = cvol_context_create();
    cvol_array *array;
    if (!context)
        return;
    cvol_context_set_threads(context, 1);
    cvol_context_set_limit_bytes(context, FUZZ_LIMIT_BYTES);
    cvol_file_layout layout;
    const int damaged = cvol_layout_verify(context, &layout, data, size, "fuzz");
    const int refused = cvol_container_read(context, &array, data, size, "fuzz");
    if (!damaged != !refused)
        abort(); /* what is verified can be read, and nothing else */
    if (!refused) {
        const cvol_grid *grid = cvol_array_grid(array);
        const size_t begin[3] = {0, 0, 0};
        size_t end[3];
        for (int a = 0; a < 3; a++)
            end[a] = grid->dims[a] < 40 ? grid->dims[a] : 40;
        void *samples = malloc(end[0] * end[1] * end[2] * 8);
        if (samples)
            (void)cvol_array_evaluate_box(context, samples, array, begin, end);
        free(samples);
        cvol_array_free(array);
    }
    fuzz_read_corner(context, data, size);
    cvol_context_destroy(context);
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    uint8_t *repaired = malloc(size ? size : 1);
    if (!repaired)
        return 0;
    fuzz_read(data, size);
    memcpy(repaired, data, size);
    fuzz_repair(repaired, size);
    fuzz_read(repaired, size);
    free(repaired);
    return 0;
}

#ifdef CVOL_FUZZ_MAIN
#include "base/context.h"
#include "base/file.h"

int main(int count, char **names)
{
    for (int i = 1; i < count; i++) {
        cvol_context *context = cvol_context_create();
        uint8_t *data;
        size_t size;
        if (context && !cvol_file_read(context, &data, &size, names[i], 0, SIZE_MAX)) {
            LLVMFuzzerTestOneInput(data, size);
            free(data);
        }
        cvol_context_destroy(context);
    }
    return 0;
}
#endif
