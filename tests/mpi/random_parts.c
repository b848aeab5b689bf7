/* Images of parts: random_parts.h. */
#include "mpi/random_parts.h"

#include <stdlib.h>

/* ---- images -------------------------------------------------------------------------------- */

static int is_grey(cvol_mode mode)
{
    return mode == CVOL_MODE_MIP || mode == CVOL_MODE_MIN || mode == CVOL_MODE_XRAY;
}

static float *pixel(const cvol_sheet_lines *lines, size_t g, size_t i)
{
    return lines->values + lines->stride * g + i;
}

void parts_clear(const cvol_sheet_lines *lines, cvol_mode mode)
{
    for (size_t g = 0; g < lines->groups; g++)
        for (size_t i = 0; i < lines->count; i++)
            for (size_t k = 0; k < 4; k++)
                pixel(lines, g, i)[k * lines->count] = k == 3 && !is_grey(mode);
}

void parts_set(const cvol_sheet_lines *lines, size_t g, size_t i, cvol_mode mode, random_state *r)
{
    const size_t n = lines->count;
    float *p = pixel(lines, g, i);
    if (is_grey(mode)) {
        p[0] = (float)random_signed(r);
        p[n] = (float)(1 + random_below(r, 1000)) / 100;
        return;
    }
    const float opacity = random_below(r, 8) ? (float)(1 + random_below(r, 1000)) / 1000 : 1;
    for (size_t k = 0; k < 3; k++)
        p[k * n] = opacity * (float)random_below(r, 1001) / 1000;
    p[3 * n] = 1 - opacity;
}

void parts_fill(const cvol_sheet_lines *lines, const size_t begin[2], const size_t end[2],
                double share, cvol_mode mode, random_state *r)
{
    for (size_t g = begin[1]; g < end[1]; g++)
        for (size_t i = begin[0]; i < end[0]; i++)
            if (random_below(r, 1000) < 1000 * share)
                parts_set(lines, g, i, mode, r);
}

/* ---- the oracle ---------------------------------------------------------------------------- */

/* Elements are pixels of four floats. `in` is before `inout`. */
static void put_over(void *in, void *inout, int *count, MPI_Datatype *type)
{
    const float *front = in;
    float *back = inout;
    (void)type;
    for (int i = 0; i < *count; i++, front += 4, back += 4) {
        for (int k = 0; k < 3; k++)
            back[k] = front[k] + front[3] * back[k];
        back[3] *= front[3];
    }
}

static void keep_extreme(const float *a, float *b, int count, int is_least)
{
    for (int i = 0; i < count; i++, a += 4, b += 4) {
        if (!(a[1] > 0))
            continue;
        if (!(b[1] > 0) || (is_least ? a[0] < b[0] : a[0] > b[0]))
            b[0] = a[0];
        if (a[1] > b[1])
            b[1] = a[1];
    }
}

static void keep_largest(void *in, void *inout, int *count, MPI_Datatype *type)
{
    (void)type;
    keep_extreme(in, inout, *count, 0);
}

static void keep_least(void *in, void *inout, int *count, MPI_Datatype *type)
{
    (void)type;
    keep_extreme(in, inout, *count, 1);
}

static void add(void *in, void *inout, int *count, MPI_Datatype *type)
{
    (void)type;
    for (int i = 0; i < 4 * *count; i++)
        ((float *)inout)[i] += ((float *)in)[i];
}

static MPI_User_function *operator_of(cvol_mode mode)
{
    return mode == CVOL_MODE_MIP    ? keep_largest
           : mode == CVOL_MODE_MIN  ? keep_least
           : mode == CVOL_MODE_XRAY ? add
                                    : put_over;
}

/* Between the lines and pixels of four floats. */
static void copy(const cvol_sheet_lines *lines, float *pixels, int is_back)
{
    for (size_t g = 0; g < lines->groups; g++)
        for (size_t i = 0; i < lines->count; i++)
            for (size_t k = 0; k < 4; k++, pixels++) {
                float *value = pixel(lines, g, i) + k * lines->count;
                *(is_back ? value : pixels) = *(is_back ? pixels : value);
            }
}

void parts_reduce(const cvol_sheet_lines *lines, cvol_mode mode, int root, MPI_Comm ordered)
{
    const size_t count = lines->groups * lines->count;
    float *own = malloc(4 * count * sizeof *own), *all = malloc(4 * count * sizeof *all);
    int rank;
    MPI_Datatype type;
    MPI_Op op;
    if (!own || !all)
        MPI_Abort(ordered, 1);
    MPI_Comm_rank(ordered, &rank);
    MPI_Type_contiguous(4, MPI_FLOAT, &type);
    MPI_Type_commit(&type);
    MPI_Op_create(operator_of(mode), operator_of(mode) != put_over, &op);
    copy(lines, own, 0);
    MPI_Reduce(own, all, (int)count, type, op, root, ordered);
    if (rank == root)
        copy(lines, all, 1);
    MPI_Op_free(&op);
    MPI_Type_free(&type);
    free(own);
    free(all);
}
