/* Bracketing search for a step. */
#include "codec/rate/search.h"

#include "cvol/base.h"

#include <math.h>

#include "base/elementary.h"

/* Without a bracket, a proposal is at most this factor from the last step. */
#define STRIDE_MAX cvol_log(32.0)
/* A bracket whose ends are less than this factor e apart may be stale. */
#define STALE_WIDTH 0.05

cvol_search cvol_search_make(double least_step, double most_step, double slope)
{
    return (cvol_search){
        .least = cvol_log(least_step), .most = cvol_log(most_step), .slope = slope};
}

void cvol_search_report(cvol_search *search, double step, double miss)
{
    const double place = cvol_log(step);
    const int side = miss < 0 ? -1 : 1;
    if (search->has_low && search->has_high && side == search->last_side) {
        /* The other end stays: halve its miss, so that it moves at last (Illinois). */
        if (++search->repeats >= 2)
            *(side < 0 ? &search->high_miss : &search->low_miss) *= 0.5;
    } else {
        search->repeats = 1;
    }
    if (side < 0) {
        if (search->has_low && place > search->low && search->low_miss < miss)
            search->slope = (miss - search->low_miss) / (place - search->low);
        search->low = place;
        search->low_miss = miss;
        search->has_low = 1;
    } else {
        if (search->has_high && place < search->high && search->high_miss > miss)
            search->slope = (search->high_miss - miss) / (search->high - place);
        search->high = place;
        search->high_miss = miss;
        search->has_high = 1;
    }
    search->last_side = side;
}

static double clamp(double value, double lo, double hi)
{
    return value < lo ? lo : value > hi ? hi : value;
}

double cvol_search_next(const cvol_search *search)
{
    const double slope = search->slope > 0.05 ? search->slope : 0.05;
    double place;
    if (search->has_low && search->has_high) {
        double width = search->high - search->low;
        double share = -search->low_miss / (search->high_miss - search->low_miss);
        place = search->low + width * clamp(share, 0.03, 0.97);
    } else if (search->has_low) {
        place = search->low + clamp(-1.03 * search->low_miss / slope, 1e-3, STRIDE_MAX);
    } else {
        place = search->high - clamp(1.03 * search->high_miss / slope, 1e-3, STRIDE_MAX);
    }
    return cvol_exp(clamp(place, search->least, search->most));
}

double cvol_search_slope(const cvol_search *search)
{
    const double width = search->high - search->low;
    if (!search->has_low || !search->has_high || !(width > 0))
        return search->slope;
    return (search->high_miss - search->low_miss) / width;
}

double cvol_search_width(const cvol_search *search)
{
    if (!search->has_low || !search->has_high)
        return (double)INFINITY;
    return search->high - search->low;
}

int cvol_search_at_least(const cvol_search *search)
{
    return search->has_high && search->high <= search->least + 1e-9;
}

int cvol_search_at_most(const cvol_search *search)
{
    return search->has_low && search->low >= search->most - 1e-9;
}

/* ---- the loop ---------------------------------------------------------------------------- */

/* The same search without its reported misses. */
static cvol_search emptied(const cvol_search *search, double slope)
{
    return (cvol_search){.least = search->least, .most = search->most, .slope = slope};
}

static int is_stale(const cvol_search *search, double miss, double slope)
{
    const double width = cvol_search_width(search);
    return slope > 0 && width < STALE_WIDTH && fabs(miss) > slope * width;
}

int cvol_search_run(cvol_search *search, double *step, const cvol_search_plan *plan,
                    cvol_search_try_fn attempt, void *user)
{
    search->has_ended_within = 0;
    for (int i = 0; i < plan->attempts_max; i++) {
        cvol_search_verdict verdict = CVOL_SEARCH_GO_ON;
        double miss = 0;
        const int code = attempt(user, i, *step, &miss, &verdict);
        if (code)
            return code;
        if (verdict == CVOL_SEARCH_FORGET)
            *search = emptied(search, search->slope);
        cvol_search_report(search, *step, miss);
        if (i >= plan->unbounded && (cvol_search_at_least(search) || cvol_search_at_most(search) ||
                                     (plan->width > 0 && cvol_search_width(search) < plan->width)))
            break;
        search->has_ended_within = verdict == CVOL_SEARCH_ENOUGH;
        if (verdict == CVOL_SEARCH_ENOUGH)
            break;
        if (is_stale(search, miss, plan->stale_slope)) {
            *search = emptied(search, plan->stale_slope / 2);
            cvol_search_report(search, *step, miss);
        }
        *step = cvol_search_next(search);
        if (verdict == CVOL_SEARCH_RESTART)
            *search = emptied(search, search->slope);
    }
    return CVOL_OK;
}
