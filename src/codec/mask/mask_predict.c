/* Tables of the predictor's sums. */
#include "codec/mask/mask_predict.h"

#include <pthread.h>

const cvol_mask_window cvol_mask_windows[CVOL_MASK_WINDOWS] = {
    {-1, -1, -2, 3}, {-1, 0, -2, 3}, {-1, 1, -2, 3}, {-2, -2, -1, 5},
    {-2, -1, -1, 5}, {-2, 0, -1, 5}, {-2, 1, -1, 5}, {-2, 2, -1, 5},
    {-2, -2, 0, 5},  {-3, -1, 0, 7}, {-4, 0, 0, 4}};

static cvol_mask_sums sums[CVOL_MASK_SUMS];
static pthread_once_t sums_once = PTHREAD_ONCE_INIT;

static void fill_sums(void)
{
    cvol_mask_sums *to = sums;
    int neighbour = 0;
    for (int w = 0; w < CVOL_MASK_WINDOWS; w++) {
        const int width = cvol_mask_windows[w].width;
        for (int bits = 0; bits < 1 << width; bits++, to++)
            for (int i = 0; i < CVOL_MASK_HIDDEN; i++) {
                int sum = w == CVOL_MASK_WINDOWS - 1 ? cvol_mask_trained.biases[i] : 0;
                for (int k = 0; k < width; k++)
                    sum += (bits >> k & 1) * cvol_mask_trained.weights[neighbour + k][i];
                to->units[i] = (int16_t)sum;
            }
        neighbour += width;
    }
}

const cvol_mask_sums *cvol_mask_predictor(void)
{
    pthread_once(&sums_once, fill_sums);
    return sums;
}
