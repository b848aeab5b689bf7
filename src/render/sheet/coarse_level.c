/* Low-resolution volumes from levels (coarse_level.h). */
#include "render/sheet/coarse_level.h"

#include "array/evaluate/decoded_terms.h"
#include "base/context.h"

enum {
    LEVEL_MAX = 3,    /* of a level whose samples are evaluated; coarser cells are their means */
    MARGIN = 32,      /* slices on either side of a part, for the filter */
    PART_SLICES = 256 /* if cells are coarser than the level, which need not be in memory then */
};

/* Slices of the volume whose level is known: first .. end - 1 count. */
typedef struct part {
    cvol_sheet_level level;
    int number;
    size_t begin, first, end; /* begin: of the level */
} part;

/* A sample of the level less the array's offset, as a share of the cells' sums. */
typedef struct sample {
    float value, cover;
} sample;

static sample sample_at(const part *p, size_t x, size_t y, size_t z)
{
    const size_t side = CVOL_LEVEL_BLOCK, *blocks = p->level.shape->blocks;
    const size_t block = x / side + blocks[0] * (y / side + blocks[1] * (z / side));
    const size_t at = block * CVOL_LEVEL_BLOCK_SAMPLES + x % side +
                      side * (y % side + side * (z % side));
    return (sample){p->level.samples[at], p->level.cover ? p->level.cover[at] : 1};
}

/* Sets a cell to the mean of `count` samples of the level along each axis. */
static void set_cell(cvol_coarse *out, const part *p, const size_t cell[3], size_t count)
{
    const size_t *size = p->level.shape->grid.dims, below = p->begin >> p->number;
    const size_t at = cell[0] + out->dims[0] * (cell[1] + out->dims[1] * cell[2]);
    double sum = 0, covers = 0, plain = 0;
    size_t begin[3], end[3], samples = 0;
    for (int a = 0; a < 3; a++) {
        begin[a] = cell[a] * count - (a == 2 ? below : 0);
        end[a] = begin[a] + count < size[a] ? begin[a] + count : size[a];
    }
    if (count == 1) {
        const sample s = sample_at(p, begin[0], begin[1], begin[2]);
        out->values[at] = s.value;
        if (out->cover)
            out->cover[at] = s.cover;
        return;
    }
    for (size_t z = begin[2]; z < end[2]; z++)
        for (size_t y = begin[1]; y < end[1]; y++)
            for (size_t x = begin[0]; x < end[0]; x++, samples++) {
                const sample s = sample_at(p, x, y, z);
                sum += (double)(s.value * s.cover);
                covers += (double)s.cover;
                plain += (double)s.value;
            }
    out->values[at] = (float)(covers > 0 ? sum / covers : plain / (double)samples);
    if (out->cover)
        out->cover[at] = (float)(covers / (double)samples);
}

/* Sets the cells of the slices of a part. */
static void set_cells(cvol_context *context, cvol_coarse *out, const part *p, int number)
{
    const size_t *n = out->dims, pitch = (size_t)1 << number;
    const size_t first = p->first / pitch, end = (p->end + pitch - 1) / pitch;
#pragma omp parallel for num_threads(cvol_context_threads(context)) schedule(static)
    for (size_t i = 0; i < n[1] * (end - first); i++)
        for (size_t x = 0; x < n[0]; x++) {
            const size_t cell[3] = {x, i % n[1], first + i / n[1]};
            set_cell(out, p, cell, (size_t)1 << (number - p->number));
        }
}

int cvol_coarse_of_array_at(cvol_context *context, cvol_coarse *out, const cvol_array *array,
                            int number)
{
    const size_t slices = array->grid.dims[2], pitch = (size_t)1 << number;
    const size_t step = number <= LEVEL_MAX ? slices : pitch > PART_SLICES ? pitch : PART_SLICES;
    int code = cvol_coarse_allocate(context, out, &array->grid, number,
                                    cvol_mask_is_void(array->mask));
    out->offset = array->offset;
    for (size_t first = 0; first < slices && !code; first += step) {
        part p = {.number = number < LEVEL_MAX ? number : LEVEL_MAX,
                  .begin = first ? first - MARGIN : 0,
                  .first = first,
                  .end = slices - first < step ? slices : first + step};
        const size_t behind = slices - p.end < MARGIN ? slices : p.end + MARGIN;
        code = cvol_sheet_level_make_means(context, &p.level, array, p.number, p.begin, behind);
        if (!code)
            set_cells(context, out, &p, number);
        cvol_sheet_level_free(&p.level);
    }
    if (code)
        cvol_coarse_free(out);
    return code;
}

int cvol_coarse_of_array(cvol_context *context, cvol_coarse *out, const cvol_array *array)
{
    const cvol_array *decoded = array;
    int code = cvol_array_need_volume(context, array, "a view of its visible part");
    if (!code)
        code = cvol_array_decoded_terms(context, &decoded, array);
    return code ? code
                : cvol_coarse_of_array_at(context, out, decoded,
                                          cvol_coarse_level(cvol_array_grid(array)));
}
