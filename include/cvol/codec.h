/* cvol/codec.h - from dense samples to compressed arrays, and the .cvol container. */
#ifndef CVOL_CODEC_H
#define CVOL_CODEC_H

#include "cvol/array.h"
#include "cvol/volume.h"

#ifdef __cplusplus
extern "C" {
#endif

/* What a compression is asked for. */
typedef enum cvol_target {
    CVOL_TARGET_RATIO = 1,     /* raw bytes / file bytes at least, and at most 2 % more */
    CVOL_TARGET_PSNR = 2,      /* dB over the range of the samples, at least */
    CVOL_TARGET_MAX_ERROR = 3, /* largest |original - decoded|, at most; 0: lossless */
    CVOL_TARGET_BITS = 4 /* bits a sample, 8 file bytes / samples: at most, and at most 2 % less */
} cvol_target;

/* A background is one value that many samples have, behind sharp edges: kept apart as a mask, it is
 * exact and the edges around it need no terms. To who evaluates or renders it is a value as any
 * other; operations (cvol/algebra.h) need an array without (cvol_array_flatten). */
typedef enum cvol_background {
    CVOL_BACKGROUND_NONE,
    CVOL_BACKGROUND_FIND, /* the value that most samples have, where that pays */
    CVOL_BACKGROUND_VALUE /* samples that equal background_value */
} cvol_background;

/* How much time compressing may take. */
typedef enum cvol_effort {
    CVOL_EFFORT_DEFAULT = 0, /* the best files in reasonable time */
    CVOL_EFFORT_FAST, /* less than half the time, 3 to 9 % more bits; a PSNR may be 0.5 dB above the
                         target */
    CVOL_EFFORT_MAX /* 0.1 to 1.8 dB more at the same size, and about 20 times the time, for reading
                       too. Blocks of 16 in bricks of 64^3; not with max_error or lossless.
                       Renderers skip less of such a volume: it stores no bounds of its blocks */
} cvol_effort;

/* How to compress; begin with cvol_compress_options_defaults(). */
typedef struct cvol_compress_options {
    cvol_transform transform; /* CVOL_DCT */
    int block;                /* 8, 16 or 32 */
    cvol_target target;
    double target_value;
    double least_psnr; /* dB: where a ratio, or bits, would leave less, compressing fails with
                          TARGET and a report; 0: whatever is left. Not of transcoding */
    double max_error;  /* beside a PSNR: no sample is further off than this; 0: none asked for */
    int lossless;      /* every sample comes back to the bit, of any type; target does not matter */
    int has_fill;      /* samples that equal `fill` have no value; NaN: all NaN and infinite ones */
    double fill;
    cvol_background background; /* of samples in memory. VALUE: not beside a bound, lossless or a
                                   fill; FIND: there it finds none */
    double background_value;
    const char *attributes; /* of cvol_compress_stream: JSON text, or NULL */
    int lapped; /* 1 (default): blocks of 16 overlap through filters across their faces, which
                   makes files smaller. 0: multiplying and convolving are faster */
    cvol_effort effort; /* CVOL_EFFORT_DEFAULT */
    int no_histogram;   /* the file does not carry how the samples are distributed, which takes
                           40 to 200 bytes: for volumes that are not drawn by themselves */
    int brick[3];       /* samples along x, y, z that are coded together, and read alone where a
                           part of the file is asked for: 16, 32, 48 or 64, multiples of the
                           block. 0, 0, 0: 64, 64, 64, and less for planes of files of 2 MB and more
                           that are made to a ratio or to bits a sample (doc/format.md, section
                           6); transcoding: as the array has them. Smaller ones take more bits */
} cvol_compress_options;

/* DCT blocks of 16^3 at ratio 30. */
CVOL_API cvol_compress_options cvol_compress_options_defaults(void);

/* What a compression reached; every figure measured on the encoded bytes, decoded again; of volumes
 * in memory that are compressed in haste (cells of 16) on the terms that were encoded. */
typedef struct cvol_compress_report {
    double ratio;   /* raw bytes / file bytes */
    double psnr_db; /* infinity when exact */
    double max_error;
    uint64_t file_bytes;
    int lossless;   /* decoded samples equal the original ones */
    int target_met; /* 0 only for a ratio (or bits) that the coarsest step does not reach, or of
                       float samples the finest does not come down to; what is lossless and smaller
                       than was asked for meets it */
    int trials;     /* steps tried */
    uint64_t coefficients;       /* terms kept */
    uint64_t background_samples; /* samples of the background that is kept apart */
    double background;           /* their value */
} cvol_compress_report;

/* Compresses the samples (described by `grid`, x fastest) into a new array.
 * The step is searched so that the target holds, and the result is verified by decoding the
 * encoded bytes. Where a lossless array takes no more bytes than the lossy one, or than a ratio
 * allows, it is the result (report->lossless, a ratio above the asked one), and where no step has a
 * PSNR; whether to try is estimated. Bits a sample are a ratio, of the bits of the samples'
 * type. report may be NULL. The caller frees *out.
 * A bound of errors and lossless compression add residual to what the terms give, which samples
 * in the array's own type (cvol_array_evaluate_box) are made with; floats
 * (cvol_array_evaluate_real, pictures, operations) are what the terms give. Samples without a value
 * are kept as a mask, come back to the bit, and count for no PSNR, error, least or largest value.
 * With a background kept apart a copy of the samples is made, filled in.
 * Lossless floats may be NaN or infinite, of at most 7 bit patterns. Cost: one forward transform,
 * and per encode attempt one quantization and coding of it. Errors: ARGUMENT, DATA (NaN or infinite
 * samples: how many and the index of the first), TARGET (no step reaches the PSNR or the bound; or
 * the result is below least_psnr, and the report says by how much), MEMORY, CANCELLED, UNSUPPORTED.
 */
CVOL_API int cvol_compress(cvol_context *context, cvol_array **out, cvol_compress_report *report,
                           const void *samples, const cvol_grid *grid,
                           const cvol_compress_options *options);

/* Where samples come from that are not all in memory. read() writes sheets (z) first_sheet ..
 * first_sheet + sheets - 1 to `samples`, x fastest, in the machine's byte order; calls go forward
 * but for a few, and through the whole volume several times. It returns 0 or an error code, with
 * its message on the context. */
typedef struct cvol_sample_source {
    int (*read)(cvol_context *context, void *user, void *samples, size_t first_sheet,
                size_t sheets); /* as above */
    void *user;                 /* handed on to it */
} cvol_sample_source;

/* Compresses samples that are read slab by slab into the file PATH, which appears under its name
 * only when it is whole. What it decodes to is measured on the way. Ratio, bits or PSNR; cells of
 * 16. options->attributes become the file's. report may be NULL.
 * Memory: two slabs of 68 sheets at most, and of what is coded about what two layers of 64 sheets
 * take; what of the file is beyond 64 MiB waits in unnamed files beside it. Cost: three to four
 * passes over the samples.
 * Errors: those of cvol_compress and of read(), IO, LIMIT. */
CVOL_API int cvol_compress_stream(cvol_context *context, cvol_compress_report *report,
                                  const char *path, const cvol_sample_source *source,
                                  const cvol_grid *grid, const cvol_compress_options *options);

/* 1 if a volume's samples are labels: names of what lies where, of which the mean of two means
 * nothing, so that they should be compressed without loss. A file says so (`path`, which may be
 * NULL: NIfTI's intent code 1002, names in .seg.nrrd), or the samples look like it: integers of at
 * most 4,096 values, that are the same over regions and jump between them. Cost: at most three
 * passes. */
CVOL_API int cvol_volume_is_labels(const cvol_volume *volume, const char *path);

/* A coarser array from a compressed volume (DCT blocks), without going through samples: terms are
 * requantized with the step that the ratio, the bits or the PSNR need; cells stay as they are,
 * attributes and masks too. Of an array with residual, the decoded samples are compressed instead
 * (as cvol_compress does it), since its terms are coarser than what it decodes to. What is known of
 * the result is certified, not measured: the bound of `array` and how far the samples moved. A PSNR
 * is what that bound promises, 2 to 3 dB below what it is. A ratio is kept, and is 3 % above what
 * was asked at most, unless no weight of bits gives such a size. report (may be NULL) and *out are
 * as those of cvol_compress; the caller frees *out. Cost: a dozen codings of the terms. Errors:
 * ARGUMENT, UNSUPPORTED (no volume in blocks; a largest error), TARGET (finer than `array`), DATA,
 * MEMORY, CANCELLED. */
CVOL_API int cvol_array_transcode(cvol_context *context, cvol_array **out,
                                  cvol_compress_report *report, const cvol_array *array,
                                  const cvol_compress_options *options);

/* Evaluates an array and sets its psnr_db and max_error to what they are, measured, against the
 * samples that it was compressed from; l2_error and max_abs become tighter if they can.
 * Cost: evaluating it, dense (blocks: twice). Errors: MEMORY, CANCELLED. */
CVOL_API int cvol_array_measure(cvol_context *context, cvol_array *array, const void *samples);

/* Writes the array as a .cvol file (doc/format.md): temporary name, sync, rename.
 * Deterministic bytes. Errors: IO, MEMORY, CANCELLED. */
CVOL_API int cvol_array_write(cvol_context *context, const cvol_array *array, const char *path,
                              uint64_t *file_bytes);

/* Has files of a volume (DCT blocks) written in bricks of brick[0] x brick[1] x brick[2] samples,
 * as cvol_compress_options has them; 0, 0, 0: 64^3. Terms, bounds and samples stay as they are.
 * Errors: ARGUMENT, UNSUPPORTED (no volume; residual, which are coded in bricks). */
CVOL_API int cvol_array_set_bricks(cvol_context *context, cvol_array *array, const int brick[3]);

/* Reads a .cvol file. The caller frees *out. file_bytes may be NULL. Of a file that ends early the
 * message says which level is whole.
 * Errors: IO, FORMAT, CORRUPT, LIMIT, UNSUPPORTED, MEMORY. */
CVOL_API int cvol_array_read(cvol_context *context, cvol_array **out, const char *path,
                             uint64_t *file_bytes);

/* The same bytes in memory, *size of them, which the caller frees with free(). *out is NULL after
 * an error. Errors: MEMORY, CANCELLED, IO (beyond 64 MiB what is coded waits in unnamed files). */
CVOL_API int cvol_array_write_memory(cvol_context *context, const cvol_array *array, void **out,
                                     size_t *size);

/* Reads the `size` bytes of a .cvol file that lie at `data`, which need not be aligned and are not
 * needed any more afterwards. `name` begins messages. A volume of more bytes than the context's
 * limit is refused before there is memory for it. The caller frees *out.
 * Errors: those of cvol_array_read but IO. */
CVOL_API int cvol_array_read_memory(cvol_context *context, cvol_array **out, const void *data,
                                    size_t size, const char *name);

/* What is read of a file; all zero: everything. */
typedef struct cvol_file_part {
    /* The box of samples [begin, end) (x, y, z), NULL: all. Of a volume in DCT blocks only the
     * bricks (of 64^3 samples, or as the file has them) that it touches are read, checked and
     * decoded. The array has the file's grid; samples of other bricks evaluate to a constant, so
     * that only samples within the box may be asked for, and it counts only the coefficients that
     * it has. */
    const size_t *begin, *end;
    /* 0: all coefficients; level 1, 2, 3: of a volume in DCT blocks those of the lowest 1/2, 1/4,
     * 1/8 of the frequencies along each axis, which stand first in the file. What is behind them is
     * not looked at. l2_error and max_abs count what is left away. */
    int level;
    /* 1: of a volume whose file ends early, the finest level that is whole (but no finer than
     * `level`) instead of an error. If all that is missing are residual, that is level 0 without
     * them: its figures are those of the terms alone, not measured. */
    int cut;
    /* Which volume of a file of many (cvol/series.h), from 0; other files have one of each. */
    int time, channel;
} cvol_file_part;

/* What was read. */
typedef struct cvol_file_report {
    uint64_t file_bytes;  /* of a volume among many: its own */
    int level;            /* of the array */
    int cut;              /* 1: the file ends early */
    int residual_missing; /* 1: it ends within the residual that make samples exact, or keep
                             their bound: the array is without, all of its figures are of that */
} cvol_file_report;

/* Reads a part of a .cvol file. Other arrays than volumes in DCT blocks are read whole. The file is
 * mapped: only what is needed is read. The caller frees *out. part, report: may be NULL.
 * Errors: those of cvol_array_read, and ARGUMENT (the box is empty, reversed, or not within; no
 * such level, time or channel). */
CVOL_API int cvol_array_read_part(cvol_context *context, cvol_array **out, cvol_file_report *report,
                                  const char *path, const cvol_file_part *part);

/* The same of a box, at level 0. file_bytes may be NULL. */
CVOL_API int cvol_array_read_box(cvol_context *context, cvol_array **out, const char *path,
                                 const size_t begin[3], const size_t end[3], uint64_t *file_bytes);

/* The grid of a .cvol file's array, as reading it would find it: only the head of the file is
 * looked at. Of many volumes that at part->time and part->channel; part may be NULL, and what else
 * it says does not count. Errors: those of cvol_array_read_part. */
CVOL_API int cvol_file_grid(cvol_context *context, cvol_grid *out, const char *path,
                            const cvol_file_part *part);

/* ---- a file as it lies there -------------------------------------------------------------- */

/* What is known of a section. */
typedef enum cvol_section_state {
    CVOL_SECTION_SOUND = 0,     /* every checksum of it holds */
    CVOL_SECTION_DAMAGED = 1,   /* one of its header, its content or a run of bricks does not */
    CVOL_SECTION_TRUNCATED = 2, /* the file ends within it */
    CVOL_SECTION_UNCHECKED = 3  /* its checksums are in a section that is damaged */
} cvol_section_state;

/* "sound", "damaged", "truncated", "not checked"; NULL for a number that is none. */
CVOL_API const char *cvol_section_state_name(cvol_section_state state);

/* A section of a file. */
typedef struct cvol_file_section {
    char tag[5];    /* "HEAD", ...; letters that cannot be printed are '?' */
    uint32_t flags; /* bit 0: readers must know it */
    /* of its header in the file; the content begins 24 bytes behind. In packed files, whose first
     * section is PACK, others have no header: of the subbands, MASK and CORR it is the place of
     * their first byte; of those in front of them it is that of PACK */
    uint64_t offset;
    uint64_t length;     /* of its content in bytes, as its header says; unpacked */
    const char *content; /* what it is, in words; static storage */
    cvol_section_state state;
} cvol_file_section;

/* How many sections are told. */
enum { CVOL_FILE_SECTIONS_MAX = 64 };

/* A file's sections. */
typedef struct cvol_file_layout {
    uint64_t file_bytes;
    uint32_t version;  /* of the format */
    int section_count; /* of more than CVOL_FILE_SECTIONS_MAX the first are told, all are checked */
    cvol_file_section sections[CVOL_FILE_SECTIONS_MAX]; /* in the file's order */
    int level; /* volumes in DCT blocks: the finest level whose sections are sound; -1: none */
} cvol_file_layout;

/* Finds a .cvol file's sections and checks every checksum: of their headers, their contents, and
 * each run of bricks. The message is about the first damage: section, byte, what differs. *out is
 * filled as far as the file can be followed, whatever is returned.
 * Cost: one pass over the file, whose bytes it holds in memory.
 * Errors: IO, FORMAT (no .cvol file), CORRUPT, UNSUPPORTED (its version), MEMORY. */
CVOL_API int cvol_file_layout_read(cvol_context *context, cvol_file_layout *out, const char *path);

/* The same, and that the file decodes: cvol_array_read succeeds after it. out may be NULL.
 * Cost: that of cvol_array_read and one more pass over the file. Errors: those of both. */
CVOL_API int cvol_file_verify(cvol_context *context, cvol_file_layout *out, const char *path);

/* What files of cvol hold. */
typedef enum cvol_file_kind {
    CVOL_FILE_OTHER = 0,   /* none of them, or unreadable */
    CVOL_FILE_ARRAY = 1,   /* an array: cvol_array_read */
    CVOL_FILE_PICTURE = 2, /* a compressed picture: cvol/picture.h */
    CVOL_FILE_BAKED = 3,   /* a baked volume: cvol/render.h */
    CVOL_FILE_SERIES = 4   /* many arrays: cvol/series.h */
} cvol_file_kind;
/* By the file's first bytes. */
CVOL_API cvol_file_kind cvol_file_kind_of(const char *path);

/* 1 if the file begins with the .cvol signature, 0 if not or unreadable. */
CVOL_API int cvol_file_is_cvol(const char *path);

#ifdef __cplusplus
}
#endif
#endif
