/* cvol/codec.h - from dense samples to compressed arrays; .cvol files. */
#ifndef CVOL_CODEC_H
#define CVOL_CODEC_H

#include "cvol/array.h"
#include "cvol/volume.h"

#ifdef __cplusplus
extern "C" {
#endif

/* Targets of compression. */
typedef enum cvol_target {
    CVOL_TARGET_RATIO = 1, /* raw bytes / file bytes, above 1: at least, and at most 2 % more */
    CVOL_TARGET_PSNR = 2,  /* dB over the value range of the samples, above 0 to 200: at least */
    CVOL_TARGET_MAX_ERROR = 3, /* largest |original - decoded|: at most; 0: lossless */
    CVOL_TARGET_BITS =
        4 /* bits per sample, 8 file bytes / samples: at most, and at most 2 % less */
} cvol_target;

/* A background is one value that many samples have, such as the air around a skull-stripped brain.
 * It is stored separately, as a mask, without loss; the sharp edges around it then need no
 * coefficients. Evaluation, rendering, operations and statistics treat it like any other value. */
typedef enum cvol_background {
    CVOL_BACKGROUND_NONE,
    CVOL_BACKGROUND_FIND, /* the most frequent value, if that makes the file smaller */
    CVOL_BACKGROUND_VALUE /* samples equal to background_value */
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

/* Options of compression; start with cvol_compress_options_defaults(). */
typedef struct cvol_compress_options {
    size_t size;              /* sizeof(cvol_compress_options) */
    cvol_transform transform; /* CVOL_DCT */
    int block;                /* 8, 16 or 32 */
    cvol_target target;
    double target_value;
    double least_psnr; /* dB: if a ratio or bits give less, compression fails with TARGET and a
                          report; 0: no limit */
    double max_error;  /* with a PSNR: no sample changes by more than this; 0: no limit */
    int lossless; /* every sample decodes to its original bits, for any type; the target does not
                     matter */
    int has_fill; /* samples that are `fill`, NaN or infinite have no value, and keep their bits; a
                     `fill` of NaN: NaN and infinite ones only */
    double fill;
    cvol_background background; /* for samples in memory. VALUE cannot be combined with a maximum
                                   error, lossless or a fill; FIND then finds none */
    double background_value;
    const char *attributes; /* a JSON text, which the file keeps and a size counts; or NULL */
    int lapped; /* 1 (default): blocks of 16 overlap through filters across their faces, which
                   makes files smaller. 0: multiplying and convolving are faster */
    cvol_effort effort; /* CVOL_EFFORT_DEFAULT */
    int no_histogram; /* 1: do not store the histogram of the samples (40 to 200 bytes), for volumes
                         that are never drawn by themselves */
    int brick[3]; /* samples along x, y, z that decode together, independently of others: 16, 32, 48
                     or 64, multiples of the block. 0, 0, 0: 64 each, and fewer for files of 2 MB
                     and more that are made to a ratio or to bits per sample, so that slices read
                     faster (doc/format.md, section 6); transcoding: as in the array. Smaller bricks
                     take more bits */
    int has_value_range; /* 1: the samples differ from original ones, which lie in value_min ..
                            value_max. The array states this range, widened by that of the samples,
                            so that bounds of products hold for the original samples. Not used by
                            transcoding */
    double value_min, value_max; /* the range of the original samples, if has_value_range */
} cvol_compress_options;

/* Sets *options, which has `size` bytes, to the defaults. */
CVOL_API void cvol_compress_options_set_defaults(cvol_compress_options *options, size_t size);
/* DCT blocks of 16^3 at ratio 30. */
static inline cvol_compress_options cvol_compress_options_defaults(void)
{
    cvol_compress_options options;
    cvol_compress_options_set_defaults(&options, sizeof options);
    return options;
}

/* Results of compression, measured by decoding the encoded bytes. With effort fast and samples in
 * memory (blocks of 16) they are measured on the quantized terms. */
typedef struct cvol_compress_report {
    double ratio;   /* raw bytes / file bytes */
    double psnr_db; /* infinity when exact */
    double max_error;
    uint64_t file_bytes;
    int lossless;   /* decoded samples equal the originals */
    int target_met; /* 0: the ratio (or bits) is out of reach of the largest step, or, for float
                       samples, of the smallest. A lossless file smaller than the target meets it */
    int trials;     /* steps tried */
    uint64_t coefficients;       /* number of terms */
    uint64_t background_samples; /* number of samples in the separate background */
    double background;           /* their value */
} cvol_compress_report;

/* Compresses samples (described by `grid`, x fastest) into a new array. The encoder searches for
 * the step that meets the target, and verifies the result by decoding the encoded bytes. If a
 * lossless file is not larger than the lossy one, or fits the ratio, it returns the lossless one
 * (report->lossless, with a higher ratio than asked), also if no step reaches the PSNR; it tries
 * this only if an estimate says it may succeed. Bits per sample are a ratio in terms of the sample
 * type. report may be NULL. The caller frees *out.
 *
 * A maximum error and lossless compression add a residual. Samples, floats (also those of
 * cvol_array_evaluate_real), pictures, statistics and operations include it; only
 * cvol_array_evaluate_points and coarse levels leave it out. Samples without a value are stored as
 * a mask, decode to their original bits, and do not count for PSNR, errors, least and largest
 * value. Lossless floats may have NaN and infinite samples of at most 7 bit patterns.
 *
 * Memory: with a separate background a copy of the samples. Cost: one forward transform, and one
 * quantization and coding per attempt. Errors: ARGUMENT, DATA (NaN or infinite samples: how many,
 * and the index of the first), TARGET (no step reaches the PSNR or the maximum error; or the result
 * is below least_psnr, and the report has its numbers), MEMORY, CANCELLED, UNSUPPORTED. */
CVOL_API int cvol_compress(cvol_context *context, cvol_array **out, cvol_compress_report *report,
                           const void *samples, const cvol_grid *grid,
                           const cvol_compress_options *options);

/* A source of samples that are not in memory. read() writes slices first_slice .. first_slice +
 * slices - 1 to `samples`, x fastest, in the byte order of the machine. Calls go through the whole
 * volume several times, with few exceptions forwards. It returns 0, or an error code after it set a
 * message on the context. read_rows(), which may be NULL, does the same for rows first_row ..
 * first_row + rows - 1 of the slices alone: with it, slices may be larger than memory. */
typedef struct cvol_sample_source {
    int (*read)(cvol_context *context, void *user, void *samples, size_t first_slice,
                size_t slices); /* as above */
    void *user;                 /* passed on to read() and read_rows() */
    int (*read_rows)(cvol_context *context, void *user, void *samples, size_t first_slice,
                     size_t slices, size_t first_row, size_t rows); /* as above */
} cvol_sample_source;

/* Compresses samples slab by slab into the file `path`, which gets its name only when it is
 * complete. The encoder measures the decoded samples on the way. Targets: ratio, bits or PSNR;
 * blocks of 16. options->attributes become those of the file. report may be NULL. Memory: a slab
 * of 68 slices; if source->read_rows is not NULL, only 128 MiB of it, but at least 68 rows. For the
 * coded data and its terms about that of two layers of 64 slices, and 24 bytes for each
 * block of 16^3 samples; coded data beyond 64 MiB waits in unnamed temporary files in the same
 * folder. Cost: three to four passes over the samples. Errors: those of cvol_compress and of
 * read(), IO, LIMIT. */
CVOL_API int cvol_compress_stream(cvol_context *context, cvol_compress_report *report,
                                  const char *path, const cvol_sample_source *source,
                                  const cvol_grid *grid, const cvol_compress_options *options);

/* 1 if the samples are labels: numbers that name regions, whose mean has no meaning, so that they
 * should be compressed without loss. Either the file says so (`path`, or NULL: NIfTI's intent code
 * 1002, a name that ends in .seg.nrrd), or the samples look like labels: integers with at most
 * 4,096 values that are constant over regions and jump between them. Cost: at most three passes. */
CVOL_API int cvol_volume_is_labels(const cvol_volume *volume, const char *path);

/* The same in *out, but it fails where cvol_volume_is_labels returns 0 because memory is short, or
 * because the file cannot be read. Errors: MEMORY, IO. */
CVOL_API int cvol_volume_compute_is_labels(cvol_context *context, int *out,
                                           const cvol_volume *volume, const char *path);

/* Makes a coarser array from a compressed volume (DCT blocks) without decoding samples: it
 * quantizes the terms again, with the step for the ratio, the bits or the PSNR. Splits of blocks,
 * attributes and masks stay the same. An array with a residual is decoded and compressed instead,
 * as by cvol_compress, because its terms are coarser than its samples. The error of the result is
 * certified, not measured: the bound of `array` plus the change of its samples. A PSNR target is
 * the PSNR that this bound guarantees, 2 to 3 dB below the real one. A ratio is met, and exceeded
 * by at most 3 %, unless no weight of bits gives such a size. report (may be NULL) and *out: as for
 * cvol_compress. Cost: about twelve codings of the terms. Errors: ARGUMENT, UNSUPPORTED (not a
 * volume in blocks; a maximum error), TARGET (finer than `array`; or the PSNR of the result, which
 * the report has, is below least_psnr), DATA, MEMORY, CANCELLED. */
CVOL_API int cvol_array_transcode(cvol_context *context, cvol_array **out,
                                  cvol_compress_report *report, const cvol_array *array,
                                  const cvol_compress_options *options);

/* Measures psnr_db and max_error of an array against the samples that it was compressed from; also
 * lowers l2_error, point_error and max_abs if it can. Cost: one evaluation of all samples (blocks:
 * two). Errors: MEMORY, CANCELLED. */
CVOL_API int cvol_array_measure(cvol_context *context, cvol_array *array, const void *samples);

/* Writes the array as a .cvol file (doc/format.md): a temporary name, sync, rename. The bytes
 * depend only on the array. Errors: IO, MEMORY, CANCELLED. */
CVOL_API int cvol_array_write(cvol_context *context, const cvol_array *array, const char *path,
                              uint64_t *file_bytes);

/* Sets the bricks in which files of a volume (DCT blocks) are written: brick[0] x brick[1] x
 * brick[2] samples, as in cvol_compress_options; 0, 0, 0: 64 each. Terms, bounds and samples do not
 * change. Errors: ARGUMENT, UNSUPPORTED (not a volume; an array with a residual, which is coded in
 * bricks). */
CVOL_API int cvol_array_set_bricks(cvol_context *context, cvol_array *array, const int brick[3]);

/* Reads a .cvol file. The caller frees *out. file_bytes may be NULL. If the file ends early, the
 * message names the finest complete level. Errors: IO, FORMAT, CORRUPT, LIMIT, UNSUPPORTED, MEMORY.
 */
CVOL_API int cvol_array_read(cvol_context *context, cvol_array **out, const char *path,
                             uint64_t *file_bytes);

/* Writes the bytes of a .cvol file to memory: *size bytes, which the caller frees with free().
 * After an error *out is NULL. Errors: MEMORY, CANCELLED, IO (coded data beyond 64 MiB waits in
 * unnamed temporary files). */
CVOL_API int cvol_array_write_memory(cvol_context *context, const cvol_array *array, void **out,
                                     size_t *size);

/* Reads a .cvol file from `size` bytes at `data`, which need not be aligned and may be freed
 * afterwards. `name` begins messages. It refuses a volume of more bytes than the limit of the
 * context before it allocates memory. The caller frees *out. Errors: those of cvol_array_read but
 * IO. */
CVOL_API int cvol_array_read_memory(cvol_context *context, cvol_array **out, const void *data,
                                    size_t size, const char *name);

/* The part of a file to read. With all fields but `size` zero: the whole file. */
typedef struct cvol_file_part {
    size_t size; /* sizeof(cvol_file_part) */
    /* The box of samples [begin, end) (x, y, z); NULL: all. For a volume in DCT blocks only the
     * bricks that touch it are read, checked and decoded. The array has the grid of the file;
     * samples of other bricks evaluate to a constant, so read only samples within the box. The
     * array counts only the coefficients that it has. */
    const size_t *begin, *end;
    /* 0: all coefficients. Level 1, 2, 3 of a volume in DCT blocks: those of the lowest 1/2, 1/4,
     * 1/8 of the frequencies along each axis, which stand first in the file; the rest of the file
     * is not read. l2_error, point_error and max_abs include the missing coefficients. Labels that
     * are coded as samples have no levels: they are read whole. */
    int level;
    /* 1: if the file of a volume ends early, read the finest complete level (no finer than `level`)
     * instead of failing. If only the residual is missing, this is level 0 without it: its numbers
     * are those of the terms alone, not measured. */
    int cut;
    /* The volume of a series (cvol/series.h), from 0; other files have one time and one channel. */
    int time, channel;
    /* 1: the array of a box also has the ranges of all blocks of the file, which the engine sheet
     * needs; without them it finds those of the box by decoding it. */
    int with_ranges;
    /* The level of each brick of a volume in DCT blocks, `level` to 3, in the order of the file
     * (doc/format.md, section 6); NULL: `level` for all of them. Without a box. Of a brick only the
     * coefficients of its level are read and checked, so the rest of the file need not be there.
     * Like a coarse level, the array is without the residual, and l2_error and max_abs include the
     * missing coefficients of the coarsest brick. Labels that are coded as samples, packed files
     * and other arrays have no such part. */
    const uint8_t *brick_levels;
    size_t brick_count; /* the number of all bricks */
} cvol_file_part;
/* A part in a call, in C: CVOL_FILE_PART(.level = 1). */
#define CVOL_FILE_PART(...) (&(const cvol_file_part){.size = sizeof(cvol_file_part), __VA_ARGS__})

/* Results of reading. */
typedef struct cvol_file_report {
    uint64_t file_bytes;  /* of one volume of a series: its own bytes */
    int level;            /* level of the array */
    int cut;              /* 1: the file ends early */
    int residual_missing; /* 1: the file has a residual, which makes samples exact or keeps the
                             maximum error, but it ends within it or the part is a coarse level; all
                             numbers of the array are those without it */
} cvol_file_report;

/* Reads a part of a .cvol file. Arrays other than volumes in DCT blocks are read whole. The file is
 * mapped: only the needed bytes are read. The caller frees *out. part and report may be NULL.
 * Errors: those of cvol_array_read, and ARGUMENT (the box is empty, reversed or outside; no such
 * level, time or channel). */
CVOL_API int cvol_array_read_part(cvol_context *context, cvol_array **out, cvol_file_report *report,
                                  const char *path, const cvol_file_part *part);

/* Reads a box at level 0. file_bytes may be NULL. Errors: those of cvol_array_read_part. */
CVOL_API int cvol_array_read_box(cvol_context *context, cvol_array **out, const char *path,
                                 const size_t begin[3], const size_t end[3], uint64_t *file_bytes);

/* Reads only the grid of a .cvol file, from its header. part (may be NULL) chooses time and
 * channel; its other fields do not matter. Errors: those of cvol_array_read_part. */
CVOL_API int cvol_file_read_grid(cvol_context *context, cvol_grid *out, const char *path,
                                 const cvol_file_part *part);

/* ---- sections of a file -------------------------------------------------------------------- */

/* State of a section. */
typedef enum cvol_section_state {
    CVOL_SECTION_SOUND = 0, /* all its checksums are right */
    CVOL_SECTION_DAMAGED =
        1, /* a checksum of its header, its content or a run of bricks is wrong */
    CVOL_SECTION_TRUNCATED = 2, /* the file ends within it */
    CVOL_SECTION_UNCHECKED = 3  /* its checksums are in a damaged section */
} cvol_section_state;

/* "sound", "damaged", "truncated", "not checked"; NULL for an invalid state. */
CVOL_API const char *cvol_section_state_name(cvol_section_state state);

/* A section of a file. */
typedef struct cvol_file_section {
    char tag[5];    /* "HEAD", ...; '?' for a byte that cannot be printed */
    uint32_t flags; /* bit 0: readers must understand the section */
    /* Place of its header in the file; the content begins 24 bytes later. In packed files, whose
     * first section is PACK, other sections have no headers: for subbands, MASK and CORR this is
     * the place of their first byte, for sections before them that of PACK. */
    uint64_t offset;
    uint64_t length;     /* bytes of its content, unpacked, by its header */
    const char *content; /* description; static storage */
    cvol_section_state state;
} cvol_file_section;

/* The largest number of sections in a layout. */
enum { CVOL_FILE_SECTIONS_MAX = 64 };

/* The sections of a file. */
typedef struct cvol_file_layout {
    uint64_t file_bytes;
    uint32_t version;  /* version of the format */
    int section_count; /* at most CVOL_FILE_SECTIONS_MAX; further sections are checked, but not
                          listed */
    cvol_file_section sections[CVOL_FILE_SECTIONS_MAX]; /* in the order of the file */
    int level; /* volumes in DCT blocks: the finest level whose sections are sound; -1: none */
} cvol_file_layout;

/* Finds the sections of a .cvol file and checks every checksum: of headers, of contents, and of
 * each run of bricks. The message names the first damage: section, byte, difference. *out has the
 * sections found so far, even after an error. Cost: one pass over the file, which it holds in
 * memory. Errors: IO, FORMAT (not a .cvol file), CORRUPT, UNSUPPORTED (its version), MEMORY. */
CVOL_API int cvol_file_read_layout(cvol_context *context, cvol_file_layout *out, const char *path);

/* The same, and decodes the file: cvol_array_read succeeds after it. out may be NULL. Cost: that of
 * cvol_array_read and one more pass over the file. Errors: those of both. */
CVOL_API int cvol_file_verify(cvol_context *context, cvol_file_layout *out, const char *path);

/* Kinds of files. */
typedef enum cvol_file_kind {
    CVOL_FILE_OTHER = 0,   /* another file, or unreadable */
    CVOL_FILE_ARRAY = 1,   /* an array: cvol_array_read */
    CVOL_FILE_PICTURE = 2, /* a compressed picture: cvol/picture.h */
    CVOL_FILE_BAKED = 3,   /* a baked volume: cvol/baked.h */
    CVOL_FILE_SERIES = 4   /* several arrays: cvol/series.h */
} cvol_file_kind;
/* The kind of a file, by its first bytes. */
CVOL_API cvol_file_kind cvol_file_kind_of(const char *path);

/* The same, but a file that exists and cannot be read is an error, and not OTHER. A path that names
 * no regular file is OTHER. Errors: IO. */
CVOL_API int cvol_file_read_kind(cvol_context *context, cvol_file_kind *out, const char *path);

/* 1 if the file begins with the signature of .cvol files; 0 if not, or unreadable. */
CVOL_API int cvol_file_is_cvol(const char *path);

#ifdef __cplusplus
}
#endif
#endif
