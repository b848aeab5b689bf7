/* Labels in place of a residual: the samples of a brick themselves (labels/label_code.h), as their
 * distances from value_min. The base is only a preview. A brick without bytes has the file's usual
 * label everywhere, which is the quantum of the rule. The rule is of an integer type. */
#ifndef CVOL_CODEC_RESIDUAL_RESIDUAL_LABELS_H
#define CVOL_CODEC_RESIDUAL_RESIDUAL_LABELS_H

#include "codec/labels/label_code.h"
#include "codec/residual/residual_rule.h"

/* True if a file may have the rule. */
int cvol_labels_rule_valid(const cvol_residual_rule *rule);

/* The number that stands for the usual label, and the largest number. */
uint32_t cvol_labels_usual(const cvol_residual_rule *rule);
uint32_t cvol_labels_most(const cvol_residual_rule *rule);

/* Decodes a brick to samples of the rule's type; numbers: memory for as many. Returns CVOL_OK or
 * CVOL_ERROR_CORRUPT. */
int cvol_labels_decode(cvol_label_coder *coder, void *samples, uint32_t *numbers,
                       const cvol_residual_rule *rule, const size_t size[3], cvol_span data);

#endif
