/* Reads the part of a volume that one process of a team computes on (cvol/mpi.h). */
#include "array/core/share.h"
#include "base/context.h"
#include "cvol/mpi.h"

/* Blocks that operations take together, at most (build.c: 2^17 terms in blocks of 8). */
enum { TOGETHER = 256 };

static const cvol_file_part all = {.size = sizeof all};

static int refuse(cvol_context *context, const char *path)
{
    return cvol_fail(context, CVOL_ERROR_UNSUPPORTED,
                     "%s: is no volume in dct blocks, which several processes can share: use one "
                     "process",
                     path);
}

/* The array with the terms of one sample, to find its kind; the caller frees it. */
static int probe(cvol_context *context, cvol_array **out, const char *path,
                 const cvol_file_part *part)
{
    static const size_t zero[3] = {0, 0, 0}, one[3] = {1, 1, 1};
    cvol_file_part first = part ? *part : all;
    first.begin = zero;
    first.end = one;
    int code = cvol_array_read_part(context, out, NULL, path, &first);
    return !code && !cvol_array_is_volume(*out) ? refuse(context, path) : code;
}

/* The slices of the blocks that operations read for the blocks of the share. */
static void widen(size_t begin[3], size_t end[3], const cvol_share *share, const cvol_array *array)
{
    const size_t planes = TOGETHER / (array->blocks[0] * array->blocks[1]) + 2;
    const size_t margin = planes * (size_t)array->block + CVOL_BRICK_SIDE;
    for (int a = 0; a < 3; a++) {
        begin[a] = 0;
        end[a] = array->grid.dims[a];
    }
    begin[2] = share->slices[0] > margin ? share->slices[0] - margin : 0;
    end[2] = share->slices[1] + margin < end[2] ? share->slices[1] + margin : end[2];
}

static uint64_t count_terms(const cvol_array *array, const cvol_share *share)
{
    const int place_bits = cvol_place_bits(array->block_log2);
    uint64_t count = 0;
    for (size_t i = share->blocks[0]; i < share->blocks[1]; i++) {
        const cvol_block *block = &array->block_table[i];
        const uint32_t *words = block->terms, *end = cvol_block_end(block);
        uint32_t place;
        for (; words < end; count++)
            (void)cvol_term_unpack(&words, &place, place_bits);
    }
    return count;
}

static int read_share(cvol_context *context, cvol_array **out, cvol_file_report *report,
                      const char *path, const cvol_file_part *part, const cvol_share *share,
                      const cvol_array *like)
{
    size_t begin[3], end[3];
    cvol_file_part own = *part;
    widen(begin, end, share, like);
    own.begin = begin;
    own.end = end;
    own.with_ranges = 1;
    int code = cvol_array_read_part(context, out, report, path, &own);
    uint64_t count = code ? 0 : count_terms(*out, share);
    code = cvol_team_add(context, share->team, code, &count);
    if (!code)
        (*out)->coefficients = count;
    return code;
}

int cvol_mpi_array_check(cvol_context *context, const char *path, const cvol_file_part *part)
{
    cvol_array *like = NULL;
    const int code = probe(context, &like, path, part);
    cvol_array_free(like);
    return code;
}

int cvol_mpi_array_read(cvol_context *context, cvol_array **out, cvol_file_report *report,
                        const char *path, const cvol_file_part *part)
{
    cvol_array *like = NULL;
    *out = NULL;
    part = part ? part : &all;
    int code = probe(context, &like, path, part);
    if (!code) {
        const cvol_share share = cvol_share_of(context, like);
        code = share.team && !like->mask && !like->residual
                   ? read_share(context, out, report, path, part, &share, like)
                   : cvol_array_read_part(context, out, report, path, part);
    }
    cvol_array_free(like);
    if (code) {
        cvol_array_free(*out);
        *out = NULL;
    }
    return code;
}
