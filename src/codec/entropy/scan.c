/* Scan orders and context classes. */
#include "codec/entropy/scan.h"

#include <math.h>
#include <pthread.h>
#include <stdlib.h>

static cvol_scan_entry entries4[64], entries8[512], entries16[4096], entries32[32768];
static uint16_t inverse4[64], inverse8[512], inverse16[4096], inverse32[32768];
static uint16_t runs[CVOL_SUB_BLOCK_SIZES][CVOL_SCAN_RUNS_MAX];
uint8_t cvol_level_table[CVOL_LEVEL_TABLE], cvol_fine_level_table[CVOL_LEVEL_TABLE];
static pthread_once_t tables_once = PTHREAD_ONCE_INIT;

static uint16_t identity[CVOL_SUB_BLOCK_SAMPLES_MAX];
static cvol_scan scans[CVOL_SUB_BLOCK_SIZES] = {
    {4, 64, 0, 6, 36, entries4, inverse4, runs[0], identity, identity, {0}, 8192},
    {8, 512, 1, 10, 100, entries8, inverse8, runs[1], identity, identity, {0}, 2896},
    {16, 4096, 2, 18, 324, entries16, inverse16, runs[2], identity, identity, {0}, 1024},
    {32, 32768, 3, 34, 1156, entries32, inverse32, runs[3], identity, identity, {0}, 362},
};

/* Band class of u + v + w = norm: bounds are 2.5, 5.5, 9.5, 14.5, 21.5 sixteenths of M. */
static int norm_class(int norm, int side)
{
    static const int bounds[5] = {5, 11, 19, 29, 43};
    int class = 0;
    while (class < 5 && 32 * norm > bounds[class] * side)
        class ++;
    return class;
}

static int largest(int u, int v, int w)
{
    const int uv = u > v ? u : v;
    return uv > w ? uv : w;
}

static void fill_scan(cvol_scan_entry *entries, uint16_t *inverse, int M)
{
    int index = 0;
    for (int inner = 0, outer = 1; inner < M; inner = outer, outer *= 2)
        for (int norm = inner; norm <= 3 * (outer - 1); norm++)
            for (int w = 0; w < outer && w <= norm; w++)
                for (int v = 0; v < outer && v + w <= norm; v++) {
                    const int u = norm - v - w;
                    if (u >= outer || largest(u, v, w) < inner)
                        continue;
                    const int zeros = (u == 0) + (v == 0) + (w == 0);
                    const int place = u + M * (v + M * w);
                    entries[index] = (cvol_scan_entry){
                        .place = (uint16_t)place,
                        .in_cell = (uint16_t)(M < 16 ? 16 / M * (u + 16 * (v + 16 * w)) : place),
                        .scatter = (uint16_t)(u + (M + 2) * (v + (M + 2) * w)),
                        .band = (uint16_t)(3 * norm_class(norm, M) + (zeros > 2 ? 2 : zeros))};
                    inverse[place] = (uint16_t)index++;
                }
}

/* Neighbours within a subband differ in u + v + w, neighbours in different subbands in the
 * subband. */
static void fill_runs(uint16_t *ends, const cvol_scan_entry *entries, const uint16_t *index,
                      int count, int M)
{
    int norm_before = 0, length_before = 0, run = 0;
    for (int i = 1; i < count; i++) {
        const int place = entries[i].place, norm = place % M + place / M % M + place / M / M;
        const int length = (cvol_bit_length(index[i]) + 2) / 3;
        if (i > 1 && (norm != norm_before || length != length_before))
            ends[run++] = (uint16_t)i;
        norm_before = norm;
        length_before = length;
    }
    ends[run] = (uint16_t)count;
}

static void fill_levels(uint8_t *table, const uint16_t *bounds)
{
    for (int sum = 0, level = 0; sum < CVOL_LEVEL_TABLE; sum++) {
        while (sum > bounds[level])
            level++;
        table[sum] = (uint8_t)level;
    }
}

static void fill_tables(void)
{
    static const uint16_t bounds[CVOL_LEVELS - 1] = {
        0, 1, 2, 3, 4, 6, 8, 11, 15, 20, 28, 40, 60, 100, 200, 400, 800, 1600, 3200, 6400, 12800};
    static const uint16_t fine[CVOL_FINE_LEVELS - 1] = {
        0,  1,  2,  3,   4,   5,   6,   8,    10,   12,   16,    22,   30,
        40, 56, 80, 120, 200, 400, 800, 1600, 3200, 6400, 12800, 25600};
    fill_levels(cvol_level_table, bounds);
    fill_levels(cvol_fine_level_table, fine);
    fill_scan(entries4, inverse4, 4);
    fill_scan(entries8, inverse8, 8);
    fill_scan(entries16, inverse16, 16);
    fill_scan(entries32, inverse32, 32);
    for (int i = 0; i < CVOL_SUB_BLOCK_SAMPLES_MAX; i++)
        identity[i] = (uint16_t)i;
    for (int size_class = 0; size_class < CVOL_SUB_BLOCK_SIZES; size_class++) {
        cvol_scan *scan = &scans[size_class];
        fill_runs(runs[size_class], scan->entries, identity, scan->count, scan->side);
        for (int s = 0; s < 4; s++)
            scan->subband_end[s] = cvol_subband_end(size_class, s);
    }
}

const cvol_scan *cvol_sub_block_scan_of(int size_class)
{
    pthread_once(&tables_once, fill_tables);
    return &scans[size_class];
}

/* A scan and its arrays. */
typedef struct ended_scan {
    cvol_scan scan;
    uint16_t runs[CVOL_SCAN_RUNS_MAX];
    uint16_t arrays[]; /* compact, index */
} ended_scan;

cvol_scan *cvol_sub_block_scan_ended(int size_class, const int n[3])
{
    const cvol_scan *whole = cvol_sub_block_scan_of(size_class);
    const int M = whole->side;
    const size_t most = (size_t)(n[0] * n[1] * n[2]), all = (size_t)whole->count;
    /* Entries have four numbers each. */
    ended_scan *ended = malloc(sizeof *ended + sizeof(uint16_t) * (all + 5 * most));
    if (!ended)
        return NULL;
    uint16_t *compact = ended->arrays, *index = compact + all;
    cvol_scan_entry *entries = (cvol_scan_entry *)(index + most);
    int count = 0;
    ended->scan = *whole;
    for (int i = 0; i < whole->count; i++) {
        const int place = whole->entries[i].place;
        compact[i] = CVOL_SCAN_NONE;
        if (place % M >= n[0] || place / M % M >= n[1] || place / M / M >= n[2])
            continue;
        compact[i] = (uint16_t)count;
        entries[count] = whole->entries[i];
        index[count++] = (uint16_t)i;
    }
    for (int s = 0, end = 0; s < 4; s++) {
        while (end < count && index[end] < whole->subband_end[s])
            end++;
        ended->scan.subband_end[s] = end;
    }
    fill_runs(ended->runs, entries, index, count, M);
    ended->scan.count = count;
    ended->scan.entries = entries;
    ended->scan.index_of_place = NULL;
    ended->scan.run_ends = ended->runs;
    ended->scan.index = index;
    ended->scan.compact = compact;
    ended->scan.weight = (int)floor(0x1p16 / sqrt((double)count) + 0.5);
    return &ended->scan;
}
