/* Section PACK: all sections of a small file in one.
 *
 * The records in front of a small volume's streams take about 500 bytes, most of which are equal in
 * every file. PACK stores only the differences. The streams (brick_index.h) follow unchanged, so
 * that the beginning of the file still gives a coarse level.
 *     n, LEB128
 *     n bytes: the packed front
 *     bytes of MASK, SHL0 ... SHL3, CORR
 * The section's checksum covers n and the packed front; INDX has the checksums of the streams.
 * Readers unpack the file in memory and then read the same sections as in an unpacked file. */
#ifndef CVOL_CODEC_CONTAINER_SECTION_PACK_H
#define CVOL_CODEC_CONTAINER_SECTION_PACK_H

#include "codec/section/section.h"

/* Larger files (before packing) are not packed. */
#define CVOL_PACK_MAX (UINT64_C(1) << 17)

/* The approximate size of a packed file of one brick without its streams, tables and histogram. */
#define CVOL_PACK_USUAL_BYTES 156

/* Appends signature, version, and section PACK up to its streams; the caller appends their bytes
 * (`streams` in total). `plain`: the file up to INDX, as without PACK. residual: content of CORR if
 * INDX does not list it, or NULL; `streams` includes it. Errors: MEMORY. */
int cvol_pack_put(cvol_context *context, cvol_bytes *out, const cvol_bytes *plain, uint64_t streams,
                  const cvol_bytes *residual);

/* 1 if the first section of data is PACK. */
int cvol_pack_detect(const uint8_t *data, size_t size);

/* A packed file without PACK. */
typedef struct cvol_unpacked {
    cvol_bytes plain; /* the file as without PACK; shorter if the packed file is cut */
    cvol_section pack;
    cvol_section_places places;
    int is_cut; /* the file ends early */
} cvol_unpacked;

/* Unpacks the available part of a file; if the file is cut within its streams it succeeds and sets
 * is_cut. The caller frees *out, also after an error; it then holds the part found before the
 * error. Errors: CORRUPT, LIMIT, UNSUPPORTED, MEMORY. */
int cvol_unpack(cvol_context *context, cvol_unpacked *out, const uint8_t *data, size_t size,
                const char *name);
void cvol_unpacked_free(cvol_unpacked *unpacked);

#endif
