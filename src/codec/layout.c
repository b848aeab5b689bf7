/* Sections in order: their headers, their contents' checksums, those of every group; then, to
 * verify, the reader itself. The first damage in the file's own order is the one that is told. */
#include "codec/layout.h"

#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/bytes.h"
#include "base/context.h"
#include "base/file.h"
#include "codec/container.h"
#include "codec/section.h"

enum { INDEX_ENTRY_BYTES = 12, FIRST_SECTION_AT = CVOL_SIGNATURE_BYTES + 4 };

/* What each section holds, which ones it may follow, and whether it is a file's last. */
static const struct section_kind {
    const char *tag, *after, *content;
    int last;
} kinds[] = {
    {"HEAD", "", "shape, type, geometry, method, error bounds", 0},
    {"RNGE", "HEAD", "bounds of the decoded samples, for skipping", 0},
    {"INDX", "RNGE", "length and checksum of each group of blocks", 0},
    {"DATA", "INDX", "the coefficients, coded in groups of blocks", 1},
    {"TERM", "HEAD", "the terms of all blocks", 1},
    {"SPEC", "HEAD", "the terms of the whole array", 1},
};
enum { KIND_COUNT = sizeof kinds / sizeof *kinds };

const char *cvol_section_state_name(cvol_section_state state)
{
    switch (state) {
    case CVOL_SECTION_SOUND:
        return "sound";
    case CVOL_SECTION_DAMAGED:
        return "damaged";
    case CVOL_SECTION_TRUNCATED:
        return "truncated";
    case CVOL_SECTION_UNCHECKED:
        return "not checked";
    }
    return NULL;
}

typedef struct walk {
    cvol_context *context;
    cvol_file_layout *out;
    cvol_cursor file, index; /* index: the content of INDX */
    const char *name;
    int code; /* of the first damage */
} walk;

static void tell(walk *w, const char *format, ...) __attribute__((format(printf, 2, 3)));

/* Notes damage: its sentence, unless there was one before. */
static void tell(walk *w, const char *format, ...)
{
    char what[CVOL_MESSAGE_BYTES];
    va_list args;
    if (w->code)
        return;
    va_start(args, format);
    vsnprintf(what, sizeof what, format, args);
    va_end(args);
    w->code = cvol_fail(w->context, CVOL_ERROR_CORRUPT, "%s: %s", w->name, what);
}

static size_t place(const walk *w)
{
    return w->file.size - cvol_cursor_left(&w->file);
}

/* ---- which section may come ------------------------------------------------------------- */

static const cvol_file_section *last_section(const cvol_file_layout *layout)
{
    return layout->section_count ? &layout->sections[layout->section_count - 1] : NULL;
}

static const char *last_tag(const cvol_file_layout *layout)
{
    const cvol_file_section *last = last_section(layout);
    return last ? last->tag : "";
}

static const struct section_kind *kind_of(const char *tag)
{
    for (int i = 0; i < KIND_COUNT; i++)
        if (!strcmp(kinds[i].tag, tag))
            return &kinds[i];
    return NULL;
}

/* The tags that may follow `tag`: "RNGE or TERM or SPEC". */
static void list_followers(char out[64], const char *tag)
{
    size_t used = 0;
    out[0] = '\0';
    for (int i = 0; i < KIND_COUNT; i++)
        if (!strcmp(kinds[i].after, tag))
            used += (size_t)snprintf(out + used, 64 - used, "%s%s", used ? " or " : "",
                                     kinds[i].tag);
}

static int is_complete(const cvol_file_layout *layout)
{
    const struct section_kind *kind = kind_of(last_tag(layout));
    return kind && kind->last;
}

/* ---- one section ------------------------------------------------------------------------ */

/* DATA, group by group; the section's checksum is that of the groups' own. */
static void check_groups(walk *w, cvol_file_section *section, cvol_cursor content, uint32_t stored)
{
    const size_t count = w->index.size / INDEX_ENTRY_BYTES, at = (size_t)section->offset;
    cvol_bytes checksums = {0};
    int sound = 1;
    for (size_t g = 0; g < count; g++) {
        const size_t left = cvol_cursor_left(&content);
        const size_t begin = at + CVOL_SECTION_HEADER_BYTES + content.size - left;
        const uint64_t length = cvol_cursor_u64(&w->index);
        const uint32_t checksum = cvol_cursor_u32(&w->index);
        cvol_bytes_put_u32(&checksums, checksum);
        if (length == 0 || length > left) {
            tell(w, "section DATA at byte %zu: group %zu of %zu has %llu bytes, %zu are left", at,
                 g, count, (unsigned long long)length, left);
            sound = 0;
            break;
        }
        const uint8_t *bytes = cvol_cursor_take(&content, (size_t)length);
        const uint32_t found = cvol_crc32c(bytes, (size_t)length);
        if (found != checksum) {
            tell(w,
                 "section DATA at byte %zu: group %zu of %zu, %llu bytes from byte %zu: checksum "
                 "is %08x, its bytes give %08x",
                 at, g, count, (unsigned long long)length, begin, checksum, found);
            sound = 0;
        }
    }
    const uint32_t found = cvol_crc32c(checksums.data, checksums.size);
    if (checksums.failed && !w->code)
        w->code = cvol_fail_memory(w->context, 4 * count, "the index");
    if (sound && cvol_cursor_left(&content))
        tell(w, "section DATA at byte %zu: %zu bytes belong to no group", at,
             cvol_cursor_left(&content));
    else if (sound && found != stored)
        tell(w, "section DATA at byte %zu: checksum is %08x, its groups' give %08x", at, stored,
             found);
    else if (sound)
        section->state = CVOL_SECTION_SOUND;
    cvol_bytes_free(&checksums);
}

static void check_content(walk *w, cvol_file_section *section, uint32_t stored)
{
    const size_t length = (size_t)section->length;
    const cvol_cursor content = cvol_cursor_make(cvol_cursor_take(&w->file, length), length);
    section->state = CVOL_SECTION_DAMAGED;
    if (!strcmp(section->tag, "DATA")) {
        if (w->index.data)
            check_groups(w, section, content, stored);
        else
            section->state = CVOL_SECTION_UNCHECKED; /* only a sound INDX says where groups end */
        return;
    }
    const uint32_t found = cvol_crc32c(content.data, length);
    if (found == stored)
        section->state = CVOL_SECTION_SOUND;
    else
        tell(w, "section %s at byte %llu: checksum is %08x, its content gives %08x", section->tag,
             (unsigned long long)section->offset, stored, found);
    if (found == stored && !strcmp(section->tag, "INDX"))
        w->index = content;
}

/* The section that comes next; 0: what follows it cannot be found. */
static int take_section(walk *w)
{
    const size_t at = place(w), left = cvol_cursor_left(&w->file);
    char wanted[64];
    list_followers(wanted, last_tag(w->out));
    const uint8_t *header = cvol_cursor_take(&w->file, CVOL_SECTION_HEADER_BYTES);
    if (!header) {
        tell(w, "truncated: of section %s at byte %zu %zu of %d bytes of its header are there",
             wanted, at, left, (int)CVOL_SECTION_HEADER_BYTES);
        return 0;
    }
    cvol_cursor fields = cvol_cursor_make(header + 4, CVOL_SECTION_HEADER_BYTES - 4);
    cvol_file_section *section = &w->out->sections[w->out->section_count];
    *section = (cvol_file_section){.offset = at, .state = CVOL_SECTION_DAMAGED, .content = ""};
    for (int i = 0; i < 4; i++)
        section->tag[i] = (char)(header[i] > ' ' && header[i] <= '~' ? header[i] : '?');
    const struct section_kind *kind = kind_of(section->tag);
    const int in_order = kind && !strcmp(kind->after, last_tag(w->out));
    w->out->section_count++;
    section->content = kind ? kind->content : "unknown";
    section->length = cvol_cursor_u64(&fields);
    const uint32_t checksum = cvol_cursor_u32(&fields), stored = cvol_cursor_u32(&fields);
    const uint32_t found = cvol_crc32c(header, 16);
    if (stored != found) {
        tell(w, "section %s at byte %zu: its header's checksum is %08x, its content gives %08x",
             section->tag, at, stored, found);
        return 0;
    }
    if (!in_order) {
        tell(w, "section %s at byte %zu stands where %s must be", section->tag, at, wanted);
        return 0;
    }
    if (section->length > cvol_cursor_left(&w->file)) {
        tell(w, "truncated: section %s at byte %zu has %zu of %llu bytes", section->tag, at,
             cvol_cursor_left(&w->file), (unsigned long long)section->length);
        section->state = CVOL_SECTION_TRUNCATED;
        return 0;
    }
    check_content(w, section, checksum);
    return 1;
}

/* ---- the file --------------------------------------------------------------------------- */

/* Signature and version; 0: what follows means nothing here. */
static int take_start(walk *w)
{
    static const uint8_t none = 0;
    const size_t size = w->file.size;
    const uint8_t *data = size ? w->file.data : &none;
    const size_t same = cvol_container_matches(data, size);
    if (same < CVOL_SIGNATURE_BYTES && same < size) {
        w->code = cvol_fail(w->context, CVOL_ERROR_FORMAT,
                            "%s: is not a .cvol file: byte %zu is %02x, must be %02x", w->name,
                            same, data[same], cvol_container_signature(same));
        return 0;
    }
    if (size < FIRST_SECTION_AT) {
        tell(w, "truncated: %zu of %d bytes of its signature and version are there", size,
             (int)FIRST_SECTION_AT);
        return 0;
    }
    cvol_cursor_take(&w->file, CVOL_SIGNATURE_BYTES);
    w->out->version = cvol_cursor_u32(&w->file);
    if (w->out->version == CVOL_FORMAT_VERSION)
        return 1;
    w->code = cvol_fail(w->context, CVOL_ERROR_UNSUPPORTED,
                        "%s: the version at byte %d is %u, this library reads %d", w->name,
                        (int)CVOL_SIGNATURE_BYTES, w->out->version, (int)CVOL_FORMAT_VERSION);
    return 0;
}

int cvol_layout_walk(cvol_context *context, cvol_file_layout *out, const uint8_t *data, size_t size,
                     const char *name)
{
    walk w = {.context = context, .out = out, .name = name};
    w.file = cvol_cursor_make(data, size);
    *out = (cvol_file_layout){.file_bytes = size};
    if (!take_start(&w))
        return w.code;
    while (cvol_cursor_left(&w.file) && !is_complete(out))
        if (!take_section(&w))
            return w.code;
    if (cvol_cursor_left(&w.file)) {
        tell(&w, "%zu bytes follow the end, at byte %zu", cvol_cursor_left(&w.file), place(&w));
    } else if (!is_complete(out)) {
        char wanted[64];
        list_followers(wanted, last_tag(out));
        tell(&w, "truncated: it ends at byte %zu, where section %s must be", size, wanted);
    }
    return w.code;
}

/* Adds to the reader's sentence, which names a section, where that is. */
static int add_offset(cvol_context *context, const cvol_file_layout *layout, const char *name,
                      int code)
{
    char what[CVOL_MESSAGE_BYTES];
    snprintf(what, sizeof what, "%s", cvol_context_message(context));
    const char *behind = strncmp(what, name, strlen(name)) ? what : what + strlen(name);
    for (int i = 0; i < layout->section_count; i++) {
        char section[16];
        snprintf(section, sizeof section, "section %s", layout->sections[i].tag);
        if (strstr(behind, section))
            return cvol_fail(context, code, "%s (%s is at byte %llu)", what, section,
                             (unsigned long long)layout->sections[i].offset);
    }
    return code;
}

int cvol_layout_verify(cvol_context *context, cvol_file_layout *out, const uint8_t *data,
                       size_t size, const char *name)
{
    cvol_array *array = NULL;
    int code = cvol_layout_walk(context, out, data, size, name);
    if (code)
        return code;
    code = cvol_container_read(context, &array, data, size, name);
    cvol_array_free(array);
    return code ? add_offset(context, out, name, code) : CVOL_OK;
}

typedef int look(cvol_context *context, cvol_file_layout *out, const uint8_t *data, size_t size,
                 const char *name);

static int look_at(cvol_context *context, cvol_file_layout *out, const char *path, look *what)
{
    uint8_t *data;
    size_t size;
    *out = (cvol_file_layout){0};
    int code = cvol_file_read(context, &data, &size, path, 0, SIZE_MAX);
    if (code)
        return code;
    code = what(context, out, data, size, path);
    free(data);
    return code;
}

int cvol_file_layout_read(cvol_context *context, cvol_file_layout *out, const char *path)
{
    return look_at(context, out, path, cvol_layout_walk);
}

int cvol_file_verify(cvol_context *context, cvol_file_layout *out, const char *path)
{
    cvol_file_layout unused;
    return look_at(context, out ? out : &unused, path, cvol_layout_verify);
}
