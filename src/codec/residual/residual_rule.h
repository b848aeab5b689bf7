/* How residuals are coded: the quantum, the unit and the grain that a file states. */
#ifndef CVOL_CODEC_RESIDUAL_RESIDUAL_RULE_H
#define CVOL_CODEC_RESIDUAL_RESIDUAL_RULE_H

#include "cvol/base.h"

/* How a file's residual are to be read. */
typedef struct cvol_residual_rule {
    cvol_type type;
    int exact;
    double quantum;              /* unless exact and of a float type */
    int unit, grain;             /* exact, of a float type: exponents of two */
    double value_min, value_max; /* what samples that are not masked lie within */
} cvol_residual_rule;

/* The samples' largest magnitude and the exponent of the last bit that any of them uses, of those
 * that are not masked (which: NULL, or not 0 where masked): merges them into *grain and *largest,
 * which begin as INT_MAX and 0. Integer types: nothing. */
void cvol_residual_scan(int *grain, double *largest, cvol_type type, const void *samples,
                        const uint8_t *which, size_t count);

/* The rule for a bound; bound 0: exact. step: the base's (about how far it is from the samples).
 * grain and largest: of cvol_residual_scan. A bound of float types that the type can hardly
 * hold gives an exact rule. */
cvol_residual_rule cvol_residual_rule_for(cvol_type type, double bound, double step,
                                          double value_min, double value_max, int grain,
                                          double largest);
/* Whether a rule from a file can be followed. */
int cvol_residual_rule_valid(const cvol_residual_rule *rule);

#endif
