/* The logistic function and its inverse in integers. Logits are in units of 1/256, probabilities in
 * units of 2^-16. */
#ifndef CVOL_CODEC_ENTROPY_LOGISTIC_H
#define CVOL_CODEC_ENTROPY_LOGISTIC_H

#include <stdint.h>

enum { CVOL_LOGITS = 4096 };

/* Filled by the first call of cvol_logistic_fill. */
extern uint16_t cvol_logistic_probability[CVOL_LOGITS]; /* [logit + 2048] */
extern int16_t cvol_logistic_logit[CVOL_LOGITS];        /* [probability / 16] */
void cvol_logistic_fill(void);

#endif
