/* Reads the part of a volume that one process of a team computes on, and finds the ranges of the
 * part that it draws (cvol/mpi.h). */
#include "array/core/share.h"
#include "array/evaluate/box.h"
#include "base/context.h"
#include "cvol/mpi.h"

/* Runs of blocks that operations work on begin and end outside a share: of 2^17 terms (build.c), or
 * of 64 blocks (blocks_sums.c). */
enum { RUN_TERMS = 1 << 17, RUN_BLOCKS = 64 };

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

/* The slices around a share that operations read: of runs of blocks, of the layers that lapped
 * blocks and their results depend on, and of the last brick. */
static size_t margin_of(const cvol_array *array)
{
    const size_t terms = cvol_array_block_terms(array), plane = array->blocks[0] * array->blocks[1];
    const size_t run = RUN_TERMS / terms > RUN_BLOCKS ? RUN_TERMS / terms : RUN_BLOCKS;
    cvol_array_info info;
    cvol_array_get_info(&info, array);
    const size_t brick = CVOL_BRICK_SIDE % info.brick[2] ? info.brick[2] : 0;
    return ((run - 1) / plane + 3) * (size_t)array->block + brick;
}

static void widen(size_t begin[3], size_t end[3], const cvol_share *share, const cvol_array *array)
{
    const size_t margin = margin_of(array);
    for (int a = 0; a < 3; a++) {
        begin[a] = 0;
        end[a] = array->grid.dims[a];
    }
    begin[2] = share->slices[0] > margin ? share->slices[0] - margin : 0;
    end[2] = share->slices[1] + margin < end[2] ? share->slices[1] + margin : end[2];
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
    const int code = cvol_array_read_part(context, out, report, path, &own);
    return code ? code : cvol_share_count_terms(context, &(*out)->coefficients, *out);
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

/* ---- ranges of parts ------------------------------------------------------------------------- */

static int widen_range(cvol_context *context, void *user, int code, double range[2])
{
    const MPI_Comm *comm = user;
    double most[2] = {-range[0], range[1]};
    int rank;
    code = cvol_mpi_agree(context, code, &rank, *comm);
    if (code)
        return code;
    MPI_Allreduce(MPI_IN_PLACE, most, 2, MPI_DOUBLE, MPI_MAX, *comm);
    range[0] = -most[0];
    range[1] = most[1];
    return CVOL_OK;
}

int cvol_mpi_array_find_ranges(cvol_context *context, cvol_array *array, const size_t begin[3],
                               const size_t end[3], MPI_Comm comm)
{
    int rank, lacks = !array->has_ranges;
    int code = cvol_array_check_box(context, array, begin, end);
    code = cvol_mpi_agree(context, code, &rank, comm);
    if (code)
        return code;
    MPI_Allreduce(MPI_IN_PLACE, &lacks, 1, MPI_INT, MPI_MAX, comm);
    return lacks ? cvol_array_find_box_ranges(context, array, begin, end, widen_range, &comm)
                 : CVOL_OK;
}
