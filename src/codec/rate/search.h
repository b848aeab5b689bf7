/* Searches for a quantizer step on a logarithmic scale.
 *
 * The caller tries steps and reports each miss: a number that rises with the step, is below 0 when
 * the step is too small, and is about linear in log step. The search keeps a bracket and proposes
 * steps by regula falsi (Illinois variant: Dowell and Jarratt 1971). */
#ifndef CVOL_CODEC_RATE_SEARCH_H
#define CVOL_CODEC_RATE_SEARCH_H

typedef struct cvol_search {
    double least, most;       /* bounds of log step */
    double slope;             /* of miss over log step, until a bracket gives it */
    double small, small_miss; /* the largest log step that was too small, and its miss */
    double large, large_miss; /* the smallest that was too large */
    int has_small, has_large;
    int last_side, repeats; /* the side that moved last, and how often in a row */
} cvol_search;

cvol_search cvol_search_make(double least_step, double most_step, double slope);
/* Reports the miss of a step. */
void cvol_search_tell(cvol_search *search, double step, double miss);
/* Returns the next step to try. */
double cvol_search_next(const cvol_search *search);
/* The slope of miss over log step: the bracket's, or the given one without a bracket. */
double cvol_search_slope(const cvol_search *search);
/* log of the bracket's width as a factor; infinity while one side is unknown. */
double cvol_search_width(const cvol_search *search);
/* 1 if even the least step is too large, or the most one too small. */
int cvol_search_at_least(const cvol_search *search);
int cvol_search_at_most(const cvol_search *search);

#endif
