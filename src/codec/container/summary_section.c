/* Section SUMM: a few bytes of flags and values, then the levels of all bins by the adaptive range
 * coder.
 *
 * A level is 0 or not; the context is the number of zeros among the previous two levels. If it is
 * not 0, the coder codes its difference from the previous nonzero level: 0 or not, its sign, its
 * magnitude in unary; the contexts are the sizes of recent differences. doc/format.md has the
 * details. */
#include "codec/container/summary_section.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "array/core/summary.h"
#include "base/context.h"
#include "codec/entropy/range_coder.h"

enum {
    FLAG_INTEGERS = 1,
    FLAG_RANGE = 2, /* min and max follow; else they equal value_min and value_max */
    FLAG_MARK = 4,
    FLAGS = 7,
    BINS_SHIFT = 4,
    CLASSES = 3, /* of sizes of recent differences */
    UNARY = 12   /* contexts of the steps of a magnitude */
};

typedef struct contexts {
    cvol_probability empty[3], change[CLASSES], sign[2], more[CLASSES][UNARY];
} contexts;

/* Codes levels; encoder and decoder share it. */
typedef struct level_coder {
    cvol_range_encoder *encoder; /* one of the two is NULL */
    cvol_range_decoder *decoder;
    contexts contexts;
    int empties;  /* one bit for each of the last two levels, set if it is 0: bit 0 is the last */
    int last;     /* the last nonzero level */
    int lately;   /* 8 times the mean magnitude of differences */
    int was_down; /* the sign of the last nonzero difference */
} level_coder;

static void start(level_coder *coder)
{
    cvol_probability *all = (cvol_probability *)&coder->contexts;
    for (size_t i = 0; i < sizeof coder->contexts / sizeof *all; i++)
        all[i] = (cvol_probability){32768, 32768};
    coder->lately = 16;
}

static int code_bit(level_coder *coder, cvol_probability *p, int bit)
{
    if (coder->decoder)
        return cvol_decode_bit(coder->decoder, p);
    cvol_encode_bit(coder->encoder, p, bit);
    return bit;
}

/* Codes the difference from the last nonzero level, or decodes and returns it. */
static int code_difference(level_coder *coder, int difference)
{
    contexts *c = &coder->contexts;
    const int size = coder->lately < 8 ? 0 : coder->lately < 24 ? 1 : 2;
    const int magnitude = abs(difference);
    int found = code_bit(coder, &c->change[size], magnitude > 0);
    if (found) {
        const int down = code_bit(coder, &c->sign[coder->was_down], difference < 0);
        while (found < CVOL_SUMMARY_LEVEL_MAX &&
               code_bit(coder, &c->more[size][found < UNARY ? found - 1 : UNARY - 1],
                        magnitude > found))
            found++;
        coder->lately += (8 * found - coder->lately) / 4;
        coder->was_down = down;
        return down ? -found : found;
    }
    coder->lately -= coder->lately / 4;
    return 0;
}

/* Codes a level, or decodes and returns it; -1: no level. */
static int code_level(level_coder *coder, int level)
{
    const int empties = (coder->empties & 1) + (coder->empties >> 1);
    const int is_empty = code_bit(coder, &coder->contexts.empty[empties], level == 0);
    coder->empties = (coder->empties << 1 | is_empty) & 3;
    if (is_empty)
        return 0;
    level = coder->last + code_difference(coder, level - coder->last);
    coder->last = level;
    return level < 1 || level > CVOL_SUMMARY_LEVEL_MAX ? -1 : level;
}

void cvol_summary_put(cvol_bytes *out, const cvol_header *header)
{
    const cvol_summary *s = &header->summary;
    const int own_range = s->min != header->error_bound.value_min ||
                          s->max != header->error_bound.value_max;
    cvol_range_encoder encoder = {0};
    level_coder coder = {.encoder = &encoder};
    cvol_bytes_put_u8(out,
                      (uint8_t)((s->integers ? FLAG_INTEGERS : 0) | (own_range ? FLAG_RANGE : 0) |
                                (s->mark_count ? FLAG_MARK : 0) |
                                (s->bins_log2 - CVOL_SUMMARY_BINS_MIN_LOG2) << BINS_SHIFT));
    cvol_bytes_put_varint(out, s->distinct);
    if (own_range) {
        cvol_bytes_put_f64(out, s->min);
        cvol_bytes_put_f64(out, s->max);
    }
    if (s->mark_count) {
        cvol_bytes_put_f64(out, s->mark);
        cvol_bytes_put_varint(out, s->mark_count);
    }
    cvol_range_encoder_start(&encoder);
    start(&coder);
    for (int i = 0; i < 1 << s->bins_log2; i++)
        code_level(&coder, s->levels[i]);
    if (!cvol_range_encoder_finish(&encoder, out))
        out->failed = 1;
    cvol_range_encoder_free(&encoder);
}

static int bad(cvol_context *context, const char *name, const char *what)
{
    return cvol_fail(context, CVOL_ERROR_CORRUPT, "%s: section SUMM %s", name, what);
}

/* Reads the fields before the levels. */
static int take_start(cvol_context *context, cvol_header *header, cvol_cursor *content,
                      const char *name)
{
    cvol_summary *s = &header->summary;
    const unsigned flags = cvol_cursor_u8(content);
    const uint64_t distinct = cvol_cursor_varint(content);
    s->integers = (flags & FLAG_INTEGERS) != 0;
    s->bins_log2 = CVOL_SUMMARY_BINS_MIN_LOG2 + (int)(flags >> BINS_SHIFT);
    s->min = flags & FLAG_RANGE ? cvol_cursor_f64(content) : header->error_bound.value_min;
    s->max = flags & FLAG_RANGE ? cvol_cursor_f64(content) : header->error_bound.value_max;
    s->mark = flags & FLAG_MARK ? cvol_cursor_f64(content) : 0;
    s->mark_count = flags & FLAG_MARK ? cvol_cursor_varint(content) : 0;
    if (content->failed)
        return bad(context, name, "ends within its fields");
    if ((flags & 15) > FLAGS || s->bins_log2 > CVOL_SUMMARY_BINS_MAX_LOG2)
        return bad(context, name, "has unknown flags, or more than 256 bins");
    if (distinct > CVOL_SUMMARY_DISTINCT)
        return bad(context, name, "states more than 256 distinct values");
    s->distinct = (uint32_t)distinct;
    if (!isfinite(s->min) || !isfinite(s->max) || !(s->min <= s->max))
        return bad(context, name, "has an invalid range");
    if ((flags & FLAG_MARK) &&
        (!isfinite(s->mark) || !s->mark_count || s->mark_count > cvol_grid_samples(&header->grid)))
        return bad(context, name, "has an invalid mark");
    return CVOL_OK;
}

int cvol_summary_take(cvol_context *context, cvol_header *header, cvol_cursor *content,
                      const char *name)
{
    cvol_summary *s = &header->summary;
    if (!cvol_header_is_volume(header)) /* such arrays are never drawn */
        return CVOL_OK;
    int code = take_start(context, header, content, name);
    if (code)
        return code;
    const size_t size = cvol_cursor_left(content);
    cvol_range_decoder decoder;
    level_coder coder = {.decoder = &decoder};
    cvol_range_decoder_start(&decoder, cvol_cursor_take(content, size), size);
    start(&coder);
    for (int i = 0; i < 1 << s->bins_log2; i++) {
        const int level = code_level(&coder, 0);
        if (level < 0)
            return bad(context, name, "has an invalid count");
        s->levels[i] = (uint8_t)level;
    }
    if (cvol_range_decoder_overrun(&decoder))
        return bad(context, name, "ends within its counts");
    s->state = CVOL_SUMMARY_KNOWN;
    return CVOL_OK;
}

uint64_t cvol_summary_section_bytes(const cvol_summary *summary,
                                    const cvol_error_bound *error_bound)
{
    const cvol_header header = {.summary = *summary, .error_bound = *error_bound};
    cvol_bytes bytes = {0};
    if (summary->state != CVOL_SUMMARY_KNOWN)
        return 0;
    cvol_summary_put(&bytes, &header);
    const uint64_t size = bytes.failed ? UINT64_MAX : bytes.size + CVOL_SECTION_HEADER_BYTES;
    cvol_bytes_free(&bytes);
    return size;
}
