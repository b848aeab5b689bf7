/* Searches for a quantizer step on a logarithmic scale.
 *
 * A function tries a step and reports its miss: a number that rises with the step, is below 0 when
 * the step is too small, and is about linear in log step. The search keeps a bracket and proposes
 * steps by regula falsi (Illinois variant: Dowell and Jarratt 1971). cvol_search_run is the loop of
 * all searches, for quantizer steps and for weights of bits. */
#ifndef CVOL_CODEC_RATE_SEARCH_H
#define CVOL_CODEC_RATE_SEARCH_H

typedef struct cvol_search {
    double least, most;     /* bounds of log step */
    double slope;           /* of miss over log step, until a bracket gives it */
    double low, low_miss;   /* the largest log step that was too small, and its miss */
    double high, high_miss; /* the smallest that was too large */
    int has_low, has_high;
    int last_side, repeats; /* the side that moved last, and how often in a row */
    int has_ended_within;   /* cvol_search_run ended by CVOL_SEARCH_ENOUGH alone, not at a bound */
} cvol_search;

cvol_search cvol_search_make(double least_step, double most_step, double slope);
/* Reports the miss of a step. */
void cvol_search_report(cvol_search *search, double step, double miss);
/* Returns the next step to try, after at least one report. */
double cvol_search_next(const cvol_search *search);
/* The slope of miss over log step: the bracket's, or the given one without a bracket. */
double cvol_search_slope(const cvol_search *search);
/* log of the bracket's width as a factor; infinity while one side is unknown. */
double cvol_search_width(const cvol_search *search);
/* 1 if even the smallest step is too large, or the largest one too small. */
int cvol_search_at_least(const cvol_search *search);
int cvol_search_at_most(const cvol_search *search);

/* ---- the loop ---------------------------------------------------------------------------- */

typedef enum cvol_search_verdict {
    CVOL_SEARCH_GO_ON,
    CVOL_SEARCH_ENOUGH, /* the step is good: stop */
    CVOL_SEARCH_FORGET, /* misses before this one mislead: drop them */
    CVOL_SEARCH_RESTART /* the next step uses this miss, later ones must not: drop it then */
} cvol_search_verdict;

/* Tries a step, number 0, 1, ... of the search. A result other than CVOL_OK ends the search. */
typedef int (*cvol_search_try_fn)(void *user, int number, double step, double *miss,
                                  cvol_search_verdict *verdict);

/* A search ends when a try is good, when a bound of the step misses on the inner side, or by
 * these. */
typedef struct cvol_search_plan {
    int attempts_max;
    int unbounded; /* this number of first tries is never the last, regardless of their misses */
    double width;  /* log of a bracket that is narrow enough; 0: no limit */
    /* Above 0: if the miss in a narrow bracket needs a larger slope, the bracket's ends come from
     * tables that are out of use. The search drops them and assumes half this slope. */
    double stale_slope;
} cvol_search_plan;

/* Searches from *step on. *step returns the last step tried, or, after tries_most tries, the next
 * one. */
int cvol_search_run(cvol_search *search, double *step, const cvol_search_plan *plan,
                    cvol_search_try_fn attempt, void *user);

#endif
