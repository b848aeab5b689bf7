/* Conversion between dense samples of eight types and the floats of blocks. */
#include <math.h>

#include "array/core/samples.h"
#include "base/cpu.h"

CVOL_SIMD_DECLARE(void, cvol_samples_load,
                  (float *, const void *, cvol_type, size_t, size_t, double));
CVOL_SIMD_DECLARE(void, cvol_samples_convert,
                  (void *, const float *, size_t, const cvol_sample_format *));

void cvol_samples_load(float *out, const void *samples, cvol_type type, size_t first, size_t count,
                       double offset)
{
    CVOL_SIMD_CHOOSE(cvol_samples_load)(out, samples, type, first, count, offset);
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

/* The least and the largest number of an integer type. */
static void type_bounds(double *least, double *most, cvol_type type)
{
    const int bits = 8 * (int)cvol_type_size(type);
    const int is_signed = type == CVOL_INT8 || type == CVOL_INT16 || type == CVOL_INT32;
    *least = is_signed ? -(double)(INT64_C(1) << (bits - 1)) : 0;
    *most = (double)((INT64_C(1) << (is_signed ? bits - 1 : bits)) - 1);
}

cvol_sample_format cvol_sample_format_of(const cvol_array *array)
{
    cvol_sample_format as = {array->grid.type, array->offset, array->error_bound.value_min,
                             array->error_bound.value_max};
    if (cvol_type_is_integer(as.type)) {
        double least, most;
        type_bounds(&least, &most, as.type);
        as.lo = fmax(trunc(as.lo), least);
        as.hi = fmin(trunc(as.hi), most);
    }
    return as;
}

void cvol_samples_convert(void *out, const float *in, size_t count, const cvol_sample_format *as)
{
    CVOL_SIMD_CHOOSE(cvol_samples_convert)(out, in, count, as);
}

void cvol_samples_store(void *out, const float *in, size_t count, const cvol_array *array)
{
    const cvol_sample_format as = cvol_sample_format_of(array);
    cvol_samples_convert(out, in, count, &as);
}
