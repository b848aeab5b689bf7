/* Scan orders, context classes, and the model's first state. */
#include "codec/block_model.h"

#include <pthread.h>

static cvol_scan_entry entries8[512], entries16[4096], entries32[32768];
static uint16_t inverse8[512], inverse16[4096], inverse32[32768];
static uint8_t level_table[CVOL_LEVEL_TABLE];
static pthread_once_t tables_once = PTHREAD_ONCE_INIT;

static const cvol_scan scans[3] = {
    {8, 512, 3, entries8, inverse8, level_table},
    {16, 4096, 4, entries16, inverse16, level_table},
    {32, 32768, 5, entries32, inverse32, level_table},
};

/* Band class of u + v + w = norm: bounds are 2.5, 5.5, 9.5, 14.5, 21.5 sixteenths of B. */
static int norm_class(int norm, int block)
{
    static const int bounds[5] = {5, 11, 19, 29, 43};
    int class = 0;
    while (class < 5 && 32 * norm > bounds[class] * block)
        class ++;
    return class;
}

static void fill_scan(cvol_scan_entry *entries, uint16_t *inverse, int B)
{
    int index = 0;
    for (int norm = 0; norm <= 3 * (B - 1); norm++)
        for (int place = 0; place < B * B * B; place++) {
            int u = place % B, v = place / B % B, w = place / B / B;
            if (u + v + w != norm)
                continue;
            int zeros = (u == 0) + (v == 0) + (w == 0);
            entries[index] = (cvol_scan_entry){
                .place = (uint16_t)place,
                .scatter = (uint16_t)(u + (B + 2) * (v + (B + 2) * w)),
                .band = (uint16_t)(3 * norm_class(norm, B) + (zeros > 2 ? 2 : zeros))};
            inverse[place] = (uint16_t)index++;
        }
}

static void fill_tables(void)
{
    static const int bounds[CVOL_LEVELS - 1] = {
        0, 1, 2, 3, 4, 6, 8, 11, 15, 20, 28, 40, 60, 100, 200, 400, 800, 1600, 3200, 6400, 12800};
    for (int sum = 0, level = 0; sum < CVOL_LEVEL_TABLE; sum++) {
        while (sum > bounds[level])
            level++;
        level_table[sum] = (uint8_t)level;
    }
    fill_scan(entries8, inverse8, 8);
    fill_scan(entries16, inverse16, 16);
    fill_scan(entries32, inverse32, 32);
}

const cvol_scan *cvol_scan_of(int block)
{
    pthread_once(&tables_once, fill_tables);
    return &scans[block == 8 ? 0 : block == 16 ? 1 : 2];
}

void cvol_block_model_start(cvol_block_model *model, int block)
{
    const uint16_t *defaults = cvol_block_defaults[block == 8 ? 0 : block == 16 ? 1 : 2];
    cvol_probability *probabilities = (cvol_probability *)model;
    for (int i = 0; i < CVOL_MODEL_SIZE; i++)
        probabilities[i] = (cvol_probability){defaults[i], defaults[i]};
}
