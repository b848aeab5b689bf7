/* Bracketing search for a step. */
#include "codec/rate/search.h"

#include <math.h>

/* Without a bracket, a proposal is at most this factor from the last step. */
#define STRIDE_MOST log(32.0)

cvol_search cvol_search_make(double least_step, double most_step, double slope)
{
    return (cvol_search){.least = log(least_step), .most = log(most_step), .slope = slope};
}

void cvol_search_tell(cvol_search *search, double step, double miss)
{
    const double place = log(step);
    const int side = miss < 0 ? -1 : 1;
    if (search->has_small && search->has_large && side == search->last_side) {
        /* The other end stays: halve its miss, so that it moves at last (Illinois). */
        if (++search->repeats >= 2)
            *(side < 0 ? &search->large_miss : &search->small_miss) *= 0.5;
    } else {
        search->repeats = 1;
    }
    if (side < 0) {
        if (search->has_small && place > search->small && search->small_miss < miss)
            search->slope = (miss - search->small_miss) / (place - search->small);
        search->small = place;
        search->small_miss = miss;
        search->has_small = 1;
    } else {
        if (search->has_large && place < search->large && search->large_miss > miss)
            search->slope = (search->large_miss - miss) / (search->large - place);
        search->large = place;
        search->large_miss = miss;
        search->has_large = 1;
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
    if (search->has_small && search->has_large) {
        double width = search->large - search->small;
        double share = -search->small_miss / (search->large_miss - search->small_miss);
        place = search->small + width * clamp(share, 0.03, 0.97);
    } else if (search->has_small) {
        place = search->small + clamp(-1.03 * search->small_miss / slope, 1e-3, STRIDE_MOST);
    } else if (search->has_large) {
        place = search->large - clamp(1.03 * search->large_miss / slope, 1e-3, STRIDE_MOST);
    } else {
        place = (search->least + search->most) / 2;
    }
    return exp(clamp(place, search->least, search->most));
}

double cvol_search_slope(const cvol_search *search)
{
    const double width = search->large - search->small;
    if (!search->has_small || !search->has_large || !(width > 0))
        return search->slope;
    return (search->large_miss - search->small_miss) / width;
}

double cvol_search_width(const cvol_search *search)
{
    if (!search->has_small || !search->has_large)
        return (double)INFINITY;
    return search->large - search->small;
}

int cvol_search_at_least(const cvol_search *search)
{
    return search->has_large && search->large <= search->least + 1e-9;
}

int cvol_search_at_most(const cvol_search *search)
{
    return search->has_small && search->small >= search->most - 1e-9;
}
