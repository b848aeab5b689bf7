/* Bounds of one interval of a ray of which the samples are known only within an error. */
#ifndef CVOL_RENDER_RAY_BOUND_H
#define CVOL_RENDER_RAY_BOUND_H

#include "render/ray/envelope.h"
#include "render/ray/light_bound.h"
#include "render/ray/walk.h"

/* The facts about the original samples: each differs from the drawn one by at most `error`, and
 * lies within min .. max. error and the limits include rounding. */
typedef struct cvol_ray_known {
    double error, min, max;
    double rounding; /* of values */
    double cell;     /* at least one cell of the table that engine ray makes for the original */
} cvol_ray_known;

/* Data of all rays of a certified picture. job->table covers min .. max and a margin of four cells
 * at both ends. */
typedef struct cvol_ray_doubt {
    const cvol_ray_job *job;
    cvol_ray_known known;
    cvol_ray_envelope envelope;
} cvol_ray_doubt;

/* A part of the ray whose opacity and colour are within these bounds, independently. Colours
 * include light; the fourth is 1, so that it becomes the opacity of the ray. */
typedef struct cvol_ray_part {
    double opacity[2];   /* least, most */
    double colour[2][4]; /* the same */
} cvol_ray_part;

/* Parts of the range of the middle's value, and of that of an end. */
#define CVOL_RAY_MIDDLES 4
#define CVOL_RAY_ENDS 3

/* Bounds of an interval for one part of the range of its middle: one part (if may_be_smooth), or
 * two halves (if may_be_divided). A half has one entry for each part of the range of its end.
 */
typedef struct cvol_ray_middle {
    cvol_ray_part smooth, halves[2][CVOL_RAY_ENDS];
} cvol_ray_middle;

/* Bounds of an interval: one of `middles` applies. */
typedef struct cvol_ray_bound {
    int may_be_smooth, may_be_divided, middle_count, end_count;
    int may_end;       /* for the caller: the ray may end behind this interval */
    double through[2]; /* the share of light that passes: least, most */
    cvol_ray_middle middles[CVOL_RAY_MIDDLES];
} cvol_ray_bound;

/* Bounds an interval. `through`: the most light that passes what lies in front; less work is done
 * where it is small. Returns 0 if engine ray's tables show that the interval is transparent. */
int cvol_ray_bound_step(cvol_ray_bound *out, const cvol_ray_doubt *doubt, const cvol_ray_step *step,
                        double through);

/* Turns bounds of the light behind an interval into those in front of it: light[0] is the least and
 * light[1] the most, in `count` channels. */
void cvol_ray_bound_apply(double light[2][4], const cvol_ray_bound *bound, int count);

#endif
