/* Fuzzing of the reader of .cvol and .cvi: any bytes must give an array, a baked volume or a
 * picture that evaluates, or an error; and verifying them must agree.
 *
 * With libFuzzer:  clang -fsanitize=fuzzer,address,undefined ... fuzz/fuzz_cvol.c
 * Without:         -DCVOL_FUZZ_MAIN reads the files named on the command line.
 * tests/codec/test_container.c includes this file and feeds it mutations.
 *
 * Mutations rarely keep the checksums: fuzz_repair() corrects all of them, so that the content
 * behind them is reached as well.
 */
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include "base/bytes.h"
#include "codec/brick/brick_index.h"
#include "codec/container/baked.h"
#include "codec/container/container.h"
#include "codec/container/layout.h"
#include "codec/container/picture.h"
#include "codec/container/plane_file.h"
#include "codec/container/series.h"
#include "codec/quantize/coding.h"
#include "codec/section/signature.h"
#include "cvol/codec.h"

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size);

/* The largest volume that a fuzzed file may state. */
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

/* Offsets of the sections that hold bricks, in the order of the index's streams. */
typedef struct fuzz_streams {
    uint8_t *headers[CVOL_STREAMS]; /* NULL: none */
    uint64_t sizes[CVOL_STREAMS];
} fuzz_streams;

/* The stream of a section, or CVOL_STREAMS. */
static int fuzz_stream_of(const uint8_t *header)
{
    if (!memcmp(header, "SHL", 3) && header[3] >= '0' && header[3] < '4')
        return header[3] - '0';
    if (!memcmp(header, "MASK", 4))
        return CVOL_STREAM_MASK;
    return memcmp(header, "CORR", 4) ? CVOL_STREAMS : CVOL_STREAM_RESIDUAL;
}

/* Tests if INDX has the checksum of a run: of one brick, if it has bytes. */
static int fuzz_has_sum(const uint64_t *ends, size_t r, size_t run)
{
    return run > 1 || ends[r] > (r ? ends[r - 1] : 0);
}

/* Sets the checksums of a stream's runs, which follow the lengths in INDX, and from them that of
 * the section's header. `ends`: of the runs in the stream. */
static void fuzz_repair_stream(uint8_t *header, uint8_t *sums, size_t runs, size_t run,
                               const uint64_t *ends, uint64_t size)
{
    static const uint8_t none[4] = {0};
    const uint8_t *data = header + CVOL_SECTION_HEADER_BYTES;
    uint64_t begin = 0;
    uint32_t all = 0;
    for (size_t r = 0; r < runs; r++) {
        const int has_sum = fuzz_has_sum(ends, r, run);
        if (has_sum && ends[r] <= size)
            fuzz_put_u32(sums, cvol_crc32c(data + begin, (size_t)(ends[r] - begin)));
        all = cvol_crc32c_more(all, has_sum ? sums : none, 4);
        sums += has_sum ? 4 : 0;
        begin = ends[r];
    }
    fuzz_put_u32(header + 16, all);
}

/* Streams first .. end - 1, whose lengths, then checksums, follow in the index; 0 if they do
 * not. */
static int fuzz_repair_streams(const fuzz_streams *streams, int first, int end, uint8_t *index,
                               cvol_cursor *lengths, size_t bricks, size_t run)
{
    const size_t runs = bricks / run + (bricks % run != 0);
    const size_t count = (size_t)(end - first);
    uint64_t *ends = calloc(runs * count + 1, sizeof *ends);
    for (size_t s = 0; ends && s < count; s++) {
        uint64_t at = 0;
        for (size_t b = 0; b < bricks; b++) {
            at += cvol_cursor_varint(lengths) & UINT32_MAX;
            ends[s * runs + b / run] = at;
        }
    }
    int is_there = ends && !lengths->failed;
    for (size_t s = 0; is_there && s < count; s++) {
        size_t sums = 0;
        for (size_t r = 0; r < runs; r++)
            sums += (size_t)fuzz_has_sum(ends + s * runs, r, run);
        is_there = cvol_cursor_left(lengths) >= 4 * sums;
        if (is_there && streams->headers[first + (int)s])
            fuzz_repair_stream(streams->headers[first + (int)s], index + lengths->at, runs, run,
                               ends + s * runs, streams->sizes[first + (int)s]);
        cvol_cursor_take(lengths, is_there ? 4 * sums : 0);
    }
    free(ends);
    return is_there;
}

/* The runs of a file whose streams have `bricks` bricks; INDX is at index[0 .. size). */
static void fuzz_repair_runs(uint8_t *index, size_t size, size_t bricks, size_t run,
                             const fuzz_streams *streams)
{
    cvol_cursor lengths = cvol_cursor_make(index, size);
    int go_on = fuzz_repair_streams(streams, 0, CVOL_SUBBANDS, index, &lengths, bricks, run);
    for (int s = CVOL_SUBBANDS; s < CVOL_STREAMS && go_on && cvol_cursor_left(&lengths); s++)
        if (streams->headers[s])
            go_on = fuzz_repair_streams(streams, s, s + 1, index, &lengths, bricks, run);
}

/* The number of bricks by HEAD, with sides from BRKS, if that is less than `most`. */
static size_t fuzz_bricks(const uint8_t *head, const uint32_t shape[4], size_t most)
{
    uint64_t bricks = 1;
    for (int a = 0; a < 3; a++) {
        const uint64_t dim = fuzz_u32(head + 8 * a), more = fuzz_u32(head + 8 * a + 4);
        bricks *= dim / shape[a] + (dim % shape[a] != 0);
        if (more || bricks > most)
            return most + 1;
    }
    return (size_t)bricks;
}

/* Section PACK, of which `left` bytes exist: its checksum covers the front and the front's length.
 * Its content cannot be repaired. */
static void fuzz_repair_pack(uint8_t *header, size_t left)
{
    uint8_t *content = header + CVOL_SECTION_HEADER_BYTES;
    cvol_cursor front = cvol_cursor_make(content, left - CVOL_SECTION_HEADER_BYTES);
    const uint64_t length = cvol_cursor_varint(&front);
    if (!front.failed && length <= cvol_cursor_left(&front))
        fuzz_put_u32(header + 16, cvol_crc32c(content, front.at + (size_t)length));
    fuzz_put_u32(header + 20, cvol_crc32c(header, 20));
}

static void fuzz_repair_at(uint8_t *file, size_t size, int depth)
{
    fuzz_streams streams = {{0}, {0}};
    uint32_t shape[4] = {CVOL_BRICK_SIDE, CVOL_BRICK_SIDE, CVOL_BRICK_SIDE, CVOL_RUN_BRICKS};
    uint8_t *index = NULL, *head = NULL;
    uint64_t index_size = 0;
    /* First the checksums of contents; lengths that must agree with bricks come after, as they are
     * in INDX too; then the checksums over all of them. */
    for (int pass = 0; pass < 2; pass++) {
        for (size_t at = CVOL_SECTIONS_AT; size >= at && size - at >= CVOL_SECTION_HEADER_BYTES;) {
            uint8_t *header = file + at;
            cvol_cursor field = cvol_cursor_make(header + 8, 8);
            const uint64_t length = cvol_cursor_u64(&field);
            const int is_there = length <= size - at - CVOL_SECTION_HEADER_BYTES;
            const int stream = fuzz_stream_of(header);
            const int is_subband = stream < CVOL_SUBBANDS, is_index = !memcmp(header, "INDX", 4);
            if (!memcmp(header, "PACK", 4)) { /* nothing follows it */
                fuzz_repair_pack(header, size - at);
                break;
            }
            if (is_there && !pass && depth < 2 && !memcmp(header, "VOLM", 4))
                fuzz_repair_at(header + CVOL_SECTION_HEADER_BYTES, (size_t)length, depth + 1);
            if (is_there && !is_subband && pass == is_index)
                fuzz_put_u32(header + 16,
                             cvol_crc32c(header + CVOL_SECTION_HEADER_BYTES, (size_t)length));
            if (!is_there && !pass)
                break;
            if (pass)
                fuzz_put_u32(header + 20, cvol_crc32c(header, 20));
            if (!is_there)
                break;
            if (stream < CVOL_STREAMS) {
                streams.headers[stream] = header;
                streams.sizes[stream] = length;
            } else if (is_index) {
                index = header + CVOL_SECTION_HEADER_BYTES;
                index_size = length;
            } else if (!memcmp(header, "HEAD", 4) && length >= 24) {
                head = header + CVOL_SECTION_HEADER_BYTES;
            } else if (!memcmp(header, "BRKS", 4) && length >= 16) {
                for (size_t i = 0; i < 4; i++) {
                    const uint32_t said = fuzz_u32(header + CVOL_SECTION_HEADER_BYTES + 4 * i);
                    shape[i] = said ? said : 1;
                }
            }
            at += CVOL_SECTION_HEADER_BYTES + (size_t)length;
        }
        const size_t bricks = head ? fuzz_bricks(head, shape, (size_t)index_size) : SIZE_MAX;
        if (!pass && index && bricks <= index_size)
            fuzz_repair_runs(index, (size_t)index_size, bricks, shape[3], &streams);
    }
}

static void fuzz_repair(uint8_t *file, size_t size)
{
    fuzz_repair_at(file, size, 0);
}

/* Samples are evaluated at this many places along each axis. */
enum { FUZZ_SIDE = 40 };

static void fuzz_evaluate(cvol_context *context, const cvol_array *array, const size_t begin[3],
                          const size_t end[3])
{
    const size_t count = (end[0] - begin[0]) * (end[1] - begin[1]) * (end[2] - begin[2]);
    void *samples = malloc(count * 8);
    float *real = malloc(count * sizeof *real);
    if (samples && real) {
        (void)cvol_array_evaluate_box(context, samples, array, begin, end);
        (void)cvol_array_evaluate_real(context, real, array, begin, end);
    }
    free(samples);
    free(real);
}

/* The first of all samples. */
static void fuzz_evaluate_first(cvol_context *context, const cvol_array *array)
{
    const size_t *dims = cvol_array_grid(array)->dims, begin[3] = {0, 0, 0};
    size_t end[3];
    for (int a = 0; a < 3; a++)
        end[a] = dims[a] < FUZZ_SIDE ? dims[a] : FUZZ_SIDE;
    fuzz_evaluate(context, array, begin, end);
}

/* A single box, of a file that may be damaged elsewhere: the first sample, and some in the
 * middle. */
static void fuzz_read_boxes(cvol_context *context, const uint8_t *data, size_t size)
{
    const size_t zero[3] = {0, 0, 0}, one[3] = {1, 1, 1};
    const cvol_file_part corner = {.size = sizeof(cvol_file_part), .begin = zero, .end = one};
    size_t begin[3], end[3];
    cvol_array *array;
    if (cvol_container_read_part(context, &array, NULL, data, size, &corner, "fuzz"))
        return;
    fuzz_evaluate(context, array, zero, one);
    for (int a = 0; a < 3; a++) {
        const size_t dim = cvol_array_grid(array)->dims[a],
                     length = 1 + data[size - 1 - (size_t)a] % 20;
        begin[a] = dim / 2 < FUZZ_SIDE ? dim / 2 : dim - dim / 4 - 1;
        end[a] = dim - begin[a] < length ? dim : begin[a] + length;
    }
    cvol_array_free(array);
    const cvol_file_part midst = {
        .size = sizeof(cvol_file_part), .begin = begin, .end = end, .level = data[size / 2] % 4};
    if (!cvol_container_read_part(context, &array, NULL, data, size, &midst, "fuzz"))
        fuzz_evaluate(context, array, begin, end);
    cvol_array_free(array);
}

/* Reads a file that may end early, also at coarse levels. */
static void fuzz_read_levels(cvol_context *context, const uint8_t *data, size_t size)
{
    for (int level = 0; level < 4; level++) {
        const cvol_file_part part = {.size = sizeof(cvol_file_part), .level = level, .cut = !level};
        cvol_file_report report = {0};
        cvol_array *array;
        if (!cvol_container_read_part(context, &array, &report, data, size, &part, "fuzz")) {
            if (report.level < 0 || report.level > 3)
                abort();
            fuzz_evaluate_first(context, array);
        }
        cvol_array_free(array);
    }
}

/* Pixels of a picture, if they are few. */
static void fuzz_draw(cvol_context *context, const cvol_picture *picture)
{
    cvol_image *image;
    const double pixels = (double)picture->width * picture->height;
    const double places = (double)picture->lattice[0] * (double)picture->lattice[1];
    if (pixels > 1e4 || places > 1e5)
        return;
    (void)cvol_picture_evaluate(context, &image, picture);
    cvol_image_free(image);
}

static void fuzz_read_picture(cvol_context *context, const uint8_t *data, size_t size)
{
    cvol_file_layout layout;
    cvol_picture *picture;
    const int damaged = cvol_layout_verify(context, &layout, data, size, "fuzz");
    const int refused = cvol_picture_take(context, &picture, data, size, "fuzz");
    if (!damaged != !refused)
        abort();
    if (!refused)
        fuzz_draw(context, picture);
    cvol_picture_free(picture);
}

static void fuzz_read_baked(cvol_context *context, const uint8_t *data, size_t size)
{
    cvol_file_layout layout;
    cvol_baked_file baked;
    const int damaged = cvol_layout_verify(context, &layout, data, size, "fuzz");
    const int refused = cvol_baked_file_take(context, &baked, data, size, "fuzz");
    if (!damaged != !refused)
        abort();
    if (!refused)
        cvol_baked_file_free(&baked);
}

static void fuzz_read_array(cvol_context *context, const uint8_t *data, size_t size)
{
    cvol_array *array;
    cvol_file_layout layout;
    const int damaged = cvol_layout_verify(context, &layout, data, size, "fuzz");
    const int refused = cvol_container_read(context, &array, data, size, "fuzz");
    if (!damaged != !refused)
        abort(); /* verified files can be read, and no others */
    if (!refused)
        fuzz_evaluate_first(context, array);
    cvol_array_free(array);
    fuzz_read_boxes(context, data, size);
    fuzz_read_levels(context, data, size);
}

/* Each volume of a complete series can be read. */
static void fuzz_read_series(cvol_context *context, const uint8_t *data, size_t size)
{
    cvol_file_layout layout;
    cvol_series *series;
    const int damaged = cvol_layout_verify(context, &layout, data, size, "fuzz");
    if (!cvol_series_take(context, &series, data, size, "fuzz"))
        for (int i = 0; i < 8; i++) {
            const cvol_file_part part = {.size = sizeof(cvol_file_part),
                                         .time = i / cvol_series_channels(series),
                                         .channel = i % cvol_series_channels(series),
                                         .cut = damaged != 0};
            cvol_array *array;
            const int refused = cvol_container_read_part(context, &array, NULL, data, size, &part,
                                                         "fuzz");
            if (refused && !damaged && part.time < cvol_series_times(series))
                abort();
            if (!refused)
                fuzz_evaluate_first(context, array);
            cvol_array_free(array);
        }
    else if (!damaged)
        abort();
    cvol_series_free(series);
}

static void fuzz_read(const uint8_t *data, size_t size)
{
    cvol_context *context = cvol_context_create();
    if (!context)
        return;
    cvol_context_set_threads(context, 1);
    cvol_context_set_limit_bytes(context, FUZZ_LIMIT_BYTES);
    const cvol_file_kind kind = cvol_plane_file_kind(data, size);
    if (kind == CVOL_FILE_PICTURE)
        fuzz_read_picture(context, data, size);
    else if (kind == CVOL_FILE_BAKED)
        fuzz_read_baked(context, data, size);
    else if (kind == CVOL_FILE_SERIES)
        fuzz_read_series(context, data, size);
    else
        fuzz_read_array(context, data, size);
    cvol_context_free(context);
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
        cvol_context_free(context);
    }
    return 0;
}
#endif
