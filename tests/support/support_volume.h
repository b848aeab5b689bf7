/* Common code of tests of volumes: a context and a folder, files in the folder, small volumes,
 * checks of read volumes, and NIfTI headers. */
#ifndef CVOL_TESTS_SUPPORT_VOLUME_H
#define CVOL_TESTS_SUPPORT_VOLUME_H

#include <stddef.h>
#include <stdint.h>

#include "cvol/volume.h"
#include "support_files.h"

/* The bytes 1 .. 255 and 0: samples of files made by hand. */
extern const uint8_t counting[256];

/* FOLDER/NAME, in storage that the next sixteen calls do not reuse. */
const char *in_folder(const char *name);
/* Writes FOLDER/NAME; returns its path. */
const char *write_bytes(const char *name, const void *data, size_t size);
/* The same: a text header and bytes behind it. */
const char *write_text(const char *name, const char *text, const void *data, size_t size);
/* Packs with zlib, `window_bits` as for deflateInit2; returns the packed size. */
size_t gzip(uint8_t *out, size_t room, const void *data, size_t size, int window_bits);

cvol_volume *read_ok(const char *path);
/* Reading fails with this code and a message that names the file and has both words. */
void read_fails_with(const char *path, const cvol_read_options *options, int code, const char *word,
                     const char *other);
void read_fails(const char *path, int code, const char *word, const char *other);
/* The same for 2^32 bytes of samples or more, which programs of 32 bits refuse before. */
void read_fails_large(const char *path, int code, const char *word);

/* A rotation about an oblique axis, times a mirror if requested. */
cvol_grid odd_grid(cvol_type type, int mirrored);
/* Random samples. */
cvol_volume *make_volume(const cvol_grid *grid, uint64_t seed);

void near(double a, double b, double relative);
void same_samples(const cvol_volume *a, const cvol_volume *b);
/* b has the geometry of a; with `turned`, the first two world axes have opposite signs. */
void same_place(const cvol_grid *a, const cvol_grid *b, double relative, int turned);

/* A NIfTI header in this machine's order or the other; fields are set by offset. */
typedef struct header {
    uint8_t bytes[600];
    int version, swapped;
} header;

/* A header of 2 x 3 x 2 uint8. */
header nifti1(int swapped);
header nifti2(int swapped);
void set16(header *h, size_t at, int value);
void set32(header *h, size_t at, int32_t value);
void set64(header *h, size_t at, int64_t value);
void set_float(header *h, size_t at, float value);
void set_double(header *h, size_t at, double value);
void set_dims(header *h, int64_t count, int64_t x, int64_t y, int64_t z, int64_t t);

#endif
