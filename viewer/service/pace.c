/* The quality of frames while the view moves. */
#include "viewer/service/pace.h"

#include <string.h>

/* Assumed ratio of the times of a rung and of the next coarser one, until the rung was tried. */
static const double growth = 3;
/* Weight of a new frame in the running time of a rung; 1 if it was faster. The first frame of a
 * rung does not count: it fills caches, and its time would block the rung for long. */
static const double share = 0.3;
/* A finer rung must fit into this share of the budget, so that the quality does not alternate. */
static const double room = 0.85;
/* Times decay, so that a rung that was too slow is tried again later. */
static const double ageing = 0.97;

const char *pace_name(int rung)
{
    static const char *const names[] = {"full",    "object order", "soft",
                                        "level 1", "level 2",      "level 3"};
    return names[rung];
}

int pace_find(const char *name)
{
    int rung = RUNG_COUNT - 1;
    while (rung >= 0 && strcmp(pace_name(rung), name))
        rung--;
    return rung;
}

int pace_choose(pace *p, const void *volume, const cvol_render_options *options, double budget_ms)
{
    if (p->volume != volume || p->width != options->width || p->height != options->height ||
        p->mode != (int)options->mode || p->lit != options->shading.on)
        *p = (pace){volume,
                    options->width,
                    options->height,
                    (int)options->mode,
                    options->shading.on,
                    RUNG_LEVEL_2,
                    {0},
                    {0}};
    while (p->rung < RUNG_LEVEL_3 && p->ms[p->rung] > budget_ms)
        p->rung++;
    const int finer_one = p->rung - 1;
    if (finer_one >= RUNG_FULL && p->ms[p->rung] > 0) {
        const double expected = p->ms[finer_one] > 0 ? p->ms[finer_one] : growth * p->ms[p->rung];
        if (expected <= room * budget_ms)
            p->rung--;
    }
    const int rung = p->rung;
    for (int finer = 0; finer < rung; finer++)
        p->ms[finer] *= ageing;
    return rung;
}

void pace_apply(cvol_render_options *options, int rung)
{
    if (rung == RUNG_FULL)
        return;
    options->sheet.ray_order = CVOL_RAY_ORDER_OBJECT;
    if (rung == RUNG_OBJECT_ORDER)
        return;
    options->step_voxels = rung == RUNG_SOFT ? 2 : 0;
    options->oversample = rung == RUNG_SOFT ? 0.7 : 1;
    options->sheet.footprint = CVOL_SHEET_LINEAR;
    const int level = rung > RUNG_SOFT ? rung - RUNG_SOFT : 0;
    options->level = level > options->level ? level : options->level;
}

void pace_add_time(pace *p, int rung, double ms)
{
    if (!p->tried[rung]) {
        p->tried[rung] = 1;
        return;
    }
    p->ms[rung] = p->ms[rung] > ms || !(p->ms[rung] > 0) ? ms
                                                         : (1 - share) * p->ms[rung] + share * ms;
}
