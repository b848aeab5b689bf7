/* Walks the pieces of a box (pieces.h). */
#include "array/evaluate/pieces.h"

#include "base/context.h"

static size_t least_of(size_t a, size_t b)
{
    return a < b ? a : b;
}

/* The first sample of the next piece along an axis. */
static size_t after(size_t at, size_t side)
{
    return (at / side + 1) * side;
}

int cvol_pieces_walk(cvol_context *context, cvol_piece_fn *add, void *user, const size_t begin[3],
                     const size_t end[3])
{
    size_t at[3];
    for (at[2] = begin[2]; at[2] < end[2]; at[2] = after(at[2], CVOL_PIECE_Z))
        for (at[1] = begin[1]; at[1] < end[1]; at[1] = after(at[1], CVOL_PIECE_Y))
            for (at[0] = begin[0]; at[0] < end[0]; at[0] = after(at[0], CVOL_PIECE_X)) {
                const size_t stop[3] = {least_of(after(at[0], CVOL_PIECE_X), end[0]),
                                        least_of(after(at[1], CVOL_PIECE_Y), end[1]),
                                        least_of(after(at[2], CVOL_PIECE_Z), end[2])};
                const double done = (double)(at[2] - begin[2]) / (double)(end[2] - begin[2]);
                int code = cvol_report_progress(context, "measuring", done);
                if (!code)
                    code = add(context, user, at, stop);
                if (code)
                    return code;
            }
    return cvol_report_progress(context, "measuring", 1);
}
