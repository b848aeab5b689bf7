/* Tables of the logistic function. */
#include "codec/entropy/logistic.h"

#include <math.h>
#include <pthread.h>

#include "base/elementary.h"

uint16_t cvol_logistic_probability[CVOL_LOGITS];
int16_t cvol_logistic_logit[CVOL_LOGITS];
static pthread_once_t once = PTHREAD_ONCE_INIT;

static void fill(void)
{
    for (int i = 0; i < CVOL_LOGITS; i++)
        cvol_logistic_probability[i] = (uint16_t)floor(65536 / (1 + cvol_exp((2048 - i) / 256.0)) +
                                                       0.5);
    for (int i = 0, below = 0; i < CVOL_LOGITS; i++) {
        while (below < CVOL_LOGITS && cvol_logistic_probability[below] < 16 * i + 8)
            below++;
        cvol_logistic_logit[i] = (int16_t)(below - CVOL_LOGITS / 2);
    }
}

void cvol_logistic_fill(void)
{
    pthread_once(&once, fill);
}
