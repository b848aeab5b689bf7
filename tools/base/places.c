/* Notes about pairs of volumes that do not lie at the same place. */
#include <math.h>
#include <stdio.h>

#include "tools/base/cli.h"

static int differ(double a, double b, double unit)
{
    return !(fabs(a - b) <= 1e-4 * unit);
}

static int lie_elsewhere(const cvol_grid *a, const cvol_grid *b)
{
    /* Without a patient's space, origins are often lost. */
    if (a->space == CVOL_SPACE_UNKNOWN || b->space == CVOL_SPACE_UNKNOWN)
        return 0;
    for (int i = 0; i < 3; i++) {
        /* LPS and RAS have opposite X and Y. */
        const double sign = a->space != b->space && i < 2 ? -1 : 1;
        if (differ(a->origin[i], sign * b->origin[i], fmin(a->spacing[0], b->spacing[0])))
            return 1;
        for (int axis = 0; axis < 3; axis++)
            if (differ(a->direction[axis][i], sign * b->direction[axis][i], 1))
                return 1;
    }
    return 0;
}

void note_places(const char *const paths[2], const cvol_grid *a, const cvol_grid *b)
{
    if (!lie_elsewhere(a, b))
        return;
    clear_progress();
    fprintf(stderr,
            "cvol: %s and %s lie at different places (origin or direction): samples are paired by "
            "their indices\n",
            paths[0], paths[1]);
}

void note_values(const char *const paths[2], const cvol_grid *a, const cvol_grid *b)
{
    if (!differ(a->value_scale, b->value_scale, 0) && !differ(a->value_offset, b->value_offset, 0))
        return;
    clear_progress();
    fprintf(
        stderr,
        "cvol: %s and %s state different slopes or intercepts: stored samples are compared, not "
        "the values that they mean\n",
        paths[0], paths[1]);
}
