/* The quality of frames while the view moves, by the times of earlier frames. */
#ifndef CVOL_VIEWER_SERVICE_PACE_H
#define CVOL_VIEWER_SERVICE_PACE_H

#include "cvol/render.h"

/* From full quality to the coarsest. */
enum {
    RUNG_FULL,
    RUNG_OBJECT_ORDER,
    RUNG_SOFT,
    RUNG_LEVEL_1,
    RUNG_LEVEL_2,
    RUNG_LEVEL_3,
    RUNG_COUNT
};

typedef struct pace {
    const void *volume; /* times of another volume are dropped */
    int width, height, mode, lit;
    int rung;              /* of the last frame */
    double ms[RUNG_COUNT]; /* 0: unknown */
    int tried[RUNG_COUNT]; /* a frame was drawn */
} pace;

/* "full", "object order", "soft", "level 1", ... */
const char *pace_name(int rung);
/* The rung of this name; -1: there is none. */
int pace_find(const char *name);
/* The rung of the next frame: that of the last frame; a coarser one if its time exceeds the budget;
 * the next finer one if its known or estimated time fits. */
int pace_choose(pace *p, const void *volume, const cvol_render_options *options, double budget_ms);
/* Sets the options of a rung. */
void pace_apply(cvol_render_options *options, int rung);
/* Stores the time of a frame. */
void pace_add_time(pace *p, int rung, double ms);

#endif
