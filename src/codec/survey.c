/* The distance of samples to what an array stands for. */
#include "codec/survey.h"

#include <math.h>
#include <stdlib.h>

#include "base/context.h"
#include "base/memory.h"
#include "cvol/codec.h"

/* Applies CASE(type) to the C type of a cvol_type. */
#define FOR_TYPE(number, CASE) \
    switch (number) {          \
    case CVOL_UINT8:           \
        CASE(uint8_t);         \
        break;                 \
    case CVOL_INT8:            \
        CASE(int8_t);          \
        break;                 \
    case CVOL_UINT16:          \
        CASE(uint16_t);        \
        break;                 \
    case CVOL_INT16:           \
        CASE(int16_t);         \
        break;                 \
    case CVOL_UINT32:          \
        CASE(uint32_t);        \
        break;                 \
    case CVOL_INT32:           \
        CASE(int32_t);         \
        break;                 \
    case CVOL_FLOAT32:         \
        CASE(float);           \
        break;                 \
    case CVOL_FLOAT64:         \
        CASE(double);          \
        break;                 \
    }

#define COMPARE(type)                                                              \
    do {                                                                           \
        const type *a = (const type *)samples + first, *b = (const type *)decoded; \
        for (size_t i = 0; i < count; i++) {                                       \
            double error = fabs((double)a[i] - (double)b[i]);                      \
            most = error > most ? error : most;                                    \
            squares += error * error;                                              \
        }                                                                          \
    } while (0)

#define COMPARE_REAL(type)                                                  \
    do {                                                                    \
        const type *a = (const type *)samples + first;                      \
        for (size_t i = 0; i < count; i++) {                                \
            float value = (float)((double)real[i] + offset);                \
            double error = (double)a[i] - (double)value;                    \
            squares += error * error;                                       \
            norm += (double)value * (double)value;                          \
            most = fabs((double)value) > most ? fabs((double)value) : most; \
        }                                                                   \
    } while (0)

/* The same with floats as cvol_array_evaluate_real gives them. */
static void compare_real_row(cvol_distance *out, const void *samples, cvol_type type, size_t first,
                             const float *real, double offset, size_t count)
{
    double squares = 0, norm = 0, most = out->real_max_abs;
    FOR_TYPE(type, COMPARE_REAL);
    out->real_max_abs = most;
    out->real_l2_error += squares;
    out->real_norm += norm;
}

/* Adds a row of `count` samples from sample `first` to a block's distance; L2 norms are squares. */
static void compare_row(cvol_distance *out, const void *samples, cvol_type type, size_t first,
                        const void *decoded, size_t count)
{
    double most = out->max_error, squares = 0;
    FOR_TYPE(type, COMPARE);
    out->max_error = most;
    out->l2_error += squares;
}

/* Sums sheets into *out, in order, so that threads do not matter. */
static void add_distances(cvol_distance *out, const cvol_distance *distances, size_t count)
{
    *out = (cvol_distance){0};
    for (size_t i = 0; i < count; i++) {
        out->max_error = fmax(out->max_error, distances[i].max_error);
        out->real_max_abs = fmax(out->real_max_abs, distances[i].real_max_abs);
        out->l2_error += distances[i].l2_error;
        out->real_l2_error += distances[i].real_l2_error;
        out->real_norm += distances[i].real_norm;
    }
    out->l2_error = sqrt(out->l2_error);
    out->real_l2_error = sqrt(out->real_l2_error);
    out->real_norm = sqrt(out->real_norm);
}

/* Evaluates all, as stored samples or as they are, and compares sheet by sheet. */
static int measure(cvol_context *context, cvol_distance *distances, const cvol_array *array,
                   const void *samples, int real)
{
    const cvol_grid *grid = &array->grid;
    const size_t begin[3] = {0, 0, 0}, sheets = grid->dims[2];
    const size_t per_sheet = grid->dims[0] * grid->dims[1];
    const size_t size = real ? sizeof(float) : cvol_type_size(grid->type);
    uint8_t *decoded = cvol_allocate(cvol_grid_samples(grid), size);
    if (!decoded)
        return cvol_fail_memory(context, cvol_grid_samples(grid) * size, "the decoded samples");
    int code = real ? cvol_array_evaluate_real(context, (float *)(void *)decoded, array, begin,
                                               grid->dims)
                    : cvol_array_evaluate_box(context, decoded, array, begin, grid->dims);
#pragma omp parallel for schedule(static) num_threads(cvol_context_threads(context))
    for (size_t z = 0; z < (code ? 0 : sheets); z++) {
        const void *sheet = decoded + z * per_sheet * size;
        if (real)
            compare_real_row(&distances[z], samples, grid->type, z * per_sheet, sheet, 0,
                             per_sheet);
        else
            compare_row(&distances[z], samples, grid->type, z * per_sheet, sheet, per_sheet);
    }
    free(decoded);
    return code;
}

int cvol_array_measure(cvol_context *context, cvol_array *array, const void *samples)
{
    const size_t sheets = array->grid.dims[2];
    cvol_distance *distances = cvol_allocate_zero(sheets, sizeof *distances), sum;
    if (!distances)
        return cvol_fail_memory(context, sheets * sizeof *distances, "the distances");
    int code = measure(context, distances, array, samples, 0);
    if (!code)
        code = measure(context, distances, array, samples, 1);
    add_distances(&sum, distances, sheets);
    free(distances);
    if (code)
        return code;
    cvol_ledger *ledger = &array->ledger;
    const double rounding = CVOL_ROUNDING * sum.real_norm;
    cvol_array_set_measured(array, &sum);
    ledger->l2_error = fmin(ledger->l2_error, sum.real_l2_error + rounding);
    ledger->max_abs = fmin(ledger->max_abs, sum.real_max_abs + rounding);
    return CVOL_OK;
}

static cvol_distance compare_block(const cvol_array *array, const void *samples, size_t index,
                                   float *evaluated, double *row)
{
    const size_t B = (size_t)array->block, *dims = array->grid.dims;
    const size_t begin[3] = {index % array->blocks[0] * B,
                             index / array->blocks[0] % array->blocks[1] * B,
                             index / array->blocks[0] / array->blocks[1] * B};
    size_t inside[3];
    for (int a = 0; a < 3; a++)
        inside[a] = dims[a] - begin[a] < B ? dims[a] - begin[a] : B;
    cvol_distance distance = {0};
    cvol_block_evaluate(evaluated, array, index);
    for (size_t z = 0; z < inside[2]; z++)
        for (size_t y = 0; y < inside[1]; y++) {
            size_t first = begin[0] + dims[0] * (begin[1] + y + dims[1] * (begin[2] + z));
            const float *line = evaluated + B * (y + B * z);
            cvol_samples_store(row, line, inside[0], array);
            compare_row(&distance, samples, array->grid.type, first, row, inside[0]);
            compare_real_row(&distance, samples, array->grid.type, first, line, array->offset,
                             inside[0]);
        }
    return distance;
}

int cvol_measure_distance(cvol_context *context, cvol_distance *out, const cvol_array *array,
                          const void *samples)
{
    const size_t B = (size_t)array->block, per_block = B * B * B;
    cvol_distance *distances = cvol_allocate(array->block_count, sizeof *distances);
    int failed = !distances;
#pragma omp parallel num_threads(cvol_context_threads(context))
    {
        float *evaluated = cvol_allocate(per_block, sizeof *evaluated);
        double row[32];
        if (!evaluated) {
#pragma omp atomic write
            failed = 1;
        }
#pragma omp for schedule(dynamic, 16)
        for (size_t i = 0; i < array->block_count; i++)
            if (evaluated && distances)
                distances[i] = compare_block(array, samples, i, evaluated, row);
        free(evaluated);
    }
    *out = (cvol_distance){0};
    if (!failed)
        add_distances(out, distances, array->block_count);
    free(distances);
    if (failed)
        return cvol_fail_memory(context, per_block * sizeof(float), "a block");
    return CVOL_OK;
}

void cvol_array_set_measured(cvol_array *array, const cvol_distance *distance)
{
    const double span = array->ledger.value_max - array->ledger.value_min;
    const double samples = (double)cvol_grid_samples(&array->grid);
    array->measured = 1;
    array->max_error = distance->max_error;
    array->psnr_db = (double)INFINITY;
    if (distance->l2_error > 0)
        array->psnr_db = 20 * log10(span * sqrt(samples) / distance->l2_error);
}
