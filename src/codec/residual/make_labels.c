/* Makes labels in place of a residual. */
#include "codec/residual/make_labels.h"

#include <stdlib.h>

#include "base/context.h"
#include "base/for_type.h"
#include "base/memory.h"
#include "codec/brick/brick_samples.h"
#include "codec/residual/residual_labels.h"

/* Labels have wide regions: at most this share of neighbours along x differs. */
#define DIFFERING_SHARE 0.25
/* The share of unequal neighbours that differ by 2 or more. */
#define JUMP_SHARE 0.3
#define FEW_VALUES 16
/* The share of unequal neighbours at faces of sub-blocks of 4, if labels were enlarged by 4 or
 * more. */
#define ALIGNED_SHARE 0.6

/* Bricks that are coded to estimate the bytes of all. The estimate may be too large by this factor;
 * one that is too small costs only time. */
#define SAMPLED_BRICKS 64
#define SAMPLE_MARGIN 1.5

/* Counts of neighbours along x. */
typedef struct pairs {
    size_t all, differing, jumps, aligned;
    double least, most;
} pairs;

static pairs count_pairs(const void *samples, const cvol_grid *grid)
{
    const size_t width = grid->dims[0], count = cvol_grid_samples(grid);
    pairs of = {.all = count};
    size_t differing = 0, jumps = 0, aligned = 0;
#define COUNT(t)                                                                           \
    {                                                                                      \
        t least = *(const t *)samples, most = least;                                       \
        for (size_t row = 0; row < count; row += width)                                    \
            for (size_t x = 0; x < width; x++) {                                           \
                const t last = ((const t *)samples)[row + (x ? x - 1 : x)];                \
                const t next = ((const t *)samples)[row + x];                              \
                const t low = last < next ? last : next, high = last < next ? next : last; \
                differing += low < high;                                                   \
                jumps += low < high && (t)(low + 1) < high;                                \
                aligned += low < high && x % 4 == 0;                                       \
                least = low < least ? low : least;                                         \
                most = high > most ? high : most;                                          \
            }                                                                              \
        of.least = (double)least;                                                          \
        of.most = (double)most;                                                            \
    }
    CVOL_FOR_TYPE(grid->type, COUNT);
#undef COUNT
    of.differing = differing;
    of.jumps = jumps;
    of.aligned = aligned;
    return of;
}

cvol_label_fit cvol_labels_judge(const void *samples, const cvol_grid *grid)
{
    if (!cvol_type_is_integer(grid->type))
        return CVOL_LABELS_NOT;
    const pairs of = count_pairs(samples, grid);
    const double differing = (double)of.differing;
    if (differing > DIFFERING_SHARE * (double)of.all)
        return CVOL_LABELS_NOT;
    return (of.most - of.least < FEW_VALUES || (double)of.jumps >= JUMP_SHARE * differing) &&
                   (double)of.aligned <= ALIGNED_SHARE * differing
               ? CVOL_LABELS_WELL
               : CVOL_LABELS_PERHAPS;
}

/* The numbers of a box of an array's samples. */
static void gather(uint32_t *numbers, const cvol_array *array, const void *samples,
                   const cvol_residual_rule *rule, const cvol_box *box)
{
    const size_t *dims = array->grid.dims, width = box->end[0] - box->begin[0];
    const int64_t least = (int64_t)rule->value_min;
    for (size_t z = box->begin[2]; z < box->end[2]; z++)
        for (size_t y = box->begin[1]; y < box->end[1]; y++, numbers += width) {
            const size_t at = box->begin[0] + dims[0] * (y + dims[1] * z);
#define GATHER(t)                      \
    for (size_t i = 0; i < width; i++) \
    numbers[i] = (uint32_t)((int64_t)((const t *)samples)[at + i] - least)
            CVOL_FOR_TYPE(rule->type, GATHER);
#undef GATHER
        }
}

/* Codes a brick; one that has the usual label everywhere gets no bytes. */
static int encode_brick(cvol_label_coder *coder, uint32_t *numbers, cvol_bytes *out,
                        const cvol_array *array, const void *samples,
                        const cvol_residual_rule *rule, size_t number)
{
    const cvol_box box = cvol_brick_samples_of(array, number);
    const uint32_t usual = cvol_labels_usual(rule);
    cvol_label_brick brick = {.most = cvol_labels_most(rule), .labels = numbers};
    size_t count = 1, same = 0;
    for (int a = 0; a < 3; a++)
        count *= brick.size[a] = box.end[a] - box.begin[a];
    gather(numbers, array, samples, rule, &box);
    while (same < count && numbers[same] == usual)
        same++;
    return same == count ? CVOL_OK : cvol_label_encode(coder, out, &brick);
}

/* Codes every `each`-th brick, until they take more than most_bytes. Returns the first error. */
static int encode_bricks(cvol_context *context, cvol_bytes *out, const cvol_array *array,
                         const void *samples, const cvol_residual_rule *rule, size_t each,
                         double most_bytes)
{
    const size_t bricks = cvol_brick_count(array);
    uint64_t bytes = 0;
    int failed = CVOL_OK;
#pragma omp parallel num_threads(cvol_context_threads(context))
    {
        cvol_label_coder *coder = cvol_label_coder_create();
        uint32_t *numbers = cvol_allocate(CVOL_BRICK_SAMPLES, sizeof *numbers);
#pragma omp for schedule(dynamic)
        for (size_t b = each / 2; b < bricks; b += each) {
            int stop;
#pragma omp atomic read
            stop = failed;
            if (stop)
                continue;
            int code = coder && numbers
                           ? encode_brick(coder, numbers, &out[b], array, samples, rule, b)
                           : CVOL_ERROR_MEMORY;
            uint64_t sum;
#pragma omp atomic capture
            sum = bytes += out[b].size;
            if (!code && (double)sum > most_bytes)
                code = CVOL_ERROR_TARGET;
            if (code) {
#pragma omp atomic write
                failed = code;
            }
        }
        cvol_label_coder_free(coder);
        free(numbers);
    }
    return failed;
}

/* The first sample is the usual label. */
static cvol_residual_rule rule_of(const cvol_array *array, const void *samples, double least,
                                  double most)
{
    cvol_residual_rule rule = {
        .type = array->grid.type, .exact = 1, .value_min = least, .value_max = most};
    const cvol_box corner = {{0, 0, 0}, {1, 1, 1}};
    uint32_t first = 0;
    gather(&first, array, samples, &rule, &corner);
    rule.quantum = rule.value_min + first;
    return rule;
}

/* Codes every `each`-th brick into *out, which has a place for each brick. The caller frees it,
 * after a failure too. Errors: MEMORY, TARGET (more than most_bytes). */
static int make_bricks(cvol_context *context, cvol_bytes **out, const cvol_array *array,
                       const void *samples, const cvol_residual_rule *rule, size_t each,
                       double most_bytes)
{
    const size_t bricks = cvol_brick_count(array);
    *out = cvol_allocate_zero(bricks, sizeof **out);
    if (!*out)
        return cvol_fail_memory(context, bricks * sizeof **out, "the labels");
    const int code = encode_bricks(context, *out, array, samples, rule, each, most_bytes);
    return code == CVOL_ERROR_MEMORY
               ? cvol_fail_memory(context, CVOL_BRICK_SAMPLES * sizeof(uint32_t), "a brick")
               : code;
}

int cvol_labels_may_fit(cvol_context *context, int *out, const cvol_array *array,
                        const void *samples, double most_bytes)
{
    const size_t bricks = cvol_brick_count(array),
                 each = bricks > SAMPLED_BRICKS ? bricks / SAMPLED_BRICKS : 1;
    double least, most;
    cvol_bytes *parts = NULL;
    int code = cvol_scan_samples(context, &least, &most, samples, &array->grid);
    if (!code) {
        const cvol_residual_rule rule = rule_of(array, samples, least, most);
        code = make_bricks(context, &parts, array, samples, &rule, each,
                           SAMPLE_MARGIN * most_bytes / (double)each);
    }
    *out = !code;
    for (size_t b = 0; parts && b < bricks; b++)
        cvol_bytes_free(&parts[b]);
    free(parts);
    return code == CVOL_ERROR_TARGET ? CVOL_OK : code;
}

int cvol_labels_make(cvol_context *context, cvol_residual_data **out, const cvol_array *array,
                     const void *samples, double most_bytes)
{
    const size_t bricks = cvol_brick_count(array);
    const cvol_residual_rule rule = rule_of(array, samples, array->error_bound.value_min,
                                            array->error_bound.value_max);
    cvol_bytes *parts;
    *out = NULL;
    int code = make_bricks(context, &parts, array, samples, &rule, 1, most_bytes);
    const int is_larger = code == CVOL_ERROR_TARGET;
    if (!code)
        code = cvol_residual_create(context, out, NULL, bricks);
    for (size_t b = 0; parts && b < bricks; b++) {
        if (!code)
            code = cvol_residual_append(context, *out, (cvol_span){parts[b].data, parts[b].size});
        cvol_bytes_free(&parts[b]);
    }
    free(parts);
    if (!code) {
        (*out)->kind = CVOL_RESIDUAL_LABELS;
        (*out)->rule = rule;
    } else if (*out) {
        cvol_residual_free(*out);
        *out = NULL;
    }
    return is_larger ? CVOL_OK : code;
}
