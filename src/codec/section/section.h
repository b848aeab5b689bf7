/* Sections of a .cvol: a header of 24 bytes, and the content.
 *
 *     tag[4]  flags u32  length u64  checksum of the content u32  checksum of the 20 bytes before
 * u32
 *
 * Which sections a file has, and their order, is in doc/format.md. Sections of unknown tags may
 * stand anywhere; a reader passes over those that are not flagged as required.
 */
#ifndef CVOL_CODEC_SECTION_SECTION_H
#define CVOL_CODEC_SECTION_SECTION_H

#include "base/bytes.h"
#include "cvol/base.h"

/* A PSNR of so many dB or more says that nothing is lost, as an infinite one does. */
#define CVOL_PSNR_EXACT 999.0

enum { CVOL_SECTION_HEADER_BYTES = 24, CVOL_SECTION_REQUIRED = 1 };

/* In the order in which they stand in a file. The four subbands follow each other. PICT, BAKE and
 * LIST stand where HEAD does in other kinds of files; VOLM is the one that there may be many of.
 * PACK (section_pack.h) is the only section of its file. */
typedef enum cvol_section_kind {
    CVOL_HEAD,
    CVOL_GEOM,
    CVOL_ATTR,
    CVOL_ERRS,
    CVOL_MODE,
    CVOL_BRKS,
    CVOL_TRUE,
    CVOL_SMAL,
    CVOL_SUMM,
    CVOL_RNGE,
    CVOL_TABL,
    CVOL_INDX,
    CVOL_MASK,
    CVOL_SHL0,
    CVOL_SHL1,
    CVOL_SHL2,
    CVOL_SHL3,
    CVOL_CORR,
    CVOL_TERM,
    CVOL_SPEC,
    CVOL_PICT,
    CVOL_BAKE,
    CVOL_PLNS,
    CVOL_LIST,
    CVOL_VOLM,
    CVOL_PACK,
    CVOL_ENDS,
    CVOL_SECTION_KINDS, /* how many; also: none of them */
    CVOL_SECTION_UNKNOWN = CVOL_SECTION_KINDS
} cvol_section_kind;

/* "HEAD"; what its content is, in words. Static storage; of an unknown one "????", "unknown". */
const char *cvol_section_tag(cvol_section_kind kind);
const char *cvol_section_content(cvol_section_kind kind);

/* ---- writing ---------------------------------------------------------------------------- */

/* Appends a section's header. */
void cvol_section_put_header(cvol_bytes *out, cvol_section_kind kind, uint64_t length,
                             uint32_t checksum);
/* Appends a whole section. */
void cvol_section_put(cvol_bytes *out, cvol_section_kind kind, const cvol_bytes *content);

/* ---- reading ---------------------------------------------------------------------------- */

typedef struct cvol_section {
    cvol_section_kind kind;
    char tag[5]; /* letters that cannot be printed are '?' */
    uint32_t flags, checksum;
    uint64_t offset, length; /* of its header in the file; of its content, as the header says */
    uint64_t content_offset; /* of its content in the file */
    const uint8_t *content;  /* NULL if it is not all there */
} cvol_section;

/* Where sections lie in a packed file, by where they lie in the unpacked one. */
enum { CVOL_SECTION_STREAMS_MOST = 8 };
typedef struct cvol_section_places {
    uint64_t front, front_at; /* sections before byte `front` are packed at byte `front_at` */
    int count;
    struct {
        uint64_t header, at; /* of the unpacked header, and of the first byte in the packed file */
    } streams[CVOL_SECTION_STREAMS_MOST];
} cvol_section_places;

/* The way through a file's sections; `file` begins behind the version. */
typedef struct cvol_section_walk {
    cvol_cursor file;
    cvol_section_kind last; /* the last known one; CVOL_SECTION_UNKNOWN: none yet */
    int cut;                /* the file ends where it should go on: within the section, or before */
    const cvol_section_places *places; /* `file` was unpacked: where sections lie; else NULL */
} cvol_section_walk;

cvol_section_walk cvol_section_walk_make(cvol_cursor file);
/* The next section's header, checked: its checksum, that it may stand there, and that its content
 * is there. ENDS, or PACK, is the last: nothing may follow it. *section is filled as far as could
 * be, its tag is empty if there was nothing. Errors: CORRUPT (with walk->cut if all that is wrong
 * is that the file ends), UNSUPPORTED (required, and unknown). The message names the section's
 * byte. */
int cvol_section_next(cvol_context *context, cvol_section *section, cvol_section_walk *walk,
                      const char *name);
static inline int cvol_section_walk_ended(const cvol_section_walk *walk)
{
    return walk->last == CVOL_ENDS || walk->last == CVOL_PACK;
}

/* Compares the content's checksum with what the header says; not that of a subband, whose checksum
 * is its runs'. Errors: CORRUPT. */
int cvol_section_check(cvol_context *context, const cvol_section *section, const char *name);
/* The sentence of it: what a section's bytes should give, and do. */
int cvol_section_fail_sum(cvol_context *context, const cvol_section *section, uint32_t found,
                          const char *name);

/* The whole content, to be read. */
static inline cvol_cursor cvol_section_cursor(const cvol_section *section)
{
    return cvol_cursor_make(section->content, (size_t)section->length);
}

#endif
