/* Samples in memory in another order than the grid's. */
#include "volume/io/strided.h"

#include <stdlib.h>
#include <string.h>

#include "base/byte_order.h"
#include "base/context.h"
#include "base/file.h"
#include "base/memory.h"

typedef struct taken {
    cvol_strided s;
    size_t dims[3], element, sample;
    int swaps;
} taken;

static void close_taken(void *state)
{
    taken *t = state;
    if (!t)
        return;
    free(t->s.data);
    free(t);
}

/* Converts a half float's bits to those of a float: exponents are shifted, subnormals
 * normalised. */
static uint32_t float_bits(uint16_t half)
{
    uint32_t sign = (uint32_t)(half & 0x8000) << 16, rest = half & 0x7fff;
    if (rest >= 0x7c00)
        return sign | 0x7f800000 | (rest & 0x3ff) << 13;
    if (rest >= 0x400)
        return sign | ((rest << 13) + (UINT32_C(112) << 23));
    const float value = (float)rest * 0x1p-24f;
    uint32_t bits;
    memcpy(&bits, &value, 4);
    return sign | bits;
}

void cvol_strided_gather(void *out, const void *in, size_t count, size_t step, size_t element,
                         int is_half)
{
    uint8_t *to = out;
    const uint8_t *from = in;
    if (is_half)
        for (size_t x = 0; x < count; x++) {
            uint16_t half;
            memcpy(&half, from + x * step, 2);
            const uint32_t bits = float_bits(half);
            memcpy(to + 4 * x, &bits, 4);
        }
    else if (step == element)
        memcpy(to, from, count * element);
    else
        for (size_t x = 0; x < count; x++)
            memcpy(to + x * element, from + x * step, element);
}

static void gather(const taken *t, size_t from, size_t count, uint8_t *out)
{
    const uint8_t *in = t->s.data + from * t->element;
    cvol_strided_gather(out, in, count, t->s.stride[0] * t->element, t->element, t->s.is_half);
}

static int read_slices(cvol_context *context, void *state, void *out, size_t first, size_t count)
{
    const taken *t = state;
    const size_t row = t->dims[0] * t->sample;
    uint8_t *to = out;
    (void)context;
    for (size_t z = first; z < first + count; z++)
        for (size_t y = 0; y < t->dims[1]; y++, to += row)
            gather(t, t->s.first + z * t->s.stride[2] + y * t->s.stride[1], t->dims[0], to);
    if (t->swaps && !t->s.is_half)
        cvol_swap_bytes(out, (size_t)(to - (uint8_t *)out) / t->sample, t->sample);
    return CVOL_OK;
}

int cvol_strided_take(cvol_context *context, cvol_stored *stored, const cvol_strided *strided,
                      const cvol_grid *grid, const char *path)
{
    taken *t = calloc(1, sizeof *t);
    if (!t) {
        free(strided->data);
        return cvol_fail_memory(context, sizeof *t, path);
    }
    t->s = *strided;
    memcpy(t->dims, grid->dims, sizeof t->dims);
    t->sample = cvol_type_size(grid->type);
    t->element = strided->is_half ? 2 : t->sample;
    t->swaps = strided->big_endian != cvol_machine_is_big_endian() && t->element > 1;
    if (t->swaps && strided->is_half) /* gather converts halves of the machine */
        cvol_swap_bytes(t->s.data, strided->size / 2, 2);
    stored->slices = (cvol_slices){.state = t, .read = read_slices, .close = close_taken};
    size_t last = strided->first;
    for (int a = 0; a < 3; a++) {
        size_t step;
        if (grid->dims[a] == 0 ||
            !cvol_size_multiply(&step, grid->dims[a] - 1, strided->stride[a]) ||
            !cvol_size_add(&last, last, step))
            last = SIZE_MAX;
    }
    if (last >= strided->size / t->element)
        return cvol_fail(context, CVOL_ERROR_FORMAT,
                         "%s: %zu bytes of samples are less than %zu x %zu x %zu of them", path,
                         strided->size, grid->dims[0], grid->dims[1], grid->dims[2]);
    return CVOL_OK;
}

int cvol_strided_read(cvol_context *context, cvol_stored *stored, cvol_strided *strided,
                      const cvol_grid *grid, const char *path, uint64_t offset, size_t count)
{
    size_t bytes;
    if (!cvol_size_multiply(&bytes, count, strided->is_half ? 2 : cvol_type_size(grid->type)))
        bytes = SIZE_MAX;
    int code = cvol_file_read(context, &strided->data, &strided->size, path, offset, bytes);
    if (!code && strided->size < bytes) {
        free(strided->data);
        code = cvol_fail(context, CVOL_ERROR_FORMAT,
                         "%s: holds %zu of the %zu bytes of samples that its header announces",
                         path, strided->size, bytes);
        strided->data = NULL;
    }
    return code ? code : cvol_strided_take(context, stored, strided, grid, path);
}
