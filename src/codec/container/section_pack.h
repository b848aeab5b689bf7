/* Section PACK: the sections of a small file in one.
 *
 * The records in front of the streams of a small volume take some 500 bytes, most of which are the
 * same in every file. PACK has what is different. The streams (brick_index.h) follow as they are,
 * so that the beginning of the file gives a coarse level here too.
 *
 *     n, LEB128     n bytes: the packed front     bytes of MASK, SHL0 ... SHL3, CORR
 *
 * The section's checksum is that of n and the packed front; the streams have theirs in INDX.
 * Readers unpack the file in memory: what they read then has the same sections as a file that is
 * not packed.
 */
#ifndef CVOL_CODEC_CONTAINER_SECTION_PACK_H
#define CVOL_CODEC_CONTAINER_SECTION_PACK_H

#include "codec/section/section.h"

/* Files of more bytes, before they are packed, are not packed. */
#define CVOL_PACK_MOST (UINT64_C(1) << 17)

/* About the bytes of a packed file of one brick without its streams, tables and histogram. */
#define CVOL_PACK_USUAL_BYTES 150

/* Appends signature, version, and section PACK up to its streams, whose bytes (`streams` in all)
 * the caller appends. `plain`: the file up to INDX, as it is without PACK. residual: content of
 * CORR where INDX does not have it, or NULL; counted in `streams`. Errors: MEMORY. */
int cvol_pack_put(cvol_context *context, cvol_bytes *out, const cvol_bytes *plain, uint64_t streams,
                  const cvol_bytes *residual);

/* 1 if the first section of data is PACK. */
int cvol_pack_is(const uint8_t *data, size_t size);

/* A packed file without PACK. */
typedef struct cvol_unpacked {
    cvol_bytes plain; /* the file, as it is without PACK; shorter where the packed file is cut */
    cvol_section pack;
    cvol_section_places places;
    int is_cut; /* the file ends early */
} cvol_unpacked;

/* Unpacks a file as far as it is there; if it is cut within its streams this succeeds, with
 * is_cut. The caller frees *out, also after an error, when it holds what was found before it.
 * Errors: CORRUPT, LIMIT, UNSUPPORTED, MEMORY. */
int cvol_unpack(cvol_context *context, cvol_unpacked *out, const uint8_t *data, size_t size,
                const char *name);
void cvol_unpacked_free(cvol_unpacked *unpacked);

#endif
