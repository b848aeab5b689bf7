/* The choice of the axes of an array that make a volume. */
#include "volume/io/axes.h"

#include "base/context.h"
#include "volume/io/format.h"

#define COLOURS_MAX 4

/* Axes of channels and of volumes, -1: there is none; and the number of leading axes that must have
 * size 1. */
typedef struct leading {
    int channel, index, front;
} leading;

static leading find_leading(const cvol_axes *a, int z)
{
    leading l = {-1, -1, 0};
    int first = 0, last = z - 1; /* remaining axes in front of z */
    while (first < last && a->dims[first] == 1)
        first++;
    if (a->rank - z == 4)
        l.channel = a->rank - 1;
    else if (last > first)
        l.channel = last--;
    if (last >= first)
        l.index = last--;
    l.front = last + 1;
    return l;
}

static int choose(cvol_context *context, cvol_axes *a, int axis, const char *path, const char *what,
                  const char *option, int has_choice, int choice)
{
    size_t chosen;
    int code = cvol_format_choose(context, &chosen, path, what, option,
                                  axis < 0 ? 1 : (size_t)a->dims[axis], has_choice, choice);
    if (axis >= 0)
        a->begin[axis] = chosen;
    return code;
}

int cvol_axes_choose(cvol_context *context, cvol_axes *axes, cvol_grid *grid, const char *path,
                     const cvol_read_options *options)
{
    const int rank = axes->rank;
    const int has_colours = rank > 3 && axes->dims[rank - 1] <= COLOURS_MAX;
    const int end = rank - has_colours, z = end - 3;
    for (int i = 0; i < CVOL_AXES_MAX; i++)
        axes->begin[i] = 0;
    for (int i = 0; i < rank; i++) {
        const int code = cvol_check_size(context, path, "the length of an axis", axes->dims[i]);
        if (code)
            return code;
    }
    for (int i = 0; i < 3; i++) {
        axes->of[i] = end - 1 - i >= 0 ? end - 1 - i : -1;
        grid->dims[i] = axes->of[i] >= 0 ? (size_t)axes->dims[axes->of[i]] : 1;
    }
    const leading l = find_leading(axes, z < 0 ? 0 : z);
    for (int i = 0; i < l.front; i++)
        if (axes->dims[i] != 1)
            return cvol_fail(context, CVOL_ERROR_UNSUPPORTED,
                             "%s: its array has %d axes, and axis %d has %llu places; five can be "
                             "read",
                             path, rank, i, (unsigned long long)axes->dims[i]);
    int code = choose(context, axes, l.channel, path, "channel", "--channel", options->has_channel,
                      options->channel);
    if (!code)
        code = choose(context, axes, l.index, path, "volume", "--time", options->has_index,
                      options->index);
    return code;
}

int cvol_axes_label(cvol_labels *labels, const cvol_axes *axes, cvol_type type)
{
    const int last = axes->rank - 1;
    return type != CVOL_UINT8 || last < 3 || axes->of[0] == last
               ? 1
               : cvol_labels_set_colours(labels, (size_t)axes->dims[last]);
}
