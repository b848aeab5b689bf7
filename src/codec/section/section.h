/* Sections of a .cvol file: a header of 24 bytes, and the content.
 *     tag[4]  flags u32  length u64  checksum of the content u32
 *     checksum of the 20 bytes before u32
 * doc/format.md gives the sections of a file and their order. Sections with unknown tags may stand
 * anywhere; a reader skips them unless they are flagged as required. */
#ifndef CVOL_CODEC_SECTION_SECTION_H
#define CVOL_CODEC_SECTION_SECTION_H

#include "base/bytes.h"
#include "cvol/base.h"

/* A PSNR of this many dB or more means exact, as an infinite one does. */
#define CVOL_PSNR_EXACT 999.0

enum { CVOL_SECTION_HEADER_BYTES = 24, CVOL_SECTION_REQUIRED = 1 };

/* In file order. The four subbands are adjacent. PICT, BAKE and LIST replace HEAD in other kinds of
 * files; only VOLM may occur more than once. PACK (section_pack.h) is the only section of its
 * file. */
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
    CVOL_SECTION_KINDS, /* number of kinds; also: no kind */
    CVOL_SECTION_UNKNOWN = CVOL_SECTION_KINDS
} cvol_section_kind;

/* The tag ("HEAD") and a description of the content. Static storage; for an unknown kind "????" and
 * "unknown". */
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
    char tag[5]; /* unprintable characters become '?' */
    uint32_t flags, checksum;
    uint64_t offset, length; /* of its header in the file; of its content, from the header */
    uint64_t content_offset; /* of its content in the file */
    const uint8_t *content;  /* NULL if it is not complete */
} cvol_section;

/* Maps places in an unpacked file to places in the packed file. */
enum { CVOL_SECTION_STREAMS_MAX = 8 };
typedef struct cvol_section_places {
    uint64_t front, front_at; /* sections before byte `front` are packed at byte `front_at` */
    int count;
    struct {
        uint64_t header, at; /* of the header in the unpacked file, of the first byte in the
                                packed file */
    } streams[CVOL_SECTION_STREAMS_MAX];
} cvol_section_places;

/* The walk through a file's sections; `file` begins after the version. */
typedef struct cvol_section_walk {
    cvol_cursor file;
    cvol_section_kind last;            /* the last known one; CVOL_SECTION_UNKNOWN: none yet */
    int cut;                           /* the file ends early: within the section, or before it */
    const cvol_section_places *places; /* `file` was unpacked: places of its sections; else NULL */
} cvol_section_walk;

cvol_section_walk cvol_section_walk_make(cvol_cursor file);
/* Reads and checks the next section's header: its checksum, its order, and the presence of its
 * content. ENDS, or PACK, is the last: no section may follow it. Fills *section as far as possible;
 * its tag is empty if no section was left. Errors: CORRUPT (with walk->cut if the only error is
 * that the file ends early), UNSUPPORTED (required, but unknown). The message names the section's
 * byte. */
int cvol_section_next(cvol_context *context, cvol_section *section, cvol_section_walk *walk,
                      const char *name);
static inline int cvol_section_walk_ended(const cvol_section_walk *walk)
{
    return walk->last == CVOL_ENDS || walk->last == CVOL_PACK;
}

/* Compares the content's checksum with the header's; not for a subband, whose checksum is computed
 * from its runs'. Errors: CORRUPT. */
int cvol_section_check(cvol_context *context, const cvol_section *section, const char *name);
/* Fails with the message of a wrong checksum: expected and found. */
int cvol_section_fail_sum(cvol_context *context, const cvol_section *section, uint32_t found,
                          const char *name);

/* A cursor over the whole content. */
static inline cvol_cursor cvol_section_cursor(const cvol_section *section)
{
    return cvol_cursor_make(section->content, (size_t)section->length);
}

#endif
