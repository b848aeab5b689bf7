/* The path of a ray through the drawn box, and its intervals from front to back. Engine ray and its
 * certified pictures follow rays by this code, so both divide a ray in the same way. */
#ifndef CVOL_RENDER_RAY_WALK_H
#define CVOL_RENDER_RAY_WALK_H

#include <math.h>
#include <string.h>

#include "render/ray/job.h"

/* Samples that are fetched together. */
#define CVOL_RAY_RUN 64

/* A ray within the drawn box: `steps` whole steps and then `rest` of one, 0 < rest <= 1. */
typedef struct cvol_ray_path {
    double entry[3]; /* in sample indices */
    double delta[3]; /* one step */
    size_t steps;
    double rest;
    double depth, rise; /* of the entry, and its change per step */
} cvol_ray_path;

/* Makes the path of pixel (i, j). Returns 1 if it meets the drawn box. */
int cvol_ray_path_make(cvol_ray_path *path, const cvol_ray_job *job, int i, int j);

/* The `count` samples from a place on, in steps along the path, one per step; cover[k]: the share
 * of each that has a value. */
void cvol_ray_fetch(double *out, double *cover, const cvol_ray_job *job, const cvol_ray_path *path,
                    double place, size_t count);

/* A value along the ray, its cover, and its cell of the table. Without a cover it has no value. */
typedef struct cvol_ray_point {
    double value, cover;
    size_t cell;
} cvol_ray_point;

static const cvol_ray_point cvol_ray_no_point = {0, 0, 0};

static inline cvol_ray_point cvol_ray_point_make(const cvol_ray_job *job, double value,
                                                 double cover)
{
    return (cvol_ray_point){value, cover, cvol_ray_table_cell(&job->table, value)};
}

static inline cvol_ray_point cvol_ray_fetch_one(const cvol_ray_job *job, const cvol_ray_path *path,
                                                double place)
{
    double value, cover;
    cvol_ray_fetch(&value, &cover, job, path, place, 1);
    return cvol_ray_point_make(job, value, cover);
}

/* The value between two samples, a share t of their distance behind the first. */
static inline cvol_ray_point cvol_ray_between(const cvol_ray_job *job, const cvol_ray_point *a,
                                              const cvol_ray_point *b, double t)
{
    return cvol_ray_point_make(job, a->value + (b->value - a->value) * t, fmin(a->cover, b->cover));
}

/* The value half way between the second and the third of four samples: that of the cubic
 * polynomial through all, limited to values between these two. */
cvol_ray_point cvol_ray_halfway(const cvol_ray_job *job, const cvol_ray_point s[4]);

/* One interval: that around s[2], which begins `place` steps along the path. Its ends are half way
 * to the neighbours, or `front` and `back` where they are not NULL. */
typedef struct cvol_ray_step {
    const cvol_ray_path *path;
    const cvol_ray_point *s; /* five; without cover beyond the ends of the path */
    const cvol_ray_point *front, *back;
    double place, length; /* in steps */
} cvol_ray_step;

/* The values at the two ends of an interval, where the volume is divided; an end without a value
 * has that of the middle. */
void cvol_ray_step_ends(cvol_ray_point ends[2], const cvol_ray_job *job, const cvol_ray_step *step);

/* The walk is inline, because a call for every interval costs engine ray 7 % of its time. */

/* Receives an interval; a nonzero result ends the walk, except at the last three intervals. */
typedef int (*cvol_ray_visit_fn)(void *user, const cvol_ray_job *job, const cvol_ray_step *step);

/* The intervals that the loop over runs leaves: the last two whole steps, and the rest. The window
 * has the last four samples. */
static inline void cvol_ray_visit_last(const cvol_ray_job *job, const cvol_ray_path *path,
                                       const cvol_ray_point *entry, cvol_ray_point window[6],
                                       cvol_ray_visit_fn visit, void *user)
{
    const size_t steps = path->steps;
    const double whole = (double)steps;
    const cvol_ray_point rest = cvol_ray_fetch_one(job, path, whole + path->rest / 2),
                         end = cvol_ray_fetch_one(job, path, whole + path->rest),
                         last = cvol_ray_between(job, &window[3], &rest, 1 / (1 + path->rest));
    window[4] = window[5] = cvol_ray_no_point;
    if (steps > 1) {
        const cvol_ray_step step = {path, window, steps > 2 ? NULL : entry, NULL, whole - 2, 1};
        visit(user, job, &step);
    }
    if (steps > 0) {
        const cvol_ray_step step = {path,  window + 1, steps > 1 ? NULL : entry,
                                    &last, whole - 1,  1};
        visit(user, job, &step);
    }
    window[2] = rest;
    const cvol_ray_step step = {path, window, steps > 0 ? &last : entry, &end, whole, path->rest};
    visit(user, job, &step);
}

static inline void cvol_ray_walk(const cvol_ray_job *job, const cvol_ray_path *path,
                                 cvol_ray_visit_fn visit, void *user)
{
    double values[CVOL_RAY_RUN], covers[CVOL_RAY_RUN];
    cvol_ray_point window[CVOL_RAY_RUN + 4] = {cvol_ray_no_point, cvol_ray_no_point,
                                               cvol_ray_no_point, cvol_ray_no_point};
    const cvol_ray_point entry = cvol_ray_fetch_one(job, path, 0);
    for (size_t first = 0; first < path->steps; first += CVOL_RAY_RUN) {
        const size_t left = path->steps - first, count = left < CVOL_RAY_RUN ? left : CVOL_RAY_RUN;
        cvol_ray_fetch(values, covers, job, path, (double)first + 0.5, count);
        for (size_t k = 0; k < count; k++) {
            window[k + 4] = cvol_ray_point_make(job, values[k], covers[k]);
            if (first + k < 2)
                continue;
            const size_t at = first + k - 2;
            const cvol_ray_step step = {path, window + k, at ? NULL : &entry, NULL, (double)at, 1};
            if (visit(user, job, &step))
                return;
        }
        memmove(window, window + count, 4 * sizeof *window);
    }
    cvol_ray_visit_last(job, path, &entry, window, visit, user);
}

#endif
