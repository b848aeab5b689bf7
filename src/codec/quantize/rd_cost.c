/* Computes costs of tokens. */
#include "codec/quantize/rd_cost.h"

#include <math.h>
#include <pthread.h>

#include "base/elementary.h"

static float bits_by_frequency[(1 << CVOL_TOKEN_SCALE) + 1];
static pthread_once_t bits_once = PTHREAD_ONCE_INIT;

static void fill_bits(void)
{
    for (int f = 1; f <= 1 << CVOL_TOKEN_SCALE; f++)
        bits_by_frequency[f] = CVOL_TOKEN_SCALE - cvol_log2f((float)f);
}

void cvol_token_costs_set(cvol_token_costs *costs, const cvol_token_tables *tables)
{
    pthread_once(&bits_once, fill_bits);
    costs->weight = 1;
    for (int r = 0; r < CVOL_ROWS; r++)
        for (int t = 0; t < CVOL_TOKENS; t++) {
            const uint16_t *bounds = tables->rows[r].bounds + 7 + t;
            costs->of[r][t] = bits_by_frequency[bounds[1] - bounds[0]];
        }
}

void cvol_token_costs_weigh(cvol_token_costs *costs, double weight)
{
    costs->weight *= (float)weight;
    for (int r = 0; r < CVOL_ROWS; r++)
        for (int t = 0; t < CVOL_TOKENS; t++)
            costs->of[r][t] *= (float)weight;
}
