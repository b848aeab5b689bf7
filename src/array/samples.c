/* Between dense samples of eight types and the floats that blocks are made of. */
#include <math.h>

#include "array/array.h"

#define GATHER_ROW(type)                                     \
    do {                                                     \
        const type *row = (const type *)samples + row_start; \
        for (size_t x = 0; x < inside; x++)                  \
            line[x] = (float)((double)row[x] - offset);      \
    } while (0)

/* The same of small integers and a small whole offset: by integers, which are exact here. */
#define GATHER_SMALL_ROW(type)                               \
    do {                                                     \
        const type *row = (const type *)samples + row_start; \
        const int32_t less = (int32_t)offset;                \
        for (size_t x = 0; x < inside; x++)                  \
            line[x] = (float)((int32_t)row[x] - less);       \
    } while (0)

/* 1 if that is so: differences have less than 24 bits. */
static int is_small(cvol_type type, double offset)
{
    return (type == CVOL_UINT8 || type == CVOL_INT8 || type == CVOL_UINT16 || type == CVOL_INT16) &&
           fabs(offset) < 0x1p22 && floor(offset) == offset;
}

static void load_small(float *line, const void *samples, cvol_type type, size_t row_start,
                       size_t inside, double offset)
{
    if (type == CVOL_UINT8)
        GATHER_SMALL_ROW(uint8_t);
    else if (type == CVOL_INT8)
        GATHER_SMALL_ROW(int8_t);
    else if (type == CVOL_UINT16)
        GATHER_SMALL_ROW(uint16_t);
    else
        GATHER_SMALL_ROW(int16_t);
}

void cvol_samples_load(float *line, const void *samples, cvol_type type, size_t row_start,
                       size_t inside, double offset)
{
    if (is_small(type, offset)) {
        load_small(line, samples, type, row_start, inside, offset);
        return;
    }
    switch (type) {
    case CVOL_UINT8:
        GATHER_ROW(uint8_t);
        break;
    case CVOL_INT8:
        GATHER_ROW(int8_t);
        break;
    case CVOL_UINT16:
        GATHER_ROW(uint16_t);
        break;
    case CVOL_INT16:
        GATHER_ROW(int16_t);
        break;
    case CVOL_UINT32:
        GATHER_ROW(uint32_t);
        break;
    case CVOL_INT32:
        GATHER_ROW(int32_t);
        break;
    case CVOL_FLOAT32:
        GATHER_ROW(float);
        break;
    case CVOL_FLOAT64:
        GATHER_ROW(double);
        break;
    }
}

static void gather(float *out, const void *samples, const cvol_grid *grid, const size_t side[3],
                   const size_t begin[3], double offset)
{
    size_t inside = grid->dims[0] - begin[0] < side[0] ? grid->dims[0] - begin[0] : side[0];
    for (size_t z = 0; z < side[2]; z++)
        for (size_t y = 0; y < side[1]; y++) {
            size_t sample_y = begin[1] + y, sample_z = begin[2] + z;
            if (sample_y >= grid->dims[1])
                sample_y = grid->dims[1] - 1;
            if (sample_z >= grid->dims[2])
                sample_z = grid->dims[2] - 1;
            float *line = out + (z * side[1] + y) * side[0];
            cvol_samples_load(line, samples, grid->type,
                              begin[0] + grid->dims[0] * (sample_y + grid->dims[1] * sample_z),
                              inside, offset);
            for (size_t x = inside; x < side[0]; x++)
                line[x] = line[inside - 1];
        }
}

void cvol_block_gather(float *out, const void *samples, const cvol_grid *grid, int block,
                       size_t index, double offset)
{
    const size_t B = (size_t)block, side[3] = {B, B, B};
    size_t blocks_x = (grid->dims[0] - 1) / B + 1, blocks_y = (grid->dims[1] - 1) / B + 1;
    size_t begin[3] = {index % blocks_x * B, index / blocks_x % blocks_y * B,
                       index / blocks_x / blocks_y * B};
    gather(out, samples, grid, side, begin, offset);
}

void cvol_array_gather(float *out, const void *samples, const cvol_array *shape, size_t index)
{
    const size_t side[3] = {cvol_block_side(shape, 0), cvol_block_side(shape, 1),
                            cvol_block_side(shape, 2)};
    size_t begin[3];
    cvol_block_origin(begin, shape, index);
    gather(out, samples, &shape->grid, side, begin, shape->offset);
}

static double clamp(double value, double lo, double hi)
{
    return value < lo ? lo : value > hi ? hi : value;
}

/* floor by way of an integer type that holds the samples' and more: conversions are instructions
 * everywhere, floor() is a call on some processors. */
#define STORE_INTEGERS(type, wide, most)                       \
    do {                                                       \
        const double far = (double)(most);                     \
        const wide least = (wide)lo, largest = (wide)hi;       \
        type *to = out;                                        \
        for (size_t i = 0; i < count; i++) {                   \
            double value = (double)in[i] + offset + 0.5;       \
            value = value > -far ? value : -far;               \
            value = value < far ? value : far;                 \
            wide whole = (wide)value;                          \
            whole = (wide)(whole - ((double)whole > value));   \
            whole = whole > least ? whole : least;             \
            to[i] = (type)(whole < largest ? whole : largest); \
        }                                                      \
    } while (0)

#define STORE_REALS(type)                                        \
    do {                                                         \
        type *to = out;                                          \
        for (size_t i = 0; i < count; i++)                       \
            to[i] = (type)clamp((double)in[i] + offset, lo, hi); \
    } while (0)

void cvol_samples_store(void *out, const float *in, size_t count, const cvol_array *array)
{
    const double offset = array->offset, lo = array->ledger.value_min, hi = array->ledger.value_max;
    switch (array->grid.type) {
    case CVOL_UINT8:
        STORE_INTEGERS(uint8_t, int32_t, 1 << 30);
        break;
    case CVOL_INT8:
        STORE_INTEGERS(int8_t, int32_t, 1 << 30);
        break;
    case CVOL_UINT16:
        STORE_INTEGERS(uint16_t, int32_t, 1 << 30);
        break;
    case CVOL_INT16:
        STORE_INTEGERS(int16_t, int32_t, 1 << 30);
        break;
    case CVOL_UINT32:
        STORE_INTEGERS(uint32_t, int64_t, INT64_C(1) << 52);
        break;
    case CVOL_INT32:
        STORE_INTEGERS(int32_t, int64_t, INT64_C(1) << 52);
        break;
    case CVOL_FLOAT32:
        STORE_REALS(float);
        break;
    case CVOL_FLOAT64:
        STORE_REALS(double);
        break;
    }
}
