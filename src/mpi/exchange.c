/* Intermediate images of several processes put together: exchange.h. */
#include "mpi/exchange.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/context.h"
#include "base/memory.h"
#include "render/view/camera.h"

/* Floats of one reduction. */
#define CHUNK (4 << 20)
/* Values of a pixel. */
#define VALUES 4

/* ---- operators on groups of lines ---------------------------------------------------------- */

/* The operators get groups: their type has the length of one, VALUES lines. */
static size_t count_pixels(MPI_Datatype type)
{
    MPI_Aint low, extent;
    MPI_Type_get_extent(type, &low, &extent);
    return (size_t)extent / (VALUES * sizeof(float));
}

/* `in` is before `inout`: premultiplied colour, and transmittance. */
static void put_over(void *in, void *inout, int *count, MPI_Datatype *type)
{
    const size_t n = count_pixels(*type);
    for (int g = 0; g < *count; g++) {
        const float *front = (const float *)in + VALUES * n * (size_t)g, *through = front + 3 * n;
        float *back = (float *)inout + VALUES * n * (size_t)g;
        for (size_t k = 0; k < 3; k++)
            for (size_t i = 0; i < n; i++)
                back[k * n + i] = front[k * n + i] + through[i] * back[k * n + i];
        for (size_t i = 0; i < n; i++)
            back[3 * n + i] *= through[i];
    }
}

/* A pixel holds a value and the length of its ray; length 0: the ray meets nothing. */
static void keep_extreme(float *kept, const float *other, size_t n, int is_least)
{
    for (size_t i = 0; i < n; i++) {
        if (!(other[n + i] > 0))
            continue;
        if (!(kept[n + i] > 0) || (is_least ? other[i] < kept[i] : other[i] > kept[i]))
            kept[i] = other[i];
        kept[n + i] = fmaxf(kept[n + i], other[n + i]);
    }
}

static void keep_largest(void *in, void *inout, int *count, MPI_Datatype *type)
{
    const size_t n = count_pixels(*type);
    for (size_t g = 0; g < (size_t)*count; g++)
        keep_extreme((float *)inout + VALUES * n * g, (const float *)in + VALUES * n * g, n, 0);
}

static void keep_least(void *in, void *inout, int *count, MPI_Datatype *type)
{
    const size_t n = count_pixels(*type);
    for (size_t g = 0; g < (size_t)*count; g++)
        keep_extreme((float *)inout + VALUES * n * g, (const float *)in + VALUES * n * g, n, 1);
}

/* Sums along rays, and lengths. */
static void add(void *in, void *inout, int *count, MPI_Datatype *type)
{
    const size_t floats = VALUES * count_pixels(*type) * (size_t)*count;
    for (size_t i = 0; i < floats; i++)
        ((float *)inout)[i] += ((const float *)in)[i];
}

static MPI_User_function *operator_of(cvol_mode mode)
{
    return mode == CVOL_MODE_MIP    ? keep_largest
           : mode == CVOL_MODE_MIN  ? keep_least
           : mode == CVOL_MODE_XRAY ? add
                                    : put_over;
}

/* ---- agreement ----------------------------------------------------------------------------- */

static int agree_code(cvol_mpi_exchange *exchange, cvol_context *context, int code)
{
    int rank;
    code = cvol_mpi_agree(context, code, &rank, exchange->comm);
    exchange->has_failed |= code != 0;
    return code;
}

static int agree(void *data, cvol_context *context, int code, size_t *value)
{
    cvol_mpi_exchange *exchange = data;
    unsigned long long largest = *value;
    code = agree_code(exchange, context, code);
    if (code)
        return code;
    MPI_Allreduce(MPI_IN_PLACE, &largest, 1, MPI_UNSIGNED_LONG_LONG, MPI_MAX, exchange->comm);
    *value = (size_t)largest;
    return CVOL_OK;
}

/* Processors with different instruction sets may choose different rays. */
static int check_lines(cvol_context *context, const cvol_mpi_exchange *exchange,
                       const cvol_sheet_lines *lines)
{
    const double own[4] = {(double)lines->groups, (double)lines->count, lines->unit[0],
                           lines->unit[1]};
    double most[8];
    for (int k = 0; k < 4; k++) {
        most[2 * k] = own[k];
        most[2 * k + 1] = -own[k];
    }
    MPI_Allreduce(MPI_IN_PLACE, most, 8, MPI_DOUBLE, MPI_MAX, exchange->comm);
    for (int k = 0; k < 4; k++)
        if (most[2 * k] > -most[2 * k + 1])
            return cvol_fail(context, CVOL_ERROR_ARGUMENT,
                             "the processes chose different rays; if their processors differ, set "
                             "the environment variable CVOL_CPU=base");
    return CVOL_OK;
}

/* ---- pictures ------------------------------------------------------------------------------ */

/* 1 if a pixel of a group shows something. */
static int is_shown(const float *values, size_t n, cvol_mode mode)
{
    const int is_grey = cvol_mode_is_grey(mode);
    const float *line = values + (is_grey ? n : 3 * n), empty = is_grey ? 0 : 1;
    for (size_t i = 0; i < n; i++)
        if (line[i] < empty || line[i] > empty)
            return 1;
    return 0;
}

/* Sets flags[g] to 1 if some process shows something in group g. */
static void find_shown(uint8_t *flags, const cvol_mpi_exchange *exchange,
                       const cvol_sheet_lines *lines, cvol_mode mode)
{
    for (size_t g = 0; g < lines->groups; g++)
        flags[g] = (uint8_t)is_shown(lines->values + lines->stride * g, lines->count, mode);
    MPI_Allreduce(MPI_IN_PLACE, flags, (int)lines->groups, MPI_UNSIGNED_CHAR, MPI_MAX,
                  exchange->comm);
}

/* Copies the groups that show something one behind the other; returns their number. */
static size_t pack(float *packed, const cvol_sheet_lines *lines, const uint8_t *flags)
{
    const size_t size = VALUES * lines->count;
    size_t count = 0;
    for (size_t g = 0; g < lines->groups; g++)
        if (flags[g])
            memcpy(packed + size * count++, lines->values + lines->stride * g,
                   size * sizeof *packed);
    return count;
}

static void unpack(const cvol_sheet_lines *lines, const uint8_t *flags, const float *packed)
{
    const size_t size = VALUES * lines->count;
    size_t count = 0;
    for (size_t g = 0; g < lines->groups; g++)
        if (flags[g])
            memcpy(lines->values + lines->stride * g, packed + size * count++,
                   size * sizeof *packed);
}

static void reduce(const cvol_mpi_exchange *exchange, float *packed, size_t groups, size_t pixels,
                   cvol_mode mode)
{
    const size_t size = VALUES * pixels, most = CHUNK / size + 1;
    const int is_first = exchange->combine.is_first;
    MPI_Datatype type;
    MPI_Op op;
    MPI_Type_contiguous((int)size, MPI_FLOAT, &type);
    MPI_Type_commit(&type);
    MPI_Op_create(operator_of(mode), operator_of(mode) != put_over, &op);
    for (size_t first = 0; first < groups; first += most) {
        const size_t left = groups - first;
        float *chunk = packed + size * first;
        MPI_Reduce(is_first ? MPI_IN_PLACE : chunk, is_first ? chunk : NULL,
                   (int)(left < most ? left : most), type, op, exchange->first, exchange->ordered);
    }
    MPI_Op_free(&op);
    MPI_Type_free(&type);
}

static int combine(void *data, cvol_context *context, int code, const cvol_sheet_lines *lines,
                   cvol_mode mode)
{
    cvol_mpi_exchange *exchange = data;
    const size_t floats = lines->groups * VALUES * lines->count;
    float *packed = code ? NULL : cvol_allocate(floats, sizeof *packed);
    uint8_t *flags = code ? NULL : cvol_allocate(lines->groups, 1);
    if (!code && (!packed || !flags))
        code = cvol_fail_memory(context, floats * sizeof *packed, "a picture of parts");
    code = agree_code(exchange, context, code);
    if (!code)
        code = check_lines(context, exchange, lines);
    exchange->has_failed |= code != 0;
    if (!code) {
        find_shown(flags, exchange, lines, mode);
        reduce(exchange, packed, pack(packed, lines, flags), lines->count, mode);
        if (exchange->combine.is_first)
            unpack(lines, flags, packed);
    }
    free(packed);
    free(flags);
    return code;
}

void cvol_mpi_exchange_begin(cvol_mpi_exchange *exchange, const cvol_mpi_parts *parts, int place,
                             int first, int is_idle)
{
    *exchange = (cvol_mpi_exchange){.combine = {.is_idle = is_idle,
                                                .is_first = parts->rank == 0,
                                                .data = exchange,
                                                .agree = agree,
                                                .combine = combine},
                                    .comm = parts->comm,
                                    .first = first};
    MPI_Comm_split(parts->comm, 0, place, &exchange->ordered);
}

void cvol_mpi_exchange_end(cvol_mpi_exchange *exchange)
{
    MPI_Comm_free(&exchange->ordered);
}
