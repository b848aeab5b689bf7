/* Computes costs of tokens. */
#include "codec/quantize/rd_cost.h"

#include <math.h>

void cvol_token_costs_set(cvol_token_costs *costs, const cvol_token_tables *tables)
{
    costs->weight = 1;
    for (int r = 0; r < CVOL_ROWS; r++)
        for (int t = 0; t < CVOL_TOKENS; t++) {
            const uint16_t *bounds = tables->rows[r].bounds + 7 + t;
            costs->of[r][t] = CVOL_TOKEN_SCALE - log2f((float)(bounds[1] - bounds[0]));
        }
}

void cvol_token_costs_weigh(cvol_token_costs *costs, double weight)
{
    costs->weight *= (float)weight;
    for (int r = 0; r < CVOL_ROWS; r++)
        for (int t = 0; t < CVOL_TOKENS; t++)
            costs->of[r][t] *= (float)weight;
}
