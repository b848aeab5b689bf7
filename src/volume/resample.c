/* Samples of one volume at the places of another grid (cvol_volume_resample).
 *
 * With M = [direction spacing] and o the origin of a grid, index x has the place M x + o. So index
 * x of the new grid has the index
 *
 *     M_from^-1 (F (M_to x + o_to) - o_from)
 *
 * in the volume, where F exchanges LPS and RAS and the units of length. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/context.h"
#include "base/elementary.h"
#include "base/for_type.h"
#include "base/memory.h"
#include "volume/io/dense.h"
#include "volume/io/unit.h"

/* Samples of a coarser grid for each sample of the volume that it is made for, along an axis:
 * linear interpolation between fewer is visibly softer. */
#define FINER 2

/* From indices of the new grid to those of the volume: matrix[a][0 .. 2] and, [3], the offset. */
typedef struct mapping {
    double matrix[3][4];
} mapping;

/* ---- spaces ---- */

static int has_same_dims(const cvol_grid *a, const cvol_grid *b)
{
    return a->dims[0] == b->dims[0] && a->dims[1] == b->dims[1] && a->dims[2] == b->dims[2];
}

static double unit_ratio(const cvol_grid *from, const cvol_grid *to)
{
    const double a = cvol_unit_metres(from->unit), b = cvol_unit_metres(to->unit);
    return a > 0 && b > 0 ? b / a : 1;
}

/* The index of a grid as a place: out[i][a], and the origin in column 3. */
static void place_matrix(double out[3][4], const cvol_grid *grid)
{
    for (int i = 0; i < 3; i++) {
        for (int a = 0; a < 3; a++)
            out[i][a] = grid->direction[a][i] * grid->spacing[a];
        out[i][3] = grid->origin[i];
    }
}

/* The inverse of the left 3 x 3 part, by cofactors; 0 if it has none. */
static int invert(double out[3][3], double m[3][4])
{
    double cofactor[3][3], determinant = 0, size = 1;
    for (int i = 0; i < 3; i++)
        for (int k = 0; k < 3; k++) {
            const int a = (i + 1) % 3, b = (i + 2) % 3, c = (k + 1) % 3, d = (k + 2) % 3;
            cofactor[i][k] = m[a][c] * m[b][d] - m[a][d] * m[b][c];
        }
    for (int k = 0; k < 3; k++) {
        determinant += m[0][k] * cofactor[0][k];
        size *= cvol_hypot(cvol_hypot(m[0][k], m[1][k]), m[2][k]);
    }
    if (!(fabs(determinant) > 1e-9 * size))
        return 0;
    for (int i = 0; i < 3; i++)
        for (int k = 0; k < 3; k++)
            out[k][i] = cofactor[i][k] / determinant;
    return 1;
}

static int find_mapping(cvol_context *context, mapping *out, const cvol_grid *from,
                        const cvol_grid *to)
{
    const int has_space = from->space != CVOL_SPACE_UNKNOWN,
              needs_space = to->space != CVOL_SPACE_UNKNOWN;
    double back[3][4], there[3][4], inverse[3][3];
    if (has_space != needs_space || (!has_space && has_same_dims(from, to))) {
        if (!has_same_dims(from, to))
            return cvol_fail(context, CVOL_ERROR_ARGUMENT,
                             "the two grids have no common space: only one of them has an "
                             "orientation, and they have %zu x %zu x %zu and %zu x %zu x %zu "
                             "samples",
                             from->dims[0], from->dims[1], from->dims[2], to->dims[0], to->dims[1],
                             to->dims[2]);
        *out = (mapping){{{1, 0, 0, 0}, {0, 1, 0, 0}, {0, 0, 1, 0}}};
        return CVOL_OK;
    }
    place_matrix(back, from);
    place_matrix(there, to);
    if (!invert(inverse, back))
        return cvol_fail(context, CVOL_ERROR_ARGUMENT,
                         "the axes of a volume lie in a plane: its samples have no places");
    const double ratio = unit_ratio(from, to);
    for (int i = 0; i < 3; i++)
        for (int k = 0; k < 4; k++)
            there[i][k] = there[i][k] * (from->space != to->space && i < 2 ? -ratio : ratio) -
                          (k == 3 ? back[i][3] : 0);
    for (int a = 0; a < 3; a++)
        for (int k = 0; k < 4; k++) {
            out->matrix[a][k] = 0;
            for (int i = 0; i < 3; i++)
                out->matrix[a][k] += inverse[a][i] * there[i][k];
        }
    return CVOL_OK;
}

/* The box of `grid` keeps its size, from the first to the last sample of each axis. */
int cvol_grid_coarsen(cvol_context *context, cvol_grid *out, const cvol_grid *grid,
                      const cvol_grid *like)
{
    mapping map;
    *out = *grid;
    if (has_same_dims(grid, like))
        return CVOL_OK;
    const int code = find_mapping(context, &map, like, grid);
    for (int a = 0; a < 3 && !code; a++) {
        double most = 0;
        for (int i = 0; i < 3; i++)
            most = fmax(most, fabs(map.matrix[i][a]));
        const double last = (double)(grid->dims[a] - 1), count = ceil(FINER * most * last) + 1;
        if (!(count < (double)grid->dims[a]) || last < 1)
            continue;
        out->dims[a] = count > 2 ? (size_t)count : 2;
        out->spacing[a] = grid->spacing[a] * last / (double)(out->dims[a] - 1);
    }
    return code;
}

/* ---- samples ---- */

/* Samples reach half a sample beyond the first and the last; a little more, for rounding. */
#define REACH 0.500001

/* The place of sample (x, y, z) of the new grid in the volume, within its samples; 0: outside. */
static int find_place(double place[3], const mapping *map, const size_t dims[3], size_t x, size_t y,
                      size_t z)
{
    for (int a = 0; a < 3; a++) {
        const double *m = map->matrix[a], last = (double)(dims[a] - 1);
        const double at = m[0] * (double)x + m[1] * (double)y + m[2] * (double)z + m[3];
        if (!(at >= -REACH && at <= last + REACH))
            return 0;
        place[a] = fmin(fmax(at, 0), last);
    }
    return 1;
}

/* The samples of a volume as floats, for linear interpolation; the caller frees them. NULL: no
 * memory. */
static float *load_floats(const cvol_volume *volume)
{
    const size_t count = cvol_grid_samples(&volume->grid);
    float *out = cvol_allocate(count, sizeof *out);
    if (!out)
        return NULL;
#define LOAD(t)                        \
    for (size_t i = 0; i < count; i++) \
    out[i] = (float)((const t *)volume->data)[i]
    CVOL_FOR_TYPE(volume->grid.type, LOAD);
#undef LOAD
    return out;
}

/* The eight samples around a place, with their weights for linear interpolation. */
typedef struct neighbours {
    size_t at[8];
    double weight[8];
} neighbours;

static void find_neighbours(neighbours *out, const size_t n[3], const double place[3])
{
    size_t step[3] = {1, n[0], n[0] * n[1]}, first = 0;
    double part[3];
    for (int a = 0; a < 3; a++) {
        const size_t low = (size_t)place[a];
        part[a] = place[a] - (double)low;
        first += low * step[a];
        if (low + 1 == n[a])
            step[a] = 0;
    }
    for (int k = 0; k < 8; k++) {
        out->weight[k] = (k & 1 ? part[0] : 1 - part[0]) * (k & 2 ? part[1] : 1 - part[1]) *
                         (k & 4 ? part[2] : 1 - part[2]);
        out->at[k] = first + (k & 1 ? step[0] : 0) + (k & 2 ? step[1] : 0) + (k & 4 ? step[2] : 0);
    }
}

/* The weighted mean of those that are numbers; NaN if they have less than half of the weight. */
static float mean_of(const float *samples, const neighbours *around)
{
    double sum = 0, weights = 0;
    for (int k = 0; k < 8; k++)
        sum += around->weight[k] * (double)samples[around->at[k]];
    if (isfinite(sum)) /* all are numbers, and their weights are 1 together */
        return (float)sum;
    sum = 0;
    for (int k = 0; k < 8; k++) {
        const float value = samples[around->at[k]];
        if (around->weight[k] > 0 && isfinite(value)) {
            sum += around->weight[k] * (double)value;
            weights += around->weight[k];
        }
    }
    return weights >= 0.5 ? (float)(sum / weights) : NAN;
}

/* The bytes of sample i. */
static uint64_t bits_of(const void *samples, size_t i, size_t size)
{
    return size == 1   ? ((const uint8_t *)samples)[i]
           : size == 2 ? ((const uint16_t *)samples)[i]
           : size == 4 ? ((const uint32_t *)samples)[i]
                       : ((const uint64_t *)samples)[i];
}

/* Copies the label that has the largest weight; of equal ones the first. */
static void copy_label(cvol_volume *out, size_t to, const cvol_volume *from,
                       const neighbours *around)
{
    const size_t size = cvol_type_size(from->grid.type);
    uint64_t labels[8], others = 0;
    int best = 0;
    for (int k = 0; k < 8; k++) {
        labels[k] = bits_of(from->data, around->at[k], size);
        others |= labels[k] ^ labels[0];
    }
    double most = 0;
    for (int k = 0; k < 8 && others; k++) {
        double weight = 0;
        for (int j = 0; j < 8; j++)
            weight += labels[j] == labels[k] ? around->weight[j] : 0;
        if (weight > most + 1e-9) {
            most = weight;
            best = k;
        }
    }
    memcpy((char *)out->data + to * size, (const char *)from->data + around->at[best] * size, size);
}

/* One slice; the number of samples inside the volume. floats: its samples; NULL: they are
 * labels. */
static uint64_t fill_slice(cvol_volume *out, const cvol_volume *from, const float *floats,
                           const mapping *map, size_t z)
{
    const size_t *n = out->grid.dims;
    uint64_t inside = 0;
    for (size_t y = 0; y < n[1]; y++)
        for (size_t x = 0; x < n[0]; x++) {
            const size_t i = x + n[0] * (y + n[1] * z);
            double place[3];
            neighbours around;
            if (find_place(place, map, from->grid.dims, x, y, z)) {
                find_neighbours(&around, from->grid.dims, place);
                if (floats)
                    ((float *)out->data)[i] = mean_of(floats, &around);
                else
                    copy_label(out, i, from, &around);
                inside++;
            } else if (floats)
                ((float *)out->data)[i] = NAN;
        }
    return inside;
}

int cvol_volume_resample(cvol_context *context, cvol_volume **out, uint64_t *inside,
                         const cvol_volume *from, const cvol_grid *grid, int labels)
{
    mapping map;
    cvol_grid to = *grid;
    uint64_t count = 0;
    *out = NULL;
    to.type = labels ? from->grid.type : CVOL_FLOAT32;
    to.value_scale = from->grid.value_scale;
    to.value_offset = from->grid.value_offset;
    int code = cvol_dense_check(context, from, "volume");
    if (!code)
        code = find_mapping(context, &map, &from->grid, grid);
    if (!code)
        code = cvol_volume_create(context, out, &to);
    float *floats = code || labels ? NULL : load_floats(from);
    if (!code && !labels && !floats) {
        cvol_volume_free(*out);
        *out = NULL;
        code = cvol_fail_memory(context, cvol_grid_samples(&from->grid) * sizeof *floats,
                                "resampling");
    }
    if (code)
        return code;
#pragma omp parallel for schedule(dynamic) num_threads(cvol_context_threads(context)) \
    reduction(+ : count)
    for (size_t z = 0; z < to.dims[2]; z++)
        count += fill_slice(*out, from, floats, &map, z);
    free(floats);
    if (inside)
        *inside = count;
    return CVOL_OK;
}
