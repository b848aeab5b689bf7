/* Walks the sections in order: headers, checksums of contents and of every run of bricks; to
 * verify, then runs the reader itself. It reports the first damage in file order. */
#include "codec/container/layout.h"

#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/context.h"
#include "base/file.h"
#include "codec/brick/brick_index.h"
#include "codec/container/baked.h"
#include "codec/container/container.h"
#include "codec/container/header.h"
#include "codec/container/picture.h"
#include "codec/container/plane_file.h"
#include "codec/container/section_pack.h"
#include "codec/container/series.h"
#include "codec/section/section.h"
#include "codec/section/signature.h"

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
    cvol_section_walk sections;
    const char *name;
    int code;                         /* of the first damage */
    char message[CVOL_MESSAGE_BYTES]; /* of that damage */
    int has_header, has_index;
    cvol_header header;
    cvol_brick_index index;
    cvol_series *series; /* or NULL */
    size_t volumes;      /* number of sections VOLM so far */
} walk;

/* Keeps the first failure, whose message is the context's last. */
static void note(walk *w, int code)
{
    if (!code || w->code)
        return;
    w->code = code;
    snprintf(w->message, sizeof w->message, "%s", cvol_context_message(w->context));
}

/* ---- one section ------------------------------------------------------------------------ */

/* The stream of bricks that a section holds; -1: none. */
static int stream_of(cvol_section_kind kind)
{
    return kind >= CVOL_SHL0 && kind <= CVOL_SHL3 ? (int)kind - CVOL_SHL0
           : kind == CVOL_MASK                    ? CVOL_STREAM_MASK
           : kind == CVOL_CORR                    ? CVOL_STREAM_RESIDUAL
                                                  : -1;
}

static int check_run(const walk *w, const cvol_section *section, size_t r)
{
    const int subband = stream_of(section->kind);
    const cvol_span run = cvol_brick_index_run(&w->index, subband, r, section->content);
    const uint32_t stored = w->index.checksums[(size_t)subband * w->index.runs + r];
    const uint32_t found = cvol_crc32c(run.data, run.size);
    if (stored == found)
        return CVOL_OK;
    const unsigned long long begin = section->content_offset +
                                     (uint64_t)(run.data - section->content);
    return cvol_fail(w->context, CVOL_ERROR_CORRUPT,
                     "%s: section %s at byte %llu: run %zu of %zu, %zu bytes from byte %llu: "
                     "checksum is %08x, its bytes give %08x",
                     w->name, section->tag, (unsigned long long)section->offset, r, w->index.runs,
                     run.size, begin, stored, found);
}

/* Checks a subband run by run; the section's checksum is computed over the runs' checksums. The
 * processes of a team check different runs. */
static cvol_section_state check_subband(walk *w, const cvol_section *section)
{
    cvol_team *team = w->context->team;
    const int subband = stream_of(section->kind);
    int code = cvol_brick_index_check(w->context, &w->index, subband, section, w->name);
    cvol_section_state state = code ? CVOL_SECTION_DAMAGED : CVOL_SECTION_SOUND;
    size_t run = 0;
    note(w, code);
    if (cvol_brick_index_size(&w->index, subband) > section->length)
        return state;
    for (code = CVOL_OK; run < w->index.runs && !code; run += !code)
        if (cvol_team_does(team, run))
            code = check_run(w, section, run);
    code = cvol_team_first_failure(w->context, team, code, run);
    note(w, code);
    return code ? CVOL_SECTION_DAMAGED : state;
}

/* Keeps content that later checks need. The reader itself reports wrong values in it. */
static void keep_content(walk *w, const cvol_section *section)
{
    cvol_cursor content = cvol_section_cursor(section);
    int code = CVOL_OK;
    if (section->kind == CVOL_HEAD)
        w->has_header = !(code = cvol_head_take(w->context, &w->header, &content, w->name));
    if (section->kind == CVOL_LIST)
        code = cvol_series_take_list(w->context, &w->series, &content, w->name);
    if (section->kind == CVOL_MODE && w->has_header)
        w->has_header = !(code = cvol_modes_take(w->context, &w->header, &content, w->name));
    if (section->kind == CVOL_BRKS && w->has_header)
        w->has_header = !(code = cvol_bricks_take(w->context, &w->header, &content, w->name));
    if (section->kind == CVOL_TRUE && w->has_header)
        w->has_header = !(
            code = cvol_true_length_section_take(w->context, &w->header, &content, w->name));
    if (section->kind == CVOL_SMAL && w->has_header)
        w->has_header = !(code = cvol_neural_take(w->context, &w->header, &content, w->name));
    if (section->kind == CVOL_INDX && w->has_header && cvol_header_is_volume(&w->header))
        w->has_index = !(code = cvol_brick_index_take_streams(
                             w->context, &w->index, section, cvol_header_bricks(&w->header),
                             w->header.brick.run, cvol_header_streams(&w->header), w->name));
    if (code == CVOL_ERROR_MEMORY)
        note(w, code);
}

/* Checks one volume of many; its own sections report the damage. */
static cvol_section_state check_volume(walk *w, const cvol_section *section)
{
    const size_t number = w->volumes++;
    const int code = cvol_section_check(w->context, section, w->name);
    if (!code)
        return CVOL_SECTION_SOUND;
    const int channels = w->series ? cvol_series_channels(w->series) : 1;
    cvol_file_layout *inside = malloc(sizeof *inside);
    if (!inside)
        note(w, cvol_fail_memory(w->context, sizeof *inside, w->name));
    char name[512];
    snprintf(name, sizeof name, "%.400s, time %zu, channel %zu (from byte %llu)", w->name,
             number / (size_t)channels, number % (size_t)channels,
             (unsigned long long)section->content_offset);
    if (inside &&
        cvol_plane_file_kind(section->content, (size_t)section->length) == CVOL_FILE_ARRAY)
        note(w,
             cvol_layout_walk(w->context, inside, section->content, (size_t)section->length, name));
    free(inside);
    if (!w->code) /* if the volume itself reports no damage */
        note(w, cvol_section_check(w->context, section, name));
    return CVOL_SECTION_DAMAGED;
}

static cvol_section_state check_content(walk *w, const cvol_section *section)
{
    if (section->kind == CVOL_VOLM)
        return check_volume(w, section);

    const int is_packed = section->kind == CVOL_CORR && w->has_header &&
                          w->header.residual == CVOL_RESIDUAL_PACKED;
    if (stream_of(section->kind) >= 0 && !is_packed)
        return w->has_index ? check_subband(w, section) : CVOL_SECTION_UNCHECKED;
    int code = cvol_section_check(w->context, section, w->name);
    note(w, code);
    if (!code)
        keep_content(w, section);
    return code ? CVOL_SECTION_DAMAGED : CVOL_SECTION_SOUND;
}

static void list_section(walk *w, const cvol_section *section, cvol_section_state state)
{
    if (w->out->section_count == CVOL_FILE_SECTIONS_MAX)
        return;
    cvol_file_section *out = &w->out->sections[w->out->section_count++];
    *out = (cvol_file_section){.flags = section->flags,
                               .offset = section->offset,
                               .length = section->length,
                               .content = cvol_section_content(section->kind),
                               .state = state};
    memcpy(out->tag, section->tag, sizeof out->tag);
}

/* Takes the next section; returns 0 if the section after it cannot be found. */
static int take_section(walk *w)
{
    cvol_section section;
    int code = cvol_section_next(w->context, &section, &w->sections, w->name);
    note(w, code);
    if (!section.tag[0])
        return 0;
    cvol_section_state state = w->sections.cut    ? CVOL_SECTION_TRUNCATED
                               : !section.content ? CVOL_SECTION_DAMAGED
                                                  : check_content(w, &section);
    if (!(w->sections.places && section.kind == CVOL_ENDS)) /* packed files have none */
        list_section(w, &section, state);
    return section.content && !code;
}

/* Continues with the sections of a packed file; *file becomes the unpacked file, which may be
 * empty. */
static void take_packed(walk *w, cvol_unpacked *unpacked, cvol_cursor *file, const uint8_t *data,
                        size_t size)
{
    const int code = cvol_unpack(w->context, unpacked, data, size, w->name);
    note(w, code);
    if (unpacked->pack.tag[0])
        list_section(w, &unpacked->pack,
                     unpacked->is_cut ? CVOL_SECTION_TRUNCATED
                     : code           ? CVOL_SECTION_DAMAGED
                                      : CVOL_SECTION_SOUND);
    *file = cvol_cursor_make(unpacked->plain.data, unpacked->plain.size);
    cvol_cursor_take(file, CVOL_SECTIONS_AT);
}

/* The finest level from complete subbands whose preceding sections are valid. */
static int find_level(const cvol_file_layout *layout)
{
    int subbands = 0;
    for (int i = 0; i < layout->section_count; i++) {
        const cvol_file_section *s = &layout->sections[i];
        if (s->state != CVOL_SECTION_SOUND &&
            !(s->state == CVOL_SECTION_TRUNCATED && !strcmp(s->tag, cvol_section_tag(CVOL_PACK))))
            break;
        subbands += !strncmp(s->tag, "SHL", 3);
    }
    return subbands ? CVOL_SUBBANDS - subbands : -1;
}

/* ---- the file --------------------------------------------------------------------------- */

/* Checks signature and version. */
static int take_start(cvol_context *context, cvol_file_layout *out, cvol_cursor *file,
                      const char *name)
{
    const size_t size = file->size, same = cvol_container_matches(file->data, size);
    if (same < CVOL_SIGNATURE_BYTES && same < size)
        return cvol_fail(context, CVOL_ERROR_FORMAT,
                         "%s: is not a .cvol file: byte %zu is %02x, must be %02x", name, same,
                         file->data[same], cvol_container_signature(same));
    if (size < CVOL_SECTIONS_AT)
        return cvol_fail(context, CVOL_ERROR_CORRUPT,
                         "%s: truncated: %zu of %d bytes of its signature and version are there",
                         name, size, (int)CVOL_SECTIONS_AT);
    cvol_cursor_take(file, CVOL_SIGNATURE_BYTES);
    out->version = cvol_cursor_u32(file);
    return cvol_container_check_version(context, out->version, name);
}

int cvol_layout_walk(cvol_context *context, cvol_file_layout *out, const uint8_t *data, size_t size,
                     const char *name)
{
    walk w = {.context = context, .out = out, .name = name};
    cvol_cursor file = cvol_cursor_make(data, size);
    *out = (cvol_file_layout){.file_bytes = size, .level = -1};
    int code = take_start(context, out, &file, name);
    if (code)
        return code;
    cvol_unpacked unpacked = {.is_cut = 0};
    const int is_packed = cvol_pack_detect(data, size);
    if (is_packed)
        take_packed(&w, &unpacked, &file, data, size);
    w.sections = cvol_section_walk_make(file);
    w.sections.places = is_packed ? &unpacked.places : NULL;
    int go_on = !w.code;
    while (go_on && !cvol_section_walk_ended(&w.sections))
        go_on = take_section(&w);
    out->level = find_level(out);
    cvol_unpacked_free(&unpacked);
    cvol_brick_index_free(&w.index);
    cvol_series_free(w.series);
    return w.code ? cvol_fail(context, w.code, "%s", w.message) : CVOL_OK;
}

/* Adds the byte offset of the section that the reader's message names. */
static int add_offset(cvol_context *context, const cvol_file_layout *layout, const char *name,
                      int code)
{
    char what[CVOL_MESSAGE_BYTES];
    snprintf(what, sizeof what, "%s", cvol_context_message(context));
    const char *behind = strncmp(what, name, strlen(name)) ? what : what + strlen(name);
    for (int i = 0; i < layout->section_count && !strstr(behind, " at byte "); i++) {
        char section[16];
        snprintf(section, sizeof section, "section %s", layout->sections[i].tag);
        if (strstr(behind, section))
            return cvol_fail(context, code, "%s (%s is at byte %llu)", what, section,
                             (unsigned long long)layout->sections[i].offset);
    }
    return code;
}

static int try_to_read(cvol_context *context, const uint8_t *data, size_t size, const char *name)
{
    if (cvol_plane_file_kind(data, size) == CVOL_FILE_SERIES)
        return cvol_series_try(context, data, size, name);
    if (cvol_plane_file_kind(data, size) == CVOL_FILE_ARRAY)
        return cvol_container_try(context, data, size, name);
    if (cvol_plane_file_kind(data, size) == CVOL_FILE_BAKED) {
        cvol_baked_file baked;
        const int code = cvol_baked_file_take(context, &baked, data, size, name);
        cvol_baked_file_free(&baked);
        return code;
    }
    cvol_picture *picture;
    const int code = cvol_picture_take(context, &picture, data, size, name);
    cvol_picture_free(picture);
    return code;
}

int cvol_layout_verify(cvol_context *context, cvol_file_layout *out, const uint8_t *data,
                       size_t size, const char *name)
{
    int code = cvol_layout_walk(context, out, data, size, name);
    if (code)
        return code;
    code = try_to_read(context, data, size, name);
    return code ? add_offset(context, out, name, code) : CVOL_OK;
}

typedef int look(cvol_context *context, cvol_file_layout *out, const uint8_t *data, size_t size,
                 const char *name);

/* Opens the file; if a process of a team cannot, none does. */
static int open_file(cvol_context *context, cvol_map *file, const char *path)
{
    cvol_team *team = context->team;
    if (!team) /* a copy: another process may be changing a damaged file */
        return cvol_file_copy(context, file, path);
    char what[CVOL_MESSAGE_BYTES];
    const int own = cvol_file_map(context, file, path); /* to read parts of a large file */
    if (own && team->rank) {
        snprintf(what, sizeof what, "%s", cvol_context_message(context));
        cvol_fail(context, own, "process %d: %s", team->rank, what);
    }
    const int code = cvol_team_first_failure(context, team, own, (size_t)team->rank);
    if (code && !own)
        cvol_file_unmap(file);
    return code;
}

static int look_at(cvol_context *context, cvol_file_layout *out, const char *path, look *what)
{
    cvol_map file;
    *out = (cvol_file_layout){.level = -1};
    int code = open_file(context, &file, path);
    if (code)
        return code;
    code = what(context, out, file.data, file.size, path);
    cvol_file_unmap(&file);
    /* All processes of a team find the same damage, but memory is short, say, in one alone. */
    return code == CVOL_ERROR_MEMORY || code == CVOL_ERROR_CANCELLED
               ? cvol_team_agree(context, context->team, code)
               : code;
}

int cvol_file_read_layout(cvol_context *context, cvol_file_layout *out, const char *path)
{
    return look_at(context, out, path, cvol_layout_walk);
}

int cvol_file_verify(cvol_context *context, cvol_file_layout *out, const char *path)
{
    cvol_file_layout unused;
    return look_at(context, out ? out : &unused, path, cvol_layout_verify);
}
