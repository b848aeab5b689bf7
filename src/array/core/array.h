/* Internals of the compressed array: a whole array's spectrum (block 0), or blocks.
 *
 * Blocks are numbered x fastest: block (i, j, l) has index i + blocks[0] (j + blocks[1] l). A block
 * is a list of terms, one 32-bit word each: the low `place_bits` bits hold the coefficient's place
 * u + B v + B^2 w (v = w = 0 beyond the rank), the rest its quantized value as a signed number. A
 * value that does not fit is an escape word (the most negative value) followed by one word with the
 * value itself. Places rise strictly within a block. A coefficient is value times step.
 *
 * The decoded samples are `offset` plus the inverse transform of the terms, post-filtered for
 * lapped volumes. */
#ifndef CVOL_ARRAY_CORE_ARRAY_H
#define CVOL_ARRAY_CORE_ARRAY_H

#include "array/core/error_bound.h"
#include "array/core/mask.h"
#include "array/core/residual.h"
#include "array/core/spectrum.h"
#include "cvol/algebra.h"
#include "cvol/array.h"

typedef struct cvol_block {
    const uint32_t *terms; /* words; owned by the array's pools */
    uint32_t words;        /* number of words, escapes included */
    uint8_t low[3];        /* per axis 1 + the highest frequency with a term; 0 if none */
    uint8_t range[2];      /* bounds of the block's decoded samples, see cvol_array_range */
    uint16_t split;        /* B = 16: the split of the block (transform/cell.h); 0: none */
} cvol_block;

/* The end of its terms. A block without terms may have NULL, to which nothing can be added. */
static inline const uint32_t *cvol_block_end(const cvol_block *block)
{
    return block->words ? block->terms + block->words : block->terms;
}

/* Samples along each axis of the bricks in which a file codes a volume, unless its array specifies
 * fewer; never more. */
enum { CVOL_BRICK_SIDE = 64 };

/* Codec data of an array. src/array only frees and copies it. */
typedef struct cvol_coding cvol_coding;
typedef struct cvol_coding_ops {
    void (*destroy)(cvol_coding *coding);
    /* Makes the coding of a result: bricks from `bricks`, the coding of terms from `terms`; NULL
     * for one of them: the default. Returns NULL if memory is short. */
    cvol_coding *(*make)(const cvol_coding *bricks, const cvol_coding *terms);
    void (*brick_sides)(size_t side[3], const cvol_coding *coding);
    /* The terms' step is the step of quantization divided by 2 to this power. */
    int (*finer_bits)(const cvol_coding *coding);
} cvol_coding_ops;
struct cvol_coding {
    const cvol_coding_ops *ops; /* the codec's data follow (codec/quantize/coding.h) */
};

struct cvol_summary;

struct cvol_array {
    cvol_grid grid;
    int rank;
    cvol_transform transform;
    cvol_spectrum whole; /* block 0 only */
    cvol_error_bound error_bound;
    int measured; /* 1: the next two are measured; 0: they follow from the error bound */
    double psnr_db, max_error; /* of the samples in the stored type */
    int is_of_exact; /* terms of the samples of an exact array (decoded_terms.h): their own error is
                        no error of the data */
    double threshold;             /* terms smaller than this were dropped; 0: none */
    cvol_coding *coding;          /* NULL: the default */
    char *attributes;             /* JSON text, or NULL: of the volume's file */
    double offset;                /* added to every sample; whole arrays: 0 */
    struct cvol_summary *summary; /* volumes: the distribution of the original samples; or NULL */
    /* Volumes only: samples without a value, which evaluate to their fills; both may be NULL. */
    cvol_mask *mask;
    cvol_residual *residual;
    /* blocks only: */
    int block;      /* B; 0: whole */
    int block_log2; /* 3, 4 or 5 */
    size_t blocks[3], block_count;
    double step;
    int lapped; /* rank 3, DCT, B = 16: evaluated blocks are then post-filtered across their faces
                   (transform/lap.h, grid 16), along x, then y, then z */
    int has_ranges;              /* 1 if the next two and the blocks' range codes are known */
    double range_min, range_max; /* the values of range codes 0 and 255 */
    cvol_block *block_table;
    uint32_t **pools; /* memory of the terms */
    size_t pool_count, pool_capacity;
    uint64_t coefficients, pool_words;
};

/* The size of an array's description in budgets and resident_bytes. It is not exact, so that
 * results do not depend on the layout of the struct. */
enum { CVOL_ARRAY_BYTES = 600 };

/* Makes an array of this grid in blocks of B = 8, 16 or 32, without terms; step 1, offset 0.
 * Errors: ARGUMENT, MEMORY, and as cvol_grid_check. */
int cvol_array_create(cvol_context *context, cvol_array **out, const cvol_grid *grid, int block);
/* The same for any rank, transform and block; 0: a whole array without terms. */
int cvol_array_create_as(cvol_context *context, cvol_array **out, const cvol_grid *grid, int rank,
                         cvol_transform transform, int block);
/* Sets the coding of a result with the bricks of one array and the terms, up to a factor, of
 * another one (NULL: neither). Errors: MEMORY. */
int cvol_array_set_coding(cvol_context *context, cvol_array *array, const cvol_array *bricks,
                          const cvol_array *terms);
/* The step with which the terms were quantized. */
double cvol_array_quantised_step(const cvol_array *array);

/* Frees mask and residual. */
void cvol_array_drop_residual(cvol_array *array);

/* An empty array of the same shape, for a result: sample type float32, value scale 1. */
int cvol_array_create_like(cvol_context *context, cvol_array **out, const cvol_array *like);

/* Returns 1 if it is a volume (rank 3, DCT, blocks), which can be rendered and coded in bricks. */
int cvol_array_is_volume(const cvol_array *array);
/* The value of a separate background; 0 if there is none. */
double cvol_array_background(const cvol_array *array);
/* Refuses arrays that are not volumes: UNSUPPORTED, with advice. `what`: "the sheet engine", "a
 * .cvol file". */
int cvol_array_need_volume(cvol_context *context, const cvol_array *array, const char *what);
/* Attributes are texts, not data. */
enum { CVOL_ATTRIBUTES_MAX = 16 << 20 };
/* Returns 1 if the bytes are UTF-8 without a zero. */
int cvol_attributes_are_text(const char *text, size_t size);
/* Sets an array's attributes without a check. Errors: MEMORY. */
int cvol_array_keep_attributes(cvol_context *context, cvol_array *array, const char *text,
                               size_t size);
/* The number of samples that have a value: all but those of a mask of missing samples. */
size_t cvol_array_valued_samples(const cvol_array *array);
/* Derives psnr_db and max_error from the error bound. The mask must be set before: missing samples
 * have no error, and the PSNR is of the others. */
void cvol_array_derive_figures(cvol_array *array);
/* Estimates, for pictures, the RMS of the difference between the exact samples and the array's
 * terms plus offset. It is not a bound: the rounding of samples to single precision, which depends
 * on the offset, does not count, because pictures are drawn from terms. */
double cvol_array_rms_error(const cvol_array *array);
/* B^rank. */
size_t cvol_array_block_terms(const cvol_array *array);
/* Bounds the coefficients of an array of this shape whose samples are within
 * error_bound.max_abs. */
double cvol_array_coefficient_bound(const cvol_array *array);
/* Returns 1 if any block is split (transform/cell.h). */
int cvol_array_has_splits(const cvol_array *array);

/* Samples that a block covers along an axis: B, or 1 beyond the rank. */
static inline size_t cvol_block_side(const cvol_array *array, int axis)
{
    return axis < array->rank ? (size_t)array->block : 1;
}

/* The first sample (x, y, z) of block `index`. */
static inline void cvol_block_origin(size_t at[3], const cvol_array *array, size_t index)
{
    at[0] = index % array->blocks[0] * cvol_block_side(array, 0);
    at[1] = index / array->blocks[0] % array->blocks[1] * cvol_block_side(array, 1);
    at[2] = index / array->blocks[0] / array->blocks[1] * cvol_block_side(array, 2);
}

/* Passes `words` words of terms, allocated with malloc, to the array, which frees them. On failure
 * the caller keeps them. Not thread-safe. Errors: MEMORY. */
int cvol_array_adopt_pool(cvol_context *context, cvol_array *array, uint32_t *terms, size_t words);

/* ---- terms ------------------------------------------------------------------------------ */

static inline int cvol_place_bits(int block_log2)
{
    return 3 * block_log2;
}

/* The escape value: the most negative one in the upper bits. */
static inline int32_t cvol_term_escape(int place_bits)
{
    return -(INT32_C(1) << (31 - place_bits));
}

/* Writes a term, value != 0, to words[0 .. 1]; returns the number of words. */
static inline uint32_t cvol_term_pack(uint32_t *words, uint32_t place, int32_t value,
                                      int place_bits)
{
    int32_t escape = cvol_term_escape(place_bits);
    if (value > escape && value < -escape) {
        words[0] = (uint32_t)value << place_bits | place;
        return 1;
    }
    words[0] = (uint32_t)escape << place_bits | place;
    words[1] = (uint32_t)value;
    return 2;
}

/* Reads the term at *words, moves *words behind it. */
static inline int32_t cvol_term_unpack(const uint32_t **words, uint32_t *place, int place_bits)
{
    uint32_t word = *(*words)++;
    *place = word & ((UINT32_C(1) << place_bits) - 1);
    int32_t value = (int32_t)word >> place_bits;
    if (__builtin_expect(value == cvol_term_escape(place_bits), 0))
        value = (int32_t) * (*words)++;
    return value;
}

/* Sets `low` of a block from its terms. */
void cvol_block_find_low(cvol_block *block, int block_log2);

/* ---- blocks and samples ----------------------------------------------------------------- */

/* Reads block `index` of dense samples as floats, minus `offset`, into out[B^3] (x fastest). Beyond
 * the volume's faces the last sample is repeated: this extension has the smallest gradient, so it
 * costs the fewest coefficients. */
void cvol_block_gather(float *out, const void *samples, const cvol_grid *grid, int block,
                       size_t index, double offset);
/* The same for blocks of any rank: out[B^rank], minus shape->offset. */
void cvol_array_gather(float *out, const void *samples, const cvol_array *shape, size_t index);

/* Samples first .. first + count - 1 of any type as floats, minus `offset`. */
void cvol_samples_load(float *out, const void *samples, cvol_type type, size_t first, size_t count,
                       double offset);
/* Finds the least and largest sample. Errors: DATA (NaN or infinite samples). */
int cvol_scan_samples(cvol_context *context, double *min, double *max, const void *samples,
                      const cvol_grid *grid);
/* The same for part of a volume, with its grid, that begins at a slice: for messages. */
int cvol_scan_slices(cvol_context *context, double *min, double *max, const void *samples,
                     const cvol_grid *grid, size_t first_slice);

/* Evaluates block `index`, as floats without `offset`, into out[B^rank] (x fastest, 64-byte
 * aligned), with the kernel that gives the same bits on every processor. Not filtered: for the
 * samples of lapped volumes see array/block/lapped.h and array/block/halo.h. */
void cvol_block_evaluate(float *out, const cvol_array *array, size_t index);

/* Converts float samples without `offset` to the grid's type as cvol_array_evaluate_box
 * documents. */
void cvol_samples_store(void *out, const float *in, size_t count, const cvol_array *array);

/* Evaluates every block and sets range_min, range_max and each block's range codes (rounded
 * outwards, so that skipping by them is safe); for lapped volumes the ranges of the samples within
 * the volume. Errors: MEMORY, CANCELLED. */
int cvol_array_find_ranges(cvol_context *context, cvol_array *array);
/* The same from the least and the largest sample of every block, without `offset`. */
void cvol_array_set_ranges(cvol_array *array, const float (*of)[2]);

/* Widens range_min .. range_max, to which the codes of blocks refer, to contain least .. most. */
void cvol_array_widen_range(cvol_array *array, double least, double most);

/* Receives the least and the largest sample of a box, or a code if they could not be found, and
 * widens them. */
typedef int cvol_range_widen(cvol_context *context, void *user, int code, double range[2]);
/* The same for the blocks of a box of samples [begin, end) alone; those of others stay. Sets
 * has_ranges: nothing may be drawn outside of the box. Memory: 40 bytes a block of the box. */
int cvol_array_find_box_ranges(cvol_context *context, cvol_array *array, const size_t begin[3],
                               const size_t end[3], cvol_range_widen *widen, void *user);

/* As cvol_array_find_ranges, and lowers max_abs accordingly. Files and the sheet engine call it if
 * has_ranges is 0. Operations do not, since it evaluates every block. Errors: MEMORY, CANCELLED. */
int cvol_array_ensure_ranges(cvol_context *context, cvol_array *array);
/* An array in blocks with a separate block table and the terms of `array`, which must outlive it.
 * The caller frees it with cvol_array_free. Errors: MEMORY. */
int cvol_array_share(cvol_context *context, cvol_array **out, const cvol_array *array);

/* The bounds of a block's decoded samples. */
static inline void cvol_array_range(const cvol_array *array, size_t index, double *lo, double *hi)
{
    const cvol_block *block = &array->block_table[index];
    double unit = (array->range_max - array->range_min) / 255;
    *lo = array->range_min + unit * block->range[0];
    *hi = array->range_min + unit * block->range[1];
}

#endif
