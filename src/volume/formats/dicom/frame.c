/* Frames of DICOM files. Raw frames are contiguous; packed ones are fragments (PS3.5, annex A.4):
 * one for each frame, or several, which the table before them separates. Run lengths (annex G) are
 * decoded here; JPEG, JPEG-LS and JPEG 2000 by GDCM, after a check that their own headers have the
 * frame's shape, so that no decoder writes beyond its buffer. */
#include "volume/formats/dicom/frame.h"

#include <pthread.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/byte_order.h"
#include "base/context.h"
#include "base/grid.h"
#include "base/memory.h"
#include "volume/formats/dicom/codec.h"
#include "volume/io/input.h"
#include "volume/io/module.h"

enum packing { RAW, RUNS, JPEG, JPEG_2000, OTHER };

static enum packing packing_of(const cvol_dicom_head *head)
{
    static const struct {
        const char *uid;
        enum packing packing;
    } all[] = {
        {"", RAW},
        {"1.2.840.10008.1.2", RAW},
        {"1.2.840.10008.1.2.1", RAW},
        {"1.2.840.10008.1.2.2", RAW},
        {"1.2.840.10008.1.2.5", RUNS},
        {"1.2.840.10008.1.2.4.50", JPEG},
        {"1.2.840.10008.1.2.4.51", JPEG},
        {"1.2.840.10008.1.2.4.57", JPEG},
        {"1.2.840.10008.1.2.4.70", JPEG},
        {"1.2.840.10008.1.2.4.80", JPEG},
        {"1.2.840.10008.1.2.4.81", JPEG},
        {"1.2.840.10008.1.2.4.90", JPEG_2000},
        {"1.2.840.10008.1.2.4.91", JPEG_2000},
    };
    for (size_t i = 0; i < sizeof all / sizeof *all; i++)
        if (!strcmp(head->transfer, all[i].uid))
            return all[i].packing;
    return OTHER;
}

/* Bytes of all samples of a frame; the head was checked. */
static size_t frame_bytes(const cvol_dicom_head *h)
{
    return (size_t)h->rows * h->columns * h->samples * (h->allocated / 8);
}

/* ---- GDCM ----------------------------------------------------------------------------- */

typedef int (*codec)(const cvol_dicom_packed *, void *, size_t);

#ifdef CVOL_DICOM_CODEC_LINKED

static codec find_codec(void)
{
    return cvol_dicom_codec_decode;
}

#else

static codec found_codec;

static void load_codec(void)
{
    void *symbol = cvol_module_find(CVOL_DICOM_MODULE, "cvol_dicom_codec_decode");
    memcpy(&found_codec, &symbol, sizeof symbol); /* C has no other conversion between the two */
}

static codec find_codec(void)
{
    static pthread_once_t once = PTHREAD_ONCE_INIT;
    pthread_once(&once, load_codec);
    return found_codec;
}

#endif

/* ---- checks --------------------------------------------------------------------------- */

static int check_bits(cvol_context *context, const cvol_dicom_head *h, cvol_type *type)
{
    const int is_signed = h->is_signed == 1;
    *type = h->allocated == 8    ? (is_signed ? CVOL_INT8 : CVOL_UINT8)
            : h->allocated == 16 ? (is_signed ? CVOL_INT16 : CVOL_UINT16)
                                 : (is_signed ? CVOL_INT32 : CVOL_UINT32);
    if (h->allocated != 8 && h->allocated != 16 && h->allocated != 32)
        return cvol_fail(context, CVOL_ERROR_UNSUPPORTED,
                         "%s: BitsAllocated is %u; 8, 16 and 32 are supported", h->path,
                         h->allocated);
    if (h->stored < 1 || h->stored > h->allocated || h->high >= h->allocated ||
        h->high + 1 < h->stored)
        return cvol_fail(context, CVOL_ERROR_FORMAT,
                         "%s: BitsStored is %u and HighBit %u, of %u BitsAllocated", h->path,
                         h->stored, h->high, h->allocated);
    if (h->is_signed > 1 || h->samples < 1 || h->samples > 4 || h->planar > 1)
        return cvol_fail(context, CVOL_ERROR_FORMAT,
                         "%s: PixelRepresentation is %u, SamplesPerPixel %u, "
                         "PlanarConfiguration %u",
                         h->path, h->is_signed, h->samples, h->planar);
    return CVOL_OK;
}

static int check_packing(cvol_context *context, const cvol_dicom_head *h)
{
    const enum packing packing = packing_of(h);
    if (packing == OTHER)
        return cvol_fail(context, CVOL_ERROR_UNSUPPORTED, "%s: transfer syntax %s is not supported",
                         h->path, h->transfer);
    if (h->is_packed != (packing != RAW))
        return cvol_fail(context, CVOL_ERROR_FORMAT,
                         "%s: its pixels are %s, which contradicts its transfer syntax '%s'",
                         h->path, h->is_packed ? "fragments" : "raw", h->transfer);
    if (packing != RAW && packing != RUNS && !find_codec())
        return cvol_fail(context, CVOL_ERROR_UNSUPPORTED,
                         "%s: is compressed (transfer syntax %s), and this cvol was built without "
                         "GDCM, or its " CVOL_DICOM_MODULE " is missing",
                         h->path, h->transfer);
    return CVOL_OK;
}

int cvol_dicom_frame_check(cvol_context *context, const cvol_dicom_head *head, cvol_type *type)
{
    int code = check_bits(context, head, type);
    if (!code)
        code = check_packing(context, head);
    cvol_grid grid = cvol_grid_make(head->columns, head->rows, head->samples, *type);
    if (!code)
        code = cvol_grid_check_file(context, &grid, head->path);
    if (code || head->is_packed)
        return code;
    cvol_input input;
    code = cvol_input_open(context, &input, head->path);
    cvol_input_close(&input);
    if (code)
        return code;
    const size_t bytes = frame_bytes(head);
    const uint64_t left = input.size > head->pixels_at ? input.size - head->pixels_at : 0;
    const uint64_t there = left < head->pixels_size ? left : head->pixels_size;
    if (there / bytes < head->frames)
        return cvol_fail(context, CVOL_ERROR_FORMAT,
                         "%s: holds %llu bytes of pixels; %llu frames of %u x %u need %zu each",
                         head->path, (unsigned long long)there, (unsigned long long)head->frames,
                         head->columns, head->rows, bytes);
    return CVOL_OK;
}

/* ---- fragments ------------------------------------------------------------------------ */

/* An item of the pixels' sequence; *size is UINT32_MAX at its end. */
static int next_item(cvol_context *context, const cvol_input *input, uint64_t *at, uint64_t *begin,
                     uint32_t *size)
{
    uint8_t b[8];
    size_t got;
    int code = cvol_input_read(context, input, *at, b, sizeof b, &got);
    if (code)
        return code;
    const uint32_t length = (uint32_t)b[4] | (uint32_t)b[5] << 8 | (uint32_t)b[6] << 16 |
                            (uint32_t)b[7] << 24;
    if (got == 8 && !memcmp(b, "\xfe\xff\xdd\xe0", 4)) {
        *size = UINT32_MAX;
        return CVOL_OK;
    }
    if (got < 8 || memcmp(b, "\xfe\xff\x00\xe0", 4) || length > input->size - *at - 8)
        return cvol_fail(context, CVOL_ERROR_FORMAT,
                         "%s: its compressed pixels are cut off or damaged at byte %llu",
                         input->path, (unsigned long long)*at);
    *begin = *at + 8;
    *at = *begin + length;
    *size = length;
    return CVOL_OK;
}

/* The table's offsets of a frame and of the next one, from the first fragment on; 1 if the table
 * has them. */
static int read_table(cvol_context *context, const cvol_input *input, uint64_t table, uint32_t size,
                      const cvol_dicom_head *head, uint64_t frame, uint32_t out[2])
{
    uint8_t b[8] = {0};
    size_t got, wanted = frame + 1 < head->frames ? 8 : 4;
    out[1] = UINT32_MAX;
    if (size / 4 < head->frames ||
        cvol_input_read(context, input, table + 4 * frame, b, wanted, &got) || got < wanted)
        return 0;
    for (size_t i = 0; i < wanted / 4; i++)
        out[i] = (uint32_t)b[4 * i] | (uint32_t)b[4 * i + 1] << 8 | (uint32_t)b[4 * i + 2] << 16 |
                 (uint32_t)b[4 * i + 3] << 24;
    return out[0] < out[1];
}

/* The concatenated bytes of a frame's fragments; the caller frees them. */
static int read_fragments(cvol_context *context, const cvol_input *input,
                          const cvol_dicom_head *head, uint64_t frame, uint8_t **out,
                          size_t *out_size)
{
    uint64_t at = head->pixels_at, begin = 0, first;
    uint32_t size = 0, table[2];
    uint64_t number = 0;
    int code = next_item(context, input, &at, &begin, &size);
    if (!code && size == UINT32_MAX)
        code = cvol_fail(context, CVOL_ERROR_FORMAT, "%s: has no compressed pixels", input->path);
    if (code)
        return code;
    first = at;
    const int has_table = head->frames > 1 &&
                          read_table(context, input, begin, size, head, frame, table);
    uint8_t *bytes = NULL;
    size_t total = 0;
    while (!code) {
        const uint64_t item = at - first;
        code = next_item(context, input, &at, &begin, &size);
        if (code || size == UINT32_MAX || (has_table && item >= table[1]))
            break;
        const int wanted = head->frames == 1 || (has_table ? item >= table[0] : number == frame);
        number++;
        if (!wanted || !size)
            continue;
        uint8_t *more = realloc(bytes, total + size);
        size_t got = 0;
        if (!more) {
            code = cvol_fail_memory(context, total + size, input->path);
            break;
        }
        bytes = more;
        code = cvol_input_read(context, input, begin, bytes + total, size, &got);
        total += got;
        if (!has_table && head->frames > 1)
            break;
    }
    if (!code && !total)
        code = cvol_fail(context, CVOL_ERROR_FORMAT, "%s: has no compressed pixels of frame %llu",
                         input->path, (unsigned long long)frame);
    if (code) {
        free(bytes);
        return code;
    }
    *out = bytes;
    *out_size = total;
    return CVOL_OK;
}

/* ---- run lengths ---------------------------------------------------------------------- */

static uint32_t little_32(const uint8_t *p)
{
    return (uint32_t)p[0] | (uint32_t)p[1] << 8 | (uint32_t)p[2] << 16 | (uint32_t)p[3] << 24;
}

/* Decodes one segment, `count` bytes, each `stride` behind the last one. 1 if it had as many. */
static int expand_runs(const uint8_t *in, size_t size, uint8_t *out, size_t count, size_t stride)
{
    size_t at = 0, done = 0;
    while (at < size && done < count) {
        const uint8_t n = in[at++];
        if (n == 128)
            continue;
        size_t run = n < 128 ? (size_t)n + 1 : 257 - (size_t)n;
        if (at >= size || (n < 128 && size - at < run))
            return 0;
        run = count - done < run ? count - done : run;
        for (size_t i = 0; i < run; i++)
            out[(done + i) * stride] = in[at + (n < 128 ? i : 0)];
        done += run;
        at += n < 128 ? (size_t)n + 1 : 1;
    }
    return done == count;
}

/* Segments are the bytes of samples, the most significant first. */
static int decode_runs(const cvol_dicom_head *h, const uint8_t *in, size_t size, uint8_t *out)
{
    const size_t each = h->allocated / 8, segments = h->samples * each;
    if (size < 64 || little_32(in) != segments)
        return 0;
    for (size_t s = 0; s < segments; s++) {
        const size_t begin = little_32(in + 4 + 4 * s);
        const size_t end = s + 1 < segments ? little_32(in + 8 + 4 * s) : size;
        const size_t byte = s / each * each +
                            (cvol_machine_is_big_endian() ? s % each : each - 1 - s % each);
        if (begin < 64 || begin > end || end > size ||
            !expand_runs(in + begin, end - begin, out + byte, (size_t)h->rows * h->columns,
                         segments))
            return 0;
    }
    return 1;
}

/* ---- codecs' own headers -------------------------------------------------------------- */

static uint32_t big(const uint8_t *p, size_t size)
{
    uint32_t value = 0;
    for (size_t i = 0; i < size; i++)
        value = value << 8 | p[i];
    return value;
}

/* A frame header: SOF0 .. SOF15, or that of JPEG-LS. */
static int is_frame_header(uint8_t marker)
{
    return marker == 0xf7 ||
           (marker >= 0xc0 && marker <= 0xcf && marker != 0xc4 && marker != 0xc8 && marker != 0xcc);
}

/* Accepts the segments that libjpeg reads without a warning and GDCM without a failed assertion,
 * which would end the process: an older JFIF, and invalid colours in Adobe's segment, are
 * refused. */
static int is_plain(uint8_t marker, const uint8_t *content, size_t size)
{
    if (marker == 0xe0 && size >= 6 && !memcmp(content, "JFIF", 5))
        return content[5] == 1;
    return marker != 0xee || size < 12 || memcmp(content, "Adobe", 5) || content[11] <= 1;
}

/* A JPEG stream up to its first scan: consecutive segments with one frame header among them, which
 * must agree with the file's. */
static int jpeg_fits(const cvol_dicom_head *h, const uint8_t *in, size_t size)
{
    size_t at = 2;
    int frames = 0;
    if (size < 4 || in[0] != 0xff || in[1] != 0xd8)
        return 0;
    while (size - at >= 4) {
        const uint8_t marker = in[at + 1];
        const size_t length = big(in + at + 2, 2);
        if (in[at] != 0xff)
            return 0;
        if (marker == 0xff) { /* padding */
            at++;
            continue;
        }
        if (marker == 0xda)
            return frames == 1;
        if (marker < 0xc0 || (marker >= 0xd0 && marker <= 0xd9) || length < 2 ||
            length + 2 > size - at || !is_plain(marker, in + at + 4, length - 2))
            return 0;
        if (is_frame_header(marker)) {
            frames++;
            if (length < 8 || in[at + 4] > h->allocated || big(in + at + 5, 2) != h->rows ||
                big(in + at + 7, 2) != h->columns || in[at + 9] != h->samples)
                return 0;
        }
        at += length + 2;
    }
    return 0;
}

/* The SIZ marker of a JPEG 2000 codestream: components must be as large as the image, without
 * offsets. */
static int jpeg_2000_fits(const cvol_dicom_head *h, const uint8_t *in, size_t size)
{
    if (size < 45 || memcmp(in, "\xff\x4f\xff\x51", 4) || big(in + 40, 2) != h->samples ||
        size < 42 + 3 * (size_t)h->samples)
        return 0;
    for (size_t i = 0; i < h->samples; i++) {
        const uint8_t *c = in + 42 + 3 * i;
        if ((c[0] & 0x7f) + 1u > h->allocated || c[1] != 1 || c[2] != 1)
            return 0;
    }
    return big(in + 8, 4) == h->columns && big(in + 12, 4) == h->rows && !big(in + 16, 4) &&
           !big(in + 20, 4);
}

static int decode_code(const cvol_dicom_head *h, const uint8_t *in, size_t size, uint8_t *out)
{
    const int fits = packing_of(h) == JPEG ? jpeg_fits(h, in, size) : jpeg_2000_fits(h, in, size);
    const cvol_dicom_packed packed = {
        h->transfer, in,           size,      h->rows, h->columns,
        h->samples,  h->allocated, h->stored, h->high, h->is_signed,
    };
    return fits && find_codec()(&packed, out, frame_bytes(h));
}

/* ---- samples -------------------------------------------------------------------------- */

/* Clears the bits that do not belong to samples, and moves signs to the type's sign bit. */
static uint32_t clean(const cvol_dicom_head *h, uint32_t value)
{
    value >>= h->high + 1 - h->stored;
    const uint32_t mask = h->stored < 32 ? (UINT32_C(1) << h->stored) - 1 : UINT32_MAX;
    const uint32_t sign = h->is_signed ? UINT32_C(1) << (h->stored - 1) : 0;
    value &= mask;
    return value & sign ? value | ~mask : value;
}

static void take_sample(const cvol_dicom_head *h, const uint8_t *frame, size_t sample, int planar,
                        void *out)
{
    const size_t pixels = (size_t)h->rows * h->columns, each = h->allocated / 8;
    const size_t stride = planar ? 1 : h->samples, begin = planar ? sample * pixels : sample;
    const int whole = h->stored == h->allocated;
    for (size_t i = 0; i < pixels; i++) {
        const uint8_t *from = frame + (begin + i * stride) * each;
        if (each == 1)
            ((uint8_t *)out)[i] = (uint8_t)(whole ? *from : clean(h, *from));
        else if (each == 2) {
            uint16_t v;
            memcpy(&v, from, 2);
            ((uint16_t *)out)[i] = (uint16_t)(whole ? v : clean(h, v));
        } else {
            uint32_t v;
            memcpy(&v, from, 4);
            ((uint32_t *)out)[i] = whole ? v : clean(h, v);
        }
    }
}

static int read_packed(cvol_context *context, const cvol_dicom_head *head, const cvol_input *input,
                       uint64_t frame, uint8_t *buffer)
{
    uint8_t *code = NULL;
    size_t size = 0;
    int failed = read_fragments(context, input, head, frame, &code, &size);
    if (failed)
        return failed;
    int done = packing_of(head) == RUNS ? decode_runs(head, code, size, buffer)
                                        : decode_code(head, code, size, buffer);
    free(code);
    return done ? CVOL_OK
                : cvol_fail(context, CVOL_ERROR_FORMAT,
                            "%s: frame %llu (transfer syntax %s) cannot be decoded as %u x %u "
                            "pixels of %u x %u bits",
                            head->path, (unsigned long long)frame, head->transfer, head->columns,
                            head->rows, head->samples, head->allocated);
}

static int read_raw(cvol_context *context, const cvol_dicom_head *head, const cvol_input *input,
                    uint64_t frame, uint8_t *buffer)
{
    const size_t bytes = frame_bytes(head), each = head->allocated / 8;
    size_t got;
    int code = cvol_input_read(context, input, head->pixels_at + frame * bytes, buffer, bytes,
                               &got);
    if (!code && got < bytes)
        code = cvol_fail(context, CVOL_ERROR_FORMAT, "%s: is cut off in frame %llu", head->path,
                         (unsigned long long)frame);
    if (!code && head->big_endian != cvol_machine_is_big_endian())
        cvol_swap_bytes(buffer, bytes / each, each);
    return code;
}

int cvol_dicom_frame_read(cvol_context *context, const cvol_dicom_head *head, uint64_t frame,
                          size_t sample, void *out)
{
    cvol_input input;
    uint8_t *buffer = cvol_allocate(frame_bytes(head), 1);
    if (!buffer)
        return cvol_fail_memory(context, frame_bytes(head), head->path);
    int code = cvol_input_open(context, &input, head->path);
    if (!code)
        code = head->is_packed ? read_packed(context, head, &input, frame, buffer)
                               : read_raw(context, head, &input, frame, buffer);
    cvol_input_close(&input);
    if (!code)
        take_sample(head, buffer, sample, !head->is_packed && head->planar, out);
    free(buffer);
    return code;
}
