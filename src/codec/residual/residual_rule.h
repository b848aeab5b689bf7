/* Rules of residuals: the quantum, the unit and the grain that a file states. */
#ifndef CVOL_CODEC_RESIDUAL_RESIDUAL_RULE_H
#define CVOL_CODEC_RESIDUAL_RESIDUAL_RULE_H

#include "cvol/base.h"

/* The coding rule of a file's residual. */
typedef struct cvol_residual_rule {
    cvol_type type;
    int exact;
    double quantum;              /* unless exact and of a float type */
    int unit, grain;             /* exact, of a float type: exponents of two */
    double value_min, value_max; /* range of samples that are not masked */
} cvol_residual_rule;

/* Scans samples that are not masked (which: NULL, or nonzero where masked) for the largest
 * magnitude and the lowest exponent of a set bit; merges them into *grain and *largest, which begin
 * as INT_MAX and 0. Does nothing for integer types. */
void cvol_residual_scan(int *grain, double *largest, cvol_type type, const void *samples,
                        const uint8_t *which, size_t count);

/* The rule for a bound; bound 0: exact. step: the base's (about its distance from the samples).
 * grain and largest: from cvol_residual_scan. If a float type can hardly represent the bound, the
 * rule is exact. */
cvol_residual_rule cvol_residual_rule_for(cvol_type type, double bound, double step,
                                          double value_min, double value_max, int grain,
                                          double largest);
/* True if the residual of a sample can be decoded only with the base of all samples before it in
 * its brick: if exact and of a float type, where the base's exponent chooses how it is coded. */
int cvol_residual_rule_needs_base(const cvol_residual_rule *rule);
/* True if a rule from a file is valid. */
int cvol_residual_rule_valid(const cvol_residual_rule *rule);

#endif
