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
#include "codec/brick_index.h"
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

static uint32_t fuzz_u32(const uint8_t *at)
{
    return (uint32_t)at[0] | (uint32_t)at[1] << 8 | (uint32_t)at[2] << 16 | (uint32_t)at[3] << 24;
}

/* Sets the checksums of a shell's runs, which INDX has behind its lengths, and from them that of
 * the shell's header. `index`: what follows the lengths; `ends`: of the runs in the shell. */
static void fuzz_repair_shell(uint8_t *header, uint8_t *sums, size_t runs, const uint64_t *ends,
                              uint64_t size)
{
    const uint8_t *data = header + CVOL_SECTION_HEADER_BYTES;
    uint64_t begin = 0;
    for (size_t r = 0; r < runs && ends[r] <= size; r++) {
        fuzz_put_u32(sums + 4 * r, cvol_crc32c(data + begin, (size_t)(ends[r] - begin)));
        begin = ends[r];
    }
    fuzz_put_u32(header + 16, cvol_crc32c(sums, 4 * runs));
}

/* The runs of a file whose shells have `bricks` bricks; INDX is at index[0 .. size). */
static void fuzz_repair_runs(uint8_t *index, size_t size, size_t bricks,
                             uint8_t *shells[CVOL_SHELLS], const uint64_t sizes[CVOL_SHELLS])
{
    const size_t runs = (bricks + CVOL_RUN_BRICKS - 1) / CVOL_RUN_BRICKS;
    uint64_t *ends = calloc(runs * CVOL_SHELLS + 1, sizeof *ends);
    cvol_cursor lengths = cvol_cursor_make(index, size);
    for (size_t s = 0; ends && s < CVOL_SHELLS; s++) {
        uint64_t end = 0;
        for (size_t b = 0; b < bricks; b++) {
            end += cvol_cursor_varint(&lengths) & UINT32_MAX;
            ends[s * runs + b / CVOL_RUN_BRICKS] = end;
        }
    }
    if (ends && cvol_cursor_left(&lengths) == 4 * CVOL_SHELLS * runs)
        for (size_t s = 0; s < CVOL_SHELLS; s++)
            if (shells[s])
                fuzz_repair_shell(shells[s], index + lengths.at + 4 * s * runs, runs,
                                  ends + s * runs, sizes[s]);
    free(ends);
}

/* How many bricks HEAD claims, as far as that is less than `most`. */
static size_t fuzz_bricks(const uint8_t *head, size_t most)
{
    uint64_t bricks = 1;
    for (int a = 0; a < 3; a++) {
        const uint64_t dim = fuzz_u32(head + 8 * a), more = fuzz_u32(head + 8 * a + 4);
        bricks *= dim / CVOL_BRICK_SIDE + (dim % CVOL_BRICK_SIDE != 0);
        if (more || bricks > most)
            return most + 1;
    }
    return (size_t)bricks;
}

static void fuzz_repair(uint8_t *file, size_t size)
{
    uint8_t *shells[CVOL_SHELLS] = {0}, *index = NULL, *head = NULL;
    uint64_t sizes[CVOL_SHELLS] = {0}, index_size = 0;
    size_t at = CVOL_SECTIONS_AT;
    for (int pass = 0; pass < 2; pass++) { /* lengths of all; then the checksums that hold them */
        for (at = CVOL_SECTIONS_AT; size >= at && size - at >= CVOL_SECTION_HEADER_BYTES;) {
            uint8_t *header = file + at;
            cvol_cursor field = cvol_cursor_make(header + 8, 8);
            const uint64_t length = cvol_cursor_u64(&field);
            const int is_there = length <= size - at - CVOL_SECTION_HEADER_BYTES;
            const int is_shell = !memcmp(header, "SHL", 3) && header[3] >= '0' && header[3] < '4';
            if (pass && is_there && !is_shell)
                fuzz_put_u32(header + 16,
                             cvol_crc32c(header + CVOL_SECTION_HEADER_BYTES, (size_t)length));
            if (pass)
                fuzz_put_u32(header + 20, cvol_crc32c(header, 20));
            if (!is_there)
                break;
            if (is_shell) {
                shells[header[3] - '0'] = header;
                sizes[header[3] - '0'] = length;
            } else if (!memcmp(header, "INDX", 4)) {
                index = header + CVOL_SECTION_HEADER_BYTES;
                index_size = length;
            } else if (!memcmp(header, "HEAD", 4) && length >= 24) {
                head = header + CVOL_SECTION_HEADER_BYTES;
            }
            at += CVOL_SECTION_HEADER_BYTES + (size_t)length;
        }
        const size_t bricks = head ? fuzz_bricks(head, (size_t)index_size) : SIZE_MAX;
        if (!pass && index && bricks <= index_size)
            fuzz_repair_runs(index, (size_t)index_size, bricks, shells, sizes);
    }
}

/* The first sample alone, of a file that may be damaged elsewhere. */
static void fuzz_read_corner(cvol_context *context, const uint8_t *data, size_t size)
{
    const size_t begin[3] = {0, 0, 0}, end[3] = {1, 1, 1};
    const cvol_file_part corner = {.begin = begin, .end = end};
    uint8_t sample[8];
    cvol_array *array;
    if (!cvol_container_read_part(context, &array, NULL, data, size, &corner, "fuzz"))
        (void)cvol_array_evaluate_box(context, sample, array, begin, end);
    cvol_array_free(array);
}

/* Of a file that may end early, and at a coarse level. */
static void fuzz_read_levels(cvol_context *context, const uint8_t *data, size_t size)
{
    const size_t begin[3] = {0, 0, 0}, end[3] = {1, 1, 1};
    for (int level = 0; level < 4; level += 2) {
        const cvol_file_part part = {.level = level, .cut = !level};
        cvol_file_report report = {0};
        uint8_t sample[8];
        cvol_array *array;
        if (!cvol_container_read_part(context, &array, &report, data, size, &part, "fuzz")) {
            if (report.level < 0 || report.level > 3)
                abort();
            (void)cvol_array_evaluate_box(context, sample, array, begin, end);
        }
        cvol_array_free(array);
    }
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
    fuzz_read_levels(context, data, size);
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
