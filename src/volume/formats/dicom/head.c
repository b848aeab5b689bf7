/* The header of a DICOM file (PS3.5: data sets; PS3.10: files): elements of tag, representation,
 * length and value, in the transfer syntaxes that are not deflated. The reader skips sequences, of
 * defined and undefined length, and reads those of enhanced multi-frame files (functional groups).
 * It trusts no length and limits the depth of nesting. */
#define _GNU_SOURCE
#include "volume/formats/dicom/head.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/context.h"
#include "volume/io/input.h"
#include "volume/io/text.h"

#define WINDOW_BYTES 65536
#define DEPTH_MAX 16
#define VALUE_MAX 1024 /* bytes of a value that is read */
#define UNDEFINED UINT32_MAX
#define TAG(group, element) ((uint32_t)(group) << 16 | (element))

typedef struct element {
    uint32_t tag, length;
    char representation[3];
    uint64_t at; /* of its value */
} element;

typedef struct walk {
    cvol_context *context;
    cvol_input input;
    cvol_dicom_head *head;
    uint8_t *window; /* the file's bytes from window_at on */
    uint64_t window_at;
    size_t window_size;
    int implicit, big_endian;
    int done;            /* the pixels were reached */
    uint64_t group_item; /* in a frame's functional groups: the frame's number; in shared ones
                            ALL_FRAMES */
    size_t elements;
} walk;

#define ALL_FRAMES UINT64_MAX
/* More elements than any file has. */
#define ELEMENTS_MAX ((size_t)1 << 22)

/* ---- bytes --------------------------------------------------------------------------- */

/* Reads `size` bytes (VALUE_MAX at most) at an offset; NULL, after a message, if they do not
 * exist. */
static const uint8_t *bytes_at(walk *w, uint64_t at, size_t size, int *code)
{
    if (at < w->window_at || at - w->window_at > w->window_size ||
        w->window_size - (at - w->window_at) < size) {
        *code = cvol_input_read(w->context, &w->input, at, w->window, WINDOW_BYTES,
                                &w->window_size);
        w->window_at = at;
        if (*code)
            return NULL;
        if (w->window_size < size) {
            *code = cvol_fail(w->context, CVOL_ERROR_FORMAT,
                              "%s: its header is cut off at byte %llu", w->input.path,
                              (unsigned long long)w->input.size);
            return NULL;
        }
    }
    return w->window + (at - w->window_at);
}

static uint32_t get_16(const walk *w, const uint8_t *p)
{
    return w->big_endian ? (uint32_t)p[0] << 8 | p[1] : (uint32_t)p[1] << 8 | p[0];
}

static uint32_t get_32(const walk *w, const uint8_t *p)
{
    return w->big_endian ? get_16(w, p) << 16 | get_16(w, p + 2)
                         : get_16(w, p + 2) << 16 | get_16(w, p);
}

static int has_long_length(const char *representation)
{
    static const char *const names[] = {"OB", "OW", "OF", "OD", "OL", "OV", "SQ",
                                        "UN", "UC", "UR", "UT", "SV", "UV"};
    for (size_t i = 0; i < sizeof names / sizeof *names; i++)
        if (!strcmp(representation, names[i]))
            return 1;
    return 0;
}

/* Reads the element at *at, and moves *at to its value. */
static int read_element(walk *w, uint64_t *at, element *e)
{
    int code = CVOL_OK;
    const uint8_t *p = bytes_at(w, *at, 8, &code);
    if (!p)
        return code;
    if (++w->elements > ELEMENTS_MAX)
        return cvol_fail(w->context, CVOL_ERROR_FORMAT, "%s: has more than %zu elements",
                         w->input.path, ELEMENTS_MAX);
    *e = (element){.tag = TAG(get_16(w, p), get_16(w, p + 2))};
    /* Items and their ends have no representation in any syntax. */
    if (w->implicit || e->tag >> 16 == 0xfffe) {
        e->length = get_32(w, p + 4);
        *at += 8;
    } else {
        memcpy(e->representation, p + 4, 2);
        if (p[4] < 'A' || p[4] > 'Z' || p[5] < 'A' || p[5] > 'Z')
            return cvol_fail(w->context, CVOL_ERROR_FORMAT,
                             "%s: element (%04x,%04x) at byte %llu has no value representation",
                             w->input.path, e->tag >> 16, e->tag & 0xffff, (unsigned long long)*at);
        e->length = get_16(w, p + 6);
        *at += 8;
        if (has_long_length(e->representation)) {
            p = bytes_at(w, *at, 4, &code);
            if (!p)
                return code;
            e->length = get_32(w, p);
            *at += 4;
        }
    }
    e->at = *at;
    return CVOL_OK;
}

/* ---- values -------------------------------------------------------------------------- */

/* A value as text: printable, without blanks at its ends. */
static int read_text(walk *w, const element *e, char *out, size_t room)
{
    int code = CVOL_OK;
    size_t size = e->length < VALUE_MAX ? e->length : VALUE_MAX;
    const uint8_t *p = bytes_at(w, e->at, size, &code);
    if (!p)
        return code;
    while (size && (p[0] == ' ' || p[0] == 0)) {
        p++;
        size--;
    }
    while (size && (p[size - 1] == ' ' || p[size - 1] == 0))
        size--;
    if (size > room - 1)
        size = room - 1;
    for (size_t i = 0; i < size; i++)
        out[i] = p[i] >= ' ' && p[i] <= '~' ? (char)p[i] : '?';
    out[size] = '\0';
    return CVOL_OK;
}

/* Reads up to `count` numbers between backslashes; *got is their number. Exponents may be padded
 * with zeros. */
static int read_numbers(walk *w, const element *e, double *out, size_t count, size_t *got)
{
    char text[VALUE_MAX + 1];
    int code = read_text(w, e, text, sizeof text);
    *got = 0;
    for (char *at = text; !code && *at && *got < count;) {
        size_t length = strcspn(at, "\\");
        const char *word = at;
        size_t word_length = 0;
        char saved = at[length];
        at[length] = '\0';
        word = cvol_text_word(&word, &word_length);
        double value;
        if (!word || !cvol_text_number(word, word_length, &value))
            return cvol_fail(w->context, CVOL_ERROR_FORMAT,
                             "%s: element (%04x,%04x) is '%.80s', not numbers", w->input.path,
                             e->tag >> 16, e->tag & 0xffff, at);
        out[(*got)++] = value;
        at += length + (saved != '\0');
    }
    return code;
}

static int read_number(walk *w, const element *e, double *out)
{
    size_t got;
    double value;
    int code = read_numbers(w, e, &value, 1, &got);
    if (!code && got)
        *out = value;
    return code;
}

static int read_short(walk *w, const element *e, uint32_t *out)
{
    int code = CVOL_OK;
    const uint8_t *p = e->length >= 2 ? bytes_at(w, e->at, 2, &code) : NULL;
    if (p)
        *out = get_16(w, p);
    return code;
}

/* Reads all numbers or none. */
static int read_vector(walk *w, const element *e, double *out, size_t count, int *has)
{
    size_t got;
    double values[6];
    int code = read_numbers(w, e, values, count, &got);
    if (code || got == 0)
        return code;
    if (got < count)
        return cvol_fail(w->context, CVOL_ERROR_FORMAT,
                         "%s: element (%04x,%04x) has %zu of %zu numbers", w->input.path,
                         e->tag >> 16, e->tag & 0xffff, got, count);
    for (size_t i = 0; i < count; i++)
        if (!isfinite(values[i]))
            return cvol_fail(w->context, CVOL_ERROR_FORMAT,
                             "%s: element (%04x,%04x) has the value %g", w->input.path,
                             e->tag >> 16, e->tag & 0xffff, values[i]);
    memcpy(out, values, count * sizeof *out);
    if (has)
        *has = 1;
    return CVOL_OK;
}

/* ---- elements ------------------------------------------------------------------------- */

static int set_frames(walk *w, const element *e)
{
    double frames = 1;
    int code = read_number(w, e, &frames);
    if (code)
        return code;
    /* Every frame has at least a byte, also if it is packed. */
    if (!(frames >= 1) || frames > (double)w->input.size || frames != floor(frames))
        return cvol_fail(w->context, CVOL_ERROR_FORMAT,
                         "%s: NumberOfFrames is %g, and the file has %llu bytes", w->input.path,
                         frames, (unsigned long long)w->input.size);
    cvol_dicom_head *h = w->head;
    h->frames = (uint64_t)frames;
    if (!h->frame) /* the first frame keeps earlier values */
        return CVOL_OK;
    cvol_dicom_frame *frame = calloc((size_t)h->frames, sizeof *frame);
    if (!frame)
        return cvol_fail_memory(w->context, (size_t)h->frames * sizeof *frame, h->path);
    frame[0] = h->frame[0];
    free(h->frame);
    h->frame = frame;
    return CVOL_OK;
}

/* Elements that may be given at the root, for all frames, or for one frame. */
static int read_of_frames(walk *w, const element *e, int *known)
{
    cvol_dicom_head *h = w->head;
    double value = 0, vector[3];
    int has = 0, code = CVOL_OK;
    *known = 1;
    switch (e->tag) {
    case TAG(0x0020, 0x0032):
        code = read_vector(w, e, vector, 3, &has);
        break;
    case TAG(0x0028, 0x1052):
    case TAG(0x0028, 0x1053):
        value = e->tag == TAG(0x0028, 0x1053) ? 1 : 0;
        code = read_number(w, e, &value);
        break;
    default:
        *known = 0;
        return CVOL_OK;
    }
    if (code || (e->tag == TAG(0x0020, 0x0032) && !has))
        return code;
    uint64_t first = w->group_item == ALL_FRAMES ? 0 : w->group_item;
    uint64_t last = w->group_item == ALL_FRAMES ? h->frames : w->group_item + 1;
    if (!h->frame && !(h->frame = calloc((size_t)h->frames, sizeof *h->frame)))
        return cvol_fail_memory(w->context, (size_t)h->frames, h->path);
    for (uint64_t f = first; f < last && f < h->frames; f++) {
        cvol_dicom_frame *frame = &h->frame[f];
        if (e->tag == TAG(0x0028, 0x1053))
            frame->slope = value;
        else if (e->tag == TAG(0x0028, 0x1052))
            frame->intercept = value;
        else {
            memcpy(frame->position, vector, sizeof vector);
            frame->has_position = 1;
        }
    }
    return CVOL_OK;
}

/* Elements that may also stand in functional groups. */
static int read_common(walk *w, const element *e)
{
    cvol_dicom_head *h = w->head;
    int known;
    int code = read_of_frames(w, e, &known);
    if (code || known)
        return code;
    switch (e->tag) {
    case TAG(0x0018, 0x0050):
        return read_number(w, e, &h->thickness);
    case TAG(0x0018, 0x0088):
        return read_number(w, e, &h->between);
    case TAG(0x0020, 0x0037):
        return h->has_orientation ? CVOL_OK
                                  : read_vector(w, e, h->orientation, 6, &h->has_orientation);
    case TAG(0x0028, 0x0030):
        return read_vector(w, e, h->spacing, 2, NULL);
    default:
        return CVOL_OK;
    }
}

static int read_root(walk *w, const element *e)
{
    cvol_dicom_head *h = w->head;
    switch (e->tag) {
    case TAG(0x0008, 0x103e):
        return read_text(w, e, h->description, sizeof h->description);
    case TAG(0x0018, 0x1164): /* at the detector; replaced by that of the samples, if known */
        return h->spacing[0] > 0 ? CVOL_OK : read_vector(w, e, h->spacing, 2, NULL);
    case TAG(0x0020, 0x000e):
        return read_text(w, e, h->series_uid, sizeof h->series_uid);
    case TAG(0x0020, 0x0011):
        return read_text(w, e, h->series_number, sizeof h->series_number);
    case TAG(0x0020, 0x0012):
        return read_number(w, e, &h->time);
    case TAG(0x0020, 0x0013):
        return read_number(w, e, &h->instance);
    case TAG(0x0028, 0x0002):
        return read_short(w, e, &h->samples);
    case TAG(0x0028, 0x0006):
        return read_short(w, e, &h->planar);
    case TAG(0x0028, 0x0008):
        return set_frames(w, e);
    case TAG(0x0028, 0x0010):
        return read_short(w, e, &h->rows);
    case TAG(0x0028, 0x0011):
        return read_short(w, e, &h->columns);
    case TAG(0x0028, 0x0100):
        return read_short(w, e, &h->allocated);
    case TAG(0x0028, 0x0101):
        return read_short(w, e, &h->stored);
    case TAG(0x0028, 0x0102):
        return read_short(w, e, &h->high);
    case TAG(0x0028, 0x0103):
        return read_short(w, e, &h->is_signed);
    default:
        return read_common(w, e);
    }
}

/* ---- data sets ------------------------------------------------------------------------ */

static int walk_elements(walk *w, uint64_t *at, uint64_t end, int depth, int reads);

/* 1 if the elements of this sequence describe frames. */
static int is_functional_group(uint32_t tag)
{
    switch (tag) {
    case TAG(0x0020, 0x9113): /* plane position */
    case TAG(0x0020, 0x9116): /* plane orientation */
    case TAG(0x0028, 0x9110): /* pixel measures */
    case TAG(0x0028, 0x9145): /* pixel value transformation */
        return 1;
    default:
        return 0;
    }
}

/* Reads the items of a sequence of undefined length, or up to its end. */
static int walk_items(walk *w, const element *e, uint64_t *at, uint64_t end, int depth, int reads)
{
    const int of_frames = e->tag == TAG(0x5200, 0x9230), of_all = e->tag == TAG(0x5200, 0x9229);
    uint64_t number = 0;
    while (*at < end) {
        element item;
        int code = read_element(w, at, &item);
        if (code)
            return code;
        if (item.tag == TAG(0xfffe, 0xe0dd))
            return CVOL_OK;
        if (item.tag != TAG(0xfffe, 0xe000))
            return cvol_fail(w->context, CVOL_ERROR_FORMAT,
                             "%s: sequence (%04x,%04x) has no item at byte %llu", w->input.path,
                             e->tag >> 16, e->tag & 0xffff, (unsigned long long)*at);
        if (of_frames)
            w->group_item = number++;
        uint64_t item_end = item.length == UNDEFINED || end - *at < item.length ? end
                                                                                : *at + item.length;
        code = walk_elements(w, at, item_end, depth + 1,
                             reads && (of_frames || of_all || is_functional_group(e->tag)));
        if (of_frames)
            w->group_item = ALL_FRAMES;
        if (code)
            return code;
        if (item.length != UNDEFINED)
            *at = item_end;
    }
    return CVOL_OK;
}

/* Pixels of undefined length within a sequence: those of a compressed icon. */
static int is_packed_icon(const element *e)
{
    return e->length == UNDEFINED &&
           (e->tag == TAG(0x7fe0, 0x0010) || !strcmp(e->representation, "OB") ||
            !strcmp(e->representation, "OW"));
}

/* Skips fragments, which are items of bytes (PS3.5 A.4), up to their end. */
static int skip_fragments(walk *w, uint64_t *at, uint64_t end)
{
    while (*at < end) {
        element fragment;
        const uint64_t begin = *at;
        int code = read_element(w, at, &fragment);
        if (code)
            return code;
        if (fragment.tag == TAG(0xfffe, 0xe0dd))
            return CVOL_OK;
        if (fragment.tag != TAG(0xfffe, 0xe000) || fragment.length > end - *at)
            return cvol_fail(w->context, CVOL_ERROR_FORMAT,
                             "%s: its compressed icon is cut off or damaged at byte %llu",
                             w->input.path, (unsigned long long)begin);
        *at += fragment.length;
    }
    return CVOL_OK;
}

/* Sequences by name, or by their undefined length. */
static int is_sequence(const walk *w, const element *e)
{
    if (e->length == UNDEFINED || !strcmp(e->representation, "SQ"))
        return 1;
    return w->implicit && (e->tag == TAG(0x5200, 0x9229) || e->tag == TAG(0x5200, 0x9230) ||
                           is_functional_group(e->tag));
}

static int note_pixels(walk *w, const element *e)
{
    cvol_dicom_head *h = w->head;
    h->has_pixels = w->done = 1;
    h->is_packed = e->length == UNDEFINED;
    h->pixels_at = e->at;
    h->pixels_size = e->length;
    return CVOL_OK;
}

/* Reads elements up to `end`, or up to an item's end. reads: 0 nothing, 1 elements that frames may
 * have, 2 all. */
static int walk_elements(walk *w, uint64_t *at, uint64_t end, int depth, int reads)
{
    if (depth > DEPTH_MAX)
        return cvol_fail(w->context, CVOL_ERROR_FORMAT,
                         "%s: its sequences are nested more than %d deep", w->input.path,
                         DEPTH_MAX);
    while (*at < end && !w->done) {
        element e;
        int code = read_element(w, at, &e);
        if (code)
            return code;
        if (e.tag == TAG(0xfffe, 0xe00d))
            return CVOL_OK;
        if (e.tag == TAG(0x7fe0, 0x0010) && reads == 2)
            return note_pixels(w, &e);
        if (is_packed_icon(&e)) {
            code = skip_fragments(w, at, end);
            if (code)
                return code;
            continue;
        }
        if (is_sequence(w, &e)) {
            uint64_t stop = e.length == UNDEFINED || end - *at < e.length ? end : *at + e.length;
            const int implicit = w->implicit;
            if (!strcmp(e.representation, "UN")) /* the writer did not know the length */
                w->implicit = 1;
            code = walk_items(w, &e, at, stop, depth, reads);
            w->implicit = implicit;
            if (code)
                return code;
            if (e.length != UNDEFINED)
                *at = stop;
            continue;
        }
        if (end - *at < e.length)
            return cvol_fail(w->context, CVOL_ERROR_FORMAT,
                             "%s: element (%04x,%04x) has %u bytes, but only %llu follow",
                             w->input.path, e.tag >> 16, e.tag & 0xffff, e.length,
                             (unsigned long long)(end - *at));
        code = reads == 2 ? read_root(w, &e) : reads == 1 ? read_common(w, &e) : CVOL_OK;
        if (code)
            return code;
        *at = e.at + e.length;
    }
    return CVOL_OK;
}

/* ---- files ---------------------------------------------------------------------------- */

/* Group 2, always explicit and little-endian, and of it the transfer syntax. */
static int read_meta(walk *w, uint64_t *at)
{
    w->implicit = w->big_endian = 0;
    while (*at < w->input.size) {
        int code = CVOL_OK;
        const uint8_t *p = bytes_at(w, *at, 8, &code);
        if (!p)
            return code;
        if (get_16(w, p) != 2)
            return CVOL_OK;
        element e;
        code = read_element(w, at, &e);
        if (!code && w->input.size - *at < e.length)
            code = cvol_fail(w->context, CVOL_ERROR_FORMAT, "%s: is cut off in its file header",
                             w->input.path);
        if (!code && e.tag == TAG(0x0002, 0x0010))
            code = read_text(w, &e, w->head->transfer, sizeof w->head->transfer);
        if (code)
            return code;
        *at = e.at + e.length;
    }
    return CVOL_OK;
}

/* Data sets without a file header do not state their syntax: explicit ones have two letters in the
 * place of a length. */
static void set_syntax(walk *w, uint64_t at)
{
    const char *transfer = w->head->transfer;
    int code = CVOL_OK;
    const uint8_t *p = bytes_at(w, at, 8, &code);
    w->big_endian = !strcmp(transfer, "1.2.840.10008.1.2.2");
    w->implicit = !strcmp(transfer, "1.2.840.10008.1.2");
    if (!transfer[0] && p)
        w->implicit = !(p[4] >= 'A' && p[4] <= 'Z' && p[5] >= 'A' && p[5] <= 'Z');
    w->head->big_endian = w->big_endian;
}

int cvol_dicom_recognise(const uint8_t *head, size_t size)
{
    return size >= 132 && !memcmp(head + 128, "DICM", 4);
}

static int read_file(walk *w)
{
    int code = CVOL_OK;
    uint64_t at = 0;
    if (w->input.size >= 132) {
        const uint8_t *p = bytes_at(w, 0, 132, &code);
        if (!p)
            return code;
        at = cvol_dicom_recognise(p, 132) ? 132 : 0;
    }
    const uint8_t *p = bytes_at(w, at, 8, &code);
    if (p && at == 0 && (p[1] || (p[0] != 2 && p[0] != 8)))
        return cvol_fail(w->context, CVOL_ERROR_FORMAT,
                         "%s: is not a DICOM file: it has no DICM at byte 128", w->input.path);
    if (!code)
        code = read_meta(w, &at);
    if (!code && !strcmp(w->head->transfer, "1.2.840.10008.1.2.1.99"))
        return cvol_fail(w->context, CVOL_ERROR_UNSUPPORTED,
                         "%s: transfer syntax 1.2.840.10008.1.2.1.99 (deflated) is not supported",
                         w->input.path);
    if (code || at >= w->input.size)
        return code;
    set_syntax(w, at);
    return walk_elements(w, &at, w->input.size, 0, 2);
}

/* Frames without a description. */
static int complete_frames(cvol_context *context, cvol_dicom_head *h)
{
    if (!h->frame && !(h->frame = calloc((size_t)h->frames, sizeof *h->frame)))
        return cvol_fail_memory(context, (size_t)h->frames, h->path);
    for (uint64_t f = 0; f < h->frames; f++)
        if (!(fabs(h->frame[f].slope) > 0) || !isfinite(h->frame[f].slope))
            h->frame[f].slope = 1;
    return CVOL_OK;
}

int cvol_dicom_head_read(cvol_context *context, cvol_dicom_head *head, const char *path)
{
    *head = (cvol_dicom_head){.samples = 1, .frames = 1};
    walk w = {.context = context, .head = head, .group_item = ALL_FRAMES};
    w.input.fd = -1;
    head->path = strdup(path);
    w.window = malloc(WINDOW_BYTES);
    int code = head->path && w.window ? CVOL_OK : cvol_fail_memory(context, WINDOW_BYTES, path);
    if (!code)
        code = cvol_input_open(context, &w.input, head->path);
    if (!code)
        code = read_file(&w);
    if (!code)
        code = complete_frames(context, head);
    cvol_input_close(&w.input);
    free(w.window);
    return code;
}

void cvol_dicom_head_close(cvol_dicom_head *head)
{
    free(head->path);
    free(head->frame);
    *head = (cvol_dicom_head){.frames = 0};
}
