/* How fine a frame may be while the view moves: by what the frames before took. */
#ifndef CVOL_VIEWER_PACE_H
#define CVOL_VIEWER_PACE_H

#include "cvol/render.h"

/* From the whole quality to the coarsest. */
enum { RUNG_FULL, RUNG_SOFT, RUNG_LEVEL_1, RUNG_LEVEL_2, RUNG_LEVEL_3, RUNG_COUNT };

typedef struct pace {
    const void *volume; /* what it was measured on: times of another are forgotten */
    int width, height, mode, lit;
    double ms[RUNG_COUNT]; /* 0: not known */
} pace;

/* "full", "soft", "level 1", ... */
const char *pace_name(int rung);
/* The finest rung that is known, or may be expected, to take no longer than the budget. */
int pace_choose(pace *p, const void *volume, const cvol_render_options *options, double budget_ms);
/* Makes the options those of a rung. */
void pace_apply(cvol_render_options *options, int rung);
/* Notes what a frame took. */
void pace_note(pace *p, int rung, double ms);

#endif
