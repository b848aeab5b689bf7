/* How fine a frame may be while the view moves: by what the frames before took. */
#ifndef CVOL_VIEWER_PACE_H
#define CVOL_VIEWER_PACE_H

#include "cvol/render.h"

/* From the whole quality to the coarsest. */
enum { RUNG_FULL, RUNG_LATTICE, RUNG_SOFT, RUNG_LEVEL_1, RUNG_LEVEL_2, RUNG_LEVEL_3, RUNG_COUNT };

typedef struct pace {
    const void *volume; /* what it was measured on: times of another are forgotten */
    int width, height, mode, lit;
    int rung;              /* of the last frame */
    double ms[RUNG_COUNT]; /* 0: not known */
    int tried[RUNG_COUNT]; /* a frame was drawn */
} pace;

/* "full", "lattice", "soft", "level 1", ... */
const char *pace_name(int rung);
/* The rung of the next frame: the last one's, a coarser one if that is known to take longer than
 * the budget, or the next finer one if it is known, or may be expected, not to. */
int pace_choose(pace *p, const void *volume, const cvol_render_options *options, double budget_ms);
/* Makes the options those of a rung. */
void pace_apply(cvol_render_options *options, int rung);
/* Notes what a frame took. */
void pace_note(pace *p, int rung, double ms);

#endif
